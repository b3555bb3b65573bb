//! `data-spec/` of the workspace describes what is really written.

use std::collections::BTreeSet;
use std::fs;

use aps_data::LinkStatus;
use serde_json::Value;

use crate::sample;

fn spec(name: &str) -> String {
    let path = format!("{}/../../data-spec/{name}", env!("CARGO_MANIFEST_DIR"));
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Checks the keywords of JSON Schema that ours uses, `pattern` excepted; unknown ones are refused.
fn check(value: &Value, schema: &Value, root: &Value, at: &str) {
    for (keyword, rule) in schema.as_object().unwrap() {
        match keyword.as_str() {
            "$schema" | "$defs" | "title" | "description" | "pattern" => {}
            "$ref" => {
                let target = root.pointer(rule.as_str().unwrap().strip_prefix('#').unwrap());
                let target = target.unwrap_or_else(|| panic!("{rule} leads nowhere"));
                check(value, target, root, at);
            }
            "const" => assert_eq!(value, rule, "{at}"),
            "enum" => assert!(
                rule.as_array().unwrap().contains(value),
                "{at}: {value} is not in {rule}"
            ),
            "type" => {
                let name = match value {
                    Value::Null => "null",
                    Value::Bool(_) => "boolean",
                    Value::Number(number) if number.is_u64() || number.is_i64() => "integer",
                    Value::Number(_) => "number",
                    Value::String(_) => "string",
                    Value::Array(_) => "array",
                    Value::Object(_) => "object",
                };
                let allowed: Vec<&str> = match rule {
                    Value::Array(names) => {
                        names.iter().map(|name| name.as_str().unwrap()).collect()
                    }
                    name => vec![name.as_str().unwrap()],
                };
                assert!(allowed.contains(&name), "{at}: {value} is not {rule}");
            }
            "minimum" => assert!(
                value.is_null() || value.as_f64() >= rule.as_f64(),
                "{at}: {value} < {rule}"
            ),
            "maximum" => assert!(value.as_f64() <= rule.as_f64(), "{at}: {value} > {rule}"),
            "exclusiveMinimum" => {
                assert!(value.as_f64() > rule.as_f64(), "{at}: {value} <= {rule}")
            }
            "uniqueItems" => {
                let items = value.as_array().unwrap();
                let distinct: BTreeSet<String> = items.iter().map(Value::to_string).collect();
                assert_eq!(distinct.len(), items.len(), "{at}");
            }
            "items" => {
                for (i, item) in value.as_array().unwrap().iter().enumerate() {
                    check(item, rule, root, &format!("{at}[{i}]"));
                }
            }
            "properties" => {
                for (key, rule) in rule.as_object().unwrap() {
                    if let Some(value) = value.get(key) {
                        check(value, rule, root, &format!("{at}.{key}"));
                    }
                }
            }
            "required" => {
                let Some(object) = value.as_object() else {
                    continue;
                };
                for key in rule.as_array().unwrap() {
                    assert!(
                        object.contains_key(key.as_str().unwrap()),
                        "{at} has no {key}"
                    );
                }
            }
            "additionalProperties" => {
                let known = &schema["properties"];
                for (key, value) in value.as_object().into_iter().flatten() {
                    if known.get(key).is_none() {
                        assert!(rule.is_object(), "{at}.{key} is not in the schema");
                        check(value, rule, root, &format!("{at}.{key}"));
                    }
                }
            }
            _ => panic!("keyword {keyword} is not known to this test"),
        }
    }
}

#[test]
fn manifests_follow_the_schema() {
    let schema: Value = serde_json::from_str(&spec("manifest.schema.json")).unwrap();
    let root = sample::written();
    let read =
        |name: &str| serde_json::from_slice(&fs::read(root.path().join(name)).unwrap()).unwrap();
    let manifest: Value = read("manifest.json");
    check(&manifest, &schema, &schema, "manifest.json");
    check(
        &read("map_0001/map.json"),
        &schema["$defs"]["map_manifest"],
        &schema,
        "map.json",
    );
}

#[test]
fn plans_follow_the_schema() {
    let schema: Value = serde_json::from_str(&spec("manifest.schema.json")).unwrap();
    let root = tempfile::tempdir().unwrap();
    let writer = aps_data::DatasetWriter::open(root.path(), sample::config()).unwrap();
    let plan = aps_data::Plan {
        maps: vec![0, 3],
        shards: Some(2),
        command: vec!["dataset".into()],
    };
    writer.set_plan(&plan).unwrap();
    let bytes = fs::read(root.path().join("plan.json")).unwrap();
    let plan: Value = serde_json::from_slice(&bytes).unwrap();
    check(&plan, &schema["$defs"]["plan"], &schema, "plan.json");
}

#[test]
fn schema_requires_every_key_it_knows() {
    fn walk(schema: &Value) {
        if let (Some(known), Some(required)) = (schema.get("properties"), schema.get("required")) {
            let known = known.as_object().unwrap().keys().map(String::as_str);
            let required = required.as_array().unwrap().iter();
            let required: BTreeSet<&str> = required.filter_map(Value::as_str).collect();
            assert_eq!(known.collect::<BTreeSet<_>>(), required);
        }
        let parts = schema["$defs"].as_object().into_iter().flatten();
        parts.for_each(|(_, schema)| walk(schema));
    }
    walk(&serde_json::from_str(&spec("manifest.schema.json")).unwrap());
}

/// The cells of the page's table rows.
fn table_rows(page: &str) -> Vec<Vec<String>> {
    let cells = |line: &str| {
        let line = line.replace("\\|", "\u{0}");
        let cell = |cell: &str| {
            cell.replace('\u{0}', "|")
                .trim()
                .trim_matches('`')
                .to_owned()
        };
        line.split('|').map(cell).collect()
    };
    let rows = page.lines().filter(|line| line.starts_with("| "));
    rows.map(cells).collect()
}

#[test]
fn page_lists_every_array_with_its_type_and_shape() {
    let mut config = sample::config();
    config.layout.pdp.as_mut().unwrap().dtype = aps_data::Precision::F16;
    let root = tempfile::tempdir().unwrap();
    let writer = aps_data::DatasetWriter::open(root.path(), config).unwrap();
    sample::write_map(&writer, 0, 1).unwrap();
    let manifest = writer.finish(&aps_data::Split::of_maps([0], 0)).unwrap();
    let map = &manifest.maps[0];
    let letter = |n: usize| match n {
        n if n == sample::GRID.width => "W",
        n if n == sample::GRID.height => "H",
        n if n == map.rx => "R",
        n if n == map.links => "L",
        n if n == map.links + 1 => "L + 1",
        n if n == map.paths + 1 => "P + 1",
        n if n == map.paths => "P",
        n if n == map.interactions => "I",
        sample::ANGLES => "A",
        sample::DELAYS => "D",
        2 => "2", // of a point, and the number of transmitters
        _ => panic!("{n} could be anything"),
    };
    let told = |file: &aps_data::FileEntry| -> (String, String, String) {
        let axes: Vec<&str> = file.shape.iter().map(|&n| letter(n)).collect();
        let shape = match axes[..] {
            [only] => format!("({only},)"),
            _ => format!("({})", axes.join(", ")),
        };
        let name = file.name.trim_end_matches(".npy");
        (name.into(), file.dtype.clone(), shape)
    };
    let written: Vec<(String, String, String)> = map.files.iter().map(told).collect();
    let listed: Vec<(String, String, String)> = table_rows(&spec("README.md"))
        .into_iter()
        .filter(|row| row[2].starts_with(['<', '|']) && row[3].starts_with('('))
        .map(|row| (row[1].clone(), row[2].clone(), row[3].replace('T', "2")))
        .collect();
    assert_eq!(written, listed);
}

#[test]
fn page_lists_every_status() {
    let page = spec("README.md");
    let rows = table_rows(&page);
    for status in LinkStatus::KNOWN {
        let row = rows
            .iter()
            .find(|row| row[1] == status.code().to_string() && row[2] == status.to_string());
        assert!(row.is_some(), "{status} is not described");
    }
}
