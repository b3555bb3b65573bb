//! Footprints in GeoJSON (RFC 7946), the form in which OpenStreetMap is exported.
//!
//! A building is a feature with a `building` tag and a Polygon or MultiPolygon, also one inside a GeometryCollection. Each
//! polygon of a MultiPolygon becomes a footprint of its own, inner rings become courtyards. Not buildings are: features
//! without the tag (streets, trees, and `building:part`s, which lie inside their building), `building=no`, roofs on posts
//! (`building=roof` and `carport`), what is underground (`location=underground`, or a negative `layer`), and what does not
//! stand: planned, proposed, under construction, in ruins, collapsed, demolished and the like, as a value of `building` or
//! a key with the value `yes`. What is abandoned or disused stands.
//!
//! Units are read, never guessed: numbers are degrees of WGS 84 unless the file's `crs` member or the caller says otherwise.
//! Degrees become metres in a [`LocalPlane`](super::LocalPlane) about the middle of all buildings; coordinates are rounded
//! to 2^-10 m, finer than any survey, so that cutting out a tile moves them without a further rounding.

mod building;
mod crs;
mod document;
mod error;
mod frame;
mod geometry;
mod projected;
#[cfg(test)]
mod tests;

use glam::DVec2;

pub use error::GeoJsonError;

use self::building::Kind;
use self::crs::Crs;
use self::document::Feature;
use self::frame::Frame;
use self::geometry::Polygon;
use super::footprint::Footprint;
use super::ring;

/// Least size of a city's largest building \[m\].
const MIN_SIZE_M: f64 = 1.0;

/// Unit of the numbers of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coordinates {
    /// As its `crs` member says: longitude and latitude \[deg\] without one, as RFC 7946 has it; Web Mercator (EPSG:3857)
    /// and UTM are taken back to these.
    #[default]
    Degrees,
    /// Easting and northing of a map \[m\], taken as they are. A `crs` member may be UTM, whose metres are 0.9996 to 1.001
    /// of those on the ground, or null; others contradict it.
    Metres,
}

/// Settings for reading a file.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GeoJsonConfig {
    /// Unit of its numbers.
    pub coordinates: Coordinates,
    /// Takes every polygon for a building: for files of footprints alone, without tags.
    pub all_polygons: bool,
    /// Place that becomes (0, 0), in the unit of [`GeoJsonCity::origin`]; the middle of all buildings without one.
    pub origin: Option<[f64; 2]>,
}

/// The buildings of a file.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct GeoJsonCity {
    /// The buildings in the order of the file \[m\]; x to the east, y to the north.
    pub footprints: Vec<Footprint>,
    /// The reference system of the file's numbers, like `EPSG:32633`; `OGC:CRS84` where it names none, none for metres
    /// of an unnamed one.
    pub crs: Option<String>,
    /// Place of (0, 0): longitude and latitude \[deg\], or easting and northing \[m\] where metres were asked for.
    pub origin: [f64; 2],
    /// Features and rings that were passed over.
    pub skipped: Skipped,
}

/// Features and rings that made no footprint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Skipped {
    /// Features that are no building.
    pub features: usize,
    /// Buildings that do not stand: planned, under construction, in ruins, demolished.
    pub not_standing: usize,
    /// Buildings given as points or lines, or with no geometry.
    pub without_area: usize,
    /// Rings with fewer than three different vertices; a building goes with its outer one.
    pub rings: usize,
}

