//! `railgrip bench --gap`: the fast integrator and its stages beside the wagon model it stands for, and a whole diagnosis of a case
//! that the truth plant makes, in a process of its own, with its time, processor time and peak memory, and how the time is shared
//! among its parts and among its passes over the recordings.

use std::hint::black_box;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use railgrip_diagnosis::data::case::{Case, Run, Sample};
use railgrip_diagnosis::data::load;
use railgrip_diagnosis::model::parameters::Shape;
use railgrip_diagnosis::predict::open_loop;
use railgrip_diagnosis::predict::passes::{self, Pass, Spent};
use railgrip_diagnosis::wagon::{Options, diagnose};
use railgrip_truth_plant::{Case as TrueCase, Recipe, files};
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion};
use railgrip_vehicle::{EffectEntry, Loading, MAX_WHEELSETS, WagonInput, WagonModel, WagonState};

use crate::output::say;
use crate::{CliError, process_figures as figures};

/// Effect of the case that is made: one with a hidden state, which costs most.
const EFFECT: &str = "brake_fade";
/// Seed of the case, so that every machine diagnoses the same.
const SEED: u64 = 11;
/// Time spent on each integrator, s.
const SECONDS_A_LINE: f64 = 0.5;
/// The child's figures are read this often; its peak memory is kept by the system in between.
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// What a diagnosis may take and use.
const AIM_S: f64 = 10.0;
const AIM_MB: f64 = 1024.0;

/// What a diagnosis says when it begins a part of its work, and that part; before the first it calibrates and selects.
const PARTS: [(&str, &str); 4] = [
    ("gap", "effects on the windows of the gap"),
    ("verdict", "free curves and the verdict"),
    ("fit on windows", "fits on all windows, predictions"),
    ("report", "report"),
];
/// What comes before these.
const FIRST_PART: &str = "calibration and selection by filters";

/// What was measured.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Report {
    integrators: Vec<Line>,
    diagnosis: Diagnosis,
    parts: Vec<Part>,
    passes: Vec<Passes>,
}

/// A part of a diagnosis.
#[derive(Debug, serde::Serialize)]
struct Part {
    what: &'static str,
    /// Of the time of the whole.
    share: f64,
}

/// Passes of one kind over the recordings that are fitted.
#[derive(Debug, serde::Serialize)]
struct Passes {
    what: &'static str,
    /// How often each of their samples was gone through.
    passes: f64,
    /// A sample of one run.
    nanoseconds: f64,
    /// Over the plain model's.
    ratio: f64,
    /// Of the time of all passes.
    share: f64,
}

/// Time of one sample of one simulated run.
#[derive(Debug, serde::Serialize)]
struct Line {
    what: &'static str,
    nanoseconds: f64,
    /// Over the plain model's.
    ratio: f64,
}

/// One whole diagnosis.
#[derive(Debug, serde::Serialize)]
struct Diagnosis {
    case: String,
    runs: usize,
    recorded_s: f64,
    samples: usize,
    verdict: String,
    effects: Vec<String>,
    wall_s: f64,
    cpu_s: f64,
    cores: usize,
    peak_memory_mb: f64,
    /// Processor time over that of simulating every recorded sample once with the plain model.
    in_plain_simulations: f64,
}

/// Makes the case, times the integrators on it, diagnoses it.
pub(crate) fn run() -> Result<Report, CliError> {
    let folder = std::env::temp_dir().join(format!("railgrip-bench-gap-{}", std::process::id()));
    let result = measure(&folder);
    let _ = std::fs::remove_dir_all(&folder);
    result
}

fn measure(folder: &Path) -> Result<Report, CliError> {
    let case = make(folder)?;
    let integrators = integrators(&case)?;
    let plain_ns = integrators[0].nanoseconds;
    let diagnosis = diagnosis(folder, &case, plain_ns)?;
    let (parts, passes) = shares(&case, plain_ns);
    Ok(Report { integrators, diagnosis, parts, passes })
}

