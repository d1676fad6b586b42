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

/// Noise of coarse encoders, one sigma, rad/s.
const ROUGH: f64 = 0.12;

/// Even noise of one sigma that repeats.
fn even_noise() -> impl FnMut(f64) -> f64 {
    let mut seed = 7_u64;
    move |sigma| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        3.46 * sigma * ((seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
    }
}

/// Alerts of a railcar of four wheelsets that stops every 150 s, and whose pads grip with these shares from the sixth stop on.
fn gripping(shares: [f64; 4]) -> Vec<Alert> {
    gripping_since(5.0 * STOP_S, shares, [1.0; 4], ROUGH)
}

/// The same from some time on, where what the pads do makes so many times the creepage that it should.
fn gripping_since(since_s: f64, shares: [f64; 4], steepness: [f64; 4], rough: f64) -> Vec<Alert> {
    // Coarse encoders: the wagon as a whole is known better than the differences within it.
    let file = WagonFile { wheelsets: 4, mass_kg: 44e3, wheel_speed_sigma_rad_s: rough, ..file() };
    let mut watch = TrainWatch::new(vec![file]);
    let mut noise = even_noise();
    let (mut v_m_s, mut press_n) = (0.0_f64, 0.0_f64);
    for step in 0..(2400.0 / DT_S) as usize {
        let t = step as f64 * DT_S;
        let braking_s = t % STOP_S - BRAKES_AT_S;
        // No two stops are alike.
        let order =
            if (0.0..38.0).contains(&braking_s) { 0.5 + 0.1 * (t / STOP_S).floor().sin() } else { 0.0 };
        let drive_m_s2 = if braking_s < -60.0 { 0.45 } else { 0.0 };
        press_n += DT_S / CYLINDER_S * (order * FULL_N - press_n);
        let pads_n: [f64; 4] = shares.map(|share| {
            let share = if t > since_s { share } else { 1.0 };
            0.35 * share * press_n * 0.25 / RADIUS_M
        });
        let a_m_s2 = match v_m_s > 0.0 || drive_m_s2 > 0.0 {
            true => {
                let resistance_n = 500.0 + 5.0 * v_m_s + 2.0 * v_m_s * v_m_s;
                (44e3 * drive_m_s2 - pads_n.iter().sum::<f64>() - resistance_n)
                    / (44e3 + 4.0 * 100.0 / (RADIUS_M * RADIUS_M))
            }
            false => 0.0,
        };
        v_m_s = (v_m_s + DT_S * a_m_s2).max(0.0);
        let mut reading =
            Reading { v_m_s: v_m_s + noise(0.03), grade_rad: 0.0, brake_demand: order, ..Reading::default() };
        for k in 0..4 {
            let drive_n = 0.25 * 44e3 * drive_m_s2;
            let turning_n = 100.0 * a_m_s2 / (RADIUS_M * RADIUS_M);
            let creepage =
                (drive_n - turning_n - steepness[k] * pads_n[k]) * 1.7e-7 + 1e-3 * (k as f64 * 1.7).sin();
            reading.wheel_speed_rad_s[k] = v_m_s / RADIUS_M * (1.0 + creepage) + noise(rough);
            reading.pressing_force_n[k] = press_n;
            reading.drive_torque_nm[k] = drive_n * RADIUS_M;
        }
        watch.take(t, &[reading]);
    }
    watch.alerts().to_vec()
}

/// The pads of one wheelset make the whole railcar brake less: that wheelset is named, and the set only where all of it has lost.
#[test]
fn whether_one_wheelset_or_all_pads_of_a_railcar_have_lost_is_told() {
    let told = |shares| {
        let alerts = gripping(shares);
        alerts.into_iter().map(|alert| (alert.cause, alert.wheelsets)).collect::<Vec<_>>()
    };
    assert_eq!(told([1.0; 4]), []);
    assert_eq!(told([1.0, 0.2, 1.0, 1.0]), [(Cause::PadUneven, vec![1])]);
    assert_eq!(told([0.65; 4]), [(Cause::PadLow, vec![])]);
}

/// From the beginning a railcar grips somewhat less than its file says, as it may, and on a steep curve one wheelset creeps an eighth as much
/// as the others: its balance has no room for pads that hardly grip.
#[test]
fn a_wheelset_that_creeps_less_does_not_grip_less_where_the_balance_shows_nothing() {
    let told = |shares, steepness| {
        let alerts = gripping_since(0.0, shares, steepness, 0.03);
        alerts.into_iter().map(|alert| (alert.cause, alert.wheelsets)).collect::<Vec<_>>()
    };
    assert_eq!(told([0.9; 4], [1.6, 0.2, 1.6, 1.6]), []);
}

/// Whether the speed is told as late of a railcar of two wheelsets that stops every 150 s; from the sixth stop on its speed comes late by `late_s`, or its
/// wheels slip in braking, and run behind it by up to twice `behind_m_s`.
fn told_late(late_s: f64, behind_m_s: f64) -> bool {
    let mut watch = TrainWatch::new(vec![file()]);
    let mut noise = even_noise();
    let (mut v_m_s, mut press_n) = (0.0_f64, 0.0_f64);
    for step in 0..(1800.0 / DT_S) as usize {
        let t = step as f64 * DT_S;
        let (braking_s, wrong) = (t % STOP_S - BRAKES_AT_S, t > 5.0 * STOP_S);
        let order = if (0.0..38.0).contains(&braking_s) { 0.6 } else { 0.0 };
        let drive_m_s2 = if braking_s < -60.0 { 0.45 } else { 0.0 };
        press_n += DT_S / CYLINDER_S * (order * FULL_N - press_n);
        let pads_n = 0.35 * press_n * 0.25 / RADIUS_M;
        let resistance_n = 500.0 + 5.0 * v_m_s + 2.0 * v_m_s * v_m_s;
        let turning_kg = 100.0 / (RADIUS_M * RADIUS_M);
        let a_m_s2 = match v_m_s > 0.0 || drive_m_s2 > 0.0 {
            true => (24e3 * drive_m_s2 - 2.0 * pads_n - resistance_n) / (24e3 + 2.0 * turning_kg),
            false => 0.0,
        };
        v_m_s = (v_m_s + DT_S * a_m_s2).max(0.0);
        let slips = wrong && order > 0.0 && v_m_s > 2.0;
        let behind_m_s = if slips { behind_m_s * (1.0 + (0.5 * t).sin()) } else { 0.0 };
        let seen_m_s = if wrong { v_m_s - late_s * a_m_s2 } else { v_m_s };
        let mut reading = Reading {
            v_m_s: seen_m_s + noise(0.03),
            grade_rad: 0.0,
            brake_demand: order,
            ..Reading::default()
        };
        for k in 0..2 {
            let drive_n = 0.5 * 24e3 * drive_m_s2;
            let creepage = (drive_n - pads_n - turning_kg * a_m_s2) * 1.7e-7;
            let rim_m_s = (v_m_s * (1.0 + creepage) - behind_m_s).max(0.0);
            reading.wheel_speed_rad_s[k] = rim_m_s / RADIUS_M + noise(0.03);
            reading.pressing_force_n[k] = press_n;
            reading.drive_torque_nm[k] = drive_n * RADIUS_M;
        }
        watch.take(t, &[reading]);
    }
    let mut alerts = watch.alerts().iter();
    alerts.any(|alert| alert.cause == Cause::SpeedSensor && alert.reason.contains("later"))
}

/// Wheels that slip on a wet rail, now more, now less, look like a speed that is late.
#[test]
fn a_speed_is_not_late_where_wheels_slip() {
    assert!(!told_late(0.0, 0.3));
    assert!(told_late(0.5, 0.0));
    assert!(!told_late(0.0, 0.0));
}

/// A hand brake holds a railcar so hard from the sixth stop on that its motors work whenever it rolls: both wheelsets are named.
#[test]
fn a_railcar_that_never_coasts_for_what_holds_it_is_told() {
    let mut watch = TrainWatch::new(vec![file()]);
    let mut noise = even_noise();
    let (mut v_m_s, mut press_n) = (0.0_f64, 0.0_f64);
    for step in 0..(1800.0 / DT_S) as usize {
        let t = step as f64 * DT_S;
        let (braking_s, held) = (t % STOP_S - BRAKES_AT_S, t > 5.0 * STOP_S);
        let order = if (0.0..38.0).contains(&braking_s) { 0.6 } else { 0.0 };
        let held_n = if held { 5e3 } else { 0.0 };
        let drive_m_s2 = match held && (-100.0..0.0).contains(&braking_s) {
            true if v_m_s < 14.0 => 0.9,
            true => 2.0 * held_n / 24e3,
            false if braking_s < -60.0 => 0.45,
            false => 0.0,
        };
        press_n += DT_S / CYLINDER_S * (order * FULL_N - press_n);
        let pads_n = 0.35 * press_n * 0.25 / RADIUS_M + held_n;
        let resistance_n = 500.0 + 5.0 * v_m_s + 2.0 * v_m_s * v_m_s;
        let turning_kg = 100.0 / (RADIUS_M * RADIUS_M);
        let a_m_s2 = match v_m_s > 0.0 || drive_m_s2 > 0.0 {
            true => (24e3 * drive_m_s2 - 2.0 * pads_n - resistance_n) / (24e3 + 2.0 * turning_kg),
            false => 0.0,
        };
        v_m_s = (v_m_s + DT_S * a_m_s2).max(0.0);
        let mut reading =
            Reading { v_m_s: v_m_s + noise(0.03), grade_rad: 0.0, brake_demand: order, ..Reading::default() };
        for k in 0..2 {
            let drive_n = 0.5 * 24e3 * drive_m_s2;
            let creepage = (drive_n - pads_n - turning_kg * a_m_s2) * 1.7e-7;
            reading.wheel_speed_rad_s[k] = v_m_s * (1.0 + creepage) / RADIUS_M + noise(0.03);
            reading.pressing_force_n[k] = press_n;
            reading.drive_torque_nm[k] = drive_n * RADIUS_M;
        }
        watch.take(t, &[reading]);
    }
    let told: Vec<_> = watch.alerts().iter().map(|alert| (alert.cause, &alert.wheelsets[..])).collect();
    assert_eq!(told, [(Cause::Dragging, &[0, 1][..])]);
}
