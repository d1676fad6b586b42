//! The unscented and the extended filter on the rig's model, behind one type.

use super::model::{PRIOR_LN_SIGMA, STATES, State, TractionModel, TractionNoise, adhesion_peak, index};
use super::sample::{OUTPUTS, TractionEstimate, TractionSample, TractionState};
use crate::core::{Gaussian, ScalarUpdate};
use crate::unscented::{Spread, SquareRootBelief};
use nalgebra::{SMatrix, SVector};

/// State that each measured value is, in the order of (5-4).
const MEASURED: [usize; OUTPUTS] =
    [0, 1, index::MOTOR_SPEED, 5, 6, index::ROLLER_SPEED, index::GENERATOR_CURRENT];

/// Innovation beyond which a value is refused, in sigma, and how many in a row before it is believed after all.
const GATE: (f64, u32) = (10.0, 3);

/// Time after the first sample in which nothing is refused and nothing claimed, s: some rotor time constants.
const SETTLE_S: f64 = 0.5;

/// ln μ0 of what a surface can have: 0.005 to 1.
const POSSIBLE_LN_PEAK: (f64, f64) = (-5.3, 0.0);

/// Relative sigma of μ0 above which a value is called unobservable: little is left of the difference to the prior.
const UNOBSERVABLE_SIGMA: f64 = 0.45;

/// Bend of the creep curve at the present load below which a value is called unobservable: the creep stiffness of a
/// surface is not known better than that.
const UNOBSERVABLE_BEND: f64 = 0.02;

/// Creep force over load below which there is no traction load to speak of.
const NO_LOAD: f64 = 0.004;

/// Time over which creepage is smoothed to judge the present load, s.
const STEADY_S: f64 = 0.5;

/// Relative sigma of μ0 up to which a value is called observable.
const OBSERVABLE_SIGMA: f64 = 0.15;

/// A belief about the 13 states that can be moved and measured.
pub trait TractionBelief: Clone + Send {
    /// Independent components; `spread` is for filters with sigma points.
    fn independent(mean: State, sigma: &State, spread: &Spread) -> Self;
    /// Moves the belief through the model.
    fn predict(&mut self, model: &TractionModel, noise_sigma: &State, dt_s: f64);
    /// What measuring a state would say.
    fn expect(&self, state: usize, measured: f64, r: f64) -> ScalarUpdate;
    /// Uses that measurement.
    fn accept(&mut self, state: usize, update: &ScalarUpdate, r: f64);
    /// Forgets everything about a state.
    fn forget(&mut self, state: usize, mean: f64, sigma: f64);
    /// Pulls μ0 back to what a surface can have: beyond, the law's slope says nothing and the filter would stay.
    fn keep_possible(&mut self);
    /// Best estimate.
    fn mean(&self) -> &State;
    /// One sigma of a state.
    fn sigma(&self, state: usize) -> f64;
    /// True if finite and positive definite.
    fn is_sound(&self) -> bool;
    /// Normalised error squared of a known truth.
    fn nees(&self, truth: &State) -> f64;
    /// Mean and covariance.
    fn gaussian(&self) -> Gaussian<STATES>;
    /// The same belief from mean and covariance; `None` if that is not positive definite.
    fn of_gaussian(&self, gaussian: &Gaussian<STATES>) -> Option<Self>;
    /// Covariance between the state now and after a step of the model, for smoothing.
    fn cross(&self, model: &TractionModel, dt_s: f64) -> SMatrix<f64, STATES, STATES>;
}

/// Belief of the unscented filter.
#[derive(Clone, Copy, Debug)]
pub struct Unscented {
    belief: SquareRootBelief<STATES>,
    spread: Spread,
}

