//! The city as a receiver sees it along rays: input of a model that predicts from where power arrives.
//!
//! - Once a map: [`PolarMap`], its corners and the shortest ways between them.
//! - Once a transmitter, for all its receivers: [`PolarMap::transmitter`]. Over which ways its waves reach each corner: straight,
//!   after one and after two specular reflections, and around other corners.
//! - Once a receiver: [`PolarMap::receiver`]. A fan of rays that go on behind each wall along the reflected ray, and the corners
//!   that each ray passes.
//! - For each link: [`PolarLink::ways`]. The ways that arrive along each ray, one of a kind, and their geometry: lengths, angles,
//!   cosines of incidence. None of this need be stored.
//!
//! No field strength, power, loss or delay is computed, and nothing is said of materials or the carrier. Paths are not searched
//! for: ways from the transmitter to corners are found by its images, and met along the rays of a fan, so that what lies
//! between two rays is missed, and of ways of one kind along one ray all but one are left out, by a power law of turns and
//! lengths. With the default fan 0 to 1 % of the paths of up to two reflections and one diffraction that no other way of their
//! kind hides are missed, and 0 to 2 % of the strongest of a link: seen through slits, or by small walls.
//!
//! ```
//! use aps_raytrace::polar::{Fan, PER_WAY, PolarLink, PolarMap};
//! use aps_raytrace::{Scene, glam::DVec2};
//!
//! let scene = Scene::from_radiomapseer("[[[40, 40], [60, 40], [60, 60], [40, 60]]]")?;
//! let map = PolarMap::new(&scene, Fan::default())?;
//! let transmitter = map.transmitter(DVec2::new(20.0, 70.0))?;
//! let receiver = map.receiver(DVec2::new(70.0, 30.0))?;
//! let link = PolarLink { map: &map, transmitter: &transmitter, receiver: &receiver };
//! // Over the house's lower left corner, or its upper right one: the same here.
//! assert!((link.geodesic_m()? - (DVec2::new(20.0, 30.0).length() + DVec2::new(30.0, 10.0).length())).abs() < 1e-9);
//! let mut ways = Vec::new();
//! link.ways(&mut ways)?;
//! // Over these corners, along the rays beside them.
//! assert!(!ways.is_empty() && ways.len().is_multiple_of(PER_WAY));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod corners;
mod error;
mod fan;
mod link;
mod map;
mod mirror;
mod rays;
#[cfg(test)]
mod tests;
mod view;
mod ways;

pub use error::PolarError;
pub use fan::{Fan, KINDS};
pub use link::{FEATURES, PER_WAY, PolarLink};
pub use map::PolarMap;
pub use mirror::Mirror;
pub use rays::ReceiverRays;
pub use ways::TransmitterWays;
