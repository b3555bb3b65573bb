//! The map: the work done once for all terminals.

use std::borrow::Cow;

use crate::between::Between;
use crate::config::TraceConfig;
use crate::corner_graph::CornerGraph;
use crate::error::{ConfigError, TerminalError};
use crate::friis::Friis;
use crate::images::{ImageTree, Visibility};
use crate::legs::{Corners, Legs};
use crate::local_scene::LocalScene;
use crate::material::Reflector;
use crate::scene::Scene;
use crate::wedge::Wedge;

/// A scene prepared for one configuration.
#[derive(Debug, Clone)]
pub(crate) struct Map<'s> {
    pub scene: LocalScene<'s>,
    pub config: TraceConfig,
    pub friis: Friis,
    /// The dynamic range as a ratio of amplitudes: 0 keeps everything.
    pub range: f64,
    /// Reflection coefficients, one a wall.
    pub reflectors: Vec<Reflector>,
    /// Corners that diffract; none without diffraction.
    pub corners: Corners,
    /// True for each courtyard, closed on all sides, that holds one of the corners.
    courtyards_with_corners: Vec<bool>,
    /// Legs between corners; absent if no path has two diffractions.
    pub between: Option<Between>,
    /// Corner graph; absent without fallback.
    pub graph: Option<CornerGraph>,
}

impl<'s> Map<'s> {
    pub fn new(scene: Cow<'s, Scene>, config: TraceConfig) -> Result<Self, ConfigError> {
        config.validate()?;
        let scene = LocalScene::new(scene);
        let local = scene.local();
        let wavelength_m = config.wavelength_m();
        let wavenumber_per_m = std::f64::consts::TAU / wavelength_m;
        let reflectors: Vec<Reflector> = local
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
        let mut map = Self {
            courtyards_with_corners: local.courtyards_with(points),
            scene,
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
            map.graph = Some(CornerGraph::new(map.scene.local(), &map.corners, limit)?);
        }
        Ok(map)
    }

    fn legs_between_corners(&self) -> Result<Between, ConfigError> {
        let limit = self.config.max_wave_bytes;
        let slopes = self.config.slope_diffraction.then_some(self.friis);
        let between = Between::find(&self.corners, slopes, limit, |corner| {
            let wedge = &self.corners.wedges[corner];
            let mut visibility = Visibility::from(self.scene.local(), wedge.point);
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
            position: from + self.scene.origin,
            order,
            limit,
        };
        ImageTree::build(self.scene.local(), max_order, limit, visibility).map_err(too_many)
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
            self.scene.local(),
            &self.reflectors,
            &self.corners,
            own,
            visibility,
            images,
            self.config.max_wave_bytes,
        )
    }
}
