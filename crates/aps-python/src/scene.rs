//! Scenes.

use std::path::PathBuf;

use map2aps::aps_data::{RasterGrid, sha256_of};
use map2aps::aps_raytrace::glam::DVec2;
use map2aps::aps_raytrace::scene::{Area, Location, SceneConfig};
use map2aps::aps_raytrace::{self, Footprint};
use map2aps::maps::{self, SceneSettings, TileSettings};
use map2aps::{Control, MapSource};
use numpy::PyArrayDyn;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{Argument, Kind, points, shaped};
use crate::error::tried;
use crate::given::{Given, optional};
use crate::maps::tell_passed_over;
use crate::run::{run, run_owned};

/// Buildings of a city, checked, repaired and united, seen from above.
///
/// Made by one of the methods ``from_radiomapseer``, ``from_geojson``, ``from_polygons`` and ``synthetic``.
#[derive(Debug)]
#[pyclass(module = "map2aps", frozen)]
pub struct Scene {
    pub(crate) scene: aps_raytrace::Scene,
}

impl Scene {
    /// Digest of the walls: equal for the same buildings.
    pub fn digest(&self) -> String {
        let walls = self.scene.walls().iter();
        let ends = walls.flat_map(|wall| [wall.a.x, wall.a.y, wall.b.x, wall.b.y]);
        sha256_of(&ends.flat_map(f64::to_le_bytes).collect::<Vec<u8>>())
    }
}

fn settings(close_gaps_m: Option<Given<f64>>) -> PyResult<SceneSettings> {
    let default = SceneSettings::default();
    let given = optional(close_gaps_m, "close_gaps_m")?;
    Ok(SceneSettings {
        close_gaps_m: given.unwrap_or(default.close_gaps_m),
        ..default
    })
}

fn of_file(
    py: Python<'_>,
    file: PathBuf,
    tile: Option<u32>,
    tiles: TileSettings,
    close_gaps_m: Option<Given<f64>>,
) -> PyResult<Scene> {
    let settings = settings(close_gaps_m)?;
    let (scene, city) = run_owned(py, move || maps::load_file(&file, tile, tiles, settings))?;
    if let Some(city) = city {
        tell_passed_over(py, &city, 1)?;
    }
    Ok(Scene { scene })
}

/// A building: a ring, or its outer ring and those of its courtyards.
fn footprint(polygon: &Bound<'_, PyAny>) -> PyResult<Footprint> {
    let ring = |ring: &Bound<'_, PyAny>| {
        Argument::new(ring, "polygons", Kind::Real, &[None, Some(2)])?.points()
    };
    // Of a ring the first number, of rings the first point.
    let first = polygon.get_item(0).and_then(|first| first.get_item(0));
    if first.and_then(|first| first.len()).is_err() {
        return Ok(Footprint::new(ring(polygon)?));
    }
    let rings = polygon.try_iter()?.map(|one| ring(&one?));
    let mut rings = rings.collect::<PyResult<Vec<_>>>()?.into_iter();
    let outer = rings.next().unwrap_or_default();
    Ok(Footprint {
        holes: rings.collect(),
        ..Footprint::new(outer)
    })
}

#[pymethods]
impl Scene {
    /// Reads a RadioMapSeer map: buildings in the square from 0 to 256 m.
    ///
    /// Parameters
    /// ----------
    /// file : path-like
    ///     JSON file of polygons.
    /// close_gaps_m : float, optional
    ///     Slits between walls that are narrower are filled, in m; 0.04 by default, 0 leaves all open.
    ///
    /// Returns
    /// -------
    /// Scene
    #[staticmethod]
    #[pyo3(signature = (file, *, close_gaps_m = None))]
    fn from_radiomapseer(
        py: Python<'_>,
        file: PathBuf,
        close_gaps_m: Option<Given<f64>>,
    ) -> PyResult<Self> {
        of_file(py, file, None, TileSettings::default(), close_gaps_m)
    }

