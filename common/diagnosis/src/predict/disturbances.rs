//! The disturbance model: what varies along a run without being an effect, and the Kalman filter's view of it.
//!
//! The filters of [`one_step`](crate::predict::one_step) and [`localise`](crate::predict::localise) are error-state filters:
//! the simulated motion and disturbances are the best estimate, the [`Gaussian`](railgrip_filter::core::Gaussian) is the belief
//! about their error. Its mean is zero, because each correction is at once made in the simulation.

use crate::data::case::{Case, OUTPUTS};
use nalgebra::{SMatrix, SVector};
use railgrip_vehicle::Loading;
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion};

/// States of the filter of a wagon with room for `wheelsets`: speeds, pad frictions, what pushes.
pub(crate) const fn states(wheelsets: usize) -> usize {
    2 * wheelsets + 2
}

/// Index of what pushes among them, see [`Push`].
pub(crate) const fn push(wheelsets: usize) -> usize {
    states(wheelsets) - 1
}

/// What pushes at the body without being an effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Push {
    /// Gusts of wind at a free wagon, m/s.
    #[default]
    Wind,
    /// The couplers of a wagon in a train, N. Gusts are small beside them.
    Couplers,
}

impl Push {
    fn of(case: &Case) -> Self {
        if case.is_coupled() { Self::Couplers } else { Self::Wind }
    }

    /// Adds to what pushes.
    pub(crate) fn add(self, disturbance: &mut Disturbance, change: f64) {
        *self.of_disturbance(disturbance) += change;
    }

    /// Leaves this share of what pushes.
    pub(crate) fn fade(self, disturbance: &mut Disturbance, share: f64) {
        *self.of_disturbance(disturbance) *= share;
    }

    fn of_disturbance(self, disturbance: &mut Disturbance) -> &mut f64 {
        match self {
            Self::Wind => &mut disturbance.wind_m_s,
            Self::Couplers => &mut disturbance.coupler_n,
        }
    }

    /// Derivative of the force on the body over what pushes.
    pub(crate) fn force(self, wagon: &FastWagon, motion: &Motion, loading: &Loading) -> f64 {
        match self {
            Self::Wind => -wagon.resistance_by_wind(motion, loading),
            Self::Couplers => 1.0,
        }
    }
}

/// The same and the coloured part of each sensor's noise.
pub(crate) const fn coloured(wheelsets: usize) -> usize {
    states(wheelsets) + 1 + wheelsets
}

/// What is left of each disturbance after a sample.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Decay {
    /// Of pad friction.
    pub(crate) pad: f64,
    /// Of what pushes.
    pub(crate) push: f64,
    /// What that is.
    pub(crate) pushes: Push,
    /// Of each sensor's coloured noise.
    pub(crate) colour: [f64; OUTPUTS],
}

impl Decay {
    /// Of the state at this index, of a wagon with room for `wheelsets`; that of a speed does not decay.
    pub(crate) fn of(&self, index: usize, wheelsets: usize) -> f64 {
        match index {
            _ if index <= wheelsets => 1.0,
            _ if index < push(wheelsets) => self.pad,
            _ if index == push(wheelsets) => self.push,
            _ => self.colour[index - states(wheelsets)],
        }
    }
}

/// Whitened innovations beyond this many sigma are outliers: they count linearly, not by their square (Huber).
pub const OUTLIER_SIGMA: f64 = 4.0;

/// The disturbance model: what varies without being an effect (pads, gusts), by how much and how fast.
#[derive(Clone, Debug)]
pub struct DisturbanceModel {
    /// Relative drift of pad friction, one sigma.
    pub pad_sigma: f64,
    /// Its correlation time, s.
    pub pad_time_s: f64,
    /// Correlation of the two wheelsets' drift.
    pub pad_correlation: f64,
    /// Gusts, one sigma, m/s.
    pub gust_sigma_m_s: f64,
    /// Their correlation time, s.
    pub gust_time_s: f64,
    /// Forces of the couplers of a wagon that does not run alone, one sigma, as an acceleration of it, m/s². Set by hand:
    /// wagons of a train brake by some tenths of m/s² more or less than their neighbours.
    pub coupler_sigma_m_s2: f64,
    /// Their correlation time, s. Set by hand: that of a train's stretching and closing up.
    pub coupler_time_s: f64,
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

impl Tolerance {
    /// Whether a filter with it corrects so much at each sample that it hardly looks beyond one step.
    pub(crate) fn is_large(&self) -> bool {
        self.wheel >= LARGE_WHEEL
    }
}

/// Process noise of wheelset speeds, relative to their sensors' sigma, from which a tolerance is large.
const LARGE_WHEEL: f64 = 1.0;

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

impl DisturbanceModel {
    /// What is left of each disturbance (pads, what pushes, coloured noise) after a sample.
    pub(crate) fn decay(&self, dt_s: f64, case: &Case) -> Decay {
        let over = |time_s: f64| (-dt_s / time_s).exp();
        let pushes = Push::of(case);
        let push_time_s = match pushes {
            Push::Wind => self.gust_time_s,
            Push::Couplers => self.coupler_time_s,
        };
        Decay {
            pad: over(self.pad_time_s),
            push: over(push_time_s),
            pushes,
            colour: std::array::from_fn(|j| over(case.noise[j].time_s)),
        }
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
            coupler_sigma_m_s2: 0.3,
            coupler_time_s: 3.0,
            contact_sigma: 0.002,
            tolerance: Tolerance::default(),
        }
    }
}

/// Robust cost of a whitened innovation: half its square, linear beyond [`OUTLIER_SIGMA`].
pub(crate) fn robust_cost(white: f64) -> f64 {
    let size = white.abs();
    if size <= OUTLIER_SIGMA { 0.5 * white * white } else { OUTLIER_SIGMA * (size - 0.5 * OUTLIER_SIGMA) }
}

