//! The 4-state extended filter (19) on the product's model of it, with any Q and R.

use super::rig::{NOMINAL_PAD_FRICTION, RigSample, SAMPLE_PERIOD_S};
use nalgebra::{Matrix4, SVector, Vector4};
use railgrip_filter::core::{Gaussian, SmootherError, SmootherStep, smooth};
use railgrip_filter::models::{PaperInput, RigModel, WagonPhysics};
use railgrip_vehicle::WagonModel;
use railgrip_vehicle::brake::{FirstOrderFriction, pad_torque_nm};

/// Law of the pad friction in the prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PadLaw {
    /// (8): constant.
    Constant,
    /// (9).
    FirstOrder(FirstOrderFriction),
}

/// Q (per second) and R, diagonals in the order `[ω_W, v_x, μ_B, μ_W]` and `[ω_W, v_x]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Q.
    pub q: [f64; 4],
    /// R.
    pub r: [f64; 2],
}

impl Tuning {
    /// (20).
    pub const PAPER: Self = Self { q: [1e1, 1e-5, 1e-3, 1e-1], r: [1e-9, 1e-7] };
}

/// What the filter says after a sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct RigEstimate {
    /// Adhesion utilised, signed.
    pub adhesion: f64,
    /// 1 σ of it.
    pub adhesion_sigma: f64,
    /// Pad friction.
    pub pad_friction: f64,
    /// 1 σ of it.
    pub pad_friction_sigma: f64,
    /// True if the pads press hard enough for (17) to have a solution; else the friction is held.
    pub pad_observable: bool,
    /// Normalised innovation squared, two values.
    pub nis: f64,
}

/// Pressing force below which pads are off, N.
const PADS_OFF_N: f64 = 500.0;

/// The filter, step by step.
#[derive(Clone, Debug)]
pub struct RigEkf {
    model: RigModel,
    tuning: Tuning,
    law: PadLaw,
    /// Belief about `[ω_W, v_x, μ_B, μ_W]`.
    pub belief: Gaussian<4>,
    last_force_n: f64,
    pads_on: bool,
}

impl RigEkf {
    /// A filter that begins at this sample.
    pub fn new(model: &WagonModel, tuning: &Tuning, law: PadLaw, first: &RigSample) -> Self {
        let mean = Vector4::new(first.wheel_speed_rad_s, first.v_m_s, NOMINAL_PAD_FRICTION, 0.0);
        Self {
            model: RigModel { physics: WagonPhysics::new(model), drop_adhesion_load: false },
            tuning: *tuning,
            law,
            belief: Gaussian::independent(mean, &Vector4::new(0.1, 0.1, 0.05, 0.05)),
            last_force_n: first.pressing_force_n,
            pads_on: false,
        }
    }

    /// Prediction to a sample; the derivative of the step.
    pub fn predict(&mut self, sample: &RigSample) -> Matrix4<f64> {
        let force_n = 0.5 * (self.last_force_n + sample.pressing_force_n);
        self.last_force_n = sample.pressing_force_n;
        self.pads_on = force_n > PADS_OFF_N;
        let input = PaperInput {
            dt_s: SAMPLE_PERIOD_S,
            torque_per_friction_nm: [pad_torque_nm(1.0, force_n, self.model.physics.brake_radius_m)],
            drive_torque_nm: [0.0],
            other_force_n: sample.roller_force_n,
            wind_m_s: 0.0,
        };
        let (mut next, mut f) = self.model.propagate(&self.belief.mean, &input);
        let mut q = SVector::from(self.tuning.q) * SAMPLE_PERIOD_S;
        if !self.pads_on {
            // Nothing measured speaks about the pads: their friction is held, flagged, and does not diffuse away.
            q[2] = 0.0;
        } else if let PadLaw::FirstOrder(law) = self.law {
            let pad = self.belief.mean[2];
            next[2] += SAMPLE_PERIOD_S * law.rate(pad);
            f[(2, 2)] += SAMPLE_PERIOD_S * law.rate_slope(pad);
        }
        self.belief.predict(next, &f, &Matrix4::from_diagonal(&q));
        f
    }

    /// Uses the measurements of a sample; their normalised innovation squared and log-likelihood.
    pub fn update(&mut self, sample: &RigSample) -> (f64, f64) {
        let (mut nis, mut log_likelihood) = (0.0, 0.0);
        for (index, measured) in [sample.wheel_speed_rad_s, sample.v_m_s].into_iter().enumerate() {
            let update = self.belief.expect_component(index, measured, self.tuning.r[index]);
            nis += update.nis();
            log_likelihood -=
                0.5 * (update.nis() + (std::f64::consts::TAU * update.innovation_variance).ln());
            self.belief.update_component(index, &update, self.tuning.r[index]);
        }
        (nis, log_likelihood)
    }

    /// What a belief says.
    pub fn read(&self, belief: &Gaussian<4>, nis: f64) -> RigEstimate {
        RigEstimate {
            adhesion: belief.mean[3],
            adhesion_sigma: belief.sigma(3),
            pad_friction: belief.mean[2],
            pad_friction_sigma: belief.sigma(2),
            pad_observable: self.pads_on,
            nis,
        }
    }
}

/// Runs the filter over a test.
pub fn estimate(model: &WagonModel, tuning: &Tuning, law: PadLaw, samples: &[RigSample]) -> Vec<RigEstimate> {
    let Some(first) = samples.first() else { return Vec::new() };
    let mut filter = RigEkf::new(model, tuning, law, first);
    let step = |sample: &RigSample| {
        filter.predict(sample);
        let (nis, _) = filter.update(sample);
        filter.read(&filter.belief, nis)
    };
    samples.iter().map(step).collect()
}

/// Runs the filter forward and smooths it backward: what the whole record says about each instant.
///
/// # Errors
/// If a predicted covariance loses its positive definiteness.
pub fn smoothed(
    model: &WagonModel,
    tuning: &Tuning,
    samples: &[RigSample],
) -> Result<Vec<RigEstimate>, SmootherError> {
    let Some(first) = samples.first() else { return Ok(Vec::new()) };
    let mut filter = RigEkf::new(model, tuning, PadLaw::Constant, first);
    let mut steps = Vec::with_capacity(samples.len());
    for sample in samples {
        let f = filter.predict(sample);
        let predicted = filter.belief;
        filter.update(sample);
        steps.push(SmootherStep { predicted, updated: filter.belief, f });
    }
    Ok(smooth(&steps)?.iter().map(|belief| filter.read(belief, f64::NAN)).collect())
}
