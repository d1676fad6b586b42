//! The first plant's two-stage steps do not come to rest where nothing balances.

use railgrip_truth_plant::{
    dynamics::{self, Action, Motion},
    plant::STEP_S,
    random::Stream,
    sheet::{GRAVITY_M_S2, Rail, Sheet},
    wagon::{Nuisances, TrueWagon},
};

/// Slip velocity of the leading wheelset (m/s) after a second at a held speed, braked with a share of dry adhesion, from a
/// wheel speed that is `off_rad_s` off rolling.
fn slip_after(wagon: &TrueWagon, v_m_s: f64, used: f64, off_rad_s: f64, step_s: f64) -> f64 {
    let peak = wagon.rail_friction(Rail::Dry);
    let weight_n = wagon.mass_kg * GRAVITY_M_S2;
    let action = Action {
        shaft_torque_nm: wagon.radius_m.map(|radius| -used * peak * weight_n / 2.0 * radius),
        grade_rad: 0.0,
        headwind_m_s: 0.0,
        body_force_n: used * peak * weight_n,
        load_transfer: 0.0,
    };
    let mut motion = Motion {
        v_m_s,
        wheel_speed_rad_s: wagon.radius_m.map(|radius| (v_m_s / radius + off_rad_s).max(0.0)),
    };
    for _ in 0..(1.0 / step_s).round() as usize {
        let next = dynamics::step(wagon, &motion, &action, 0.0, step_s, &|_, _| peak).0;
        motion = Motion { v_m_s, wheel_speed_rad_s: next.wheel_speed_rad_s.map(|speed| speed.max(0.0)) };
    }
    wagon.radius_m[0] * motion.wheel_speed_rad_s[0] - v_m_s
}

fn false_slides(step_s: f64) -> Vec<String> {
    let mut found = Vec::new();
    for seed in 0..4 {
        let wagon = TrueWagon::new(
            &Sheet::draw(&mut Stream::new(seed, "sheet", 0), false, false),
            &Nuisances::default(),
        );
        for used in [0.25, 0.6] {
            for v_m_s in [0.5, 1.0, 2.0, 3.3, 8.0, 20.0, 50.0] {
                let rest = slip_after(&wagon, v_m_s, used, 0.0, 2e-5);
                for off_rad_s in [-0.25, -0.1, -0.03, 0.03, 0.1, 0.25] {
                    let slip = slip_after(&wagon, v_m_s, used, off_rad_s, step_s);
                    if (slip - rest).abs() > 3e-3 {
                        found.push(format!(
                            "{v_m_s} m/s, {used} used, {off_rad_s} rad/s: {slip:.4} for {rest:.4}"
                        ));
                    }
                }
            }
        }
    }
    found
}

#[test]
fn a_wheel_that_is_off_rolling_comes_back_to_it() {
    for step_s in [STEP_S, 5e-3] {
        let found = false_slides(step_s);
        println!("{} of 336 starts slide falsely at {} ms", found.len(), 1e3 * step_s);
        assert!(found.is_empty(), "{found:#?}");
    }
}
