//! An effect that a diagnosis found is an effect that the simulator and the estimator load: every id of the catalogue, written
//! into a vehicle file as `gap diagnose --apply` writes it, changes what `simulate` computes, and what `estimate` computes
//! unless it is a law of what the estimator estimates anyway.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::path::Path;
use std::process::Command;

use railgrip_tests::{Table, program};
use serde_json::Value;

/// One wagon that coasts, brakes, releases, slides on a low stretch, is sanded, and drives off again on an incline.
const SCENARIO: &str = r#"
schema = 1
name = "everything"
duration_s = 70.0
start_speed_m_s = 22.0
train = { wagons = 1 }
demand = [
    { from_s = 0.0, coast = true },
    { from_s = 3.0, brake = 0.5 },
    { from_s = 9.0, brake = 0.2 },
    { from_s = 14.0, brake = 0.9 },
    { from_s = 22.0, brake = 0.9, sanding = 1.0 },
    { from_s = 30.0, coast = true },
    { from_s = 33.0, traction = 0.8 },
    { from_s = 55.0, brake = 0.7 },
]
rail = [
    { from_m = -100.0, condition = "wet" },
    { from_m = 230.0, condition = "low" },
    { from_m = 420.0, condition = "dry" },
]
grade = [{ from_m = -100.0, grade_rad = 0.001 }]
"#;

/// Laws of the adhesion that is available: the estimator takes none for granted and estimates the adhesion itself, whatever
/// it depends on, so that they change what is simulated only.
const ESTIMATED_ANYWAY: [&str; 5] =
    ["falling_friction", "self_cleaning", "low_adhesion_patch", "adhesion_speed", "sanding"];

fn run(arguments: &[&str]) -> String {
    let output = Command::new(program!()).args(arguments).output().expect("start");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Recording of the scenario with this vehicle.
fn simulated(scenario: &Path, vehicle: &Path, out: &Path) -> std::path::PathBuf {
    let text = |path: &Path| path.display().to_string();
    run(&[
        "simulate",
        "--scenario",
        &text(scenario),
        "--vehicle",
        &text(vehicle),
        "--out",
        &text(out),
        "--seed",
        "5",
    ]);
    let named = |name: &str| name.starts_with("wagon") && name.ends_with(".csv");
    std::fs::read_dir(out)
        .expect("folder")
        .flatten()
        .map(|entry| entry.path())
        .find(|path| path.file_name().is_some_and(|name| named(&name.to_string_lossy())))
        .expect("a recording")
}

fn estimated(recording: &Path, vehicle: &Path, out: &Path) -> Table {
    let text = |path: &Path| path.display().to_string();
    run(&["estimate", &text(recording), "--vehicle", &text(vehicle), "--out", &text(out)]);
    Table::read(out)
}

/// Largest difference of a column, relative to the column's largest value.
fn difference(a: &Table, b: &Table, column: &str) -> f64 {
    let (a, b) = (a.column(column), b.column(column));
    let size = a.iter().map(|x| x.abs()).fold(1e-12, f64::max);
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max) / size
}

/// A value of the parameter at which the effect acts.
fn acting(parameter: &Value) -> f64 {
    let number = |key: &str| parameter[key].as_f64();
    let (lower, upper) = (number("lower").expect("lower"), number("upper").expect("upper"));
    let name = parameter["name"].as_str().unwrap_or_default();
    match name {
        "start_m" => 250.0,
        "length_m" => 150.0,
        _ => {
            let default = number("default").expect("default");
            let idle = number("neutral") == Some(default);
            if idle {
                default + 0.3 * (upper - lower).min(2.0 * (upper - default).max(default - lower))
            } else {
                default
            }
            .clamp(lower, upper)
        }
    }
}

