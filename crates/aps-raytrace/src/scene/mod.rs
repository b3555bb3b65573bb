//! The scene: checked walls, their corners and an index over them.

mod city;
mod courtyards;
mod footprint;
mod gaps;
#[cfg(feature = "geojson")]
mod geojson;
mod locate;
mod plane;
mod radiomapseer;
mod repair;
mod ring;
mod tiles;
mod union;
mod wall;
mod wgs84;

use glam::DVec2;

pub use city::CityConfig;
pub use footprint::Footprint;
#[cfg(feature = "geojson")]
pub use geojson::{Coordinates, GeoJsonCity, GeoJsonConfig, GeoJsonError, Skipped, parse_geojson};
pub use locate::Location;
pub use plane::LocalPlane;
pub use radiomapseer::parse_radiomapseer;
pub use repair::{Repair, RepairKind, RepairReport};
pub use tiles::{Tile, Tiling, TilingError};
pub use wall::Wall;

use crate::error::SceneError;
use crate::occlusion::{self, LegSegment};
use crate::wall_index::WallIndex;

/// Buildings below this area \[m^2\] are dropped as slivers.
const MIN_BUILDING_AREA_M2: f64 = 1e-3;
/// Part of the scene's squared extent below which buildings are dropped, where that is less: a model city in
/// millimetres has buildings too.
const MIN_BUILDING_SHARE: f64 = 1e-7;

/// A rectangle in the plane \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Lower left corner \[m\].
    pub min: DVec2,
    /// Upper right corner \[m\].
    pub max: DVec2,
}

impl Area {
    /// The square of a RadioMapSeer map: 0 to 256 m both ways.
    pub const RADIOMAPSEER: Self = Self {
        min: DVec2::ZERO,
        max: DVec2::splat(256.0),
    };

    /// Returns true when `p` is inside or on the border.
    #[must_use]
    pub fn contains(&self, p: DVec2) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }
}

/// Settings for making a scene from footprints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneConfig {
    /// The area that terminals are confined to; none for the whole plane.
    pub area: Option<Area>,
    /// Slits between walls are filled where they are narrower \[m\], at most 20; 0 leaves all open. Buildings that span less than 1 m
    /// together are a model of another scale: none of their slits is filled.
    ///
    /// The default, 0.04 m, is just below half a wavelength at 3.5 GHz: a wave whose field is parallel to the walls does not
    /// pass a slit below half a wavelength. Maps do not resolve as much: OpenStreetMap stores positions to 0.01 m, and
    /// buildings are surveyed to some 0.1 m.
    pub close_gaps_m: f64,
}

impl Default for SceneConfig {
    fn default() -> Self {
        Self {
            area: None,
            close_gaps_m: 0.04,
        }
    }
}

/// Widest slit that is filled \[m\]: above, streets would be, at the price of all pairs of walls.
const MAX_GAP_M: f64 = 20.0;

/// Buildings that span less together \[m\] are a model, in which no slit is filled.
const MODEL_EXTENT_M: f64 = 1.0;

/// A checked city: the walls that waves can meet.
///
/// Walls are numbered outline by outline, outlines by their lowest, then leftmost vertex, so
/// that ids depend on the geometry alone. Wall `i` starts at corner `i`.
#[derive(Debug, Clone)]
pub struct Scene {
    walls: Vec<Wall>,
    index: WallIndex,
    /// Walls of each courtyard, the smallest courtyard first.
    courtyards: Vec<Vec<u32>>,
    area: Option<Area>,
    buildings: usize,
    report: RepairReport,
}

impl Scene {
    /// Checks, repairs and unites footprints, with the default [`SceneConfig`] but for the area.
    ///
    /// # Errors
    /// As [`Scene::with_config`].
    pub fn new(footprints: &[Footprint], area: Option<Area>) -> Result<Self, SceneError> {
        let config = SceneConfig {
            area,
            ..SceneConfig::default()
        };
        Self::with_config(footprints, &config)
    }