/// Reads the buildings of a GeoJSON text: a collection, a feature or a geometry, or several of them in a row, one a line or
/// as a text sequence (RFC 8142). The text is UTF-8, with or without a byte order mark.
///
/// # Errors
/// [`GeoJsonError`]. What geometry makes no sense beyond that is found by the scene.
///
/// ```
/// use aps_raytrace::scene::{GeoJsonConfig, parse_geojson};
/// let text = r#"{"type": "Feature", "properties": {"building": "yes"}, "geometry": {"type": "Polygon",
///     "coordinates": [[[24.9450, 60.1680], [24.9452, 60.1680], [24.9452, 60.1681], [24.9450, 60.1680]]]}}"#;
/// let city = parse_geojson(text, &GeoJsonConfig::default())?;
/// let [a, b] = [city.footprints[0].outer[0], city.footprints[0].outer[1]];
/// assert!((a.distance(b) - 11.1).abs() < 0.05);
/// # Ok::<(), aps_raytrace::scene::GeoJsonError>(())
/// ```
pub fn parse_geojson(
    text: impl AsRef<[u8]>,
    config: &GeoJsonConfig,
) -> Result<GeoJsonCity, GeoJsonError> {
    let features = document::features(text.as_ref())?;
    let mut skipped = Skipped::default();
    let mut polygons = Vec::new();
    let mut crs = None;
    for (number, feature) in features.iter().enumerate() {
        match Kind::of(feature) {
            _ if config.all_polygons => {}
            Kind::Building => {}
            Kind::NotStanding => {
                skipped.not_standing += 1;
                continue;
            }
            Kind::Other => {
                skipped.features += 1;
                continue;
            }
        }
        let before = polygons.len();
        let empty = geometry::collect(number, &feature.geometry, &mut polygons)?;
        if polygons.len() == before {
            skipped.without_area += 1;
            continue;
        }
        skipped.rings += empty;
        unite(&mut crs, number, feature.crs)?;
    }
    let Some(crs) = crs else {
        return Err(no_building(&features, config));
    };
    let crs = stated(crs, config.coordinates)?;
    let frame = match config.coordinates {
        Coordinates::Metres => Frame::of_metres(&polygons, config.origin)?,
        Coordinates::Degrees => {
            to_degrees(crs.unwrap_or(Crs::CRS84), &mut polygons)?;
            Frame::of_degrees(&polygons, config.origin)?
        }
    };
    let mut footprints = Vec::with_capacity(polygons.len());
    let mut size_m = 0.0_f64;
    for polygon in &polygons {
        let rings = metres(polygon, &frame)?;
        let (min, max) = ring::bounds(rings[0].iter().copied());
        size_m = size_m.max((max - min).max_element());
        footprints.extend(footprint(rings, &mut skipped));
    }
    if size_m < MIN_SIZE_M {
        return Err(GeoJsonError::TooSmall {
            buildings: polygons.len(),
            size_m,
        });
    }
    if footprints.is_empty() {
        return Err(no_building(&features, config));
    }
    Ok(GeoJsonCity {
        footprints,
        crs: crs.map(|crs| crs.to_string()),
        origin: frame.origin(),
        skipped,
    })
}

/// Refuses a building of another reference system than those before it.
fn unite(
    first: &mut Option<Option<Crs>>,
    feature: usize,
    crs: Option<Crs>,
) -> Result<(), GeoJsonError> {
    let [a, b] = [*first.get_or_insert(crs), crs].map(|crs| crs.unwrap_or(Crs::CRS84));
    match a.agrees(b) {
        true => Ok(()),
        false => Err(GeoJsonError::MixedCrs {
            feature,
            crs: b.to_string(),
            first: a.to_string(),
        }),
    }
}

/// The reference system, if it and the unit asked for make sense together; `None` for metres of an unknown one.
fn stated(crs: Option<Crs>, coordinates: Coordinates) -> Result<Option<Crs>, GeoJsonError> {
    match (coordinates, crs) {
        (Coordinates::Metres, None | Some(Crs::Unknown)) => Ok(None),
        (Coordinates::Metres, Some(crs @ Crs::Utm(_))) => Ok(Some(crs)),
        (Coordinates::Metres, Some(crs)) => Err(GeoJsonError::NotMetres {
            crs: crs.to_string(),
        }),
        (Coordinates::Degrees, Some(Crs::Unknown)) => Err(GeoJsonError::UnknownCrs),
        (Coordinates::Degrees, crs) => Ok(Some(crs.unwrap_or(Crs::CRS84))),
    }
}

fn to_degrees(crs: Crs, polygons: &mut [Polygon]) -> Result<(), GeoJsonError> {
    for polygon in polygons {
        for position in polygon.rings.iter_mut().flatten() {
            let [x, y] = *position;
            *position = crs.degrees([x, y]).ok_or_else(|| {
                frame::coordinate(polygon.feature, x, y, format!("position of {crs}"))
            })?;
        }
    }
    Ok(())
}

/// The rings of a polygon in metres.
fn metres(polygon: &Polygon, frame: &Frame) -> Result<Vec<Vec<DVec2>>, GeoJsonError> {
    let ring = |ring: &Vec<[f64; 2]>| {
        let points = ring.iter().map(|&p| frame.metres(polygon.feature, p));
        points.collect()
    };
    polygon.rings.iter().map(ring).collect()
}

/// The footprint of some rings; `None` without an outer one.
fn footprint(rings: Vec<Vec<DVec2>>, skipped: &mut Skipped) -> Option<Footprint> {
    let mut kept = Vec::with_capacity(rings.len());
    for (i, ring) in rings.into_iter().enumerate() {
        if ring::distinct_up_to_3(&ring) == 3 {
            kept.push(ring);
            continue;
        }
        skipped.rings += 1;
        if i == 0 {
            return None;
        }
    }
    let mut rings = kept.into_iter();
    rings.next().map(|outer| Footprint {
        outer,
        holes: rings.collect(),
        material: None,
    })
}

fn no_building(features: &[Feature], config: &GeoJsonConfig) -> GeoJsonError {
    let is_tagged = |feature: &Feature| feature.tag("building").is_some();
    let n = features.len();
    if n == 0 {
        return GeoJsonError::NoFeature;
    }
    match config.all_polygons || features.iter().any(is_tagged) {
        true => GeoJsonError::NoBuilding { features: n },
        false => GeoJsonError::NoTag { features: n },
    }
}
