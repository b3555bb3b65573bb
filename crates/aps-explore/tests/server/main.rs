//! The server over its socket.

mod client;
mod refusals;

use std::cmp::Reverse;

use aps_raytrace::TraceConfig;
use map2aps::aps_model::ModelKind;
use map2aps::aps_model::weights::Shipped;
use map2aps::maps::{TileSettings, load_file};
use map2aps::path_list::LinkList;
use map2aps::{MapSource, SceneSettings};
use serde_json::{Value, json};

use client::{
    Answer, cells, changed, get, post, post_from, question, start, start_with, traced, traced_in,
    traced_with,
};

/// The powers of a curve \[dB\].
fn levels(curve: &Value) -> Vec<f64> {
    let levels = curve["aps_db"].as_array().unwrap().iter();
    levels.map(|level| level.as_f64().unwrap()).collect()
}

/// The command lines that give the same link.
fn command(port: u16, question: &Value) -> Answer {
    post(port, "/api/file/command", question)
}

#[test]
fn page_and_its_files_load_nothing_from_elsewhere() {
    let port = start();
    let page = get(port, "/");
    assert_eq!(page.status, 200);
    for header in [
        "content-security-policy: default-src 'none'; script-src 'self'",
        "frame-ancestors 'none'",
        "cross-origin-resource-policy: same-origin",
        "x-content-type-options: nosniff",
    ] {
        assert!(page.head.contains(header), "{}", page.head);
    }
    let text = page.text();
    assert!(!text.contains("://"), "an address in the page");
    let is_file = |part: &&str| part.starts_with('/') && part.ends_with(['s', '/']);
    for part in text.split('"').filter(is_file) {
        let file = get(port, part);
        assert_eq!(file.status, 200, "{part}");
        let foreign = file.text().replace("http://www.w3.org/2000/svg", "");
        assert!(!foreign.contains("://"), "{part}");
    }
    for path in [
        "/../Cargo.toml",
        "/%2e%2e/main.rs",
        "//",
        "/api",
        "/api/file/",
        "/api/file/map/..",
    ] {
        assert_eq!(get(port, path).status, 404, "{path}");
    }
}

#[test]
fn link_is_the_one_that_the_tracer_gives() {
    let port = start();
    for map in [0, 2] {
        let question = question(port, map);
        let answer = post(port, "/api/link", &question).json();
        assert_eq!(answer["link"], traced(&question));
        assert_eq!(answer["spectrum"]["aps_db"].as_array().unwrap().len(), 180);
        assert_eq!(answer["other"]["protocol"], "released");
        // Asked again, what was prepared gives the same.
        let again = post(port, "/api/link", &question).json();
        assert_eq!(answer["link"], again["link"]);
        assert_eq!(answer["lobes"], again["lobes"]);
    }
}

#[test]
fn turned_array_sees_the_same_paths_turned() {
    let port = start();
    let mut question = question(port, 0);
    question["label"]["array"] = "uca".into();
    let straight = post(port, "/api/link", &question).json();
    question["label"]["heading_deg"] = 90.0.into();
    let turned = post(port, "/api/link", &question).json();
    assert_eq!(straight["link"], turned["link"]);
    assert_eq!(turned["turn_deg"], 90.0);
    // A circle of 16 looks the same after a quarter turn.
    let [a, b] = [straight, turned].map(|answer| levels(&answer["spectrum"]));
    for i in 0..180 {
        assert!((a[(i + 45) % 180] - b[i]).abs() <= 0.011, "{i}");
    }
}

#[test]
fn comparison_of_the_reference_limits_with_themselves_finds_no_error() {
    let port = start();
    let mut question = question(port, 1);
    let default = post(port, "/api/compare", &question).json();
    assert!(default["error_db"]["mean"].as_f64().unwrap() > 0.0);
    assert!(default["own"]["times_us"]["rx"].as_f64().unwrap() > 0.0);
    question["trace"]["reflections"] = 5.into();
    question["trace"]["diffractions"] = 2.into();
    question["trace"]["dynamic_range_db"] = 30.0.into();
    let reference = post(port, "/api/compare", &question).json();
    assert_eq!(reference["error_db"], json!({ "mean": 0.0, "worst": 0.0 }));
}

