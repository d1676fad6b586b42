//! The 4-state extended filter (19) on the product's model of it, with any Q and R.

use super::rig::{NOMINAL_PAD_FRICTION, RigSample, SAMPLE_PERIOD_S};
use nalgebra::{SVector, Vector4};
use railgrip_filter::core::Gaussian;
use railgrip_filter::models::{PaperInput, RigModel, WagonPhysics};
use railgrip_vehicle::WagonModel;

/// Law of the pad friction in the prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PadLaw {
    /// (8): constant.
    Constant,
    /// (9): `μ̇_B = (μ_B0 − μ_B) / (t_μ μ_B)`.
    FirstOrder {
        /// μ_B0.
        level: f64,
        /// t_μ, s.
        time_s: f64,
    },
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

/// Runs the filter over a test.
pub fn estimate(model: &WagonModel, tuning: &Tuning, law: PadLaw, samples: &[RigSample]) -> Vec<RigEstimate> {
    let model = RigModel { physics: WagonPhysics::new(model), drop_adhesion_load: false };
    let Some(first) = samples.first() else { return Vec::new() };
    let mean = Vector4::new(first.wheel_speed_rad_s, first.v_m_s, NOMINAL_PAD_FRICTION, 0.0);
    let mut belief = Gaussian::independent(mean, &Vector4::new(0.1, 0.1, 0.05, 0.05));
    let q = SVector::from(tuning.q) * SAMPLE_PERIOD_S;
    let mut last_force_n = first.pressing_force_n;
    let mut estimates = Vec::with_capacity(samples.len());
    for sample in samples {
        let force_n = 0.5 * (last_force_n + sample.pressing_force_n);
        last_force_n = sample.pressing_force_n;
        let input = PaperInput {
            dt_s: SAMPLE_PERIOD_S,
            torque_per_friction_nm: [force_n * model.physics.brake_radius_m],
            drive_torque_nm: [0.0],
            other_force_n: sample.roller_force_n,
            wind_m_s: 0.0,
        };
        let (mut next, mut f) = model.propagate(&belief.mean, &input);
        let pads_on = force_n > PADS_OFF_N;
        let mut q_now = q;
        if !pads_on {
            // Nothing measured speaks about the pads: their friction is held, flagged, and does not diffuse away.
            q_now[2] = 0.0;
        } else if let PadLaw::FirstOrder { level, time_s } = law {
            let pad = belief.mean[2];
            next[2] += SAMPLE_PERIOD_S * (level - pad) / (time_s * pad);
            f[(2, 2)] -= SAMPLE_PERIOD_S * level / (time_s * pad * pad);
        }
        belief.predict(next, &f, &nalgebra::SMatrix::from_diagonal(&q_now));
        let mut nis = 0.0;
        for (index, measured) in [sample.wheel_speed_rad_s, sample.v_m_s].into_iter().enumerate() {
            let update = belief.expect_component(index, measured, tuning.r[index]);
            nis += update.nis();
            belief.update_component(index, &update, tuning.r[index]);
        }
        estimates.push(RigEstimate {
            adhesion: belief.mean[3],
            adhesion_sigma: belief.sigma(3),
            pad_friction: belief.mean[2],
            pad_friction_sigma: belief.sigma(2),
            pad_observable: pads_on,
            nis,
        });
    }
    estimates
}
