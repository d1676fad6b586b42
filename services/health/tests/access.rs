//! Access with real sockets: TLS, tokens and roles, rotation, limits, slow clients, pages elsewhere, the audit log.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may end at what it does not expect, and prints"
)]

use railgrip_health::access::{self, Access, Role, tokens};
use railgrip_health::alerts::Symptom;
use railgrip_health::api::grade::Grade;
use railgrip_health::api::router;
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_messages::Stamp;
use railgrip_settings::{Overrides, TrainSettings};
use serde_json::Value;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tokio::sync::oneshot;
use ureq::tls::{Certificate, RootCerts, TlsConfig};

const NOW: Stamp = Stamp { unix_ns: 1_772_366_400_000_000_000, monotonic_ns: 100_000_000_000 };

/// A service on a port of its own.
struct Service {
    folder: TempDir,
    address: SocketAddr,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
    certificate: Option<String>,
    shared: Shared,
}

impl Service {
    /// `http` is the table of the config; `tls` adds a certificate and a token file.
    fn start(http: &str, tls: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let mut certificate = None;
        let mut text = format!(
            "schema = 1\n[train]\nname = \"access\"\nwagons = 2\nvehicle = \"{}/../../config/vehicle.toml\"\n[source]\nkind = \"stdin\"\n[http]\n",
            env!("CARGO_MANIFEST_DIR")
        );
        if tls {
            let made = rcgen::generate_simple_self_signed(vec!["localhost".to_owned()]).unwrap();
            std::fs::write(at("cert.pem"), made.cert.pem()).unwrap();
            std::fs::write(at("key.pem"), made.signing_key.serialize_pem()).unwrap();
            certificate = Some(made.cert.pem());
            text += "token_file = \"tokens.toml\"\n";
        }
        text += http;
        if tls {
            text += "\n[http.tls]\ncertificate = \"cert.pem\"\nkey = \"key.pem\"\n";
        }
        let overrides = Overrides { instance_dir: Some(at("i")), ..Overrides::default() };
        std::fs::create_dir(at("i")).unwrap();
        let settings = TrainSettings::parse(&at("train.toml"), &text, &overrides).unwrap();
        let mut store = Store::new(&settings);
        let shared = Shared::new(store.snapshot(NOW), || NOW);
        let access = Access::open(&settings).unwrap();
        let router = access::guard(router(shared.clone()), &access);
        let (stop, stopped) = oneshot::channel();
        let (sender, receiver) = channel();
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async move {
                let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
                sender.send(listener.local_addr().unwrap()).unwrap();
                access::serve(listener, None, router, access, async { drop(stopped.await) }).await;
            });
        });
        let address = receiver.recv().unwrap();
        Self { folder, address, stop: Some(stop), thread: Some(thread), certificate, shared }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn url(&self, path: &str) -> String {
        let scheme = if self.certificate.is_some() { "https" } else { "http" };
        format!("{scheme}://localhost:{}{path}", self.address.port())
    }

    fn agent(&self) -> ureq::Agent {
        let mut config = ureq::Agent::config_builder()
            .timeout_global(Some(Duration::from_secs(10)))
            .http_status_as_error(false);
        if let Some(pem) = &self.certificate {
            let root = Certificate::from_pem(pem.as_bytes()).unwrap();
            config = config
                .tls_config(TlsConfig::builder().root_certs(RootCerts::new_with_certs(&[root])).build());
        }
        config.build().into()
    }

    /// Status, headers as text, body.
    fn get(&self, path: &str, headers: &[(&str, &str)]) -> (u16, String, String) {
        let mut request = self.agent().get(self.url(path));
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        taken(request.call().unwrap())
    }

    fn post(&self, path: &str, headers: &[(&str, &str)], body: &str) -> (u16, String, String) {
        let mut request = self.agent().post(self.url(path)).header("content-type", "application/json");
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        taken(request.send(body).unwrap())
    }

    fn socket(&self) -> TcpStream {
        let socket = TcpStream::connect(self.address).unwrap();
        socket.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        socket
    }

    /// Raises an alert and gives its number.
    fn raise(&self) -> u64 {
        let book = self.shared.latest().book.clone();
        let mut book = book.lock();
        for half in 0..20 {
            let ns = half * 500_000_000;
            let now = Stamp { unix_ns: NOW.unix_ns + ns as i64, monotonic_ns: NOW.monotonic_ns + ns };
            let symptom = Symptom { wagon: 1, wheelset: Some(2), rule: "brake_friction" };
            book.judge(symptom, Grade::Act, "far too low", now);
            book.settle(now);
        }
        book.list()[0].id
    }

    fn audit(&self) -> String {
        let text = |name: &str| std::fs::read_to_string(self.file(name)).unwrap_or_default();
        text("i/audit.jsonl") + &text("i/audit-strangers.jsonl")
    }
}

