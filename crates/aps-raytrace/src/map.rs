//! The map: the work done once for all terminals.

use std::borrow::Cow;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec2;

use crate::between::Between;
use crate::config::TraceConfig;
use crate::corner_graph::CornerGraph;
use crate::error::{ConfigError, TerminalError};
use crate::friis::Friis;
use crate::images::{ImageTree, Visibility};
use crate::legs::{Corners, Legs};
use crate::material::Reflector;
use crate::scene::Scene;
use crate::wedge::Wedge;

/// A scene prepared for one configuration.
#[derive(Debug, Clone)]
pub(crate) struct Map<'s> {
    /// Number of the map in this process, by which its terminals are known.
    pub number: u64,
    /// The scene as it was given.
    pub scene: Cow<'s, Scene>,
    /// Scene in which everything is computed, where that is another: moved by `-origin` where it lies far off.
    moved: Option<Scene>,
    /// Position of zero in the given scene's coordinates \[m\].
    pub origin: DVec2,
    pub config: TraceConfig,
    pub friis: Friis,
    /// The dynamic range as a ratio of amplitudes: 0 keeps everything.
    pub range: f64,
    /// By wall.
    pub reflectors: Vec<Reflector>,
    /// Empty without diffraction.
    pub corners: Corners,
    /// For each courtyard closed on all sides, whether one of the corners is there.
    courtyards_with_corners: Vec<bool>,
    /// None when no path has two diffractions.
    pub between: Option<Between>,
    /// None when no link goes on beyond the limits.
    pub graph: Option<CornerGraph>,
}

impl<'s> Map<'s> {
    pub fn new(scene: Cow<'s, Scene>, config: TraceConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let (moved, origin) = scene.near_zero();
        let local = moved.as_ref().unwrap_or(&scene);
        let wavelength_m = config.wavelength_m();
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
        let diffractions = config.diffraction_limit();
        let corners = if diffractions > 0 || config.has_fallback() {
            let with_visible_walls = config.reflection_limit() > 0;
            let limit = config.max_wave_bytes;
            let corners = Corners::new(
                local,
                &reflectors,
                wavenumber_per_m,
                with_visible_walls,
                limit,
            );
            corners.ok_or(ConfigError::TooManyWaves {
                what: "walls that corners see",
                setting: "max_reflections to 0",
                limit,
            })?
        } else {
            Corners::default()
        };
        let points = corners.wedges.iter().map(|wedge| wedge.point);
        static MAPS: AtomicU64 = AtomicU64::new(0);
        let mut map = Self {
            number: MAPS.fetch_add(1, Ordering::Relaxed),
            courtyards_with_corners: local.courtyards_with(points),
            scene,
            moved,
            origin,
            friis: Friis { wavelength_m },
            range: config
                .dynamic_range_db
                .map_or(0.0, |db| 10.0_f64.powf(-db / 20.0)),
            reflectors,
            corners,
            between: None,
            graph: None,
            config,
        };
        if diffractions > 1 {
            map.between = Some(map.legs_between_corners()?);
        }
        if map.config.has_fallback() {
            let limit = map.config.max_wave_bytes;
            map.graph = Some(CornerGraph::new(map.local(), &map.corners, limit)?);
        }
        Ok(map)
    }

    /// The scene in which everything is computed.
    pub fn local(&self) -> &Scene {
        self.moved.as_ref().unwrap_or(&self.scene)
    }

    fn legs_between_corners(&self) -> Result<Between, ConfigError> {
        let limit = self.config.max_wave_bytes;
        let slopes = self.config.slope_diffraction.then_some(self.friis);
        let between = Between::find(&self.corners, slopes, limit, |corner| {
            let wedge = &self.corners.wedges[corner];
            let mut visibility = Visibility::from(self.local(), wedge.point);
            let images = self.images(&mut visibility);
            let images = images.map_err(ConfigError::Corner)?;
            Ok(self.legs(Some(wedge), &visibility, &images))
        })?;
        between.ok_or(ConfigError::TooManyWaves {
            what: "waves between corners",
            setting: "max_reflections or max_diffractions",
            limit,
        })
    }

    /// Returns true when a corner can diffract between a terminal and others in its courtyard.
    pub fn may_reach_corners(&self, courtyard: Option<usize>) -> bool {
        match courtyard {
            Some(courtyard) => self.courtyards_with_corners[courtyard],
            None => !self.corners.wedges.is_empty(),
        }
    }

    /// Builds the images of a point from what is seen there.
    pub fn images(&self, visibility: &mut Visibility) -> Result<ImageTree, TerminalError> {
        let from = visibility.from;
        let (max_order, limit) = (self.config.reflection_limit(), self.config.max_images);
        let too_many = |order| TerminalError::TooManyImages {
            position: from + self.origin,
            order,
            limit,
        };
        ImageTree::build(self.local(), max_order, limit, visibility).map_err(too_many)
    }

    /// Finds the legs of a point from what is seen there and its images; `own` is the corner that it is, if it is one. `None` if they take
    /// more memory than allowed.
    pub fn legs(
        &self,
        own: Option<&Wedge>,
        visibility: &Visibility,
        images: &ImageTree,
    ) -> Option<Legs> {
        Legs::find(
            self.local(),
            &self.reflectors,
            &self.corners,
            own,
            visibility,
            images,
            self.config.max_wave_bytes,
        )
    }
}