impl TractionBelief for Unscented {
    fn independent(mean: State, sigma: &State, spread: &Spread) -> Self {
        Self { belief: SquareRootBelief::independent(mean, sigma), spread: *spread }
    }
    #[inline]
    fn predict(&mut self, model: &TractionModel, noise_sigma: &State, dt_s: f64) {
        self.belief.predict(&self.spread, noise_sigma, |x| model.step(x, dt_s));
    }
    #[inline]
    fn expect(&self, state: usize, measured: f64, r: f64) -> ScalarUpdate {
        self.belief.expect_component(state, measured, r)
    }
    #[inline]
    fn accept(&mut self, state: usize, update: &ScalarUpdate, r: f64) {
        self.belief.update_component(state, update, r);
    }
    fn forget(&mut self, state: usize, mean: f64, sigma: f64) {
        self.belief.forget_component(state, mean, sigma);
    }
    fn keep_possible(&mut self) {
        let ln_peak = &mut self.belief.mean[index::LN_ADHESION_PEAK];
        *ln_peak = ln_peak.clamp(POSSIBLE_LN_PEAK.0, POSSIBLE_LN_PEAK.1);
    }
    fn mean(&self) -> &State {
        &self.belief.mean
    }
    fn sigma(&self, state: usize) -> f64 {
        self.belief.sigma(state)
    }
    fn is_sound(&self) -> bool {
        self.belief.is_sound()
    }
    fn nees(&self, truth: &State) -> f64 {
        self.belief.nees(truth)
    }
    fn gaussian(&self) -> Gaussian<STATES> {
        self.belief.gaussian()
    }
    fn of_gaussian(&self, gaussian: &Gaussian<STATES>) -> Option<Self> {
        let root = gaussian.covariance.cholesky()?.l();
        Some(Self { belief: SquareRootBelief { mean: gaussian.mean, root }, spread: self.spread })
    }
    fn cross(&self, model: &TractionModel, dt_s: f64) -> SMatrix<f64, STATES, STATES> {
        // Σ W (X_i − x)(Z_i − z)ᵀ: opposite points leave the odd part only.
        let reach = self.spread.reach_squared(STATES).sqrt();
        let mut cross = SMatrix::zeros();
        for i in 0..STATES {
            let column: State = self.belief.root.column(i).into_owned();
            let offset = column * reach;
            let ahead = model.step(&(self.belief.mean + offset), dt_s);
            let behind = model.step(&(self.belief.mean - offset), dt_s);
            cross += column * ((ahead - behind) / (2.0 * reach)).transpose();
        }
        cross
    }
}

/// Belief of the extended filter; its Jacobian is worked out numerically, as the paper's is.
#[derive(Clone, Copy, Debug)]
pub struct Extended {
    belief: Gaussian<STATES>,
}

impl TractionBelief for Extended {
    fn independent(mean: State, sigma: &State, _spread: &Spread) -> Self {
        Self { belief: Gaussian::independent(mean, sigma) }
    }
    fn predict(&mut self, model: &TractionModel, noise_sigma: &State, dt_s: f64) {
        let f = jacobian(model, &self.belief.mean, dt_s);
        let q = SMatrix::from_diagonal(&noise_sigma.component_mul(noise_sigma));
        self.belief.predict(model.step(&self.belief.mean, dt_s), &f, &q);
    }
    fn expect(&self, state: usize, measured: f64, r: f64) -> ScalarUpdate {
        self.belief.expect_component(state, measured, r)
    }
    fn accept(&mut self, state: usize, update: &ScalarUpdate, r: f64) {
        self.belief.update_component(state, update, r);
    }
    fn forget(&mut self, state: usize, mean: f64, sigma: f64) {
        self.belief.mean[state] = mean;
        self.belief.covariance.row_mut(state).fill(0.0);
        self.belief.covariance.column_mut(state).fill(0.0);
        self.belief.covariance[(state, state)] = sigma * sigma;
    }
    fn keep_possible(&mut self) {
        let ln_peak = &mut self.belief.mean[index::LN_ADHESION_PEAK];
        *ln_peak = ln_peak.clamp(POSSIBLE_LN_PEAK.0, POSSIBLE_LN_PEAK.1);
    }
    fn mean(&self) -> &State {
        &self.belief.mean
    }
    fn sigma(&self, state: usize) -> f64 {
        self.belief.sigma(state)
    }
    fn is_sound(&self) -> bool {
        self.belief.is_sound()
    }
    fn nees(&self, truth: &State) -> f64 {
        let error = truth - self.belief.mean;
        self.belief.covariance.cholesky().map_or(f64::INFINITY, |factor| error.dot(&factor.solve(&error)))
    }
    fn gaussian(&self) -> Gaussian<STATES> {
        self.belief
    }
    fn of_gaussian(&self, gaussian: &Gaussian<STATES>) -> Option<Self> {
        gaussian.is_sound().then_some(Self { belief: *gaussian })
    }
    fn cross(&self, model: &TractionModel, dt_s: f64) -> SMatrix<f64, STATES, STATES> {
        self.belief.covariance * jacobian(model, &self.belief.mean, dt_s).transpose()
    }
}

