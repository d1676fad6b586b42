//! Cases as real vehicles give them: other rates, gaps, trailers, rail that nobody noted, few runs. The truth plant makes the
//! runs; here they are damaged.

#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests print what they measure and should fail where they can"
)]

use railgrip_diagnosis::data::case::{Case, Run};
use railgrip_diagnosis::data::load;
use railgrip_diagnosis::decide::selection;
use railgrip_diagnosis::predict::disturbances::DisturbanceModel;
use railgrip_diagnosis::predict::one_step::Predictor;
use railgrip_diagnosis::predict::open_loop;
use railgrip_diagnosis::wagon::{Options, diagnose};
use railgrip_diagnosis::write::predictions;
use railgrip_truth_plant::departure::Departures;
use railgrip_truth_plant::departures::Kind;
use railgrip_truth_plant::plant::{self, Plant};
use railgrip_truth_plant::programme;
use railgrip_truth_plant::random::Stream;
use railgrip_truth_plant::sheet::Sheet;
use railgrip_truth_plant::wagon::{Nuisances, TrueWagon};
use railgrip_vehicle::RailClass;
use std::path::Path;

/// Columns of a trailer, without torques, sand and position.
const TRAILER: &str = "t_s,v_m_s,omega_f_rad_s,omega_r_rad_s,f_perp_f_n,f_perp_r_n,grade_rad";

/// The plant's runs of these names, in this order, with the departure `id` at this strength.
fn drive(seed: u64, departure: Option<(&str, f64)>, names: &[&str]) -> (Sheet, TrueWagon, Vec<plant::Run>) {
    let sheet = Sheet::draw(&mut Stream::new(seed, "sheet", 0), false, false);
    let wagon = TrueWagon::new(&sheet, &Nuisances::draw(&mut Stream::new(seed, "nuisances", 0)));
    let departures = departure
        .map(|(id, strength)| Kind::of(id).unwrap().draw(strength, &mut Stream::new(seed, id, 0), &sheet).0);
    let mut plant = Plant::new(&sheet, &wagon, Departures(departures.into_iter().collect()), seed);
    let orders = programme::orders(&sheet, seed);
    let index = |name: &&str| orders.iter().position(|order| order.name == *name && !order.holdout).unwrap();
    let runs = names.iter().map(index).map(|index| plant.drive(&orders[index], index as u64)).collect();
    (sheet, wagon, runs)
}

/// Cells of a row under [`TRAILER`].
fn cells(row: &plant::Row) -> Vec<String> {
    let [front, rear] = row.wheel_speed_rad_s;
    let [press_f, press_r] = row.pressing_force_n;
    [row.time_s, row.v_m_s, front, rear, press_f, press_r, row.grade_rad]
        .map(|cell| format!("{cell:?}"))
        .to_vec()
}

/// Writes a run with every `step`th row; `change` may alter a row or take it away.
fn write(
    path: &Path,
    run: &plant::Run,
    step: usize,
    change: impl Fn(usize, Vec<String>) -> Option<Vec<String>>,
) {
    let rows = run.rows.iter().step_by(step).enumerate();
    let text: String =
        rows.filter_map(|(k, row)| change(k, cells(row))).map(|cells| cells.join(",") + "\n").collect();
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, format!("{TRAILER}\n{text}")).unwrap();
}

fn read(folder: &Path, sheet: &Sheet) -> Case {
    let case = load::load(folder, toml::from_str(&sheet.to_toml()).unwrap()).unwrap();
    case.notes.iter().for_each(|note| println!("{note}"));
    case
}

fn emptied(mut cells: Vec<String>, columns: &[usize]) -> Vec<String> {
    columns.iter().for_each(|column| cells[*column].clear());
    cells
}

