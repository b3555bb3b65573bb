//! Footprints in GeoJSON (RFC 7946), the form in which OpenStreetMap is exported.
//!
//! A building is a feature with a `building` tag and a Polygon or MultiPolygon, also one inside a GeometryCollection. Each
//! polygon of a MultiPolygon becomes a footprint of its own, inner rings become courtyards. Not buildings are: features
//! without the tag (streets, trees, and `building:part`s, which lie inside their building), `building=no`, roofs on posts
//! (`building=roof` and `carport`), and what is underground (`location=underground`, or a negative `layer`).
//!
//! Longitude and latitude become metres in a [`LocalPlane`] about the middle of all buildings; coordinates are rounded to
//! 2^-10 m, finer than any survey, so that cutting out a tile moves them without a further rounding.

use ::geojson::{Feature, GeoJson, Geometry, GeometryValue, Position};
use glam::DVec2;
use thiserror::Error;

use super::footprint::Footprint;
use super::plane::LocalPlane;

/// Coordinates are rounded to this many parts of a metre.
const PARTS_PER_METRE: f64 = 1024.0;

/// Largest coordinate in metres: beyond any plane of the Earth.
const MAX_METRES: f64 = 1e8;

/// Values of `building` that are not one, or have no walls.
const NO_WALLS: [&str; 3] = ["no", "roof", "carport"];

/// What the numbers of a file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coordinates {
    /// Degrees if all of them could be, else metres.
    #[default]
    Auto,
    /// Longitude and latitude on WGS84, as RFC 7946 has it \[deg\].
    Degrees,
    /// Easting and northing of a projected map \[m\].
    Metres,
}

/// How a file is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GeoJsonConfig {
    /// What its numbers are.
    pub coordinates: Coordinates,
    /// Takes every polygon for a building: for files of footprints alone, without tags.
    pub all_polygons: bool,
}

/// The buildings of a file.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct GeoJsonCity {
    /// The buildings in the order of the file \[m\]; x to the east, y to the north.
    pub footprints: Vec<Footprint>,
    /// What the numbers of the file were taken for: degrees or metres.
    pub coordinates: Coordinates,
    /// Where (0, 0) is: longitude and latitude \[deg\], or easting and northing \[m\].
    pub origin: [f64; 2],
    /// What was passed over.
    pub skipped: Skipped,
}

/// Features and rings that made no footprint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Skipped {
    /// Features that are no building.
    pub features: usize,
    /// Buildings given as points or lines.
    pub without_area: usize,
    /// Rings with fewer than three different vertices; a building goes with its outer one.
    pub rings: usize,
}

/// Why a file gives no city.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum GeoJsonError {
    /// The text is not GeoJSON.
    #[error("not valid GeoJSON: {reason}")]
    Syntax {
        /// The parser's words, with line and column where they are known.
        reason: String,
    },
    /// No feature has the tag.
    #[error(
        "none of {features} features has a `building` tag; export OpenStreetMap's buildings, or take every polygon for one"
    )]
    NoTag {
        /// Features in the file.
        features: usize,
    },
    /// No feature is a building with an area.
    #[error("none of {features} features is a building with an area")]
    NoBuilding {
        /// Features in the file.
        features: usize,
    },
    /// A position without two numbers.
    #[error("feature {feature}: a position needs two numbers")]
    Position {
        /// Index of the feature.
        feature: usize,
    },
    /// A coordinate that cannot be.
    #[error("feature {feature}: ({x}, {y}) is no {expected}")]
    Coordinate {
        /// Index of the feature.
        feature: usize,
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
        /// What it should be.
        expected: &'static str,
    },
    /// The buildings are too far apart for one plane.
    #[error(
        "feature {feature} is {distance_deg:.1} degrees from the middle of all buildings, at most {limit_deg} fit one plane; cut the file"
    )]
    TooLarge {
        /// Index of the feature.
        feature: usize,
        /// How far \[deg\].
        distance_deg: f64,
        /// How far is allowed \[deg\].
        limit_deg: f64,
    },
}