    /// Reads a tile of a city in GeoJSON, as OpenStreetMap's exports are.
    ///
    /// Parameters
    /// ----------
    /// file : path-like
    ///     GeoJSON file.
    /// tile : int, optional
    ///     The tile, counted row by row from the south-west; the first one with buildings by default.
    /// tile_m : float, optional
    ///     Side of the tiles in m; 256 by default.
    /// metric : bool
    ///     The coordinates are metres, not degrees.
    /// all_polygons : bool
    ///     Every polygon is a building, with or without a building tag.
    /// close_gaps_m : float, optional
    ///     As of ``from_radiomapseer``.
    ///
    /// Returns
    /// -------
    /// Scene
    ///     The tile, its south-western corner at (0, 0).
    #[staticmethod]
    #[pyo3(
        signature = (
            file, *, tile = None, tile_m = None, metric = false.into(), all_polygons = false.into(), close_gaps_m = None
        ),
        text_signature = "(file, *, tile=None, tile_m=None, metric=False, all_polygons=False, close_gaps_m=None)"
    )]
    fn from_geojson(
        py: Python<'_>,
        file: PathBuf,
        tile: Option<Given<u32>>,
        tile_m: Option<Given<f64>>,
        metric: Given<bool>,
        all_polygons: Given<bool>,
        close_gaps_m: Option<Given<f64>>,
    ) -> PyResult<Self> {
        let default = TileSettings::default();
        let tiles = TileSettings {
            tile_m: optional(tile_m, "tile_m")?.unwrap_or(default.tile_m),
            metric: metric.named("metric")?,
            all_polygons: all_polygons.named("all_polygons")?,
            ..default
        };
        let tile = optional(tile, "tile")?;
        of_file(py, file, tile, tiles, close_gaps_m)
    }

    /// Makes up a city in the square from 0 to 256 m.
    ///
    /// Parameters
    /// ----------
    /// seed : int
    ///     The same seed makes the same city, everywhere.
    /// close_gaps_m : float, optional
    ///     As of ``from_radiomapseer``.
    ///
    /// Returns
    /// -------
    /// Scene
    #[staticmethod]
    #[pyo3(
        signature = (seed = 1.into(), *, close_gaps_m = None),
        text_signature = "(seed=1, *, close_gaps_m=None)"
    )]
    fn synthetic(
        py: Python<'_>,
        seed: Given<u64>,
        close_gaps_m: Option<Given<f64>>,
    ) -> PyResult<Self> {
        let (seed, settings) = (seed.named("seed")?, settings(close_gaps_m)?);
        let source = MapSource::Synthetic { count: 1 };
        let scene = run_owned(py, move || source.load(0, seed, settings))?;
        Ok(Self { scene })
    }

    /// Makes a scene of outlines of buildings.
    ///
    /// Parameters
    /// ----------
    /// polygons : sequence
    ///     Of each building its outline, array_like of shape (n, 2) in m, or a list of it and of the outlines of its courtyards, as
    ///     a polygon of GeoJSON is. Open or closed, turning either way.
    /// area : tuple (left, bottom, right, top), optional
    ///     Rectangle that terminals are confined to, in m; the whole plane by default.
    /// close_gaps_m : float, optional
    ///     As of ``from_radiomapseer``.
    ///
    /// Returns
    /// -------
    /// Scene
    #[staticmethod]
    #[pyo3(signature = (polygons, *, area = None, close_gaps_m = None))]
    fn from_polygons(
        py: Python<'_>,
        polygons: &Bound<'_, PyAny>,
        area: Option<Given<[f64; 4]>>,
        close_gaps_m: Option<Given<f64>>,
    ) -> PyResult<Self> {
        let Some(polygons) = tried(py, polygons.try_iter())? else {
            let kind = polygons.get_type().name()?;
            let text = format!("polygons: expected a sequence of polygons, got {kind}");
            return Err(PyValueError::new_err(text));
        };
        let footprints = polygons.map(|polygon| {
            py.check_signals()?;
            footprint(&polygon?)
        });
        let footprints = footprints.collect::<PyResult<Vec<_>>>()?;
        let config = SceneConfig {
            area: optional(area, "area")?.map(|[left, bottom, right, top]| Area {
                min: DVec2::new(left, bottom),
                max: DVec2::new(right, top),
            }),
            close_gaps_m: settings(close_gaps_m)?.close_gaps_m,
        };
        let make = move || Ok(aps_raytrace::Scene::with_config(&footprints, &config)?);
        Ok(Self {
            scene: run_owned(py, make)?,
        })
    }

    /// Tells which points are outdoors and in the area: neither in a building nor on its wall.
    ///
    /// Parameters
    /// ----------
    /// points_m : array_like, shape (n, 2) or (2,)
    ///     The points, in m.
    ///
    /// Returns
    /// -------
    /// ndarray of bool, shape (n,)
    fn is_outdoor<'py>(
        &self,
        py: Python<'py>,
        points_m: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        let points = points(points_m, "points_m")?;
        if let Some(row) = points.iter().position(|p| !p.is_finite()) {
            let text = format!("points_m: row {row} is {}, which is no place", points[row]);
            return Err(PyValueError::new_err(text));
        }
        let is_outdoor = |&p: &DVec2| self.scene.locate(p) == Location::Outdoor;
        let is_outdoor: Vec<bool> = points.iter().map(is_outdoor).collect();
        let rows = is_outdoor.len();
        shaped(py, is_outdoor, [rows])
    }

    /// Draws the buildings.
    ///
    /// Parameters
    /// ----------
    /// size : int
    ///     Rows and columns; 256 by default.
    ///
    /// Returns
    /// -------
    /// ndarray of uint8, shape (size, size)
    ///     1 for pixels in a building. Pixel (x, y) is in row y, column x, and stands for the point (x, y) times the area's side
    ///     over `size`.
    #[pyo3(signature = (size = 256.into()), text_signature = "($self, size=256)")]
    fn raster<'py>(
        &self,
        py: Python<'py>,
        size: Given<usize>,
    ) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        let size = size.named("size")?;
        let square = self
            .scene
            .area()
            .filter(|area| area.min == DVec2::ZERO && area.max.x == area.max.y);
        let Some(area) = square else {
            let text = "a raster shows a square area with a corner at (0, 0), which this scene has not; give area=(0, 0, SIDE, SIDE)";
            return Err(PyValueError::new_err(text));
        };
        let grid = RasterGrid::square(size, area.max.x);
        let draw = |_: &Control<'_>| maps::raster(&self.scene, grid);
        let raster = run(py, None, draw)?;
        shaped(py, raster.pixels().to_vec(), [size, size])
    }

    /// Outlines of the united buildings: rings in m, each of shape (n, 2); what lies in an odd number of them is indoors.
    #[getter]
    fn outlines<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArrayDyn<f64>>>> {
        let ring = |ring: Vec<DVec2>| {
            let values: Vec<f64> = ring.iter().flat_map(DVec2::to_array).collect();
            shaped(py, values, [ring.len(), 2])
        };
        self.scene.outlines().into_iter().map(ring).collect()
    }

    /// Walls from end to end in m, shape (walls, 2, 2): the buildings are to their left.
    #[getter]
    fn walls<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let walls = self.scene.walls();
        let ends = walls.iter().flat_map(|wall| [wall.a, wall.b]);
        let values: Vec<f64> = ends.flat_map(|p| p.to_array()).collect();
        shaped(py, values, [walls.len(), 2, 2])
    }

    /// Rectangle that terminals are confined to, left, bottom, right and top in m; None for the whole plane.
    #[getter]
    fn area(&self) -> Option<[f64; 4]> {
        let area = self.scene.area()?;
        Some([area.min.x, area.min.y, area.max.x, area.max.y])
    }

    /// Repairs of the polygons in words; empty for none.
    #[getter]
    fn repairs(&self) -> String {
        match self.scene.report().is_clean() {
            true => String::new(),
            false => self.scene.report().to_string(),
        }
    }

    fn __repr__(&self) -> String {
        format!(
            "Scene({} buildings, {} walls)",
            self.scene.building_count(),
            self.scene.walls().len()
        )
    }
}
