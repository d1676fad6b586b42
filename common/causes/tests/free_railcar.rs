//! A railcar by itself, which has no other brake than its own: what it owes is told although its application never ends.

use railgrip_causes::{Alert, Cause, Grade, Reading, TrainWatch, WagonFile};

const DT_S: f64 = 0.05;
const RADIUS_M: f64 = 0.45;
const FULL_N: f64 = 30e3;
/// Cylinders take so long to fill and to empty, s.
const CYLINDER_S: f64 = 0.8;
/// Driven until the first second of the fifth stop and a quarter of an hour longer.
const BRAKES_AT_S: f64 = 105.0;
const STOP_S: f64 = 150.0;
const WITHOUT_FROM_S: f64 = 3.0 * STOP_S;

fn file() -> WagonFile {
    WagonFile {
        wheelsets: 2,
        mass_kg: 24e3,
        mass_sigma: 0.015,
        radius_m: RADIUS_M,
        inertia_kg_m2: 100.0,
        pad_radius_m: 0.25,
        pad_friction: 0.35,
        compliance_per_n: 1.7e-7,
        resistance: [500.0, 5.0, 2.0],
        speed_sigma_m_s: 0.03,
        wheel_speed_sigma_rad_s: 0.03,
    }
}

/// Alerts of a railcar that stops every 150 s and whose cylinders give this share of what is ordered in each second of the stop
/// that begins at [`WITHOUT_FROM_S`]; from then on the driver brakes and never releases.
fn never_released(share: impl Fn(f64) -> f64) -> Vec<Alert> {
    let mut watch = TrainWatch::new(vec![file()]);
    let (mut v_m_s, mut press_n) = (0.0_f64, 0.0_f64);
    for step in 0..(1200.0 / DT_S) as usize {
        let t = step as f64 * DT_S;
        let braking_s = if t > WITHOUT_FROM_S { t - WITHOUT_FROM_S } else { t % STOP_S } - BRAKES_AT_S;
        let order = match braking_s {
            s if s < 0.0 => 0.0,
            s if s < 35.0 || t > WITHOUT_FROM_S => 0.6,
            _ => 0.0,
        };
        let drive_m_s2 = if braking_s < -60.0 { 0.45 } else { 0.0 };
        let given = if t > WITHOUT_FROM_S && order > 0.0 { share(braking_s) } else { 1.0 };
        press_n += DT_S / CYLINDER_S * (given * order * FULL_N - press_n);
        let pads_n = 2.0 * 0.35 * press_n * 0.25 / RADIUS_M;
        let held_m_s2 = if v_m_s > 0.0 { pads_n / 24e3 + 0.02 } else { 0.0 };
        v_m_s = (v_m_s + DT_S * (drive_m_s2 - held_m_s2)).max(0.0);
        let mut reading = Reading { v_m_s, grade_rad: 0.0, brake_demand: order, ..Reading::default() };
        for k in 0..2 {
            reading.wheel_speed_rad_s[k] = v_m_s / RADIUS_M;
            reading.pressing_force_n[k] = press_n;
            reading.drive_torque_nm[k] = 0.5 * 24e3 * drive_m_s2 * RADIUS_M;
        }
        watch.take(t, &[reading]);
    }
    watch.alerts().to_vec()
}

#[test]
fn a_railcar_without_its_brake_is_told_although_its_application_never_ends() {
    let alerts = never_released(|_| 0.0);
    let [alert] = &alerts[..] else { panic!("{alerts:?}") };
    assert_eq!((alert.cause, alert.grade, &alert.wagons[..]), (Cause::Isolated, Grade::Act, &[0][..]));
    let after_s = alert.raised_t_s - WITHOUT_FROM_S - BRAKES_AT_S;
    assert!((10.0..45.0).contains(&after_s), "told {after_s} s after the order");
}

/// A distributor that takes ten seconds to hear the order is late, and no missing brake.
#[test]
fn a_brake_that_comes_late_in_an_application_that_never_ends_is_there() {
    let alerts = never_released(|braking_s| if braking_s < 10.0 { 0.0 } else { 1.0 });
    assert!(alerts.iter().all(|alert| alert.cause != Cause::Isolated), "{alerts:?}");
}
