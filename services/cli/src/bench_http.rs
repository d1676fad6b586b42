//! `railgrip bench --http`: the HTTP service of a long train on one thread, with access control around it and a new picture of
//! the train several times a second, beside a bare axum handler that answers the same bytes on one thread, too.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use railgrip_bus::now;
use railgrip_health::access::{self, Access};
use railgrip_health::api;
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_indicators::indicator::{ADHESION_AVAILABLE, ASYMMETRY, BRAKE_FRICTION};
use railgrip_messages::{Grade, Health, Indicator};
use railgrip_settings::{Overrides, TrainSettings};
use tokio::net::TcpListener;
use tokio::sync::oneshot;

use crate::CliError;
use crate::load::{self, Load};
use crate::output::say;

const WAGONS: u32 = 64;
/// Connections that ask at once.
const CONNECTIONS: usize = 16;
const LOAD: Duration = Duration::from_secs(4);
/// Rounds, service and reference in turn; the best of each counts, which is what the machine can do undisturbed.
const ROUNDS: usize = 3;
const VEHICLE: &str = include_str!("../../../config/vehicle.toml");
const PATH: &str = "/api/v1/wagons";

/// What was measured.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Report {
    wagons: u32,
    connections: usize,
    http: Load,
    bare_http: Load,
}

/// The report for people.
pub(crate) fn show(report: &Report) {
    say(&format!(
        "GET {PATH}, {} wagons, {} bytes, {} connections   requests/s   p50 µs   p99 µs",
        report.wagons, report.http.answer_bytes, report.connections
    ));
    for (name, load) in
        [("this service, one thread", report.http), ("bare axum, one thread", report.bare_http)]
    {
        say(&format!(
            "{name:<58} {:>10.0} {:>8.0} {:>8.0}",
            load.requests_a_second, load.p50_us, load.p99_us
        ));
    }
}

/// Loads both in turn.
pub(crate) fn run() -> Result<Report, CliError> {
    let folder = std::env::temp_dir().join(format!("rgh{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(CliError::failed)?;
    let result = measure(&folder);
    let _ = std::fs::remove_dir_all(&folder);
    result
}

fn measure(folder: &std::path::Path) -> Result<Report, CliError> {
    std::fs::write(folder.join("vehicle.toml"), VEHICLE).map_err(CliError::failed)?;
    let config = format!(
        "schema = 1\n[train]\nname = \"bench\"\nwagons = {WAGONS}\nvehicle = \"vehicle.toml\"\n[source]\nkind = \"stdin\"\n"
    );
    let overrides = Overrides { instance_dir: Some(folder.join("i")), ..Overrides::default() };
    std::fs::create_dir_all(folder.join("i")).map_err(CliError::failed)?;
    let settings = TrainSettings::parse(&folder.join("train.toml"), &config, &overrides)?;
    let mut store = Store::new(&settings);
    for wagon in 1..=WAGONS {
        let _ = store.receive_health(wagon, &health(wagon), now());
    }
    let shared = Shared::new(store.snapshot(now()), now);
    let body = shared.latest().rows_json.clone();
    let ended = Arc::new(AtomicBool::new(false));
    let renewing = std::thread::spawn({
        let (shared, ended) = (shared.clone(), Arc::clone(&ended));
        move || {
            while !ended.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(150));
                for wagon in 1..=WAGONS {
                    let _ = store.receive_health(wagon, &health(wagon), now());
                }
                shared.replace(Arc::new(store.snapshot(now())));
            }
        }
    });
    let access = Access::open(&settings)?;
    let router = access::guard(api::router(shared), &access);
    let json = [(axum::http::header::CONTENT_TYPE, "application/json")];
    let handler = axum::routing::get(move || std::future::ready((json, body.clone())));
    let bare = axum::Router::new().route(PATH, handler);
    let mut best: [Option<Load>; 2] = [None, None];
    for _ in 0..ROUNDS {
        let (router, access, bare) = (router.clone(), access.clone(), bare.clone());
        let own = served(move |listener, stop| async move {
            access::serve(listener, None, router, access, async { drop(stop.await) }).await;
        })?;
        let reference = served(move |listener, stop| async move {
            tokio::select! {
                result = axum::serve(listener, bare) => drop(result),
                _ = stop => {}
            }
        })?;
        for (best, load) in best.iter_mut().zip([own, reference]) {
            if best.is_none_or(|best| best.requests_a_second < load.requests_a_second) {
                *best = Some(load);
            }
        }
    }
    ended.store(true, Ordering::Relaxed);
    let _ = renewing.join();
    let [Some(http), Some(bare_http)] = best else { return Err(CliError::failed("nothing was measured")) };
    Ok(Report { wagons: WAGONS, connections: CONNECTIONS, http, bare_http })
}

/// Loads a service that runs on a thread of its own.
fn served<F: Future<Output = ()> + 'static>(
    serve: impl FnOnce(TcpListener, oneshot::Receiver<()>) -> F + Send + 'static,
) -> Result<Load, CliError> {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").map_err(CliError::failed)?;
    listener.set_nonblocking(true).map_err(CliError::failed)?;
    let address: SocketAddr = listener.local_addr().map_err(CliError::failed)?;
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(CliError::failed)?;
    let (stop, stopped) = oneshot::channel();
    let server = std::thread::spawn(move || {
        runtime.block_on(async move {
            if let Ok(listener) = TcpListener::from_std(listener) {
                serve(listener, stopped).await;
            }
        });
    });
    let load = load::run(address, PATH, CONNECTIONS, LOAD);
    drop(stop);
    let _ = server.join();
    load
}

/// A wagon that says about as much as a real one.
fn health(wagon: u32) -> Health {
    let judged = |value: f64| Indicator {
        value,
        low: value - 0.011,
        high: value + 0.012,
        grade: Grade::Ok.code(),
        known: 1,
        reason: "as it should be: 0.356 ± 0.011 over 44 s of braking, 102 % of nominal 0.350".into(),
    };
    let mut health = Health {
        wagon,
        wheelsets: 2,
        acquired: now(),
        published_monotonic_ns: now().monotonic_ns,
        samples: 100_000,
        v_m_s: 20.123,
        mu_w: -0.0812,
        grade: Grade::Ok.code(),
        ..Health::default()
    };
    BRAKE_FRICTION.put(&mut health, judged(0.35615));
    ASYMMETRY.put(&mut health, judged(-0.0254));
    ADHESION_AVAILABLE.put(&mut health, judged(0.2123));
    for index in 0..2 {
        BRAKE_FRICTION.put_wheelset(&mut health, index, judged(0.351));
    }
    health
}
