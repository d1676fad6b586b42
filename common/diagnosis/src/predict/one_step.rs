//! Whitened one-step prediction errors: the objective that selects effects.
//!
//! Open-loop errors over ten seconds are strongly coloured by what a diagnosis is not about (pads wander, wind
//! gusts), and a wheelset at the edge of sliding may fall either way, so that they make a poor likelihood. Here an
//! extended Kalman filter carries these disturbances as Ornstein–Uhlenbeck states. Its gains are computed once, at
//! the calibrated nominal model, and then frozen: a candidate's cost is that of one simulation with feedback, its
//! innovations are as smooth in the parameters as the laws, and under the nominal model they are white with unit
//! variance (prediction-error method with a fixed predictor; Ljung, System Identification, chapter 7).

use crate::data::case::{OUTPUTS, Run, Sample, WHEELSETS};
use crate::model::parameters::Built;
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion};
use railgrip_vehicle::{Sensors, VehicleParameters};

/// Speeds, pad frictions, wind.
pub(crate) const STATES: usize = OUTPUTS + WHEELSETS + 1;

/// Whitened innovations beyond this many sigma are outliers: they count linearly, not by their square (Huber).
pub const OUTLIER_SIGMA: f64 = 4.0;

/// The disturbance model: what varies without being an effect (pads, gusts), by how much and how fast.
#[derive(Clone, Debug)]
pub struct DisturbanceModel {
    /// Relative wander of pad friction, one sigma.
    pub pad_sigma: f64,
    /// Its correlation time, s.
    pub pad_time_s: f64,
    /// Correlation of the two wheelsets' wander.
    pub pad_correlation: f64,
    /// Gusts, one sigma, m/s.
    pub gust_sigma_m_s: f64,
    /// Their correlation time, s.
    pub gust_time_s: f64,
    /// White torque noise beyond that of the pressing force, relative to the torque at the adhesion limit.
    pub contact_sigma: f64,
    /// How wrong the model may be beyond that, see [`DisturbanceModel::tolerant`].
    pub tolerance: Tolerance,
}

/// White process noise for what a model leaves out: it shortens the horizon over which the filter trusts its model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tolerance {
    /// One sigma a sample of vehicle speed, relative to its sensor's sigma.
    pub speed: f64,
    /// One sigma a sample of wheelset speeds, relative to their sensors' sigma.
    pub wheel: f64,
}

/// Tolerances from none to one-step-ahead prediction.
pub const TOLERANCES: [Tolerance; 4] = [
    Tolerance { speed: 0.0, wheel: 0.0 },
    Tolerance { speed: 0.02, wheel: 0.2 },
    Tolerance { speed: 0.1, wheel: 1.0 },
    Tolerance { speed: 0.5, wheel: 5.0 },
];

impl DisturbanceModel {
    /// This disturbance model with one of the [`TOLERANCES`].
    pub fn tolerant(&self, index: usize) -> Self {
        Self { tolerance: TOLERANCES[index], ..self.clone() }
    }
}

impl Default for DisturbanceModel {
    fn default() -> Self {
        Self {
            pad_sigma: 0.006,
            pad_time_s: 4.0,
            pad_correlation: 0.7,
            gust_sigma_m_s: 0.5,
            gust_time_s: 4.0,
            contact_sigma: 0.002,
            tolerance: Tolerance::default(),
        }
    }
}

