//! The axle that twists against two masses in fine steps: rolling, and in slides on low rail.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_vehicle::effects;
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion, SampleInput};
use railgrip_vehicle::{EffectEntry, VehicleParameters, WagonInput, WagonModel, WagonState};

const COMPLIANCE_RAD_PER_KNM: f64 = 0.02;
/// Moments of inertia of discs and gear, kg m², of 120 of their wheelset: the lighter part of it, and the heavier one.
const LIGHT_KG_M2: f64 = 30.0;
const HEAVY_KG_M2: f64 = 70.0;
const DAMPING_RATIO: f64 = 0.03;
/// Steps of the fine solution in a sample of 10 ms.
const FINE: usize = 200;

fn coach() -> VehicleParameters {
    toml::from_str(
        r#"
        schema = 1
        name = "coach"
        body = { mass_kg = 40000.0, com_height_m = 1.6, wheelbase_m = 10.0 }
        wheelset = { radius_m = 0.45, inertia_kg_m2 = 120.0 }
        brake = { radius_m = 0.25, friction_coefficient = 0.35 }
        resistance = { constant_n = 400.0, linear_n_s_per_m = 8.0, drag_n_s2_per_m2 = 4.0 }
        contact = { stiffness_n = 6.0e6, k_a = 1.0, k_s = 0.4 }
        rail = { dry = 0.3, wet = 0.12, low = 0.06 }
        sensors = { sample_rate_hz = 100.0, speed_sigma_m_s = 0.03, wheel_speed_sigma_rad_s = 0.03, pressing_force_sigma_n = 150.0 }
        "#,
    )
    .expect("a vehicle")
}

/// Pressing force at a sample, N: full for 0.6 s of each second as under slide protection, or half of it for 0.5 s.
fn force_n(sample: usize, slides: bool) -> f64 {
    match slides {
        true if sample % 100 < 60 => 22e3,
        true => 4e3,
        false if sample % 100 < 50 => 11e3,
        false => 0.0,
    }
}

/// Encoder speeds of the first wheelset, rad/s, from two masses on a shaft whose torque drives the wheels of a rigid model.
fn two_masses(samples: usize, discs_kg_m2: f64, adhesion: f64, slides: bool) -> Vec<f64> {
    let mut vehicle = coach();
    vehicle.wheelset.inertia_kg_m2 -= discs_kg_m2;
    let wheels = WagonModel::new(&vehicle).expect("a model");
    let per_n = vehicle.brake.radius_m * vehicle.brake.friction_coefficient;
    let stiffness = 1e3 / COMPLIANCE_RAD_PER_KNM;
    let damping = 2.0 * DAMPING_RATIO * (stiffness * discs_kg_m2).sqrt();
    let omega = 20.0 / vehicle.wheelset.radius_m;
    let mut state = WagonState { v_m_s: 20.0, wheel_speed_rad_s: [omega; railgrip_vehicle::MAX_WHEELSETS] };
    let (mut twist, mut rate, mut acceleration) = ([0.0; 2], [0.0; 2], 0.0);
    let step_s = 0.01 / FINE as f64;
    let mut read = vec![omega];
    for sample in 0..samples {
        let brake_nm = per_n * 0.5 * (force_n(sample, slides) + force_n(sample + 1, slides));
        for _ in 0..FINE {
            let mut input = WagonInput {
                adhesion_peak: [adhesion; railgrip_vehicle::MAX_WHEELSETS],
                ..WagonInput::default()
            };
            for i in 0..2 {
                input.drive_torque_nm[i] = stiffness * twist[i] + damping * rate[i];
            }
            let at = wheels.operating(&state, &input);
            let loading = wheels.loading(&at, &input, step_s, &[]);
            let before = state.wheel_speed_rad_s;
            state = wheels.step(&state, &loading, step_s, &mut acceleration);
            for i in 0..2 {
                let wheel = (state.wheel_speed_rad_s[i] - before[i]) / step_s;
                rate[i] += step_s * ((-brake_nm - input.drive_torque_nm[i]) / discs_kg_m2 - wheel);
                twist[i] += step_s * rate[i];
            }
        }
        read.push(state.wheel_speed_rad_s[0] + rate[0]);
    }
    read
}

/// The effect of the catalogue with the same shaft.
fn torsion(discs_kg_m2: f64) -> EffectEntry {
    let parameters = [
        ("compliance_rad_per_knm", COMPLIANCE_RAD_PER_KNM),
        ("disc_inertia_kg_m2", discs_kg_m2),
        ("damping_ratio", DAMPING_RATIO),
    ];
    EffectEntry {
        id: "axle_torsion".to_owned(),
        parameters: parameters.map(|(name, value)| (name.to_owned(), value)).into_iter().collect(),
    }
}

