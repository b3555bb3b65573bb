//! The tracer: what is done once a map and once a terminal.

use std::borrow::Cow;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

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
    /// What everything is computed in: the scene, moved by `-origin` where it lies far off.
    local: Cow<'s, Scene>,
    origin: DVec2,
    config: TraceConfig,
    wavelength_m: f64,
    /// The dynamic range as a ratio of amplitudes: 0 keeps everything.
    range: f64,
    /// By wall.
    reflectors: Vec<Reflector>,
    /// Empty without diffraction.
    corners: Corners,
    /// For each courtyard closed on all sides, whether one of the corners is there.
    courtyards_with_corners: Vec<bool>,
    /// Legs from each corner to the others; empty when no path has two diffractions.
    between: Vec<Legs>,
    graph: Option<CornerGraph>,
}

/// A transmitter, prepared: its images over the walls it lights and its waves at the corners.
#[derive(Debug, Clone)]
pub struct Transmitter {
    /// In the scene's coordinates, and in the tracer's own.
    pub(crate) position: DVec2,
    pub(crate) place: DVec2,
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
    /// In the scene's coordinates, and in the tracer's own.
    position: DVec2,
    pub(crate) place: DVec2,
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
    /// [`ConfigError`] for a setting outside its range, when the images of a corner exceed
    /// `max_images`, or what is kept for all corners `max_wave_bytes`.
    pub fn new(scene: &'s Scene, config: TraceConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let origin = scene.origin();
        let local = if origin == DVec2::ZERO {
            Cow::Borrowed(scene)
        } else {
            Cow::Owned(scene.moved(-origin))
        };
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
            Corners::new(&local, &reflectors, wavenumber_per_m, with_sights)
        } else {
            Corners::default()
        };
        let points = corners.wedges.iter().map(|wedge| wedge.point);
        let mut tracer = Self {
            scene,
            courtyards_with_corners: local.courtyards_with(points),
            local,
            origin,
            wavelength_m,
            range: config
                .dynamic_range_db
                .map_or(0.0, |db| 10.0_f64.powf(-db / 20.0)),
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
            let limit = tracer.config.max_wave_bytes;
            tracer.graph = Some(CornerGraph::new(&tracer.local, &tracer.corners, limit)?);
        }
        Ok(tracer)
    }

    fn legs_between_corners(&self) -> Result<Vec<Legs>, ConfigError> {
        let limit = self.config.max_wave_bytes;
        let too_many = || ConfigError::TooManyWaves {
            what: "waves between corners",
            setting: "max_reflections or max_diffractions",
            limit,
        };
        let bytes = AtomicUsize::new(0);
        self.corners
            .wedges
            .par_iter()
            .map(|wedge| {
                let images = self.images(wedge.point).map_err(ConfigError::Corner)?;
                let legs = self.legs(wedge.point, &images).ok_or_else(too_many)?;
                let before = bytes.fetch_add(legs.bytes(), Ordering::Relaxed);
                if before + legs.bytes() > limit {
                    return Err(too_many());
                }
                Ok(legs)
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
    /// [`TerminalError`] where no terminal can stand, or when its images exceed `max_images` or its
    /// waves at corners `max_wave_bytes`.
    pub fn transmitter(&self, position: DVec2) -> Result<Transmitter, TerminalError> {
        self.scene.check_terminal(position)?;
        let given = position;
        let position = given - self.origin;
        let courtyard = self.scene.courtyard_of(given);
        let images = self.images(position)?;
        let too_many = || TerminalError::TooManyWaves {
            position: given,
            limit: self.config.max_wave_bytes,
        };
        let legs = if self.may_reach_corners(courtyard) {
            self.legs(position, &images).ok_or_else(too_many)?
        } else {
            Legs::default()
        };
        let limits = self.config.limits();
        let fronts = Fronts::extend(&self.corners, &legs, &self.between, &limits);
        Ok(Transmitter {
            position: given,
            place: position,
            courtyard,
            fronts: fronts.ok_or_else(too_many)?,
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
        let given = position;
        let position = given - self.origin;
        let sights = if self.config.reflection_limit() == 0 {
            Vec::new()
        } else {
            sights(&self.local, position, &mut TreeScratch::default(), |_| {
                false
            })
        };
        let courtyard = self.scene.courtyard_of(given);
        // Legs need the receiver's own images; without corners nobody asks for them.
        let legs = if self.may_reach_corners(courtyard) {
            let legs = self.legs(position, &self.images(position)?);
            legs.ok_or(TerminalError::TooManyWaves {
                position: given,
                limit: self.config.max_wave_bytes,
            })?
        } else {
            Legs::default()
        };
        Ok(Receiver {
            position: given,
            place: position,
            courtyard,
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

    /// Whether anything at all could bend between a terminal and others in its courtyard.
    fn may_reach_corners(&self, courtyard: Option<usize>) -> bool {
        match courtyard {
            Some(courtyard) => self.courtyards_with_corners[courtyard],
            None => !self.corners.wedges.is_empty(),
        }
    }

    fn images(&self, from: DVec2) -> Result<ImageTree, TerminalError> {
        ImageTree::build(
            &self.local,
            from,
            self.config.reflection_limit(),
            self.config.max_images,
            &mut TreeScratch::default(),
        )
        .map_err(|error| error.moved(self.origin))
    }

    fn legs(&self, from: DVec2, images: &ImageTree) -> Option<Legs> {
        let max_reflections = self.config.reflection_limit();
        let (scene, corners) = (&self.local, &self.corners);
        Legs::find(
            scene,
            &self.reflectors,
            corners,
            from,
            images,
            max_reflections,
            self.config.max_wave_bytes,
        )
    }

    /// The scene in the tracer's own coordinates.
    pub(crate) fn local(&self) -> &Scene {
        &self.local
    }

    /// Where their zero is \[m\].
    pub(crate) fn origin(&self) -> DVec2 {
        self.origin
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
        self.range
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
