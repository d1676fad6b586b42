//! The plant obeys mechanics, its integration converges, and its runs look like runs.

mod common;

use common::{Pair, mean, onset};
use railgrip_truth_plant::{
    Case, Recipe,
    dynamics::{self, Action, Motion},
    plant::SAMPLE_S,
    random::Stream,
    sheet::{Rail, Sheet},
    wagon::{Nuisances, TrueWagon},
};

fn wagon() -> TrueWagon {
    TrueWagon::new(&Sheet::draw(&mut Stream::new(5, "sheet", 0), false, false), &Nuisances::default())
}

fn braking(torque_nm: f64) -> Action {
    Action {
        shaft_torque_nm: [-torque_nm, -0.9 * torque_nm],
        grade_rad: 0.003,
        headwind_m_s: 1.0,
        body_force_n: -200.0,
        load_transfer: 1.0,
    }
}

/// Brakes for two seconds with a torque that slides the leading wheelset on low rail.
fn brake(wagon: &TrueWagon, step_s: f64, mut see: impl FnMut(&Motion, &Motion, &dynamics::Rates)) -> Motion {
    let v_m_s = 20.0;
    let mut motion = Motion { v_m_s, wheel_speed_rad_s: wagon.radius_m.map(|radius| v_m_s / radius) };
    let capacity_nm = 0.065 * wagon.mass_kg * 9.81 / 2.0 * wagon.radius_m[0];
    let peak = wagon.rail_friction(Rail::Low);
    let mut lagged_m_s2 = 0.0;
    for index in 0..(2.0 / step_s).round() as usize {
        // Held over 2 ms, so that every step size sees the same torque.
        let held_s = (index as f64 * step_s / 2e-3 + 1e-6).floor() * 2e-3;
        let share = (held_s / 0.8).min(1.0);
        let action = braking(1.02 * capacity_nm * share);
        let (next, rates) = dynamics::step(wagon, &motion, &action, lagged_m_s2, step_s, &|_, _| peak);
        see(&motion, &next, &rates);
        lagged_m_s2 = rates.acceleration_m_s2;
        motion = next;
    }
    motion
}

#[test]
fn momentum_changes_by_the_sum_of_all_forces() {
    let wagon = wagon();
    let step_s = 5e-4;
    let mut impulse = 0.0;
    let end = brake(&wagon, step_s, |before, after, rates| {
        let v = 0.5 * (before.v_m_s + after.v_m_s);
        let [constant, linear, drag] = wagon.resistance;
        let resistance = constant + linear * v + drag * (v + 1.0).powi(2);
        let weight = wagon.mass_kg * 9.81 * 0.003f64.sin();
        impulse += step_s * (rates.contact_n.iter().sum::<f64>() - resistance - weight - 200.0);
    });
    let change = wagon.mass_kg * (end.v_m_s - 20.0);
    println!("momentum change {change:.2} N s, impulse {impulse:.2} N s");
    assert!((change - impulse).abs() < 2e-4 * change.abs());
}

#[test]
fn energy_goes_into_brakes_contact_and_resistance() {
    let wagon = wagon();
    let step_s = 2e-4;
    let (mut work, mut index) = (0.0, 0.0);
    let capacity_nm = 0.065 * wagon.mass_kg * 9.81 / 2.0 * wagon.radius_m[0];
    let energy = |motion: &Motion| {
        let turning =
            (0..2).map(|k| wagon.inertia_kg_m2[k] * motion.wheel_speed_rad_s[k].powi(2)).sum::<f64>();
        0.5 * (wagon.mass_kg * motion.v_m_s.powi(2) + turning)
    };
    let mut burnt = 0.0;
    let end = brake(&wagon, step_s, |before, after, rates| {
        let held_s = f64::floor(index * step_s / 2e-3 + 1e-6) * 2e-3;
        let torque_nm = 1.02 * capacity_nm * (held_s / 0.8f64).min(1.0);
        index += 1.0;
        let v = 0.5 * (before.v_m_s + after.v_m_s);
        let [constant, linear, drag] = wagon.resistance;
        let body =
            constant + linear * v + drag * (v + 1.0).powi(2) + wagon.mass_kg * 9.81 * 0.003f64.sin() + 200.0;
        let wheel = |k: usize| 0.5 * (before.wheel_speed_rad_s[k] + after.wheel_speed_rad_s[k]);
        let sliding: f64 = (0..2).map(|k| rates.contact_n[k] * (v - wagon.radius_m[k] * wheel(k))).sum();
        burnt -= step_s * sliding;
        work += step_s * (torque_nm * wheel(0) + 0.9 * torque_nm * wheel(1) + body * v - sliding);
    });
    let start = Motion { v_m_s: 20.0, wheel_speed_rad_s: wagon.radius_m.map(|radius| 20.0 / radius) };
    let lost = energy(&start) - energy(&end);
    println!("energy lost {lost:.0} J, accounted for {work:.0} J, of it {burnt:.0} J in the contacts");
    assert!(burnt > 0.0);
    assert!((lost - work).abs() < 1e-3 * lost);
}

