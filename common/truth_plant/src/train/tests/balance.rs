//! Momentum, energy, and a contact without false slides.

use super::{
    super::{
        Journey,
        contact::{Contact, CreepLaw},
        dynamics::Motion,
    },
    healthy, on_rail,
};

const STEP_S: f64 = 0.005;

/// A freight train with its slack, rolling at some speed, brakes pressed unevenly.
fn rolling(v_m_s: f64) -> Motion {
    let journey = Journey::new(healthy(3, "freight_p", Some(9), 0.1));
    let mut motion = journey.motion().clone();
    for (index, body) in motion.bodies.iter_mut().enumerate() {
        body.v_m_s = v_m_s;
        body.wheel_speed_rad_s = body.radius_m.map(|radius| v_m_s / radius);
        body.friction = [0.3; 4];
        body.slope_rad = 0.002;
        body.brake_nm = [400.0 * index as f64; 4];
        body.drive_nm = if index == 0 { [4e3; 4] } else { [0.0; 4] };
    }
    motion
}

#[test]
fn outer_forces_alone_change_the_momentum_of_the_train() {
    let mut motion = rolling(18.0);
    let (mut largest_coupler_n, mut worst) = (0.0f64, 0.0f64);
    for _ in 0..4000 {
        let before: f64 = motion.bodies.iter().map(|body| body.mass_kg * body.v_m_s).sum();
        motion.step(STEP_S);
        let after: f64 = motion.bodies.iter().map(|body| body.mass_kg * body.v_m_s).sum();
        let wheelsets =
            |body: &super::super::dynamics::Body| body.contact_n[..body.wheelsets].iter().sum::<f64>();
        let outer_n: f64 = motion.bodies.iter().map(|body| body.outer_n + wheelsets(body)).sum();
        worst = worst.max(((after - before) / STEP_S - outer_n).abs());
        largest_coupler_n =
            motion.couplers.iter().map(|coupler| coupler.force_n.abs()).fold(largest_coupler_n, f64::max);
    }
    println!("largest coupler force {largest_coupler_n:.0} N, worst imbalance {worst:.2e} N");
    assert!(largest_coupler_n > 1e4, "couplers must work for this test to mean anything");
    assert!(worst < 0.05, "{worst} N left over of forces of {largest_coupler_n} N");
}

/// Kinetic energy of bodies and wheelsets, J.
fn kinetic_j(motion: &Motion) -> f64 {
    let of = |body: &super::super::dynamics::Body| {
        let spin: f64 =
            (0..body.wheelsets).map(|k| body.inertia_kg_m2[k] * body.wheel_speed_rad_s[k].powi(2)).sum();
        0.5 * (body.mass_kg * body.v_m_s.powi(2) + spin)
    };
    motion.bodies.iter().map(of).sum()
}

#[test]
fn what_energy_goes_can_be_named_and_nothing_gives_any_back() {
    let mut motion = rolling(18.0);
    let (mut work_j, mut slip_j, mut pads_j, mut gear_j) = (0.0, 0.0, 0.0, 0.0);
    let start_j = kinetic_j(&motion);
    for _ in 0..4000 {
        let before = motion.clone();
        motion.step(STEP_S);
        for (old, new) in before.bodies.iter().zip(&motion.bodies) {
            let v = 0.5 * (old.v_m_s + new.v_m_s);
            work_j += STEP_S * new.outer_n * v;
            for k in 0..new.wheelsets {
                let omega = 0.5 * (old.wheel_speed_rad_s[k] + new.wheel_speed_rad_s[k]);
                work_j += STEP_S * new.drive_nm[k] * omega;
                pads_j += STEP_S * new.braked_nm[k] * omega;
                slip_j += STEP_S * new.contact_n[k] * (new.radius_m[k] * omega - v);
            }
        }
        for (i, coupler) in motion.couplers.iter().enumerate() {
            let grown_m = coupler.extension_m - before.couplers[i].extension_m;
            gear_j += coupler.force_n * grown_m;
        }
    }
    let change_j = kinetic_j(&motion) - start_j;
    let left_j = change_j - (work_j - slip_j - pads_j - gear_j);
    println!(
        "kinetic {change_j:.0} J: work {work_j:.0}, pads {pads_j:.0}, slip {slip_j:.0}, draw gear {gear_j:.0}, left {left_j:.3}"
    );
    assert!(left_j.abs() < 1e-6 * change_j.abs());
    assert!(pads_j > 0.0 && slip_j > 0.0 && gear_j > 0.0);
    assert!(slip_j < 0.02 * pads_j, "rolling wheels lose little by creep");
}

/// Slip velocity at which the law gives a force, by bisection, m/s.
fn slip_of(law: &CreepLaw, contact: &Contact, force_n: f64, v_m_s: f64) -> f64 {
    let (mut low, mut high) = (-0.02 * v_m_s, 0.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if law.force(contact, middle, v_m_s).0 < force_n { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[test]
fn wheels_that_have_grip_do_not_slide_falsely() {
    for v_m_s in [0.5, 1.0, 3.3, 8.0, 20.0, 50.0] {
        for off_rad_s in [-0.25, -0.1, 0.0, 0.1, 0.25] {
            for share in [0.2, 0.5, 0.7] {
                let journey = Journey::new(on_rail(healthy(5, "railcar", None, 0.1), 0.3));
                let mut motion = journey.motion().clone();
                let body = &mut motion.bodies[0];
                body.friction = [0.3; 4];
                // Held at its speed, as by a very heavy train.
                body.mass_kg = 1e9;
                body.v_m_s = v_m_s;
                let loads = body.load_n;
                let torque_nm: [f64; 4] = std::array::from_fn(|k| share * 0.3 * loads[k] * body.radius_m[k]);
                body.brake_nm = torque_nm;
                body.wheel_speed_rad_s = body.radius_m.map(|radius| (v_m_s / radius + off_rad_s).max(0.1));
                for _ in 0..1000 {
                    motion.step(STEP_S);
                    motion.bodies[0].load_n = loads;
                }
                let body = &motion.bodies[0];
                let contact = Contact { load_n: loads[0], friction: 0.3, stiffness_n: body.stiffness_n[0] };
                let wanted = slip_of(&body.law, &contact, -torque_nm[0] / body.radius_m[0], body.v_m_s);
                let found = body.slip_m_s(0);
                assert!(
                    (found / wanted - 1.0).abs() < 0.02,
                    "at {v_m_s} m/s from {off_rad_s} rad/s, {share}: slip {found}, should be {wanted}"
                );
            }
        }
    }
}
