//! `railgrip bench`: how fast the parts are on this machine, each beside a reference measured in the same run, because a
//! ratio says more than a time.

use std::hint::black_box;

use nalgebra::{DMatrix, DVector};
use railgrip_filter::models::{DrivenSample, PaperFilter, WagonFilter, WagonPhysics};
use railgrip_filter::{EstimatorConfig, WagonEstimator, WagonSample};
use railgrip_vehicle::{VehicleParameters, WagonInput, WagonModel, WagonState};

use crate::bench_line::{Line, line, time};
use crate::output::say;
use crate::{
    CliError, bench_acoustics, bench_gap, bench_history, bench_http, bench_source, bench_train,
    bench_transport, bench_unscented,
};

/// The vehicle that is timed.
const VEHICLE: &str = include_str!("../../../config/vehicle.toml");

/// Measure the speed of the parts on this machine.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
    /// Measure the latency from ingest to estimate through real processes instead
    #[arg(long)]
    transport: bool,
    /// Measure a train of 64 wagons at 1 kHz, and its HTTP service under load, instead
    #[arg(long, conflicts_with = "transport")]
    train: bool,
    /// Measure listening to one second of audio instead
    #[arg(long, conflicts_with_all = ["transport", "train"])]
    acoustics: bool,
    /// Measure the HTTP service of 64 wagons on one thread instead
    #[arg(long, conflicts_with_all = ["transport", "train", "acoustics"])]
    http: bool,
    /// Measure what the history writes and how fast it answers instead
    #[arg(long, conflicts_with_all = ["transport", "train", "acoustics", "http"])]
    history: bool,
    /// Measure the diagnosis of the sim-to-real gap instead: its kernel, and one whole case with time and memory
    #[arg(long, conflicts_with_all = ["transport", "train", "acoustics", "http", "history"])]
    gap: bool,
    #[command(flatten)]
    source: bench_source::Options,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    if args.transport {
        return run_transport(args.json);
    }
    if args.train {
        let report = bench_train::run(default_step_ns()?)?;
        if args.json {
            return json(&report);
        }
        bench_train::show(&report);
        return Ok(());
    }
    if args.http {
        let report = bench_http::run()?;
        if args.json {
            return json(&report);
        }
        bench_http::show(&report);
        return Ok(());
    }
    if args.source.wanted() {
        let report = bench_source::run(&args.source)?;
        if args.json {
            return json(&report);
        }
        bench_source::show(&report);
        return Ok(());
    }
    if args.history {
        let report = bench_history::run()?;
        if args.json {
            return json(&report);
        }
        bench_history::show(&report);
        return Ok(());
    }
    if args.gap {
        let report = bench_gap::run()?;
        if args.json {
            say(&serde_json::to_string_pretty(&report).map_err(CliError::failed)?);
        } else {
            bench_gap::show(&report);
        }
        return Ok(());
    }
    let lines = if args.acoustics { bench_acoustics::lines()? } else { filter_lines(&vehicle()?)? };
    if args.json {
        say(&serde_json::to_string_pretty(&lines).map_err(CliError::failed)?);
        return Ok(());
    }
    say(&format!("{:<44} {:>9}   {:<44} {:>9} {:>7}", "part", "ns", "reference in this run", "ns", "ratio"));
    for line in &lines {
        say(&format!(
            "{:<44} {:>9.0}   {:<44} {:>9.0} {:>7.3}",
            line.what, line.nanoseconds, line.reference, line.reference_nanoseconds, line.ratio
        ));
    }
    Ok(())
}

/// The vehicle of all these figures.
fn vehicle() -> Result<VehicleParameters, CliError> {
    railgrip_settings::vehicle::parse(std::path::Path::new("built-in vehicle"), VEHICLE)
        .map_err(CliError::failed)
}

/// What a step of the default filter takes here, ns.
fn default_step_ns() -> Result<f64, CliError> {
    let vehicle = vehicle()?;
    let estimator = WagonEstimator::new(&EstimatorConfig::default(), &vehicle).map_err(CliError::failed)?;
    Ok(time_estimator(estimator, &vehicle))
}

fn json(report: &impl serde::Serialize) -> Result<(), CliError> {
    say(&serde_json::to_string_pretty(report).map_err(CliError::failed)?);
    Ok(())
}

fn run_transport(json: bool) -> Result<(), CliError> {
    let lines = bench_transport::run()?;
    if json {
        say(&serde_json::to_string_pretty(&lines).map_err(CliError::failed)?);
    } else {
        bench_transport::show(&lines);
    }
    Ok(())
}