/// How outputs are observed where some were not measured: a row of its own variance one, which no state moves, stands in for
/// each. With an innovation of zero it corrects nothing, and adds nothing to a cost or a determinant; the belief is that
/// after the outputs which were measured.
pub(crate) fn of_measured<const S: usize, const N: usize>(
    measured: &[bool; OUTPUTS],
    observe: &SMatrix<f64, S, N>,
    sensor: &SMatrix<f64, S, S>,
) -> (SMatrix<f64, S, N>, SMatrix<f64, S, S>) {
    let (mut observe, mut sensor) = (*observe, *sensor);
    for j in (0..S).filter(|j| !measured[*j]) {
        observe.row_mut(j).fill(0.0);
        sensor.row_mut(j).fill(0.0);
        sensor.column_mut(j).fill(0.0);
        sensor[(j, j)] = 1.0;
    }
    (observe, sensor)
}

/// Derivatives of the next state with respect to the present one, of a wagon with room for `W` wheelsets, `S` being `1 + W`, and
/// `N` its states, with coloured noise or without; rows beyond these are zero. `decay` is what is left of each disturbance
/// after a sample.
pub(crate) fn derivatives<const W: usize, const S: usize, const N: usize>(
    wagon: &FastWagon,
    motion: &Motion,
    disturbance: &Disturbance,
    loading: &Loading,
    decay: &Decay,
) -> SMatrix<f64, N, N> {
    let slopes = wagon.slopes::<W, S>(motion, loading);
    let mut derivatives = SMatrix::zeros();
    let by_push = decay.pushes.force(wagon, motion, loading);
    for row in 0..S {
        for column in 0..S {
            derivatives[(row, column)] = slopes.by_speed[row][column];
        }
        for i in 0..W {
            let against = if motion.state[1 + i] == 0.0 { 0.0 } else { motion.state[1 + i].signum() };
            let by_pad = -against * loading.brake_torque_nm[i] / (1.0 + disturbance.pad[i]);
            derivatives[(row, S + i)] = slopes.by_torque[row][i] * by_pad;
        }
        derivatives[(row, push(W))] = slopes.by_force[row] * by_push;
    }
    for i in S..N.min(coloured(W)) {
        derivatives[(i, i)] = decay.of(i, W);
    }
    derivatives
}

/// How the outputs are observed: speeds, and coloured noise where it is among the `N` states.
pub(crate) fn observed<const S: usize, const N: usize>() -> SMatrix<f64, S, N> {
    let colour = states(S - 1);
    SMatrix::from_fn(|i, j| if j == i || j == colour + i { 1.0 } else { 0.0 })
}

/// Covariances of the filter of a vehicle over its `N` states: of the first error, of the noise of one sample, of the sensors.
pub(crate) struct Noise<const S: usize, const N: usize> {
    pub(crate) start: SMatrix<f64, N, N>,
    pub(crate) process: SMatrix<f64, N, N>,
    pub(crate) sensor: SMatrix<f64, S, S>,
}

impl<const S: usize, const N: usize> Noise<S, N> {
    /// `decay` is what is left of each disturbance after a sample of `dt_s`.
    pub(crate) fn new(case: &Case, disturbances: &DisturbanceModel, dt_s: f64, decay: &Decay) -> Self {
        let room = S - 1;
        let wheelsets = case.wheelsets().min(room);
        let vehicle = &case.vehicle;
        let sensors = &vehicle.sensors;
        let (speed, wheel) = (sensors.speed_sigma_m_s, sensors.wheel_speed_sigma_rad_s);
        let sensor = SMatrix::from_diagonal(&SVector::from_fn(|j, _| case.noise[j].white.powi(2)));
        let mut start = SMatrix::<f64, N, N>::zeros();
        let mut process = start;
        for (j, noise) in case.noise.iter().enumerate().take(1 + wheelsets) {
            start[(j, j)] = noise.level().powi(2);
            let at = states(room) + j;
            if N >= coloured(room) {
                let variance = noise.coloured.powi(2);
                start[(at, at)] = variance;
                process[(at, at)] = variance * (1.0 - decay.colour[j].powi(2));
            }
        }
        let pressing =
            vehicle.brake.friction_coefficient * vehicle.brake.radius_m * sensors.pressing_force_sigma_n;
        let limit = vehicle.axle_load_n() * vehicle.rail.wet * vehicle.wheelset.radius_m;
        let torque = pressing.hypot(disturbances.contact_sigma * limit);
        let tolerance = &disturbances.tolerance;
        process[(0, 0)] = 1e-10 + (tolerance.speed * speed).powi(2);
        for j in 1..=wheelsets {
            process[(j, j)] = (torque / vehicle.wheelset.inertia_kg_m2 * dt_s).powi(2);
            process[(j, j)] += (tolerance.wheel * wheel).powi(2);
        }
        let pad = disturbances.pad_sigma.powi(2);
        for i in 0..wheelsets {
            for j in 0..wheelsets {
                let share = if i == j { 1.0 } else { disturbances.pad_correlation };
                let at = (S + i, S + j);
                start[at] = pad * share;
                process[at] = pad * share * (1.0 - decay.pad * decay.pad);
            }
        }
        let sigma = match decay.pushes {
            Push::Wind => disturbances.gust_sigma_m_s,
            Push::Couplers => disturbances.coupler_sigma_m_s2 * vehicle.body.mass_kg,
        };
        let push = push(room);
        start[(push, push)] = sigma.powi(2);
        process[(push, push)] = sigma.powi(2) * (1.0 - decay.push * decay.push);
        Self { start, process, sensor }
    }
}
