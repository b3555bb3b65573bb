//! The `crs` member: the reference system of a file's numbers.
//!
//! RFC 7946 has no such member, its numbers are longitude and latitude of WGS 84; the format of 2008 has, and GIS programs
//! still write it. It is read wherever it stands: at a collection, a feature or a geometry. Whatever it says, the order is
//! that of GeoJSON: east before north.

use std::fmt;

use serde_json::{Map, Value};

use super::GeoJsonError;
use super::projected;

/// A reference system that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Crs {
    /// Longitude and latitude \[deg\], by the name given: WGS 84, or ETRS89, the same to a metre.
    Degrees(&'static str),
    /// EPSG:3857, metres stretched by 1 / cos(latitude).
    WebMercator,
    /// UTM by its EPSG code: of WGS 84 (326xx north, 327xx south), or ETRS89 (258xx).
    Utm(u16),
    /// `null`: said to be unknown.
    Unknown,
}

impl Crs {
    /// The system that RFC 7946 has.
    pub(super) const CRS84: Self = Self::Degrees("OGC:CRS84");

    /// Reads the `crs` member of an object; `None` without one.
    pub(super) fn of(object: &Map<String, Value>) -> Result<Option<Self>, GeoJsonError> {
        let Some(member) = object.get("crs") else {
            return Ok(None);
        };
        if member.is_null() {
            return Ok(Some(Self::Unknown));
        }
        let properties = &member["properties"];
        let name = member.as_str().or(properties["name"].as_str());
        let name = match (name, &properties["code"]) {
            (Some(name), _) => name.to_owned(),
            (None, Value::Null) => member.to_string(),
            // A form older than 2008: {"type": "EPSG", "properties": {"code": 4326}}.
            (None, code) => format!("EPSG:{}", code.to_string().trim_matches('"')),
        };
        match Self::named(&name) {
            Some(crs) => Ok(Some(crs)),
            None => Err(GeoJsonError::Crs {
                crs: name.chars().take(200).collect(),
            }),
        }
    }

    /// Finds a system by a name like `EPSG:3857`, a URN or a URL.
    fn named(name: &str) -> Option<Self> {
        let parts = name.split([':', '/', '#']).map(str::trim);
        let parts: Vec<String> = parts.map(str::to_ascii_uppercase).collect();
        let code = parts.last()?.as_str();
        if matches!(code, "CRS84" | "CRS84H" | "WGS84" | "WGS 84") {
            return Some(Self::CRS84);
        }
        let has = |authority| parts.iter().any(|part| part.starts_with(authority));
        match code.parse().ok()? {
            // Numbers that ESRI and others gave it before EPSG did.
            102_100 | 900_913 => Some(Self::WebMercator),
            _ if !has("EPSG") => None,
            4326 => Some(Self::Degrees("EPSG:4326")),
            4979 => Some(Self::Degrees("EPSG:4979")),
            4258 => Some(Self::Degrees("EPSG:4258")),
            3857 => Some(Self::WebMercator),
            code @ (32_601..=32_660 | 32_701..=32_760 | 25_828..=25_838) => {
                Some(Self::Utm(u16::try_from(code).ok()?))
            }
            _ => None,
        }
    }

    /// Returns true when coordinates in both systems mean the same.
    pub(super) fn agrees(self, other: Self) -> bool {
        self == other || matches!((self, other), (Self::Degrees(_), Self::Degrees(_)))
    }

    /// Longitude and latitude of a position \[deg\]; `None` for numbers that are no position in it.
    pub(super) fn degrees(self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        match self {
            Self::Degrees(_) | Self::Unknown => Some([x, y]),
            Self::WebMercator => projected::from_web_mercator(x, y),
            Self::Utm(code) => projected::from_utm(
                u32::from(code % 100),
                (32_700..32_800).contains(&code),
                x,
                y,
            ),
        }
    }
}

impl fmt::Display for Crs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Degrees(name) => f.write_str(name),
            Self::WebMercator => f.write_str("EPSG:3857"),
            Self::Utm(code) => write!(f, "EPSG:{code}"),
            Self::Unknown => f.write_str("null"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn read(member: &str) -> Result<Option<Crs>, GeoJsonError> {
        let object = format!(r#"{{"crs": {member}}}"#);
        Crs::of(&serde_json::from_str(&object).unwrap())
    }

    fn named(name: &str) -> Result<Option<Crs>, GeoJsonError> {
        read(&format!(
            r#"{{"type":"name","properties":{{"name":"{name}"}}}}"#
        ))
    }

    #[test]
    fn one_system_has_many_names() {
        for name in [
            "urn:ogc:def:crs:OGC:1.3:CRS84",
            "urn:ogc:def:crs:OGC::CRS84",
            "OGC:CRS84",
            "http://www.opengis.net/def/crs/OGC/1.3/CRS84",
            "EPSG:4326",
            "epsg:4326",
            "urn:ogc:def:crs:EPSG::4326",
            "urn:ogc:def:crs:EPSG:6.9:4326",
            "urn:x-ogc:def:crs:EPSG:4326",
            "http://www.opengis.net/def/crs/EPSG/0/4326",
            "http://www.opengis.net/gml/srs/epsg.xml#4326",
        ] {
            let crs = named(name).unwrap().unwrap();
            assert!(crs.agrees(Crs::CRS84), "{name}");
        }
        for name in [
            "EPSG:3857",
            "urn:ogc:def:crs:EPSG::3857",
            "EPSG:900913",
            "ESRI:102100",
        ] {
            assert_eq!(named(name), Ok(Some(Crs::WebMercator)), "{name}");
        }
        assert_eq!(
            named("urn:ogc:def:crs:EPSG::25832"),
            Ok(Some(Crs::Utm(25832)))
        );
        assert_eq!(read(r#""EPSG:32733""#), Ok(Some(Crs::Utm(32733))));
        let old = r#"{"type":"EPSG","properties":{"code":32633}}"#;
        assert_eq!(read(old), Ok(Some(Crs::Utm(32633))));
        assert_eq!(read("null"), Ok(Some(Crs::Unknown)));
    }

    #[test]
    fn others_are_refused_by_name() {
        for name in [
            "urn:ogc:def:crs:EPSG::2263",
            "EPSG:32661",
            "EPSG:27700",
            "ESRI:4326",
            "NAD83",
            "",
            "urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::5783",
        ] {
            let error = named(name).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains("ogr2ogr"), "{error}");
        }
        let link = r#"{"type":"link","properties":{"href":"http://example.com/crs/42"}}"#;
        let error = read(link).unwrap_err().to_string();
        assert!(error.contains("example.com"), "{error}");
        for odd in [
            "7",
            "[]",
            "{}",
            r#"{"type":"name","properties":{"name":4326}}"#,
        ] {
            assert!(matches!(read(odd), Err(GeoJsonError::Crs { .. })), "{odd}");
        }
    }
}
