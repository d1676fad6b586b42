//! The features against librosa's own figures (tests/data/make_reference.py), and what bad audio is called.

use railgrip_acoustics::{AudioError, AudioState, FEATURE_NAMES, FeatureExtractor, SAMPLE_RATE_HZ};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

const COUNT: usize = SAMPLE_RATE_HZ as usize;

fn noise(seed: u32, count: usize) -> Vec<f64> {
    let mut state = seed;
    (0..count)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / 2_147_483_648.0 - 1.0
        })
        .collect()
}

fn over_time(signal: impl Fn(f64, usize) -> f64) -> Vec<f32> {
    (0..COUNT).map(|n| signal(n as f64 / f64::from(SAMPLE_RATE_HZ), n) as f32).collect()
}

fn signals() -> Vec<(&'static str, Vec<f32>)> {
    let (white, rough, faint) = (noise(1, COUNT), noise(7, COUNT + 31), noise(3, COUNT));
    let smooth = |n: usize| rough[n..n + 32].iter().sum::<f64>() / 32.0;
    vec![
        ("white noise", over_time(|_, n| 0.3 * white[n])),
        ("two tones", over_time(|t, _| 0.4 * (TAU * 443.0 * t).sin() + 0.2 * (TAU * 1337.0 * t).sin())),
        ("rumble and squeal", over_time(|t, n| smooth(n) + 0.05 * (TAU * 2750.0 * t).sin())),
        ("swept tone", over_time(|t, n| 0.5 * (TAU * (200.0 * t + 900.0 * t * t)).sin() + 0.01 * faint[n])),
    ]
}

#[test]
fn features_agree_with_librosa_to_a_thousandth() {
    let text = include_str!("data/librosa_features.json");
    let reference: BTreeMap<String, Vec<f64>> = serde_json::from_str(text).expect("fixture");
    let extractor = FeatureExtractor::new(SAMPLE_RATE_HZ).expect("rate");
    for (name, audio) in signals() {
        let (features, state) = extractor.extract(&audio).expect("good audio");
        assert_eq!(state, AudioState::Good);
        let mut worst = (0.0, "");
        for ((ours, theirs), feature) in features.iter().zip(&reference[name]).zip(FEATURE_NAMES) {
            // Cepstral coefficients pass through zero: there the scale is a tenth of a decibel, not the value.
            let scale = if feature.starts_with("mfcc") { theirs.abs().max(0.1) } else { theirs.abs() };
            let error = (ours - theirs).abs() / scale;
            if error > worst.0 {
                worst = (error, feature);
            }
        }
        println!("{name}: largest relative difference {:.1e} ({})", worst.0, worst.1);
        assert!(worst.0 < 1e-3, "{name}: {} differs by {:.2e}", worst.1, worst.0);
    }
}

#[test]
fn bad_audio_has_a_name() {
    let extractor = FeatureExtractor::new(SAMPLE_RATE_HZ).expect("rate");
    assert_eq!(FeatureExtractor::new(48_000).err(), Some(AudioError::SampleRate { found_hz: 48_000 }));
    let (features, state) = extractor.extract(&vec![0.0; COUNT]).expect("silence has features");
    assert_eq!(state, AudioState::Silent);
    assert!(features.iter().all(|value| value.is_finite()), "{features:?}");
    assert_eq!(extractor.extract(&vec![0.3; COUNT]).expect("features").1, AudioState::Silent, "stuck");
    let overdriven = over_time(|t, _| (3.0 * (TAU * 300.0 * t).sin()).clamp(-1.0, 1.0));
    assert_eq!(extractor.extract(&overdriven).expect("features").1, AudioState::Clipped);
    assert_eq!(extractor.extract(&[0.1; 100]), Err(AudioError::TooShort { samples: 100 }));
    let mut broken = vec![0.1; COUNT];
    broken[17] = f32::NAN;
    assert_eq!(extractor.extract(&broken), Err(AudioError::NotFinite { index: 17 }));
}
