//! The gap that a right model would leave on these very recordings: noise of the sensors, what it makes of the state from which a
//! window starts, pads that drift, gusts.
//!
//! A gap of 3 may be a light wagon that gusts push about, or a sensor that is wrong. What tolerances and noise make follows from the
//! recordings' own inputs: the model drives each window with drifting pads and gusts drawn at random, its outputs get the noise that was
//! heard, and the same model predicts them from such a noisy start as any window has (a parametric bootstrap).

use crate::data::case::{Case, OUTPUTS, Run};
use crate::data::noise::SensorNoise;
use crate::model::parameters::Built;
use crate::predict::disturbances::DisturbanceModel;
use crate::predict::open_loop::{self, Tally, sigmas};
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use std::ops::Range;

/// Replicates of each window.
pub(crate) const REPLICATES: u64 = 4;

/// The tallies of replicates of every window of some runs, if `built` is right about them.
pub(crate) fn tallies(
    case: &Case,
    runs: &[Run],
    built: &Built,
    disturbances: &DisturbanceModel,
    seed: u64,
) -> Vec<Tally> {
    let of_run = |(index, run): (usize, &Run)| {
        let wagon = FastWagon::new(&built.model, built.adhesion(run.rail), run.dt_s);
        let (sigma, decay) = (sigmas(&case.vehicle.sensors), disturbances.decay(run.dt_s, case));
        let mut random =
            Pcg64Mcg::seed_from_u64(seed ^ (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut tallies = Vec::new();
        open_loop::each_window(&wagon, run, |range, past| {
            for _ in 0..REPLICATES {
                let mut drift = Drift::new(disturbances, decay.pad, decay.push, &mut random);
                let mut noise = Coloured::new(&case.noise, run.dt_s, &mut random);
                let started = open_loop::start_motion(&wagon, run, range, past);
                let truth =
                    drive(&wagon, run, range, past, started, |random| drift.next(random), &mut random);
                let readings: Vec<[f64; OUTPUTS]> =
                    (0..truth.len()).map(|_| noise.next(&mut random)).collect();
                let count = open_loop::start_samples(run.dt_s).min(readings.len());
                let mut off = started;
                for j in 0..OUTPUTS {
                    off.state[j] += readings[..count].iter().map(|r| r[j]).sum::<f64>() / count as f64;
                }
                let predicted = drive(&wagon, run, range, past, off, |_| Disturbance::default(), &mut random);
                tallies.push(tally(run, range, &sigma, &truth, &readings, &predicted));
            }
        });
        tallies
    };
    runs.par_iter().enumerate().flat_map_iter(of_run).collect()
}

/// Errors of a prediction against a truth with noise, over the sigmas of the sensors.
fn tally(
    run: &Run,
    range: &Range<usize>,
    sigma: &[f64; OUTPUTS],
    truth: &[[f64; OUTPUTS]],
    noise: &[[f64; OUTPUTS]],
    predicted: &[[f64; OUTPUTS]],
) -> Tally {
    let mut tally = Tally { outputs: run.outputs(), count: range.len(), ..Tally::default() };
    for (k, sample) in run.samples[range.clone()].iter().enumerate() {
        for j in 0..run.outputs() {
            if sample.measured[j] {
                let error = (predicted[k][j] - truth[k][j] - noise[k][j]) / sigma[j];
                tally.squares[j] += open_loop::squared(error);
            } else {
                tally.missing[j] += 1;
            }
        }
    }
    tally
}

/// Outputs of a window without noise, under what disturbs it at each sample.
fn drive(
    wagon: &FastWagon,
    run: &Run,
    range: &Range<usize>,
    past: &[f64],
    mut motion: Motion,
    mut disturbs: impl FnMut(&mut Pcg64Mcg) -> Disturbance,
    random: &mut Pcg64Mcg,
) -> Vec<[f64; OUTPUTS]> {
    let mut hidden = past.to_vec();
    let mut outputs = Vec::with_capacity(range.len());
    for sample in &run.samples[range.clone()] {
        outputs.push(wagon.read(&motion, &sample.input, &hidden));
        let disturbance = disturbs(random);
        wagon.step(&mut motion, &sample.input, &disturbance, &mut hidden);
    }
    outputs
}

fn normal(random: &mut Pcg64Mcg) -> f64 {
    StandardNormal.sample(random)
}

/// Pads that drift, and gusts.
struct Drift {
    now: Disturbance,
    /// What is left of pads and gusts after a sample.
    decay: [f64; 2],
    /// One sigma of the part of the drift that all pads share, of each pad's own, of gusts.
    sigma: [f64; 3],
    shared: f64,
    own: Disturbance,
}

impl Drift {
    fn new(model: &DisturbanceModel, pad: f64, push: f64, random: &mut Pcg64Mcg) -> Self {
        let shared = model.pad_correlation;
        let sigma =
            [model.pad_sigma * shared.sqrt(), model.pad_sigma * (1.0 - shared).sqrt(), model.gust_sigma_m_s];
        let mut drift = Self {
            now: Disturbance::default(),
            decay: [0.0; 2],
            sigma,
            shared: 0.0,
            own: Disturbance::default(),
        };
        // Without memory the first draw is that of a drift which has long been going on.
        drift.next(random);
        drift.decay = [pad, push];
        drift
    }

    fn next(&mut self, random: &mut Pcg64Mcg) -> Disturbance {
        let [pad, push] = self.decay;
        let [new_pad, new_push] = self.decay.map(|decay| (1.0 - decay * decay).sqrt());
        self.shared = pad * self.shared + new_pad * self.sigma[0] * normal(random);
        for (now, own) in self.now.pad.iter_mut().zip(&mut self.own.pad) {
            *own = pad * *own + new_pad * self.sigma[1] * normal(random);
            *now = self.shared + *own;
        }
        self.now.wind_m_s = push * self.now.wind_m_s + new_push * self.sigma[2] * normal(random);
        self.now
    }
}

/// Noise of the sensors as it was heard.
struct Coloured<'c> {
    noise: &'c [SensorNoise; OUTPUTS],
    decay: [f64; OUTPUTS],
    now: [f64; OUTPUTS],
}

impl<'c> Coloured<'c> {
    fn new(noise: &'c [SensorNoise; OUTPUTS], dt_s: f64, random: &mut Pcg64Mcg) -> Self {
        let decay = std::array::from_fn(|j| (-dt_s / noise[j].time_s).exp());
        let now = std::array::from_fn(|j| noise[j].coloured * normal(random));
        Self { noise, decay, now }
    }

    fn next(&mut self, random: &mut Pcg64Mcg) -> [f64; OUTPUTS] {
        std::array::from_fn(|j| {
            let (noise, decay) = (&self.noise[j], self.decay[j]);
            self.now[j] =
                decay * self.now[j] + (1.0 - decay * decay).sqrt() * noise.coloured * normal(random);
            self.now[j] + noise.white * normal(random)
        })
    }
}
