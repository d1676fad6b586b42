//! Where: one place of the equations or one sensor freed at a time by an Ornstein–Uhlenbeck disturbance.
//!
//! The filter of the calibrated model gets one more state, a disturbance d with d' = −d/τ + noise, which acts at one
//! place. Where the model errs, freeing that place lets the recordings become far more likely than freeing any other,
//! whatever the error depends on. Amplitude and correlation time are those of the greatest likelihood on a coarse grid
//! (Kennedy & O'Hagan's discrepancy, put inside the equations; Jazwinski, Stochastic Processes and Filtering Theory,
//! section 8.4, for the disturbance as a state).

use crate::data::case::{Case, OUTPUTS, Run, Sample, WHEELSETS};
use crate::model::discrepancy::{Place, Scope};
use crate::model::parameters::Built;
use crate::model::places;
use crate::predict::disturbances::{
    DIFFERENCES, DisturbanceModel, Noise, STATES, WIND, derivatives, move_disturbance, robust_cost,
};
use nalgebra::{SMatrix, SVector};
use railgrip_filter::core::Gaussian;
use railgrip_vehicle::effects::Term;
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion};
use rayon::prelude::*;

/// States of the wagon's filter and the disturbance.
const WIDE: usize = STATES + 1;
type State = SMatrix<f64, WIDE, WIDE>;

/// What is freed, in the order of the report.
const PLACES: [(Place, Scope); 15] = [
    (Place::BodyForce, Scope::Both),
    (Place::WheelTorque, Scope::Both),
    (Place::WheelTorque, Scope::Front),
    (Place::WheelTorque, Scope::Rear),
    (Place::PadFriction, Scope::Both),
    (Place::PadFriction, Scope::Front),
    (Place::PadFriction, Scope::Rear),
    (Place::Adhesion, Scope::Both),
    (Place::DriveTorque, Scope::Both),
    (Place::SpeedSensor, Scope::Both),
    (Place::WheelSensor, Scope::Both),
    (Place::WheelSensor, Scope::Front),
    (Place::WheelSensor, Scope::Rear),
    (Place::WheelScale, Scope::Front),
    (Place::WheelScale, Scope::Rear),
];
/// Amplitudes tried, relative to the size of a change that matters.
const AMPLITUDES: [f64; 5] = [0.3, 1.0, 3.0, 10.0, 30.0];
/// Correlation time at which amplitudes are tried, s.
const TIME_S: f64 = 1.0;
/// Further correlation times, s.
const TIMES_S: [f64; 2] = [0.1, 10.0];
/// Samples over which derivatives are held: they change slowly beside the sampling.
const DERIVATIVES_HELD: usize = 3;
/// Length of the stretches whose costs are kept apart, s.
const STRETCH_S: f64 = 5.0;
/// Cost of a filter that diverged.
const DIVERGED: f64 = 1e12;

/// A place that was freed, and what that gained.
#[derive(Clone, Copy, Debug)]
pub struct PlaceEvidence {
    /// Where.
    pub place: Place,
    /// On which wheelsets.
    pub scope: Scope,
    /// Log-likelihood gained over the same filter with nothing freed.
    pub evidence: f64,
    /// Amplitude of the disturbance, one sigma, in the unit of the place.
    pub amplitude: f64,
    /// Its correlation time, s.
    pub time_s: f64,
}

/// Frees every place in turn; the most likely first. `event_share` is the share of a case's stretches that are not counted.
pub fn localise(
    case: &Case,
    built: &Built,
    disturbances: &DisturbanceModel,
    event_share: f64,
) -> Vec<PlaceEvidence> {
    let nothing = costs(case, built, disturbances, &LocalDisturbance::nothing());
    let mut all: Vec<PlaceEvidence> = PLACES
        .par_iter()
        .map(|&(place, scope)| {
            let scale = place.scale().0;
            let try_one = |step: usize, time_s: f64| {
                let freed = LocalDisturbance { place, scope, amplitude: AMPLITUDES[step] * scale, time_s };
                let costs = costs(case, built, disturbances, &freed);
                (costs.iter().sum::<f64>(), step, time_s, costs)
            };
            // The likelihood has one hill over the amplitude: up it from the middle.
            let (mut best, mut beside) = (try_one(1, TIME_S), try_one(2, TIME_S));
            let upwards = beside.0 < best.0;
            if upwards {
                std::mem::swap(&mut best, &mut beside);
            }
            loop {
                let next = if upwards { best.1 + 1 } else { best.1.wrapping_sub(1) };
                if next >= AMPLITUDES.len() {
                    break;
                }
                let further = try_one(next, TIME_S);
                if further.0 >= best.0 {
                    break;
                }
                best = further;
            }
            for time_s in TIMES_S {
                let other = try_one(best.1, time_s);
                if other.0 < best.0 {
                    best = other;
                }
            }
            let amplitude = AMPLITUDES[best.1] * scale;
            PlaceEvidence {
                place,
                scope,
                evidence: evidence(&nothing, &best.3, event_share),
                amplitude,
                time_s: best.2,
            }
        })
        .collect();
    all.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    all
}

