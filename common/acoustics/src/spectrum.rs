//! Short-time spectra.

use crate::{BINS, FRAME, HOP};
use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex};
use std::sync::Arc;

/// Short-time Fourier transform with a periodic Hann window and zero padding at both ends.
pub(crate) struct ShortTimeSpectrum {
    transform: Arc<dyn RealToComplex<f64>>,
    window: Vec<f64>,
}

impl ShortTimeSpectrum {
    pub(crate) fn new() -> Self {
        let turn = std::f64::consts::TAU / FRAME as f64;
        Self {
            transform: RealFftPlanner::new().plan_fft_forward(FRAME),
            window: (0..FRAME).map(|n| 0.5 - 0.5 * (turn * n as f64).cos()).collect(),
        }
    }

    /// Magnitudes of each frame of `audio`, [`BINS`] a frame.
    pub(crate) fn magnitudes(&self, audio: &[f32]) -> Vec<Vec<f64>> {
        let padded = framed(audio, |_| 0.0);
        let mut spectrum: Vec<Complex<f64>> = self.transform.make_output_vec();
        let mut scratch = self.transform.make_scratch_vec();
        let mut input = vec![0.0; FRAME];
        frames(&padded)
            .map(|frame| {
                for ((slot, sample), weight) in input.iter_mut().zip(frame).zip(&self.window) {
                    *slot = sample * weight;
                }
                let done = self.transform.process_with_scratch(&mut input, &mut spectrum, &mut scratch);
                debug_assert!(done.is_ok(), "buffers come from the plan itself");
                spectrum[..BINS].iter().map(|value| value.norm()).collect()
            })
            .collect()
    }
}

/// The signal with half a frame before and behind it, filled by `pad` (told whether it is the front).
pub(crate) fn framed(audio: &[f32], pad: impl Fn(bool) -> f64) -> Vec<f64> {
    let mut padded = vec![pad(true); FRAME / 2];
    padded.extend(audio.iter().map(|&sample| f64::from(sample)));
    padded.extend(std::iter::repeat_n(pad(false), FRAME / 2));
    padded
}

/// All frames of a padded signal.
pub(crate) fn frames(padded: &[f64]) -> impl Iterator<Item = &[f64]> {
    padded.windows(FRAME).step_by(HOP)
}
