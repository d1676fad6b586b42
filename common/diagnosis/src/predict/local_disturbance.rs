//! A filter with one place of the equations or one sensor freed by a local disturbance d, d' = −d/τ + noise, as one more
//! state (Jazwinski, Stochastic Processes and Filtering Theory, section 8.4).

use crate::data::case::{Case, Run, Sample};
use crate::model::discrepancy::{Place, Scope};
use crate::model::parameters::Built;
use crate::predict::disturbances::{
    Decay, DisturbanceModel, Noise, coloured, derivatives, observed, of_measured, push, robust_cost, states,
};
use crate::predict::passes::{Pass, counted};
use nalgebra::{SMatrix, SVector};
use railgrip_filter::core::Gaussian;
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion};

/// Samples over which derivatives are held: they change slowly beside the sampling.
const DERIVATIVES_HELD: usize = 3;
/// Cost of a filter that diverged.
const DIVERGED: f64 = 1e12;

/// A freed place with its disturbance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalDisturbance {
    /// Where.
    pub(crate) place: Place,
    /// On which wheelsets.
    pub(crate) scope: Scope,
    /// One sigma, in the unit of the place; zero frees nothing.
    pub(crate) amplitude: f64,
    /// Correlation time τ, s.
    pub(crate) time_s: f64,
}

impl LocalDisturbance {
    /// The disturbance that frees nothing.
    pub(crate) fn nothing() -> Self {
        Self { place: Place::BodyForce, scope: Scope::All, amplitude: 0.0, time_s: 1.0 }
    }

    fn on(&self, wheelset: usize) -> f64 {
        if self.scope.has(wheelset) { 1.0 } else { 0.0 }
    }
}

/// Minus the log-likelihood, up to a constant, of each stretch of `stretch_s` of the runs to fit on.
pub(crate) fn costs(
    case: &Case,
    built: &Built,
    disturbances: &DisturbanceModel,
    freed: &LocalDisturbance,
    stretch_s: f64,
) -> Vec<f64> {
    let colour = case.noise.iter().any(|noise| noise.coloured > 0.0);
    // The states of the wagon's filter and one more, the last.
    const TWO: [usize; 2] = [states(2) + 1, coloured(2) + 1];
    const FOUR: [usize; 2] = [states(4) + 1, coloured(4) + 1];
    let of_run = |run: &Run| match (run.room(), colour) {
        (3, false) => Filter::<2, 3, { TWO[0] }>::new(case, built, run, disturbances, freed).costs(stretch_s),
        (3, true) => Filter::<2, 3, { TWO[1] }>::new(case, built, run, disturbances, freed).costs(stretch_s),
        (_, false) => {
            Filter::<4, 5, { FOUR[0] }>::new(case, built, run, disturbances, freed).costs(stretch_s)
        }
        (_, true) => Filter::<4, 5, { FOUR[1] }>::new(case, built, run, disturbances, freed).costs(stretch_s),
    };
    let of = |run: &Run| counted(Pass::Freed, run.len(), || of_run(run));
    case.fit.iter().flat_map(of).collect()
}

/// The filter of a wagon with room for `W` wheelsets, `S` being `1 + W`, and `N` states with that of the freed place.
struct Filter<'a, const W: usize, const S: usize, const N: usize> {
    run: &'a Run,
    wagon: FastWagon<'a>,
    freed: &'a LocalDisturbance,
    mass_kg: f64,
    inertia_kg_m2: f64,
    decay: Decay,
    /// Decay of the disturbance.
    own_decay: f64,
    process: SMatrix<f64, N, N>,
    sensor: SMatrix<f64, S, S>,
    /// Belief about the error of what follows, see [`crate::predict::disturbances`].
    error: Gaussian<N>,
    derivatives: SMatrix<f64, N, N>,
    motion: Motion,
    disturbance: Disturbance,
    local: f64,
    /// The coloured part of each sensor's noise.
    colour: [f64; S],
    hidden: Vec<f64>,
}

