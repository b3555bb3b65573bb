//! The tracer: what is done once a map and once a terminal.

use std::sync::OnceLock;

use glam::DVec2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::config::TraceConfig;
use crate::corner_graph::CornerGraph;
use crate::error::{ConfigError, TerminalError, TraceError};
use crate::fallback::{Arrivals, Chains};
use crate::fronts::Fronts;
use crate::images::{ImageTree, Sight, TreeScratch, sights};
use crate::legs::{Corners, Legs};
use crate::link::Link;
use crate::material::{Reflector, SPEED_OF_LIGHT_M_PER_S};
use crate::scene::Scene;

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
    scene: &'s Scene,
    config: TraceConfig,
    wavelength_m: f64,
    /// By wall.
    reflectors: Vec<Reflector>,
    /// Empty without diffraction.
    corners: Corners,
    /// Legs from each corner to the others; empty when no path has two diffractions.
    between: Vec<Legs>,
    graph: Option<CornerGraph>,
}

/// A transmitter, prepared: its images over the walls it lights and its waves at the corners.
#[derive(Debug, Clone)]
pub struct Transmitter {
    pub(crate) position: DVec2,
    pub(crate) courtyard: Option<usize>,
    pub(crate) images: ImageTree,
    pub(crate) legs: Legs,
    pub(crate) fronts: Fronts,
    /// Made when the first link without a path asks.
    pub(crate) chains: OnceLock<Chains>,
}

/// A receiver, prepared: the walls it sees and its legs to the corners.
#[derive(Debug, Clone)]
pub struct Receiver {
    pub(crate) position: DVec2,
    pub(crate) courtyard: Option<usize>,
    pub(crate) sights: Vec<Sight>,
    pub(crate) legs: Legs,
    /// Made when the first link without a path asks.
    pub(crate) arrivals: OnceLock<Arrivals>,
}

impl Transmitter {
    /// Where it is \[m\].
    #[must_use]
    pub fn position(&self) -> DVec2 {
        self.position
    }

    /// How many images it has, over all orders.
    #[must_use]
    pub fn image_count(&self) -> usize {
        self.images.images.len()
    }

    /// How many of them light no further wall: branches left out for want of geometry.
    #[must_use]
    pub fn empty_beam_count(&self) -> usize {
        self.images.empty_beams
    }

    /// How many waves arrive at corners.
    #[must_use]
    pub fn front_count(&self) -> usize {
        self.fronts.len()
    }
}

impl Receiver {
    /// Where it is \[m\].
    #[must_use]
    pub fn position(&self) -> DVec2 {
        self.position
    }
}

impl<'s> Tracer<'s> {
    /// Prepares a scene for one configuration: work done once a map.
    ///
    /// # Errors
    /// [`ConfigError`] for a setting outside its range, or when the images of a corner exceed
    /// `max_images`.
    pub fn new(scene: &'s Scene, config: TraceConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let wavelength_m = SPEED_OF_LIGHT_M_PER_S / config.frequency_hz;
        let wavenumber_per_m = std::f64::consts::TAU / wavelength_m;
        let reflectors: Vec<Reflector> = scene
            .walls()
            .iter()
            .map(|w| {
                w.material
                    .unwrap_or(config.material)
                    .at(config.frequency_hz)
            })
            .collect();
        let may_diffract = config.max_diffractions.min(config.max_interactions) > 0;
        let corners = if may_diffract || config.has_fallback() {
            let with_sights = config.reflection_limit() > 0;
            Corners::new(scene, &reflectors, wavenumber_per_m, with_sights)
        } else {
            Corners::default()
        };
        let mut tracer = Self {
            scene,
            wavelength_m,
            reflectors,
            corners,
            between: Vec::new(),
            graph: None,
            config,
        };
        if tracer
            .config
            .max_diffractions
            .min(tracer.config.max_interactions)
            > 1
        {
            tracer.between = tracer.legs_between_corners()?;
        }
        if tracer.config.has_fallback() {
            tracer.graph = Some(CornerGraph::new(scene, &tracer.corners));
        }
        Ok(tracer)
    }