fn taken(mut answer: ureq::http::Response<ureq::Body>) -> (u16, String, String) {
    let headers = answer.headers().iter();
    let headers: String =
        headers.map(|(name, value)| format!("{name}: {}\n", value.to_str().unwrap())).collect();
    (answer.status().as_u16(), headers, answer.body_mut().read_to_string().unwrap())
}

impl Drop for Service {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Everything until the other end closes, and how long that took.
fn rest(socket: &mut TcpStream) -> (String, Duration) {
    let started = Instant::now();
    let mut bytes = Vec::new();
    let _ = socket.read_to_end(&mut bytes);
    (String::from_utf8_lossy(&bytes).into_owned(), started.elapsed())
}

fn within(patience: Duration, mut done: impl FnMut() -> bool) -> bool {
    let started = Instant::now();
    while started.elapsed() < patience {
        if done() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    false
}

const PATIENCE: Duration = Duration::from_secs(20);

#[test]
fn tokens_open_what_their_role_allows_and_are_rotated_without_a_restart() {
    let service = Service::start("", true);
    let file = service.file("tokens.toml");
    let of = |name: &str, role| tokens::add(&file, name, role, None).unwrap();
    let (reader, worker, admin) =
        (of("reader", Role::Read), of("worker", Role::Acknowledge), of("admin", Role::Admin));
    let as_ = |token: &str| format!("Bearer {token}");
    let get = |path: &str, token: &str| service.get(path, &[("authorization", &as_(token))]).0;
    assert!(
        within(PATIENCE, || get("/api/v1/train", &reader) == 200),
        "tokens are read while the service runs"
    );

    let (status, headers, body) = service.get("/api/v1/wagons", &[]);
    assert_eq!(status, 401, "{body}");
    assert!(
        headers.contains("application/problem+json") && headers.contains("www-authenticate: Bearer"),
        "{headers}"
    );
    assert_eq!(service.get("/api/v1/wagons", &[("authorization", "Bearer railgrip_wrong")]).0, 401);
    assert_eq!(
        service.get("/health/ready", &[]).0,
        503,
        "a supervisor holds no token; nothing feeds this service"
    );

    let act = |token: &str| {
        let body = "{\"by\":\"depot\"}";
        service.post("/api/v1/alerts/7/acknowledge", &[("authorization", &as_(token))], body).0
    };
    assert_eq!((act(&reader), act(&worker), act(&admin)), (403, 404, 404), "there is no alert 7");
    assert_eq!(get("/api/v1/audit", &reader), 403);
    assert_eq!(get("/api/v1/audit", &worker), 403);
    assert_eq!(get("/api/v1/audit", &admin), 200);

    let kept = std::fs::read_to_string(&file).unwrap();
    for secret in [&reader, &worker, &admin] {
        assert!(!kept.contains(secret.as_str()), "only hashes are kept");
        assert!(!service.audit().contains(secret.as_str()), "no secret in the log");
    }

    let renewed = tokens::rotate(&file, "reader", 3600).unwrap();
    assert!(within(PATIENCE, || get("/api/v1/train", &renewed) == 200));
    assert_eq!(get("/api/v1/train", &reader), 200, "the old secret counts for an hour more");
    let again = tokens::rotate(&file, "reader", 0).unwrap();
    assert!(within(PATIENCE, || get("/api/v1/train", &renewed) == 401), "without overlap it ends at once");
    assert_eq!(get("/api/v1/train", &again), 200);
    tokens::revoke(&file, "reader").unwrap();
    assert!(within(PATIENCE, || get("/api/v1/train", &again) == 401), "revoked");

    assert!(within(PATIENCE, || service.audit().contains("token_reload")));
    let lines: Vec<Value> =
        service.audit().lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let found = |who: &str, status: u16| {
        lines.iter().any(|line| line["who"] == who && line["status"] == status && line["method"] == "POST")
    };
    assert!(found("worker", 404) && found("reader", 403), "{lines:?}");
    assert!(lines.iter().any(|line| line["status"] == 401 && line["event"] == "refused"));
}

#[test]
fn whoever_shows_a_token_acts_under_its_name() {
    let service = Service::start("", true);
    let file = service.file("tokens.toml");
    let kim = tokens::add(&file, "kim", Role::Acknowledge, None).unwrap();
    let bearer = format!("Bearer {kim}");
    let headers = [("authorization", bearer.as_str())];
    assert!(within(PATIENCE, || service.get("/api/v1/train", &headers).0 == 200));
    let (_, _, told) = service.get("/api/v1/identity", &headers);
    assert_eq!(told, r#"{"name":"kim","role":"acknowledge"}"#);
    // The name of the token comes first; whom the body names, if anybody, stands behind it.
    for (body, by) in [
        (r#"{"by":"boss","text":"squeals"}"#, "kim (boss)"),
        (r#"{"by":" kim ","text":"squeals"}"#, "kim"),
        (r#"{"text":"squeals"}"#, "kim"),
    ] {
        let (status, _, told) = service.post("/api/v1/wagons/1/notes", &headers, body);
        let told: Value = serde_json::from_str(&told).unwrap();
        let notes = told["notes"].as_array().unwrap();
        let signed = notes.iter().filter(|note| note["by"] == by).count();
        assert!(status == 200 && signed >= 1, "{by}: {told}");
    }
    let id = service.raise();
    for (act, body, by) in [
        ("acknowledge", r#"{"by":"boss"}"#, "kim (boss)"),
        ("unacknowledge", "{}", "kim"),
        ("silence", r#"{"by":"boss","why":"known","duration_s":3600}"#, "kim (boss)"),
        ("unsilence", "{}", "kim"),
    ] {
        let (status, _, told) = service.post(&format!("/api/v1/alerts/{id}/{act}"), &headers, body);
        let told: Value = serde_json::from_str(&told).unwrap();
        let last = told["history"].as_array().unwrap().last().unwrap();
        assert_eq!((status, &last["by"]), (200, &Value::from(by)), "{act}: {told}");
    }
    let open = Service::start("", false);
    assert_eq!(open.get("/api/v1/identity", &[]).2, r#"{"name":null,"role":"admin"}"#);
    let (status, _, told) = open.post("/api/v1/wagons/1/notes", &[], r#"{"text":"squeals"}"#);
    assert!(status == 422 && told.contains("`by`"), "without tokens people sign themselves: {told}");
}

#[test]
fn nothing_but_tls_is_spoken_where_tls_is_asked_for() {
    let service = Service::start("[http.limits]\nhead_s = 0.5\n", true);
    let mut plain = service.socket();
    plain.write_all(b"GET /health/live HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    let (said, _) = rest(&mut plain);
    assert!(!said.contains("HTTP/1.1"), "{said:?}");
    let mut silent = service.socket();
    let (_, took) = rest(&mut silent);
    println!("a handshake that never comes is cut off after {:.2} s", took.as_secs_f64());
    assert!(took < PATIENCE);
    let (_, headers, _) = service.get("/health/live", &[]);
    assert!(headers.contains("strict-transport-security: max-age=31536000"), "{headers}");
}

#[test]
fn a_certificate_is_renewed_without_a_restart() {
    let mut service = Service::start("", true);
    assert_eq!(service.get("/health/live", &[]).0, 200);
    let made = rcgen::generate_simple_self_signed(vec!["localhost".to_owned()]).unwrap();
    std::fs::write(service.file("key.pem"), made.signing_key.serialize_pem()).unwrap();
    std::fs::write(service.file("cert.pem"), made.cert.pem()).unwrap();
    service.certificate = Some(made.cert.pem());
    let speaks = || service.agent().get(service.url("/health/live")).call().is_ok();
    assert!(within(PATIENCE, speaks), "the new certificate is trusted by its own root only");
}

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

/// Somebody without a token once wrote all 25 MB of the log out within half a minute.
#[test]
fn strangers_write_nobody_out_of_the_audit_log() {
    let service = Service::start("[http.audit]\nmax_mb = 0.01\nkeep = 2\n", true);
    let kim = tokens::add(&service.file("tokens.toml"), "kim", Role::Acknowledge, None).unwrap();
    let bearer = format!("Bearer {kim}");
    let headers = [("authorization", bearer.as_str())];
    assert!(within(PATIENCE, || service.get("/api/v1/train", &headers).0 == 200));
    assert_eq!(service.post("/api/v1/wagons/1/notes", &headers, r#"{"text":"squeals"}"#).0, 200);
    for _ in 0..100 {
        service.post("/health/live", &[], "");
        service.post("/api/v1/wagons/1/notes", &[], "");
    }
    let log = std::fs::read_to_string(service.file("i/audit.jsonl")).unwrap();
    assert!(log.contains("\"start\"") && log.contains("\"kim\"") && !log.contains("/health/live"), "{log}");
    assert!(service.audit().contains("/health/live"), "and it is known that they came");
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

#[test]
fn an_address_beyond_loopback_asks_for_tls_and_tokens() {
    let text = format!(
        "schema = 1\n[train]\nname = \"access\"\nwagons = 1\nvehicle = \"{}/../../config/vehicle.toml\"\n[source]\nkind = \"stdin\"\n[http]\nlisten = \"0.0.0.0:0\"\n",
        env!("CARGO_MANIFEST_DIR")
    );
    let said =
        TrainSettings::parse(Path::new("train.toml"), &text, &Overrides::default()).unwrap_err().to_string();
    println!("{said}");
    assert!(said.contains("`http.listen`") && said.contains("certificate") && said.contains("token_file"));
}
