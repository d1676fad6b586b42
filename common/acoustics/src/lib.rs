//! Listening to rolling noise: the features by which dry and wet rail sound different.
//!
//! Shrestha et al. describe a window of one second by 26 numbers: zero-crossing rate, spectral centroid, roll-off,
//! 20 mel-frequency cepstral coefficients, chroma, bandwidth and RMS, each the mean over the window's frames. The
//! definitions here are those of the Python package librosa (0.11, its defaults), with which the paper worked.
//!
//! # Terms
//! * **frame** – [`FRAME`] samples under a Hann window, one every [`HOP`]; the signal is padded by half a frame on
//!   both sides so that frame `k` is centred at sample `k · HOP`.
//! * **mel** – a scale of pitch: linear up to 1 kHz, logarithmic above (Slaney).
//! * **chroma** – energy by pitch class, the octaves folded onto each other.

mod chroma;
mod features;
mod mel;
mod spectrum;
pub mod synthesis;
pub mod wav;

pub use features::{AudioError, AudioState, FEATURE_NAMES, FEATURES, FeatureExtractor, Features};

/// Samples of a frame.
pub const FRAME: usize = 2048;

/// Samples from one frame to the next.
pub const HOP: usize = 512;

/// Sample rate that the features are defined for, Hz.
pub const SAMPLE_RATE_HZ: u32 = 22_050;

/// Frequency bins of a frame's spectrum, DC and Nyquist included.
pub(crate) const BINS: usize = FRAME / 2 + 1;

/// Centre of frequency bin `bin`, Hz.
pub(crate) fn bin_frequency_hz(bin: usize) -> f64 {
    bin as f64 * f64::from(SAMPLE_RATE_HZ) / FRAME as f64
}
