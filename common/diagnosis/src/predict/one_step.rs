//! Whitened one-step prediction errors: the objective that selects effects.
//!
//! Open-loop errors over ten seconds are strongly coloured by what a diagnosis is not about (pads that drift, gusts of
//! wind), and a wheelset at the edge of sliding may fall either way, so that they make a poor likelihood. Here an
//! extended Kalman filter carries these disturbances as Ornstein–Uhlenbeck states. Its gains are computed once, at
//! the calibrated nominal model, and then frozen: a candidate's cost is that of one simulation with feedback, its
//! innovations are as smooth in the parameters as the laws, and under the nominal model they are white with unit
//! variance (prediction-error method with a fixed predictor; Ljung, System Identification, chapter 7).

use crate::data::case::{Case, Run, Sample};
use crate::model::parameters::Built;
use crate::predict::disturbances::{
    Decay, DisturbanceModel, Noise, Push, coloured, derivatives, observed, of_measured, push, states,
};
use crate::predict::passes::{Pass, counted};
use nalgebra::{SMatrix, SVector};
use railgrip_filter::core::{Gaussian, JointGain};
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion};

/// Frozen filter of one run.
#[derive(Clone, Debug)]
pub struct Predictor {
    pub(super) frozen: Frozen,
    /// Whether the filter corrects so much that its wheelsets are thrown off rolling at every sample.
    pub(crate) tolerant: bool,
    /// Half the log-determinants of all innovation covariances.
    pub half_log_determinant: f64,
}

/// The frozen filter by how many wheelsets it has room for.
#[derive(Clone, Debug)]
pub(super) enum Frozen {
    Two(Gains<2, 3, { coloured(2) }>),
    Four(Gains<4, 5, { coloured(4) }>),
}

/// Gain and whitening of each sample of a wagon with room for `W` wheelsets, `S` being `1 + W` and `C` all its states.
#[derive(Clone, Debug)]
pub(super) struct Gains<const W: usize, const S: usize, const C: usize> {
    pub(super) gains: Vec<JointGain<C, S>>,
    pub(super) decay: Decay,
}

impl Predictor {
    /// Runs the filter over `run` at `built` and keeps its gains.
    pub fn new(built: &Built, run: &Run, case: &Case, disturbances: &DisturbanceModel) -> Self {
        let tolerant = disturbances.tolerance.is_large();
        let wagon = wagon(built, run, tolerant);
        let colour = case.noise.iter().any(|noise| noise.coloured > 0.0);
        let frozen = counted(Pass::Gains, run.len(), || match (run.room(), colour) {
            (3, false) => Frozen::Two(Gains::new::<{ states(2) }>(&wagon, run, case, disturbances)),
            (3, true) => Frozen::Two(Gains::new::<{ coloured(2) }>(&wagon, run, case, disturbances)),
            (_, false) => Frozen::Four(Gains::new::<{ states(4) }>(&wagon, run, case, disturbances)),
            (_, true) => Frozen::Four(Gains::new::<{ coloured(4) }>(&wagon, run, case, disturbances)),
        });
        let half_log_determinant = match &frozen {
            Frozen::Two(two) => two.half_log_determinant(),
            Frozen::Four(four) => four.half_log_determinant(),
        };
        Self { frozen, tolerant, half_log_determinant }
    }

    /// Appends the whitened innovations of `built` on `run`, [`Run::room`] a sample.
    pub fn residuals(&self, built: &Built, run: &Run, out: &mut Vec<f64>) {
        let wagon = wagon(built, run, self.tolerant);
        counted(Pass::Frozen, run.len(), || match &self.frozen {
            Frozen::Two(two) => two.residuals(&wagon, run, out),
            Frozen::Four(four) => four.residuals(&wagon, run, out),
        });
    }
}

impl<const W: usize, const S: usize, const C: usize> Gains<W, S, C> {
    fn new<const N: usize>(
        wagon: &FastWagon,
        run: &Run,
        case: &Case,
        disturbances: &DisturbanceModel,
    ) -> Self {
        let decay = disturbances.decay(run.dt_s, case);
        let noise = Noise::<S, N>::new(case, disturbances, run.dt_s, &decay);
        let observe = observed::<S, N>();
        let mut error = Gaussian { mean: SVector::zeros(), covariance: noise.start };
        let mut filter = Filter::<W, S>::start(run, wagon);
        let mut gains = Vec::with_capacity(run.len());
        for (k, sample) in run.samples.iter().enumerate() {
            let (observe, sensor) = of_measured(&sample.measured, &observe, &noise.sensor);
            let gain = error.condition(&observe, &sensor).map_or_else(JointGain::undefined, embedded);
            gains.push(gain);
            let innovation = filter.innovation(wagon, sample);
            filter.correct(&gain, &innovation, decay.pushes);
            if k + 1 == run.len() {
                break;
            }
            let along = filter.derivatives::<N>(wagon, sample, &decay);
            error.predict_covariance(&along, S, &noise.process);
            filter.predict(wagon, sample, &decay);
        }
        Self { gains, decay }
    }