fn filter_lines(vehicle: &VehicleParameters) -> Result<Vec<Line>, CliError> {
    let model = WagonModel::new(vehicle).map_err(CliError::failed)?;
    let dense = time_dense();
    let dense_name = "the same with matrices of dynamic size";
    let config = EstimatorConfig::default();
    let paper = time_paper(&config, vehicle, &model);
    let mut lines = vec![line("wagon EKF of 6 states, predict + update", paper, dense_name, dense)];
    let paper_name = "wagon EKF of 6 states, predict + update";
    for (what, filter) in [
        ("estimator step, filter \"paper\"", "paper"),
        ("estimator step, filter \"rig\"", "rig"),
        ("estimator step, filter \"default\"", "default"),
        ("estimator step, filter \"imm\"", "imm"),
    ] {
        let config = EstimatorConfig { filter: filter.into(), ..config.clone() };
        let estimator = WagonEstimator::new(&config, vehicle).map_err(CliError::failed)?;
        lines.push(line(what, time_estimator(estimator, vehicle), paper_name, paper));
    }
    lines.push(line("wagon model, one step of 10 ms", time_model(vehicle, &model), paper_name, paper));
    let dense = time(bench_unscented::dense_step());
    for step in bench_unscented::filters() {
        lines.push(line(step.name, step.step_ns, "UKF of 13 states with matrices of dynamic size", dense));
    }
    Ok(lines)
}

/// A sample of steady braking from 20 m/s.
fn sample(vehicle: &VehicleParameters) -> DrivenSample {
    let wheel = 20.0 / vehicle.wheelset.radius_m;
    DrivenSample {
        v_m_s: 20.0,
        wheel_speed_rad_s: [wheel, wheel, 0.0, 0.0],
        pressing_force_n: [3e4, 3e4, 0.0, 0.0],
        step_force_n: [3e4, 3e4, 0.0, 0.0],
        ..DrivenSample::default()
    }
}

fn time_paper(config: &EstimatorConfig, vehicle: &VehicleParameters, model: &WagonModel) -> f64 {
    let mut filter = PaperFilter::<2, 6>::new(config, vehicle, WagonPhysics::new(model));
    let sample = sample(vehicle);
    filter.start(&sample);
    let start = filter.clone();
    let mut steps = 0_u32;
    time(move || {
        let sample = black_box(&sample);
        let input = filter.step_input(sample, 0.01);
        filter.predict_step(&input);
        for output in 0..3 {
            let update = filter.expect(output, sample.measured(output));
            filter.accept(output, &update);
        }
        // The same measurements for ever would drive the pads away; a fresh start now and then keeps the numbers usual.
        steps += 1;
        if steps.is_multiple_of(1000) {
            filter = start.clone();
        }
        black_box(&filter.belief);
    })
}

/// Predict and joint update of six states with heap matrices: what a filter without fixed sizes costs.
fn time_dense() -> f64 {
    let f = DMatrix::<f64>::identity(6, 6);
    let q = DMatrix::<f64>::identity(6, 6) * 1e-3;
    let h = DMatrix::<f64>::from_fn(3, 6, |row, column| f64::from(u8::from(row == column)));
    let r = DMatrix::<f64>::identity(3, 3) * 1e-3;
    let mut x = DVector::<f64>::zeros(6);
    let mut p = DMatrix::<f64>::identity(6, 6);
    time(move || {
        x = &f * &x;
        p = &f * &p * f.transpose() + &q;
        let s = &h * &p * h.transpose() + &r;
        if let Some(factor) = s.cholesky() {
            let gain = factor.solve(&(&h * &p)).transpose();
            x += &gain * (DVector::from_element(3, 0.1) - &h * &x);
            let keep = DMatrix::<f64>::identity(6, 6) - &gain * &h;
            p = &keep * &p * keep.transpose() + &gain * &r * gain.transpose();
        }
        black_box(&p);
    })
}

fn time_estimator(mut estimator: WagonEstimator, vehicle: &VehicleParameters) -> f64 {
    let wheel = 20.0 / vehicle.wheelset.radius_m;
    let mut input = WagonSample {
        v_m_s: 20.0,
        wheel_speed_rad_s: [wheel, wheel, f64::NAN, f64::NAN],
        pressing_force_n: [3e4, 3e4, f64::NAN, f64::NAN],
        drive_torque_nm: [0.0; 4],
        grade_rad: 0.0,
        sanding: 0.0,
        ..WagonSample::missing(0.0)
    };
    let mut noise = 1_u32;
    time(move || {
        input.time_s += 0.01;
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        input.v_m_s = 20.0 + 0.05 * (f64::from(noise >> 8) / 16_777_216.0 - 0.5);
        black_box(estimator.step(black_box(&input)));
    })
}

fn time_model(vehicle: &VehicleParameters, model: &WagonModel) -> f64 {
    let wheel = 20.0 / vehicle.wheelset.radius_m;
    let input = WagonInput { pressing_force_n: [3e4, 3e4, 0.0, 0.0], ..WagonInput::default() };
    let start = WagonState { v_m_s: 20.0, wheel_speed_rad_s: [wheel, wheel, 0.0, 0.0] };
    let loading = model.loading(&model.operating(&start, &input), &input, 0.01, &[]);
    let mut acceleration_m_s2 = 0.0;
    time(move || {
        black_box(model.step(black_box(&start), &loading, 0.01, &mut acceleration_m_s2));
    })
}
