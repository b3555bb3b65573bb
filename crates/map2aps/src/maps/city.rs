//! Maps cut out of a city in GeoJSON.

use std::fmt;
use std::path::{Path, PathBuf};

use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Coordinates, GeoJsonConfig, Skipped, Tile, Tiling, parse_geojson};
use serde_json::{Value, json};

use super::scene_settings::{MIN_BUILDING_M, SceneSettings, bounds};
use super::{MapError, radiomapseer, ranges};
use crate::counted;
use crate::error::{At, Error, Place, Result, must_be_file};

/// Tiles with a larger share of buildings have no room for terminals.
const MAX_BUILT_SHARE: f64 = 0.95;

/// Settings by which a city in GeoJSON becomes maps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TileSettings {
    /// Side of the maps \[m\]; they are numbered row by row from the south-west.
    pub tile_m: f64,
    /// Fewest buildings of a map.
    pub min_buildings: usize,
    /// Coordinates are metres, not degrees.
    pub metric: bool,
    /// Every polygon is a building, with or without a building tag.
    pub all_polygons: bool,
    /// South-west corner of the first map: longitude and latitude \[deg\], or metres as `metric` has it; that of all buildings
    /// without one.
    pub corner: Option<[f64; 2]>,
}

impl Default for TileSettings {
    fn default() -> Self {
        Self {
            tile_m: 256.0,
            min_buildings: 1,
            metric: false,
            all_polygons: false,
            corner: None,
        }
    }
}

impl TileSettings {
    /// The settings in the `configuration` of a data set, as far as it tells them; otherwise the default.
    pub fn of_dataset(configuration: &Value) -> Self {
        let stored = &configuration["maps"];
        let default = Self::default();
        let min_buildings = stored["min_buildings"].as_u64();
        Self {
            tile_m: stored["tile_m"].as_f64().unwrap_or(default.tile_m),
            min_buildings: min_buildings.map_or(default.min_buildings, |n| n as usize),
            metric: stored["coordinates"] == "metres",
            all_polygons: stored["all_polygons"] == true,
            corner: serde_json::from_value(stored["corner"].clone()).unwrap_or_default(),
        }
    }

    /// Refuses settings other than the default, for maps that are not cut into tiles.
    ///
    /// # Errors
    /// [`MapError::NoTiles`].
    pub fn must_be_default(self) -> Result<(), MapError> {
        match self == Self::default() {
            true => Ok(()),
            false => Err(MapError::NoTiles),
        }
    }
}

/// A city cut into tiles, some of which are maps.
#[derive(Debug, Clone)]
pub struct City {
    file: PathBuf,
    tiling: Tiling,
    ids: Vec<u32>,
    settings: TileSettings,
    crs: Option<String>,
    origin: [f64; 2],
    buildings: usize,
    skipped: Skipped,
}

impl City {
    /// Reads and cuts a city.
    ///
    /// # Errors
    /// A file that cannot be read, is no GeoJSON, or holds no map.
    pub fn read(file: &Path, settings: TileSettings) -> Result<Self> {
        let bytes = std::fs::read(file).at_file(Place::City, file)?;
        Self::of_bytes(&bytes, file, settings)
    }

    /// Cuts the city in the bytes of a file.
    pub(super) fn of_bytes(bytes: &[u8], file: &Path, settings: TileSettings) -> Result<Self> {
        if is_list(bytes) {
            return Err(Error::Map(MapError::NotGeoJson(file.into())));
        }
        let config = GeoJsonConfig {
            coordinates: match settings.metric {
                true => Coordinates::Metres,
                false => Coordinates::Degrees,
            },
            all_polygons: settings.all_polygons,
            origin: settings.corner,
        };
        let city = parse_geojson(bytes, &config).at_file(Place::City, file)?;
        let buildings = city.footprints.len();
        let tiling = match settings.corner {
            None => Tiling::new(city.footprints, settings.tile_m),
            Some(_) => Tiling::from_corner(city.footprints, settings.tile_m, DVec2::ZERO),
        };
        let tiling = tiling.at_file(Place::City, file)?;
        let is_map = |id: &u32| tiling.contents(*id).1 <= MAX_BUILT_SHARE && is_built(&tiling, *id);
        let ids: Vec<u32> = tiling.ids(settings.min_buildings).filter(is_map).collect();
        let city = Self {
            file: file.into(),
            tiling,
            ids,
            settings,
            crs: city.crs,
            origin: city.origin,
            buildings,
            skipped: city.skipped,
        };
        match city.ids.is_empty() {
            true => Err(MapError::NoTile(settings.min_buildings)).at_file(Place::City, file),
            false => Ok(city),
        }
    }

    /// The file of the city.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Settings by which it was cut.
    pub fn settings(&self) -> TileSettings {
        self.settings
    }

    /// The tiles that are maps, ascending; at least one.
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// Describes the settings that decide the maps, as a manifest keeps them.
    pub fn describe(&self) -> Value {
        let mut described = json!({
            "kind": "geojson",
            "tile_m": self.settings.tile_m,
            "min_buildings": self.settings.min_buildings,
            "all_polygons": self.settings.all_polygons,
            "coordinates": self.unit().0,
            "crs": self.crs,
            "origin": self.origin,
            "buildings": self.buildings,
        });
        if let Some(corner) = self.settings.corner {
            described["corner"] = json!(corner);
        }
        described
    }

