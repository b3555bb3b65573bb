//! The fields of one scene: the work done once for all terminals.

use std::borrow::Cow;

use glam::DVec2;
use rayon::prelude::*;

use super::canvas::{Canvas, DARK, Source};
use super::corners::Corners;
use super::error::FieldError;
use super::fan::Fan;
use super::grid::FieldGrid;
use super::receiver::ReceiverRays;
use super::transmitter::TransmitterFields;
use crate::scene::{Location, Scene};

/// A pixel is near a corner if its centre is within so many pixels of it.
const NEAR_CORNER_PIXELS: f64 = 2.0;

/// Settings of the fields.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FieldConfig {
    /// Pixels of a transmitter's fields.
    pub grid: FieldGrid,
    /// Rays of a receiver.
    pub fan: Fan,
}

/// A scene prepared for making fields.
#[derive(Debug, Clone)]
pub struct FieldMap<'s> {
    given: Cow<'s, Scene>,
    /// Scene in which everything is computed, where that is another: moved by `-origin` where it lies far off.
    moved: Option<Scene>,
    origin: DVec2,
    config: FieldConfig,
    pub(super) corners: Corners,
    /// By pixel: whether a corner is near.
    pub(super) near_corner: Vec<bool>,
    is_outdoor: Vec<bool>,
    /// Pixels indoors with a neighbour outdoors.
    rim: Vec<usize>,
}

impl<'s> FieldMap<'s> {
    /// Prepares a scene: work done once a map, spread over the threads. Costs a view for each corner and a test for each pair of
    /// corners and each pixel.
    ///
    /// # Errors
    /// [`FieldError::Grid`], [`FieldError::Fan`], [`FieldError::TooManyCorners`].
    pub fn new(scene: &'s Scene, config: FieldConfig) -> Result<Self, FieldError> {
        Self::of(Cow::Borrowed(scene), config)
    }

    /// Prepares a scene as [`FieldMap::new`] does, and keeps it.
    ///
    /// # Errors
    /// As [`FieldMap::new`].
    pub fn owning(scene: Scene, config: FieldConfig) -> Result<FieldMap<'static>, FieldError> {
        FieldMap::of(Cow::Owned(scene), config)
    }

    fn of(given: Cow<'s, Scene>, config: FieldConfig) -> Result<Self, FieldError> {
        config.grid.check()?;
        config.fan.check()?;
        let origin = given.origin();
        let moved = (origin != DVec2::ZERO).then(|| given.moved(-origin));
        let local = moved.as_ref().unwrap_or(&given);
        let grid = config.grid.moved(-origin);
        let corners = Corners::new(local, [grid.first_m, grid.last_m()])?;
        let is_outdoor: Vec<bool> = (0..grid.pixels())
            .into_par_iter()
            .map(|pixel| {
                let location = local.locate(grid.centre(pixel));
                !matches!(location, Location::Inside { .. })
            })
            .collect();
        let is_rim = |&pixel: &usize| {
            !is_outdoor[pixel] && neighbours(&grid, pixel).any(|beside| is_outdoor[beside])
        };
        Ok(Self {
            rim: (0..grid.pixels()).filter(is_rim).collect(),
            near_corner: near_corner(&corners, &grid),
            is_outdoor,
            corners,
            origin,
            config,
            given,
            moved,
        })
    }

    /// Makes the fields of a transmitter.
    ///
    /// # Errors
    /// [`FieldError::Terminal`] where none can stand, [`FieldError::TooManySources`].
    pub fn transmitter(&self, position: DVec2) -> Result<TransmitterFields, FieldError> {
        self.given
            .check_terminal(position)
            .map_err(FieldError::Terminal)?;
        TransmitterFields::new(self, position)
    }

    /// Follows the rays of a receiver.
    ///
    /// # Errors
    /// [`FieldError::Terminal`] where none can stand.
    pub fn receiver(&self, position: DVec2) -> Result<ReceiverRays, FieldError> {
        self.given
            .check_terminal(position)
            .map_err(FieldError::Terminal)?;
        Ok(ReceiverRays::new(self, position))
    }

    /// The pixels.
    #[must_use]
    pub fn grid(&self) -> &FieldGrid {
        &self.config.grid
    }

    /// The rays.
    #[must_use]
    pub fn fan(&self) -> &Fan {
        &self.config.fan
    }

    /// Returns true, pixel by pixel, where the centre is outdoors, on a wall, or out of the scene's area.
    #[must_use]
    pub fn is_outdoor(&self) -> &[bool] {
        &self.is_outdoor
    }

    /// Number of corners that ways bend around.
    #[must_use]
    pub fn corner_count(&self) -> usize {
        self.corners.corners.len()
    }

    pub(super) fn scene(&self) -> &Scene {
        self.moved.as_ref().unwrap_or(&self.given)
    }

    pub(super) fn origin(&self) -> DVec2 {
        self.origin
    }

    pub(super) fn local_grid(&self) -> FieldGrid {
        self.config.grid.moved(-self.origin)
    }

    /// Two opposite corners of the box around all centres of pixels.
    pub(super) fn reach(&self) -> [DVec2; 2] {
        let grid = self.local_grid();
        [grid.first_m, grid.last_m()]
    }

    /// Gives each pixel indoors beside the street the source of that neighbour over which its centre is nearest, walls or not:
    /// a position before a wall may lie in a pixel with its centre behind the wall.
    pub(super) fn extend_to_rim(&self, canvas: &mut Canvas, sources: &[Source]) {
        let grid = self.local_grid();
        for &pixel in &self.rim {
            let centre = grid.centre(pixel);
            let length = |source: u32| sources[source as usize].length_m(centre);
            let beside = neighbours(&grid, pixel).filter(|&beside| self.is_outdoor[beside]);
            let lit = beside.map(|beside| canvas.sources[beside]);
            let lit = lit.filter(|&source| source != DARK);
            let nearest = lit.min_by(|&p, &q| length(p).total_cmp(&length(q)));
            canvas.sources[pixel] = nearest.unwrap_or(DARK);
        }
    }
}

/// The eight pixels around one, less those beyond the border.
fn neighbours(grid: &FieldGrid, pixel: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (pixel % grid.width, pixel / grid.width);
    let columns = x.saturating_sub(1)..(x + 2).min(grid.width);
    let (rows, width) = (y.saturating_sub(1)..(y + 2).min(grid.height), grid.width);
    let all = rows.flat_map(move |row| columns.clone().map(move |column| row * width + column));
    all.filter(move |&beside| beside != pixel)
}

fn near_corner(corners: &Corners, grid: &FieldGrid) -> Vec<bool> {
    let mut is_near = vec![false; grid.pixels()];
    let radius_m = NEAR_CORNER_PIXELS * grid.pixel_m;
    for corner in &corners.corners {
        let at = (corner.point - grid.first_m) / grid.pixel_m;
        let along = |at: f64, count: usize| {
            let from = (at - NEAR_CORNER_PIXELS).ceil().max(0.0);
            let to = (at + NEAR_CORNER_PIXELS).floor().min(count as f64 - 1.0);
            // None where the corner is far off the grid.
            from as usize..if to < from {
                from as usize
            } else {
                to as usize + 1
            }
        };
        for row in along(at.y, grid.height) {
            for column in along(at.x, grid.width) {
                let pixel = row * grid.width + column;
                is_near[pixel] |= grid.centre(pixel).distance(corner.point) < radius_m;
            }
        }
    }
    is_near
}
