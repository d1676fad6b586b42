//! `railgrip bench --train`: a long train at a high rate on this machine: what it costs, whether it loses samples, and how
//! quick its HTTP service is meanwhile, beside a bare axum handler that answers the same bytes.

use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::bench_up::{self, Up};
use crate::load::Load;
use crate::output::say;
use crate::{CliError, process_figures as figures};

/// Wagons of the train, one estimator process each.
const WAGONS: usize = 64;
/// Samples a second of each wagon.
const RATE_HZ: f64 = 1000.0;
/// Samples of so many milliseconds travel together: as by default.
const BATCH_MS: f64 = 20.0;
/// How long the train is watched.
const WATCH: Duration = Duration::from_secs(10);
/// How long requests are sent to each of the two services.
const LOAD: Duration = Duration::from_secs(4);
const CLIENTS: usize = 2;

/// What was measured.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Report {
    wagons: usize,
    samples_a_second_and_wagon: f64,
    seconds: f64,
    samples_taken: u64,
    samples_missed: u64,
    processes: Vec<figures::Group>,
    cpu_percent_of_one_core: f64,
    /// What the steps of the default filter alone would take, one after another, % of one core: the reference.
    filter_percent_of_one_core: f64,
    http: Load,
    bare_http: Load,
}

/// Starts the train, watches it, loads its HTTP service, stops it. `step_ns`: what a step of the default filter takes here.
pub(crate) fn run(step_ns: f64) -> Result<Report, CliError> {
    let up = Up::start("rgt", |_| Ok(config()), Stdio::null())?;
    watch(&up, step_ns)
}

/// The report for people.
pub(crate) fn show(report: &Report) {
    say(&format!(
        "{} wagons at {:.0} Hz in batches of {BATCH_MS:.0} ms: {} samples in {:.1} s, {} missed",
        report.wagons,
        report.samples_a_second_and_wagon,
        report.samples_taken,
        report.seconds,
        report.samples_missed
    ));
    say("process      number   CPU, % of a core   PSS of one, MB");
    for group in &report.processes {
        say(&format!(
            "{:<12} {:>6}   {:>16.1}   {:>14.2}",
            group.role, group.number, group.cpu_percent, group.pss_mb
        ));
    }
    say(&format!("all                   {:>16.1}", report.cpu_percent_of_one_core));
    say(&format!(
        "the filters' steps alone, one after another: {:.1} % of a core; all costs {:.1} times that",
        report.filter_percent_of_one_core,
        report.cpu_percent_of_one_core / report.filter_percent_of_one_core
    ));
    say("GET /api/v1/wagons meanwhile     requests/s   p50 µs   p99 µs");
    for (name, load) in
        [("this train's service", report.http), ("bare axum, the same bytes", report.bare_http)]
    {
        say(&format!(
            "{name:<32} {:>10.0} {:>8.0} {:>8.0}",
            load.requests_a_second, load.p50_us, load.p99_us
        ));
    }
}

fn config() -> String {
    format!(
        "schema = 1\n[train]\nname = \"bench\"\nwagons = {WAGONS}\nvehicle = \"vehicle.toml\"\n\
         [source]\nkind = \"simulate\"\nsample_rate_hz = {RATE_HZ:?}\n[samples]\nbatch_ms = {BATCH_MS:?}\n\
         [logging]\nlevel = \"warn\"\n"
    )
}

fn watch(up: &Up, step_ns: f64) -> Result<Report, CliError> {
    up.wait_ready()?;
    // Start-up is over once every page was touched.
    std::thread::sleep(Duration::from_secs(2));
    let before = samples(up)?;
    let watched = Instant::now();
    let (processes, cpu_percent_of_one_core) = figures::watch(up.id(), WATCH);
    let after = samples(up)?;
    let seconds = watched.elapsed().as_secs_f64();
    let url = up.url("/api/v1/wagons")?;
    let body = up.text("/api/v1/wagons")?;
    let http = load(&url)?;
    let bare_http = bare(body)?;
    Ok(Report {
        wagons: WAGONS,
        samples_a_second_and_wagon: RATE_HZ,
        seconds,
        samples_taken: after.0 - before.0,
        samples_missed: after.1,
        processes,
        cpu_percent_of_one_core,
        filter_percent_of_one_core: 100.0 * WAGONS as f64 * RATE_HZ * step_ns * 1e-9,
        http,
        bare_http,
    })
}

/// Samples taken in and missed by all estimators, from their heartbeats.
fn samples(up: &Up) -> Result<(u64, u64), CliError> {
    let train = up.json("/api/v1/train")?;
    Ok((bench_up::sum(&train, "estimator", "received"), bench_up::sum(&train, "estimator", "missed")))
}

/// Clients that ask again as soon as they have an answer.
fn load(url: &str) -> Result<Load, CliError> {
    let rest = url.trim_start_matches("http://");
    let (address, path) = rest.split_once('/').unwrap_or((rest, ""));
    crate::load::run(address.parse().map_err(CliError::failed)?, &format!("/{path}"), CLIENTS, LOAD)
}

/// The same load on a handler that does nothing but answer.
fn bare(body: String) -> Result<Load, CliError> {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").map_err(CliError::failed)?;
    listener.set_nonblocking(true).map_err(CliError::failed)?;
    let url = format!("http://{}/", listener.local_addr().map_err(CliError::failed)?);
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(CliError::failed)?;
    let json = [(axum::http::header::CONTENT_TYPE, "application/json")];
    let handler = axum::routing::get(move || std::future::ready((json, body.clone())));
    let router = axum::Router::new().route("/", handler);
    let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
    std::thread::scope(|scope| {
        let server = scope.spawn(move || {
            runtime.block_on(async {
                let listener = tokio::net::TcpListener::from_std(listener)?;
                let until = async { drop(stopped.await) };
                tokio::select! {
                    result = axum::serve(listener, router) => result,
                    () = until => Ok(()),
                }
            })
        });
        let result = load(&url);
        drop(stop);
        let _ = server.join();
        result
    })
}