    /// Checks, repairs and unites footprints. Costs O(n log n) in the number of
    /// vertices, a few milliseconds for a city district.
    ///
    /// # Errors
    /// [`SceneError`] for what no repair can make sense of, naming building and vertex.
    ///
    /// ```
    /// use aps_raytrace::{Footprint, Scene, glam::DVec2, scene::SceneConfig};
    /// let house = [(0.0, 0.0), (0.0, 8.0), (10.0, 8.0), (10.0, 0.0)].map(DVec2::from);
    /// let scene = Scene::with_config(&[Footprint::new(house)], &SceneConfig::default())?;
    /// assert_eq!(scene.walls().len(), 4);
    /// assert_eq!(scene.report().to_string(), "1 reoriented");
    /// # Ok::<(), aps_raytrace::SceneError>(())
    /// ```
    pub fn with_config(footprints: &[Footprint], config: &SceneConfig) -> Result<Self, SceneError> {
        let area = config.area;
        if let Some(Area { min, max }) = area
            && !(min.is_finite() && max.is_finite() && min.cmplt(max).all())
        {
            return Err(SceneError::Area { min, max });
        }
        let width_m = config.close_gaps_m;
        if !(0.0..=MAX_GAP_M).contains(&width_m) {
            return Err(SceneError::CloseGaps { width_m });
        }
        let mut report = RepairReport::default();
        let extent_m = extent_m(footprints);
        let min_area_m2 = (MIN_BUILDING_SHARE * extent_m * extent_m).min(MIN_BUILDING_AREA_M2);
        let mut buildings = Vec::with_capacity(footprints.len());
        for (building, footprint) in footprints.iter().enumerate() {
            if let Some(material) = footprint.material {
                material
                    .validate()
                    .map_err(|source| SceneError::Material { building, source })?;
            }
            let rings = clean_building(building, footprint, min_area_m2, &mut report)?;
            if !rings.is_empty() {
                buildings.push((building, rings));
            }
        }
        let material = |building: usize| footprints[building].material;
        let outlines = union::unite(
            &buildings,
            if extent_m < MODEL_EXTENT_M {
                0.0
            } else {
                width_m
            },
            |p, q| material(p) == material(q),
            &mut report,
        );
        report.repairs.sort_by_key(|r| r.building);

        let mut walls = Vec::with_capacity(outlines.iter().map(|o| o.points.len()).sum());
        for outline in &outlines {
            let first = walls.len();
            let n = outline.points.len();
            walls.extend((0..n).map(|i| Wall {
                a: outline.points[i],
                b: outline.points[(i + 1) % n],
                previous: (first + (i + n - 1) % n) as u32,
                next: (first + (i + 1) % n) as u32,
                building: outline.edge_building[i],
                material: material(outline.edge_building[i]),
            }));
        }
        Ok(Self {
            index: WallIndex::new(&walls),
            courtyards: courtyards::courtyards(&walls),
            walls,
            area,
            buildings: footprints.len(),
            report,
        })
    }

    /// A RadioMapSeer map: its footprints in the 256 m square.
    ///
    /// # Errors
    /// As [`parse_radiomapseer`] and [`Scene::new`].
    pub fn from_radiomapseer(text: &str) -> Result<Self, SceneError> {
        Self::new(&parse_radiomapseer(text)?, Some(Area::RADIOMAPSEER))
    }

    /// Walls, indexed by id.
    #[must_use]
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// The outlines of the united buildings \[m\]: outer ones counter-clockwise, courtyards clockwise, each from its lowest,
    /// then leftmost vertex, which is not repeated.
    #[must_use]
    pub fn outlines(&self) -> Vec<Vec<DVec2>> {
        // Walls of one outline are numbered in a row; its last one leads back to its first.
        let ids = (0..self.walls.len()).collect::<Vec<_>>();
        let outlines = ids.chunk_by(|&id, &following| self.walls[id].next as usize == following);
        let points = |ids: &[usize]| ids.iter().map(|&id| self.walls[id].a).collect();
        outlines.map(points).collect()
    }

    /// The area that terminals are confined to.
    #[must_use]
    pub fn area(&self) -> Option<Area> {
        self.area
    }

    /// Number of footprints given.
    #[must_use]
    pub fn building_count(&self) -> usize {
        self.buildings
    }

    /// Faults found in the footprints, and their repairs.
    #[must_use]
    pub fn report(&self) -> &RepairReport {
        &self.report
    }

    /// Returns true when corner `id` (the start of wall `id`) points outwards, so that it diffracts
    /// unless another building touches it.
    #[must_use]
    pub fn is_convex(&self, id: u32) -> bool {
        occlusion::is_convex(&self.walls, id)
    }

