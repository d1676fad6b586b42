//! Columns in other units are refused, and what only looks like it is not.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_diagnosis::data::units::check;
use railgrip_recording::Recording;
use railgrip_vehicle::VehicleParameters;

/// Thirty seconds at 100 Hz: a brake that rises, holds and eases; the front wheelset locks after a second.
fn braking() -> Recording {
    let n = 3000;
    let press = |k: usize| 6e4 * (k as f64 / 800.0).min(1.0) * ((3000 - k) as f64 / 800.0).min(1.0);
    let mut v = vec![60.0];
    (1..n).for_each(|k| v.push(v[k - 1] - 0.01 * 0.8 * press(k) / 6e4));
    let roll: Vec<f64> = v.iter().map(|v| v / 0.45).collect();
    Recording {
        name: "stop.dry".into(),
        rail: None,
        wheelsets: 2,
        t_s: (0..n).map(|k| 0.01 * k as f64).collect(),
        wheel_speed_rad_s: vec![(0..n).map(|k| if k < 100 { roll[k] } else { 0.0 }).collect(), roll],
        v_m_s: v,
        pressing_force_n: vec![(0..n).map(press).collect(), (0..n).map(press).collect()],
        drive_torque_nm: vec![vec![0.0; n]; 2],
        grade_rad: None,
        sanding: None,
        position_m: None,
        wsp_active: None,
        load_kg: None,
        brake_demand: None,
    }
}

fn vehicle(mass_kg: f64) -> VehicleParameters {
    let text = format!(
        "schema = 1\nname = \"x\"\nbody = {{ mass_kg = {mass_kg:?}, com_height_m = 1.6, wheelbase_m = 10.0 }}\n\
         wheelset = {{ radius_m = 0.45, inertia_kg_m2 = 120.0 }}\nbrake = {{ radius_m = 0.25, friction_coefficient = 0.35 }}\n\
         resistance = {{ constant_n = 400.0, linear_n_s_per_m = 8.0, drag_n_s2_per_m2 = 4.0 }}\n\
         contact = {{ stiffness_n = 6.0e6, k_a = 1.0, k_s = 0.4 }}\nrail = {{ dry = 0.3, wet = 0.12, low = 0.06 }}\n\
         sensors = {{ sample_rate_hz = 100.0, speed_sigma_m_s = 0.03, wheel_speed_sigma_rad_s = 0.03, \
         pressing_force_sigma_n = 150.0 }}\n",
    );
    toml::from_str(&text).expect("vehicle")
}

fn refused(run: &Recording, mass_kg: f64) -> Option<String> {
    check(run, &vehicle(mass_kg)).err().map(|error| {
        println!("{error}, at {} s", error.t_s);
        error.column
    })
}

/// Repeatable noise of about one.
fn noise(k: usize) -> f64 {
    1.4 * (k as f64 * 2.399_963).sin() + (k as f64 * 7.123).cos()
}

#[test]
fn units_are_told_from_effects() {
    let column = |change: &dyn Fn(&mut Recording)| {
        let mut run = braking();
        change(&mut run);
        refused(&run, 40000.0)
    };
    let scale = |values: &mut Vec<f64>, factor: f64| values.iter_mut().for_each(|value| *value *= factor);
    assert_eq!(column(&|_| ()), None);
    assert_eq!(column(&|r| scale(&mut r.v_m_s, 1.1)), None);
    assert_eq!(column(&|r| scale(&mut r.v_m_s, 3.6)), Some("v_m_s".into()));
    assert_eq!(column(&|r| scale(&mut r.wheel_speed_rad_s[1], 9.55)), Some("omega_r_rad_s".into()));
    for factor in [1e-3, 1e-4] {
        let small = column(&|r| r.pressing_force_n.iter_mut().for_each(|f| scale(f, factor)));
        assert_eq!(small, Some("f_perp_f_n".into()));
    }
    for factor in [2.0, 0.5] {
        let both = column(&|r| r.wheel_speed_rad_s.iter_mut().for_each(|w| scale(w, factor)));
        assert!(both.is_some(), "the radius of the vehicle file is {factor} times what it should be");
    }
    assert_eq!(column(&|r| scale(&mut r.v_m_s, 1.0 / 0.514_444)), Some("v_m_s".into()), "knots");
    assert_eq!(column(&|r| scale(&mut r.v_m_s, -1.0)), Some("v_m_s".into()), "the other direction");
    assert_eq!(column(&|r| scale(&mut r.wheel_speed_rad_s[1], -1.0)), Some("omega_r_rad_s".into()));
    let both_ways = |r: &mut Recording| {
        scale(&mut r.v_m_s, -1.0);
        r.wheel_speed_rad_s.iter_mut().for_each(|w| scale(w, -1.0));
    };
    assert_eq!(column(&both_ways), None, "a wagon that runs backwards");
    assert_eq!(column(&|r| scale(&mut r.pressing_force_n[1], 1e-3)), Some("f_perp_r_n".into()));
    let isolated = |r: &mut Recording| {
        r.pressing_force_n[1] =
            (0..3000).map(|k| 40.0 * noise(k) + 1e-3 * r.pressing_force_n[0][k]).collect();
    };
    assert_eq!(column(&isolated), None, "a brake that is isolated");
    let degrees = |r: &mut Recording| r.grade_rad = Some(vec![0.57; 3000]);
    assert_eq!(column(&degrees), Some("grade_rad".into()));
    let steady = |r: &mut Recording| {
        (0..r.len()).for_each(|k| r.v_m_s[k] = 60.0 - 0.008 * k as f64);
        r.wheel_speed_rad_s[1] = r.v_m_s.iter().map(|v| v / 0.45).collect();
        r.pressing_force_n.iter_mut().for_each(|f| f.fill(73.0));
    };
    assert_eq!(column(&steady), Some("f_perp_f_n".into()));
}

