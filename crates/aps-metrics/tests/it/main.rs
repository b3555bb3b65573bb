//! Tests through the crate's public face, one file a theme.

/// The cluster bootstrap.
mod bootstrap;
/// Scores, peaks and ranges of good input.
mod common;
/// Input that is empty, constant, negative, not finite or of the wrong shape.
mod edges;
/// Values computed by SciPy and NumPy.
mod golden;
/// Laws that hold for all spectra.
mod laws;
/// The worked example of docs/protocol.md.
mod swapped_twins;
