//! A map as a file that the command line reads.

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Area;
use serde_json::{Value, json};

use crate::cache::City;

/// Returns true for a map that RadioMapSeer's format holds: polygons without holes in its square.
pub fn is_plain(city: &City) -> bool {
    city.area == Area::RADIOMAPSEER && city.houses.iter().all(|h| h.footprint.holes.is_empty())
}

/// The houses as they were given: polygons of RadioMapSeer, or GeoJSON in metres where there are courtyards or the square is
/// another.
pub fn map(city: &City) -> Value {
    let ring = |ring: &Vec<DVec2>| -> Vec<[f64; 2]> {
        let is_closed = ring.first() == ring.last();
        let again = ring.first().filter(|_| !is_closed);
        let closed = ring.iter().chain(again);
        closed.map(|p| p.to_array()).collect()
    };
    if is_plain(city) {
        let rings = city.houses.iter().map(|h| ring(&h.footprint.outer));
        return rings.collect();
    }
    let features = city.houses.iter().map(|house| {
        let rings = std::iter::once(&house.footprint.outer).chain(&house.footprint.holes);
        let rings: Vec<_> = rings.map(ring).collect();
        json!({
            "type": "Feature",
            "properties": { "building": "yes" },
            "geometry": { "type": "Polygon", "coordinates": rings },
        })
    });
    json!({ "type": "FeatureCollection", "features": features.collect::<Value>() })
}

/// The file that the page saves a map as.
pub fn map_name(id: u32) -> String {
    format!("map-{id}.json")
}