#[test]
fn a_vehicle_that_coasts_crawls_slides_or_weighs_little_is_taken() {
    // Engine drag of 1.1 m/s², which changes with speed, and a brake that reads its noise.
    let mut coasting = braking();
    for k in 0..coasting.len() {
        coasting.v_m_s[k] = 50.0 - 0.011 * k as f64 + 4.0 * (k as f64 / 1500.0).powi(2);
        (0..2).for_each(|i| coasting.pressing_force_n[i][k] = 150.0 * noise(k + 17 * i));
    }
    coasting.wheel_speed_rad_s = vec![coasting.v_m_s.iter().map(|v| v / 0.45).collect(); 2];
    assert_eq!(refused(&coasting, 40000.0), None);
    coasting.pressing_force_n = vec![vec![0.0; coasting.len()]; 2];
    assert_eq!(refused(&coasting, 40000.0), None);
    // Both wheelsets locked from the first sample to the last.
    let mut locked = braking();
    locked.wheel_speed_rad_s = vec![vec![0.0; locked.len()]; 2];
    assert_eq!(refused(&locked, 40000.0), None);
    // A crawl at 1 m/s, of which the wheelset sensors see half the teeth.
    let mut slow = braking();
    slow.v_m_s.fill(1.0);
    slow.wheel_speed_rad_s = vec![vec![0.9; slow.len()]; 2];
    assert_eq!(refused(&slow, 40000.0), None);
    // A vehicle of 300 kg brakes with 500 N.
    let mut light = braking();
    light.pressing_force_n.iter_mut().flatten().for_each(|force| *force *= 5e2 / 6e4);
    assert_eq!(refused(&light, 300.0), None);
}

/// Forces a thousand times too large, and pads that pull, once passed.
#[test]
fn forces_and_torques_that_no_vehicle_has_are_refused() {
    let with = |change: &dyn Fn(&mut Recording)| {
        let mut run = braking();
        change(&mut run);
        let early = railgrip_diagnosis::data::units::check_early(&run, &vehicle(40000.0));
        assert_eq!(early.err().map(|error| error.column), refused(&run, 40000.0), "the same within seconds");
        refused(&run, 40000.0)
    };
    let scale = |values: &mut Vec<f64>, factor: f64| values.iter_mut().for_each(|value| *value *= factor);
    assert_eq!(with(&|run| scale(&mut run.pressing_force_n[0], 1e3)), Some("f_perp_f_n".into()));
    assert_eq!(with(&|run| scale(&mut run.pressing_force_n[1], 1e3)), Some("f_perp_r_n".into()));
    assert_eq!(with(&|run| scale(&mut run.pressing_force_n[1], -1.0)), Some("f_perp_r_n".into()));
    let torque = |torque: f64| move |run: &mut Recording| run.drive_torque_nm[1].fill(torque);
    assert_eq!(with(&torque(2e7)), Some("m_w_r_nm".into()));
    assert_eq!(with(&torque(-2e7)), Some("m_w_r_nm".into()));
    // What is strong, noisy, or wrong for a moment is the filter's business.
    assert_eq!(with(&torque(2e4)), None);
    assert_eq!(with(&|run| scale(&mut run.pressing_force_n[0], 3.0)), None);
    assert_eq!(with(&|run| run.pressing_force_n[0][500..520].fill(1e9)), None);
    let noisy = |run: &mut Recording| {
        run.pressing_force_n[0].iter_mut().enumerate().for_each(|(k, force)| *force += 1500.0 * noise(k));
    };
    assert_eq!(with(&noisy), None);
}