#[test]
fn pages_that_ask_for_the_same_at_once_all_have_their_answer() {
    for map in 0..3 {
        let port = start();
        let question = question(port, map);
        let cells = cells(&question, "error", 32.0);
        let [question, cells] = [question, cells].map(|q| q.to_string());
        let answers = std::thread::scope(|scope| {
            let ask = |page| {
                let (question, cells) = (&question, &cells);
                scope.spawn(move || {
                    let compare = || post_from(page, port, "/api/compare", question).json();
                    let survey = || post_from(page, port, "/api/coverage", cells).body;
                    let (answer, coverage) = match page % 2 {
                        0 => (compare(), survey()),
                        _ => {
                            let coverage = survey();
                            (compare(), coverage)
                        }
                    };
                    (answer["error_db"].clone(), coverage)
                })
            };
            let asked: Vec<_> = (0..8).map(ask).collect();
            let answers = asked.into_iter().map(|page| page.join().unwrap());
            answers.collect::<Vec<_>>()
        });
        let first = &answers[0];
        assert!(first.0["mean"].is_number() && first.1.ends_with(b"\n"));
        assert!(answers.iter().all(|answer| answer == first));
    }
}

/// Sets the limits of the labels that the shipped weights learnt.
fn learnt_limits(question: &mut Value) {
    let config = TraceConfig::converged();
    question["trace"]["reflections"] = config.max_reflections.into();
    question["trace"]["diffractions"] = config.max_diffractions.into();
    question["trace"]["dynamic_range_db"] = config.dynamic_range_db.into();
}

#[test]
fn prediction_is_scored_against_the_label_that_is_shown() {
    let port = start();
    let mut question = question(port, 0);
    learnt_limits(&mut question);
    let without = post(port, "/api/link", &question).json();
    assert!(without.get("model").is_none());
    question["model"] = true.into();
    let answer = post(port, "/api/link", &question).json();
    assert_eq!(answer["link"], without["link"]);
    let model = &answer["model"];
    assert_eq!(model["is_foreign"], false);
    let (label, predicted) = (levels(&answer["spectrum"]), levels(&model["curve"]));
    assert_eq!(
        model["curve"]["angles_deg"],
        answer["spectrum"]["angles_deg"]
    );
    let top_db = label.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let power = |db: f64| 10_f64.powf((db - top_db) / 10.0);
    // Normalised errors are those of the share of power over the deviation of the training.
    let shipped = Shipped::of(ModelKind::PolarReg).unwrap();
    let settings: Value = serde_json::from_str(shipped.settings).unwrap();
    let deviation = settings["training_statistics"]["std"].as_f64().unwrap();
    let pairs = label.iter().zip(&predicted);
    let errors = pairs.map(|(&a, &b)| (power(a) - power(b)).abs());
    let mae = errors.sum::<f64>() / 180.0 / deviation;
    let told = model["mae"].as_f64().unwrap();
    assert!((told - mae).abs() < 0.02, "{mae}: {model}");
    assert!(model["cosine"].as_f64().unwrap() > 0.3, "{model}");
    // The next link of the map finds it prepared.
    question["rx"][0] = (question["rx"][0].as_f64().unwrap() + 0.5).into();
    let next = post(port, "/api/link", &question).json();
    assert_eq!(next["model"]["times_us"][1], model["times_us"][1]);
}

#[test]
fn prediction_tells_the_setting_that_it_does_not_know() {
    let port = start();
    let mut asked = question(port, 0);
    asked["model"] = true.into();
    learnt_limits(&mut asked);
    let linear = "a linear array of 16 elements";
    for (pointer, value, told) in [
        ("/label/protocol", json!("released"), "protocol paper"),
        ("/label/array", json!("uca"), linear),
        ("/label/elements", json!(8), linear),
        ("/label/heading_deg", json!(15), "heading 0°"),
        ("/label/sampling_rate_hz", json!(100e6), "200 MHz"),
        ("/trace/frequency_hz", json!(28e9), "3.5 GHz"),
    ] {
        let other = changed(&asked, pointer, value);
        let answer = post(port, "/api/link", &other).json();
        let reason = answer["model"]["reason"].as_str().unwrap();
        assert!(reason.contains(told), "{pointer}: {reason}");
        assert!(answer["model"].get("curve").is_none());
    }
    // Of other limits and walls there is one: what the model gets wrong is to be seen.
    let answer = post(port, "/api/link", &asked).json();
    assert_eq!(answer["model"]["is_foreign"], false);
    for (pointer, value) in [
        ("/trace/reflections", json!(4)),
        ("/trace/material", json!("pec")),
        ("/trace/dynamic_range_db", json!(60.0)),
    ] {
        let other = changed(&asked, pointer, value);
        let answer = post(port, "/api/link", &other).json();
        assert_eq!(answer["model"]["is_foreign"], true, "{pointer}");
        assert!(answer["model"]["cosine"].is_number());
    }
}