/// Reads the buildings of a GeoJSON text.
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
pub fn parse_geojson(text: &str, config: &GeoJsonConfig) -> Result<GeoJsonCity, GeoJsonError> {
    let json: GeoJson = text
        .parse()
        .map_err(|e: ::geojson::Error| GeoJsonError::Syntax {
            reason: e.to_string(),
        })?;
    let features = match json {
        GeoJson::FeatureCollection(collection) => collection.features,
        GeoJson::Feature(feature) => vec![feature],
        GeoJson::Geometry(geometry) => vec![geometry.into()],
    };
    let mut skipped = Skipped::default();
    let mut polygons = Vec::new();
    for (number, feature) in features.iter().enumerate() {
        if !(config.all_polygons || is_building(feature)) {
            skipped.features += 1;
            continue;
        }
        let before = polygons.len();
        if let Some(geometry) = &feature.geometry {
            collect(number, geometry, &mut polygons);
        }
        skipped.without_area += usize::from(polygons.len() == before);
    }
    if let Some(polygon) = polygons
        .iter()
        .find(|p| p.rings.iter().flatten().any(|p| p.len() < 2))
    {
        let feature = polygon.feature;
        return Err(GeoJsonError::Position { feature });
    }
    if polygons.is_empty() {
        let is_tagged = |feature: &Feature| tag(feature, "building").is_some();
        let features_n = features.len();
        return Err(
            match config.all_polygons || features.iter().any(is_tagged) {
                true => GeoJsonError::NoBuilding {
                    features: features_n,
                },
                false => GeoJsonError::NoTag {
                    features: features_n,
                },
            },
        );
    }
    let frame = Frame::of(&polygons, config.coordinates)?;
    let mut footprints = Vec::with_capacity(polygons.len());
    for polygon in &polygons {
        footprints.extend(frame.footprint(polygon, &mut skipped)?);
    }
    if footprints.is_empty() {
        return Err(GeoJsonError::NoBuilding {
            features: features.len(),
        });
    }
    Ok(GeoJsonCity {
        footprints,
        coordinates: frame.coordinates(),
        origin: frame.origin(),
        skipped,
    })
}

/// The rings of one polygon, and the feature they are from. Each position was checked to have two numbers, which the
/// parser does not promise.
struct Polygon<'a> {
    feature: usize,
    rings: &'a [Vec<Position>],
}

fn tag<'a>(feature: &'a Feature, key: &str) -> Option<&'a serde_json::Value> {
    feature
        .properties
        .as_ref()?
        .get(key)
        .filter(|v| !v.is_null())
}

fn is_building(feature: &Feature) -> bool {
    let is = |key, value: &str| tag(feature, key).and_then(|v| v.as_str()) == Some(value);
    let layer = tag(feature, "layer").and_then(|v| match v.as_str() {
        Some(text) => text.trim().parse().ok(),
        None => v.as_f64(),
    });
    tag(feature, "building").is_some_and(|v| v != false)
        && !NO_WALLS.iter().any(|value| is("building", value))
        && !is("location", "underground")
        && layer.is_none_or(|layer| layer >= 0.0)
}

/// Nesting is as deep as the parser allowed, a hundred levels.
fn collect<'a>(feature: usize, geometry: &'a Geometry, polygons: &mut Vec<Polygon<'a>>) {
    match &geometry.value {
        GeometryValue::Polygon { coordinates: rings } => polygons.push(Polygon { feature, rings }),
        GeometryValue::MultiPolygon { coordinates } => {
            polygons.extend(coordinates.iter().map(|rings| Polygon { feature, rings }));
        }
        GeometryValue::GeometryCollection { geometries } => {
            for geometry in geometries {
                collect(feature, geometry, polygons);
            }
        }
        _ => {}
    }
}

/// How the numbers of a file become metres.
enum Frame {
    Plane(LocalPlane),
    Shift(DVec2),
}