/// Frozen gain and whitening of one sample.
#[derive(Clone, Copy, Debug)]
struct Gain {
    gain: [[f64; OUTPUTS]; STATES],
    /// Inverse of the lower Cholesky factor of the innovation covariance.
    whiten: [[f64; OUTPUTS]; OUTPUTS],
}

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
        sensors: &Sensors,
        vehicle: &VehicleParameters,
        disturbances: &DisturbanceModel,
    ) -> Self {
        let wagon = FastWagon::new(&built.model, built.adhesion(run.rail), run.dt_s);
        let pad = (-run.dt_s / disturbances.pad_time_s).exp();
        let gust = (-run.dt_s / disturbances.gust_time_s).exp();
        let noise = Noise::new(sensors, vehicle, disturbances, run.dt_s, [pad, gust]);
        let mut covariance = noise.start;
        let mut filter = Filter::start(run, &wagon);
        let decay = [pad, pad, gust];
        let mut gains = Vec::with_capacity(run.len());
        for (k, sample) in run.samples.iter().enumerate() {
            let gain = update(&mut covariance, &noise.sensor);
            gains.push(gain);
            let innovation = filter.innovation(&wagon, sample);
            filter.correct(&gain, &innovation);
            if k + 1 == run.len() {
                break;
            }
            let jacobian = filter.jacobian(&wagon, sample, &decay);
            covariance = propagate(&jacobian, &covariance, &noise.process);
            filter.predict(&wagon, sample, &decay);
        }
        let log = |gain: &Gain| -> f64 { (0..OUTPUTS).map(|j| -gain.whiten[j][j].ln()).sum() };
        let half_log_determinant = gains.iter().map(log).sum();
        Self { gains, decay, half_log_determinant }
    }

    /// Appends the whitened innovations of `built` on `run`, three a sample.
    pub fn residuals(&self, built: &Built, run: &Run, out: &mut Vec<f64>) {
        let wagon = FastWagon::new(&built.model, built.adhesion(run.rail), run.dt_s);
        let mut filter = Filter::start(run, &wagon);
        let last = run.len() - 1;
        for (k, (sample, gain)) in run.samples.iter().zip(&self.gains).enumerate() {
            let innovation = filter.innovation(&wagon, sample);
            for row in &gain.whiten {
                let white: f64 = row.iter().zip(&innovation).map(|(w, e)| w * e).sum();
                out.push(if white.is_finite() { white.clamp(-CLAMP, CLAMP) } else { CLAMP });
            }
            filter.correct(gain, &innovation);
            if k < last {
                filter.predict(&wagon, sample, &self.decay);
            }
        }
    }
}

/// Innovations beyond this many sigma count as this many: a diverged trial must stay finite.
const CLAMP: f64 = 1e4;

/// The filter's mean.
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
        std::array::from_fn(|j| sample.outputs[j] - reading[j])
    }

    fn correct(&mut self, gain: &Gain, innovation: &[f64; OUTPUTS]) {
        let change = |row: usize| -> f64 { gain.gain[row].iter().zip(innovation).map(|(k, e)| k * e).sum() };
        for j in 0..OUTPUTS {
            self.motion.state[j] += change(j);
        }
        for i in 0..WHEELSETS {
            self.disturbance.pad[i] += change(OUTPUTS + i);
        }
        self.disturbance.wind_m_s += change(STATES - 1);
    }

    fn predict(&mut self, wagon: &FastWagon, sample: &Sample, decay: &[f64; WHEELSETS + 1]) {
        wagon.step(&mut self.motion, &sample.input, &self.disturbance, &mut self.hidden);
        for i in 0..WHEELSETS {
            self.disturbance.pad[i] *= decay[i];
        }
        self.disturbance.wind_m_s *= decay[WHEELSETS];
    }

    /// Derivatives of the next state, by differences.
    fn jacobian(
        &self,
        wagon: &FastWagon,
        sample: &Sample,
        decay: &[f64; WHEELSETS + 1],
    ) -> [[f64; STATES]; STATES] {
        let next = |column: usize, by: f64| {
            let (mut motion, mut disturbance) = (self.motion, self.disturbance);
            match column {
                0..OUTPUTS => motion.state[column] += by,
                _ if column < STATES - 1 => disturbance.pad[column - OUTPUTS] += by,
                _ => disturbance.wind_m_s += by,
            }
            wagon.step(&mut motion, &sample.input, &disturbance, &mut self.hidden.clone());
            motion.state
        };
        const BY: [f64; STATES] = [1e-4, 1e-4, 1e-4, 1e-3, 1e-3, 1e-1];
        let base = next(0, 0.0);
        let mut jacobian = [[0.0; STATES]; STATES];
        for (column, by) in BY.into_iter().enumerate() {
            let moved = next(column, by);
            for row in 0..OUTPUTS {
                jacobian[row][column] = (moved[row] - base[row]) / by;
            }
        }
        for (i, d) in decay.iter().enumerate() {
            jacobian[OUTPUTS + i][OUTPUTS + i] = *d;
        }
        jacobian
    }
}

pub(crate) type Matrix = [[f64; STATES]; STATES];

pub(crate) struct Noise {
    pub(crate) start: Matrix,
    pub(crate) process: Matrix,
    pub(crate) sensor: [f64; OUTPUTS],
}

