//! From a text to its features, whatever holds them: a collection, a feature, a bare geometry, or several of these in a
//! row, one a line (GeoJSONL) or as a text sequence (RFC 8142).

use serde_json::{Deserializer, Map, Value};

use super::GeoJsonError;
use super::crs::Crs;
use crate::text;

/// One feature of a file.
pub(super) struct Feature {
    properties: Value,
    /// An object, or null.
    pub(super) geometry: Value,
    /// Reference system that the feature names, or the object that holds it.
    pub(super) crs: Option<Crs>,
}

impl Feature {
    /// The value of a tag: a property, or a member of `tags` among the properties, where exports of Overpass keep them.
    pub(super) fn tag(&self, key: &str) -> Option<&Value> {
        let nested = self.properties.get("tags");
        let tags = [Some(&self.properties), nested].into_iter().flatten();
        let mut values = tags.filter_map(|tags| tags.get(key));
        values.find(|value| !value.is_null())
    }
}

/// The features of a text in their order.
pub(super) fn features(text: &[u8]) -> Result<Vec<Feature>, GeoJsonError> {
    let text = text::of_json(text).map_err(syntax)?;
    let mut features = Vec::new();
    for document in Deserializer::from_str(&text).into_iter::<Value>() {
        let document = document.map_err(|e| syntax(text::json_error(&text, &e)))?;
        add(document, &mut features)?;
    }
    Ok(features)
}

fn add(document: Value, features: &mut Vec<Feature>) -> Result<(), GeoJsonError> {
    let Value::Object(mut document) = document else {
        return Err(syntax("expected an object with a `type`".into()));
    };
    let crs = Crs::of(&document)?;
    match kind(&document) {
        Some("FeatureCollection") => {
            let Some(Value::Array(members)) = document.remove("features") else {
                return Err(syntax("a FeatureCollection without `features`".into()));
            };
            features.reserve(members.len());
            for member in members {
                match member {
                    Value::Object(f) if kind(&f) == Some("Feature") => {
                        features.push(feature(f, crs)?)
                    }
                    _ => {
                        let place = features.len();
                        return Err(syntax(format!("feature {place} is not of type Feature")));
                    }
                }
            }
        }
        Some("Feature") => features.push(feature(document, crs)?),
        Some(
            "Point" | "MultiPoint" | "LineString" | "MultiLineString" | "Polygon" | "MultiPolygon"
            | "GeometryCollection",
        ) => {
            let geometry = document.into();
            features.push(Feature {
                properties: Value::Null,
                crs: crs_within(&geometry)?,
                geometry,
            });
        }
        Some(other) => return Err(syntax(format!("a {other} is no object of GeoJSON"))),
        None => return Err(syntax("expected an object with a `type`".into())),
    }
    Ok(())
}

fn kind(object: &Map<String, Value>) -> Option<&str> {
    object.get("type")?.as_str()
}

fn feature(mut members: Map<String, Value>, outer: Option<Crs>) -> Result<Feature, GeoJsonError> {
    let own = Crs::of(&members)?;
    let geometry = members.remove("geometry").unwrap_or_default();
    let inner = crs_within(&geometry)?;
    Ok(Feature {
        properties: members.remove("properties").unwrap_or_default(),
        crs: inner.or(own).or(outer),
        geometry,
    })
}

/// The coordinate system that a geometry names, or one of those in a collection.
fn crs_within(geometry: &Value) -> Result<Option<Crs>, GeoJsonError> {
    let Some(object) = geometry.as_object() else {
        return Ok(None);
    };
    let mut found = Crs::of(object)?;
    let members = object.get("geometries").and_then(Value::as_array);
    for inner in members.into_iter().flatten() {
        let Some(own) = crs_within(inner)? else {
            continue;
        };
        if let Some(other) = found.replace(own)
            && other != own
        {
            let reason = format!("a geometry is in {own}, what holds it in {other}");
            return Err(syntax(reason));
        }
    }
    Ok(found)
}

pub(super) fn syntax(reason: String) -> GeoJsonError {
    GeoJsonError::Syntax { reason }
}
