//! Radio propagation paths in a city seen from above.
//!
//! Give it building footprints, a transmitter and a receiver; it returns every path between them
//! that reflects at walls and diffracts at corners up to the limits you set, with length, delay,
//! departure and arrival azimuth and complex gain.
//!
//! Picture the plane cut through all buildings at the height of the terminals. A terminal sees some
//! walls; each wall turns it into an image behind the wall, which sees further walls through that
//! wall as through a window. The images form a tree. A receiver looks, for each wall it sees, which
//! images stand behind it: those are its reflected paths. Convex corners are seen in the same way,
//! from both ends; where a wave of the transmitter and the view of the receiver meet at a corner,
//! there is a diffracted path.
//!
//! ```
//! use aps_raytrace::{Scene, TraceConfig, Tracer, glam::DVec2};
//!
//! let map = "[[[40, 40], [60, 40], [60, 60], [40, 60], [40, 40]]]"; // one house
//! let scene = Scene::from_radiomapseer(map)?;
//! let tracer = Tracer::new(&scene, TraceConfig::default())?;
//! let link = tracer.trace(DVec2::new(20.0, 70.0), DVec2::new(70.0, 30.0))?;
//! // The house is in the way: paths bend around its corners.
//! assert!(link.paths.iter().all(|p| !p.is_line_of_sight()));
//! for path in &link.paths {
//!     println!("{:.1} ns, {:.1} dB", path.delay_s * 1e9, path.gain_db());
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Main types
//!
//! - [`Scene`]: footprints checked, repaired and united ([`scene`]); [`Scene::synthetic`] makes a
//!   city out of nothing.
//! - [`TraceConfig`]: carrier, material, limits.
//! - [`Tracer`]: [`Tracer::trace`] for one link; for many, [`Tracer::transmitter`] and
//!   [`Tracer::receiver`] prepare each terminal once and [`Tracer::link`] joins them in
//!   microseconds. All three may be shared by threads.
//! - [`Link`] with its [`PathRecord`]s.
//!
//! # Conventions
//!
//! Metres, seconds, radians; x to the right, y upwards, angles counter-clockwise from x in
//! (-pi, pi]. Arrival azimuths point from the receiver *towards* the last interaction. Time factor
//! e^{+j omega t}. Gains are between isotropic antennas, vertical polarisation, spherical spreading.
//!
//! # Why a path exists or not is decided exactly
//!
//! Maps have integer coordinates, and so have terminals: rays touch corners and run along walls all
//! the time. Rounding must not decide whether such a path exists, or links lose it in one direction
//! and keep it in the other. Signs come from exact predicates ([`predicates`]), after a reflection from a
//! formula that gives the same bits from both ends; corners have an owner (a wall owns its start, not its end), and diffraction takes the same side as the shadow boundary
//! it smooths.
//!
//! # Features
//!
//! None is on by default.
//!
//! - `geojson`: footprints from OpenStreetMap's exports (`scene::parse_geojson`).
//! - `serde`: `Serialize` and `Deserialize` for configurations, footprints and path records.
//!
//! # Limits
//!
//! Transmission through buildings, rooftops and the ground are not modelled.

#![forbid(unsafe_code)]

mod beam;
mod between;
mod bound;
mod chain;
mod chains;
mod config;
mod corner_graph;
pub mod error;
mod fallback;
mod friis;
mod front_counts;
mod fronts;
mod images;
mod join;
mod last_steps;
mod leg_ends;
mod legs;
mod limits;
mod link;
mod local_scene;
mod map;
mod material;
mod occlusion;
mod path;
pub mod polar;
pub mod predicates;
mod products;
mod ranges;
mod ray;
pub mod scene;
mod search;
mod slope;
mod strength;
mod terminal;
mod text;
mod tracer;
pub mod transition;
pub mod utd;
mod wall_index;
mod wedge;
pub use config::{MAX_INTERACTIONS, TraceConfig};
pub use error::{ConfigError, SceneError, TerminalError, TraceError};
pub use glam;
pub use link::{Link, Omitted};
pub use material::{
    Material, MaterialSource, Reflector, SPEED_OF_LIGHT_M_PER_S, VACUUM_PERMITTIVITY_F_PER_M,
};
pub use num_complex::Complex64;
pub use path::{Interaction, InteractionKind, Interactions, PathRecord};
pub use scene::{Area, Footprint, Scene, Wall};
pub use terminal::{Receiver, Transmitter};
pub use tracer::Tracer;

/// Threads can share all types.
const _: fn() = || {
    use polar::*;
    use scene::*;

    fn is_shared<T: Clone + Send + Sync + 'static>() {}
    fn is_error<T: std::error::Error + Clone + Send + Sync + 'static>() {}
    is_shared::<(Scene, Footprint, Area, Wall, CityConfig, Location, Repair)>();
    is_shared::<(RepairReport, RepairKind, Tiling, Tile, LocalPlane)>();
    is_shared::<(Material, MaterialSource, Reflector, TraceConfig)>();
    is_shared::<(Tracer<'static>, Transmitter, Receiver, Link, Omitted)>();
    is_shared::<(PathRecord, Interaction, InteractionKind, Interactions)>();
    is_shared::<(Fan, Mirror, PolarLink<'static>, PolarMap<'static>)>();
    is_shared::<(ReceiverRays, TransmitterWays)>();
    is_error::<SceneError>();
    is_error::<ConfigError>();
    is_error::<TerminalError>();
    is_error::<TraceError>();
    is_error::<TilingError>();
    is_error::<PolarError>();
    #[cfg(feature = "geojson")]
    is_shared::<(Coordinates, GeoJsonCity, GeoJsonConfig, Skipped)>();
    #[cfg(feature = "geojson")]
    is_error::<GeoJsonError>();
};
