//! The server over its socket: what it answers, what it refuses, and what it survives.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use aps_raytrace::glam::DVec2;
use aps_raytrace::{TraceConfig, Tracer};
use map2aps::aps_model::ModelKind;
use map2aps::aps_model::weights::Shipped;
use map2aps::maps::{TileSettings, load_file};
use map2aps::path_list::{LinkEntry, LinkList};
use map2aps::{MapSource, SceneSettings};
use serde_json::{Value, json};
use xtask_explore::stock::Maps;
use xtask_explore::{App, Server, Stock};

/// Starts a server for synthetic cities, which ends with the process.
fn start() -> u16 {
    start_with(MapSource::Synthetic { count: 3 })
}

fn start_with(source: MapSource) -> u16 {
    let maps = Maps::new(source, 42, SceneSettings::default()).unwrap();
    let server = Server::bind(App::new(Stock::new(maps).unwrap()).unwrap(), 0).unwrap();
    assert!(server.address().ip().is_loopback());
    let port = server.address().port();
    std::thread::spawn(|| server.serve().unwrap());
    port
}

/// An answer: status, head, body.
struct Answer {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Answer {
    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }

    /// Kind of the fault.
    #[track_caller]
    fn kind(&self) -> String {
        assert!(self.head.contains("x-fault: 1"), "{}", self.head);
        self.json()["error"]["kind"].as_str().unwrap().into()
    }
}

/// A server that is silent for so long hangs.
const HANGS: Duration = Duration::from_secs(600);

/// Sends bytes and reads the answer up to its end.
fn exchange(port: u16, request: &[u8]) -> Answer {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(HANGS)).unwrap();
    // A server that refuses may close before it has read everything.
    let _ = stream.write_all(request);
    let mut bytes = Vec::new();
    if let Err(error) = stream.read_to_end(&mut bytes) {
        assert_eq!(error.kind(), ErrorKind::ConnectionReset);
    }
    let end = bytes.windows(4).position(|w| w == b"\r\n\r\n");
    let end = end.expect("an answer has a head");
    let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
    let mut body = bytes.split_off(end + 4);
    if head.contains("transfer-encoding: chunked") {
        body = joined(&body);
    }
    Answer {
        status: head[9..12].parse().unwrap(),
        head,
        body,
    }
}

/// The content of a body in chunks.
fn joined(mut chunks: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    loop {
        let end = chunks.windows(2).position(|w| w == b"\r\n").unwrap();
        let size = std::str::from_utf8(&chunks[..end]).unwrap();
        let size = usize::from_str_radix(size, 16).unwrap();
        if size == 0 {
            return body;
        }
        body.extend(&chunks[end + 2..end + 2 + size]);
        chunks = &chunks[end + 4 + size..];
    }
}

fn get(port: u16, path: &str) -> Answer {
    let head =
        format!("GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n");
    exchange(port, head.as_bytes())
}

fn post_text(port: u16, path: &str, body: &str) -> Answer {
    post_from(0, port, path, body)
}

/// Asks as one of several pages, which do not overtake each other.
fn post_from(page: usize, port: u16, path: &str, body: &str) -> Answer {
    let request = format!(
        "POST {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Type: application/json\r\nX-Page: {page}\r\n\
         Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
        body.len()
    );
    exchange(port, request.as_bytes())
}

fn post(port: u16, path: &str, question: &Value) -> Answer {
    post_text(port, path, &question.to_string())
}

/// A link of a city whose terminals the server proposes.
fn question(port: u16, map: u32) -> Value {
    let city = post(port, "/api/map", &json!({ "map": map })).json();
    json!({
        "city": { "map": map },
        "tx": city["tx"],
        "rx": city["rx"],
        "trace": {
            "reflections": 2, "diffractions": 1, "slope_diffraction": true, "dynamic_range_db": 60.0,
            "frequency_hz": 3.5e9, "material": "concrete",
        },
        "label": {
            "protocol": "paper", "array": "ula", "elements": 16, "spacing": 0.5,
            "heading_deg": 0.0, "sampling_rate_hz": 200e6,
        },
    })
}

fn point(value: &Value) -> DVec2 {
    DVec2::new(value[0].as_f64().unwrap(), value[1].as_f64().unwrap())
}

/// The link as the tracer gives it.
fn traced(question: &Value) -> Value {
    traced_with(question, TraceConfig::default())
}