    fn legs_between_corners(&self) -> Result<Vec<Legs>, ConfigError> {
        self.corners
            .wedges
            .par_iter()
            .map(|wedge| {
                let images = self.images(wedge.point).map_err(ConfigError::Corner)?;
                Ok(self.legs(wedge.point, &images))
            })
            .collect()
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &TraceConfig {
        &self.config
    }

    /// How many corners can diffract; none are set up when the limits allow no diffraction.
    #[must_use]
    pub fn corner_count(&self) -> usize {
        self.corners.wedges.len()
    }

    /// Prepares a transmitter: work done once for all its links.
    ///
    /// # Errors
    /// [`TerminalError`] where no terminal can stand, or when its images exceed `max_images`.
    pub fn transmitter(&self, position: DVec2) -> Result<Transmitter, TerminalError> {
        self.scene.check_terminal(position)?;
        let images = self.images(position)?;
        let legs = self.legs(position, &images);
        let limits = self.config.limits();
        Ok(Transmitter {
            position,
            courtyard: self.scene.courtyard_of(position),
            fronts: Fronts::extend(&self.corners, &legs, &self.between, &limits),
            images,
            legs,
            chains: OnceLock::new(),
        })
    }

    /// Prepares a receiver: work done once for all its links.
    ///
    /// # Errors
    /// As [`Self::transmitter`].
    pub fn receiver(&self, position: DVec2) -> Result<Receiver, TerminalError> {
        self.scene.check_terminal(position)?;
        let sights = if self.config.reflection_limit() == 0 {
            Vec::new()
        } else {
            sights(self.scene, position, &mut TreeScratch::default(), |_| false)
        };
        // Legs need the receiver's own images; without corners nobody asks for them.
        let legs = if self.corners.wedges.is_empty() {
            Legs::default()
        } else {
            self.legs(position, &self.images(position)?)
        };
        Ok(Receiver {
            position,
            courtyard: self.scene.courtyard_of(position),
            sights,
            legs,
            arrivals: OnceLock::new(),
        })
    }

    /// All paths between two points.
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

    fn images(&self, from: DVec2) -> Result<ImageTree, TerminalError> {
        ImageTree::build(
            self.scene,
            from,
            self.config.reflection_limit(),
            self.config.max_images,
            &mut TreeScratch::default(),
        )
    }

    fn legs(&self, from: DVec2, images: &ImageTree) -> Legs {
        let max_reflections = self.config.reflection_limit();
        let (scene, corners) = (self.scene, &self.corners);
        Legs::find(
            scene,
            &self.reflectors,
            corners,
            from,
            images,
            max_reflections,
        )
    }

    pub(crate) fn reflectors(&self) -> &[Reflector] {
        &self.reflectors
    }

    pub(crate) fn corners(&self) -> &Corners {
        &self.corners
    }

    pub(crate) fn between(&self) -> &[Legs] {
        &self.between
    }

    pub(crate) fn graph(&self) -> Option<&CornerGraph> {
        self.graph.as_ref()
    }

    /// The dynamic range as a ratio of amplitudes: 0 keeps everything.
    pub(crate) fn range(&self) -> f64 {
        self.config
            .dynamic_range_db
            .map_or(0.0, |db| 10.0_f64.powf(-db / 20.0))
    }

    /// lambda / (4 pi L): the amplitude between isotropic antennas (Friis).
    pub(crate) fn friis_amplitude(&self, length_m: f64) -> f64 {
        self.wavelength_m / (4.0 * std::f64::consts::PI * length_m)
    }

    /// The same with the phase e^{-j k L}.
    pub(crate) fn friis(&self, length_m: f64) -> Complex64 {
        let cycles = length_m / self.wavelength_m;
        let phase = -std::f64::consts::TAU * cycles.fract();
        Complex64::from_polar(self.friis_amplitude(length_m), phase)
    }
}
