//! Whitened one-step prediction errors: the objective that selects effects.
//!
//! Open-loop errors over ten seconds are strongly coloured by what a diagnosis is not about (pads that drift, gusts of
//! wind), and a wheelset at the edge of sliding may fall either way, so that they make a poor likelihood. Here an
//! extended Kalman filter carries these disturbances as Ornstein–Uhlenbeck states. Its gains are computed once, at
//! the calibrated nominal model, and then frozen: a candidate's cost is that of one simulation with feedback, its
//! innovations are as smooth in the parameters as the laws, and under the nominal model they are white with unit
//! variance (prediction-error method with a fixed predictor; Ljung, System Identification, chapter 7).

use crate::data::case::{Case, OUTPUTS, Run, Sample, WHEELSETS};
use crate::model::parameters::Built;
use crate::predict::disturbances::{
    COLOURED, DECAYING, DisturbanceModel, Noise, STATES, WIND, derivatives, leading, observed, of_measured,
    widened,
};
use nalgebra::{SMatrix, SVector};
use railgrip_filter::core::{Gaussian, JointGain};
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion};

/// Gain and whitening of one sample.
pub(super) type Gain = JointGain<COLOURED, OUTPUTS>;

/// Frozen filter of one run.
#[derive(Clone, Debug)]
pub struct Predictor {
    pub(super) gains: Vec<Gain>,
    pub(super) decay: [f64; DECAYING],
    /// Whether the filter corrects so much that its wheelsets are thrown off rolling at every sample.
    pub(crate) tolerant: bool,
    /// Half the log-determinants of all innovation covariances.
    pub half_log_determinant: f64,
}

impl Predictor {
    /// Runs the filter over `run` at `built` and keeps its gains.
    pub fn new(built: &Built, run: &Run, case: &Case, disturbances: &DisturbanceModel) -> Self {
        if case.noise.iter().any(|noise| noise.coloured > 0.0) {
            Self::with_states::<COLOURED>(built, run, case, disturbances)
        } else {
            Self::with_states::<STATES>(built, run, case, disturbances)
        }
    }

    fn with_states<const N: usize>(
        built: &Built,
        run: &Run,
        case: &Case,
        disturbances: &DisturbanceModel,
    ) -> Self {
        let tolerant = disturbances.tolerance.is_large();
        let wagon = wagon(built, run, tolerant);
        let decay = disturbances.decay(run.dt_s, &case.noise);
        let noise = Noise::new(case, disturbances, run.dt_s, &decay);
        let process = leading::<N>(&noise.process);
        let observe = observed::<N>();
        let mut error = Gaussian { mean: SVector::zeros(), covariance: leading::<N>(&noise.start) };
        let mut filter = Filter::start(run, &wagon);
        let mut gains = Vec::with_capacity(run.len());
        for (k, sample) in run.samples.iter().enumerate() {
            let (observe, sensor) = of_measured(&sample.measured, &observe, &noise.sensor);
            let gain = error.condition(&observe, &sensor).map_or_else(Gain::undefined, embedded);
            gains.push(gain);
            let innovation = filter.innovation(&wagon, sample);
            filter.correct(&gain, &innovation);
            if k + 1 == run.len() {
                break;
            }
            let along = widened::<N>(&filter.derivatives(&wagon, sample, &decay), &decay);
            error.predict(SVector::zeros(), &along, &process);
            filter.predict(&wagon, sample, &decay);
        }
        let half_log_determinant = gains.iter().map(|gain| gain.half_log_determinant).sum();
        Self { gains, decay, tolerant, half_log_determinant }
    }

    /// Appends the whitened innovations of `built` on `run`, three a sample.
    pub fn residuals(&self, built: &Built, run: &Run, out: &mut Vec<f64>) {
        let wagon = wagon(built, run, self.tolerant);
        let mut filter = Filter::start(run, &wagon);
        let last = run.len() - 1;
        for (k, (sample, gain)) in run.samples.iter().zip(&self.gains).enumerate() {
            let innovation = filter.innovation(&wagon, sample);
            let white = gain.whitened(&innovation);
            out.extend(white.map(|white| if white.is_finite() { white.clamp(-CLAMP, CLAMP) } else { CLAMP }));
            filter.correct(gain, &innovation);
            if k < last {
                filter.predict(&wagon, sample, &self.decay);
            }
        }
    }
}

/// The gain of a filter of fewer states as that of one with all.
fn embedded<const N: usize>(gain: JointGain<N, OUTPUTS>) -> Gain {
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
pub(super) struct Filter {
    pub(super) motion: Motion,
    pub(super) disturbance: Disturbance,
    /// The coloured part of each sensor's noise.
    pub(super) colour: [f64; OUTPUTS],
    pub(super) hidden: Vec<f64>,
}

impl Filter {
    pub(super) fn start(run: &Run, wagon: &FastWagon) -> Self {
        let first = &run.samples[0];
        let hidden = wagon.start_hidden(&first.outputs, &first.input);
        let motion = wagon.start_motion(&first.measured_motion(), &first.input, &hidden);
        Self { motion, disturbance: Disturbance::default(), colour: [0.0; OUTPUTS], hidden }
    }

    fn innovation(&self, wagon: &FastWagon, sample: &Sample) -> [f64; OUTPUTS] {
        sample.innovation(&self.reading(wagon, sample))
    }

    /// What the sensors should read, coloured noise included.
    pub(super) fn reading(&self, wagon: &FastWagon, sample: &Sample) -> [f64; OUTPUTS] {
        let reading = wagon.read(&self.motion, &sample.input, &self.hidden);
        std::array::from_fn(|j| reading[j] + self.colour[j])
    }

    pub(super) fn correct(&mut self, gain: &Gain, innovation: &[f64; OUTPUTS]) {
        let change = gain.correction(innovation);
        for j in 0..OUTPUTS {
            self.motion.state[j] += change[j];
        }
        for i in 0..WHEELSETS {
            self.disturbance.pad[i] += change[OUTPUTS + i];
        }
        self.disturbance.wind_m_s += change[WIND];
        for j in 0..OUTPUTS {
            self.colour[j] += change[STATES + j];
        }
    }

    pub(super) fn predict(&mut self, wagon: &FastWagon, sample: &Sample, decay: &[f64; DECAYING]) {
        wagon.step(&mut self.motion, &sample.input, &self.disturbance, &mut self.hidden);
        for i in 0..WHEELSETS {
            self.disturbance.pad[i] *= decay[i];
        }
        self.disturbance.wind_m_s *= decay[WHEELSETS];
        for j in 0..OUTPUTS {
            self.colour[j] *= decay[WHEELSETS + 1 + j];
        }
    }

    /// Derivatives of the next state.
    fn derivatives(
        &self,
        wagon: &FastWagon,
        sample: &Sample,
        decay: &[f64; DECAYING],
    ) -> SMatrix<f64, STATES, STATES> {
        let loading = wagon.loading_at(&self.motion, &sample.input, &self.disturbance, &self.hidden);
        derivatives(wagon, &self.motion, &self.disturbance, &loading, decay)
    }
}
