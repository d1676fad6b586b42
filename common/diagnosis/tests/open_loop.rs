//! The fast integrator against the model it stands for, and the windows over which it predicts.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_diagnosis::data::case::{Columns, Run};
use railgrip_diagnosis::predict::open_loop;
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion};
use railgrip_vehicle::{RailClass, VehicleParameters, WagonInput, WagonModel, WagonState};

const COACH: &str = r#"
schema = 1
name = "coach"
body = { mass_kg = 40000.0, com_height_m = 1.6, wheelbase_m = 10.0 }
wheelset = { radius_m = 0.44, inertia_kg_m2 = 120.0 }
brake = { radius_m = 0.25, friction_coefficient = 0.35 }
resistance = { constant_n = 400.0, linear_n_s_per_m = 8.0, drag_n_s2_per_m2 = 4.0 }
contact = { stiffness_n = 6.0e6, k_a = 1.0, k_s = 0.4 }
rail = { dry = 0.3, wet = 0.12, low = 0.06 }
sensors = { sample_rate_hz = 100.0, speed_sigma_m_s = 0.03, wheel_speed_sigma_rad_s = 0.03, pressing_force_sigma_n = 150.0 }
"#;

/// Pressing forces that make both wheelsets slide and catch again on wet rail.
fn forces(k: usize) -> [f64; 2] {
    let phase = (k % 300) as f64 / 300.0;
    let force = if phase < 0.7 { 1e5 * (phase / 0.2).min(1.0) } else { 2.5e4 };
    [force, 0.9 * force]
}

/// A run of the coach, simulated by the reference integrator in steps of 1 ms.
fn reference_run(vehicle: &VehicleParameters) -> (Run, Vec<[f64; 3]>) {
    let model = WagonModel::new(vehicle).expect("model");
    let n = 1200;
    let mut state = WagonState { v_m_s: 25.0, wheel_speed_rad_s: [25.0 / 0.44; 4] };
    let mut acceleration = 0.0;
    let mut truth = Vec::new();
    for k in 0..n {
        truth.push([state.v_m_s, state.wheel_speed_rad_s[0], state.wheel_speed_rad_s[1]]);
        let (now, next) = (forces(k), forces(k + 1));
        let middle = [0.5 * (now[0] + next[0]), 0.5 * (now[1] + next[1]), 0.0, 0.0];
        let input =
            WagonInput { pressing_force_n: middle, adhesion_peak: [0.12; 4], ..WagonInput::default() };
        for _ in 0..10 {
            let at = model.operating(&state, &input);
            let loading = model.loading(&at, &input, 0.01, &[]);
            state = model.step(&state, &loading, 0.001, &mut acceleration);
        }
    }
    let column = |j: usize| truth.iter().map(|row: &[f64; 3]| row[j]).collect::<Vec<f64>>();
    let columns = Columns {
        t_s: (0..n).map(|k| k as f64 * 0.01).collect(),
        v_m_s: column(0),
        wheel_speed_rad_s: [column(1), column(2)],
        pressing_force_n: [0, 1].map(|i| (0..n).map(|k| forces(k)[i]).collect()),
        drive_torque_nm: [vec![0.0; n], vec![0.0; n]],
        ..Columns::default()
    };
    (Run::new("slide.wet".into(), RailClass::Wet, &columns), truth)
}

#[test]
fn the_fast_integrator_follows_the_model_through_slides() {
    let vehicle: VehicleParameters = toml::from_str(COACH).expect("vehicle");
    let (run, truth) = reference_run(&vehicle);
    let model = WagonModel::new(&vehicle).expect("model");
    let wagon = FastWagon::new(&model, 0.12, run.dt_s);
    let mut motion = Motion { state: truth[0], ..Motion::default() };
    let (mut worst, mut deepest) = ([0.0_f64; 3], 0.0_f64);
    for (sample, row) in run.samples.iter().zip(&truth) {
        for j in 0..3 {
            worst[j] = worst[j].max((motion.state[j] - row[j]).abs());
        }
        deepest = deepest.max(row[0] - 0.44 * row[2]);
        wagon.step(&mut motion, &sample.input, &Disturbance::default(), &mut []);
    }
    println!("deepest slide {deepest:.2} m/s; worst errors {worst:.4?} (m/s, rad/s, rad/s)");
    assert!(deepest > 0.2, "the run must slide");
    assert!(worst[0] < 0.001 && worst[1] < 0.02 && worst[2] < 0.02, "{worst:?}");
}

#[test]
fn windows_are_ten_seconds_and_the_last_at_least_one() {
    let vehicle: VehicleParameters = toml::from_str(COACH).expect("vehicle");
    let (mut run, _) = reference_run(&vehicle);
    assert_eq!(open_loop::windows(&run), vec![0..1000, 1000..1200]);
    run.samples.truncate(1099);
    assert_eq!(open_loop::windows(&run), vec![0..1000]);
}
