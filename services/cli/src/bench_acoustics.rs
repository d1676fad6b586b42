//! `railgrip bench --acoustics`: listening to one second of audio, beside what its Fourier transforms alone cost.

use std::hint::black_box;

use railgrip_acoustics::synthesis::{Rig, Rolling, Scene, Surroundings, Synthesiser};
use railgrip_acoustics::{FRAME, FeatureExtractor, HOP, SAMPLE_RATE_HZ};
use railgrip_classifier::{Ear, Model, Window};
use realfft::RealFftPlanner;

use crate::CliError;
use crate::bench_line::{Line, line, time};

pub(crate) fn lines() -> Result<Vec<Line>, CliError> {
    let audio = second()?;
    let transforms = time_transforms(&audio);
    let reference = "its 44 Fourier transforms of 2048 alone";
    let extractor = FeatureExtractor::new(SAMPLE_RATE_HZ).map_err(CliError::failed)?;
    let features = time(|| {
        let _ = black_box(extractor.extract(black_box(&audio)));
    });
    let model = Model::built_in().map_err(CliError::failed)?;
    let (found, _) = extractor.extract(&audio).map_err(CliError::failed)?;
    let network = time(|| {
        let _ = black_box(model.wet_probabilities(black_box(&[found])));
    });
    let mut ear = Ear::new(model, 0.0).map_err(CliError::failed)?;
    let window = Window { sample_rate_hz: SAMPLE_RATE_HZ, samples: &audio, speed_m_s: Some(2.0) };
    let whole = time(|| {
        let _ = black_box(ear.listen(black_box(&window)));
    });
    Ok(vec![
        line("1 s of audio: features and classification", whole, reference, transforms),
        line("  the 26 features", features, reference, transforms),
        line("  the network 26-512-512-2", network, reference, transforms),
    ])
}

/// The bogie rig on a wet day.
fn second() -> Result<Vec<f32>, CliError> {
    let rig = Rig::named("bogie").ok_or_else(|| CliError::failed("the bogie rig makes no noise"))?;
    let rolling = Rolling {
        speed_m_s: 2.0,
        load_n: rig.load_n,
        creepage: 0.01,
        wetness: 1.0,
        roughness_db: rig.roughness_db,
        roughness_tilt_db: 0.0,
    };
    let mut audio = Vec::new();
    let scene = Scene { rolling, surroundings: Surroundings::default() };
    Synthesiser::new(rig, 1).render(&scene, SAMPLE_RATE_HZ as usize, &mut audio);
    Ok(audio)
}

fn time_transforms(audio: &[f32]) -> f64 {
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(FRAME);
    let mut input: Vec<f64> = audio.iter().take(FRAME).map(|sample| f64::from(*sample)).collect();
    let (mut output, mut scratch) = (transform.make_output_vec(), transform.make_scratch_vec());
    let frames = audio.len() / HOP + 1;
    let kept = input.clone();
    time(move || {
        for _ in 0..frames {
            input.copy_from_slice(&kept);
            let _ = transform.process_with_scratch(&mut input, &mut output, &mut scratch);
            black_box(&output);
        }
    })
}