/// Derivative of a step by central differences, as the paper works it out.
fn jacobian(model: &TractionModel, x: &State, dt_s: f64) -> SMatrix<f64, STATES, STATES> {
    // A thousandth of a typical size of each state: far above rounding, far below curvature.
    const REACH: [f64; STATES] =
        [1e-3, 1e-3, 1e-4, 1e-4, 1e-4, 1e-2, 1e-2, 1e-6, 1e-1, 1e-5, 1e-5, 1e-5, 1e-3];
    let mut f = SMatrix::<f64, STATES, STATES>::zeros();
    for column in 0..STATES {
        let (mut ahead, mut behind) = (*x, *x);
        ahead[column] += REACH[column];
        behind[column] -= REACH[column];
        let slope: State = (model.step(&ahead, dt_s) - model.step(&behind, dt_s)) / (2.0 * REACH[column]);
        f.set_column(column, &slope);
    }
    f
}

/// A filter of the rig: a pure step from sample to estimate.
#[derive(Clone, Debug)]
pub struct TractionFilter<B> {
    /// Equations.
    pub model: TractionModel,
    /// Noise of model and sensors.
    pub noise: TractionNoise,
    /// Belief, once begun.
    pub belief: Option<B>,
    /// Sigma points of the unscented filter.
    pub spread: Spread,
    last: TractionSample,
    began_s: f64,
    refused_in_row: [u32; OUTPUTS],
    /// Samples in a row of which most values were refused.
    broken_in_row: u32,
    /// Smoothed creepage: that of the load, without sensor noise.
    steady_creepage: f64,
    /// Smoothed creep force over load.
    steady_utilised: f64,
    /// Smoothed sine between one current vector and the next, times the direction of the motor; the same of the
    /// voltage.
    turning: [f64; 2],
}

/// The paper's filter.
pub type TractionUkf = TractionFilter<Unscented>;

/// The filter that the paper compares with.
pub type TractionEkf = TractionFilter<Extended>;

impl<B: TractionBelief> TractionFilter<B> {
    /// A filter that begins with its first complete sample.
    pub fn new(model: TractionModel, noise: TractionNoise) -> Self {
        let last = TractionSample {
            time_s: f64::NAN,
            current_a: [f64::NAN; 2],
            motor_speed_rad_s: f64::NAN,
            voltage_v: [f64::NAN; 2],
            roller_speed_rad_s: f64::NAN,
            generator_current_a: f64::NAN,
        };
        Self {
            model,
            noise,
            belief: None,
            spread: Spread::default(),
            last,
            began_s: f64::NAN,
            refused_in_row: [0; OUTPUTS],
            broken_in_row: 0,
            steady_creepage: 0.0,
            steady_utilised: 0.0,
            turning: [0.0; 2],
        }
    }

    /// Uses a sample; the estimate after it.
    pub fn step(&mut self, sample: &TractionSample) -> TractionEstimate {
        let dt_s = sample.time_s - self.last.time_s;
        let mut estimate = TractionEstimate { time_s: sample.time_s, ..TractionEstimate::default() };
        match &mut self.belief {
            Some(belief) if dt_s > 0.0 => {
                let sigma = self.noise.over(dt_s);
                belief.predict(&self.model, &sigma, dt_s);
                if sample.time_s - self.began_s < SETTLE_S {
                    // The first samples know the slip so badly that a linear filter would draw firm and false
                    // conclusions about μ0 from them.
                    belief.forget(
                        index::LN_ADHESION_PEAK,
                        self.model.prior_adhesion_peak.ln(),
                        PRIOR_LN_SIGMA,
                    );
                }
                self.measure(sample, &mut estimate);
                self.smooth_creepage(dt_s);
                self.restart_if_broken(sample, &estimate);
            }
            Some(_) => {}
            None => self.start(sample),
        }
        self.watch_phases(sample);
        self.last = *sample;
        self.read(sample.time_s, &mut estimate);
        estimate
    }

