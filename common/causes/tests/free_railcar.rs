//! A railcar by itself, which has no other brake than its own and nobody beside it: what its own balance and its own wheels tell.

use railgrip_causes::{Alert, Cause, Grade, Reading, TrainWatch, WagonFile};

const DT_S: f64 = 0.05;
const RADIUS_M: f64 = 0.45;
const FULL_N: f64 = 30e3;
/// Mass a wheelset, kg.
const MASS_KG: f64 = 12e3;
const INERTIA_KG_M2: f64 = 100.0;
const COMPLIANCE_PER_N: f64 = 1.7e-7;
const RESISTANCE: [f64; 3] = [500.0, 5.0, 2.0];
/// Cylinders take so long to fill and to empty, s.
const CYLINDER_S: f64 = 0.8;
/// It drives for 45 s, coasts, and brakes to a stop, again and again, s.
const STOP_S: f64 = 150.0;
const DRIVES_S: f64 = 45.0;
const BRAKES_AT_S: f64 = 105.0;
const BRAKES_S: f64 = 38.0;
/// What is wrong is so from the sixth stop on, unless it says otherwise.
const WRONG_FROM_S: f64 = 5.0 * STOP_S;
/// Noise of encoders, fine and coarse, one sigma, rad/s.
const FINE: f64 = 0.03;
const COARSE: f64 = 0.12;

/// What is done with it at one instant, and what is wrong with it.
#[derive(Clone, Copy)]
struct Now {
    drive_m_s2: f64,
    order: f64,
    /// Share of the order that its cylinders give.
    given: f64,
    /// What the pads of each wheelset grip with, over nominal.
    pads: [f64; 4],
    /// So many times the creepage that the pads of each wheelset should cause.
    steepness: [f64; 4],
    /// What holds each wheelset back besides, N.
    held_n: f64,
    /// By how much wheels slip, m/s, and the speed is late, s.
    slips_m_s: f64,
    late_s: f64,
}

impl Now {
    /// All is well at this time of a day of stops.
    fn well(t: f64) -> Self {
        let braking_s = t % STOP_S - BRAKES_AT_S;
        Self {
            drive_m_s2: if t % STOP_S < DRIVES_S { 0.45 } else { 0.0 },
            order: if (0.0..BRAKES_S).contains(&braking_s) { 0.6 } else { 0.0 },
            given: 1.0,
            pads: [1.0; 4],
            steepness: [1.0; 4],
            held_n: 0.0,
            slips_m_s: 0.0,
            late_s: 0.0,
        }
    }
}