fn traced_with(question: &Value, config: TraceConfig) -> Value {
    let map = question["city"]["map"].as_u64().unwrap() as u32;
    let cities = MapSource::Synthetic { count: 3 };
    let scene = cities.load(map, 42, SceneSettings::default()).unwrap();
    let tracer = Tracer::new(&scene, config).unwrap();
    let (tx, rx) = (point(&question["tx"]), point(&question["rx"]));
    let link = tracer.trace(tx, rx).unwrap();
    assert!(!link.paths.is_empty());
    serde_json::to_value(LinkEntry::new(tx, rx, &link.paths)).unwrap()
}

#[test]
fn page_and_its_files_load_nothing_from_elsewhere() {
    let port = start();
    let page = get(port, "/");
    let text = String::from_utf8(page.body.clone()).unwrap();
    assert_eq!(page.status, 200);
    for header in [
        "content-security-policy: default-src 'none'; script-src 'self'",
        "frame-ancestors 'none'",
        "cross-origin-resource-policy: same-origin",
        "x-content-type-options: nosniff",
    ] {
        assert!(page.head.contains(header), "{}", page.head);
    }
    assert!(!text.contains("://"), "an address in the page");
    let is_file = |part: &&str| part.starts_with('/') && part.ends_with(['s', '/']);
    for part in text.split('"').filter(is_file) {
        let file = get(port, part);
        assert_eq!(file.status, 200, "{part}");
        let text = String::from_utf8(file.body).unwrap();
        let foreign =
            text.matches("://").count() - text.matches("http://www.w3.org/2000/svg").count();
        assert_eq!(foreign, 0, "{part}");
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
    let of = |answer: &Value| -> Vec<f64> {
        let curve = answer["spectrum"]["aps_db"].as_array().unwrap().iter();
        curve.map(|v| v.as_f64().unwrap()).collect()
    };
    let (a, b) = (of(&straight), of(&turned));
    for i in 0..180 {
        assert!((a[(i + 45) % 180] - b[i]).abs() <= 0.011, "{i}");
    }
}

#[test]
fn comparison_of_converged_limits_with_themselves_finds_no_error() {
    let port = start();
    let mut question = question(port, 1);
    let default = post(port, "/api/compare", &question).json();
    assert!(default["error_db"]["mean"].as_f64().unwrap() >= 0.0);
    assert!(default["own"]["times_us"]["rx"].as_f64().unwrap() > 0.0);
    question["trace"]["reflections"] = 5.into();
    question["trace"]["diffractions"] = 2.into();
    question["trace"]["dynamic_range_db"] = 30.0.into();
    let converged = post(port, "/api/compare", &question).json();
    assert_eq!(converged["error_db"], json!({ "mean": 0.0, "worst": 0.0 }));
}

#[test]
fn pages_that_ask_for_the_same_at_once_all_have_their_answer() {
    for map in 0..3 {
        let port = start();
        let question = question(port, map);
        let mut cells = question.clone();
        cells.as_object_mut().unwrap().remove("rx");
        cells["show"] = "error".into();
        cells["cell_m"] = 32.0.into();
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

#[test]
fn prediction_is_scored_against_the_label_that_is_shown() {
    let port = start();
    let mut question = question(port, 0);
    let without = post(port, "/api/link", &question).json();
    assert!(without.get("model").is_none());
    question["model"] = true.into();
    let answer = post(port, "/api/link", &question).json();
    assert_eq!(answer["link"], without["link"]);
    let model = &answer["model"];
    assert_eq!(model["is_foreign"], false);
    let levels = |curve: &Value| -> Vec<f64> {
        let levels = curve["aps_db"].as_array().unwrap().iter();
        levels.map(|level| level.as_f64().unwrap()).collect()
    };
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
    let errors = label
        .iter()
        .zip(&predicted)
        .map(|(&a, &b)| (power(a) - power(b)).abs());
    let mae = errors.sum::<f64>() / 180.0 / deviation;
    assert!(
        (model["mae"].as_f64().unwrap() - mae).abs() < 0.02,
        "{mae}: {model}"
    );
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
    for (pointer, value, told) in [
        ("/label/protocol", json!("released"), "protocol paper"),
        (
            "/label/array",
            json!("uca"),
            "a linear array of 16 elements",
        ),
        ("/label/elements", json!(8), "a linear array of 16 elements"),
        ("/label/heading_deg", json!(15), "heading 0°"),
        ("/label/sampling_rate_hz", json!(100e6), "200 MHz"),
        ("/trace/frequency_hz", json!(28e9), "3.5 GHz"),
    ] {
        let mut other = asked.clone();
        *other.pointer_mut(pointer).unwrap() = value;
        let answer = post(port, "/api/link", &other).json();
        let reason = answer["model"]["reason"].as_str().unwrap();
        assert!(reason.contains(told), "{pointer}: {reason}");
        assert!(answer["model"].get("curve").is_none());
    }
    // Of other limits and walls there is one: what the model gets wrong is to be seen.
    for (pointer, value) in [
        ("/trace/reflections", json!(5)),
        ("/trace/material", json!("pec")),
        ("/trace/dynamic_range_db", json!(null)),
    ] {
        let mut other = asked.clone();
        *other.pointer_mut(pointer).unwrap() = value;
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
        max_diffractions: 2,
        max_interactions: 4,
        dynamic_range_db: None,
        slope_diffraction: true,
        ..TraceConfig::default()
    };
    assert_eq!(with["link"], traced_with(&question, config));
    let command = post(port, "/api/file/command", &question).body;
    let command = String::from_utf8(command).unwrap();
    assert_eq!(command.matches("--slope-diffraction true").count(), 2);
}

#[test]
fn coverage_comes_in_order_and_agrees_with_links() {
    let port = start();
    let mut question = question(port, 0);
    let rx = question.as_object_mut().unwrap().remove("rx").unwrap();
    question["show"] = "link".into();
    question["cell_m"] = 16.0.into();
    let answer = post(port, "/api/coverage", &question);
    let lines: Vec<Value> = answer
        .body
        .split(|&b| b == b'\n')
        .filter(|line| !line.is_empty())
        .map(|line| serde_json::from_slice(line).unwrap())
        .collect();
    let (grid, blocks) = lines.split_first().unwrap();
    assert_eq!(blocks.last().unwrap()["done"], grid["of"]);
    assert!(
        blocks
            .windows(2)
            .all(|w| w[0]["stride"].as_u64() >= w[1]["stride"].as_u64())
    );
    let columns = grid["columns"].as_u64().unwrap();
    let mut links = 0;
    for block in blocks {
        let cells = block["at"].as_array().unwrap().iter().enumerate();
        for (i, cell) in cells.step_by(7) {
            let cell = cell.as_u64().unwrap();
            let place = |step: u64| 16.0 * (step as f64 + grid["middle"].as_f64().unwrap());
            question["rx"] = json!([place(cell % columns), place(cell / columns)]);
            let mut asked = question.clone();
            for name in ["show", "cell_m"] {
                asked.as_object_mut().unwrap().remove(name);
            }
            let answer = post(port, "/api/link", &asked);
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
    question["show"] = "error".into();
    question.as_object_mut().unwrap().remove("rx");
    let errors = post(port, "/api/coverage", &question);
    assert!(String::from_utf8(errors.body).unwrap().contains("error_db"));
    question["rx"] = rx;
    assert_eq!(post(port, "/api/coverage", &question).kind(), "form");
}

#[test]
fn edited_houses_change_the_map_and_the_file_gives_the_same_link() {
    let maps = tempfile::tempdir().unwrap();
    let house = |x: f64, y: f64| {
        [
            [x, y],
            [x + 30.0, y],
            [x + 30.0, y + 20.0],
            [x, y + 20.0],
            [x, y],
        ]
    };
    let houses = json!([
        house(20.0, 30.0),
        house(80.0, 40.0),
        house(150.0, 60.0),
        house(90.0, 150.0)
    ]);
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
    assert_eq!(
        city["houses"].as_array().unwrap().len(),
        before["houses"].as_array().unwrap().len() - 1
    );
    assert_eq!(city["repairs_as_read"], before["repairs"]);
    // The ring crosses itself, which is repaired and told as for files.
    assert!(
        city["repairs"]
            .as_str()
            .unwrap()
            .contains("1 self-intersections"),
        "{city}"
    );

    for end in ["tx", "rx"] {
        question[end] = city[end].clone();
    }
    let answer = post(port, "/api/link", &question).json();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("map-7.json");
    std::fs::write(&file, post(port, "/api/file/map", &question).body).unwrap();
    let read = load_file(
        &file,
        None,
        TileSettings::default(),
        SceneSettings::default(),
    );
    let scene = read.unwrap().0;
    assert_eq!(
        scene.report().to_string(),
        city["repairs"].as_str().unwrap()
    );
    let tracer = Tracer::new(&scene, TraceConfig::default()).unwrap();
    let (tx, rx) = (point(&question["tx"]), point(&question["rx"]));
    let link = LinkEntry::new(tx, rx, &tracer.trace(tx, rx).unwrap().paths);
    assert_eq!(answer["link"], serde_json::to_value(link).unwrap());
    let command = post(port, "/api/file/command", &question).body;
    let command = String::from_utf8(command).unwrap();
    assert!(
        command.starts_with("cargo xtask trace --format json --map map-7.json --tx"),
        "{command}"
    );
}

#[test]
fn files_are_what_their_names_say() {
    let port = start();
    let question = question(port, 0);
    let file = |name: &str| post(port, &format!("/api/file/{name}"), &question);
    let list = LinkList::read(&file("paths").body[..]).unwrap();
    assert_eq!(
        serde_json::to_value(&list.links[0]).unwrap(),
        traced(&question)
    );
    let text = |name: &str| String::from_utf8(file(name).body).unwrap();
    assert!(text("picture").starts_with("<svg"));
    assert!(text("explanation").contains("<table"));
    assert!(text("command").contains("--map synthetic --seed 42"));
}

#[test]
fn foreign_hosts_and_pages_are_refused_whatever_they_ask() {
    let port = start();
    let own = format!("127.0.0.1:{port}");
    let foreign = [
        ("evil.example", None),
        (own.as_str(), Some("http://evil.example")),
        (own.as_str(), Some("null")),
    ];
    for (host, origin) in foreign {
        for head in [
            "GET /",
            "GET /api/maps",
            "GET /main.js",
            "POST /api/link",
            "OPTIONS /api/link",
            "GET /none",
        ] {
            let origin = origin.map_or(String::new(), |o| format!("Origin: {o}\r\n"));
            let request = format!(
                "{head} HTTP/1.1\r\nHost: {host}\r\n{origin}Content-Type: application/json\r\nContent-Length: 2\r\n\r\n{{}}"
            );
            let answer = exchange(port, request.as_bytes());
            assert_eq!(
                (answer.status, answer.kind().as_str()),
                (403, "foreign"),
                "{head}"
            );
        }
    }
    let proxied = format!("GET http://evil.example/ HTTP/1.1\r\nHost: {own}\r\n\r\n");
    assert_eq!(exchange(port, proxied.as_bytes()).status, 403);
}

#[test]
fn bodies_without_end_are_refused_before_they_are_read() {
    let port = start();
    let head = format!(
        "POST /api/link HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Type: application/json\r\n"
    );
    // Only the head is sent: the answer cannot have waited for the 100 MB.
    let announced = format!("{head}Content-Length: {}\r\n\r\n", 100 << 20);
    let answer = exchange(port, announced.as_bytes());
    assert_eq!((answer.status, answer.kind().as_str()), (413, "size"));
    let absurd = format!("{head}Content-Length: 99999999999999999999999\r\n\r\n");
    assert_eq!(exchange(port, absurd.as_bytes()).status, 400);
    let mut chunked = format!("{head}Transfer-Encoding: chunked\r\n\r\n").into_bytes();
    for _ in 0..30 {
        chunked.extend(b"4000\r\n");
        chunked.extend([b' '; 0x4000]);
        chunked.extend(b"\r\n");
    }
    let answer = exchange(port, &chunked);
    assert_eq!((answer.status, answer.kind().as_str()), (413, "size"));
    let long = format!("GET /{} HTTP/1.1\r\n", "a".repeat(1 << 20));
    assert!((400..500).contains(&exchange(port, long.as_bytes()).status));
}

#[test]
fn bad_questions_are_told_and_the_server_goes_on() {
    let port = start();
    let good = question(port, 0);
    for text in ["[]", "{\"city\":{\"map\":0,\"map\":1}}", "\u{ff}"] {
        let answer = post_text(port, "/api/link", text);
        assert_eq!(
            (answer.status, answer.kind().as_str()),
            (400, "form"),
            "{text}"
        );
    }
    let plain = format!(
        "POST /api/link HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Type: text/plain\r\nContent-Length: 2\r\n\r\n{{}}"
    );
    assert_eq!(exchange(port, plain.as_bytes()).status, 415);
    assert_eq!(get(port, "/api/link").status, 405);
    assert_eq!(post(port, "/", &json!({})).status, 405);

    let city = post(port, "/api/map", &json!({ "map": 0 })).json();
    let rings = city["rings"].as_array().unwrap().iter();
    let mut rings = rings.map(|ring| {
        ring.as_array()
            .unwrap()
            .iter()
            .map(point)
            .collect::<Vec<_>>()
    });
    let ring = rings
        .find(|ring| ring.len() == 4 && (ring[1] - ring[0]).perp_dot(ring[2] - ring[1]) > 0.0)
        .unwrap();
    let middle = 0.5 * (ring[0] + ring[2]);
    let wall = 0.5 * (ring[0] + ring[1]);
    for (pointer, value, kind) in [
        ("/rx", json!(middle.to_array()), "terminal"),
        ("/tx", json!(wall.to_array()), "terminal"),
        ("/rx", json!([1e300, 0.0]), "terminal"),
        ("/rx", json!([-5.0, 1.0]), "terminal"),
        ("/rx", good["tx"].clone(), "library"),
        ("/city/map", json!(3), "house"),
        ("/trace/dynamic_range_db", json!(null), "form"),
        ("/trace/reflections", json!(1000), "setting"),
        ("/trace/frequency_hz", json!(1e300), "library"),
        ("/label/elements", json!(0), "setting"),
        ("/label/spacing", json!(1e9), "library"),
    ] {
        let mut question = good.clone();
        *question.pointer_mut(pointer).unwrap() = value.clone();
        if pointer == "/city/map" {
            question["city"] = json!({ "map": 0, "houses": { "gone": [100_000] } });
        }
        if kind == "form" {
            let text = question
                .to_string()
                .replace("\"dynamic_range_db\":null", "\"dynamic_range_db\":1e999");
            assert_eq!(post_text(port, "/api/link", &text).kind(), kind);
            continue;
        }
        let answer = post(port, "/api/link", &question);
        assert_eq!(answer.kind(), kind, "{pointer} = {value}");
        let end = &answer.json()["error"]["end"];
        assert!(
            kind != "terminal" || *end == pointer[1..],
            "{pointer}: {end}"
        );
    }
    for (ring, kind) in [
        (json!(vec![[0.0; 2]; 100_000]), "size"),
        (json!(vec![[1.0, 2.0]; 5000]), "size"),
        (json!([[1.0, 1.0], [1.0, 1.0], [2.0, 2.0]]), "library"),
        (json!([[1.0, 1.0], [1e10, 1.0], [2.0, 2.0]]), "library"),
        (json!([]), "library"),
    ] {
        let mut question = good.clone();
        question["city"]["houses"] = json!({ "drawn": [ring] });
        assert_eq!(post(port, "/api/link", &question).kind(), kind);
    }
    assert_eq!(post(port, "/api/link", &good).json()["link"], traced(&good));
}

#[test]
fn closed_connections_are_survived() {
    let port = start();
    let good = question(port, 0);
    let mut coverage = good.clone();
    coverage.as_object_mut().unwrap().remove("rx");
    coverage["show"] = "error".into();
    coverage["cell_m"] = 1.0.into();
    let coverage = coverage.to_string();
    for read in [0, 1, 100, 5000] {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        let request = format!(
            "POST /api/coverage HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\n\r\n{coverage}",
            coverage.len()
        );
        stream.write_all(request.as_bytes()).unwrap();
        stream.read_exact(&mut vec![0; read]).unwrap();
    }
    for part in ["", "P", "POST /api/link HTTP/1.1\r\nHost: 127.0.0.1"] {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.write_all(part.as_bytes()).unwrap();
    }
    let cut = format!(
        "POST /api/link HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Type: application/json\r\nContent-Length: 50\r\n\r\n{{"
    );
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.write_all(cut.as_bytes()).unwrap();
    drop(stream);
    assert_eq!(post(port, "/api/link", &good).json()["link"], traced(&good));
}
