//! Reading, writing and comparing JSON.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::Serialize;
use serde_json::Value;

use crate::error::{Difference, Error, at};

/// Largest manifest read \[bytes\]; that of 51 maps has some 200 kB.
const MAX_BYTES: u64 = 256 << 20;

/// Reads a whole file after a look at its size.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, Error> {
    let file = File::open(path).map_err(at(path, "open"))?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(at(path, "read"))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(Error::Damaged {
            path: path.into(),
            problem: "larger than 256 MiB, no manifest is".into(),
        });
    }
    Ok(bytes)
}

/// Encodes JSON as it is stored: indented, one newline at the end.
pub(crate) fn to_bytes(value: &impl Serialize) -> Vec<u8> {
    let mut bytes = serde_json::to_vec_pretty(value).expect("manifests have string keys only");
    bytes.push(b'\n');
    bytes
}

/// Lists the places where two values differ, by path, e.g. `tracer.materials[2]`; `given` is of `b`.
pub fn differences(a: &Value, b: &Value) -> Vec<Difference> {
    fn walk(key: String, a: Option<&Value>, b: Option<&Value>, found: &mut Vec<Difference>) {
        match (a, b) {
            (Some(Value::Object(a)), Some(Value::Object(b))) => {
                let mut names: Vec<&String> = a.keys().chain(b.keys()).collect();
                names.sort_unstable();
                names.dedup();
                let dot = if key.is_empty() { "" } else { "." };
                for name in names {
                    walk(format!("{key}{dot}{name}"), a.get(name), b.get(name), found);
                }
            }
            (Some(Value::Array(a)), Some(Value::Array(b))) => {
                for i in 0..a.len().max(b.len()) {
                    walk(format!("{key}[{i}]"), a.get(i), b.get(i), found);
                }
            }
            (a, b) if a == b => {}
            (a, b) => {
                let text = |value: Option<&Value>| value.map_or("nothing".into(), Value::to_string);
                let (stored, given) = (text(a), text(b));
                found.push(Difference { key, stored, given });
            }
        }
    }
    let mut found = Vec::new();
    walk(String::new(), Some(a), Some(b), &mut found);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn differences_are_named_by_their_paths() {
        let a = json!({"tracer": {"max_reflections": 2, "materials": [1, 2]}, "seed": 1});
        let b = json!({"tracer": {"max_reflections": 3, "materials": [1]}, "seed": 1});
        let difference = |[key, stored, given]: [&str; 3]| Difference {
            key: key.into(),
            stored: stored.into(),
            given: given.into(),
        };
        let expected = [
            ["tracer.materials[1]", "2", "nothing"],
            ["tracer.max_reflections", "2", "3"],
        ];
        assert_eq!(differences(&a, &b), expected.map(difference));
        assert!(differences(&a, &a).is_empty());
    }
}