    /// Returns true when the open segment from `p` to `q` meets the inside of a building.
    ///
    /// Grazing a wall or passing a corner on one side leaves it free; slipping through between
    /// two corners that leave a gap of width zero does not. Decided exactly, and the same in
    /// both directions.
    #[inline]
    #[must_use]
    pub fn is_blocked(&self, p: DVec2, q: DVec2) -> bool {
        self.is_obstructed(&LegSegment::between(p, q))
    }

    /// Returns true when one wall already blocks the segment from `p` to `q`.
    #[inline]
    pub(crate) fn is_blocked_by(&self, p: DVec2, q: DVec2, wall: Option<u32>) -> bool {
        let leg = LegSegment::between(p, q);
        wall.is_some_and(|wall| leg.is_blocked_by(&self.walls, wall))
    }

    /// Returns true when a leg, whose ends may be rounded, meets the inside of a building.
    #[inline]
    pub(crate) fn is_obstructed(&self, leg: &LegSegment) -> bool {
        leg.is_blocked(&self.walls, &self.index)
    }

    /// A place to count from that is near the walls \[m\]: zero unless the scene is small against
    /// its distance from there, as in UTM coordinates.
    ///
    /// Subtracting it is exact for every vertex (Sterbenz: no coordinate is more than twice
    /// another), so that the walls so moved are the same walls with more digits to compute in.
    fn origin(&self) -> DVec2 {
        if self.walls.is_empty() {
            return DVec2::ZERO;
        }
        let (min, max) = ring::bounds(self.walls.iter().map(|wall| wall.a));
        let axis = |min: f64, max: f64| {
            let nearest = if min > 0.0 { min.floor() } else { max.ceil() };
            let farthest = min.abs().max(max.abs());
            if nearest != 0.0 && min.signum() == max.signum() && farthest <= 2.0 * nearest.abs() {
                nearest
            } else {
                0.0
            }
        };
        DVec2::new(axis(min.x, max.x), axis(min.y, max.y))
    }

    /// Returns the scene with its walls counted from their origin, where that is not zero, and the origin \[m\].
    pub(crate) fn near_zero(&self) -> (Option<Self>, DVec2) {
        let origin = self.origin();
        if origin == DVec2::ZERO {
            return (None, origin);
        }
        let mut scene = self.clone();
        for wall in &mut scene.walls {
            wall.a -= origin;
            wall.b -= origin;
        }
        scene.area = scene.area.map(|area| Area {
            min: area.min - origin,
            max: area.max - origin,
        });
        scene.index = WallIndex::new(&scene.walls);
        (Some(scene), origin)
    }

    pub(crate) fn index(&self) -> &WallIndex {
        &self.index
    }
}

/// The longer side of the box around all buildings \[m\].
fn extent_m(footprints: &[Footprint]) -> f64 {
    let points = footprints.iter().flat_map(|f| f.outer.iter().copied());
    let (min, max) = ring::bounds(points);
    // Points that are not finite are refused when their ring is cleaned.
    (max - min).max_element()
}

fn clean_building(
    building: usize,
    footprint: &Footprint,
    min_area_m2: f64,
    report: &mut RepairReport,
) -> Result<Vec<ring::Ring>, SceneError> {
    let mut rings = Vec::new();
    let given = footprint.rings();
    if given[0].0 != 0 {
        report.push(building, RepairKind::RingsReordered);
    }
    for (place, &(i, points)) in given.iter().enumerate() {
        match ring::clean(building, i, place == 0, points, report)? {
            Some(r) => {
                ring::report_crossings(building, &r, report);
                rings.push(r);
            }
            // Without its outer ring a building is gone, courtyards and all.
            None if place == 0 => return Ok(Vec::new()),
            None => {}
        }
    }
    let area = ring::doubled_area(&rings[0].points) / 2.0;
    if area < min_area_m2 && report_is_simple(report, building) {
        report.push(building, RepairKind::Sliver);
        return Ok(Vec::new());
    }
    Ok(rings)
}

/// The signed area of a figure of eight says nothing about its size.
fn report_is_simple(report: &RepairReport, building: usize) -> bool {
    !report
        .repairs
        .iter()
        .any(|r| r.building == building && matches!(r.kind, RepairKind::SelfIntersection { .. }))
}
