//! Interacting multiple models (Blom & Bar-Shalom, IEEE Trans. Automatic Control 33, 1988) over the equations of Schwarz &
//! Keck: four extended filters run side by side, each begins a step from a mixture of all, and each weighs as much as it
//! foretold.
//!
//! One set of noise matrices must choose between following a jump of adhesion and averaging sensor noise, and one brake
//! model between pads that follow the measured pressing force at once and pads that come late, as they do behind a slide
//! protection. Here each choice is a mode, and the data weigh them:
//!
//! | mode | adhesion | pads |
//! | --- | --- | --- |
//! | 0 | steady | prompt |
//! | 1 | moving | prompt |
//! | 2 | steady | late |
//! | 3 | moving | late |
//!
//! Glossary: *mode* – one filter with its noise and its brake; *weight* – its probability; *dwell* – mean time in a mode.

use super::paper::{PaperFilter, PaperInput, PaperModel};
use super::{DrivenSample, FilterState, WagonFilter, WagonPhysics, pack};
use crate::core::{Gaussian, ScalarUpdate};
use crate::{EstimatorConfig, EstimatorOutput, FilterError, ImmSettings};
use nalgebra::{DMatrix, DVector, SVector};
use railgrip_vehicle::{MAX_WHEELSETS, VehicleParameters, WagonModel};

/// Number of modes.
const MODES: usize = 4;
/// Weight that a mode keeps at least, so that it can come back.
const LEAST_WEIGHT: f64 = 1e-6;

/// Four filters (12)–(15) side by side.
#[derive(Clone, Debug)]
pub struct ImmFilter<const W: usize, const N: usize> {
    /// Constants, priors and reading; its belief is the mixture.
    pub(super) base: PaperFilter<W, N>,
    settings: ImmSettings,
    beliefs: [Gaussian<N>; MODES],
    weights: [f64; MODES],
    /// Process noise per second of steady and of moving adhesion.
    pub(super) q_per_s: [SVector<f64, N>; 2],
    late_force_n: [f64; W],
}

/// Builds the filter for the wheelsets of `model`.
pub(super) fn boxed(
    config: &EstimatorConfig,
    vehicle: &VehicleParameters,
    model: &WagonModel,
) -> Result<Box<dyn WagonFilter>, FilterError> {
    match model.constants().wheelsets {
        1 => Ok(Box::new(ImmFilter::<1, 4>::new(config, vehicle, WagonPhysics::new(model)))),
        2 => Ok(Box::new(ImmFilter::<2, 6>::new(config, vehicle, WagonPhysics::new(model)))),
        3 => Ok(Box::new(ImmFilter::<3, 8>::new(config, vehicle, WagonPhysics::new(model)))),
        4 => Ok(Box::new(ImmFilter::<4, 10>::new(config, vehicle, WagonPhysics::new(model)))),
        wheelsets => Err(FilterError::Wheelsets { filter: "imm", wheelsets }),
    }
}

impl<const W: usize, const N: usize> ImmFilter<W, N> {
    /// The filter with these constants; its sensors are always the declared ones.
    pub fn new(config: &EstimatorConfig, vehicle: &VehicleParameters, physics: WagonPhysics<W>) -> Self {
        let physical = EstimatorConfig { noise: crate::NoisePreset::Physical, ..config.clone() };
        let base = PaperFilter::<W, N>::new(&physical, vehicle, physics);
        let settings = config.imm.clone();
        let q = |adhesion: f64| {
            let mut q = base.q_per_s;
            for i in 0..W {
                q[i] = (settings.rim_speed_per_sqrt_s / base.model.physics.wheel_radius_m[i]).powi(2);
            }
            q[PaperModel::<W, N>::ADHESION] = adhesion * adhesion;
            q
        };
        let q_per_s = [q(settings.adhesion_steady_per_sqrt_s), q(settings.adhesion_moving_per_sqrt_s)];
        let beliefs = [base.belief; MODES];
        Self {
            base,
            settings,
            beliefs,
            weights: [1.0 / MODES as f64; MODES],
            q_per_s,
            late_force_n: [0.0; W],
        }
    }

    /// Probability of each mode.
    pub fn weights(&self) -> &[f64; MODES] {
        &self.weights
    }

    /// Probability that adhesion, and that the pads, change their mode within a step.
    pub(super) fn change_shares(&self, dt_s: f64) -> [f64; 2] {
        let change = |dwell_s: f64| 0.5 * (1.0 - (-2.0 * dt_s / dwell_s).exp());
        [change(self.settings.adhesion_dwell_s), change(self.settings.pads_dwell_s)]
    }

    /// Lets every mode begin from the mixture that could have led into it.
    fn mix(&mut self, dt_s: f64) {
        let [adhesion, pads] = self.change_shares(dt_s);
        let step = |from: usize, to: usize| {
            let a = if from & 1 == to & 1 { 1.0 - adhesion } else { adhesion };
            let p = if from & 2 == to & 2 { 1.0 - pads } else { pads };
            a * p
        };
        let before = self.beliefs;
        let weights = self.weights;
        for to in 0..MODES {
            let from: [f64; MODES] = std::array::from_fn(|i| weights[i] * step(i, to));
            self.weights[to] = from.iter().sum();
            self.beliefs[to] = mixture(&before, &from);
        }
    }

    /// Input of one step of a mode.
    pub(super) fn input(&self, sample: &DrivenSample, dt_s: f64, mode: usize) -> PaperInput<W> {
        if mode & 2 == 0 {
            return self.base.step_input(sample, dt_s);
        }
        let mut step_force_n = [0.0; MAX_WHEELSETS];
        step_force_n[..W].copy_from_slice(&self.late_force_n);
        self.base.step_input(&DrivenSample { step_force_n, ..*sample }, dt_s)
    }