impl<'a, const W: usize, const S: usize, const N: usize> Filter<'a, W, S, N> {
    /// Whether coloured noise is among the states.
    const COLOUR: bool = N > coloured(W);

    fn new(
        case: &Case,
        built: &'a Built,
        run: &'a Run,
        disturbances: &DisturbanceModel,
        freed: &'a LocalDisturbance,
    ) -> Self {
        let vehicle = &case.vehicle;
        let own = (-run.dt_s / freed.time_s).exp();
        let decay = disturbances.decay(run.dt_s, case);
        let noise = Noise::<S, N>::new(case, disturbances, run.dt_s, &decay);
        let variance = freed.amplitude.powi(2);
        let widened = |mut matrix: SMatrix<f64, N, N>, last: f64| {
            matrix[(N - 1, N - 1)] = last;
            matrix
        };
        let wagon = FastWagon::new(&built.model, built.adhesion(run.rail), run.dt_s);
        let first = &run.samples[0];
        let hidden = wagon.start_hidden(&first.outputs, &first.input);
        Self {
            run,
            freed,
            mass_kg: vehicle.body.mass_kg,
            inertia_kg_m2: vehicle.wheelset.inertia_kg_m2,
            decay,
            own_decay: own,
            process: widened(noise.process, variance * (1.0 - own * own)),
            sensor: noise.sensor,
            error: Gaussian { mean: SVector::zeros(), covariance: widened(noise.start, variance) },
            derivatives: SMatrix::identity(),
            motion: wagon.start_motion(&first.measured_motion(), &first.input, &hidden),
            wagon,
            disturbance: Disturbance::default(),
            local: 0.0,
            colour: [0.0; S],
            hidden,
        }
    }

    /// Cost of each stretch of the run.
    fn costs(mut self, stretch_s: f64) -> Vec<f64> {
        let stretch = (stretch_s / self.run.dt_s).round().max(1.0) as usize;
        let mut costs = vec![0.0; self.run.len().div_ceil(stretch)];
        for k in 0..self.run.len() {
            let sample = &self.run.samples[k];
            let cost = self.update(sample);
            costs[k / stretch] += if cost.is_finite() { cost } else { DIVERGED };
            if !cost.is_finite() {
                break;
            }
            if k + 1 < self.run.len() {
                if k % DERIVATIVES_HELD == 0 {
                    self.derivatives = self.derivatives(sample);
                }
                self.predict(sample);
            }
        }
        costs
    }

    /// What the sensors should read at a sample, and its derivatives.
    fn expected(&self, sample: &Sample) -> ([f64; S], SMatrix<f64, S, N>) {
        let reading = self.wagon.read(&self.motion, &sample.input, &self.hidden);
        let mut observe = observed::<S, N>();
        observe.column_mut(N - 1).fill(0.0);
        let mut expected: [f64; S] = std::array::from_fn(|j| reading[j] + self.colour[j]);
        match self.freed.place {
            Place::SpeedSensor => {
                observe[(0, N - 1)] = 1.0;
                expected[0] += self.local;
            }
            Place::WheelSensor => {
                for i in 0..W {
                    observe[(1 + i, N - 1)] = self.freed.on(i);
                    expected[1 + i] += self.freed.on(i) * self.local;
                }
            }
            Place::WheelScale => {
                for i in 0..W {
                    observe[(1 + i, N - 1)] = self.freed.on(i) * reading[1 + i];
                    expected[1 + i] += self.freed.on(i) * self.local * reading[1 + i];
                }
            }
            _ => {}
        }
        (expected, observe)
    }

    /// Uses a sample; returns its share of the cost, infinite for a filter that diverged.
    fn update(&mut self, sample: &Sample) -> f64 {
        let (expected, observe) = self.expected(sample);
        let innovation = sample.innovation(&expected);
        let (observe, sensor) = of_measured(&sample.measured, &observe, &self.sensor);
        let Some(gain) = self.error.condition(&observe, &sensor) else { return f64::INFINITY };
        let change = gain.correction(&innovation);
        for j in 0..S {
            self.motion.state[j] += change[j];
        }
        for i in 0..W {
            self.disturbance.pad[i] += change[S + i];
        }
        self.decay.pushes.add(&mut self.disturbance, change[push(W)]);
        self.local += change[N - 1];
        if Self::COLOUR {
            (0..S).for_each(|j| self.colour[j] += change[states(W) + j]);
        }
        let white = gain.whitened(&innovation);
        white.into_iter().map(robust_cost).sum::<f64>() + gain.half_log_determinant
    }