    /// Numbers of features, buildings and rings of the file that became no building.
    pub fn skipped(&self) -> Skipped {
        self.skipped
    }

    /// Text that tells them; empty where there are none.
    pub fn passed_over(&self) -> String {
        let told = [
            (
                self.skipped.features,
                "feature that is no building",
                "features that are no building",
            ),
            (
                self.skipped.not_standing,
                "building planned, under construction, in ruins or demolished",
                "buildings planned, under construction, in ruins or demolished",
            ),
            (
                self.skipped.without_area,
                "building without an area",
                "buildings without an area",
            ),
            (
                self.skipped.rings,
                "ring without an area",
                "rings without an area",
            ),
        ];
        let told = told.into_iter().filter(|(count, ..)| *count > 0);
        let told =
            told.map(|(count, one, many)| format!("{} passed over", counted(count, one, many)));
        told.collect::<Vec<_>>().join("; ")
    }

    /// Side of the maps \[m\].
    pub fn side_m(&self) -> f64 {
        self.tiling.side_m()
    }

    /// Makes the scene of one map: a tile with its buildings, those over the border whole.
    ///
    /// # Errors
    /// [`MapError::EmptyTile`], and buildings that make no scene.
    pub fn load(&self, id: u32, settings: SceneSettings) -> Result<Scene> {
        let tile = self.tile(id)?;
        let scene = settings.scene(&tile.footprints, tile.area);
        scene.at(Place::Tile(id))
    }

    /// One map: a tile with its buildings.
    pub(super) fn tile(&self, id: u32) -> Result<Tile, MapError> {
        self.tiling.tile(id).ok_or_else(|| MapError::EmptyTile {
            tile: id,
            maps: self.ids.clone(),
        })
    }

    /// Unit of the coordinates, and the digits that place a city.
    fn unit(&self) -> (&'static str, usize) {
        match self.settings.metric {
            true => ("metres", 1),
            false => ("degrees", 5),
        }
    }
}

/// Two lines: the buildings found and passed over, the tiles and maps.
impl fmt::Display for City {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([x, y], (unit, digits)) = (self.origin, self.unit());
        write!(
            f,
            "city '{}': {} about ({x:.digits$}, {y:.digits$}) {unit}",
            self.file.display(),
            counted(self.buildings, "building", "buildings")
        )?;
        if let Some(crs) = &self.crs {
            write!(f, ", read as {crs}")?;
        }
        let passed_over = self.passed_over();
        if !passed_over.is_empty() {
            write!(f, "; {passed_over}")?;
        }
        let [columns, rows] = self.tiling.size();
        let (tiles, side_m) = (
            if columns * rows == 1 { "tile" } else { "tiles" },
            self.settings.tile_m,
        );
        write!(
            f,
            "\n{columns} x {rows} {tiles} of {side_m} m, {} of them {}: {}",
            self.ids.len(),
            if self.ids.len() == 1 { "a map" } else { "maps" },
            ranges(&self.ids)
        )
    }
}

/// Returns true when a tile has a building at least as large as [`MIN_BUILDING_M`].
fn is_built(tiling: &Tiling, id: u32) -> bool {
    let tile = tiling.tile(id);
    tile.is_some_and(|tile| {
        let mut rings = tile.footprints.iter().map(|f| &f.outer);
        rings.any(|ring| {
            let (min, max) = bounds(ring);
            (max - min).max_element() >= MIN_BUILDING_M
        })
    })
}

/// Reads the one map of a RadioMapSeer file, or a tile of a city in GeoJSON, the first that is a map if none is named, with
/// the city.
///
/// # Errors
/// A file that is not there, holds no map, or makes no scene, and settings of tiles for a map that is none.
pub fn load_file(
    file: &Path,
    tile: Option<u32>,
    tiles: TileSettings,
    settings: SceneSettings,
) -> Result<(Scene, Option<City>)> {
    match must_be_file(file) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(MapError::NoFile).at_file(Place::MapFile, file);
        }
        is_file => is_file.at_file(Place::MapFile, file)?,
    }
    let bytes = std::fs::read(file).at_file(Place::MapFile, file)?;
    load_bytes(&bytes, file, tile, tiles, settings)
}

/// Does what [`load_file`] does, with the bytes of a file of that name.
///
/// # Errors
/// As [`load_file`].
pub fn load_bytes(
    bytes: &[u8],
    file: &Path,
    tile: Option<u32>,
    tiles: TileSettings,
    settings: SceneSettings,
) -> Result<(Scene, Option<City>)> {
    match is_list(bytes) {
        true if tile.is_some() => Err(MapError::NoTiles).at_file(Place::MapFile, file),
        true => {
            tiles.must_be_default().at_file(Place::MapFile, file)?;
            let scene = radiomapseer::scene(bytes, settings);
            Ok((scene.at_file(Place::MapFile, file)?, None))
        }
        false => {
            let city = City::of_bytes(bytes, file, tiles)?;
            let scene = city.load(tile.unwrap_or(city.ids()[0]), settings)?;
            Ok((scene, Some(city)))
        }
    }
}

/// Returns true when a JSON text is a list, like the maps of RadioMapSeer, and no object, like those of GeoJSON.
fn is_list(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.trim_ascii_start().first() == Some(&b'[')
}