impl Noise {
    pub(crate) fn new(
        sensors: &Sensors,
        vehicle: &VehicleParameters,
        disturbances: &DisturbanceModel,
        dt_s: f64,
        decay: [f64; 2],
    ) -> Self {
        let sensor = [
            sensors.speed_sigma_m_s.powi(2),
            sensors.wheel_speed_sigma_rad_s.powi(2),
            sensors.wheel_speed_sigma_rad_s.powi(2),
        ];
        let (mut start, mut process) = ([[0.0; STATES]; STATES], [[0.0; STATES]; STATES]);
        for j in 0..OUTPUTS {
            start[j][j] = sensor[j];
        }
        let pressing =
            vehicle.brake.friction_coefficient * vehicle.brake.radius_m * sensors.pressing_force_sigma_n;
        let limit = vehicle.axle_load_n() * vehicle.rail.wet * vehicle.wheelset.radius_m;
        let torque = pressing.hypot(disturbances.contact_sigma * limit);
        let tolerance = &disturbances.tolerance;
        for j in 1..OUTPUTS {
            process[j][j] = (torque / vehicle.wheelset.inertia_kg_m2 * dt_s).powi(2);
            process[j][j] += (tolerance.wheel * sensors.wheel_speed_sigma_rad_s).powi(2);
        }
        process[0][0] = 1e-10 + (tolerance.speed * sensors.speed_sigma_m_s).powi(2);
        let pad = disturbances.pad_sigma.powi(2);
        for i in 0..WHEELSETS {
            for j in 0..WHEELSETS {
                let share = if i == j { 1.0 } else { disturbances.pad_correlation };
                start[OUTPUTS + i][OUTPUTS + j] = pad * share;
                process[OUTPUTS + i][OUTPUTS + j] = pad * share * (1.0 - decay[0] * decay[0]);
            }
        }
        let gust = disturbances.gust_sigma_m_s.powi(2);
        start[STATES - 1][STATES - 1] = gust;
        process[STATES - 1][STATES - 1] = gust * (1.0 - decay[1] * decay[1]);
        Self { start, process, sensor }
    }
}

/// Kalman update in place (Joseph form is not needed: covariances stay far from singular); returns the gain.
fn update(covariance: &mut Matrix, sensor: &[f64; OUTPUTS]) -> Gain {
    let mut s = [[0.0; OUTPUTS]; OUTPUTS];
    for i in 0..OUTPUTS {
        s[i][..OUTPUTS].copy_from_slice(&covariance[i][..OUTPUTS]);
        s[i][i] += sensor[i];
    }
    let whiten = inverse_cholesky(&s);
    // S⁻¹ = Wᵀ W with W the inverse of the lower factor.
    let mut inverse = [[0.0; OUTPUTS]; OUTPUTS];
    for i in 0..OUTPUTS {
        for j in 0..OUTPUTS {
            inverse[i][j] = (0..OUTPUTS).map(|k| whiten[k][i] * whiten[k][j]).sum();
        }
    }
    let mut gain = [[0.0; OUTPUTS]; STATES];
    for i in 0..STATES {
        for j in 0..OUTPUTS {
            gain[i][j] = (0..OUTPUTS).map(|k| covariance[i][k] * inverse[k][j]).sum();
        }
    }
    let before = *covariance;
    for i in 0..STATES {
        for j in 0..STATES {
            let drop: f64 = (0..OUTPUTS).map(|k| gain[i][k] * before[k][j]).sum();
            covariance[i][j] = before[i][j] - drop;
        }
    }
    for i in 0..STATES {
        for j in 0..i {
            let mean = 0.5 * (covariance[i][j] + covariance[j][i]);
            covariance[i][j] = mean;
            covariance[j][i] = mean;
        }
    }
    Gain { gain, whiten }
}

fn propagate(jacobian: &Matrix, covariance: &Matrix, process: &Matrix) -> Matrix {
    let mut half = [[0.0; STATES]; STATES];
    for i in 0..STATES {
        for j in 0..STATES {
            half[i][j] = (0..STATES).map(|k| jacobian[i][k] * covariance[k][j]).sum();
        }
    }
    let mut next = *process;
    for i in 0..STATES {
        for j in 0..STATES {
            next[i][j] += (0..STATES).map(|k| half[i][k] * jacobian[j][k]).sum::<f64>();
        }
    }
    next
}

fn inverse_cholesky(s: &[[f64; OUTPUTS]; OUTPUTS]) -> [[f64; OUTPUTS]; OUTPUTS] {
    let mut lower = [[0.0; OUTPUTS]; OUTPUTS];
    for i in 0..OUTPUTS {
        for j in 0..=i {
            let sum: f64 = s[i][j] - (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f64>();
            lower[i][j] = if i == j { sum.max(1e-18).sqrt() } else { sum / lower[j][j] };
        }
    }
    let mut inverse = [[0.0; OUTPUTS]; OUTPUTS];
    for i in 0..OUTPUTS {
        inverse[i][i] = 1.0 / lower[i][i];
        for j in 0..i {
            let sum: f64 = (j..i).map(|k| lower[i][k] * inverse[k][j]).sum();
            inverse[i][j] = -sum / lower[i][i];
        }
    }
    inverse
}
