//! `railgrip bench --train`: a long train at a high rate on this machine: what it costs, whether it loses samples, and how
//! quick its HTTP service is meanwhile, beside a bare axum handler that answers the same bytes.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::load::Load;
use crate::output::say;
use crate::{CliError, process_figures as figures};

/// Wagons of the train, one estimator process each.
const WAGONS: usize = 64;
/// Samples a second of each wagon.
const RATE_HZ: f64 = 1000.0;
/// How long the train is watched.
const WATCH: Duration = Duration::from_secs(10);
/// How long requests are sent to each of the two services.
const LOAD: Duration = Duration::from_secs(4);
const CLIENTS: usize = 2;
const START_PATIENCE: Duration = Duration::from_secs(30);
const VEHICLE: &str = include_str!("../../../config/vehicle.toml");

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
    http: Load,
    bare_http: Load,
}

/// Starts the train, watches it, loads its HTTP service, stops it.
pub(crate) fn run() -> Result<Report, CliError> {
    let folder = std::env::temp_dir().join(format!("rgt{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(CliError::failed)?;
    let result = start(&folder).and_then(|mut up| {
        let result = watch(&folder, up.id());
        stop(&mut up);
        result
    });
    let _ = std::fs::remove_dir_all(&folder);
    result
}

/// The report for people.
pub(crate) fn show(report: &Report) {
    say(&format!(
        "{} wagons at {:.0} Hz in batches of 10 ms: {} samples in {:.1} s, {} missed",
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

fn start(folder: &Path) -> Result<Child, CliError> {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).map_err(CliError::failed);
    write("vehicle.toml", VEHICLE)?;
    write(
        "train.toml",
        &format!(
            "schema = 1\n[train]\nname = \"bench\"\nwagons = {WAGONS}\nvehicle = \"vehicle.toml\"\n\
             [source]\nkind = \"simulate\"\nsample_rate_hz = {RATE_HZ:?}\n[samples]\nbatch_ms = 10.0\n\
             [logging]\nlevel = \"warn\"\n"
        ),
    )?;
    Command::new(std::env::current_exe().map_err(CliError::failed)?)
        .args(["up", "--listen", "127.0.0.1:0", "--config"])
        .arg(folder.join("train.toml"))
        .arg("--instance")
        .arg(folder.join("i"))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .map_err(CliError::failed)
}

fn stop(up: &mut Child) {
    let pid = rustix::process::Pid::from_child(up);
    let _ = rustix::process::kill_process(pid, rustix::process::Signal::TERM);
    let _ = up.wait();
}

fn watch(folder: &Path, up: u32) -> Result<Report, CliError> {
    let base = address(folder)?;
    let agent = agent();
    let started = Instant::now();
    while agent.get(format!("{base}/health/ready")).call().is_err() {
        if started.elapsed() > START_PATIENCE {
            return Err(CliError::failed("the train does not become ready"));
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    // Start-up is over once every page was touched.
    std::thread::sleep(Duration::from_secs(2));
    let before = samples(&agent, &base)?;
    let watched = Instant::now();
    let (processes, cpu_percent_of_one_core) = figures::watch(up, WATCH);
    let after = samples(&agent, &base)?;
    let seconds = watched.elapsed().as_secs_f64();
    let url = format!("{base}/api/v1/wagons");
    let body = text(&agent, &url)?;
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
        http,
        bare_http,
    })
}

fn agent() -> ureq::Agent {
    ureq::Agent::config_builder().timeout_global(Some(Duration::from_secs(10))).build().into()
}

fn text(agent: &ureq::Agent, url: &str) -> Result<String, CliError> {
    let mut answer = agent.get(url).call().map_err(CliError::failed)?;
    answer.body_mut().read_to_string().map_err(CliError::failed)
}

fn address(folder: &Path) -> Result<String, CliError> {
    let file = folder.join("i").join("http.address");
    let started = Instant::now();
    while started.elapsed() < START_PATIENCE {
        match std::fs::read_to_string(&file) {
            Ok(text) if !text.trim().is_empty() => {
                return Ok(format!("http://{}", text.trim().trim_start_matches("http://")));
            }
            _ => std::thread::sleep(Duration::from_millis(50)),
        }
    }
    Err(CliError::failed("the train serves no HTTP"))
}

/// Samples taken in and missed by all estimators, from their heartbeats.
fn samples(agent: &ureq::Agent, base: &str) -> Result<(u64, u64), CliError> {
    let train: Value =
        serde_json::from_str(&text(agent, &format!("{base}/api/v1/train"))?).map_err(CliError::failed)?;
    let processes = train["processes"].as_array().map(Vec::as_slice).unwrap_or_default();
    let estimators = processes.iter().filter(|process| process["process"] == "estimator");
    let sum = |name: &str| estimators.clone().filter_map(|process| process[name].as_u64()).sum();
    Ok((sum("received"), sum("missed")))
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
