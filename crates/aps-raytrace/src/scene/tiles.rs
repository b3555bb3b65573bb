//! A city cut into square maps.
//!
//! Tile (column, row) of side s is the square from (column, row) * s to (column + 1, row + 1) * s, counted from the
//! south-west corner of the bounding box of all buildings, or from a corner that is given. Tiles are numbered row by row from there: id = row * columns +
//! column.
//!
//! A tile holds every building that has some area in it, whole, even where it reaches beyond the border: a building cut
//! there would get a wall that does not exist. Buildings beyond the border are left out, since the image of the map
//! does not show them. Terminals are confined to the square.

use std::collections::BTreeMap;

use glam::DVec2;
use thiserror::Error;

use super::Area;
use super::footprint::Footprint;
use super::ring;

/// Most tiles a city may be cut into, empty ones included: 256 km x 256 km of maps of 256 m.
const MAX_TILES: f64 = 1e6;

/// Most pairs of a building and a tile its bounding box reaches.
const MAX_PLACES: f64 = 1e7;

/// Error of cutting a city into tiles.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TilingError {
    /// A side that no map can have.
    #[error("tiles of {side_m} m: the side must be finite and at least 1 m")]
    Side {
        /// The side asked for \[m\].
        side_m: f64,
    },
    /// There is nothing to cut.
    #[error("there is no building")]
    NoBuilding,
    /// The buildings are too far apart, or far too large.
    #[error(
        "buildings from {min} to {max} m make too many tiles of {side_m} m; remove the outliers or cut the file"
    )]
    Extent {
        /// Lower left corner of their bounding box \[m\].
        min: DVec2,
        /// Upper right corner \[m\].
        max: DVec2,
        /// The side asked for \[m\].
        side_m: f64,
    },
}

/// A city cut into square maps.
#[derive(Debug, Clone, PartialEq)]
pub struct Tiling {
    side_m: f64,
    origin_m: DVec2,
    columns: u32,
    rows: u32,
    footprints: Vec<Footprint>,
    tiles: BTreeMap<u32, Contents>,
}

#[derive(Debug, Clone, PartialEq, Default)]
struct Contents {
    buildings: Vec<usize>,
    built_m2: f64,
}

/// One square map of a city; see [`Tiling`].
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    /// Number of the tile, row by row from the south-west.
    pub id: u32,
    /// Place of the tile: column from the west, row from the south.
    pub cell: [u32; 2],
    /// South-west corner in the coordinates of the city \[m\].
    pub origin_m: DVec2,
    /// Buildings that reach into the tile \[m\], x to the east and y to the north from that corner.
    pub footprints: Vec<Footprint>,
    /// The square that terminals are confined to: from 0 to the side both ways.
    pub area: Area,
}

impl Tiling {
    /// Cuts a city into squares of a side \[m\].
    ///
    /// Cost: number of vertices times the tiles each building reaches.
    ///
    /// # Errors
    /// [`TilingError`].
    ///
    /// ```
    /// use aps_raytrace::{Footprint, glam::DVec2, scene::Tiling};
    /// let house = |x: f64| Footprint::new([(x, 0.), (x + 9., 0.), (x + 9., 9.), (x, 9.)].map(DVec2::from));
    /// let city = Tiling::new(vec![house(0.0), house(95.0)], 100.0)?;
    /// assert_eq!(city.ids(1).collect::<Vec<_>>(), [0, 1]);
    /// assert_eq!(city.tile(1).unwrap().footprints[0].outer[0], DVec2::new(-5.0, 0.0));
    /// # Ok::<(), aps_raytrace::scene::TilingError>(())
    /// ```
    pub fn new(footprints: Vec<Footprint>, side_m: f64) -> Result<Self, TilingError> {
        Self::cut(footprints, side_m, None)
    }

    /// Cuts the part of a city that lies north and east of a corner \[m\]; cost as [`Tiling::new`].
    ///
    /// # Errors
    /// [`TilingError`].
    pub fn from_corner(
        footprints: Vec<Footprint>,
        side_m: f64,
        corner_m: DVec2,
    ) -> Result<Self, TilingError> {
        Self::cut(footprints, side_m, Some(corner_m))
    }

