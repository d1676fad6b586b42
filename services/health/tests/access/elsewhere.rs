//! Requests of pages elsewhere, and by other names of this host.

use crate::service::{Service, rest};
use std::io::Write;

/// Once all of these got through: two hosts, of which a proxy reads the other one, and none.
#[test]
fn a_request_names_one_host() {
    let service = Service::start("", false);
    let answer = |hosts: &str, version: &str| {
        let mut socket = service.socket();
        let request = format!("GET /api/v1/train HTTP/{version}\r\n{hosts}Connection: close\r\n\r\n");
        socket.write_all(request.as_bytes()).unwrap();
        rest(&mut socket).0.split(' ').nth(1).unwrap_or_default().to_owned()
    };
    assert_eq!(answer("Host: localhost\r\n", "1.1"), "200");
    assert_eq!(answer("Host: localhost\r\nHost: evil.example\r\n", "1.1"), "400");
    assert_eq!(answer("Host: evil.example\r\nHost: localhost\r\n", "1.1"), "400");
    assert_eq!(answer("", "1.1"), "400");
    assert_eq!(answer("", "1.0"), "200", "HTTP/1.0 names none");
}

#[test]
fn pages_elsewhere_are_kept_out_unless_they_are_listed() {
    let closed = Service::start("", false);
    let depot = ("origin", "https://depot.example");
    let (status, headers, _) = closed.get("/api/v1/train", &[depot]);
    assert_eq!(status, 200);
    assert!(!headers.contains("access-control"), "CORS is off by default: {headers}");
    assert!(
        headers.contains("content-security-policy: ") && headers.contains("x-content-type-options: nosniff")
    );
    let evil = [("origin", "https://evil.example")];
    assert_eq!(closed.post("/api/v1/alerts/1/acknowledge", &evil, "{\"by\":\"x\"}").0, 403);
    let (status, _, body) = closed.get("/api/v1/train", &[("host", "evil.example")]);
    assert_eq!(status, 421, "another name for our address: {body}");
    let (_, headers, page) = closed.get("/docs", &[]);
    assert!(headers.contains("default-src 'none'") && !page.contains("<script"), "{headers}");

    let open = Service::start("cors_origins = [\"https://depot.example\"]\n", false);
    let (_, headers, _) = open.get("/api/v1/train", &[depot]);
    assert!(headers.contains("access-control-allow-origin: https://depot.example"), "{headers}");
    assert!(headers.to_lowercase().contains("vary: origin"), "{headers}");
    assert!(!open.get("/api/v1/train", &evil).1.contains("access-control-allow-origin"));
    let mut socket = open.socket();
    let question = "OPTIONS /api/v1/alerts/1/acknowledge HTTP/1.1\r\nHost: localhost\r\nOrigin: https://depot.example\r\n\
                    Access-Control-Request-Method: POST\r\nConnection: close\r\n\r\n";
    socket.write_all(question.as_bytes()).unwrap();
    let (said, _) = rest(&mut socket);
    assert!(
        said.starts_with("HTTP/1.1 204") && said.contains("access-control-allow-methods: GET, HEAD, POST"),
        "{said}"
    );
}
