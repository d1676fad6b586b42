//! The built-in model: what it reaches on what it never heard, what it refuses, and that its file is safe.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_acoustics::SAMPLE_RATE_HZ;
use railgrip_classifier::dataset::{sound, synthesise};
use railgrip_classifier::recipe::{
    Circumstances, HELD_OUT_NOISE_DB, Noise, Speeds, TEST_RIGS, UNHEARD_RIG, draw,
};
use railgrip_classifier::{Condition, Confusion, Ear, Hearing, Model, ModelError, Training, Window, train};
use std::f64::consts::TAU;

const COUNT: usize = SAMPLE_RATE_HZ as usize;

fn held_out(noise_db: f64) -> Circumstances {
    Circumstances { rigs: TEST_RIGS.to_vec(), speeds: Speeds::HeldOut, noise: Noise::Level(noise_db) }
}

#[test]
fn held_out_speeds_and_noise_are_told_apart_and_noise_hurts() {
    let model = Model::built_in().expect("built in");
    let accuracy = HELD_OUT_NOISE_DB.map(|noise_db| {
        let confusion = Confusion::of(&model, &synthesise(&held_out(noise_db), 360, 901));
        println!("noise {noise_db:>4} dB: accuracy {:.3}, {confusion:?}", confusion.accuracy());
        confusion.accuracy()
    });
    assert!(accuracy[0] > 0.88 && accuracy[1] > 0.86, "quiet");
    assert!(accuracy[3] > 0.65 && accuracy[3] < accuracy[0], "as loud as the rolling noise itself");
}

#[test]
fn a_rig_never_heard_is_told_better_than_by_chance() {
    let model = Model::built_in().expect("built in");
    let unheard = |noise_db| Circumstances { rigs: vec![UNHEARD_RIG], ..held_out(noise_db) };
    let accuracy = [-32.0, -20.0].map(|noise_db| {
        let confusion = Confusion::of(&model, &synthesise(&unheard(noise_db), 300, 902));
        println!(
            "{UNHEARD_RIG}, noise {noise_db:>4} dB: accuracy {:.3}, {confusion:?}",
            confusion.accuracy()
        );
        confusion.accuracy()
    });
    assert!(accuracy.iter().all(|accuracy| *accuracy > 0.6));
}

#[test]
fn the_same_seed_trains_the_same_model_and_its_file_keeps_it() {
    let training = Training { clips: 150, epochs: 3, seed: 5 };
    let folder = tempfile::tempdir().expect("folder");
    let [one, two] = ["one", "two"].map(|name| folder.path().join(name));
    let model = train(&training, |_, _| {}).expect("trained");
    model.save(&one).expect("saved");
    train(&training, |_, _| {}).expect("trained").save(&two).expect("saved");
    let bytes = std::fs::read(&one).expect("bytes");
    assert_eq!(bytes, std::fs::read(&two).expect("bytes"), "same seed, same bytes");

    let loaded = Model::load(&one).expect("loaded");
    assert_eq!(loaded.provenance(), model.provenance());
    let features: Vec<_> = synthesise(&held_out(-32.0), 20, 3).iter().map(|clip| clip.features).collect();
    let [before, after] = [&model, &loaded].map(|model| model.wet_probabilities(&features));
    let worst = before.iter().zip(&after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("half precision moves probabilities by at most {worst:.1e}");
    assert!(worst < 5e-3);
    assert!(matches!(train(&Training { clips: 5, ..training }, |_, _| {}), Err(ModelError::TooFew { .. })));
}

/// Figures of an independent library of tensors, candle 0.9.2, on these clips: with the built-in model, and with one that it
/// trained from the same random numbers over three and over forty-two steps.
#[test]
fn answers_and_training_are_those_of_an_independent_library() {
    let features: Vec<_> = synthesise(&held_out(-10.0), 8, 77).iter().map(|clip| clip.features).collect();
    let trained = |clips, epochs| train(&Training { clips, epochs, seed: 5 }, |_, _| {}).expect("trained");
    let compare = |name: &str, model: Model, theirs: [f64; 8], allowed: f64| {
        let ours = model.wet_probabilities(&features);
        let worst = ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{name}: probabilities differ by at most {worst:.1e}");
        assert!(ours.len() == 8 && worst < allowed, "{name}: {ours:?}");
    };
    compare("built in", Model::built_in().expect("built in"), BUILT_IN, 1e-5);
    compare("three steps", trained(150, 3), THREE_STEPS, 1e-4);
    compare("forty-two steps", trained(1000, 6), FORTY_TWO_STEPS, 1e-4);
}

const BUILT_IN: [f64; 8] = [
    0.207_326_114_177_703_9,
    0.700_985_610_485_076_9,
    0.013_239_375_315_606_594,
    0.798_934_221_267_700_2,
    0.016_046_183_183_789_253,
    0.997_687_935_829_162_6,
    0.039_305_359_125_137_33,
    0.580_253_303_050_994_9,
];
const THREE_STEPS: [f64; 8] = [
    0.918_730_556_964_874_3,
    0.878_596_186_637_878_4,
    0.234_085_977_077_484_13,
    0.873_920_023_441_314_7,
    0.234_198_644_757_270_8,
    0.982_956_886_291_503_9,
    0.873_966_932_296_752_9,
    0.909_459_412_097_930_9,
];
const FORTY_TWO_STEPS: [f64; 8] = [
    0.391_446_381_807_327_3,
    0.691_392_362_117_767_3,
    0.013_230_141_252_279_282,
    0.936_866_521_835_327_1,
    0.067_417_189_478_874_2,
    0.970_222_651_958_465_6,
    0.737_403_929_233_551,
    0.728_288_114_070_892_3,
];

#[test]
fn a_damaged_or_foreign_file_is_refused_with_a_reason() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("model");
    Model::built_in().expect("built in").save(&path).expect("saved");
    let good = std::fs::read(&path).expect("bytes");
    let try_bytes = |bytes: &[u8]| {
        std::fs::write(&path, bytes).expect("written");
        Model::load(&path).expect_err("must be refused").to_string()
    };
    let mut flipped = good.clone();
    *flipped.last_mut().expect("bytes") ^= 1;
    assert!(try_bytes(&flipped).contains("checksum"));
    assert!(try_bytes(&good[..good.len() / 2]).contains("safetensors"));
    assert!(try_bytes(b"dry").contains("allowed is"));
    let key = b"\\\"format\\\":";
    let at = good.windows(key.len()).position(|bytes| bytes == key).expect("header");
    let mut newer = good.clone();
    newer[at + key.len()] = b'2';
    assert!(try_bytes(&newer).contains("format 2"));
}