    fn cut(
        footprints: Vec<Footprint>,
        side_m: f64,
        corner_m: Option<DVec2>,
    ) -> Result<Self, TilingError> {
        if !(side_m.is_finite() && side_m >= 1.0) {
            return Err(TilingError::Side { side_m });
        }
        let outer = |f: &Footprint| bounds(f.rings()[0].1);
        let boxes: Vec<_> = footprints.iter().filter_map(outer).collect();
        let Some((min, max)) = boxes
            .iter()
            .copied()
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
        else {
            return Err(TilingError::NoBuilding);
        };
        let min = corner_m.unwrap_or(min);
        let count = ((max - min) / side_m).ceil().max(DVec2::ONE);
        let reach = |(a, b): (DVec2, DVec2)| {
            let cells = ((b - a) / side_m).ceil() + 1.0;
            cells.x * cells.y
        };
        let places: f64 = boxes.into_iter().map(reach).sum();
        if !(count.x * count.y <= MAX_TILES && places <= MAX_PLACES) {
            return Err(TilingError::Extent { min, max, side_m });
        }
        let mut tiling = Self {
            side_m,
            origin_m: min,
            columns: count.x as u32,
            rows: count.y as u32,
            tiles: BTreeMap::new(),
            footprints: Vec::new(),
        };
        for (building, footprint) in footprints.iter().enumerate() {
            tiling.place(building, footprint);
        }
        tiling.footprints = footprints;
        Ok(tiling)
    }

    fn place(&mut self, building: usize, footprint: &Footprint) {
        let rings = footprint.rings();
        let Some((min, max)) = bounds(rings[0].1) else {
            return;
        };
        let cell = |p: DVec2| ((p - self.origin_m) / self.side_m).floor();
        let (first, last) = (cell(min).max(DVec2::ZERO), cell(max));
        if last.min_element() < 0.0 {
            return;
        }
        for row in first.y as u32..=(last.y as u32).min(self.rows - 1) {
            for column in first.x as u32..=(last.x as u32).min(self.columns - 1) {
                let corner = self.corner([column, row]);
                let inside = |ring: &[DVec2]| area_inside(ring, corner, self.side_m);
                let outer = inside(rings[0].1);
                // Of a ring that crosses itself, parts of opposite sense may add up to nothing.
                let has_corner = || rings[0].1.iter().any(|&p| self.is_within(p - corner));
                if outer <= 0.0 && !has_corner() {
                    continue;
                }
                let yards: f64 = rings[1..].iter().map(|(_, hole)| inside(hole)).sum();
                let contents = self.tiles.entry(row * self.columns + column).or_default();
                contents.buildings.push(building);
                contents.built_m2 += (outer - yards).max(0.0);
            }
        }
    }

    /// Tells if a point lies inside of a tile, seen from its corner.
    fn is_within(&self, p: DVec2) -> bool {
        p.min_element() > 0.0 && p.max_element() < self.side_m
    }

    fn corner(&self, [column, row]: [u32; 2]) -> DVec2 {
        self.origin_m + DVec2::new(f64::from(column), f64::from(row)) * self.side_m
    }