#[test]
fn every_effect_in_a_vehicle_file_changes_what_simulator_and_estimator_compute() {
    let folder = tempfile::tempdir().expect("folder");
    let at = |name: &str| folder.path().join(name);
    let plain_text = include_str!("../../config/vehicle.toml");
    let (scenario, plain) = (at("scenario.toml"), at("plain.toml"));
    std::fs::write(&scenario, SCENARIO).expect("scenario");
    std::fs::write(&plain, plain_text).expect("vehicle");
    let catalogue: Vec<Value> =
        serde_json::from_str(&run(&["gap", "effects", "--json"])).expect("the catalogue as JSON");
    assert!(catalogue.len() >= 27, "{} effects", catalogue.len());
    let recording = simulated(&scenario, &plain, &at("plain"));
    let (measured, estimates) = (Table::read(&recording), estimated(&recording, &plain, &at("plain.csv")));
    let mut idle = Vec::new();
    for spec in &catalogue {
        let id = spec["id"].as_str().expect("id");
        let parameters = spec["parameters"].as_array().expect("parameters").iter();
        let parameters: Vec<String> =
            parameters.map(|p| format!("{} = {:?}", p["name"].as_str().expect("name"), acting(p))).collect();
        let vehicle = at(&format!("{id}.toml"));
        let effect = format!("\n[[effect]]\nid = \"{id}\"\n[effect.parameters]\n{}\n", parameters.join("\n"));
        std::fs::write(&vehicle, format!("{plain_text}{effect}")).expect("vehicle");
        let changed = Table::read(&simulated(&scenario, &vehicle, &at(id)));
        let simulated = ["v_m_s", "omega_f_rad_s", "omega_r_rad_s"]
            .map(|column| difference(&measured, &changed, column))
            .into_iter()
            .fold(0.0, f64::max);
        let other = estimated(&recording, &vehicle, &at(&format!("{id}.csv")));
        let computed = ["v_m_s", "mu_w", "mu_b_f", "mu_b_r", "slip_f", "slip_r", "nis"]
            .map(|column| difference(&estimates, &other, column))
            .into_iter()
            .fold(0.0, f64::max);
        println!("{id:<28} simulate {simulated:.1e}  estimate {computed:.1e}  ({})", parameters.join(", "));
        if simulated < 1e-4 {
            idle.push(format!("simulate {id}"));
        }
        if computed < 1e-4 && !ESTIMATED_ANYWAY.contains(&id) {
            idle.push(format!("estimate {id}"));
        }
    }
    assert!(idle.is_empty(), "no change: {}", idle.join(", "));
}

#[test]
fn pads_of_their_own_are_loaded_and_act() {
    let folder = tempfile::tempdir().expect("folder");
    let at = |name: &str| folder.path().join(name);
    let text = include_str!("../../config/vehicle.toml");
    let own = text.replace(
        "friction_coefficient = 0.35",
        "friction_coefficient = 0.35\nfriction_by_wheelset = [0.3, 0.4]",
    );
    assert_ne!(own, text);
    let (scenario, plain, uneven) = (at("scenario.toml"), at("plain.toml"), at("uneven.toml"));
    std::fs::write(&scenario, SCENARIO).expect("scenario");
    std::fs::write(&plain, text).expect("vehicle");
    std::fs::write(&uneven, own).expect("vehicle");
    let recording = simulated(&scenario, &uneven, &at("runs"));
    let truth = Table::read(&at("runs/truth").join(recording.file_name().expect("name")));
    let mean = |table: &Table, column: &str| {
        let values: Vec<f64> = table.column(column).iter().copied().filter(|x| x.is_finite()).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let (front, rear) = (mean(&truth, "mu_b_f"), mean(&truth, "mu_b_r"));
    println!("true pads {front:.3} front, {rear:.3} rear");
    assert!((front - 0.3).abs() < 0.03 && (rear - 0.4).abs() < 0.03, "front {front}, rear {rear}");
    let first = |vehicle: &Path| {
        let estimates = estimated(&recording, vehicle, &at("estimates.csv"));
        (estimates.column("mu_b_f")[0], estimates.column("mu_b_r")[0])
    };
    let (known, unknown) = (first(&uneven), first(&plain));
    assert!((known.0 - 0.3).abs() < 1e-6 && (known.1 - 0.4).abs() < 1e-6, "{known:?}");
    assert!((unknown.0 - unknown.1).abs() < 1e-6, "{unknown:?}");
}
