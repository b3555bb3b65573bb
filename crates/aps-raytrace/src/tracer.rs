//! The tracer: the face of all stages.

use std::borrow::Cow;

use glam::DVec2;

use crate::config::TraceConfig;
use crate::error::{ConfigError, TerminalError, TraceError};
use crate::join;
use crate::link::Link;
use crate::map::Map;
use crate::scene::Scene;
use crate::terminal::{Receiver, Transmitter};

/// Traces links in one scene.
///
/// ```
/// use aps_raytrace::{Footprint, Scene, TraceConfig, Tracer, glam::DVec2};
/// let house = [(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)].map(DVec2::from);
/// let scene = Scene::new(&[Footprint::new(house)], None)?;
/// let tracer = Tracer::new(&scene, TraceConfig::default())?;
/// let tx = tracer.transmitter(DVec2::new(-5.0, 15.0))?;
/// let rx = tracer.receiver(DVec2::new(25.0, 15.0))?;
/// let mut link = Default::default();
/// tracer.link(&tx, &rx, &mut link)?;
/// // Line of sight, a reflection on the roof-side wall, two diffractions at its corners.
/// assert_eq!(link.paths.len(), 4);
/// assert_eq!(link.paths[0].length_m, 30.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Tracer<'s> {
    map: Map<'s>,
}

impl<'s> Tracer<'s> {
    /// Prepares a scene for one configuration: work done once a map.
    ///
    /// # Errors
    /// [`ConfigError`] for a setting outside its range, when the images of a corner exceed
    /// `max_images`, or what is kept for all corners `max_wave_bytes`.
    pub fn new(scene: &'s Scene, config: TraceConfig) -> Result<Self, ConfigError> {
        let map = Map::new(Cow::Borrowed(scene), config)?;
        Ok(Self { map })
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.map.scene.given
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &TraceConfig {
        &self.map.config
    }

    /// Number of corners that can diffract; none are set up when the limits allow no diffraction.
    #[must_use]
    pub fn corner_count(&self) -> usize {
        self.map.corners.wedges.len()
    }

    /// Prepares a transmitter: work done once for all its links.
    ///
    /// # Errors
    /// [`TerminalError`] where no terminal can stand, or when its images exceed `max_images` or its
    /// waves at corners `max_wave_bytes`.
    pub fn transmitter(&self, position: DVec2) -> Result<Transmitter, TerminalError> {
        self.scene().check_terminal(position)?;
        Transmitter::new(&self.map, position, self.scene().courtyard_of(position))
    }

    /// Prepares a receiver: work done once for all its links.
    ///
    /// # Errors
    /// As [`Self::transmitter`].
    pub fn receiver(&self, position: DVec2) -> Result<Receiver, TerminalError> {
        self.scene().check_terminal(position)?;
        Receiver::new(&self.map, position, self.scene().courtyard_of(position))
    }

    /// Finds all paths of a link within the limits.
    ///
    /// No path is an empty list, not an error. Costs some microseconds in a city district at the
    /// default limits; a tenth less with [`Link::without_interactions`], where only lengths, azimuths and gains are of use. Links of
    /// neighbouring receivers one after the other take an eighth less time than in any order: they read the same waves.
    ///
    /// # Errors
    /// [`TraceError::Foreign`] for a terminal of another tracer that is no copy of this one, [`TraceError::Coincident`] when
    /// both terminals are at one point,
    /// [`TraceError::TooManyChains`] when what a link without a path needs exceeds `max_wave_bytes`.
    pub fn link(&self, tx: &Transmitter, rx: &Receiver, link: &mut Link) -> Result<(), TraceError> {
        join::trace(&self.map, tx, rx, link)
    }

    /// Finds all paths between two points.
    ///
    /// ```
    /// use aps_raytrace::{Scene, TraceConfig, Tracer, glam::DVec2};
    ///
    /// let scene = Scene::from_radiomapseer("[[[40, 40], [60, 40], [60, 60], [40, 60]]]")?;
    /// let tracer = Tracer::new(&scene, TraceConfig::default())?;
    /// let (tx, rx) = (DVec2::new(20.0, 70.0), DVec2::new(70.0, 30.0));
    /// let (there, back) = (tracer.trace(tx, rx)?, tracer.trace(rx, tx)?);
    /// assert_eq!(there.paths.len(), back.paths.len()); // waves go both ways
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// Prepares both ends for this one link; for many links prepare
    /// each terminal once and use [`Self::link`].
    ///
    /// # Errors
    /// [`TraceError`] when an end cannot stand where it is, or both are at one point.
    pub fn trace(&self, tx: DVec2, rx: DVec2) -> Result<Link, TraceError> {
        let tx = self.transmitter(tx).map_err(TraceError::Transmitter)?;
        let rx = self.receiver(rx).map_err(TraceError::Receiver)?;
        let mut link = Link::default();
        self.link(&tx, &rx, &mut link)?;
        Ok(link)
    }
}

impl Tracer<'static> {
    /// Prepares a tracer that owns its scene.
    ///
    /// # Errors
    /// As [`Tracer::new`].
    pub fn owning(scene: Scene, config: TraceConfig) -> Result<Self, ConfigError> {
        let map = Map::new(Cow::Owned(scene), config)?;
        Ok(Self { map })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminals_of_another_tracer_are_refused() {
        let scene = Scene::new(&[], None).unwrap();
        let tracer = || Tracer::new(&scene, TraceConfig::default()).unwrap();
        let (own, other) = (tracer(), tracer());
        let (tx, rx) = (DVec2::ZERO, DVec2::new(30.0, 0.0));
        let of = |tracer: &Tracer<'_>| {
            (
                tracer.transmitter(tx).unwrap(),
                tracer.receiver(rx).unwrap(),
            )
        };
        let ((tx, rx), (other_tx, other_rx)) = (of(&own), of(&other));
        let link = |tx, rx| own.clone().link(tx, rx, &mut Link::default());
        assert_eq!(link(&tx, &rx), Ok(()));
        let refused = |terminal| Err(TraceError::Foreign { terminal });
        assert_eq!(link(&other_tx, &rx), refused("transmitter"));
        assert_eq!(link(&tx, &other_rx), refused("receiver"));
    }
}
