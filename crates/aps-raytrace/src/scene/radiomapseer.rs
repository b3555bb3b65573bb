//! Footprints in the format of the RadioMapSeer data set: a JSON list of polygons, each a closed
//! list of `[x, y]` in metres.

use glam::DVec2;
use serde_json::Value;

use super::footprint::Footprint;
use crate::error::SceneError;
use crate::text;

/// Reads RadioMapSeer footprints.
///
/// # Errors
/// [`SceneError::Syntax`] for text that is not JSON in UTF-8, [`SceneError::Shape`] naming the first
/// building and vertex of another shape. Geometry is checked later, by the scene.
///
/// ```
/// let text = r#"[[[0, 0], [10, 0], [10, 8], [0, 8], [0, 0]]]"#;
/// let buildings = aps_raytrace::scene::parse_radiomapseer(text)?;
/// assert_eq!(buildings[0].outer.len(), 5);
/// # Ok::<(), aps_raytrace::SceneError>(())
/// ```
pub fn parse_radiomapseer(text: impl AsRef<[u8]>) -> Result<Vec<Footprint>, SceneError> {
    let syntax = |reason| SceneError::Syntax { reason };
    let text = text::of_json(text.as_ref()).map_err(syntax)?;
    let root: Value =
        serde_json::from_str(&text).map_err(|e| syntax(text::json_error(&text, &e)))?;
    let polygons = root.as_array().ok_or_else(|| SceneError::Shape {
        place: "top level".into(),
        expected: match root.get("type") {
            Some(_) => "a list of polygons, not GeoJSON, which is a map source of its own",
            None => "a list of polygons",
        },
    })?;
    polygons
        .iter()
        .enumerate()
        .map(|(building, polygon)| parse_polygon(building, polygon).map(Footprint::new))
        .collect()
}

fn parse_polygon(building: usize, polygon: &Value) -> Result<Vec<DVec2>, SceneError> {
    let vertices = polygon.as_array().ok_or_else(|| SceneError::Shape {
        place: format!("building {building}"),
        expected: "a list of vertices",
    })?;
    vertices
        .iter()
        .enumerate()
        .map(|(vertex, pair)| {
            let numbers = pair.as_array().map(Vec::as_slice);
            match numbers {
                Some([x, y]) => x.as_f64().zip(y.as_f64()).map(DVec2::from),
                _ => None,
            }
            .ok_or_else(|| SceneError::Shape {
                place: format!("building {building}, vertex {vertex}"),
                expected: "two numbers [x, y]",
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_error(text: &str, expected: &str) {
        let message = parse_radiomapseer(text).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }

    #[test]
    fn byte_order_mark_is_no_part_of_the_text() {
        let buildings = parse_radiomapseer("\u{feff}[[[0,0],[1,0],[1,1]]]").unwrap();
        assert_eq!(buildings.len(), 1);
    }

    #[test]
    fn errors_name_building_and_vertex() {
        check_error("[[[0, 0], [1, 0]", "not valid JSON");
        check_error("{}", "top level");
        check_error(r#"{"type": "FeatureCollection"}"#, "not GeoJSON");
        check_error("", "empty");
        check_error("[[[0, NaN]]]", "NaN at line 1 column 7");
        check_error("[3]", "building 0");
        check_error("[[[0,0],[1,0],[1,1]], [[0,0],[1]]]", "building 1, vertex 1");
        check_error(r#"[[[0,0],[1,"a"]]]"#, "building 0, vertex 1");
        check_error("[[[0,0],[1,2,3]]]", "building 0, vertex 1");
    }
}