    /// Columns and rows of the grid of tiles, empty ones included.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.columns, self.rows]
    }

    /// The side of a tile \[m\].
    #[must_use]
    pub fn side_m(&self) -> f64 {
        self.side_m
    }

    /// Numbers of the tiles with at least so many buildings, and at least one, in ascending order.
    pub fn ids(&self, min_buildings: usize) -> impl Iterator<Item = u32> {
        let has_enough = move |(_, c): &(&u32, &Contents)| c.buildings.len() >= min_buildings;
        self.tiles.iter().filter(has_enough).map(|(&id, _)| id)
    }

    /// Number of buildings in a tile, and the share of it they cover; overlapping ones count twice.
    #[must_use]
    pub fn contents(&self, id: u32) -> (usize, f64) {
        self.tiles.get(&id).map_or((0, 0.0), |c| {
            (c.buildings.len(), c.built_m2 / (self.side_m * self.side_m))
        })
    }

    /// Returns a tile; `None` when there is no such tile or no building in it.
    #[must_use]
    pub fn tile(&self, id: u32) -> Option<Tile> {
        let cell = [id % self.columns, id / self.columns];
        let origin_m = self.corner(cell);
        let shift = |ring: &Vec<DVec2>| ring.iter().map(|&p| p - origin_m).collect();
        let buildings = &self.tiles.get(&id)?.buildings;
        Some(Tile {
            id,
            cell,
            origin_m,
            footprints: buildings
                .iter()
                .map(|&building| {
                    let f = &self.footprints[building];
                    Footprint {
                        outer: shift(&f.outer),
                        holes: f.holes.iter().map(shift).collect(),
                        material: f.material,
                    }
                })
                .collect(),
            area: Area {
                min: DVec2::ZERO,
                max: DVec2::splat(self.side_m),
            },
        })
    }
}

/// Bounding box of some points; `None` without any, or when one is not finite.
fn bounds(points: &[DVec2]) -> Option<(DVec2, DVec2)> {
    let is_sound = !points.is_empty() && points.iter().all(|p| p.is_finite());
    is_sound.then(|| ring::bounds(points.iter().copied()))
}

