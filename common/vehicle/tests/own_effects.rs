//! Effects written in a file: they do what the same law in Rust does, and what is wrong with them is said with what there is.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_vehicle::effects::own::{OwnEffectError, OwnEffects, register};
use railgrip_vehicle::effects::{self, Effect, Operating};
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion, SampleInput};
use railgrip_vehicle::{VehicleParameters, WagonModel};
use std::time::Instant;

fn file(text: &str) -> OwnEffects {
    toml::from_str(text).expect("a file of effects")
}

fn built(id: &str, values: &[f64]) -> Box<dyn Effect> {
    let (_, constructor) = effects::find(id).expect("a known effect");
    constructor(values)
}

const FADE: &str = r#"
schema = 1
[[effect]]
id = "own_fade"
term = "brake_friction"
law = "brake_friction"
expression = "value * max(1 - alpha_per_k * max(state - onset_k, 0), 0.05)"
[effect.state]
rate = "brake_power_w / 60e3 - state / cooling_time_s"
[effect.parameters.alpha_per_k]
unit = "1/K"
upper = 1e-2
default = 5e-4
neutral = 0.0
[effect.parameters.cooling_time_s]
unit = "s"
lower = 10.0
upper = 1000.0
default = 120.0
[effect.parameters.onset_k]
unit = "K"
upper = 300.0
default = 0.0
starts = [60.0]
"#;

/// Parameters stand in the order of their names: alpha, cooling time, onset.
#[test]
fn fade_from_a_file_is_the_fade_of_the_catalogue() {
    register(&file(FADE)).expect("registered");
    register(&file(FADE)).expect("the same once more");
    let own = built("own_fade", &[1e-3, 90.0, 20.0]);
    let catalogue = built("brake_fade", &[1e-3, 20.0, 90.0]);
    assert_eq!(own.spec().term, catalogue.spec().term);
    let hidden = |effect: &dyn Effect| vec![0.0; effect.hidden_len(0.01)];
    let (mut a, mut b) = (hidden(own.as_ref()), hidden(catalogue.as_ref()));
    let mut worst: f64 = 0.0;
    for k in 0..20_000 {
        let power = 150e3 * (1.0 + (0.001 * f64::from(k)).sin());
        let at = Operating { brake_power_w: [power, 0.5 * power, 0.0, 0.0], ..Operating::default() };
        own.advance(&at, 0.01, &mut a);
        catalogue.advance(&at, 0.01, &mut b);
        for wheelset in 0..2 {
            let pads = [(&own, &a), (&catalogue, &b)].map(|(e, h)| e.brake_friction(wheelset, &at, h, 0.35));
            worst = worst.max((pads[0] - pads[1]).abs());
        }
    }
    println!("disc {:.1} K warmer after 200 s; pad friction differs by at most {worst:.1e}", b[0]);
    assert!(b[0] > 100.0 && worst < 1e-9);
    // What it costs a simulation: the same stop with either.
    let time = |effect: Box<dyn Effect>| {
        let model = WagonModel::with_effects(&coach(), vec![effect]);
        let wagon = FastWagon::new(&model, 0.3, 0.01);
        let pressing = [2e4, 2e4, 0.0, 0.0];
        let input =
            SampleInput { pressing_force_n: pressing, mid_pressing_force_n: pressing, ..Default::default() };
        let motion = Motion { state: [40.0, 40.0 / 0.45, 40.0 / 0.45, 0.0, 0.0], ..Motion::default() };
        let mut hidden = wagon.start_hidden(&motion.state, &input);
        let from = Instant::now();
        let mut end = motion;
        for _ in 0..100 {
            end = motion;
            hidden.fill(0.0);
            for _ in 0..1000 {
                wagon.step(&mut end, &input, &Disturbance::default(), &mut hidden);
            }
        }
        (from.elapsed().as_secs_f64() / 1e5 * 1e9, end.state[0])
    };
    let ((own_ns, own_m_s), (catalogue_ns, m_s)) = (time(own), time(catalogue));
    println!(
        "a sample simulated: {own_ns:.0} ns with the file's, {catalogue_ns:.0} ns with the catalogue's, {:.1} times",
        own_ns / catalogue_ns
    );
    assert!(m_s < 37.0 && (own_m_s - m_s).abs() < 1e-6, "{own_m_s} and {m_s} m/s after the stop");
}

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

