//! Whitened one-step prediction errors: the objective that selects effects.
//!
//! Open-loop errors over ten seconds are strongly coloured by what a diagnosis is not about (pads that drift, gusts of
//! wind), and a wheelset at the edge of sliding may fall either way, so that they make a poor likelihood. Here an
//! extended Kalman filter carries these disturbances as Ornstein–Uhlenbeck states. Its gains are computed once, at
//! the calibrated nominal model, and then frozen: a candidate's cost is that of one simulation with feedback, its
//! innovations are as smooth in the parameters as the laws, and under the nominal model they are white with unit
//! variance (prediction-error method with a fixed predictor; Ljung, System Identification, chapter 7).

use crate::data::case::{OUTPUTS, Run, Sample, WHEELSETS};
use crate::model::parameters::Built;
use crate::predict::disturbances::{
    DIFFERENCES, DisturbanceModel, Noise, STATES, WIND, derivatives, move_disturbance, of_measured,
};
use nalgebra::{SMatrix, SVector};
use railgrip_filter::core::{Gaussian, JointGain};
use railgrip_vehicle::VehicleParameters;
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion};

/// Gain and whitening of one sample.
type Gain = JointGain<STATES, OUTPUTS>;

/// Frozen filter of one run.
#[derive(Clone, Debug)]
pub struct Predictor {
    gains: Vec<Gain>,
    decay: [f64; WHEELSETS + 1],
    /// Half the log-determinants of all innovation covariances.
    pub half_log_determinant: f64,
}

impl Predictor {
    /// Runs the filter over `run` at `built` and keeps its gains.
    pub fn new(
        built: &Built,
        run: &Run,
        vehicle: &VehicleParameters,
        disturbances: &DisturbanceModel,
    ) -> Self {
        let wagon = FastWagon::new(&built.model, built.adhesion(run.rail), run.dt_s);
        let decay = disturbances.decay(run.dt_s);
        let noise = Noise::new(vehicle, disturbances, run.dt_s, &decay);
        let observe = SMatrix::<f64, OUTPUTS, STATES>::identity();
        let mut error = Gaussian { mean: SVector::zeros(), covariance: noise.start };
        let mut filter = Filter::start(run, &wagon);
        let mut gains = Vec::with_capacity(run.len());
        for (k, sample) in run.samples.iter().enumerate() {
            let (observe, sensor) = of_measured(&sample.measured, &observe, &noise.sensor);
            let gain = error.condition(&observe, &sensor).unwrap_or_else(Gain::undefined);
            gains.push(gain);
            let innovation = filter.innovation(&wagon, sample);
            filter.correct(&gain, &innovation);
            if k + 1 == run.len() {
                break;
            }
            let along = filter.derivatives(&wagon, sample, &decay);
            error.predict(SVector::zeros(), &along, &noise.process);
            filter.predict(&wagon, sample, &decay);
        }
        let half_log_determinant = gains.iter().map(|gain| gain.half_log_determinant).sum();
        Self { gains, decay, half_log_determinant }
    }

    /// Appends the whitened innovations of `built` on `run`, three a sample.
    pub fn residuals(&self, built: &Built, run: &Run, out: &mut Vec<f64>) {
        let wagon = FastWagon::new(&built.model, built.adhesion(run.rail), run.dt_s);
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

/// Innovations beyond this many sigma count as this many: a diverged trial must stay finite.
const CLAMP: f64 = 1e4;

/// The best estimate: motion, disturbances, hidden states of effects.
struct Filter {
    motion: Motion,
    disturbance: Disturbance,
    hidden: Vec<f64>,
}

impl Filter {
    fn start(run: &Run, wagon: &FastWagon) -> Self {
        let first = &run.samples[0];
        let hidden = wagon.start_hidden(&first.outputs, &first.input);
        let motion = wagon.start_motion(&first.measured_motion(), &first.input, &hidden);
        Self { motion, disturbance: Disturbance::default(), hidden }
    }

    fn innovation(&self, wagon: &FastWagon, sample: &Sample) -> [f64; OUTPUTS] {
        let reading = wagon.read(&self.motion, &sample.input, &self.hidden);
        sample.innovation(&reading)
    }

    fn correct(&mut self, gain: &Gain, innovation: &[f64; OUTPUTS]) {
        let change = gain.correction(innovation);
        for j in 0..OUTPUTS {
            self.motion.state[j] += change[j];
        }
        for i in 0..WHEELSETS {
            self.disturbance.pad[i] += change[OUTPUTS + i];
        }
        self.disturbance.wind_m_s += change[WIND];
    }

    fn predict(&mut self, wagon: &FastWagon, sample: &Sample, decay: &[f64; WHEELSETS + 1]) {
        wagon.step(&mut self.motion, &sample.input, &self.disturbance, &mut self.hidden);
        for i in 0..WHEELSETS {
            self.disturbance.pad[i] *= decay[i];
        }
        self.disturbance.wind_m_s *= decay[WHEELSETS];
    }

    /// Derivatives of the next state.
    fn derivatives(
        &self,
        wagon: &FastWagon,
        sample: &Sample,
        decay: &[f64; WHEELSETS + 1],
    ) -> SMatrix<f64, STATES, STATES> {
        let speeds_after = |state: usize, by: f64| {
            let (mut motion, mut disturbance) = (self.motion, self.disturbance);
            if state < OUTPUTS {
                motion.state[state] += by;
            } else {
                move_disturbance(&mut disturbance, state, by);
            }
            wagon.step(&mut motion, &sample.input, &disturbance, &mut self.hidden.clone());
            motion.state
        };
        derivatives(speeds_after, &DIFFERENCES, decay)
    }
}
