//! Mel-frequency cepstral coefficients.

use crate::{BINS, SAMPLE_RATE_HZ, bin_frequency_hz};

/// Triangular filters over the spectrum.
const BANDS: usize = 128;

/// Coefficients kept.
pub(crate) const COEFFICIENTS: usize = 20;

/// Range below the loudest band beyond which levels are cut, dB.
const DYNAMIC_RANGE_DB: f64 = 80.0;

/// One triangular filter: its first bin and its weights from there.
struct Band {
    first: usize,
    weights: Vec<f64>,
}

/// Filter bank and cosine transform.
pub(crate) struct MelCepstrum {
    bands: Vec<Band>,
    cosines: Vec<[f64; BANDS]>,
}

impl MelCepstrum {
    pub(crate) fn new() -> Self {
        let top = mel_of_hz(0.5 * f64::from(SAMPLE_RATE_HZ));
        let edge = |i: usize| hz_of_mel(top * i as f64 / (BANDS + 1) as f64);
        let bands = (0..BANDS).map(|band| triangle(edge(band), edge(band + 1), edge(band + 2))).collect();
        Self { bands, cosines: (0..COEFFICIENTS).map(cosine_row).collect() }
    }

    /// Mean over the frames of each coefficient, from frames of magnitudes.
    pub(crate) fn mean_coefficients(&self, magnitudes: &[Vec<f64>]) -> [f64; COEFFICIENTS] {
        let levels: Vec<Vec<f64>> = magnitudes.iter().map(|frame| self.levels_db(frame)).collect();
        let loudest = levels.iter().flatten().copied().fold(f64::MIN, f64::max);
        let floor = loudest - DYNAMIC_RANGE_DB;
        // The transform is linear, so that the levels' mean over the frames can be taken first.
        let mut mean = [0.0; BANDS];
        for frame in &levels {
            for (sum, level) in mean.iter_mut().zip(frame) {
                *sum += level.max(floor) / levels.len() as f64;
            }
        }
        std::array::from_fn(|k| self.cosines[k].iter().zip(mean).map(|(c, level)| c * level).sum())
    }

    /// Power of each band in dB, cut at 1e-10.
    fn levels_db(&self, magnitudes: &[f64]) -> Vec<f64> {
        let power = |band: &Band| -> f64 {
            let bins = &magnitudes[band.first..];
            band.weights.iter().zip(bins).map(|(weight, magnitude)| weight * magnitude * magnitude).sum()
        };
        self.bands.iter().map(|band| 10.0 * power(band).max(1e-10).log10()).collect()
    }
}

/// Triangle over frequency of unit area (times two), as Slaney's auditory toolbox has it.
fn triangle(low_hz: f64, centre_hz: f64, high_hz: f64) -> Band {
    let weight = |bin: usize| {
        let f = bin_frequency_hz(bin);
        let rising = (f - low_hz) / (centre_hz - low_hz);
        let falling = (high_hz - f) / (high_hz - centre_hz);
        rising.min(falling).max(0.0) * 2.0 / (high_hz - low_hz)
    };
    let first = (0..BINS).find(|&bin| weight(bin) > 0.0).unwrap_or(0);
    let weights = (first..BINS).map(weight).take_while(|&w| w > 0.0).collect();
    Band { first, weights }
}

/// Row `k` of the orthonormal DCT-II.
fn cosine_row(k: usize) -> [f64; BANDS] {
    let scale = (if k == 0 { 1.0 } else { 2.0 } / BANDS as f64).sqrt();
    let step = std::f64::consts::PI * k as f64 / BANDS as f64;
    std::array::from_fn(|n| scale * (step * (n as f64 + 0.5)).cos())
}

/// Linear up to 1 kHz (200/3 Hz a mel), then 27 mel for each factor of 6.4.
const LINEAR_HZ_PER_MEL: f64 = 200.0 / 3.0;
const BREAK_HZ: f64 = 1000.0;
const BREAK_MEL: f64 = BREAK_HZ / LINEAR_HZ_PER_MEL;

fn log_step() -> f64 {
    6.4_f64.ln() / 27.0
}

fn mel_of_hz(hz: f64) -> f64 {
    if hz < BREAK_HZ { hz / LINEAR_HZ_PER_MEL } else { BREAK_MEL + (hz / BREAK_HZ).ln() / log_step() }
}

fn hz_of_mel(mel: f64) -> f64 {
    if mel < BREAK_MEL { mel * LINEAR_HZ_PER_MEL } else { BREAK_HZ * (log_step() * (mel - BREAK_MEL)).exp() }
}
