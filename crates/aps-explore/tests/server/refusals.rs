//! Refusals of the server, and requests that it survives.

use std::io::{Read, Write};
use std::net::TcpStream;

use serde_json::{Value, json};

use crate::client::{
    cells, changed, exchange, get, point, post, post_text, question, start, traced,
};

/// The beginning of a request with a body.
fn head(port: u16, path: &str, media_type: &str) -> String {
    format!("POST {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Type: {media_type}\r\n")
}

const JSON: &str = "application/json";

/// `guard` has a test of which hosts and pages are foreign.
#[test]
fn foreign_hosts_and_pages_are_refused_whatever_they_ask() {
    let port = start();
    let own = format!("Host: 127.0.0.1:{port}\r\nOrigin: null");
    for (head, from) in [
        ("GET /", "Host: evil.example"),
        ("GET /", &own),
        ("GET /api/maps", &own),
        ("GET /main.js", &own),
        ("POST /api/link", &own),
        ("OPTIONS /api/link", &own),
        ("GET /none", &own),
    ] {
        let request = format!(
            "{head} HTTP/1.1\r\n{from}\r\nContent-Type: application/json\r\nContent-Length: 2\r\n\r\n{{}}"
        );
        let answer = exchange(port, request.as_bytes());
        assert_eq!((answer.status, &*answer.kind()), (403, "foreign"), "{head}");
    }
    let proxied = format!("GET http://evil.example/ HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n");
    assert_eq!(exchange(port, proxied.as_bytes()).status, 403);
}

#[test]
fn bodies_without_end_are_refused_before_they_are_read() {
    let port = start();
    let head = head(port, "/api/link", JSON);
    // Only the head is sent: the answer cannot have waited for the 100 MB.
    let announced = format!("{head}Content-Length: {}\r\n\r\n", 100 << 20);
    let answer = exchange(port, announced.as_bytes());
    assert_eq!((answer.status, &*answer.kind()), (413, "size"));
    let absurd = format!("{head}Content-Length: 99999999999999999999999\r\n\r\n");
    assert_eq!(exchange(port, absurd.as_bytes()).status, 400);
    let mut chunked = format!("{head}Transfer-Encoding: chunked\r\n\r\n").into_bytes();
    for _ in 0..30 {
        chunked.extend(b"4000\r\n");
        chunked.extend([b' '; 0x4000]);
        chunked.extend(b"\r\n");
    }
    let answer = exchange(port, &chunked);
    assert_eq!((answer.status, &*answer.kind()), (413, "size"));
    let long = format!("GET /{} HTTP/1.1\r\n", "a".repeat(1 << 20));
    assert!((400..500).contains(&exchange(port, long.as_bytes()).status));
}

#[test]
fn bad_questions_are_told_and_the_server_goes_on() {
    let port = start();
    let good = question(port, 0);
    for text in ["[]", "{\"city\":{\"map\":0,\"map\":1}}", "\u{ff}"] {
        let answer = post_text(port, "/api/link", text);
        assert_eq!((answer.status, &*answer.kind()), (400, "form"), "{text}");
    }
    let plain = head(port, "/api/link", "text/plain") + "Content-Length: 2\r\n\r\n{}";
    assert_eq!(exchange(port, plain.as_bytes()).status, 415);
    assert_eq!(get(port, "/api/link").status, 405);
    assert_eq!(post(port, "/", &json!({})).status, 405);

    let city = post(port, "/api/map", &json!({ "map": 0 })).json();
    let list = |value: &Value| value.as_array().unwrap().clone();
    let rings = list(&city["rings"]).into_iter();
    let mut rings = rings.map(|ring| list(&ring).iter().map(point).collect::<Vec<_>>());
    let ring = rings
        .find(|ring| ring.len() == 4 && (ring[1] - ring[0]).perp_dot(ring[2] - ring[1]) > 0.0)
        .unwrap();
    let unbounded = changed(&good, "/trace/dynamic_range_db", json!(null)).to_string();
    let (null, infinite) = ("\"dynamic_range_db\":null", "\"dynamic_range_db\":1e999");
    let text = unbounded.replace(null, infinite);
    assert_eq!(post_text(port, "/api/link", &text).kind(), "form");
    let middle = 0.5 * (ring[0] + ring[2]);
    let wall = 0.5 * (ring[0] + ring[1]);
    for (pointer, value, kind) in [
        ("/rx", json!(middle.to_array()), "terminal"),
        ("/tx", json!(wall.to_array()), "terminal"),
        ("/rx", json!([1e300, 0.0]), "terminal"),
        ("/rx", json!([-5.0, 1.0]), "terminal"),
        ("/rx", good["tx"].clone(), "library"),
        (
            "/city",
            json!({ "map": 0, "houses": { "gone": [100_000] } }),
            "house",
        ),
        ("/trace/reflections", json!(1000), "setting"),
        ("/trace/frequency_hz", json!(1e300), "library"),
        ("/label/spacing", json!(1e9), "library"),
    ] {
        let question = changed(&good, pointer, value.clone());
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
    let coverage = cells(&good, "error", 1.0).to_string();
    for read in [0, 1, 100, 5000] {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        let head = head(port, "/api/coverage", JSON);
        let request = format!("{head}Content-Length: {}\r\n\r\n{coverage}", coverage.len());
        stream.write_all(request.as_bytes()).unwrap();
        stream.read_exact(&mut vec![0; read]).unwrap();
    }
    for part in ["", "P", "POST /api/link HTTP/1.1\r\nHost: 127.0.0.1"] {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.write_all(part.as_bytes()).unwrap();
    }
    let cut = head(port, "/api/link", JSON) + "Content-Length: 50\r\n\r\n{";
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.write_all(cut.as_bytes()).unwrap();
    drop(stream);
    assert_eq!(post(port, "/api/link", &good).json()["link"], traced(&good));
}
