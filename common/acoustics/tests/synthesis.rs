//! The synthesised noise behaves as rolling noise does.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_acoustics::synthesis::{RIGS, Rig, Rolling, Scene, Surroundings, Synthesiser, dry_level_db};
use railgrip_acoustics::{FeatureExtractor, Features, SAMPLE_RATE_HZ};

fn quiet() -> Surroundings {
    Surroundings { background_db: 0.0, hum_db: 0.0, hiss_db: 0.0, ..Surroundings::default() }
}

fn rolling(rig: &Rig, speed_m_s: f64, wetness: f64) -> Rolling {
    Rolling {
        speed_m_s,
        load_n: rig.load_n,
        creepage: 0.01,
        wetness,
        roughness_db: rig.roughness_db,
        roughness_tilt_db: 0.0,
    }
}

fn second(rig: &Rig, rolling: Rolling, surroundings: Surroundings, seed: u64) -> Vec<f32> {
    let mut audio = Vec::new();
    let scene = Scene { rolling, surroundings };
    Synthesiser::new(rig.clone(), seed).render(&scene, SAMPLE_RATE_HZ as usize, &mut audio);
    audio
}

fn features(audio: &[f32]) -> Features {
    FeatureExtractor::new(SAMPLE_RATE_HZ).expect("rate").extract(audio).expect("good").0
}

fn level_db(audio: &[f32]) -> f64 {
    let power: f64 = audio.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>() / audio.len() as f64;
    10.0 * power.log10()
}

#[test]
fn levels_are_those_of_rolling_wheels_and_rise_with_speed() {
    for rig in RIGS.iter().map(|rig| rig()) {
        let (low, high) = rig.speed_m_s;
        let mid = 0.5 * (low + high);
        let [quiet, middle, loud] = [low, mid, high].map(|v| dry_level_db(&rig, v));
        // Rolling noise of trains grows with about 30 lg v (Thompson, chapter 1); slow rigs, which feel the flat part of
        // the roughness curve, grow less.
        let slope = (loud - middle) / (high / mid).log10();
        println!(
            "{}: {quiet:.0}, {middle:.0}, {loud:.0} dB at {low}, {mid:.1}, {high} m/s; {slope:.0} lg v",
            rig.name
        );
        assert!(quiet < middle && middle < loud);
        assert!((5.0..40.0).contains(&slope));
    }
    let wagon = dry_level_db(&Rig::named("track").expect("rig"), 30.0);
    assert!((95.0..120.0).contains(&wagon), "{wagon} dB beside a wheel at 108 km/h");
}

#[test]
fn the_same_seed_gives_the_same_samples_however_they_are_asked_for() {
    let rig = Rig::named("bogie").expect("rig");
    let scene = Scene { rolling: rolling(&rig, 2.0, 0.5), surroundings: Surroundings::default() };
    let whole = second(&rig, scene.rolling, scene.surroundings, 5);
    let (mut parts, mut synthesiser) = (Vec::new(), Synthesiser::new(rig.clone(), 5));
    for count in [1, 999, 2048, 19_002] {
        synthesiser.render(&scene, count, &mut parts);
    }
    assert_eq!(whole, parts);
    assert_ne!(whole, second(&rig, scene.rolling, scene.surroundings, 6));
}

#[test]
fn water_makes_a_rig_quieter_but_not_more_than_roughness_does() {
    for rig in RIGS.iter().map(|rig| rig()) {
        let speed = 0.6 * rig.speed_m_s.1;
        let [dry, wet] =
            [0.0, 1.0].map(|wetness| level_db(&second(&rig, rolling(&rig, speed, wetness), quiet(), 3)));
        let rough = Rolling { roughness_db: rig.roughness_db + 4.0, ..rolling(&rig, speed, 1.0) };
        let rough = level_db(&second(&rig, rough, quiet(), 3));
        println!("{}: dry {dry:.1} dB, wet {wet:.1} dB, wet and 4 dB rougher {rough:.1} dB", rig.name);
        assert!(wet < dry - 0.3, "the drop of Shrestha's Fig. 11");
        assert!(rough > wet + 2.0 && wet > dry - 9.0);
    }
}

#[test]
fn no_single_feature_tells_wet_from_dry() {
    use rand::{RngExt, SeedableRng};
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(4);
    let rig = Rig::named("bogie").expect("rig");
    let mut sets = [Vec::new(), Vec::new()];
    for number in 0..160 {
        let wet = number % 2;
        let speed = random.random_range(0.8..4.2);
        let wetness = if wet == 1 { random.random_range(0.45..1.0) } else { random.random_range(0.0..0.2) };
        let base = rolling(&rig, speed, wetness);
        let roughness_db = base.roughness_db + random.random_range(-4.0..4.0);
        let surroundings = Surroundings {
            background_db: dry_level_db(&rig, speed) + random.random_range(-30.0..-10.0),
            gain_db: random.random_range(-6.0..6.0),
            ..quiet()
        };
        let own = rig.clone().varied(&mut random);
        sets[wet].push(features(&second(
            &own,
            Rolling { roughness_db, ..base },
            surroundings,
            number as u64,
        )));
    }
    let mut best = (0.0, 0);
    for feature in 0..26 {
        let mut all: Vec<(f64, usize)> =
            (0..2).flat_map(|wet| sets[wet].iter().map(move |set| (set[feature], wet))).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut wet_below, mut dry_below) = (0.0_f64, 0.0_f64);
        for (_, wet) in all {
            if wet == 1 {
                wet_below += 1.0
            } else {
                dry_below += 1.0
            }
            let right = (wet_below - dry_below).abs() / 160.0 + 0.5;
            if right > best.0 {
                best = (right, feature);
            }
        }
    }
    println!("best single feature: number {} with {:.0} %", best.1, 100.0 * best.0);
    assert!(best.0 < 0.97 && best.0 > 0.55);
}