    fn gather(&mut self) {
        self.base.belief = mixture(&self.beliefs, &self.weights);
    }

    fn scatter(&mut self) {
        self.beliefs = [self.base.belief; MODES];
        self.weights = [1.0 / MODES as f64; MODES];
    }
}

/// One Gaussian with mean and covariance of a weighted sum of Gaussians; weights need not add up to one.
fn mixture<const N: usize>(beliefs: &[Gaussian<N>; MODES], weights: &[f64; MODES]) -> Gaussian<N> {
    let sum: f64 = weights.iter().sum();
    let mut mean = SVector::<f64, N>::zeros();
    for (belief, weight) in beliefs.iter().zip(weights) {
        mean.axpy(weight / sum, &belief.mean, 1.0);
    }
    let mut mixed = Gaussian { mean, covariance: nalgebra::SMatrix::zeros() };
    for (belief, weight) in beliefs.iter().zip(weights) {
        let apart = belief.mean - mean;
        mixed.covariance += (belief.covariance + apart * apart.transpose()) * (weight / sum);
    }
    mixed.symmetrise();
    mixed
}

impl<const W: usize, const N: usize> WagonFilter for ImmFilter<W, N> {
    fn start(&mut self, sample: &DrivenSample) {
        self.base.start(sample);
        self.late_force_n.copy_from_slice(&sample.pressing_force_n[..W]);
        self.scatter();
    }

    fn restart_motion(&mut self, sample: &DrivenSample, gap_s: f64) {
        self.gather();
        self.base.restart_motion(sample, gap_s);
        self.late_force_n.copy_from_slice(&sample.pressing_force_n[..W]);
        self.scatter();
    }

    fn predict(&mut self, sample: &DrivenSample, dt_s: f64) {
        self.mix(dt_s);
        let share = 1.0 - (-dt_s / self.settings.pads_late_s).exp();
        for i in 0..W {
            self.late_force_n[i] += share * (sample.step_force_n[i] - self.late_force_n[i]);
        }
        for mode in 0..MODES {
            let input = self.input(sample, dt_s, mode);
            let q = self.q_per_s[mode & 1];
            self.base.belief = self.beliefs[mode];
            self.base.predict_with(&input, &q);
            self.base.age_pads(sample, dt_s);
            self.beliefs[mode] = self.base.belief;
        }
        self.gather();
    }

    /// The innovation of the mixture, with its variance.
    fn expect(&self, output: usize, measured: f64) -> ScalarUpdate {
        self.base.expect(output, measured)
    }

    /// Every mode uses the measurement; each weighs as much as it had foretold it.
    fn accept(&mut self, output: usize, update: &ScalarUpdate) {
        let measured = update.innovation + self.base.belief.mean[PaperFilter::<W, N>::index(output)];
        let mut logarithms = [0.0; MODES];
        for mode in 0..MODES {
            self.base.belief = self.beliefs[mode];
            let own = self.base.expect(output, measured);
            logarithms[mode] = self.weights[mode].ln() - 0.5 * (own.nis() + own.innovation_variance.ln());
            self.base.accept(output, &own);
            self.beliefs[mode] = self.base.belief;
        }
        let best = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let shares = logarithms.map(|value| (value - best).exp());
        let sum: f64 = shares.iter().sum();
        self.weights = shares.map(|share| (share / sum).max(LEAST_WEIGHT));
        self.gather();
    }

    fn believe(&mut self, output: usize, measured: f64) {
        for mode in 0..MODES {
            self.base.belief = self.beliefs[mode];
            self.base.believe(output, measured);
            self.beliefs[mode] = self.base.belief;
        }
        self.gather();
    }

    fn conclude(&mut self, _sample: &DrivenSample, _dt_s: f64) {}

    fn read(&self, sample: &DrivenSample, out: &mut EstimatorOutput) {
        self.base.read(sample, out);
    }

    fn save(&self) -> FilterState {
        let mut memory = Vec::new();
        for belief in &self.beliefs {
            memory.extend(belief.mean.iter().chain(belief.covariance.iter()));
        }
        memory.extend(self.weights);
        memory.extend(self.late_force_n);
        pack(&self.base.belief, memory)
    }

    fn load(&mut self, state: &FilterState) -> Result<(), FilterError> {
        let size = N + N * N;
        let mixed = super::unpack::<N>(state, MODES * (size + 1) + W)?;
        let mut beliefs = self.beliefs;
        for (mode, belief) in beliefs.iter_mut().enumerate() {
            let values = &state.memory[mode * size..(mode + 1) * size];
            belief.mean.copy_from_slice(&values[..N]);
            belief.covariance.copy_from_slice(&values[N..]);
            if !belief.is_sound() {
                return Err(FilterError::SnapshotUnsound);
            }
        }
        self.base.belief = mixed;
        self.beliefs = beliefs;
        self.weights.copy_from_slice(&state.memory[MODES * size..MODES * size + MODES]);
        self.late_force_n.copy_from_slice(&state.memory[MODES * (size + 1)..]);
        Ok(())
    }

    fn boxed_clone(&self) -> Box<dyn WagonFilter> {
        Box::new(self.clone())
    }

    fn belief(&self) -> Option<(DVector<f64>, DMatrix<f64>)> {
        None
    }

    fn transition(&self) -> DMatrix<f64> {
        DMatrix::identity(N, N)
    }

    fn has_diverged(&self) -> bool {
        self.base.has_diverged()
    }
}