#[test]
fn windows_start_by_time_and_reach_over_no_long_gap() {
    let (sheet, _, runs) = drive(3, None, &["dry_steps", "dry_stop"]);
    let folder = tempfile::tempdir().unwrap();
    // At 20 Hz: the vehicle's speed is missing for 0.4 s and for 1.5 s, a wheelset's for 0.6 s.
    write(&folder.path().join("fit/steps.csv"), &runs[0], 5, |k, cells| {
        Some(match k {
            60..68 => emptied(cells, &[1]),
            300..330 => emptied(cells, &[1]),
            500..512 => emptied(cells, &[3]),
            _ => cells,
        })
    });
    write(&folder.path().join("holdout/stop.dry.csv"), &runs[1], 5, |_, cells| Some(cells));
    let case = read(folder.path(), &sheet);
    let run = &case.fit[0];
    assert_eq!((run.name.as_str(), run.rail), ("steps", RailClass::Undeclared));
    assert!((run.dt_s - 0.05).abs() < 1e-9);
    assert_eq!(run.unbroken[..2], [0..300, 330..500]);
    assert_eq!(run.unbroken[2].start, 512);
    let windows = open_loop::windows(run);
    assert_eq!(windows[..3], [0..200, 200..300, 330..500]);
    assert!(!run.samples[64].measured[0] && run.samples[64].measured[1]);
    assert!(run.samples[64].as_measured(0).is_nan() && run.samples[64].outputs[0].is_finite());
    let said = case.notes.join("\n");
    for word in ["sampled at 20.00 Hz", "taken as a trailer", "declare no rail"] {
        assert!(said.contains(word), "{word}");
    }
    // A window starts at the one sample of its first 0.05 s, and counts what was measured.
    let shape = railgrip_diagnosis::model::parameters::Shape::nominal(&case);
    let built = shape.build(&shape.start());
    let first = &open_loop::predict(&built, run)[0];
    assert_eq!(first.outputs[0], run.samples[0].outputs);
    let tally = open_loop::tally(first, run, &[0.03; 5]);
    assert_eq!((tally.count, tally.missing), (200, [8, 0, 0, 0, 0]));
}

#[test]
fn outputs_that_were_not_measured_have_no_innovation_and_leave_the_others_alone() {
    let (sheet, _, runs) = drive(3, None, &["dry_stop"]);
    let folder = tempfile::tempdir().unwrap();
    let holes = |k: usize| (400..440).contains(&k) || (k > 600 && k.is_multiple_of(7));
    write(&folder.path().join("fit/stop.dry.csv"), &runs[0], 1, |k, cells| {
        Some(if holes(k) { emptied(cells, &[1, 2, 3][..1 + k % 3]) } else { cells })
    });
    write(&folder.path().join("holdout/stop.dry.csv"), &runs[0], 1, |_, cells| Some(cells));
    let case = read(folder.path(), &sheet);
    let shape = railgrip_diagnosis::model::parameters::Shape::nominal(&case);
    let built = shape.build(&shape.start());
    let white = |run: &Run| {
        let mut white = Vec::new();
        let predictor = Predictor::new(&built, run, &case, &DisturbanceModel::default());
        predictor.residuals(&built, run, &mut white);
        white
    };
    let (torn, whole) = (white(&case.fit[0]), white(&case.holdout[0]));
    for (k, sample) in case.fit[0].samples.iter().enumerate() {
        for j in 0..3 {
            assert!(sample.measured[j] || torn[3 * k + j] == 0.0, "sample {k}, output {j}");
        }
    }
    let rms = |white: &[f64]| (white.iter().map(|w| w * w).sum::<f64>() / white.len() as f64).sqrt();
    let n = 3 * 1000..3 * 3000.min(case.fit[0].len());
    println!(
        "rms of whitened innovations {:.3} with holes, {:.3} without",
        rms(&torn[n.clone()]),
        rms(&whole[n.clone()])
    );
    assert!(rms(&torn[n.clone()]) < rms(&whole[n]));
}