/// The case, in a folder `case`, and as it is read from there.
fn make(folder: &Path) -> Result<Case, CliError> {
    let recipe = Recipe { name: "case".into(), seed: SEED, departures: vec![EFFECT.into()] };
    let made = TrueCase::make(&recipe).map_err(CliError::failed)?;
    let path = folder.join("case");
    files::write_case(&path, &made.sheet.to_toml(), &made.runs).map_err(CliError::failed)?;
    let vehicle = railgrip_settings::vehicle::load(&path.join("vehicle.toml")).map_err(CliError::failed)?;
    load::load(&path, vehicle).map_err(CliError::failed)
}

/// Nanoseconds of one sample: the best of several rounds over a run.
fn time(run: &Run, mut over: impl FnMut(&Run)) -> f64 {
    let started = Instant::now();
    let mut best = f64::INFINITY;
    while started.elapsed().as_secs_f64() < SECONDS_A_LINE {
        let round = Instant::now();
        over(black_box(run));
        best = best.min(round.elapsed().as_secs_f64() / run.len() as f64);
    }
    best * 1e9
}

fn integrators(case: &Case) -> Result<Vec<Line>, CliError> {
    let Some(run) = case.fit.iter().max_by_key(|run| run.len()) else {
        return Err(CliError::failed("the case has no run"));
    };
    let model = WagonModel::new(&case.vehicle).map_err(CliError::failed)?;
    let plain = time(run, |run| plain_simulation(&model, case.vehicle.rail.adhesion(run.rail), run));
    let mut lines = vec![Line { what: "wagon model, simulated plainly", nanoseconds: plain, ratio: 1.0 }];
    for (what, ids) in [
        ("fast integrator, no effect", &[][..]),
        ("the same with brake_fade", &["brake_fade"][..]),
        (
            "the same with brake_fade, brake_lag, speed_latency",
            &["brake_fade", "brake_lag", "speed_latency"][..],
        ),
    ] {
        let mut with = case.clone();
        let entry = |id: &&str| EffectEntry { id: (*id).into(), parameters: Default::default() };
        with.vehicle.effects = ids.iter().map(entry).collect();
        let shape = Shape::nominal(&with);
        let built = shape.build(&shape.start());
        let nanoseconds = time(run, |run| {
            black_box(open_loop::predict(&built, run));
        });
        lines.push(Line { what, nanoseconds, ratio: nanoseconds / plain });
        if ids.len() == MOST_EFFECTS {
            let wagon = FastWagon::new(&built.model, built.adhesion(run.rail), run.dt_s);
            lines.extend(stages(&wagon, run).map(|(what, nanoseconds)| Line {
                what,
                nanoseconds,
                ratio: nanoseconds / plain,
            }));
        }
    }
    Ok(lines)
}

/// Effects in the line whose stages are timed.
const MOST_EFFECTS: usize = 3;