/// What is gained over all stretches but the few that gain most, a share `event_share` of them: a wheelset at the edge between holding and sliding may
/// fall either way, and a filter that lost it there gains by whatever is freed.
pub(crate) fn evidence(nothing: &[f64], freed: &[f64], event_share: f64) -> f64 {
    let mut gains: Vec<f64> = nothing.iter().zip(freed).map(|(a, b)| a - b).collect();
    gains.sort_by(f64::total_cmp);
    let events = (event_share * gains.len() as f64).ceil() as usize;
    gains.iter().take(gains.len() - events).sum()
}

/// Places that gain at least a `share` of what the best one gains: the recordings cannot tell them apart.
pub fn likely(places: &[PlaceEvidence], share: f64) -> &[PlaceEvidence] {
    let best = places.first().map_or(0.0, |w| w.evidence);
    let count = places.iter().take_while(|w| w.evidence >= share * best).count();
    &places[..count]
}

/// What freeing a place gains beside the named effects, as a share of what it gained without them.
pub fn share_left(before: &[PlaceEvidence], beside: &[PlaceEvidence]) -> f64 {
    let best = |places: &[PlaceEvidence]| places.first().map_or(0.0, |w| w.evidence.max(0.0));
    best(beside) / best(before).max(1.0)
}

/// Whether an effect of a term may show where freeing a place gained most.
pub fn may_act_at(term: Term, likely: &[PlaceEvidence]) -> bool {
    likely.iter().any(|place| places::of(term).contains(&place.place))
}

/// A freed place with its disturbance.
#[derive(Clone, Copy, Debug)]
struct LocalDisturbance {
    place: Place,
    scope: Scope,
    amplitude: f64,
    time_s: f64,
}

impl LocalDisturbance {
    fn nothing() -> Self {
        Self { place: Place::BodyForce, scope: Scope::Both, amplitude: 0.0, time_s: TIME_S }
    }

    fn on(&self, wheelset: usize) -> f64 {
        if self.scope.has(wheelset) { 1.0 } else { 0.0 }
    }
}

/// Minus the log-likelihood of each stretch of the runs to fit on, up to a constant.
fn costs(case: &Case, built: &Built, disturbances: &DisturbanceModel, freed: &LocalDisturbance) -> Vec<f64> {
    case.fit.iter().flat_map(|run| Filter::new(case, built, run, disturbances, freed).costs()).collect()
}

struct Filter<'a> {
    run: &'a Run,
    wagon: FastWagon<'a>,
    freed: &'a LocalDisturbance,
    mass_kg: f64,
    inertia_kg_m2: f64,
    decay: [f64; WHEELSETS + 2],
    process: State,
    sensor: SMatrix<f64, OUTPUTS, OUTPUTS>,
    /// Belief about the error of what follows, see [`crate::predict::disturbances`].
    error: Gaussian<WIDE>,
    derivatives: State,
    motion: Motion,
    disturbance: Disturbance,
    local: f64,
    hidden: Vec<f64>,
}

impl<'a> Filter<'a> {
    fn new(
        case: &Case,
        built: &'a Built,
        run: &'a Run,
        disturbances: &DisturbanceModel,
        freed: &'a LocalDisturbance,
    ) -> Self {
        let vehicle = &case.vehicle;
        let own = (-run.dt_s / freed.time_s).exp();
        let shared = disturbances.decay(run.dt_s);
        let noise = Noise::new(vehicle, disturbances, run.dt_s, &shared);
        let widen = |narrow: &SMatrix<f64, STATES, STATES>, last: f64| {
            let mut wide = State::zeros();
            wide.fixed_view_mut::<STATES, STATES>(0, 0).copy_from(narrow);
            wide[(STATES, STATES)] = last;
            wide
        };
        let variance = freed.amplitude.powi(2);
        let wagon = FastWagon::new(&built.model, built.adhesion(run.rail), run.dt_s);
        let first = &run.samples[0];
        let hidden = wagon.start_hidden(&first.outputs, &first.input);
        let mut decay = [own; WHEELSETS + 2];
        decay[..=WHEELSETS].copy_from_slice(&shared);
        Self {
            run,
            freed,
            mass_kg: vehicle.body.mass_kg,
            inertia_kg_m2: vehicle.wheelset.inertia_kg_m2,
            decay,
            process: widen(&noise.process, variance * (1.0 - own * own)),
            sensor: noise.sensor,
            error: Gaussian { mean: SVector::zeros(), covariance: widen(&noise.start, variance) },
            derivatives: State::identity(),
            motion: wagon.start_motion(&first.measured_motion(), &first.input, &hidden),
            wagon,
            disturbance: Disturbance::default(),
            local: 0.0,
            hidden,
        }
    }