    /// Everything beside the belief that the next step depends on, for a snapshot.
    pub(crate) fn memory(&self) -> Vec<f64> {
        let mut memory = vec![self.began_s, self.steady_creepage, self.steady_utilised];
        memory.extend(self.turning);
        memory.push(f64::from(self.broken_in_row));
        memory.extend(self.refused_in_row.map(f64::from));
        memory.push(self.last.time_s);
        memory.extend(self.last.outputs());
        memory
    }

    /// Takes up a memory; `false`, and nothing changes, if it has another shape.
    pub(crate) fn remember(&mut self, memory: &[f64]) -> bool {
        if memory.len() != 7 + 2 * OUTPUTS {
            return false;
        }
        let (head, outputs) = (memory, &memory[7 + OUTPUTS..]);
        (self.began_s, self.steady_creepage, self.steady_utilised) = (head[0], head[1], head[2]);
        self.turning = [head[3], head[4]];
        self.broken_in_row = head[5] as u32;
        self.refused_in_row = std::array::from_fn(|slot| head[6 + slot] as u32);
        self.last = TractionSample {
            time_s: head[6 + OUTPUTS],
            current_a: [outputs[0], outputs[1]],
            motor_speed_rad_s: outputs[2],
            voltage_v: [outputs[3], outputs[4]],
            roller_speed_rad_s: outputs[5],
            generator_current_a: outputs[6],
        };
        true
    }

    /// True if this sample begins the belief anew or forgets part of it.
    pub(crate) fn is_settling(&self, time_s: f64) -> bool {
        self.belief.is_none() || time_s - self.began_s < SETTLE_S
    }

    /// The time of the sample before.
    pub(crate) fn last_time_s(&self) -> f64 {
        self.last.time_s
    }

    fn start(&mut self, sample: &TractionSample) {
        let outputs = sample.outputs();
        if !outputs.iter().all(|value| value.is_finite()) {
            return;
        }
        let mut x = State::zeros();
        for (value, state) in outputs.into_iter().zip(MEASURED) {
            x[state] = value;
        }
        let flux = self.model.flux_guess_wb(sample.current_a, sample.voltage_v, sample.motor_speed_rad_s);
        x[index::FLUX] = flux[0];
        x[index::FLUX + 1] = flux[1];
        x[index::LN_ADHESION_PEAK] = self.model.prior_adhesion_peak.ln();
        let current = x[index::GENERATOR_CURRENT];
        self.model.follow(&mut x);
        x[index::GENERATOR_CURRENT] = current;
        let mut sigma = State::from([0.0, 0.0, 0.2, 0.2, 0.0, 0.0, 0.0, 0.02, 100.0, 0.0, 0.1, 0.0, 0.0]);
        for (slot, state) in MEASURED.into_iter().enumerate() {
            sigma[state] = self.noise.sensors[slot];
        }
        sigma[index::LN_ADHESION_PEAK] = PRIOR_LN_SIGMA;
        self.began_s = sample.time_s;
        self.belief = Some(B::independent(x, &sigma, &self.spread));
    }