/// The same as the effect of the catalogue in the fast wagon says, or without any effect.
fn sampled(samples: usize, discs_kg_m2: Option<f64>, adhesion: f64, slides: bool) -> Vec<f64> {
    let own = discs_kg_m2.map(|discs| effects::build(&torsion(discs)).expect("an effect"));
    let model = WagonModel::with_effects(&coach(), own.into_iter().collect());
    let wagon = FastWagon::new(&model, adhesion, 0.01);
    let omega = 20.0 / 0.45;
    let mut motion = Motion { state: [omega; 5], ..Motion::default() };
    motion.state[0] = 20.0;
    let input = |sample: usize| {
        let (now, next) = (force_n(sample, slides), force_n(sample + 1, slides));
        SampleInput {
            pressing_force_n: [now; 4],
            mid_pressing_force_n: [0.5 * (now + next); 4],
            ..SampleInput::default()
        }
    };
    let mut hidden = wagon.start_hidden(&motion.state, &input(0));
    let mut read = vec![omega];
    for sample in 0..samples {
        wagon.step(&mut motion, &input(sample), &Disturbance::default(), &mut hidden);
        read.push(wagon.read(&motion, &input(sample + 1), &hidden)[1]);
    }
    read
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

#[test]
fn an_encoder_on_a_soft_axle_reads_what_two_masses_in_fine_steps_do() {
    for (what, discs_kg_m2, adhesion, slides) in [
        ("rolling", LIGHT_KG_M2, 0.3, false),
        ("in slides", LIGHT_KG_M2, 0.06, true),
        ("heavy discs, rolling", HEAVY_KG_M2, 0.3, false),
        ("heavy discs, in slides", HEAVY_KG_M2, 0.06, true),
    ] {
        let samples = 800;
        let fine = two_masses(samples, discs_kg_m2, adhesion, slides);
        let soft = rms(&fine, &sampled(samples, Some(discs_kg_m2), adhesion, slides));
        let stiff = rms(&fine, &sampled(samples, None, adhesion, slides));
        println!("{what}: RMS error {soft:.4} rad/s with the twist, {stiff:.4} rad/s without");
        assert!(soft < 0.03, "{what}: {soft} rad/s is more than a sensor's noise");
        assert!(soft < 0.2 * stiff, "{what}: {soft} of {stiff}");
    }
}

#[test]
fn without_compliance_the_axle_is_stiff() {
    let entry = EffectEntry {
        id: "axle_torsion".to_owned(),
        parameters: [("compliance_rad_per_knm".to_owned(), 0.0)].into_iter().collect(),
    };
    let stiff = WagonModel::with_effects(&coach(), vec![effects::build(&entry).expect("an effect")]);
    let rigid = WagonModel::new(&coach()).expect("a model");
    assert_eq!(stiff.constants().inertia_kg_m2, rigid.constants().inertia_kg_m2);
    let wagon = FastWagon::new(&stiff, 0.06, 0.01);
    let motion = Motion { state: [20.0, 44.0, 43.0, 0.0, 0.0], ..Motion::default() };
    let mut hidden = wagon.start_hidden(&motion.state, &SampleInput::default());
    let (mut a, mut b) = (motion, motion);
    for _ in 0..50 {
        wagon.step(&mut a, &SampleInput::default(), &Disturbance::default(), &mut hidden);
        FastWagon::new(&rigid, 0.06, 0.01).step(
            &mut b,
            &SampleInput::default(),
            &Disturbance::default(),
            &mut [],
        );
    }
    assert_eq!(a, b);
}

#[test]
fn discs_that_pads_hold_do_not_swing() {
    let (pressed, speed) = (11e3, 1.5);
    let model =
        WagonModel::with_effects(&coach(), vec![effects::build(&torsion(LIGHT_KG_M2)).expect("an effect")]);
    let wagon = FastWagon::new(&model, 0.3, 0.01);
    let omega = speed / 0.45;
    let mut motion = Motion { state: [speed, omega, omega, 0.0, 0.0], ..Motion::default() };
    let input = |force_n: f64| SampleInput {
        pressing_force_n: [force_n; 4],
        mid_pressing_force_n: [force_n; 4],
        ..SampleInput::default()
    };
    let mut hidden = wagon.start_hidden(&motion.state, &input(pressed));
    let mut step = |motion: &mut Motion, force_n: f64| {
        wagon.step(motion, &input(force_n), &Disturbance::default(), &mut hidden);
        wagon.read(motion, &input(force_n), &hidden)[1]
    };
    let stands = (0..2000).find(|_| step(&mut motion, pressed) < 0.1 && motion.state[0] < 0.02);
    println!("the wagon stands after {stands:?} samples");
    assert!(stands.is_some(), "{:?}", motion.state);
    let held: Vec<f64> = (0..100).map(|_| step(&mut motion, pressed).abs()).collect();
    let swing = held[10..].iter().copied().fold(0.0, f64::max);
    let let_go = (0..100).map(|_| step(&mut motion, 0.0).abs()).fold(0.0, f64::max);
    println!("encoder at standstill: {swing:.4} rad/s while pads hold, up to {let_go:.4} after they let go");
    assert!(swing < 0.03, "discs swing by more than a sensor's noise between clamped pads: {swing} rad/s");
    assert!(let_go > 0.2, "the twist comes out of the shaft when pads let go: {let_go} rad/s");
}
