//! Tests through the crate's public face, one file a theme.

/// Damaged and foreign files: every fault is found and named.
mod damage;
/// Bytes from anywhere: no panic, no memory for sizes that are only claimed.
mod fuzz;
/// Values computed by NumPy and Pillow.
mod golden;
/// Messages of errors.
mod messages;
/// Our arrays against an independent reader and writer of the same format.
mod npy;
/// The formats of the published data.
mod released;
/// Interrupted, repeated, shared and refused runs.
mod resume;
/// Reads the data that were written.
mod round_trip;
/// A small data set with every kind of array.
mod sample;
/// The written specification against what is written.
mod spec;