#[test]
fn slopes_are_those_of_the_tracer_and_of_the_command_line() {
    let port = start();
    let mut question = question(port, 0);
    question["trace"]["diffractions"] = 2.into();
    question["trace"]["dynamic_range_db"] = json!(null);
    question["trace"]["slope_diffraction"] = false.into();
    let without = post(port, "/api/link", &question).json();
    question["trace"]["slope_diffraction"] = true.into();
    let with = post(port, "/api/link", &question).json();
    assert_ne!(with["link"], without["link"]);
    let config = TraceConfig {
        dynamic_range_db: None,
        slope_diffraction: true,
        ..TraceConfig::within(2, 2)
    };
    assert_eq!(with["link"], traced_with(&question, config));
    let words = command(port, &question).text();
    assert_eq!(words.matches("--slope-diffraction true").count(), 2);
}

#[test]
fn coverage_comes_in_order_and_agrees_with_links() {
    let port = start();
    let mut question = question(port, 0);
    let answer = post(port, "/api/coverage", &cells(&question, "link", 16.0));
    let text = answer.text();
    let lines = text.lines().map(|line| serde_json::from_str(line).unwrap());
    let lines: Vec<Value> = lines.collect();
    let (grid, blocks) = lines.split_first().unwrap();
    assert_eq!(blocks.last().unwrap()["done"], grid["of"]);
    assert!(blocks.is_sorted_by_key(|block| Reverse(block["stride"].as_u64())));
    let columns = grid["columns"].as_u64().unwrap();
    let mut links = 0;
    for block in blocks {
        let cells = block["at"].as_array().unwrap().iter().enumerate();
        for (i, cell) in cells.step_by(7) {
            let cell = cell.as_u64().unwrap();
            let place = |step: u64| 16.0 * (step as f64 + grid["middle"].as_f64().unwrap());
            question["rx"] = json!([place(cell % columns), place(cell / columns)]);
            let answer = post(port, "/api/link", &question);
            if block["paths"][i].is_null() {
                assert_eq!(answer.kind(), "terminal");
                continue;
            }
            let link = answer.json();
            let paths = link["link"]["paths"].as_array().unwrap();
            assert_eq!(block["paths"][i], paths.len());
            match block["level_db"][i].as_f64() {
                Some(level) => {
                    assert!((level + link["path_loss_db"].as_f64().unwrap()).abs() <= 0.051);
                }
                None => assert!(paths.is_empty()),
            }
            links += 1;
        }
    }
    assert!(links > 10, "{links}");
    let mut asked = cells(&question, "error", 16.0);
    let errors = post(port, "/api/coverage", &asked);
    assert!(errors.text().contains("error_db"));
    asked["rx"] = question["rx"].clone();
    assert_eq!(post(port, "/api/coverage", &asked).kind(), "form");
}

#[test]
fn edited_houses_change_the_map_and_the_file_gives_the_same_link() {
    let maps = tempfile::tempdir().unwrap();
    let house = |(x, y): (f64, f64)| {
        let (right, top) = (x + 30.0, y + 20.0);
        [[x, y], [right, y], [right, top], [x, top], [x, y]]
    };
    let corners = [(20.0, 30.0), (80.0, 40.0), (150.0, 60.0), (90.0, 150.0)];
    let houses = json!(corners.map(house));
    std::fs::write(maps.path().join("7.json"), houses.to_string()).unwrap();
    let port = start_with(MapSource::Folder(maps.path().into()));
    let mut question = question(port, 7);
    let before = post(port, "/api/map", &question["city"]).json();
    question["city"]["houses"] = json!({
        "moved": [[0, [-1.0, 2.5]]], "gone": [1, 2],
        "drawn": [[[100.0, 100.0], [120.0, 112.0], [120.0, 100.0], [100.0, 111.0]]],
    });
    let city = post(port, "/api/map", &question["city"]).json();
    assert_eq!(city["as_read"], before["as_read"]);
    let count = |city: &Value| city["houses"].as_array().unwrap().len();
    assert_eq!(count(&city), count(&before) - 1);
    assert_eq!(city["repairs_as_read"], before["repairs"]);
    // The ring crosses itself, which is repaired and told as for files.
    let repairs = city["repairs"].as_str().unwrap();
    assert!(repairs.contains("1 self-intersection"), "{city}");

    for end in ["tx", "rx"] {
        question[end] = city[end].clone();
    }
    let answer = post(port, "/api/link", &question).json();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("map-7.json");
    std::fs::write(&file, post(port, "/api/file/map", &question).body).unwrap();
    let (tiles, settings) = (TileSettings::default(), SceneSettings::default());
    let (scene, _) = load_file(&file, None, tiles, settings).unwrap();
    assert_eq!(scene.report().to_string(), repairs);
    let link = traced_in(&scene, &question, TraceConfig::default());
    assert_eq!(answer["link"], link);
    let words = command(port, &question).text();
    let expected = "cargo xtask trace --format json --map map-7.json --tx";
    assert!(words.starts_with(expected), "{words}");
}

