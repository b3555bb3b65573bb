//! Limits that keep an answer within seconds on the largest maps.

/// Most reflections on a path.
pub const REFLECTIONS: usize = 6;

/// Most diffractions on a path.
pub const DIFFRACTIONS: usize = 3;

/// Most elements of an array.
pub const ELEMENTS: usize = 256;

/// Most images of a terminal.
pub const MAX_IMAGES: usize = 2_000_000;

/// Most memory for the waves of a transmitter \[bytes\].
pub const MAX_WAVE_BYTES: usize = 256 << 20;

/// Largest dynamic range of paths with more diffractions than two \[dB\]: without one, a link can have hundreds of thousands.
pub const MANY_DIFFRACTIONS_RANGE_DB: f64 = 60.0;

/// Vertices of all drawn houses together: a wall more is a corner more for every other corner to be seen from.
pub const MAX_VERTICES: usize = 1000;