fn over_time(signal: impl Fn(f64) -> f64) -> Vec<f32> {
    (0..COUNT).map(|n| signal(n as f64 / COUNT as f64) as f32).collect()
}

#[test]
fn what_cannot_be_heard_gets_a_name_and_keeps_the_condition() {
    let mut ear = Ear::new(Model::built_in().expect("built in"), 0.0).expect("ear");
    let clip = draw(&held_out(-32.0), 2, 11).pop().expect("clip");
    let good = sound(&clip);
    let mut listen = |sample_rate_hz, samples: &[f32], speed_m_s| {
        ear.listen(&Window { sample_rate_hz, samples, speed_m_s })
    };
    let first = listen(SAMPLE_RATE_HZ, &good, Some(10.0));
    assert_eq!((first.hearing, first.condition), (Hearing::Heard, Some(Condition::Wet)), "{first:?}");
    let mut broken = good.clone();
    broken[99] = f32::NAN;
    let loud: Vec<f32> = good.iter().map(|x| (x * 60.0).clamp(-1.0, 1.0)).collect();
    let tone = over_time(|t| 0.4 * (TAU * 1000.0 * t).sin());
    for (name, rate, samples, speed, expected) in [
        ("48 kHz", 48_000, &good, None, Hearing::WrongSampleRate),
        ("zeros", SAMPLE_RATE_HZ, &vec![0.0; COUNT], None, Hearing::SilentMicrophone),
        ("stuck", SAMPLE_RATE_HZ, &vec![0.5; COUNT], None, Hearing::SilentMicrophone),
        ("loud", SAMPLE_RATE_HZ, &loud, None, Hearing::Clipped),
        ("NaN", SAMPLE_RATE_HZ, &broken, None, Hearing::NotFinite),
        ("short", SAMPLE_RATE_HZ, &good[..5000].to_vec(), None, Hearing::TooShort),
        ("standing", SAMPLE_RATE_HZ, &good, Some(0.0), Hearing::Standstill),
        ("tone", SAMPLE_RATE_HZ, &tone, None, Hearing::Unfamiliar),
    ] {
        let verdict = listen(rate, samples, speed);
        assert_eq!((verdict.hearing, verdict.wet, verdict.condition), (expected, None, None), "{name}");
    }
    assert_eq!(listen(SAMPLE_RATE_HZ, &good, None).condition, Some(Condition::Wet));
}
