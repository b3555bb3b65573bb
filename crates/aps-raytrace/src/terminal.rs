//! Terminals: the work done once for all links of a transmitter or a receiver.

use std::sync::OnceLock;

use glam::DVec2;

use crate::chains::{Arrivals, Chains};
use crate::error::TerminalError;
use crate::fronts::{Fronts, Sources};
use crate::images::{ImageTree, Visibility, VisibleWall};
use crate::last_steps::LastSteps;
use crate::legs::Legs;
use crate::map::Map;

/// A transmitter, prepared: its images over the walls it lights and its waves at the corners.
#[derive(Debug, Clone)]
pub struct Transmitter {
    /// Identifier of the map that prepared it.
    pub(crate) map: u64,
    /// Position in the scene's coordinates \[m\].
    pub(crate) position: DVec2,
    /// Position in the local scene \[m\].
    pub(crate) place: DVec2,
    pub(crate) courtyard: Option<usize>,
    pub(crate) visibility: Visibility,
    pub(crate) images: ImageTree,
    pub(crate) legs: Legs,
    /// Direction in which each leg leaves \[rad\].
    pub(crate) azimuths_rad: Vec<f64>,
    pub(crate) fronts: Fronts,
    /// Chains from the first corners, made when the first link without a path asks.
    pub(crate) chains: OnceLock<Chains>,
}

/// A receiver, prepared: the walls it sees and its legs to the corners.
#[derive(Debug, Clone)]
pub struct Receiver {
    /// Identifier of the map that prepared it.
    pub(crate) map: u64,
    /// Position in the scene's coordinates \[m\].
    position: DVec2,
    /// Position in the local scene \[m\].
    pub(crate) place: DVec2,
    pub(crate) courtyard: Option<usize>,
    pub(crate) visible_walls: Vec<VisibleWall>,
    pub(crate) legs: Legs,
    /// Direction in which each leg leaves \[rad\].
    pub(crate) azimuths_rad: Vec<f64>,
    pub(crate) steps: LastSteps,
    /// Edges into the last corners, made when the first link without a path asks.
    pub(crate) arrivals: OnceLock<Arrivals>,
}

impl Transmitter {
    pub(crate) fn new(
        map: &Map<'_>,
        given: DVec2,
        courtyard: Option<usize>,
    ) -> Result<Self, TerminalError> {
        let place = given - map.scene.origin;
        let mut visibility = Visibility::from(map.scene.local(), place);
        let images = map.images(&mut visibility)?;
        let legs = legs(map, given, courtyard, &visibility, &images)?;
        let of = Sources {
            corners: &map.corners,
            between: map.between.as_ref(),
            legs: &legs,
        };
        let fronts = Fronts::extend(&of, &map.config.limits());
        Ok(Self {
            map: map.scene.id,
            position: given,
            place,
            courtyard,
            fronts: fronts.ok_or_else(|| too_many(map, given))?,
            visibility,
            images,
            azimuths_rad: legs.azimuths_rad(&map.corners, place),
            legs,
            chains: OnceLock::new(),
        })
    }

    /// Position of the transmitter \[m\].
    #[must_use]
    pub fn position(&self) -> DVec2 {
        self.position
    }

    /// Number of images, over all orders.
    #[must_use]
    pub fn image_count(&self) -> usize {
        self.images.images.len()
    }

    /// Number of images that light no further wall: branches left out for want of geometry.
    #[must_use]
    pub fn empty_beam_count(&self) -> usize {
        self.images.empty_beams
    }

    /// Number of waves that arrive at corners.
    #[must_use]
    pub fn front_count(&self) -> usize {
        self.fronts.len()
    }
}

impl Receiver {
    pub(crate) fn new(
        map: &Map<'_>,
        given: DVec2,
        courtyard: Option<usize>,
    ) -> Result<Self, TerminalError> {
        let place = given - map.scene.origin;
        let mut visibility = Visibility::from(map.scene.local(), place);
        let visible_walls = if map.config.reflection_limit() == 0 {
            Vec::new()
        } else {
            visibility.visible_walls(map.scene.local())
        };
        // Legs need the receiver's own images; without corners there are no legs.
        let legs = if map.may_reach_corners(courtyard) {
            let images = map.images(&mut visibility)?;
            legs(map, given, courtyard, &visibility, &images)?
        } else {
            Legs::default()
        };
        let steps = LastSteps::find(
            &map.corners,
            &legs,
            map.between.as_ref(),
            &map.config.limits(),
        );
        Ok(Self {
            map: map.scene.id,
            position: given,
            place,
            courtyard,
            visible_walls,
            azimuths_rad: legs.azimuths_rad(&map.corners, place),
            legs,
            steps: steps.ok_or_else(|| too_many(map, given))?,
            arrivals: OnceLock::new(),
        })
    }

    /// Position of the receiver \[m\].
    #[must_use]
    pub fn position(&self) -> DVec2 {
        self.position
    }
}

fn legs(
    map: &Map<'_>,
    given: DVec2,
    courtyard: Option<usize>,
    visibility: &Visibility,
    images: &ImageTree,
) -> Result<Legs, TerminalError> {
    if !map.may_reach_corners(courtyard) {
        return Ok(Legs::default());
    }
    let legs = map.legs(None, visibility, images);
    legs.ok_or_else(|| too_many(map, given))
}

fn too_many(map: &Map<'_>, position: DVec2) -> TerminalError {
    TerminalError::TooManyWaves {
        position,
        limit: map.config.max_wave_bytes,
    }
}