    fn half_log_determinant(&self) -> f64 {
        self.gains.iter().map(|gain| gain.half_log_determinant).sum()
    }

    fn residuals(&self, wagon: &FastWagon, run: &Run, out: &mut Vec<f64>) {
        let mut filter = Filter::<W, S>::start(run, wagon);
        let last = run.len() - 1;
        for (k, (sample, gain)) in run.samples.iter().zip(&self.gains).enumerate() {
            let innovation = filter.innovation(wagon, sample);
            let white = gain.whitened(&innovation);
            out.extend(white.map(|white| if white.is_finite() { white.clamp(-CLAMP, CLAMP) } else { CLAMP }));
            filter.correct(gain, &innovation, self.decay.pushes);
            if k < last {
                filter.predict(wagon, sample, &self.decay);
            }
        }
    }
}

/// The gain of a filter of fewer states as that of one with all.
fn embedded<const N: usize, const C: usize, const S: usize>(gain: JointGain<N, S>) -> JointGain<C, S> {
    JointGain {
        gain: SMatrix::from_fn(|i, j| if i < N { gain.gain[(i, j)] } else { 0.0 }),
        whitening: gain.whitening,
        half_log_determinant: gain.half_log_determinant,
    }
}

/// The wagon of a filter over `run`, see [`FastWagon::quick`].
pub(super) fn wagon<'a>(built: &'a Built, run: &Run, tolerant: bool) -> FastWagon<'a> {
    let wagon = FastWagon::new(&built.model, built.adhesion(run.rail), run.dt_s);
    if tolerant { wagon.quick() } else { wagon }
}

/// Innovations beyond this many sigma count as this many: a diverged trial must stay finite.
pub(super) const CLAMP: f64 = 1e4;

/// The best estimate: motion, disturbances, hidden states of effects.
pub(super) struct Filter<const W: usize, const S: usize> {
    pub(super) motion: Motion,
    pub(super) disturbance: Disturbance,
    /// The coloured part of each sensor's noise.
    pub(super) colour: [f64; S],
    pub(super) hidden: Vec<f64>,
}

impl<const W: usize, const S: usize> Filter<W, S> {
    pub(super) fn start(run: &Run, wagon: &FastWagon) -> Self {
        let first = &run.samples[0];
        let hidden = wagon.start_hidden(&first.outputs, &first.input);
        let motion = wagon.start_motion(&first.measured_motion(), &first.input, &hidden);
        Self { motion, disturbance: Disturbance::default(), colour: [0.0; S], hidden }
    }

    fn innovation(&self, wagon: &FastWagon, sample: &Sample) -> [f64; S] {
        sample.innovation(&self.reading(wagon, sample))
    }

    /// What the sensors should read, coloured noise included.
    pub(super) fn reading(&self, wagon: &FastWagon, sample: &Sample) -> [f64; S] {
        let reading = wagon.read(&self.motion, &sample.input, &self.hidden);
        std::array::from_fn(|j| reading[j] + self.colour[j])
    }

    pub(super) fn correct<const C: usize>(
        &mut self,
        gain: &JointGain<C, S>,
        innovation: &[f64; S],
        pushes: Push,
    ) {
        let change = gain.correction(innovation);
        for j in 0..S {
            self.motion.state[j] += change[j];
        }
        for i in 0..W {
            self.disturbance.pad[i] += change[S + i];
        }
        pushes.add(&mut self.disturbance, change[push(W)]);
        for j in 0..S {
            self.colour[j] += change[states(W) + j];
        }
    }

    pub(super) fn predict(&mut self, wagon: &FastWagon, sample: &Sample, decay: &Decay) {
        wagon.step(&mut self.motion, &sample.input, &self.disturbance, &mut self.hidden);
        for i in 0..W {
            self.disturbance.pad[i] *= decay.pad;
        }
        decay.pushes.fade(&mut self.disturbance, decay.push);
        for j in 0..S {
            self.colour[j] *= decay.colour[j];
        }
    }

    /// Derivatives of the next state.
    fn derivatives<const N: usize>(
        &self,
        wagon: &FastWagon,
        sample: &Sample,
        decay: &Decay,
    ) -> SMatrix<f64, N, N> {
        let loading = wagon.loading_at(&self.motion, &sample.input, &self.disturbance, &self.hidden);
        derivatives::<W, S, N>(wagon, &self.motion, &self.disturbance, &loading, decay)
    }
}
