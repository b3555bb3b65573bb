//! Maps cut out of a city in GeoJSON.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Coordinates, GeoJsonConfig, GeoJsonError, Tiling, parse_geojson};
use clap::Args;
use serde_json::{Value, json};

use crate::maps::{SceneSettings, is_list, ranges};
use crate::note;

/// Tiles with a larger share of buildings have no room for terminals.
const MAX_BUILT_SHARE: f64 = 0.95;

/// A map needs a building as large as this [m].
pub const MIN_BUILDING_M: f64 = 1.0;

/// Settings by which a city in GeoJSON becomes maps.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "City in GeoJSON")]
pub struct TileArgs {
    /// Side of the maps it is cut into [m]; numbered row by row from the south-west [default: 256, or as the data set
    /// at hand was made].
    #[arg(long, value_name = "METRES")]
    pub tile: Option<f64>,
    /// Leave out maps with fewer buildings [default: 1, or as the data set at hand was made].
    #[arg(long)]
    pub min_buildings: Option<usize>,
    /// Its coordinates are metres, not degrees.
    #[arg(long)]
    pub metric: bool,
    /// Take every polygon for a building, with or without a building tag.
    #[arg(long)]
    pub all_polygons: bool,
}

/// [`TileArgs`] with everything said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TileSettings {
    pub tile_m: f64,
    pub min_buildings: usize,
    pub metric: bool,
    pub all_polygons: bool,
}

impl TileArgs {
    /// For maps of one's own.
    pub fn settings(&self) -> TileSettings {
        self.settings_of(&Value::Null)
    }

    /// For the maps of a data set: what is not said is as [`CutCity::describe`] has put it into its manifest, as far as that
    /// tells.
    pub fn settings_of(&self, stored: &Value) -> TileSettings {
        let stored_min = stored["min_buildings"].as_u64().map(|n| n as usize);
        TileSettings {
            tile_m: self.tile.or(stored["tile_m"].as_f64()).unwrap_or(256.0),
            min_buildings: self.min_buildings.or(stored_min).unwrap_or(1),
            metric: self.metric || stored["coordinates"] == "metres",
            all_polygons: self.all_polygons || stored["all_polygons"] == true,
        }
    }
}

/// A city, its tiles, and which of them are maps.
#[derive(Debug)]
pub struct CutCity {
    tiling: Tiling,
    ids: Vec<u32>,
    settings: Value,
}

impl CutCity {
    /// Reads and cuts a city, and says what was found.
    pub fn read(file: &Path, settings: TileSettings) -> Result<Self> {
        let place = || format!("city '{}'", file.display());
        let bytes = std::fs::read(file).with_context(place)?;
        Self::of_bytes(&bytes, file, settings)
    }

    /// The same from the bytes of a file.
    pub fn of_bytes(bytes: &[u8], file: &Path, settings: TileSettings) -> Result<Self> {
        let place = || format!("city '{}'", file.display());
        ensure!(
            !is_list(bytes),
            "'{}' holds a list, as RadioMapSeer's maps do, and no GeoJSON; give the folder that it is in, with its number in \
             --map-ids",
            file.display()
        );
        let config = GeoJsonConfig {
            coordinates: match settings.metric {
                true => Coordinates::Metres,
                false => Coordinates::Degrees,
            },
            all_polygons: settings.all_polygons,
        };
        let city = parse_geojson(bytes, &config)
            .map_err(|error| anyhow::anyhow!("{}: {error}{}", place(), advice(&error)))?;
        let (unit, digits) = match settings.metric {
            true => ("metres", 1),
            false => ("degrees", 5),
        };
        let [x, y] = city.origin;
        let description = json!({
            "kind": "geojson",
            "tile_m": settings.tile_m,
            "min_buildings": settings.min_buildings,
            "all_polygons": settings.all_polygons,
            "coordinates": unit,
            "crs": city.crs,
            "origin": city.origin,
            "buildings": city.footprints.len(),
        });
        let skipped = city.skipped;
        let mut words = format!(
            "{} buildings about ({x:.digits$}, {y:.digits$}) {unit}",
            city.footprints.len()
        );
        if let Some(crs) = city.crs {
            words += &format!(", read as {crs}");
        }
        for (count, what) in [
            (skipped.features, "features that are no building"),
            (
                skipped.not_standing,
                "buildings planned, under construction, in ruins or demolished",
            ),
            (skipped.without_area, "buildings without an area"),
            (skipped.rings, "rings without an area"),
        ] {
            if count > 0 {
                words += &format!("; {count} {what} passed over");
            }
        }
        let tiling = Tiling::new(city.footprints, settings.tile_m).with_context(place)?;
        let [columns, rows] = tiling.size();
        let is_map = |id: &u32| tiling.contents(*id).1 <= MAX_BUILT_SHARE && is_built(&tiling, *id);
        let ids: Vec<u32> = tiling.ids(settings.min_buildings).filter(is_map).collect();
        note!(
            "{}: {words}\n{columns} x {rows} tiles of {} m, {} of them maps: {}",
            place(),
            settings.tile_m,
            ids.len(),
            ranges(&ids)
        );
        ensure!(
            !ids.is_empty(),
            "{}: no tile has {} buildings and less than 95 % of its area built over",
            place(),
            settings.min_buildings
        );
        Ok(Self {
            tiling,
            ids,
            settings: description,
        })
    }

    /// The tiles that are maps; at least one.
    pub fn ids(&self) -> Result<Vec<u32>> {
        Ok(self.ids.clone())
    }

    /// Describes the settings that decide the maps, as a manifest keeps them.
    pub fn describe(&self) -> Value {
        self.settings.clone()
    }

    /// Side of the maps [m].
    pub fn side_m(&self) -> f64 {
        self.tiling.side_m()
    }

    /// One map: a tile with its buildings, those over the border whole.
    pub fn load(&self, id: u32, settings: SceneSettings) -> Result<Scene> {
        let Some(tile) = self.tiling.tile(id) else {
            bail!(
                "tile {id} has no buildings; those with some are {}",
                ranges(&self.ids)
            );
        };
        let scene = settings.scene(&tile.footprints, tile.area);
        scene.with_context(|| format!("tile {id}"))
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

/// Bounding box of some points.
pub fn bounds(points: &[DVec2]) -> (DVec2, DVec2) {
    let grow = |(min, max): (DVec2, DVec2), &p: &DVec2| (min.min(p), max.max(p));
    let none = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    points.iter().fold(none, grow)
}

/// Option to add or leave away where a file was read in another way than its writer meant; empty if none helps.
fn advice(error: &GeoJsonError) -> &'static str {
    match error {
        GeoJsonError::NoTag { .. } => " (--all-polygons takes untagged ones)",
        GeoJsonError::Coordinate { .. }
        | GeoJsonError::Latitude { .. }
        | GeoJsonError::TooLarge { .. }
        | GeoJsonError::UnknownCrs => " (--metric takes its numbers for metres)",
        GeoJsonError::NotMetres { .. } => "; leave --metric away",
        _ => "",
    }
}
