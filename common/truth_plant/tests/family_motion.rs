//! No variant of the family's plants comes to rest where nothing balances.

use railgrip_truth_plant::{
    family::{Action, CreepLaw, FamilyNuisances, FamilySheet, FamilyWagon, Integrator, Motion, Needs, step},
    random::Stream,
};

const SPEEDS_M_S: [f64; 9] = [0.2, 0.5, 1.0, 2.0, 3.3, 8.0, 20.0, 40.0, 80.0];

fn wagon(law: CreepLaw, seed: u64) -> FamilyWagon {
    let sheet = FamilySheet::draw(&mut Stream::new(seed, "sheet", 0), Needs::default());
    FamilyWagon::new(&sheet, &FamilyNuisances::default(), law)
}

/// Braking that uses this share of the adhesion of a rail, at a speed that the wagon keeps.
fn held_at_speed(wagon: &FamilyWagon, peak: f64, used: f64) -> Action {
    let load_n = wagon.loads_n(wagon.mass_kg, 0.0, 1.0);
    let brake_nm = std::array::from_fn(|k| used * peak * load_n[k] * wagon.radius_m[k]);
    Action {
        mass_kg: wagon.mass_kg,
        load_n,
        peak: [peak; 4],
        radius_m: wagon.radius_m,
        inertia_kg_m2: wagon.inertia_kg_m2,
        brake_nm,
        // What the wheels brake, something pushes.
        outer_n: used * peak * load_n.iter().sum::<f64>(),
        ..Action::default()
    }
}

/// Slip velocity (m/s) of the leading wheelset after `time_s`, from a wheel speed that is `off_rad_s` off rolling. The speed
/// is held, so that a slide has nowhere to go but back or on.
fn slip_after(
    wagon: &FamilyWagon,
    action: &Action,
    v_m_s: f64,
    off_rad_s: f64,
    integrator: Integrator,
    step_s: f64,
    time_s: f64,
) -> f64 {
    let rolling =
        |k: usize| if k < wagon.wheelsets { (v_m_s / wagon.radius_m[k] + off_rad_s).max(0.0) } else { 0.0 };
    let mut motion = Motion { v_m_s, wheel_speed_rad_s: std::array::from_fn(rolling) };
    for _ in 0..(time_s / step_s).round() as usize {
        motion = step(wagon, &motion, action, 0.0, step_s, integrator).motion;
        motion.v_m_s = v_m_s;
    }
    wagon.radius_m[0] * motion.wheel_speed_rad_s[0] - v_m_s
}

#[test]
fn nothing_slides_that_does_not_slide_in_fine_steps() {
    let (mut starts, mut worst) = (0, 0.0f64);
    for (seed, law) in CreepLaw::ALL.into_iter().enumerate() {
        let wagon = wagon(law, seed as u64);
        for (peak, used) in [(0.31, 0.25), (0.31, 0.6), (0.12, 0.6), (0.065, 0.8)] {
            let action = held_at_speed(&wagon, peak, used);
            for v_m_s in SPEEDS_M_S {
                // A fine implicit solution from rolling is where every start has to end.
                let rest = slip_after(&wagon, &action, v_m_s, 0.0, Integrator::Implicit, 1e-4, 1.5);
                for integrator in Integrator::ALL {
                    for off_rad_s in [-0.25, -0.1, -0.03, 0.0, 0.03, 0.1, 0.25] {
                        let slip = slip_after(
                            &wagon,
                            &action,
                            v_m_s,
                            off_rad_s,
                            integrator,
                            integrator.longest_step_s(),
                            1.5,
                        );
                        let error = (slip - rest).abs();
                        starts += 1;
                        worst = worst.max(error);
                        assert!(
                            error < 2e-3,
                            "{law:?} {integrator:?} at {v_m_s} m/s from {off_rad_s} rad/s: slip {slip:.4}, rest {rest:.4} m/s"
                        );
                    }
                }
            }
        }
    }
    println!("{starts} starts, worst slip error {worst:.1e} m/s");
}

#[test]
fn slides_run_as_in_fine_steps() {
    for law in CreepLaw::ALL {
        let wagon = wagon(law, 3);
        let action = held_at_speed(&wagon, 0.065, 1.25);
        for v_m_s in [5.0, 20.0] {
            let fine = slip_after(&wagon, &action, v_m_s, 0.0, Integrator::Explicit, 5e-5, 0.4);
            assert!(fine < -0.2, "it slides: {fine}");
            for integrator in Integrator::ALL {
                let slip =
                    slip_after(&wagon, &action, v_m_s, 0.0, integrator, integrator.longest_step_s(), 0.4);
                assert!(
                    (slip / fine - 1.0).abs() < 0.03,
                    "{law:?} {integrator:?}: {slip:.4} of {fine:.4} m/s"
                );
            }
        }
    }
}

#[test]
fn every_law_is_odd_bounded_and_has_its_stated_slope() {
    for law in CreepLaw::ALL {
        for strain in [0.01, 0.3, 1.1, 2.7, 8.0, 60.0] {
            let (value, slope) = law.curve(strain, 1.03);
            let ahead = law.curve(strain + 1e-6, 1.03).0;
            let behind = law.curve(strain - 1e-6, 1.03).0;
            assert!(((ahead - behind) / 2e-6 - slope).abs() < 1e-6, "{law:?} at {strain}");
            assert!((0.0..=1.0).contains(&value) && slope >= 0.0);
        }
        let (forward, backward) =
            (law.force(2e4, 6e6, 1.0, 0.02, 10.0).0, law.force(2e4, 6e6, 1.0, -0.02, 10.0).0);
        assert_eq!(forward, -backward);
    }
}

#[test]
fn laws_are_near_the_sheets_and_not_the_sheets() {
    let mut curves = Vec::new();
    for law in CreepLaw::ALL {
        let strains: Vec<f64> = (1..200).map(|index| 0.05 * f64::from(index)).collect();
        let curve: Vec<f64> = strains.iter().map(|strain| law.curve(*strain, 1.0).0).collect();
        let off = strains
            .iter()
            .zip(&curve)
            .map(|(strain, value)| (value - CreepLaw::Sheet.curve(*strain, 1.0).0).abs());
        let off = off.fold(0.0, f64::max);
        println!("{law:?} is {off:.4} off the sheet");
        assert!((0.003..0.03).contains(&off), "{law:?} {off}");
        curves.push(curve);
    }
    for (index, curve) in curves.iter().enumerate() {
        for other in &curves[..index] {
            let apart = curve.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart > 0.003, "two laws are {apart} apart");
        }
    }
}
