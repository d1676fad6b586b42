//! The fast integrator against the model it stands for, and the windows over which it predicts.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_diagnosis::data::case::{Columns, OUTPUTS, Run};
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

/// The same coach on two bogies.
const BOGIES: &str = r#"
schema = 1
name = "coach on bogies"
body = { mass_kg = 50000.0, com_height_m = 1.6, wheelbase_m = 16.0, wheelset_positions_m = [9.25, 6.75, -6.75, -9.25] }
bogie = { wheelbase_m = 2.5, pivot_height_m = 0.6 }
wheelset = { radius_m = 0.44, inertia_kg_m2 = 120.0 }
brake = { radius_m = 0.25, friction_coefficient = 0.35 }
resistance = { constant_n = 400.0, linear_n_s_per_m = 8.0, drag_n_s2_per_m2 = 4.0 }
contact = { stiffness_n = 6.0e6, k_a = 1.0, k_s = 0.4 }
rail = { dry = 0.3, wet = 0.12, low = 0.06 }
sensors = { sample_rate_hz = 100.0, speed_sigma_m_s = 0.03, wheel_speed_sigma_rad_s = 0.03, pressing_force_sigma_n = 150.0 }
"#;

/// Pressing force on a wheelset, N, that makes it slide and catch again on wet rail; `full` presses with all of it.
fn force(k: usize, wheelset: usize, full: f64) -> f64 {
    let phase = (k % 300) as f64 / 300.0;
    let force = if phase < 0.7 { full * (phase / 0.2).min(1.0) } else { 0.25 * full };
    force * (1.0 - 0.1 * wheelset as f64 / 3.0_f64.max(wheelset as f64))
}

/// A run of a coach, simulated by the reference integrator in steps of 1 ms.
fn reference_run(vehicle: &VehicleParameters) -> (Run, Vec<[f64; OUTPUTS]>) {
    let model = WagonModel::new(vehicle).expect("model");
    let (n, wheelsets) = (1200, vehicle.wheelsets());
    // Enough to break every wheelset away.
    let full = 0.16 * vehicle.axle_load_n() * 0.44 / (0.35 * 0.25);
    let mut state = WagonState { v_m_s: 25.0, wheel_speed_rad_s: [25.0 / 0.44; 4] };
    state.wheel_speed_rad_s[wheelsets..].fill(0.0);
    let mut acceleration = 0.0;
    let mut truth = Vec::new();
    for k in 0..n {
        let mut row = [state.v_m_s; OUTPUTS];
        row[1..].copy_from_slice(&state.wheel_speed_rad_s);
        truth.push(row);
        let mut middle = [0.0; 4];
        for (i, middle) in middle.iter_mut().enumerate().take(wheelsets) {
            *middle = 0.5 * (force(k, i, full) + force(k + 1, i, full));
        }
        let input =
            WagonInput { pressing_force_n: middle, adhesion_peak: [0.12; 4], ..WagonInput::default() };
        for _ in 0..10 {
            let at = model.operating(&state, &input);
            let loading = model.loading(&at, &input, 0.01, &[]);
            state = model.step(&state, &loading, 0.001, &mut acceleration);
        }
    }
    let column = |j: usize| truth.iter().map(|row: &[f64; OUTPUTS]| row[j]).collect::<Vec<f64>>();
    let columns = Columns {
        t_s: (0..n).map(|k| k as f64 * 0.01).collect(),
        v_m_s: column(0),
        wheel_speed_rad_s: (1..=wheelsets).map(column).collect(),
        pressing_force_n: (0..wheelsets).map(|i| (0..n).map(|k| force(k, i, full)).collect()).collect(),
        drive_torque_nm: vec![vec![0.0; n]; wheelsets],
        ..Columns::default()
    };
    (Run::new("slide.wet".into(), RailClass::Wet, &columns), truth)
}

#[test]
fn the_fast_integrator_follows_the_model_through_slides() {
    for file in [COACH, BOGIES] {
        let vehicle: VehicleParameters = toml::from_str(file).expect("vehicle");
        let (run, truth) = reference_run(&vehicle);
        let model = WagonModel::new(&vehicle).expect("model");
        let wagon = FastWagon::new(&model, 0.12, run.dt_s);
        let mut motion = Motion { state: truth[0], ..Motion::default() };
        let (mut worst, mut deepest) = ([0.0_f64; OUTPUTS], [0.0_f64; OUTPUTS]);
        for (sample, row) in run.samples.iter().zip(&truth) {
            for j in 0..run.outputs() {
                worst[j] = worst[j].max((motion.state[j] - row[j]).abs());
                deepest[j] = deepest[j].max(if j > 0 { row[0] - 0.44 * row[j] } else { 0.0 });
            }
            wagon.step(&mut motion, &sample.input, &Disturbance::default(), &mut []);
        }
        println!("{}: slides {deepest:.2?} m/s deep; worst errors {worst:.4?} (m/s, rad/s)", vehicle.name);
        let wheelsets = 1..run.outputs();
        assert!(deepest[wheelsets.clone()].iter().all(|deep| *deep > 0.2), "all must slide: {deepest:?}");
        assert!(worst[0] < 0.001 && worst[wheelsets].iter().all(|error| *error < 0.02), "{worst:?}");
    }
}

#[test]
fn windows_are_ten_seconds_and_the_last_at_least_one() {
    let vehicle: VehicleParameters = toml::from_str(COACH).expect("vehicle");
    let (mut run, _) = reference_run(&vehicle);
    assert_eq!(open_loop::windows(&run), vec![0..1000, 1000..1200]);
    run.samples.truncate(1099);
    assert_eq!(open_loop::windows(&run), vec![0..1000]);
}
