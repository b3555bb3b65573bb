//! Refusal of requests that come from elsewhere.
//!
//! Every page that a browser shows can send requests to a port of this machine. It cannot choose two of their headers: `Host`
//! is the name that the browser looked up, and `Origin` is the page that asks. A foreign name that its owner points at 127.0.0.1
//! shows in the first, a foreign page in the second.

use hyper::header::{HOST, HeaderMap, HeaderName, ORIGIN};
use hyper::{Method, Uri};

use crate::fault::Fault;

/// Names of this machine that the page may be opened with.
const NAMES: [&str; 2] = ["127.0.0.1", "localhost"];

const FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// Lets requests pass that this server's page on `port` makes, or a program that is no browser.
///
/// # Errors
/// [`Fault::Foreign`].
pub fn check(method: &Method, uri: &Uri, headers: &HeaderMap, port: u16) -> Result<(), Fault> {
    if uri.authority().is_some() || uri.scheme().is_some() {
        return Err(Fault::Foreign("this server is no proxy"));
    }
    // Browsers leave the port of HTTP out.
    let own = NAMES.map(|name| match port {
        80 => name.to_owned(),
        _ => format!("{name}:{port}"),
    });
    let hosts: Vec<_> = headers.get_all(HOST).iter().collect();
    if hosts.len() != 1 || !own.iter().any(|host| hosts[0] == host.as_str()) {
        return Err(Fault::Foreign("the header Host names another place"));
    }
    for origin in headers.get_all(ORIGIN) {
        let is_own = |host: &String| origin.as_bytes() == format!("http://{host}").as_bytes();
        if !own.iter().any(is_own) {
            return Err(Fault::Foreign("the header Origin names another page"));
        }
    }
    // A link in a mail may lead to the page, which is a GET; nothing else comes from another site.
    let site = headers.get(FETCH_SITE);
    if method != Method::GET && site.is_some_and(|site| site != "same-origin") {
        return Err(Fault::Foreign("the request comes from another site"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passes(method: Method, uri: &str, headers: &[(&str, &str)]) -> bool {
        let mut map = HeaderMap::new();
        for (name, value) in headers {
            let name: HeaderName = name.parse().unwrap();
            map.append(name, value.parse().unwrap());
        }
        check(&method, &uri.parse().unwrap(), &map, 8000).is_ok()
    }

    #[test]
    fn own_page_and_programs_pass() {
        assert!(passes(Method::GET, "/", &[("host", "127.0.0.1:8000")]));
        assert!(passes(Method::GET, "/", &[("host", "localhost:8000")]));
        let own = [
            ("host", "127.0.0.1:8000"),
            ("origin", "http://127.0.0.1:8000"),
            ("sec-fetch-site", "same-origin"),
        ];
        assert!(passes(Method::POST, "/api/link", &own));
    }

    #[test]
    fn link_in_a_mail_leads_to_the_page_but_asks_nothing() {
        let from_a_mail = [("host", "127.0.0.1:8000"), ("sec-fetch-site", "cross-site")];
        assert!(passes(Method::GET, "/", &from_a_mail));
        assert!(!passes(Method::POST, "/api/link", &from_a_mail));
    }

    #[test]
    fn foreign_names_and_pages_are_refused() {
        for host in [
            "evil.example",
            "evil.example:8000",
            "127.0.0.1",
            "127.0.0.1:8001",
            "127.0.0.1.evil.example:8000",
            "127.0.0.1:8000.evil.example",
            "[::1]:8000",
            "",
        ] {
            assert!(!passes(Method::GET, "/", &[("host", host)]), "{host}");
        }
        assert!(!passes(Method::GET, "/", &[]));
        let two = [("host", "127.0.0.1:8000"), ("host", "evil.example")];
        assert!(!passes(Method::GET, "/", &two));
        for origin in [
            "null",
            "",
            "http://evil.example",
            "https://127.0.0.1:8000",
            "http://127.0.0.1",
            "http://127.0.0.1:8000/",
            "http://127.0.0.1:8000.evil.example",
            "file://",
        ] {
            let headers = [("host", "127.0.0.1:8000"), ("origin", origin)];
            for method in [Method::GET, Method::POST, Method::OPTIONS] {
                assert!(!passes(method, "/api/link", &headers), "{origin}");
            }
        }
        let own = [("host", "127.0.0.1:8000")];
        assert!(!passes(Method::GET, "http://127.0.0.1:8000/", &own));
    }
}