/// Alerts of a railcar of so many wheelsets, with encoders of this noise, of which `now` says what is done with it at each time, s,
/// and speed, m/s.
fn day(wheelsets: usize, encoder: f64, lasts_s: f64, now: impl Fn(f64, f64) -> Now) -> Vec<Alert> {
    let mass_kg = MASS_KG * wheelsets as f64;
    let mut watch = TrainWatch::new(vec![WagonFile {
        wheelsets,
        mass_kg,
        mass_sigma: 0.015,
        radius_m: RADIUS_M,
        inertia_kg_m2: INERTIA_KG_M2,
        pad_radius_m: 0.25,
        pad_friction: 0.35,
        compliance_per_n: COMPLIANCE_PER_N,
        resistance: RESISTANCE,
        speed_sigma_m_s: 0.03,
        wheel_speed_sigma_rad_s: encoder,
    }]);
    let mut seed = 7_u64;
    // Even noise of one sigma that repeats.
    let mut noise = |sigma: f64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        3.46 * sigma * ((seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
    };
    let turning_kg = INERTIA_KG_M2 / (RADIUS_M * RADIUS_M);
    let (mut v_m_s, mut press_n) = (0.0_f64, 0.0_f64);
    for step in 0..(lasts_s / DT_S) as usize {
        let t = step as f64 * DT_S;
        let now = now(t, v_m_s);
        press_n += DT_S / CYLINDER_S * (now.given * now.order * FULL_N - press_n);
        let held_n: [f64; 4] =
            std::array::from_fn(|k| 0.35 * now.pads[k] * press_n * 0.25 / RADIUS_M + now.held_n);
        let resistance_n = RESISTANCE[0] + RESISTANCE[1] * v_m_s + RESISTANCE[2] * v_m_s * v_m_s;
        let a_m_s2 = match v_m_s > 0.0 || now.drive_m_s2 > 0.0 {
            true => {
                (mass_kg * now.drive_m_s2 - held_n[..wheelsets].iter().sum::<f64>() - resistance_n)
                    / (mass_kg + wheelsets as f64 * turning_kg)
            }
            false => 0.0,
        };
        v_m_s = (v_m_s + DT_S * a_m_s2).max(0.0);
        let mut reading = Reading {
            v_m_s: v_m_s - now.late_s * a_m_s2 + noise(0.03),
            grade_rad: 0.0,
            brake_demand: now.order,
            ..Reading::default()
        };
        for (k, held_n) in held_n[..wheelsets].iter().enumerate() {
            let drive_n = MASS_KG * now.drive_m_s2;
            let force_n = drive_n - turning_kg * a_m_s2 - now.steepness[k] * held_n;
            // Every wheel has a radius of its own.
            let creepage = COMPLIANCE_PER_N * force_n + 1e-3 * (k as f64 * 1.7).sin();
            let rim_m_s = (v_m_s * (1.0 + creepage) - now.slips_m_s).max(0.0);
            reading.wheel_speed_rad_s[k] = rim_m_s / RADIUS_M + noise(encoder);
            reading.pressing_force_n[k] = press_n;
            reading.drive_torque_nm[k] = drive_n * RADIUS_M;
        }
        watch.take(t, &[reading]);
    }
    watch.alerts().to_vec()
}

/// What was told, and of which wheelsets.
fn told(alerts: Vec<Alert>) -> Vec<(Cause, Vec<usize>)> {
    alerts.into_iter().map(|alert| (alert.cause, alert.wheelsets)).collect()
}

/// When the application begins that never ends, s.
const FOR_GOOD_S: f64 = 3.0 * STOP_S + BRAKES_AT_S;

/// Alerts of a railcar whose driver brakes at the fourth stop and never releases, and whose cylinders give this share of what is
/// ordered so long, s, after that.
fn never_released(share: impl Fn(f64) -> f64) -> Vec<Alert> {
    day(2, FINE, 1200.0, |t, _| match t > FOR_GOOD_S {
        true => Now { order: 0.6, drive_m_s2: 0.0, given: share(t - FOR_GOOD_S), ..Now::well(t) },
        false => Now::well(t),
    })
}

#[test]
fn a_railcar_without_its_brake_is_told_although_its_application_never_ends() {
    let alerts = never_released(|_| 0.0);
    let [alert] = &alerts[..] else { panic!("{alerts:?}") };
    assert_eq!((alert.cause, alert.grade, &alert.wagons[..]), (Cause::Isolated, Grade::Act, &[0][..]));
    let after_s = alert.raised_t_s - FOR_GOOD_S;
    assert!((10.0..45.0).contains(&after_s), "told {after_s} s after the order");
}

/// A distributor that takes ten seconds to hear the order is late, and no missing brake.
#[test]
fn a_brake_that_comes_late_in_an_application_that_never_ends_is_there() {
    let alerts = never_released(|braking_s| if braking_s < 10.0 { 0.0 } else { 1.0 });
    assert!(alerts.iter().all(|alert| alert.cause != Cause::Isolated), "{alerts:?}");
}

/// What is told of a railcar of four wheelsets, no two of whose stops are alike, and whose pads grip with these shares from a time on,
/// s.
fn gripping(encoder: f64, since_s: f64, pads: [f64; 4], steepness: [f64; 4]) -> Vec<(Cause, Vec<usize>)> {
    told(day(4, encoder, 2400.0, |t, _| {
        let mut now = Now { steepness, ..Now::well(t) };
        if now.order > 0.0 {
            now.order = 0.5 + 0.1 * (t / STOP_S).floor().sin();
        }
        if t > since_s {
            now.pads = pads;
        }
        now
    }))
}

/// The pads of one wheelset make the whole railcar brake less: that wheelset is named, and the set only where all of it has lost. Its
/// encoders are coarse, so that the whole is known better than the differences within it.
#[test]
fn whether_one_wheelset_or_all_pads_of_a_railcar_have_lost_is_told() {
    let told = |pads| gripping(COARSE, WRONG_FROM_S, pads, [1.0; 4]);
    assert_eq!(told([1.0; 4]), []);
    assert_eq!(told([1.0, 0.2, 1.0, 1.0]), [(Cause::PadUneven, vec![1])]);
    assert_eq!(told([0.65; 4]), [(Cause::PadLow, vec![])]);
}

/// From the beginning a railcar grips somewhat less than its file says, as it may, and on a steep curve one wheelset creeps an eighth
/// as much as the others: its balance has no room for pads that hardly grip.
#[test]
fn a_wheelset_that_creeps_less_does_not_grip_less_where_the_balance_shows_nothing() {
    assert_eq!(gripping(FINE, 0.0, [0.9; 4], [1.6, 0.2, 1.6, 1.6]), []);
}

/// Wheels that slip on a wet rail, now more, now less, look like a speed that is late.
#[test]
fn a_speed_is_not_late_where_wheels_slip() {
    let told_late = |late_s: f64, slips_m_s: f64| {
        let alerts = day(2, FINE, 1800.0, |t, v_m_s| match t > WRONG_FROM_S {
            true => {
                // The harder it brakes, and it does so each third time, the more they slip.
                let hard = ((t / STOP_S) as usize).is_multiple_of(3);
                let order = if Now::well(t).order > 0.0 { if hard { 0.9 } else { 0.5 } } else { 0.0 };
                let slips = order > 0.0 && v_m_s > 2.0 && hard;
                let slips_m_s = if slips { slips_m_s * (1.0 + (0.5 * t).sin()) } else { 0.0 };
                Now { late_s, slips_m_s, order, ..Now::well(t) }
            }
            false => Now::well(t),
        });
        alerts.iter().any(|alert| alert.cause == Cause::SpeedSensor && alert.reason.contains("later"))
    };
    assert!(!told_late(0.0, 0.3));
    assert!(told_late(0.5, 0.0));
    assert!(!told_late(0.0, 0.0));
}

/// A hand brake holds a railcar so hard that its motors work whenever it rolls: both wheelsets are named.
#[test]
fn a_railcar_that_never_coasts_for_what_holds_it_is_told() {
    const HELD_N: f64 = 5e3;
    let alerts = day(2, FINE, 1800.0, |t, v_m_s| {
        let drives = (5.0..BRAKES_AT_S).contains(&(t % STOP_S));
        let drive_m_s2 = match drives {
            true if v_m_s < 14.0 => 0.9,
            true => HELD_N / MASS_KG,
            false => 0.0,
        };
        match t > WRONG_FROM_S {
            true => Now { held_n: HELD_N, drive_m_s2, ..Now::well(t) },
            false => Now::well(t),
        }
    });
    assert_eq!(told(alerts), [(Cause::Dragging, vec![0, 1])]);
}