/// Nanoseconds of the stages of the fast integrator, each alone, along the recorded motion.
fn stages(wagon: &FastWagon, run: &Run) -> [(&'static str, f64); 3] {
    let first = &run.samples[0];
    let hidden = wagon.start_hidden(&first.outputs, &first.input);
    let motions: Vec<Motion> = run.samples.iter().map(Sample::measured_motion).collect();
    let loading = |(motion, sample): (&Motion, &Sample)| {
        wagon.loading_at(motion, &sample.input, &Disturbance::default(), &hidden)
    };
    let loadings: Vec<Loading> = motions.iter().zip(&run.samples).map(loading).collect();
    let laws = time(run, |run| {
        for at in motions.iter().zip(&run.samples) {
            black_box(loading(at));
        }
    });
    let contact = time(run, |_| {
        for (motion, loading) in motions.iter().zip(&loadings) {
            black_box(wagon.coarse(motion, loading));
        }
    });
    let readings = time(run, |run| {
        for (motion, sample) in motions.iter().zip(&run.samples) {
            black_box(wagon.read(motion, &sample.input, &hidden));
        }
    });
    [
        ("  of which laws of pads, rail and body forces", laws),
        ("  of which contact and speeds, in one step", contact),
        ("  of which readings of the sensors", readings),
    ]
}

/// The run's inputs through [`WagonModel::step`], from the first sample to the last.
fn plain_simulation(model: &WagonModel, adhesion: f64, run: &Run) {
    let first = &run.samples[0];
    let mut state = WagonState { v_m_s: first.outputs[0], ..WagonState::default() };
    state.wheel_speed_rad_s.copy_from_slice(&first.outputs[1..]);
    let mut input = WagonInput { adhesion_peak: [adhesion; MAX_WHEELSETS], ..WagonInput::default() };
    let mut acceleration_m_s2 = 0.0;
    for sample in &run.samples {
        input.time_s = sample.input.time_s;
        input.grade_rad = sample.input.grade_rad;
        input.pressing_force_n = sample.input.mid_pressing_force_n;
        input.drive_torque_nm = sample.input.mid_drive_torque_nm;
        let loading = model.loading(&model.operating(&state, &input), &input, run.dt_s, &[]);
        state = model.step(&state, &loading, run.dt_s, &mut acceleration_m_s2);
    }
    black_box(&state);
}

fn diagnosis(folder: &Path, case: &Case, plain_ns: f64) -> Result<Diagnosis, CliError> {
    let report = folder.join("report.json");
    let started = Instant::now();
    let mut child = Command::new(std::env::current_exe().map_err(CliError::failed)?)
        .args(["gap", "diagnose"])
        .arg(folder.join("case"))
        .arg("--json")
        .arg(&report)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .map_err(CliError::failed)?;
    let (cpu_s, peak_memory_mb) = watch(&mut child)?;
    let wall_s = started.elapsed().as_secs_f64();
    let text = std::fs::read_to_string(&report).map_err(CliError::failed)?;
    let report: serde_json::Value = serde_json::from_str(&text).map_err(CliError::failed)?;
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let runs = || case.fit.iter().chain(&case.holdout);
    let samples: usize = runs().map(Run::len).sum();
    Ok(Diagnosis {
        case: format!("{EFFECT}, seed {SEED}"),
        runs: runs().count(),
        recorded_s: runs().map(|run| run.len() as f64 * run.dt_s).sum(),
        samples,
        verdict: text(&report["verdict"]),
        effects: report["effects"]
            .as_array()
            .into_iter()
            .flatten()
            .map(|effect| text(&effect["id"]))
            .collect(),
        wall_s,
        cpu_s,
        cores: std::thread::available_parallelism().map_or(1, usize::from),
        peak_memory_mb,
        in_plain_simulations: cpu_s / (1e-9 * plain_ns * samples as f64),
    })
}

/// How the time of a diagnosis, in this process, is shared among its parts and among passes.
fn shares(case: &Case, plain_ns: f64) -> (Vec<Part>, Vec<Passes>) {
    let before = passes::spent();
    let parts = parts(case);
    let spent: Vec<Spent> =
        passes::spent().into_iter().zip(before).map(|(after, before)| after.since(before)).collect();
    let all_ns: u64 = spent.iter().map(|spent| spent.nanoseconds).sum();
    let samples: usize = case.fit.iter().map(Run::len).sum();
    let line = |kind: Pass, spent: Spent| {
        let nanoseconds = spent.nanoseconds as f64 / spent.samples as f64;
        Passes {
            what: label(kind),
            passes: spent.samples as f64 / samples as f64,
            nanoseconds,
            ratio: nanoseconds / plain_ns,
            share: spent.nanoseconds as f64 / all_ns as f64,
        }
    };
    let spent = Pass::ALL.into_iter().zip(spent).filter(|(_, spent)| spent.samples > 0);
    (parts, spent.map(|(kind, spent)| line(kind, spent)).collect())
}

/// What a pass is called.
fn label(kind: Pass) -> &'static str {
    match kind {
        Pass::Gains => "filters that compute their gains",
        Pass::Frozen => "filters with frozen gains",
        Pass::Path => "filters that leave their path",
        Pass::Response => "responses along a path",
        Pass::Windows => "windows of the gap, open loop",
        Pass::Freed => "filters with a place freed",
    }
}

/// How the time of a diagnosis, in this process, is shared among its parts.
fn parts(case: &Case) -> Vec<Part> {
    let began = Mutex::new(vec![(FIRST_PART, Instant::now())]);
    let note = |said: &'static str| {
        let part = PARTS.iter().find(|(label, _)| *label == said);
        if let (Some((_, what)), Ok(mut began)) = (part, began.lock()) {
            began.push((*what, Instant::now()));
        }
    };
    diagnose(case, &Options::default(), &note);
    let ended = Instant::now();
    let began = began.into_inner().unwrap_or_default();
    let whole = began.first().map_or(0.0, |(_, first)| (ended - *first).as_secs_f64());
    let ends = began.iter().skip(1).map(|(_, at)| *at).chain([ended]);
    let of_whole = |((what, at), end): (&(&'static str, Instant), Instant)| Part {
        what,
        share: (end - *at).as_secs_f64() / whole,
    };
    began.iter().zip(ends).map(of_whole).collect()
}

