//! A server and a client that speaks HTTP over a plain socket.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use aps_explore::{Maps, Server};
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Scene, TraceConfig, Tracer};
use map2aps::path_list::LinkEntry;
use map2aps::{MapSource, SceneSettings};
use serde_json::{Value, json};

/// Starts a server for synthetic cities, which ends with the process.
pub fn start() -> u16 {
    start_with(MapSource::Synthetic { count: 3 })
}

pub fn start_with(source: MapSource) -> u16 {
    let maps = Maps::new(source, 42, SceneSettings::default()).unwrap();
    let server = Server::bind(maps, 0).unwrap();
    assert!(server.address().ip().is_loopback());
    let port = server.address().port();
    std::thread::spawn(|| server.serve().unwrap());
    port
}

/// An answer: status, head, body.
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }

    pub fn text(self) -> String {
        String::from_utf8(self.body).unwrap()
    }

    /// Kind of the fault.
    #[track_caller]
    pub fn kind(&self) -> String {
        assert!(self.head.contains("x-fault: 1"), "{}", self.head);
        self.json()["error"]["kind"].as_str().unwrap().into()
    }
}

/// A server that is silent for so long hangs.
pub const HANGS: Duration = Duration::from_secs(600);

/// Sends bytes and reads the answer up to its end.
pub fn exchange(port: u16, request: &[u8]) -> Answer {
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

pub fn get(port: u16, path: &str) -> Answer {
    let head =
        format!("GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n");
    exchange(port, head.as_bytes())
}

pub fn post_text(port: u16, path: &str, body: &str) -> Answer {
    post_from(0, port, path, body)
}

/// Asks as one of several pages, which do not overtake each other.
pub fn post_from(page: usize, port: u16, path: &str, body: &str) -> Answer {
    let request = format!(
        "POST {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Type: application/json\r\nX-Page: {page}\r\n\
         Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
        body.len()
    );
    exchange(port, request.as_bytes())
}

pub fn post(port: u16, path: &str, question: &Value) -> Answer {
    post_text(port, path, &question.to_string())
}

/// A link of a city whose terminals the server proposes.
pub fn question(port: u16, map: u32) -> Value {
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

/// The question about coverage that a link's settings make.
pub fn cells(question: &Value, show: &str, cell_m: f64) -> Value {
    let mut cells = question.clone();
    cells.as_object_mut().unwrap().remove("rx");
    cells["show"] = show.into();
    cells["cell_m"] = cell_m.into();
    cells
}

/// Copies a question, with another value at a place.
pub fn changed(question: &Value, pointer: &str, value: Value) -> Value {
    let mut changed = question.clone();
    *changed.pointer_mut(pointer).unwrap() = value;
    changed
}

pub fn point(value: &Value) -> DVec2 {
    DVec2::new(value[0].as_f64().unwrap(), value[1].as_f64().unwrap())
}

/// The link as the tracer gives it.
pub fn traced(question: &Value) -> Value {
    traced_with(question, TraceConfig::default())
}

pub fn traced_with(question: &Value, config: TraceConfig) -> Value {
    let map = question["city"]["map"].as_u64().unwrap() as u32;
    let cities = MapSource::Synthetic { count: 3 };
    let scene = cities.load(map, 42, SceneSettings::default()).unwrap();
    traced_in(&scene, question, config)
}

pub fn traced_in(scene: &Scene, question: &Value, config: TraceConfig) -> Value {
    let tracer = Tracer::new(scene, config).unwrap();
    let (tx, rx) = (point(&question["tx"]), point(&question["rx"]));
    let link = tracer.trace(tx, rx).unwrap();
    assert!(!link.paths.is_empty());
    serde_json::to_value(LinkEntry::new(tx, rx, &link.paths)).unwrap()
}
