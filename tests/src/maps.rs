//! Real cities: a part of Helsinki, which is committed, and maps of RadioMapSeer where they lie beside the checkout.

use std::fs;
use std::path::Path;

use aps_raytrace::Scene;
use aps_raytrace::scene::{GeoJsonConfig, Tile, Tiling, parse_geojson};

/// Helsinki, and those of the maps `ids` that are in `../shared/maps`, each with its name.
///
/// # Panics
/// A file is not a map.
#[must_use]
pub fn real_cities(ids: &[u32]) -> Vec<(String, Scene)> {
    let tile = helsinki(256.0);
    let scene = Scene::new(&tile.footprints, Some(tile.area)).expect("sound footprints");
    let mut cities = vec![("Helsinki".into(), scene)];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/maps");
    for id in ids {
        if let Ok(text) = fs::read_to_string(folder.join(format!("{id}.json"))) {
            let scene = Scene::from_radiomapseer(&text).expect("a map of RadioMapSeer");
            cities.push((format!("map {id}"), scene));
        }
    }
    cities
}

/// The tile of so many metres of the committed extract that has the most buildings.
///
/// # Panics
/// The extract has no tiles of this size.
#[must_use]
pub fn helsinki(side_m: f64) -> Tile {
    let text = include_str!("../data/helsinki.geojson");
    let city = parse_geojson(text, &GeoJsonConfig::default()).expect("the committed extract");
    let tiling = Tiling::new(city.footprints, side_m).expect("a few tiles");
    let most = tiling.ids(1).max_by_key(|&id| tiling.contents(id).0);
    most.and_then(|id| tiling.tile(id)).expect("buildings")
}
