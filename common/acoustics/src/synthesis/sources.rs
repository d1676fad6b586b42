//! What is radiated and heard: power densities at the microphone, and tones.

use super::contact::{Patch, roughness_density};
use super::mobility::Mobilities;
use super::rig::{Rig, Support};
use super::{Rolling, Scene, Surroundings, from_db, pressure_squared};
use crate::{BINS, SAMPLE_RATE_HZ, bin_frequency_hz};
use std::f64::consts::{PI, TAU};

/// ρ c of air, kg/(m² s).
const AIR_IMPEDANCE: f64 = 415.0;
/// Speed of sound, m/s.
const SOUND_M_S: f64 = 343.0;
/// Points at which a bin's density is taken and averaged: wheel modes are hardly wider than bins.
pub(crate) const FINE: usize = 2;
/// The same where only the level counts.
pub(crate) const COARSE: usize = 1;
/// Mean square velocity of a vibrating disc's surface over that at its tread (chosen; a disc's modes give 0.05 to 0.3).
const SURFACE_SHARE: f64 = 0.15;
/// Friction of dry and of wet rollers (Shrestha et al., section 4.1.1: 0.4 and about half).
const FRICTION: (f64, f64) = (0.4, 0.2);
/// Share of the friction force that fluctuates in a creeping contact at a creepage of 1 (chosen), and where its spectrum falls.
const CREEP_FLUCTUATION: f64 = 0.02;
const CREEP_CORNER_HZ: f64 = 2500.0;
/// Level of spray at 1 m from a closed film thrown off at 10 m/s by a wheel of 0.46 m, dB re 20 µPa (chosen); it grows
/// with the cube of speed, as power goes into drops, and with the wheel's size.
const SPRAY_DB: f64 = 74.0;
/// Level of wind over a microphone in the open at 30 m/s, dB re 20 µPa; sixth power of speed (dipoles; value chosen).
const WIND_DB: f64 = 88.0;
/// Noise of the microphone itself, dB re 20 µPa.
const SELF_NOISE_DB: f64 = 22.0;

/// What arrives at the microphone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sound {
    /// Power density of pressure by bin, Pa²/Hz.
    pub density: Vec<f64>,
    /// Tones: frequency in Hz, amplitude in Pa.
    pub tones: Vec<(f64, f64)>,
}

impl Sound {
    /// Everything in a scene, the microphone's response included.
    pub fn of(rig: &Rig, scene: &Scene) -> Self {
        let Scene { rolling, surroundings } = scene;
        let mut density = rolling_density(rig, rolling, FINE);
        let rolling_power = power(&density);
        add(
            &mut density,
            rolling.wetness * spray_power(rig, rolling) * from_db(surroundings.spray_db),
            |f| band(f, 4500.0, 1.3),
        );
        background(&mut density, rig, rolling, surroundings);
        let mut tones = hum(surroundings);
        if let (Some(level_db), Some(mode)) =
            (surroundings.squeal_db, rig.modes.get(surroundings.squeal_mode))
        {
            tones.push((mode.frequency_hz, (2.0 * rolling_power * from_db(level_db)).sqrt()));
        }
        let response = |frequency_hz: f64| {
            let octaves = (frequency_hz.max(20.0) / 1000.0).log2();
            from_db(surroundings.response_db * octaves) * band_edge(frequency_hz)
        };
        for (bin, value) in density.iter_mut().enumerate() {
            *value *= response(bin_frequency_hz(bin));
        }
        for (frequency_hz, amplitude_pa) in &mut tones {
            *amplitude_pa *= response(*frequency_hz).sqrt();
        }
        tones.retain(|(frequency_hz, _)| *frequency_hz < 0.49 * f64::from(SAMPLE_RATE_HZ));
        Self { density, tones }
    }
}

/// Mean square of the pressure, Pa².
pub(crate) fn power(density: &[f64]) -> f64 {
    density.iter().sum::<f64>() * bin_frequency_hz(1)
}

/// Rolling noise and the noise of creeping, Pa²/Hz by bin.
pub(crate) fn rolling_density(rig: &Rig, rolling: &Rolling, points: usize) -> Vec<f64> {
    let mut density = vec![0.0; BINS];
    if rolling.speed_m_s <= 0.0 {
        return density;
    }
    let patch = Patch::hertz(rolling.load_n, rig.curvature_m);
    let width_hz = bin_frequency_hz(1);
    for (bin, value) in density.iter_mut().enumerate().skip(1) {
        for point in 0..points {
            let offset = (point as f64 + 0.5) / points as f64 - 0.5;
            let frequency_hz = bin_frequency_hz(bin) + offset * width_hz;
            *value += radiated(rig, rolling, &patch, frequency_hz) / points as f64;
        }
    }
    density
}