#[test]
fn adhesion_of_rail_that_nobody_noted_is_fitted() {
    let (sheet, wagon, runs) = drive(5, None, &["wet_steps", "wet_stop", "dry_stop"]);
    let folder = tempfile::tempdir().unwrap();
    for (run, name) in runs.iter().zip(["fit/a.csv", "holdout/b.csv", "fit/c.dry.csv"]) {
        write(&folder.path().join(name), run, 2, |_, cells| Some(cells));
    }
    let case = read(folder.path(), &sheet);
    let base = selection::calibrate(&case);
    let built = base.fitted.shape.build(&base.fitted.fit.theta);
    let found = built.adhesion(RailClass::Undeclared);
    let truth = wagon.rail_friction(runs[0].order.rail);
    println!(
        "μ0 {found:.4} found from {:.3} on, {truth:.4} in truth",
        sheet.rail_friction(runs[2].order.rail)
    );
    assert!((found / truth - 1.0).abs() < 0.08);
}

#[test]
fn a_late_brake_is_named_in_three_rough_runs_of_a_trailer_at_50_hz() {
    let (sheet, _, runs) =
        drive(1, Some(("brake_lag", 1.0)), &["dry_steps", "wet_steps", "wet_stop", "dry_stop"]);
    let folder = tempfile::tempdir().unwrap();
    let names = ["fit/steps.dry.csv", "fit/steps.csv", "fit/stop.csv", "holdout/stop.dry.csv"];
    for (n, (run, name)) in runs.iter().zip(names).enumerate() {
        write(&folder.path().join(name), run, 2, |k, mut cells| {
            // Single rows and cells missing, times that jitter by 12 %, and of the holdout run four seconds without forces.
            let late = 0.12 * 0.02 * (k as f64 * 2.399 + n as f64).sin();
            cells[0] = format!("{:.5}", 0.02 * k as f64 + late);
            if n == 3 && (700..900).contains(&k) {
                cells[4].clear();
            }
            match k % 97 {
                13 => None,
                31 => Some(emptied(cells, &[2])),
                _ => Some(cells),
            }
        });
    }
    let case = read(folder.path(), &sheet);
    assert_eq!((case.fit.len(), case.holdout.len()), (3, 2), "the holdout run is cut in two");
    let outcome = diagnose(&case, &Options { case: "rough".into(), seed: 1, ..Options::default() }, &|_| ());
    let report = &outcome.report;
    let named: Vec<&str> = report.effects.iter().map(|effect| effect.id.as_str()).collect();
    let gap = &report.gap.holdout;
    println!("{:?} by {}: {named:?}; {gap:?}; {:.1} s", report.verdict, report.rule, report.seconds);
    assert_eq!(named, ["brake_lag"]);
    assert!(gap.extended < 0.6 * gap.calibrated);
    assert_eq!(report.notes, case.notes);

    let names: Vec<&str> = outcome.predictions.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["stop.dry"], "one file for both parts");
    predictions::write(&outcome.predictions, folder.path()).unwrap();
    let text = std::fs::read_to_string(folder.path().join("stop.dry.csv")).unwrap();
    assert!(!text.contains("NaN") && text.contains(",,"), "empty cells where nothing was measured");
    // The gap follows from the file.
    let table = railgrip_recording::Table::read(&folder.path().join("stop.dry.csv")).unwrap();
    let squares = ["v_m_s", "omega_f_rad_s", "omega_r_rad_s"].map(|output| {
        let sigma = match output {
            "v_m_s" => case.vehicle.sensors.speed_sigma_m_s,
            _ => case.vehicle.sensors.wheel_speed_sigma_rad_s,
        };
        let model = table.column(&format!("{output}_extended")).unwrap();
        let pairs =
            table.column(output).unwrap().iter().zip(model).filter(|(measured, _)| measured.is_finite());
        let errors: Vec<f64> = pairs.map(|(measured, model)| ((model - measured) / sigma).powi(2)).collect();
        errors.iter().sum::<f64>() / errors.len() as f64
    });
    let followed = (squares.iter().sum::<f64>() / 3.0).sqrt();
    println!("{:.4} stated, {followed:.4} from the file", gap.extended);
    assert!((followed / gap.extended - 1.0).abs() < 1e-3);
}