#[test]
fn changed_map_with_courtyards_is_read_back_by_the_command_line() {
    let house = |x: f64, has_court: bool| {
        let square = |x: f64, y: f64, s: f64| {
            json!([[x, y], [x + s, y], [x + s, y + s], [x, y + s], [x, y]])
        };
        let mut rings = vec![square(x, 30.0, 40.0)];
        if has_court {
            rings.push(square(x + 10.0, 40.0, 20.0));
        }
        json!({
            "type": "Feature", "properties": { "building": "yes" },
            "geometry": { "type": "Polygon", "coordinates": rings },
        })
    };
    let houses = [house(20.0, true), house(90.5, false)];
    let city = json!({ "type": "FeatureCollection", "features": houses });
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("city.geojson");
    std::fs::write(&file, city.to_string()).unwrap();
    let tiles = TileSettings {
        metric: true,
        tile_m: 150.0,
        ..TileSettings::default()
    };
    let port = start_with(MapSource::geojson(&file, tiles).unwrap());
    let mut question = question(port, 0);
    question["city"]["houses"] =
        json!({ "moved": [[1, [3.0, -2.0]]], "drawn": [[[5, 90], [50, 90], [50, 100], [5, 100]]] });
    let told = post(port, "/api/map", &question["city"]).json();
    for end in ["tx", "rx"] {
        question[end] = told[end].clone();
    }
    let words = command(port, &question).text();
    let expected = "--map map-0.json --map-id 0 --tile 150 --corner 0,0 --metric";
    assert!(words.contains(expected), "{words}");
    let changed = folder.path().join("map-0.json");
    std::fs::write(&changed, post(port, "/api/file/map", &question).body).unwrap();
    let tiles = TileSettings {
        corner: Some([0.0; 2]),
        ..tiles
    };
    let (scene, _) = load_file(&changed, None, tiles, SceneSettings::default()).unwrap();
    let link = traced_in(&scene, &question, TraceConfig::default());
    let answer = post(port, "/api/link", &question).json();
    assert_eq!(answer["link"], link);
    // A tile that is built over is no map of a city.
    question["city"]["houses"] = json!({ "drawn": [[[1, 1], [149, 1], [149, 149], [1, 149]]] });
    assert_eq!(command(port, &question).kind(), "nothing");
    for corner in [5.3, -60.0] {
        question["city"]["houses"] =
            json!({ "drawn": [[[corner, 90], [corner + 9.0, 90], [corner + 9.0, 95]]] });
        assert_eq!(command(port, &question).kind(), "nothing");
    }
}

#[test]
fn changed_maps_that_no_file_holds_have_no_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let house = json!([[[100, 100], [110, 100], [110, 110], [100, 110]]]);
    std::fs::write(folder.path().join("007.json"), house.to_string()).unwrap();
    let port = start_with(MapSource::Folder(folder.path().into()));
    let mut question = question(port, 7);
    // A file is named as it is.
    let words = command(port, &question).text();
    assert!(words.contains("007.json"), "{words}");
    for drawn in [
        json!([]),
        json!([[[60, 100], [60.5, 100], [60.5, 100.5]]]),
        json!([[[-60, 100], [-50, 100], [-50, 105]]]),
    ] {
        question["city"]["houses"] = json!({ "gone": [0], "drawn": drawn });
        let refused = command(port, &question);
        assert_eq!(refused.kind(), "nothing");
        let told = refused.json()["error"]["message"].to_string();
        assert!(told.contains("cannot read the changed map"), "{told}");
    }
    question["city"]["houses"] = json!({});
    question["label"]["heading_deg"] = 720.into();
    assert_eq!(command(port, &question).kind(), "setting");
    let unknown = json!({ "map": 8 });
    assert_eq!(post(port, "/api/map", &unknown).kind(), "library");
    assert_eq!(post(start(), "/api/map", &unknown).kind(), "library");
}

#[test]
fn files_are_what_their_names_say() {
    let port = start();
    let question = question(port, 0);
    let file = |name: &str| post(port, &format!("/api/file/{name}"), &question);
    let list = LinkList::read(&file("paths").body[..]).unwrap();
    let link = serde_json::to_value(&list.links[0]).unwrap();
    assert_eq!(link, traced(&question));
    let text = |name: &str| file(name).text();
    assert!(text("picture").starts_with("<svg"));
    assert!(text("explanation").contains("<table"));
    assert!(text("command").contains("--map synthetic --seed 42"));
}
