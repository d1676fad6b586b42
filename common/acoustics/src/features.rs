//! The 26 features of a window of one second, and the state of the audio itself.

use crate::mel::{COEFFICIENTS, MelCepstrum};
use crate::spectrum::{ShortTimeSpectrum, framed, frames};
use crate::{FRAME, SAMPLE_RATE_HZ, bin_frequency_hz, chroma};

/// Number of features.
pub const FEATURES: usize = 26;

/// The features in their order.
pub const FEATURE_NAMES: [&str; FEATURES] = [
    "zero_crossing_rate",
    "spectral_centroid_hz",
    "spectral_rolloff_hz",
    "mfcc_01",
    "mfcc_02",
    "mfcc_03",
    "mfcc_04",
    "mfcc_05",
    "mfcc_06",
    "mfcc_07",
    "mfcc_08",
    "mfcc_09",
    "mfcc_10",
    "mfcc_11",
    "mfcc_12",
    "mfcc_13",
    "mfcc_14",
    "mfcc_15",
    "mfcc_16",
    "mfcc_17",
    "mfcc_18",
    "mfcc_19",
    "mfcc_20",
    "chroma",
    "spectral_bandwidth_hz",
    "rms",
];

/// Share of a frame's magnitude below the roll-off frequency.
const ROLLOFF_SHARE: f64 = 0.85;

/// The features of one window, in the order of [`FEATURE_NAMES`].
pub type Features = [f64; FEATURES];

/// What a window is, apart from what it sounds like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AudioState {
    /// Fit for classification.
    Good,
    /// No sound beyond quantisation: the microphone is off or dead.
    Silent,
    /// More than one sample in a thousand at the limits: overdriven.
    Clipped,
}

/// Audio from which no features can be computed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AudioError {
    /// Another sample rate than the features are defined for.
    #[error(
        "audio is sampled at {found_hz} Hz, the features are defined at {SAMPLE_RATE_HZ} Hz; resample it first"
    )]
    SampleRate {
        /// The audio's rate, Hz.
        found_hz: u32,
    },
    /// Shorter than a frame.
    #[error("a window of {samples} samples is shorter than one frame of {FRAME}")]
    TooShort {
        /// Samples given.
        samples: usize,
    },
    /// A sample that is not a number.
    #[error("sample {index} is not a finite number")]
    NotFinite {
        /// Its index in the window.
        index: usize,
    },
}

/// Computes features; holds windows, filters and transform plans.
pub struct FeatureExtractor {
    spectrum: ShortTimeSpectrum,
    mel: MelCepstrum,
}

impl FeatureExtractor {
    /// An extractor for audio at [`SAMPLE_RATE_HZ`].
    ///
    /// # Errors
    /// Another sample rate.
    pub fn new(sample_rate_hz: u32) -> Result<Self, AudioError> {
        if sample_rate_hz != SAMPLE_RATE_HZ {
            return Err(AudioError::SampleRate { found_hz: sample_rate_hz });
        }
        Ok(Self { spectrum: ShortTimeSpectrum::new(), mel: MelCepstrum::new() })
    }

    /// Features and state of a window, full scale ±1.
    ///
    /// # Errors
    /// A window shorter than one frame, or with samples that are not finite.
    pub fn extract(&self, audio: &[f32]) -> Result<(Features, AudioState), AudioError> {
        if audio.len() < FRAME {
            return Err(AudioError::TooShort { samples: audio.len() });
        }
        if let Some(index) = audio.iter().position(|sample| !sample.is_finite()) {
            return Err(AudioError::NotFinite { index });
        }
        let magnitudes = self.spectrum.magnitudes(audio);
        let shapes: Vec<Shape> = magnitudes.iter().map(|frame| Shape::of(frame)).collect();
        let mean = |value: fn(&Shape) -> f64| shapes.iter().map(value).sum::<f64>() / shapes.len() as f64;

        let mut features = [0.0; FEATURES];
        features[0] = zero_crossing_rate(audio);
        features[1] = mean(|shape| shape.centroid_hz);
        features[2] = mean(|shape| shape.rolloff_hz);
        features[3..3 + COEFFICIENTS].copy_from_slice(&self.mel.mean_coefficients(&magnitudes));
        features[23] = chroma::mean_chroma(&magnitudes);
        features[24] = mean(|shape| shape.bandwidth_hz);
        features[25] = rms(audio);
        Ok((features, state(audio)))
    }
}

fn state(audio: &[f32]) -> AudioState {
    // A dead microphone may leave a constant offset: what counts is how far samples move.
    let (low, high) = audio.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), sample| {
        (low.min(*sample), high.max(*sample))
    });
    let at_limit = audio.iter().filter(|sample| sample.abs() >= 0.999).count();
    if high - low < 4.0 / 32_768.0 {
        AudioState::Silent
    } else if at_limit * 1000 > audio.len() {
        AudioState::Clipped
    } else {
        AudioState::Good
    }
}

/// Where the magnitude of a frame lies over frequency.
struct Shape {
    centroid_hz: f64,
    bandwidth_hz: f64,
    rolloff_hz: f64,
}

impl Shape {
    fn of(magnitudes: &[f64]) -> Self {
        let total: f64 = magnitudes.iter().sum();
        let share =
            |magnitude: f64| if total > f64::from(f32::MIN_POSITIVE) { magnitude / total } else { magnitude };
        let moment = |value: &dyn Fn(f64) -> f64| -> f64 {
            magnitudes.iter().enumerate().map(|(bin, &m)| share(m) * value(bin_frequency_hz(bin))).sum()
        };
        let centroid_hz = moment(&|f| f);
        let bandwidth_hz = moment(&|f| (f - centroid_hz).powi(2)).sqrt();
        let mut below = 0.0;
        let rolloff = magnitudes.iter().position(|magnitude| {
            below += magnitude;
            below >= ROLLOFF_SHARE * total
        });
        Self { centroid_hz, bandwidth_hz, rolloff_hz: rolloff.map_or(0.0, bin_frequency_hz) }
    }
}

/// Mean over the frames of the share of samples at which the sign changes; the ends are padded with the end values.
fn zero_crossing_rate(audio: &[f32]) -> f64 {
    let ends = [audio.first(), audio.last()].map(|end| f64::from(end.copied().unwrap_or(0.0)));
    let padded = framed(audio, |front| if front { ends[0] } else { ends[1] });
    let negative = |sample: f64| sample < -1e-10;
    let rates: Vec<f64> = frames(&padded)
        .map(|frame| {
            let changes = frame.windows(2).filter(|pair| negative(pair[0]) != negative(pair[1])).count();
            changes as f64 / FRAME as f64
        })
        .collect();
    rates.iter().sum::<f64>() / rates.len() as f64
}

/// Mean over the frames of their root mean square.
fn rms(audio: &[f32]) -> f64 {
    let padded = framed(audio, |_| 0.0);
    let levels: Vec<f64> = frames(&padded)
        .map(|frame| (frame.iter().map(|x| x * x).sum::<f64>() / FRAME as f64).sqrt())
        .collect();
    levels.iter().sum::<f64>() / levels.len() as f64
}
