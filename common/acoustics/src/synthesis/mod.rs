//! Rolling noise made by calculation: what a microphone beside a wheel hears, from roughness to samples.
//!
//! There is no public collection of such sounds with the rail's condition noted, so the network learns from these. The
//! chain is that of the rolling-noise models in use (Remington 1976; Thompson, *Railway Noise and Vibration*, 2009):
//! roughness, passing under the wheel, drives wheel and rail against each other through the spring of their contact;
//! what moves radiates. On top come what friction excites, water, other machines, wind and the microphone itself.
//!
//! **What water changes**, each partly, and all of it masked by circumstances that vary as much:
//! * wheel modes lose more energy ([`rig`]): their peaks become lower and broader;
//! * the film carries part of the fine roughness ([`contact`]): less excitation at short wavelengths;
//! * friction halves (Shrestha et al., section 4.1.1), and with it the noise of creeping contacts; squeal gets rare;
//! * spray hisses at high frequencies, as do leaking air and rubbing brakes on a dry day.
//!
//! # Glossary
//! * **wetness** – 0 dry, 1 a closed film of water; a damp rail lies between.
//! * **power density** – of pressure squared or of samples squared, one-sided, per hertz.
//! * **full scale** – a sample of 1.

pub mod contact;
mod mobility;
mod render;
pub mod rig;
mod sources;

pub use render::{Synthesiser, dry_level_db};
pub use rig::{RIGS, Rig, rig_names};

/// How a wheel rolls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rolling {
    /// Speed of the wheel's tread, m/s.
    pub speed_m_s: f64,
    /// Load of the wheel, N.
    pub load_n: f64,
    /// Creepage, magnitude.
    pub creepage: f64,
    /// 0 dry to 1 wet.
    pub wetness: f64,
    /// Combined roughness over that of a smooth rail ([`contact::smooth_roughness_db`]), dB.
    pub roughness_db: f64,
    /// More of that at short wavelengths (positive) or at long ones (negative), dB per octave about 30 mm.
    pub roughness_tilt_db: f64,
}

/// What else is to be heard, and how the microphone hears it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// Level of other machines at the microphone, dB re 20 µPa.
    pub background_db: f64,
    /// Slope of its spectrum, dB per octave; −3 is pink.
    pub background_slope_db: f64,
    /// Level of a hum with harmonics, dB re 20 µPa.
    pub hum_db: f64,
    /// Fundamental of the hum, Hz.
    pub hum_hz: f64,
    /// Level of hissing air or rubbing pads, dB re 20 µPa.
    pub hiss_db: f64,
    /// Spray of a wet wheel over the usual, dB.
    pub spray_db: f64,
    /// Level of a squealing wheel over its rolling noise, dB, if it squeals.
    pub squeal_db: Option<f64>,
    /// Mode that squeals, counted from the lowest.
    pub squeal_mode: usize,
    /// Gain of the recording over the usual, dB.
    pub gain_db: f64,
    /// Slope of the microphone's response, dB per octave about 1 kHz.
    pub response_db: f64,
}

impl Default for Surroundings {
    /// A quiet hall, a good microphone.
    fn default() -> Self {
        Self {
            background_db: 40.0,
            background_slope_db: -4.0,
            hum_db: 30.0,
            hum_hz: 50.0,
            hiss_db: 20.0,
            spray_db: 0.0,
            squeal_db: None,
            squeal_mode: 2,
            gain_db: 0.0,
            response_db: 0.0,
        }
    }
}

/// Everything that a piece of sound depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// How the wheel rolls.
    pub rolling: Rolling,
    /// What else is heard.
    pub surroundings: Surroundings,
}

/// Power of a level re 20 µPa, Pa².
pub(crate) fn pressure_squared(level_db: f64) -> f64 {
    (20e-6_f64).powi(2) * from_db(level_db)
}

/// Ratio of powers.
pub(crate) fn from_db(decibels: f64) -> f64 {
    10_f64.powf(decibels / 10.0)
}
