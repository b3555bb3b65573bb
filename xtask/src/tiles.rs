//! Maps cut out of a city in GeoJSON.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use aps_raytrace::Scene;
use aps_raytrace::scene::{Coordinates, GeoJsonConfig, Tiling, parse_geojson};
use clap::Args;
use serde_json::{Value, json};

use crate::maps::{Map, ranges};
use crate::note;

/// Tiles with a larger share of buildings have no room for terminals.
const MAX_BUILT_SHARE: f64 = 0.95;

/// How a city in GeoJSON becomes maps.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "City in GeoJSON")]
pub struct TileArgs {
    /// Side of the maps it is cut into [m]; numbered row by row from the south-west.
    #[arg(long, default_value_t = 256.0, value_name = "METRES")]
    pub tile: f64,
    /// Leave out maps with fewer buildings.
    #[arg(long, default_value_t = 1)]
    pub min_buildings: usize,
    /// Its coordinates are metres, not degrees.
    #[arg(long)]
    pub metric: bool,
    /// Take every polygon for a building, with or without a building tag.
    #[arg(long)]
    pub all_polygons: bool,
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
    pub fn read(file: &Path, args: &TileArgs) -> Result<Self> {
        let place = || format!("city '{}'", file.display());
        let text = std::fs::read_to_string(file).with_context(place)?;
        let config = GeoJsonConfig {
            coordinates: if args.metric {
                Coordinates::Metres
            } else {
                Coordinates::Auto
            },
            all_polygons: args.all_polygons,
        };
        let city = parse_geojson(&text, &config).with_context(|| match args.all_polygons {
            true => place(),
            false => format!("{} (--all-polygons takes untagged ones)", place()),
        })?;
        let (unit, digits) = match city.coordinates {
            Coordinates::Metres => ("metres", 1),
            _ => ("degrees", 5),
        };
        let [x, y] = city.origin;
        let settings = json!({
            "kind": "geojson",
            "tile_m": args.tile,
            "min_buildings": args.min_buildings,
            "coordinates": unit,
            "origin": city.origin,
            "buildings": city.footprints.len(),
        });
        let skipped = city.skipped;
        let mut words = format!(
            "{} buildings about ({x:.digits$}, {y:.digits$}) {unit}",
            city.footprints.len()
        );
        for (count, what) in [
            (skipped.features, "features that are no building"),
            (skipped.without_area, "buildings without an area"),
            (skipped.rings, "rings without an area"),
        ] {
            if count > 0 {
                words += &format!("; {count} {what} passed over");
            }
        }
        let tiling = Tiling::new(city.footprints, args.tile).with_context(place)?;
        let [columns, rows] = tiling.size();
        let is_open = |id: &u32| tiling.contents(*id).1 <= MAX_BUILT_SHARE;
        let ids: Vec<u32> = tiling.ids(args.min_buildings).filter(is_open).collect();
        note!(
            "{}: {words}\n{columns} x {rows} tiles of {} m, {} of them maps: {}",
            place(),
            args.tile,
            ids.len(),
            ranges(&ids)
        );
        ensure!(
            !ids.is_empty(),
            "{}: no tile has {} buildings and room between them",
            place(),
            args.min_buildings
        );
        Ok(Self {
            tiling,
            ids,
            settings,
        })
    }

    /// The tiles that are maps; at least one.
    pub fn ids(&self) -> Result<Vec<u32>> {
        Ok(self.ids.clone())
    }

    /// What decides the maps, as a manifest keeps it.
    pub fn describe(&self) -> Value {
        self.settings.clone()
    }

    /// Side of the maps [m].
    pub fn side_m(&self) -> f64 {
        self.tiling.side_m()
    }

    /// One map: a tile with its buildings, those over the border whole.
    pub fn load(&self, id: u32) -> Result<Map> {
        let Some(tile) = self.tiling.tile(id) else {
            bail!(
                "tile {id} has no buildings; those with some are {}",
                ranges(&self.ids)
            );
        };
        let scene =
            Scene::new(&tile.footprints, Some(tile.area)).with_context(|| format!("tile {id}"))?;
        Ok(Map {
            footprints: tile.footprints,
            scene,
        })
    }
}
