//! Tests through the crate's public face, one file a theme.

/// Bytes from anywhere as GeoJSON.
mod fuzz;
/// Messages and settings of the public types.
mod messages;