    fn predict(&mut self, sample: &Sample) {
        self.error.predict_covariance(&self.derivatives, S, &self.process);
        let mut hidden = std::mem::take(&mut self.hidden);
        self.motion = self.step(self.motion, sample, self.disturbance, self.local, &mut hidden);
        self.hidden = hidden;
        for i in 0..W {
            self.disturbance.pad[i] *= self.decay.pad;
        }
        self.decay.pushes.fade(&mut self.disturbance, self.decay.push);
        self.local *= self.own_decay;
        for (colour, decay) in self.colour.iter_mut().zip(&self.decay.colour) {
            *colour *= decay;
        }
    }

    /// One sample on, with the disturbance at its place.
    fn step(
        &self,
        mut motion: Motion,
        sample: &Sample,
        mut disturbance: Disturbance,
        local: f64,
        hidden: &mut [f64],
    ) -> Motion {
        let (mut adhesion_factor, freed) = (1.0, self.freed);
        let mut input = sample.input;
        match freed.place {
            Place::PadFriction => (0..W).for_each(|i| disturbance.pad[i] += freed.on(i) * local),
            Place::Adhesion => adhesion_factor = (1.0 + local).max(0.05),
            Place::DriveTorque => {
                input.mid_drive_torque_nm.iter_mut().for_each(|torque| *torque *= 1.0 + local);
            }
            _ => {}
        }
        self.wagon.on_adhesion(adhesion_factor).step(&mut motion, &input, &disturbance, hidden);
        match freed.place {
            Place::BodyForce => motion.state[0] += local * self.run.dt_s / self.mass_kg,
            Place::WheelTorque => {
                for i in 0..W {
                    motion.state[1 + i] += freed.on(i) * local * self.run.dt_s / self.inertia_kg_m2;
                }
            }
            _ => {}
        }
        motion
    }

    /// Derivatives of the next state.
    fn derivatives(&self, sample: &Sample) -> SMatrix<f64, N, N> {
        let (freed, local) = (self.freed, self.local);
        let mut disturbance = self.disturbance;
        let mut adhesion_factor = 1.0;
        match freed.place {
            Place::PadFriction => (0..W).for_each(|i| disturbance.pad[i] += freed.on(i) * local),
            Place::Adhesion => adhesion_factor = (1.0 + local).max(0.05),
            _ => {}
        }
        let wagon = self.wagon.on_adhesion(adhesion_factor);
        let loading = wagon.loading_at(&self.motion, &sample.input, &disturbance, &self.hidden);
        let mut wide = derivatives::<W, S, N>(&wagon, &self.motion, &disturbance, &loading, &self.decay);
        wide[(N - 1, N - 1)] = self.own_decay;
        let slopes = wagon.slopes::<W, S>(&self.motion, &loading);
        for row in 0..S {
            let sum = |of: &dyn Fn(usize) -> f64| (0..W).map(of).sum::<f64>();
            wide[(row, N - 1)] = match freed.place {
                Place::PadFriction => sum(&|i| freed.on(i) * wide[(row, S + i)]),
                Place::Adhesion => {
                    sum(&|i| slopes.by_adhesion[row][i] * loading.adhesion_peak[i] / adhesion_factor)
                }
                Place::DriveTorque => {
                    sum(&|i| slopes.by_torque[row][i] * sample.input.mid_drive_torque_nm[i])
                }
                Place::BodyForce if row == 0 => self.run.dt_s / self.mass_kg,
                Place::WheelTorque if row > 0 => freed.on(row - 1) * self.run.dt_s / self.inertia_kg_m2,
                _ => 0.0,
            };
        }
        wide
    }
}
