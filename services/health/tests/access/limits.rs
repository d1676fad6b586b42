//! How much one client gets, and how long a slow one is waited for.

use crate::service::{PATIENCE, Service, rest, within};
use railgrip_health::access::{Role, tokens};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

#[test]
fn slow_clients_are_cut_off() {
    let limits =
        "[http.limits]\nhead_s = 0.5\nbody_s = 0.5\nstall_s = 0.5\non_loopback = true\nrequests_per_s = 0\n";
    let service = Service::start(limits, false);
    // Slowloris: a head that never ends, a byte at a time.
    let mut socket = service.socket();
    socket.write_all(b"GET /api/v1/train HTTP/1.1\r\nHost: localhost\r\n").unwrap();
    let started = Instant::now();
    let cut = within(PATIENCE, || {
        socket.write_all(b"X").is_err() || {
            socket.set_nonblocking(true).unwrap();
            let gone = socket.read(&mut [0; 256]).is_ok();
            socket.set_nonblocking(false).unwrap();
            gone
        }
    });
    println!("a head that never ends is cut off after {:.2} s", started.elapsed().as_secs_f64());
    assert!(cut, "the head took for ever");

    let mut socket = service.socket();
    let head = "POST /api/v1/alerts/1/acknowledge HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 50\r\n\r\n{";
    socket.write_all(head.as_bytes()).unwrap();
    let (said, took) = rest(&mut socket);
    println!("a body that never ends is answered after {:.2} s", took.as_secs_f64());
    assert!(said.starts_with("HTTP/1.1 408") && said.contains("application/problem+json"), "{said}");

    // A reader who asks for much and takes nothing.
    let mut socket = service.socket();
    let request = "GET /openapi.json HTTP/1.1\r\nHost: localhost\r\n\r\n".repeat(400);
    socket.write_all(request.as_bytes()).unwrap();
    std::thread::sleep(Duration::from_secs(2));
    let (said, _) = rest(&mut socket);
    let answers = said.matches("HTTP/1.1 200").count();
    println!("a reader who takes nothing got {answers} of 400 answers");
    assert!(answers < 400, "the service waited for a reader who took nothing");

    // All the while others are served.
    assert_eq!(service.get("/api/v1/wagons", &[]).0, 200);
}

#[test]
fn one_client_cannot_take_everything() {
    let limits = "[http.limits]\nbody_kb = 1\nrequests_per_s = 1\nburst = 20\nconnections_per_client = 3\non_loopback = true\n";
    let service = Service::start(limits, false);
    let (status, headers, body) =
        service.post("/api/v1/alerts/1/acknowledge", &[], &format!("{{\"by\":\"{}\"}}", "x".repeat(2000)));
    assert_eq!(status, 413, "{body}");
    assert!(headers.contains("application/problem+json"));
    let statuses: Vec<u16> = (0..30).map(|_| service.get("/api/v1/train", &[]).0).collect();
    let refused = statuses.iter().filter(|status| **status == 429).count();
    println!("{refused} of 30 requests refused at a burst of 20");
    assert!((1..30).contains(&refused), "{statuses:?}");
    let (status, headers, _) = service.get("/api/v1/train", &[]);
    assert!(status != 429 || headers.contains("retry-after: "), "{headers}");
    let held: Vec<TcpStream> = (0..3).map(|_| service.socket()).collect();
    std::thread::sleep(Duration::from_millis(300));
    let (said, took) = rest(&mut service.socket());
    assert!(said.is_empty() && took < PATIENCE, "a fourth connection is closed");
    drop(held);
}

/// Wrong tokens once were judged at the full rate of a client, and a route that asks for none told for nothing whether one was right.
#[test]
fn a_wrong_token_costs_ten_requests() {
    let limits = "[http.limits]\nrequests_per_s = 0.001\nburst = 40\non_loopback = true\n";
    for path in ["/api/v1/train", "/health/ready"] {
        let service = Service::start(limits, true);
        tokens::add(&service.file("tokens.toml"), "kim", Role::Read, None).unwrap();
        let agent = service.agent();
        let ask = || agent.get(service.url(path)).header("authorization", "Bearer railgrip_wrong").call();
        // Who owes is turned away before the handshake.
        let status = |_| ask().map_or(429, |answer| answer.status().as_u16());
        let judged = (0..40).map(status).take_while(|status| *status != 429).count();
        println!("{path}: {judged} wrong tokens judged out of a burst of 40");
        assert!((2..=4).contains(&judged), "{judged}");
    }
}

/// A proxy runs on this machine, so that its clients once had no limits at all.
#[test]
fn limits_hold_for_those_behind_a_proxy() {
    let statuses = |proxies: &str, from: &dyn Fn(usize) -> String| {
        let limits = format!("[http.limits]\nrequests_per_s = 0.001\nburst = 5\n{proxies}");
        let service = Service::start(&limits, false);
        let ask = |n: usize| service.get("/api/v1/train", &[("x-forwarded-for", from(n).as_str())]).0;
        let counted: Vec<u16> = (0..20).map(ask).collect();
        assert_eq!(service.get("/api/v1/train", &[]).0, 200, "who asks from this machine has no limits");
        counted.iter().filter(|status| **status == 200).count()
    };
    let known = "proxies = [\"127.0.0.1\", \"::1\"]\n";
    assert_eq!(statuses(known, &|_| "203.0.113.7".to_owned()), 5, "one client");
    assert_eq!(statuses(known, &|n| format!("10.0.0.{n}, 203.0.113.7")), 5, "what it invents counts nothing");
    assert_eq!(statuses(known, &|n| format!("203.0.113.{n}")), 20, "twenty clients");
    assert_eq!(statuses("", &|n| format!("203.0.113.{n}")), 5, "an unknown proxy is one client");
}
