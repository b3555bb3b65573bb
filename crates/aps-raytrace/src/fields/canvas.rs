//! Paints convex regions onto pixels: each keeps the source with the shortest way to it.

use glam::DVec2;

use super::grid::FieldGrid;
use crate::scene::Wall;

/// Regions are closed, and wider by this part of a pixel: what two regions share belongs to one of them at least.
const SLACK: f64 = 1e-9;

/// Most half-planes of a region: two rays, the walls at both ends, and two more around a corner.
const MAX_SIDES: usize = 6;

/// Marks a pixel that no source reaches.
pub(super) const DARK: u32 = u32::MAX;

/// A place that waves come from: a terminal, an image of it or a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Source {
    pub point: DVec2,
    /// Length of the way to it \[m\].
    pub offset_m: f64,
}

impl Source {
    /// Length of the way over the source to a place in its sight \[m\].
    pub fn length_m(&self, to: DVec2) -> f64 {
        self.offset_m + self.point.distance(to)
    }
}

/// The half of the plane to the left of a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct HalfPlane {
    pub point: DVec2,
    pub direction: DVec2,
}

impl HalfPlane {
    /// The street before a wall.
    pub fn before(wall: &Wall) -> Self {
        Self {
            point: wall.b,
            direction: -wall.along(),
        }
    }

    /// Positive inside, the distance times the length of the direction.
    pub fn depth(&self, p: DVec2) -> f64 {
        self.direction.perp_dot(p - self.point)
    }
}

/// For each pixel the source of the shortest way found.
#[derive(Debug)]
pub(super) struct Canvas {
    grid: FieldGrid,
    pub sources: Vec<u32>,
    lengths_m: Vec<f64>,
}

impl Canvas {
    pub fn new(grid: FieldGrid) -> Self {
        Self {
            grid,
            sources: vec![DARK; grid.pixels()],
            lengths_m: vec![f64::INFINITY; grid.pixels()],
        }
    }

    /// Paints what half-planes have in common between two heights, wherever the way over the source is shorter than any before.
    pub fn paint(
        &mut self,
        heights_m: [f64; 2],
        half_planes: impl Iterator<Item = HalfPlane>,
        id: u32,
        source: &Source,
    ) {
        let FieldGrid {
            first_m,
            pixel_m,
            width,
            height,
        } = self.grid;
        let [low, high] = heights_m.map(|y| (y - first_m.y) / pixel_m);
        let Some((from, to)) = range(low, high, height) else {
            return;
        };
        let mut sides = [Side::default(); MAX_SIDES];
        let mut count = 0;
        for (side, half_plane) in sides.iter_mut().zip(half_planes) {
            *side = Side::new(&half_plane, pixel_m * SLACK);
            count += 1;
        }
        for row in from..=to {
            let y = first_m.y + row as f64 * pixel_m;
            let (mut left, mut right) = (f64::MIN, f64::MAX);
            for side in &sides[..count] {
                side.cut(y, &mut left, &mut right);
            }
            let columns = range(
                (left - first_m.x) / pixel_m,
                (right - first_m.x) / pixel_m,
                width,
            );
            let Some((from, to)) = columns else {
                continue;
            };
            let dy = y - source.point.y;
            let start = row * width;
            let lengths = &mut self.lengths_m[start + from..=start + to];
            let sources = &mut self.sources[start + from..=start + to];
            for (i, (best, owner)) in lengths.iter_mut().zip(sources).enumerate() {
                let dx = first_m.x + (from + i) as f64 * pixel_m - source.point.x;
                let length = source.offset_m + (dx * dx + dy * dy).sqrt();
                let is_shorter = length < *best;
                *best = if is_shorter { length } else { *best };
                *owner = if is_shorter { id } else { *owner };
            }
        }
    }
}

/// First and last whole number between two, with slack, below `count`.
fn range(low: f64, high: f64, count: usize) -> Option<(usize, usize)> {
    let from = (low - SLACK).ceil().max(0.0);
    let to = (high + SLACK).floor().min(count as f64 - 1.0);
    (from <= to).then_some((from as usize, to as usize))
}

/// A half-plane as a bound of x on a row.
#[derive(Debug, Clone, Copy, Default)]
struct Side {
    point: DVec2,
    /// x over y along the line.
    slope: f64,
    kind: Kind,
}

/// Place of the line: at an end of each row, or below or above all rows inside.
#[derive(Debug, Clone, Copy, Default)]
enum Kind {
    #[default]
    None,
    Left,
    Right,
    Below,
    Above,
}

impl Side {
    fn new(half_plane: &HalfPlane, slack_m: f64) -> Self {
        let d = half_plane.direction;
        let (slope, kind) = if d.y > 0.0 {
            (d.x / d.y, Kind::Right)
        } else if d.y < 0.0 {
            (d.x / d.y, Kind::Left)
        } else if d.x > 0.0 {
            (0.0, Kind::Below)
        } else if d.x < 0.0 {
            (0.0, Kind::Above)
        } else {
            (0.0, Kind::None)
        };
        Self {
            point: half_plane.point - d.perp().normalize_or_zero() * slack_m,
            slope,
            kind,
        }
    }

    #[inline]
    fn cut(&self, y: f64, left: &mut f64, right: &mut f64) {
        let up = y - self.point.y;
        match self.kind {
            Kind::Right => *right = right.min(self.point.x + self.slope * up),
            Kind::Left => *left = left.max(self.point.x + self.slope * up),
            Kind::Below if up < 0.0 => *right = f64::MIN,
            Kind::Above if up > 0.0 => *right = f64::MIN,
            Kind::Below | Kind::Above | Kind::None => {}
        }
    }
}
