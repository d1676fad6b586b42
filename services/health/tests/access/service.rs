//! A service with a real socket, and what its clients do.

use railgrip_health::access::{self, Access};
use railgrip_health::alerts::Symptom;
use railgrip_health::api::grade::Grade;
use railgrip_health::api::router;
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_messages::Stamp;
use railgrip_settings::{Overrides, TrainSettings};
use std::io::Read;
use std::net::{SocketAddr, TcpStream};
use std::path::PathBuf;
use std::sync::mpsc::channel;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tokio::sync::oneshot;
use ureq::tls::{Certificate, RootCerts, TlsConfig};

const NOW: Stamp = Stamp { unix_ns: 1_772_366_400_000_000_000, monotonic_ns: 100_000_000_000 };
/// Longest wait for anything.
pub const PATIENCE: Duration = Duration::from_secs(20);

/// A service on a port of its own.
pub struct Service {
    folder: TempDir,
    address: SocketAddr,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
    pub certificate: Option<String>,
    shared: Shared,
}

impl Service {
    /// `http` is the table of the config; `tls` adds a certificate and a token file.
    pub fn start(http: &str, tls: bool) -> Self {
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

    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn url(&self, path: &str) -> String {
        let scheme = if self.certificate.is_some() { "https" } else { "http" };
        format!("{scheme}://localhost:{}{path}", self.address.port())
    }

    pub fn agent(&self) -> ureq::Agent {
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
    pub fn get(&self, path: &str, headers: &[(&str, &str)]) -> (u16, String, String) {
        let mut request = self.agent().get(self.url(path));
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        taken(request.call().unwrap())
    }

    pub fn post(&self, path: &str, headers: &[(&str, &str)], body: &str) -> (u16, String, String) {
        let mut request = self.agent().post(self.url(path)).header("content-type", "application/json");
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        taken(request.send(body).unwrap())
    }

    pub fn socket(&self) -> TcpStream {
        let socket = TcpStream::connect(self.address).unwrap();
        socket.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        socket
    }

    /// Raises an alert and gives its number.
    pub fn raise(&self) -> u64 {
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

    pub fn audit(&self) -> String {
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
pub fn rest(socket: &mut TcpStream) -> (String, Duration) {
    let started = Instant::now();
    let mut bytes = Vec::new();
    let _ = socket.read_to_end(&mut bytes);
    (String::from_utf8_lossy(&bytes).into_owned(), started.elapsed())
}

pub fn within(patience: Duration, mut done: impl FnMut() -> bool) -> bool {
    let started = Instant::now();
    while started.elapsed() < patience {
        if done() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    false
}