/// Processor time, s, and peak memory, MB, of a child that runs to its end.
fn watch(child: &mut Child) -> Result<(f64, f64), CliError> {
    let (mut cpu_s, mut peak_mb) = (0.0_f64, 0.0_f64);
    loop {
        if let Some(now) = figures::cpu_s(child.id()) {
            cpu_s = cpu_s.max(now);
        }
        if let Some(now) = figures::peak_mb(child.id()) {
            peak_mb = peak_mb.max(now);
        }
        match child.try_wait().map_err(CliError::failed)? {
            None => std::thread::sleep(LOOK_EVERY),
            Some(status) if status.success() => return Ok((cpu_s, peak_mb)),
            Some(status) => return Err(CliError::failed(format!("the diagnosis ended with {status}"))),
        }
    }
}

/// The report for people.
pub(crate) fn show(report: &Report) {
    say(&format!("{:<54} {:>9} {:>7}", "one sample of one run", "ns", "ratio"));
    for line in &report.integrators {
        say(&format!("{:<54} {:>9.0} {:>7.2}", line.what, line.nanoseconds, line.ratio));
    }
    let d = &report.diagnosis;
    say(&format!(
        "\ndiagnosis of a case with {}: {} runs, {:.0} s, {} samples, 27 and more candidates\n  answer {} {}",
        d.case,
        d.runs,
        d.recorded_s,
        d.samples,
        d.verdict,
        d.effects.join(", ")
    ));
    say(&format!("  wall          {:>8.1} s on {} cores (aim {AIM_S:.0} s)", d.wall_s, d.cores));
    say(&format!(
        "  processor     {:>8.1} s = {:.0} plain simulations of every sample",
        d.cpu_s, d.in_plain_simulations
    ));
    say(&format!("  peak memory   {:>8.0} MB (aim {AIM_MB:.0} MB)", d.peak_memory_mb));
    say(&format!("\n{:<54} {:>9}", "part of a diagnosis", "share"));
    for part in &report.parts {
        say(&format!("{:<54} {:>8.0}%", part.what, 100.0 * part.share));
    }
    say(&format!(
        "\n{:<40} {:>8} {:>8} {:>7} {:>7}",
        "over the fitted samples", "passes", "ns", "ratio", "share"
    ));
    for line in &report.passes {
        say(&format!(
            "{:<40} {:>8.0} {:>8.0} {:>7.2} {:>6.0}%",
            line.what,
            line.passes,
            line.nanoseconds,
            line.ratio,
            100.0 * line.share
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_integrator_is_timed_on_the_case() {
        let folder = tempfile::tempdir().unwrap();
        let lines = integrators(&make(folder.path()).unwrap()).unwrap();
        assert_eq!(lines.len(), 7);
        for line in lines {
            assert!(line.nanoseconds > 0.0 && line.nanoseconds.is_finite(), "{}", line.what);
        }
    }

    #[test]
    fn the_parts_of_a_diagnosis_make_up_the_whole_and_its_passes_are_counted() {
        let folder = tempfile::tempdir().unwrap();
        let (parts, passes) = shares(&make(folder.path()).unwrap(), 1.0);
        let known: Vec<&str> = PARTS.iter().map(|(_, what)| *what).collect();
        let found: Vec<&str> = parts.iter().map(|part| part.what).collect();
        assert_eq!(found[0], FIRST_PART);
        assert_eq!(found[1..], known);
        let whole: f64 = parts.iter().map(|part| part.share).sum();
        assert!((whole - 1.0).abs() < 1e-9, "{whole}");
        for line in &passes {
            println!("{}: {:.0} passes, share {:.2}", line.what, line.passes, line.share);
        }
        for kind in [Pass::Gains, Pass::Frozen, Pass::Windows, Pass::Freed] {
            assert!(passes.iter().any(|line| line.what == label(kind) && line.passes > 1.0), "{kind:?}");
        }
    }
}