#[test]
fn halving_the_step_divides_the_error_by_four() {
    let wagon = wagon();
    let reference = brake(&wagon, 2.5e-5, |_, _, _| ());
    let error = |step_s: f64| {
        let end = brake(&wagon, step_s, |_, _, _| ());
        (end.wheel_speed_rad_s[0] - reference.wheel_speed_rad_s[0]).abs()
    };
    let (coarse, fine) = (error(2e-3), error(1e-3));
    println!("wheel speed error {coarse:.2e} at 2 ms, {fine:.2e} at 1 ms, {:.2e} at 0.5 ms", error(5e-4));
    assert!(coarse / fine > 3.0, "order {:.2}", (coarse / fine).log2());
    assert!(error(5e-4) < 0.003, "a tenth of the wheel-speed sensor's sigma");
}

#[test]
fn braking_loads_the_leading_wheelset() {
    let wagon = wagon();
    let mut last = dynamics::Rates::default();
    brake(&wagon, 5e-4, |_, _, rates| last = *rates);
    let expected = -2.0 * wagon.height_over_wheelbase * wagon.mass_kg * last.acceleration_m_s2;
    println!("loads {:.0} and {:.0} N, transfer {expected:.0} N", last.load_n[0], last.load_n[1]);
    assert!((last.load_n[0] - last.load_n[1] - expected).abs() < 1e-3 * expected);
    assert!((last.load_n.iter().sum::<f64>() - wagon.mass_kg * 9.81).abs() < 1e-6 * wagon.mass_kg);
}

#[test]
fn every_family_gives_plausible_runs() {
    for seed in 0..8 {
        let recipe = Recipe { name: "none".into(), seed, departures: Vec::new() };
        let case = Case::make(&recipe).unwrap();
        assert_eq!(case.runs.len(), 10);
        for run in &case.runs {
            let length_s = run.rows.len() as f64 * SAMPLE_S;
            assert!((15.0..=75.1).contains(&length_s), "{} lasts {length_s} s", run.order.name);
            assert!(run.rows.iter().all(|row| row.pressing_force_n.iter().all(|force| *force >= 0.0)));
        }
        let stop = &case.runs[1];
        let (from, to) = (onset(stop) + 200, stop.truth.len() - 1);
        let retardation = (stop.truth[from].v_m_s - stop.truth[to].v_m_s) / ((to - from) as f64 * SAMPLE_S);
        println!("{} dry stop {retardation:.2} m/s²", case.label.vehicle);
        assert!((0.5..1.6).contains(&retardation));
        let gaps = case.label.gap_without_the_effect;
        println!("   gap without any effect: fit {:.2}, holdout {:.2}", gaps.fit, gaps.holdout);
        assert!((1.0..5.0).contains(&gaps.fit));
    }
}

#[test]
fn sensors_are_as_noisy_as_the_sheet_says() {
    let pair = Pair::new("speed_scale", 1.0);
    let run = pair.without("dry_stop");
    let both = || run.rows.iter().zip(&run.truth);
    let v = mean(both().map(|(row, truth)| (row.v_m_s - truth.v_m_s).powi(2))).sqrt();
    let wheel =
        mean(both().map(|(row, truth)| (row.wheel_speed_rad_s[1] - truth.wheel_speed_rad_s[1]).powi(2)))
            .sqrt();
    let neighbours = run.rows.windows(2).zip(run.truth.windows(2));
    let lagged = mean(
        neighbours.map(|(row, truth)| (row[0].v_m_s - truth[0].v_m_s) * (row[1].v_m_s - truth[1].v_m_s)),
    );
    println!("sigma v {v:.4}, wheel {wheel:.4}, correlation of neighbours {:.3}", lagged / (v * v));
    assert!((v / 0.03 - 1.0).abs() < 0.05 && (wheel / 0.03 - 1.0).abs() < 0.05);
    assert!((lagged / (v * v)).abs() < 0.06);
}

#[test]
fn the_same_seed_gives_the_same_case() {
    let recipe = Recipe { name: "twice".into(), seed: 3, departures: vec!["headwind".into()] };
    let (first, second) = (Case::make(&recipe).unwrap(), Case::make(&recipe).unwrap());
    assert_eq!(first.label, second.label);
    for (first, second) in first.runs.iter().zip(&second.runs) {
        assert_eq!(first.rows, second.rows);
    }
    let other = Case::make(&Recipe { seed: 4, ..recipe }).unwrap();
    assert_ne!(first.runs[0].rows, other.runs[0].rows);
}

#[test]
fn a_twin_shares_the_clutter_of_its_case() {
    let pair = Pair::new("brake_friction_speed", 2.0);
    let (with, without) = (pair.with("dry_stop"), pair.without("dry_stop"));
    let coasting = onset(&with);
    assert_eq!(with.rows[..coasting], without.rows[..coasting], "before the brake, nothing differs");
    assert_ne!(with.rows[coasting + 300].v_m_s, without.rows[coasting + 300].v_m_s);
}

#[test]
fn an_unknown_departure_is_refused_by_name() {
    let recipe = Recipe { name: "typo".into(), seed: 1, departures: vec!["brake_fad".into()] };
    let error = Case::make(&recipe).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("brake_fad"));
}
