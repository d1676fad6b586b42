//! The response of a frozen filter's innovations to a small change of the model, against running the filter again.

use railgrip_diagnosis::data::case::{Case, Columns, Run};
use railgrip_diagnosis::data::noise::SensorNoise;
use railgrip_diagnosis::fit::candidate::Fitted;
use railgrip_diagnosis::fit::linearisation::Linearisation;
use railgrip_diagnosis::fit::objective::{Innovations, Objective, Whitening};
use railgrip_diagnosis::fit::solver::{self, Effort, Problem};
use railgrip_diagnosis::model::candidates;
use railgrip_diagnosis::model::parameters::Shape;
use railgrip_diagnosis::predict::disturbances::{DisturbanceModel, TOLERANCES};
use railgrip_vehicle::{RailClass, VehicleParameters};

const VEHICLE: &str = r#"
schema = 1
name = "railcar"
[body]
mass_kg = 42000.0
com_height_m = 1.5
wheelbase_m = 10.0
[wheelset]
radius_m = 0.42
inertia_kg_m2 = 120.0
[brake]
radius_m = 0.24
friction_coefficient = 0.35
[resistance]
constant_n = 450.0
linear_n_s_per_m = 8.0
drag_n_s2_per_m2 = 4.0
[contact]
stiffness_n = 6e6
k_a = 1.0
k_s = 0.4
[rail]
dry = 0.3
wet = 0.12
low = 0.05
[sensors]
sample_rate_hz = 50.0
speed_sigma_m_s = 0.03
wheel_speed_sigma_rad_s = 0.03
pressing_force_sigma_n = 150.0
"#;

/// A stop from 30 m/s on dry rail as a driver makes it, in three notches; noise from a fixed sequence.
fn stop() -> Run {
    let (dt, n, pad) = (0.02, 1100, 0.35 * 0.24);
    let two = || vec![Vec::new(); 2];
    let mut columns = Columns {
        wheel_speed_rad_s: two(),
        pressing_force_n: two(),
        drive_torque_nm: two(),
        ..Columns::default()
    };
    let (mut v, mut state) = (30.0_f64, 0x2545_f491_4f6c_dd1d_u64);
    let mut noise = || {
        // Twelve uniform numbers make a normal one.
        let uniform = (0..12).map(|_| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64
        });
        0.03 * (uniform.sum::<f64>() - 6.0)
    };
    for k in 0..n {
        let t = k as f64 * dt;
        let force: f64 = if t < 3.0 {
            0.0
        } else if t < 9.0 {
            38e3
        } else if t < 14.0 {
            22e3
        } else {
            45e3
        };
        columns.t_s.push(t);
        columns.v_m_s.push(v + noise());
        for i in 0..2 {
            columns.wheel_speed_rad_s[i].push(v / 0.42 * (1.0 - 3e-4 * force / 45e3) + noise());
            columns.pressing_force_n[i].push(force);
            columns.drive_torque_nm[i].push(0.0);
        }
        let resistance = 450.0 + 8.0 * v + 4.0 * v * v;
        v -= (2.0 * pad * force / 0.42 + resistance) / (42e3 + 2.0 * 120.0 / 0.42_f64.powi(2)) * dt;
    }
    Run::new("stop.dry".into(), RailClass::Dry, &columns)
}

fn case() -> Case {
    let vehicle: VehicleParameters = toml::from_str(VEHICLE).expect("vehicle");
    let noise = SensorNoise::of_file(&vehicle.sensors);
    Case { vehicle, fit: vec![stop()], holdout: Vec::new(), noise, notes: Vec::new() }
}

/// Over every effect that has a neutral strength and acts on this run, with the most tolerant filter, for which the
/// recursion is meant: the change of innovations that it gives beside the change that running the filter again gives.
#[test]
fn the_response_is_what_running_the_filter_again_gives() {
    let case = case();
    let shape = Shape::nominal(&case);
    let disturbances = DisturbanceModel::default().tolerant(TOLERANCES.len() - 1);
    let whitening = Whitening::new(&case, &shape.build(&shape.start()), &disturbances);
    let problem = Innovations { whitening: &whitening, shape: &shape };
    let effort = Effort { iterations: 6, slow_columns: 0, refresh: 1, tolerance: 0.1 };
    let mut fit = solver::fit(&problem, shape.parameters(), &shape.start(), effort, None);
    let (residuals, columns) = solver::linearise(&problem, shape.parameters(), &mut fit);
    let base = Fitted { shape: shape.clone(), fit, residuals, columns, left_out: Vec::new() };
    let around = Linearisation::new(&whitening, &base);
    let norm = |of: &[f64]| of.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut compared = 0;
    for id in [
        "brake_fade",
        "brake_friction_speed",
        "brake_friction_pressure",
        "running_resistance",
        "mass_error",
        "rotating_inertia",
        "speed_scale",
        "wheel_radius",
    ] {
        let library = candidates::all(&case, &[]);
        let candidate = library.iter().find(|c| c.spec.id == id).expect("in the catalogue");
        let effect = &candidate.starts[0];
        let with = shape.with(effect);
        let mut theta = base.fit.theta.clone();
        theta.extend(
            effect
                .parameters
                .iter()
                .zip(effect.spec.parameters)
                .map(|(p, s)| s.neutral.map_or(p.start, |neutral| neutral + 0.05 * p.scale)),
        );
        let again = Innovations { whitening: &whitening, shape: &with }.residuals(&theta);
        let response = around.of(&with).residuals(&theta);
        let change = |of: &[f64]| of.iter().zip(&base.residuals).map(|(a, b)| a - b).collect::<Vec<f64>>();
        let (again, response) = (change(&again), change(&response));
        let apart: Vec<f64> = again.iter().zip(&response).map(|(a, b)| a - b).collect();
        let share = norm(&apart) / norm(&again);
        println!(
            "{id}: innovations change by {:.3}, the response is off by {share:.3} of that",
            norm(&again)
        );
        assert!(norm(&again) > 1e-4, "{id} does nothing");
        assert!(share < 0.15, "{id}: {share}");
        compared += 1;
    }
    assert_eq!(compared, 8);
}
