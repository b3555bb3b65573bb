//! Polygons out of a geometry.

use serde_json::Value;

use super::GeoJsonError;
use super::document::syntax;

/// The rings of one polygon as they are written, and the feature they are from.
pub(super) struct Polygon {
    pub(super) feature: usize,
    /// At least one, each with at least one position.
    pub(super) rings: Vec<Vec<[f64; 2]>>,
}

/// Collects the polygons of a geometry, also those inside collections; returns how many empty lists stood beside them in
/// place of rings and polygons. Nesting is as deep as the parser allowed, a hundred levels.
pub(super) fn collect(
    feature: usize,
    geometry: &Value,
    polygons: &mut Vec<Polygon>,
) -> Result<usize, GeoJsonError> {
    let list = |value| list(feature, value);
    let mut empty = 0;
    match geometry.get("type").and_then(Value::as_str) {
        Some("Polygon") => empty += polygon(feature, list(&geometry["coordinates"])?, polygons)?,
        Some("MultiPolygon") => {
            for rings in list(&geometry["coordinates"])? {
                let rings = list(rings)?;
                empty += usize::from(rings.is_empty()) + polygon(feature, rings, polygons)?;
            }
        }
        Some("GeometryCollection") => {
            for geometry in list(&geometry["geometries"])? {
                empty += collect(feature, geometry, polygons)?;
            }
        }
        _ => {}
    }
    Ok(empty)
}

fn polygon(
    feature: usize,
    rings: &[Value],
    polygons: &mut Vec<Polygon>,
) -> Result<usize, GeoJsonError> {
    let position = |value: &Value| {
        let number = |i: usize| value.get(i).and_then(Value::as_f64);
        let both = number(0).zip(number(1));
        both.map(<[f64; 2]>::from)
            .ok_or(GeoJsonError::Position { feature })
    };
    let mut kept = Vec::with_capacity(rings.len());
    for (i, ring) in rings.iter().enumerate() {
        match list(feature, ring)? {
            // Without its outer ring a polygon is nothing.
            [] if i == 0 => return Ok(1),
            [] => {}
            ring => kept.push(ring.iter().map(position).collect::<Result<_, _>>()?),
        }
    }
    let empty = rings.len() - kept.len();
    if !kept.is_empty() {
        polygons.push(Polygon {
            feature,
            rings: kept,
        });
    }
    Ok(empty)
}

fn list(feature: usize, value: &Value) -> Result<&[Value], GeoJsonError> {
    let list = value.as_array().map(Vec::as_slice);
    list.ok_or_else(|| {
        syntax(format!(
            "feature {feature}: expected a list in its geometry"
        ))
    })
}