impl Frame {
    fn of(polygons: &[Polygon<'_>], coordinates: Coordinates) -> Result<Self, GeoJsonError> {
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for p in polygons.iter().flat_map(|p| p.rings.iter().flatten()) {
            let p = DVec2::new(p[0], p[1]);
            (min, max) = (min.min(p), max.max(p));
        }
        let fits = |min: DVec2, max: DVec2| {
            min.x >= -180.0 && max.x <= 180.0 && min.y >= -90.0 && max.y <= 90.0
        };
        let middle = (min + max) / 2.0;
        match coordinates {
            Coordinates::Degrees => Ok(Self::Plane(LocalPlane::at(middle.x, middle.y))),
            Coordinates::Auto if fits(min, max) => {
                Ok(Self::Plane(LocalPlane::at(middle.x, middle.y)))
            }
            // Whole metres, so that coordinates given in metres keep their fractions.
            _ => Ok(Self::Shift(middle.floor())),
        }
    }

    fn coordinates(&self) -> Coordinates {
        match self {
            Self::Plane(_) => Coordinates::Degrees,
            Self::Shift(_) => Coordinates::Metres,
        }
    }

    fn origin(&self) -> [f64; 2] {
        match self {
            Self::Plane(plane) => plane.origin_deg(),
            Self::Shift(origin) => origin.to_array(),
        }
    }

    /// The polygon in metres; `None` without an outer ring.
    fn footprint(
        &self,
        polygon: &Polygon<'_>,
        skipped: &mut Skipped,
    ) -> Result<Option<Footprint>, GeoJsonError> {
        let mut rings = Vec::with_capacity(polygon.rings.len());
        for (i, ring) in polygon.rings.iter().enumerate() {
            let points: Vec<DVec2> = ring
                .iter()
                .map(|p| self.metres(polygon.feature, p[0], p[1]))
                .collect::<Result<_, _>>()?;
            if has_three(&points) {
                rings.push(points);
                continue;
            }
            skipped.rings += 1;
            if i == 0 {
                return Ok(None);
            }
        }
        let mut rings = rings.into_iter();
        Ok(rings.next().map(|outer| Footprint {
            outer,
            holes: rings.collect(),
            material: None,
        }))
    }

    fn metres(&self, feature: usize, x: f64, y: f64) -> Result<DVec2, GeoJsonError> {
        let wrong = |expected| GeoJsonError::Coordinate {
            feature,
            x,
            y,
            expected,
        };
        let p = match self {
            Self::Plane(plane) => {
                if !(x.abs() <= 180.0 && y.abs() <= 90.0) {
                    return Err(wrong("longitude and latitude"));
                }
                let [longitude, latitude] = plane.origin_deg();
                let distance_deg = (x - longitude).abs().max((y - latitude).abs());
                if distance_deg > LocalPlane::REACH_DEG || y.abs() > 89.0 {
                    return Err(GeoJsonError::TooLarge {
                        feature,
                        distance_deg,
                        limit_deg: LocalPlane::REACH_DEG,
                    });
                }
                plane.project(x, y)
            }
            Self::Shift(origin) => {
                if !(x.abs() <= MAX_METRES && y.abs() <= MAX_METRES) {
                    return Err(wrong("position in metres"));
                }
                DVec2::new(x, y) - *origin
            }
        };
        Ok((p * PARTS_PER_METRE).round() / PARTS_PER_METRE)
    }
}

fn has_three(points: &[DVec2]) -> bool {
    let second = points.iter().find(|&&p| p != points[0]);
    second.is_some_and(|b| points.iter().any(|p| p != &points[0] && p != b))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str =
        "[[24.945,60.168],[24.946,60.168],[24.946,60.1685],[24.945,60.1685],[24.945,60.168]]";

    fn parse(text: &str) -> Result<GeoJsonCity, GeoJsonError> {
        parse_geojson(text, &GeoJsonConfig::default())
    }

    fn feature(tags: &str, geometry: &str, coordinates: &str) -> String {
        format!(
            r#"{{"type":"Feature","properties":{{{tags}}},"geometry":{{"type":"{geometry}","coordinates":{coordinates}}}}}"#
        )
    }

    fn collection(features: &[String]) -> String {
        format!(
            r#"{{"type":"FeatureCollection","features":[{}]}}"#,
            features.join(",")
        )
    }

    #[test]
    fn only_buildings_with_walls_count() {
        let ring = format!("[{SQUARE}]");
        let with = |tags: &str| feature(tags, "Polygon", &ring);
        let city = parse(&collection(&[
            with(r#""building":"yes""#),
            with(r#""building":"no""#),
            with(r#""building":"roof""#),
            with(r#""building":null"#),
            with(r#""building:part":"yes""#),
            with(r#""building":"garage","layer":"-1""#),
            with(r#""building":"yes","location":"underground""#),
            with(r#""building":"hotel","layer":1"#),
            feature(r#""building":"yes""#, "Point", "[24.945,60.168]"),
            feature(r#""highway":"residential""#, "LineString", SQUARE),
        ]))
        .unwrap();
        assert_eq!(city.footprints.len(), 2);
        let expected = Skipped {
            features: 7,
            without_area: 1,
            rings: 0,
        };
        assert_eq!(city.skipped, expected);
    }

    #[test]
    fn multipolygons_and_collections_are_taken_apart_and_holes_kept() {
        let yard = "[[24.9452,60.1681],[24.9458,60.1681],[24.9458,60.1684],[24.9452,60.1681]]";
        let multi = feature(
            r#""building":"yes""#,
            "MultiPolygon",
            &format!("[[{SQUARE},{yard}],[{SQUARE}]]"),
        );
        let inner = format!(r#"{{"type":"Polygon","coordinates":[{SQUARE}]}}"#);
        let nested = format!(
            r#"{{"type":"Feature","properties":{{"building":"yes"}},"geometry":{{"type":"GeometryCollection",
            "geometries":[{inner},{{"type":"GeometryCollection","geometries":[{inner}]}}]}}}}"#
        );
        let city = parse(&collection(&[multi, nested])).unwrap();
        let holes: Vec<usize> = city.footprints.iter().map(|f| f.holes.len()).collect();
        assert_eq!(holes, [1, 0, 0, 0]);
    }

    #[test]
    fn rings_without_area_are_passed_over() {
        let flat = "[[24.945,60.168],[24.946,60.168],[24.945,60.168]]";
        let yes = r#""building":"yes""#;
        let city = parse(&collection(&[
            feature(yes, "Polygon", &format!("[{flat}]")),
            feature(yes, "Polygon", &format!("[{SQUARE},{flat},[]]")),
            feature(yes, "Polygon", "[]"),
        ]))
        .unwrap();
        assert_eq!((city.footprints.len(), city.skipped.rings), (1, 3));
        assert!(city.footprints[0].holes.is_empty());
    }

    #[test]
    fn metres_are_told_from_degrees() {
        let yes = r#""building":"yes""#;
        let metric = feature(
            yes,
            "Polygon",
            "[[[385000.5,6671000],[385010,6671000],[385010,6671010]]]",
        );
        let city = parse(&metric).unwrap();
        assert_eq!(city.coordinates, Coordinates::Metres);
        assert_eq!(city.footprints[0].outer[0].x + city.origin[0], 385_000.5);
        let small = feature(yes, "Polygon", "[[[0,0],[50,0],[50,30]]]");
        assert!(matches!(parse(&small), Err(GeoJsonError::TooLarge { .. })));
        let config = GeoJsonConfig {
            coordinates: Coordinates::Metres,
            ..GeoJsonConfig::default()
        };
        assert!(parse_geojson(&small, &config).is_ok());
        let config = GeoJsonConfig {
            coordinates: Coordinates::Degrees,
            ..config
        };
        let error = parse_geojson(&metric, &config).unwrap_err().to_string();
        assert!(
            error.contains("feature 0") && error.contains("longitude"),
            "{error}"
        );
    }

    #[test]
    fn files_without_buildings_say_so() {
        let tree = feature(r#""natural":"tree""#, "Point", "[24.9,60.1]");
        assert_eq!(
            parse(&collection(&[tree])),
            Err(GeoJsonError::NoTag { features: 1 })
        );
        let none = feature(r#""building":"no""#, "Polygon", &format!("[{SQUARE}]"));
        assert_eq!(parse(&none), Err(GeoJsonError::NoBuilding { features: 1 }));
        let bare = format!(r#"{{"type":"Polygon","coordinates":[{SQUARE}]}}"#);
        assert_eq!(parse(&bare), Err(GeoJsonError::NoTag { features: 1 }));
        let config = GeoJsonConfig {
            all_polygons: true,
            ..GeoJsonConfig::default()
        };
        assert_eq!(parse_geojson(&bare, &config).unwrap().footprints.len(), 1);
        let short = feature(r#""building":"yes""#, "Polygon", "[[[1,2],[1]]]");
        assert_eq!(parse(&short), Err(GeoJsonError::Position { feature: 0 }));
        for text in ["", "[]", "{}", r#"{"type":"Polygon"}"#] {
            assert!(
                matches!(parse(text), Err(GeoJsonError::Syntax { .. })),
                "{text}"
            );
        }
    }
}
