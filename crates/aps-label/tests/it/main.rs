//! Tests through the crate's public face, one file a theme.

/// The tolerance, and links to try.
mod common;
/// Values computed by NumPy and mpmath.
mod golden;
/// Inputs that are refused or have no label, and sharing between threads.
mod inputs;
/// Laws every label obeys.
mod laws;
