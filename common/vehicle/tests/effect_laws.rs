//! Laws of effects where another form would be easy to write: ovals, hyperbolas, patches under each wheelset.

use railgrip_vehicle::EffectEntry;
use railgrip_vehicle::effects::{self, Effect, Observation, Operating};

fn built(id: &str, parameters: &[(&str, f64)]) -> Box<dyn Effect> {
    let parameters = parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    effects::build(&EffectEntry { id: id.into(), parameters }).expect("an effect of the catalogue")
}

#[test]
fn an_oval_ring_errs_twice_in_a_turn_and_an_eccentric_one_once() {
    // What a file does not say about the oval is that there is none.
    let eccentric =
        built("wheel_encoder_eccentricity", &[("sine", 0.01), ("cosine", 0.0), ("wheelset", 1.0)]);
    let oval = built(
        "wheel_encoder_eccentricity",
        &[("sine", 0.0), ("cosine", 0.0), ("second_sine", 0.004), ("wheelset", 1.0)],
    );
    let error = |effect: &dyn Effect, angle: f64| {
        let mut at = Operating { wheel_speed_rad_s: [50.0; 4], ..Operating::default() };
        at.wheel_angle_rad[0] = angle;
        let mut reading = Observation { v_m_s: 20.0, wheel_speed_rad_s: [50.0; 4] };
        effect.observe(&at, &[], &mut reading);
        assert_eq!(reading.wheel_speed_rad_s[1], 50.0, "the other wheelset is read as it is");
        reading.wheel_speed_rad_s[0] / 50.0 - 1.0
    };
    for angle in [0.3, 1.1, 2.0, 4.4] {
        let half_turn = angle + std::f64::consts::PI;
        let once = error(eccentric.as_ref(), angle) + error(eccentric.as_ref(), half_turn);
        let twice = error(oval.as_ref(), angle) - error(oval.as_ref(), half_turn);
        assert!(once.abs() < 1e-12 && twice.abs() < 1e-12, "{once} {twice}");
        assert!((error(oval.as_ref(), angle) - 0.004 * (2.0 * angle).sin()).abs() < 1e-12);
    }
}

#[test]
fn a_levelling_force_turns_the_power_into_a_hyperbola() {
    let (level, force_n) = (1e5, [2e4, 4e4]);
    let law = built("brake_friction_pressure", &[("exponent", 1.0), ("levelling_force_n", level)]);
    let friction = |force_n: f64| {
        let at = Operating { pressing_force_n: [force_n; 4], ..Operating::default() };
        law.brake_friction(0, &at, &[], 0.35)
    };
    let product = force_n.map(|force_n| friction(force_n) * (force_n + level));
    println!("mu (F + F1) at two forces: {product:?}");
    assert!((product[0] / product[1] - 1.0).abs() < 1e-12 && (friction(5e4) - 0.35).abs() < 1e-12);
}

#[test]
fn each_wheelset_meets_a_patch_at_its_own_place() {
    let patch = built("low_adhesion_patch", &[("start_m", 200.0), ("length_m", 50.0), ("loss", 0.5)]);
    // The centre of the wagon is a good wheelbase ahead of the patch's end.
    let at =
        Operating { position_m: 254.0, wheelset_position_m: [7.0, -7.0, 0.0, 0.0], ..Operating::default() };
    let peaks = [0, 1].map(|wheelset| patch.adhesion_peak(wheelset, &at, &[], 0.3));
    println!("adhesion of both wheelsets: {peaks:?}");
    assert!(peaks[0] > 0.299 && peaks[1] < 0.2);
    let before =
        Operating { position_m: 195.0, wheelset_position_m: [7.0, -7.0, 0.0, 0.0], ..Operating::default() };
    let peaks = [0, 1].map(|wheelset| patch.adhesion_peak(wheelset, &before, &[], 0.3));
    assert!(peaks[0] < 0.2 && peaks[1] > 0.299);
}

#[test]
fn a_pads_friction_follows_its_disc_into_a_slide() {
    let text = include_str!("../../../config/vehicle.toml");
    let mut vehicle: railgrip_vehicle::VehicleParameters = toml::from_str(text).expect("vehicle");
    let parameters = [("rise".to_owned(), 0.5), ("decay_speed_m_s".to_owned(), 6.0)].into();
    vehicle.effects = vec![EffectEntry { id: "brake_friction_speed".into(), parameters }];
    let model = railgrip_vehicle::WagonModel::new(&vehicle).expect("model");
    let rolling = 20.0 / vehicle.wheelset.radius_m;
    let at = Operating { v_m_s: 20.0, wheel_speed_rad_s: [rolling, 0.0, 0.0, 0.0], ..Operating::default() };
    let input = railgrip_vehicle::WagonInput {
        pressing_force_n: [4e4; 4],
        ..railgrip_vehicle::WagonInput::default()
    };
    let friction = model.loading(&at, &input, 0.01, &[]).brake_friction;
    let nominal = vehicle.brake.friction_coefficient;
    println!("rolling {:.4}, locked {:.4}, nominal {nominal}", friction[0], friction[1]);
    assert!((friction[0] / (nominal * (1.0 + 0.5 * (-20.0f64 / 6.0).exp())) - 1.0).abs() < 1e-12);
    assert!((friction[1] / (nominal * 1.5) - 1.0).abs() < 1e-12, "a disc that stands grips as at standstill");
}

