//! From power densities to samples.

use super::rig::Rig;
use super::sources::{COARSE, Sound, power, rolling_density};
use super::{Rolling, Scene, from_db, pressure_squared};
use crate::{BINS, FRAME, SAMPLE_RATE_HZ, bin_frequency_hz};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use realfft::{ComplexToReal, RealFftPlanner, num_complex::Complex};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Frames overlap by half; the squares of their windows then add to 1 and the power is even.
const STEP: usize = FRAME / 2;
/// Full scale over the rolling noise of the dry rig at its highest speed: room for peaks.
const HEADROOM_DB: f64 = 24.0;
/// Quantisation of the recording: 16 bit.
const STEPS: f64 = 32_768.0;

/// Lets a rig sound, for as long as one likes and through changing scenes. The same seed gives the same samples.
pub struct Synthesiser {
    rig: Rig,
    random: Pcg64Mcg,
    transform: Arc<dyn ComplexToReal<f64>>,
    window: Vec<f64>,
    full_scale_pa: f64,
    scene: Option<Scene>,
    sound: Sound,
    phases: Vec<f64>,
    tail: Vec<f64>,
    ready: Vec<f32>,
    taken: usize,
}

impl Synthesiser {
    /// A rig, silent so far.
    pub fn new(rig: Rig, seed: u64) -> Self {
        let full_scale_pa =
            (pressure_squared(dry_level_db(&rig, rig.speed_m_s.1)) * from_db(HEADROOM_DB)).sqrt();
        Self {
            rig,
            random: Pcg64Mcg::seed_from_u64(seed),
            transform: RealFftPlanner::new().plan_fft_inverse(FRAME),
            window: (0..FRAME).map(|n| (PI * (n as f64 + 0.5) / FRAME as f64).sin()).collect(),
            full_scale_pa,
            scene: None,
            sound: Sound::default(),
            phases: Vec::new(),
            tail: vec![0.0; STEP],
            ready: Vec::new(),
            taken: 0,
        }
    }

    /// The rig.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Appends `count` samples of the scene, full scale ±1. A scene takes effect with the next frame.
    pub fn render(&mut self, scene: &Scene, count: usize, out: &mut Vec<f32>) {
        if self.scene.as_ref() != Some(scene) {
            self.sound = Sound::of(&self.rig, scene);
            self.scene = Some(*scene);
        }
        let mut missing = count;
        while missing > 0 {
            if self.taken == self.ready.len() {
                self.frame(from_db(scene.surroundings.gain_db).sqrt() / self.full_scale_pa);
            }
            let piece = missing.min(self.ready.len() - self.taken);
            out.extend_from_slice(&self.ready[self.taken..self.taken + piece]);
            self.taken += piece;
            missing -= piece;
        }
    }

    /// Makes the next [`STEP`] samples.
    fn frame(&mut self, gain: f64) {
        let mut spectrum = vec![Complex::new(0.0, 0.0); BINS];
        let width_hz = bin_frequency_hz(1);
        for (slot, density) in spectrum.iter_mut().zip(&self.sound.density).take(BINS - 1).skip(1) {
            // A bin and its mirror share the power of its width; so do real and imaginary part.
            let sigma = (density * width_hz / 4.0).sqrt();
            let mut normal = || -> f64 { StandardNormal.sample(&mut self.random) };
            *slot = Complex::new(sigma * normal(), sigma * normal());
        }
        let mut frame = vec![0.0; FRAME];
        let done = self.transform.process(&mut spectrum, &mut frame);
        debug_assert!(done.is_ok(), "buffers fit the plan");
        frame.iter_mut().zip(&self.window).for_each(|(sample, weight)| *sample *= weight);
        let (front, back) = frame.split_at(STEP);
        let mut pressure: Vec<f64> = self.tail.iter().zip(front).map(|(old, new)| old + new).collect();
        self.tail.copy_from_slice(back);
        self.add_tones(&mut pressure);
        self.ready.clear();
        self.ready.extend(pressure.iter().map(|value| quantised(gain * value)));
        self.taken = 0;
    }

    fn add_tones(&mut self, pressure: &mut [f64]) {
        self.phases.resize(self.sound.tones.len(), 0.0);
        for ((frequency_hz, amplitude), phase) in self.sound.tones.iter().zip(&mut self.phases) {
            let turn = TAU * frequency_hz / f64::from(SAMPLE_RATE_HZ);
            for (n, value) in pressure.iter_mut().enumerate() {
                *value += amplitude * (*phase + turn * n as f64).sin();
            }
            *phase = (*phase + turn * pressure.len() as f64) % TAU;
        }
    }
}

/// Level of the rolling noise alone at the rig's microphone on dry steel under usual circumstances, dB re 20 µPa.
pub fn dry_level_db(rig: &Rig, speed_m_s: f64) -> f64 {
    let rolling = Rolling {
        speed_m_s,
        load_n: rig.load_n,
        creepage: 0.003,
        wetness: 0.0,
        roughness_db: rig.roughness_db,
        roughness_tilt_db: 0.0,
    };
    10.0 * (power(&rolling_density(rig, &rolling, COARSE)) / pressure_squared(0.0)).max(1e-12).log10()
}

fn quantised(value: f64) -> f32 {
    ((value * STEPS).round().clamp(-STEPS, STEPS - 1.0) / STEPS) as f32
}
