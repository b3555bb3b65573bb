//! Geometric fields of a scene: what a model may look at without any path being searched or any field strength computed.
//!
//! - Once a map: [`FieldMap`].
//! - Once a transmitter, for all its receivers: [`FieldMap::transmitter`]. On a grid of pixels: where it is in sight, the length
//!   of the shortest way around the buildings, where one and two specular reflections light, and over which length.
//! - Once a receiver: [`FieldMap::receiver`]. Where a fan of rays is at given unfolded ranges, going on behind each wall along
//!   the reflected ray.
//! - For each link: [`gather()`]. The transmitter's fields at the positions of the receiver's rays, twelve planes over range and
//!   direction, and four numbers a direction ([`FieldLink`]). Nothing of this need be stored: it costs less than reading it.
//!
//! ```
//! use aps_raytrace::fields::{FieldConfig, FieldLink, FieldMap, Mirror, NUMBERS, PLANES, gather};
//! use aps_raytrace::{Scene, glam::DVec2};
//!
//! let scene = Scene::from_radiomapseer("[[[40, 40], [60, 40], [60, 60], [40, 60]]]")?;
//! let map = FieldMap::new(&scene, FieldConfig::default())?;
//! let transmitter = map.transmitter(DVec2::new(20.0, 70.0))?;
//! let receiver = map.receiver(DVec2::new(70.0, 30.0))?;
//! let link = FieldLink { map: &map, transmitter: &transmitter, receiver: &receiver, mirror: Mirror::default() };
//! // Over the house's lower left corner, or its upper right one: the same here.
//! assert!((link.geodesic_m() - (DVec2::new(20.0, 30.0).length() + DVec2::new(30.0, 10.0).length())).abs() < 1e-9);
//! let mut planes = vec![0.0; PLANES * map.fan().positions()];
//! let mut numbers = vec![0.0; NUMBERS * map.fan().directions];
//! gather(&[link], &mut planes, &mut numbers)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Exactness
//!
//! Lit regions are polygons between exact rays, painted onto the pixels whose centre they hold. Centres within 1e-9 pixels of
//! the edge of a region may fall to either side. Lengths are computed in f64 and handed out in f32.

mod canvas;
mod corners;
mod error;
mod fan;
mod grid;
mod link;
mod map;
mod mirror;
mod receiver;
mod transmitter;
mod view;

pub use error::FieldError;
pub use fan::Fan;
pub use grid::FieldGrid;
pub use link::{FEATURES, FieldLink, NUMBERS, gather, rows};
pub use map::{FieldConfig, FieldMap};
pub use mirror::Mirror;
pub use receiver::ReceiverRays;
pub use transmitter::{FIELDS, TransmitterFields};