#[test]
fn adhesion_over_speed_is_curtius_and_knifflers_by_default_and_keeps_its_asymptote() {
    use railgrip_vehicle::adhesion::curtius_kniffler;
    let law = built("adhesion_speed", &[]);
    let peak = |law: &dyn Effect, v_m_s: f64| {
        law.adhesion_peak(0, &Operating { v_m_s, ..Operating::default() }, &[], 1.0)
    };
    for v in [0.0, 5.0, 15.0, 30.0, 45.0] {
        let published = curtius_kniffler(v) / curtius_kniffler(15.0);
        assert!((peak(law.as_ref(), v) / published - 1.0).abs() < 1e-12, "at {v} m/s");
    }
    let fast = peak(law.as_ref(), 1e6) * curtius_kniffler(15.0);
    println!("at any speed at least {fast:.4}");
    assert!((fast - 0.161).abs() < 1e-4);
    let neutral = built("adhesion_speed", &[("decay_s_per_m", 0.0)]);
    assert_eq!(peak(neutral.as_ref(), 40.0), 1.0);
}

/// A fit steps a hair below "none", sensors at rest read less than nothing, wagons roll backwards: no law may panic or make a number
/// that is none of it. A force of hysteresis once ended a diagnosis.
#[test]
fn no_law_breaks_at_the_edge_of_what_it_may_be_asked() {
    let mut asked = 0;
    for (spec, boxed) in effects::all() {
        let corner = |which: usize| -> Vec<f64> {
            let value = |p: &effects::ParameterSpec| {
                let hair = 1e-9 * (p.upper - p.lower);
                [p.lower - hair, p.lower, p.default, p.upper, p.upper + hair][which]
            };
            spec.parameters.iter().map(|p| if p.discrete { p.default } else { value(p) }).collect()
        };
        for (which, force_n, v_m_s) in (0..5).flat_map(|which| {
            [-5e2, -1e-9, 0.0, 1e-9, 3e4]
                .into_iter()
                .flat_map(move |force_n| [-2.0, 0.0, 1e-6, 30.0].map(|v_m_s| (which, force_n, v_m_s)))
        }) {
            let effect = boxed(&corner(which));
            let at = Operating {
                wheelsets: 4,
                time_s: 3.0,
                v_m_s,
                position_m: 200.0,
                adhesion_peak: [0.2; 4],
                wheel_speed_rad_s: [2.0 * v_m_s; 4],
                pressing_force_n: [force_n; 4],
                drive_torque_nm: [-force_n; 4],
                ..Operating::default()
            };
            let mut hidden = vec![0.0; effect.hidden_len(0.02)];
            effect.start(&at, &mut hidden);
            let mut reading = Observation { v_m_s, wheel_speed_rad_s: [2.0 * v_m_s; 4] };
            let mut all = Vec::new();
            for _ in 0..3 {
                effect.advance(&at, 0.02, &mut hidden);
                for wheelset in 0..4 {
                    all.push(effect.pad_force_n(wheelset, &at, &hidden, force_n));
                    all.push(effect.brake_friction(wheelset, &at, &hidden, 0.35));
                    all.push(effect.brake_torque_nm(wheelset, &at, &hidden, 0.1 * force_n));
                    all.push(effect.drive_torque_nm(wheelset, &at, &hidden, 0.1 * force_n));
                    all.push(effect.adhesion_peak(wheelset, &at, &hidden, 0.2));
                }
                all.push(effect.body_force_n(&at, &hidden, -100.0));
                all.push(effect.headwind_m_s(&at, &hidden, 0.0));
                effect.observe(&at, &hidden, &mut reading);
            }
            all.extend(reading.wheel_speed_rad_s.into_iter().chain([reading.v_m_s]));
            let numbers = all.iter().chain(&hidden).all(|value| value.is_finite());
            assert!(numbers, "{} at corner {which}, {force_n} N, {v_m_s} m/s: {all:?} {hidden:?}", spec.id);
            asked += 1;
        }
    }
    println!("{asked} corners of {} effects", effects::all().len());
}