#[test]
fn one_wheelset_drags_as_in_the_catalogue() {
    let text = r#"
        schema = 1
        [[effect]]
        id = "own_drag"
        term = "brake_actuation"
        law = "brake_torque_nm"
        wheelset = 2
        expression = "value + torque_nm"
        parameters.torque_nm = { unit = "N m", upper = 5000.0, default = 500.0, neutral = 0.0 }
    "#;
    register(&file(text)).expect("registered");
    let (own, catalogue) = (built("own_drag", &[800.0]), built("dragging_brake", &[800.0, 2.0]));
    let at = Operating::default();
    for wheelset in 0..4 {
        let torques = [&own, &catalogue].map(|effect| effect.brake_torque_nm(wheelset, &at, &[], 1000.0));
        assert_eq!(torques[0], torques[1]);
        assert_eq!(torques[0], if wheelset == 1 { 1800.0 } else { 1000.0 });
        assert_eq!(own.brake_friction(wheelset, &at, &[], 0.3), 0.3, "another law stays");
    }
}

/// What gives no number changes nothing, and a state that is quick beside the sampling does not run away.
#[test]
fn the_odd_changes_nothing() {
    let text = r#"
        schema = 1
        [[effect]]
        id = "own_odd"
        term = "adhesion"
        law = "adhesion_peak"
        expression = "value * ln(19 - state)"
        [effect.state]
        start = 1.0
        rate = "(v_m_s - state) / 1e-6"
    "#;
    register(&file(text)).expect("registered");
    let own = built("own_odd", &[]);
    let at = Operating { v_m_s: 20.0, ..Operating::default() };
    let mut hidden = vec![0.0; own.hidden_len(0.05)];
    own.start(&at, &mut hidden);
    assert_eq!(hidden[..4], [1.0; 4]);
    own.advance(&at, 0.05, &mut hidden);
    assert!((hidden[0] - 20.0).abs() < 1e-6, "{}", hidden[0]);
    assert_eq!(own.adhesion_peak(0, &at, &hidden, 0.3), 0.3, "the logarithm of a negative number");
}

#[test]
fn what_is_wrong_is_said_with_what_there_is() {
    let plain = r#"schema = 1
        [[effect]]
        id = "own_wrong"
        term = "resistance"
        law = "body_force_n"
        expression = "value - k * v_m_s^2"
        parameters.k = { upper = 5.0, default = 0.0 }
    "#;
    let wrong = |from: &str, to: &str| {
        let text = plain.replace(from, to);
        assert_ne!(text, plain, "{from}");
        register(&file(&text)).expect_err("refused")
    };
    for (from, to, place, words) in [
        (
            "v_m_s^2",
            "v_km_h^2",
            "expression",
            "nothing is called `v_km_h` (perhaps v_m_s?); there are value, k, time_s, v_m_s",
        ),
        ("k * v", "k * * v", "expression", "\"value - k * * v_m_s^2\""),
        ("k * v", "k * state * v", "expression", "nothing is called `state`"),
        (
            "\"resistance\"",
            "\"friction\"",
            "term",
            "no term \"friction\"; there are brake_friction, brake_actuation",
        ),
        ("\"body_force_n\"", "\"force\"", "law", "no law \"force\"; there are pad_force_n, brake_friction"),
        ("own_wrong", "brake_fade", "id", "the catalogue has an effect of this id"),
        ("own_wrong", "Own wrong", "id", "lower-case letters"),
        ("default = 0.0", "default = 9.0", "parameters", "`k`: 9 is not within 0 to 5"),
        ("upper = 5.0", "upper = -5.0", "parameters", "lower must be below upper"),
        ("parameters.k", "parameters.v_m_s", "parameters", "`v_m_s` is the name of a quantity"),
        (
            "{ upper",
            "{ unit = \"N/foot\", upper",
            "parameters",
            "`k`: unit: nothing is measured in \"foot\"; a unit is 1",
        ),
        ("{ upper", "{ unit = \"\", upper", "parameters", "`k`: unit: is empty"),
        ("value - k * v_m_s^2", "value + 0 / (k - k)", "expression", "gives no number"),
        ("expression", "twins = [\"nope\"]\nexpression", "twins", "no effect is called \"nope\""),
        ("expression", "wheelset = 7\nexpression", "wheelset", "is 7, allowed is 1 to 4"),
    ] {
        let error = wrong(from, to);
        let OwnEffectError::Effect { what, problem, .. } = &error else { panic!("{error}") };
        assert_eq!(*what, place, "{error}");
        assert!(problem.contains(words), "{to}: {problem}");
    }
    assert_eq!(wrong("schema = 1", "schema = 2"), OwnEffectError::Schema { found: 2 });
    register(&file(plain)).expect("registered");
    let other = wrong("v_m_s^2", "v_m_s");
    assert_eq!(other, OwnEffectError::Twice { id: "own_wrong".into() });
    assert!(effects::find("Own wrong").is_none());
}