    #[inline]
    fn measure(&mut self, sample: &TractionSample, estimate: &mut TractionEstimate) {
        let Some(belief) = &mut self.belief else { return };
        let settled = sample.time_s - self.began_s > SETTLE_S;
        let variances: SVector<f64, OUTPUTS> = self.noise.sensors.component_mul(&self.noise.sensors);
        for (slot, value) in sample.outputs().into_iter().enumerate() {
            if !value.is_finite() {
                continue;
            }
            let update = belief.expect(MEASURED[slot], value, variances[slot]);
            estimate.nis += update.nis();
            estimate.nis_dof += 1;
            estimate.innovations.innovation[slot] = update.innovation;
            estimate.innovations.innovation_variance[slot] = update.innovation_variance;
            estimate.innovations.test_ratio[slot] = update.nis() / (GATE.0 * GATE.0);
            if settled && update.nis() > GATE.0 * GATE.0 && self.refused_in_row[slot] < GATE.1 {
                self.refused_in_row[slot] += 1;
                estimate.rejected |= 1 << slot;
                estimate.innovations.rejected |= 1 << slot;
                continue;
            }
            self.refused_in_row[slot] = 0;
            estimate.innovations.fused |= 1 << slot;
            belief.accept(MEASURED[slot], &update, variances[slot]);
        }
        belief.keep_possible();
    }

    fn watch_phases(&mut self, sample: &TractionSample) {
        let vectors = [(self.last.current_a, sample.current_a), (self.last.voltage_v, sample.voltage_v)];
        for (turning, ([a, b], [c, d])) in self.turning.iter_mut().zip(vectors) {
            let sine = (a * d - b * c) / ((a * a + b * b).sqrt() * (c * c + d * d).sqrt());
            if sine.is_finite() && sample.motor_speed_rad_s.abs() > 2.0 {
                *turning += 0.01 * (sine * sample.motor_speed_rad_s.signum() - *turning);
            }
        }
    }

    /// Most values at odds with the belief for several samples: the record jumped, and the belief is worthless.
    fn restart_if_broken(&mut self, sample: &TractionSample, estimate: &TractionEstimate) {
        let broken = estimate.rejected.count_ones() as usize > OUTPUTS / 2;
        self.broken_in_row = if broken { self.broken_in_row + 1 } else { 0 };
        if self.broken_in_row >= GATE.1 {
            self.broken_in_row = 0;
            self.start(sample);
        }
    }

    fn smooth_creepage(&mut self, dt_s: f64) {
        let Some(belief) = &self.belief else { return };
        let share = (dt_s / STEADY_S).min(1.0);
        self.steady_creepage += share * (belief.mean()[index::CREEPAGE] - self.steady_creepage);
        let load = self.model.rig.parameters.drivetrain.normal_load_n;
        self.steady_utilised += share * (belief.mean()[index::CREEP_FORCE] / load - self.steady_utilised);
    }

    fn read(&self, sample_time_s: f64, estimate: &mut TractionEstimate) {
        let Some(belief) = &self.belief else { return };
        self.read_belief(belief, sample_time_s, estimate);
    }

    /// Writes a belief into an estimate.
    pub(crate) fn read_belief(&self, belief: &B, sample_time_s: f64, estimate: &mut TractionEstimate) {
        let x = belief.mean();
        estimate.creepage = x[index::CREEPAGE];
        estimate.creepage_sigma = belief.sigma(index::CREEPAGE);
        estimate.creep_force_n = x[index::CREEP_FORCE];
        estimate.creep_force_sigma_n = belief.sigma(index::CREEP_FORCE);
        estimate.friction = x[index::FRICTION];
        let relative = belief.sigma(index::LN_ADHESION_PEAK);
        estimate.adhesion_peak = adhesion_peak(x);
        estimate.adhesion_peak_sigma = relative * estimate.adhesion_peak;
        estimate.state = self.judge(sample_time_s, estimate.adhesion_peak, relative);
    }

    /// What the value of μ0 is worth.
    fn judge(&self, time_s: f64, adhesion_peak: f64, relative_sigma: f64) -> TractionState {
        if self.turning.iter().any(|turning| *turning < -0.01) {
            TractionState::PhasesSwapped
        } else if time_s - self.began_s < SETTLE_S {
            TractionState::Starting
        } else if self.steady_utilised.abs() < NO_LOAD {
            TractionState::NoLoad
        } else if relative_sigma > UNOBSERVABLE_SIGMA
            || self.model.bend(self.steady_creepage, adhesion_peak) < UNOBSERVABLE_BEND
        {
            TractionState::Unobservable
        } else if relative_sigma > OBSERVABLE_SIGMA {
            TractionState::Weak
        } else {
            TractionState::Observable
        }
    }
}
