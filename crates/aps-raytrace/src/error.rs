//! Errors in the input of callers.

use glam::DVec2;
use thiserror::Error;

use crate::ranges::{FREQUENCY_HZ, MAX_CONDUCTIVITY_S_PER_M, MAX_PERMITTIVITY};

/// Footprints that no repair can make sense of. Buildings, rings and vertices count from 0.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The text is not JSON.
    #[error("footprints are not valid JSON: {reason}")]
    Syntax {
        /// The parser's words, with line and column.
        reason: String,
    },
    /// JSON of another shape than a list of polygons of `[x, y]` pairs.
    #[error(
        "{place}: expected {expected}; footprints are a list of polygons, each a list of [x, y] in metres"
    )]
    Shape {
        /// Place of the fault: building and vertex, as far as known.
        place: String,
        /// Description of the JSON that should stand there.
        expected: &'static str,
    },
    /// A coordinate that is NaN, infinite or beyond 1e9 m.
    #[error(
        "building {building}, ring {ring}, vertex {vertex}: coordinate ({x}, {y}) is not a finite position within 1e9 m"
    )]
    Coordinate {
        /// Building index.
        building: usize,
        /// Ring index: 0 outer, then holes.
        ring: usize,
        /// Vertex index.
        vertex: usize,
        /// x \[m\].
        x: f64,
        /// y \[m\].
        y: f64,
    },
    /// A ring with fewer than three distinct vertices.
    #[error(
        "building {building}, ring {ring}, vertex {vertex}: the ring ends with only {distinct} distinct vertices; a footprint needs at least 3 (remove the building or complete it)"
    )]
    TooFewVertices {
        /// Building index.
        building: usize,
        /// Ring index: 0 outer, then holes.
        ring: usize,
        /// Last vertex of the ring.
        vertex: usize,
        /// Distinct vertices found.
        distinct: usize,
    },
    /// A material with impossible values.
    #[error("building {building}: its material has impossible values")]
    Material {
        /// Building index.
        building: usize,
        /// Fault of the material.
        source: ConfigError,
    },
    /// A width of gaps to close that is negative, not finite or that of a street.
    #[error("gaps of {width_m} m cannot be closed: the width must be 0 to 20 m")]
    CloseGaps {
        /// The width asked for \[m\].
        width_m: f64,
    },
    /// An area whose corners are not finite or not ordered.
    #[error("area from {min} to {max} is empty or not finite")]
    Area {
        /// Lower left corner \[m\].
        min: DVec2,
        /// Upper right corner \[m\].
        max: DVec2,
    },
}

/// A setting outside its range.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// Carrier frequency outside its range.
    #[error(
        "carrier frequency {0} Hz must be between {min:e} and {max:e} Hz",
        min = FREQUENCY_HZ.start(),
        max = FREQUENCY_HZ.end()
    )]
    Frequency(f64),
    /// Material values out of range.
    #[error(
        "relative permittivity {relative_permittivity} must be between 1 and {eps:e}, conductivity {conductivity_s_per_m} S/m between 0 and {sigma:e}",
        eps = MAX_PERMITTIVITY,
        sigma = MAX_CONDUCTIVITY_S_PER_M
    )]
    Material {
        /// Real relative permittivity.
        relative_permittivity: f64,
        /// Conductivity \[S/m\].
        conductivity_s_per_m: f64,
    },
    /// Text that names no material.
    #[error("'{0}' is none of concrete, pec, EPS,SIGMA")]
    UnknownMaterial(String),
    /// An interaction limit beyond the number that records hold.
    #[error("{name} = {value} is above the limit of {limit}")]
    TooManyInteractions {
        /// The setting.
        name: &'static str,
        /// The value asked for.
        value: usize,
        /// The largest value supported.
        limit: usize,
    },
    /// Dynamic range not finite or negative.
    #[error("dynamic range {0} dB must be finite and not negative")]
    DynamicRange(f64),
    /// The images of a corner exceed the limit.
    #[error("a corner cannot be a source of diffracted waves")]
    Corner(#[source] TerminalError),
    /// Data kept for all corners would grow beyond the limit.
    #[error(
        "{what} take more than {limit} bytes; lower {setting}, simplify round buildings or raise max_wave_bytes"
    )]
    TooManyWaves {
        /// Name of the data.
        what: &'static str,
        /// The setting that multiplies their size, with the value that does without them where others hardly help.
        setting: &'static str,
        /// The limit \[bytes\].
        limit: usize,
    },
    /// A synthetic city that cannot be laid out.
    #[error("synthetic city: {0}")]
    City(String),
}

/// A place where no terminal can stand.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum TerminalError {
    /// A coordinate that is NaN, infinite or beyond 1e9 m.
    #[error("terminal at ({0}, {1}) is not at a finite position within 1e9 m")]
    NotFinite(f64, f64),
    /// Strictly inside a building.
    #[error("terminal at {position} is inside building {building}; move it outdoors")]
    InsideBuilding {
        /// Position \[m\].
        position: DVec2,
        /// Index of the building among the footprints given.
        building: usize,
    },
    /// Exactly on a wall: outdoor means strictly outside.
    #[error("terminal at {position} is on wall {wall}; move it off the facade")]
    OnWall {
        /// Position \[m\].
        position: DVec2,
        /// The wall.
        wall: u32,
    },
    /// The image tree would grow beyond the limit.
    #[error(
        "terminal at {position} has more than {limit} images at reflection order {order}; lower max_reflections or raise max_images"
    )]
    TooManyImages {
        /// Position \[m\].
        position: DVec2,
        /// The order at which the limit was met.
        order: usize,
        /// The limit.
        limit: usize,
    },
    /// The waves at corners, or the candidates for them, would grow beyond the limit.
    #[error(
        "terminal at {position} needs more than {limit} bytes for its waves at corners; lower max_diffractions or max_reflections or raise max_wave_bytes"
    )]
    TooManyWaves {
        /// Position \[m\].
        position: DVec2,
        /// The limit \[bytes\].
        limit: usize,
    },
    /// Outside the scene's area.
    #[error("terminal at {position} is outside the area from {min} to {max}")]
    OutsideArea {
        /// Position \[m\].
        position: DVec2,
        /// Lower left corner of the area \[m\].
        min: DVec2,
        /// Upper right corner of the area \[m\].
        max: DVec2,
    },
}

/// Reason to refuse a link.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum TraceError {
    /// The transmitter cannot stand where it is.
    #[error("the transmitter cannot be used")]
    Transmitter(#[source] TerminalError),
    /// The receiver cannot stand where it is.
    #[error("the receiver cannot be used")]
    Receiver(#[source] TerminalError),
    /// The chains of corners for links without a path would grow beyond the limit.
    #[error(
        "chains of up to {diffractions} corners from {position} take more than {limit} bytes; lower max_fallback_diffractions or raise max_wave_bytes"
    )]
    TooManyChains {
        /// The transmitter \[m\].
        position: DVec2,
        /// Corners of the longest chain.
        diffractions: usize,
        /// The limit \[bytes\].
        limit: usize,
    },
    /// Both terminals at one point, or nearer than 1e-100 m: the gain of a path of length zero is
    /// not defined.
    #[error("transmitter and receiver are both at {position}; a link needs two places")]
    Coincident {
        /// Position \[m\].
        position: DVec2,
    },
    /// A terminal that another tracer prepared.
    #[error(
        "the {terminal} was prepared by another tracer; prepare it by the one that traces the link"
    )]
    Foreign {
        /// The terminal.
        terminal: &'static str,
    },
}