fn radiated(rig: &Rig, rolling: &Rolling, patch: &Patch, frequency_hz: f64) -> f64 {
    let omega = TAU * frequency_hz;
    let mobilities = Mobilities::of(rig, patch, rolling.wetness, frequency_hz);
    // Roughness moves the contact with jω r; the three mobilities share it.
    let force = omega * omega * roughness_density(rolling, patch, frequency_hz) / mobilities.sum.norm_sqr();
    let creep = creep_force_density(rolling, frequency_hz);
    let wheel_m2 = SURFACE_SHARE * 2.0 * PI * rig.wheel_radius_m.powi(2);
    let support_m2 = match rig.support {
        // The rail moves over a metre or two; its own decay is taken as constant.
        Support::Track { .. } => 0.6,
        Support::Roller { .. } => wheel_m2,
    };
    let wheel = force * mobilities.wheel_radiation + creep * mobilities.creep_radiation;
    let support = force * mobilities.support.norm_sqr();
    let power = wheel * wheel_m2 * efficiency(frequency_hz, rig.wheel_radius_m)
        + support * support_m2 * efficiency(frequency_hz, 0.08);
    // W = ρ c σ S <v²>, spread over a half sphere around a source of the wheel's size: p² = W ρ c / (2 π (d² + R²)).
    let distance2 = rig.microphone_m.powi(2) + rig.wheel_radius_m.powi(2);
    AIR_IMPEDANCE * power * AIR_IMPEDANCE / (2.0 * PI * distance2)
}

/// How well a body of that size radiates: poorly while it is small against the wavelength.
fn efficiency(frequency_hz: f64, size_m: f64) -> f64 {
    let ka = TAU * frequency_hz / SOUND_M_S * size_m;
    ka.powi(2) / (1.0 + ka.powi(2))
}

/// Power density of the friction force of a creeping contact, N²/Hz.
fn creep_force_density(rolling: &Rolling, frequency_hz: f64) -> f64 {
    let friction = FRICTION.0 + (FRICTION.1 - FRICTION.0) * rolling.wetness;
    let force = CREEP_FLUCTUATION * friction * rolling.load_n * rolling.creepage.sqrt() * 0.1;
    // A sliding asperity is felt for about the time that it needs through the patch: faster sliding reaches higher.
    let corner_hz = CREEP_CORNER_HZ * (1.0 + rolling.creepage * rolling.speed_m_s).sqrt();
    force.powi(2) / (1.0 + (frequency_hz / corner_hz).powi(2)) / corner_hz
}

fn spray_power(rig: &Rig, rolling: &Rolling) -> f64 {
    let size = (rig.wheel_radius_m / 0.46).powi(2);
    pressure_squared(SPRAY_DB) * (rolling.speed_m_s / 10.0).max(0.0).powi(3) * size / rig.microphone_m.powi(2)
}

fn background(density: &mut [f64], rig: &Rig, rolling: &Rolling, surroundings: &Surroundings) {
    let slope = surroundings.background_slope_db / (10.0 * 2_f64.log10());
    add(density, pressure_squared(surroundings.background_db), |f| (f.max(60.0) / 1000.0).powf(slope));
    add(density, pressure_squared(surroundings.hiss_db), |f| band(f, 5500.0, 1.0));
    if matches!(rig.support, Support::Track { .. }) {
        let wind = pressure_squared(WIND_DB) * (rolling.speed_m_s / 30.0).powi(6);
        add(density, wind, |f| 1.0 / (1.0 + (f / 250.0).powi(2)));
    }
    add(density, pressure_squared(SELF_NOISE_DB), |_| 1.0);
}

/// A hum and its harmonics, each 4 dB below the one before.
fn hum(surroundings: &Surroundings) -> Vec<(f64, f64)> {
    let first = (2.0 * pressure_squared(surroundings.hum_db)).sqrt();
    (0..8)
        .map(|k| (surroundings.hum_hz * f64::from(k + 1), first * from_db(-4.0 * f64::from(k)).sqrt()))
        .collect()
}

/// Adds `total` Pa² with a spectrum of that shape.
fn add(density: &mut [f64], total: f64, shape: impl Fn(f64) -> f64) {
    let values: Vec<f64> = (0..density.len()).map(|bin| shape(bin_frequency_hz(bin))).collect();
    let scale = total / power(&values);
    density.iter_mut().zip(values).for_each(|(sum, value)| *sum += scale * value);
}

/// A broad hump over the logarithm of frequency, `octaves` to each side.
fn band(frequency_hz: f64, centre_hz: f64, octaves: f64) -> f64 {
    (-0.5 * ((frequency_hz.max(1.0) / centre_hz).log2() / octaves).powi(2)).exp()
}

/// A microphone hears nothing far below its range: second order, −3 dB at 40 Hz.
fn band_edge(frequency_hz: f64) -> f64 {
    let x = (frequency_hz / 40.0).powi(4);
    x / (1.0 + x)
}