/// Area of the part of a ring inside a square \[m^2\]: Sutherland and Hodgman, Reentrant polygon clipping, Comm. ACM 17,
/// 1974. Where the part falls apart, the pieces stay joined along the border, which has no area.
fn area_inside(ring: &[DVec2], corner: DVec2, side_m: f64) -> f64 {
    let mut points: Vec<DVec2> = ring.iter().map(|&p| p - corner).collect();
    // Keep x >= 0, turn a quarter about the square's centre, and again.
    for _ in 0..4 {
        let mut kept = Vec::with_capacity(points.len() + 4);
        for (i, &b) in points.iter().enumerate() {
            let a = points[(i + points.len() - 1) % points.len()];
            if (a.x < 0.0) != (b.x < 0.0) {
                kept.push(DVec2::new(0.0, a.y + (b.y - a.y) * (a.x / (a.x - b.x))));
            }
            if b.x >= 0.0 {
                kept.push(b);
            }
        }
        points = kept
            .into_iter()
            .map(|p| DVec2::new(p.y, side_m - p.x))
            .collect();
    }
    ring::doubled_area(&points).abs() / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Footprint {
        Footprint::new([(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(DVec2::from))
    }

    /// Houses of 10 m by 10 m.
    fn houses<const N: usize>(corners: [(f64, f64); N]) -> Vec<Footprint> {
        let house = |(x, y)| rectangle(x, y, x + 10.0, y + 10.0);
        corners.map(house).into()
    }

    #[test]
    fn building_over_a_border_is_whole_in_both_tiles() {
        let city = vec![
            rectangle(0.0, 0.0, 10.0, 10.0),
            rectangle(90.0, 20.0, 130.0, 40.0),
        ];
        let tiling = Tiling::new(city, 100.0).unwrap();
        assert_eq!(tiling.size(), [2, 1]);
        let (west, east) = (tiling.tile(0).unwrap(), tiling.tile(1).unwrap());
        assert_eq!((west.footprints.len(), east.footprints.len()), (2, 1));
        assert_eq!(east.footprints[0].outer[0], DVec2::new(-10.0, 20.0));
        assert!((tiling.contents(1).1 - 30.0 * 20.0 / 1e4).abs() < 1e-12);
    }

    #[test]
    fn building_that_only_touches_a_tile_is_not_in_it() {
        let city = vec![
            rectangle(0.0, 0.0, 100.0, 100.0),
            rectangle(150.0, 0.0, 160.0, 10.0),
        ];
        let tiling = Tiling::new(city, 100.0).unwrap();
        assert_eq!(tiling.tile(1).unwrap().footprints.len(), 1);
        assert_eq!(tiling.contents(0), (1, 1.0));
    }

    #[test]
    fn tiles_are_numbered_row_by_row_from_the_south_west() {
        let city = houses([(0.0, 0.0), (250.0, 0.0), (50.0, 150.0)]);
        let tiling = Tiling::new(city, 100.0).unwrap();
        assert_eq!(tiling.size(), [3, 2]);
        assert_eq!(tiling.ids(1).collect::<Vec<_>>(), [0, 2, 3]);
        assert_eq!(tiling.ids(2).count(), 0);
        assert_eq!(tiling.tile(3).unwrap().cell, [0, 1]);
        assert_eq!(tiling.tile(1), None);
    }

    #[test]
    fn tiles_from_a_corner_leave_out_what_lies_behind_it() {
        let city = houses([(0.0, 0.0), (95.0, 10.0), (250.0, 0.0), (50.0, 150.0)]);
        let corner = DVec2::new(100.0, -30.0);
        let tiling = Tiling::from_corner(city.clone(), 100.0, corner).unwrap();
        assert_eq!(tiling.ids(1).collect::<Vec<_>>(), [0, 1]);
        let first = tiling.tile(0).unwrap();
        assert_eq!(first.footprints.len(), 1);
        assert_eq!(first.footprints[0].outer[0], DVec2::new(-5.0, 40.0));
        let nothing = Tiling::from_corner(city.clone(), 100.0, DVec2::splat(1e3)).unwrap();
        assert_eq!(nothing.ids(1).count(), 0);
        let far = Tiling::from_corner(city, 100.0, DVec2::splat(-1e9));
        assert!(matches!(far, Err(TilingError::Extent { .. })));
    }

    #[test]
    fn building_around_a_tile_is_in_it_and_its_courtyard_is_free() {
        let around = Footprint {
            holes: vec![rectangle(-50.0, -50.0, 150.0, 150.0).outer],
            ..rectangle(-60.0, -60.0, 160.0, 160.0)
        };
        assert!((area_inside(&around.outer, DVec2::ZERO, 100.0) - 1e4).abs() < 1e-9);
        assert!((area_inside(&around.holes[0], DVec2::ZERO, 100.0) - 1e4).abs() < 1e-9);
    }

    #[test]
    fn area_of_a_concave_part_is_exact() {
        // A U whose legs alone reach into the square.
        let u = [
            (-20., 10.),
            (30., 10.),
            (30., 30.),
            (-10., 30.),
            (-10., 60.),
            (30., 60.),
            (30., 80.),
            (-20., 80.),
        ];
        let u = u.map(DVec2::from);
        assert!((area_inside(&u, DVec2::ZERO, 100.0) - 2.0 * 30.0 * 20.0).abs() < 1e-9);
    }

    #[test]
    fn a_ring_that_crosses_itself_is_in_its_tile() {
        let bow_tie = [(10., 10.), (20., 20.), (20., 10.), (10., 20.)].map(DVec2::from);
        let city = vec![
            rectangle(0.0, 0.0, 5.0, 5.0),
            Footprint::new(bow_tie),
            rectangle(100.0, 0.0, 110.0, 5.0),
        ];
        let tiling = Tiling::new(city, 50.0).unwrap();
        let tiles: Vec<usize> = tiling.ids(1).map(|id| tiling.contents(id).0).collect();
        assert_eq!(tiles, [2, 1]);
    }

    #[test]
    fn impossible_cuts_are_refused() {
        assert_eq!(Tiling::new(vec![], 256.0), Err(TilingError::NoBuilding));
        let house = || rectangle(0.0, 0.0, 10.0, 10.0);
        for side in [0.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(
                Tiling::new(vec![house()], side),
                Err(TilingError::Side { .. })
            ));
        }
        let far = vec![house(), rectangle(1e7, 1e7, 1.1e7, 1.1e7)];
        assert!(matches!(
            Tiling::new(far, 256.0),
            Err(TilingError::Extent { .. })
        ));
    }
}