    /// Cost of each stretch of the run.
    fn costs(mut self) -> Vec<f64> {
        let stretch = (STRETCH_S / self.run.dt_s).round().max(1.0) as usize;
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
    fn expected(&self, sample: &Sample) -> ([f64; OUTPUTS], SMatrix<f64, OUTPUTS, WIDE>) {
        let reading = self.wagon.read(&self.motion, &sample.input, &self.hidden);
        let mut observe = SMatrix::<f64, OUTPUTS, WIDE>::identity();
        let mut expected = reading;
        match self.freed.place {
            Place::SpeedSensor => {
                observe[(0, STATES)] = 1.0;
                expected[0] += self.local;
            }
            Place::WheelSensor => {
                for i in 0..WHEELSETS {
                    observe[(1 + i, STATES)] = self.freed.on(i);
                    expected[1 + i] += self.freed.on(i) * self.local;
                }
            }
            Place::WheelScale => {
                for i in 0..WHEELSETS {
                    observe[(1 + i, STATES)] = self.freed.on(i) * reading[1 + i];
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
        let innovation: [f64; OUTPUTS] = std::array::from_fn(|j| sample.outputs[j] - expected[j]);
        let Some(gain) = self.error.condition(&observe, &self.sensor) else { return f64::INFINITY };
        let change = gain.correction(&innovation);
        for j in 0..OUTPUTS {
            self.motion.state[j] += change[j];
        }
        for i in 0..WHEELSETS {
            self.disturbance.pad[i] += change[OUTPUTS + i];
        }
        self.disturbance.wind_m_s += change[WIND];
        self.local += change[STATES];
        let white = gain.whitened(&innovation);
        white.into_iter().map(robust_cost).sum::<f64>() + gain.half_log_determinant
    }

    fn predict(&mut self, sample: &Sample) {
        self.error.predict(SVector::zeros(), &self.derivatives, &self.process);
        let mut hidden = std::mem::take(&mut self.hidden);
        self.motion = self.step(self.motion, sample, self.disturbance, self.local, &mut hidden);
        self.hidden = hidden;
        for i in 0..WHEELSETS {
            self.disturbance.pad[i] *= self.decay[i];
        }
        self.disturbance.wind_m_s *= self.decay[WHEELSETS];
        self.local *= self.decay[WHEELSETS + 1];
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
            Place::PadFriction => (0..WHEELSETS).for_each(|i| disturbance.pad[i] += freed.on(i) * local),
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
                for i in 0..WHEELSETS {
                    motion.state[1 + i] += freed.on(i) * local * self.run.dt_s / self.inertia_kg_m2;
                }
            }
            _ => {}
        }
        motion
    }

    /// Derivatives of the next state.
    fn derivatives(&self, sample: &Sample) -> State {
        let speeds_after = |state: usize, by: f64| {
            let (mut motion, mut disturbance, mut local) = (self.motion, self.disturbance, self.local);
            match state {
                0..OUTPUTS => motion.state[state] += by,
                STATES => local += by,
                _ => move_disturbance(&mut disturbance, state, by),
            }
            self.step(motion, sample, disturbance, local, &mut self.hidden.clone()).state
        };
        let mut steps = [0.03 * self.freed.place.scale().0; WIDE];
        steps[..STATES].copy_from_slice(&DIFFERENCES);
        derivatives(speeds_after, &steps, &self.decay)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_stretches_decide_nothing() {
        let nothing = vec![10.0; 40];
        let mut event = nothing.clone();
        event[7] -= 650.0;
        event[8] -= 130.0;
        assert!(
            evidence(&nothing, &event, 0.05) <= 0.0,
            "an event counts for {}",
            evidence(&nothing, &event, 0.05)
        );
        let everywhere: Vec<f64> = nothing.iter().map(|cost| cost - 5.0).collect();
        assert!((evidence(&nothing, &everywhere, 0.05) - 190.0).abs() < 1e-9);
    }
}
