//! What a small change of the model does to the innovations of a frozen filter: a linear recursion beside one simulation.
//!
//! The filter is run once and leaves its path: motion, loading, and how the speeds after each sample depend on what enters
//! it. Another model is then not simulated. Its laws are asked along that path; by how much its loading and its readings
//! differ drives a linear filter of the difference,
//!
//! ```text
//! δν = −(h'(x) − h(x)) − H δx ,   δx⁺ = δx + K δν ,   δx' = A δx⁺ + B δu
//! ```
//!
//! with δu the change of torques, adhesion and forces. This is the derivative of the innovations where the change is small
//! (Ljung, System Identification, section 10.3), and stays useful where it is not: the path follows what was measured, so
//! that a model which lets a wheelset slide is asked where the wheelset did slide. Hidden states of effects and sensors that
//! are late see the path and not the difference. A late reading in its own feedback would unsettle the filter; here it
//! cannot.

use crate::data::case::{OUTPUTS, Run};
use crate::model::parameters::Built;
use crate::predict::disturbances::{Decay, coloured, push, states};
use crate::predict::one_step::{CLAMP, Filter, Frozen, Gains, Predictor, wagon};
use crate::predict::passes::{Pass, counted};
use railgrip_vehicle::fast::{Disturbance, Motion};
use railgrip_vehicle::{Constants, Loading, Slopes};

/// Where a frozen filter stood at a sample, and what acted there.
#[derive(Clone, Debug)]
struct Point<const W: usize, const S: usize> {
    /// Before and after what was measured had corrected it.
    before: Motion,
    after: Motion,
    disturbance: Disturbance,
    reading: [f64; OUTPUTS],
    innovation: [f64; S],
    loading: Loading,
    /// Speeds after the sample by the linear part of a step.
    ahead: [f64; OUTPUTS],
    resistance_n: f64,
    slopes: Slopes<W, S>,
    /// Derivative of the force on the body over what pushes.
    by_push: f64,
}

/// The path of a frozen filter over one run.
#[derive(Debug)]
pub struct Path<'a>(Size<'a>);

/// The path by how many wheelsets there is room for.
#[derive(Debug)]
enum Size<'a> {
    Two(Points<'a, 2, 3, { coloured(2) }>),
    Four(Points<'a, 4, 5, { coloured(4) }>),
}

impl<'a> Path<'a> {
    /// Runs the frozen filter over `run` with `built`.
    pub fn new(built: &Built, run: &'a Run, predictor: &'a Predictor) -> Self {
        let tolerant = predictor.tolerant;
        Self(counted(Pass::Path, run.len(), || match &predictor.frozen {
            Frozen::Two(gains) => Size::Two(Points::new(built, run, gains, tolerant)),
            Frozen::Four(gains) => Size::Four(Points::new(built, run, gains, tolerant)),
        }))
    }

    /// Appends the whitened innovations that `built` would have, [`Run::room`] a sample.
    pub fn residuals(&self, built: &Built, out: &mut Vec<f64>) {
        let samples = match &self.0 {
            Size::Two(points) => points.run.len(),
            Size::Four(points) => points.run.len(),
        };
        counted(Pass::Response, samples, || match &self.0 {
            Size::Two(points) => points.residuals(built, out),
            Size::Four(points) => points.residuals(built, out),
        });
    }
}

/// The points of a path of a wagon with room for `W` wheelsets, `S` being `1 + W` and `C` all its states.
#[derive(Debug)]
struct Points<'a, const W: usize, const S: usize, const C: usize> {
    run: &'a Run,
    gains: &'a Gains<W, S, C>,
    tolerant: bool,
    points: Vec<Point<W, S>>,
    constants: Constants,
}

/// Relative change of adhesion from which a model is stepped instead of linearised: where it matters, it decides between
/// holding and sliding.
const STEPPED: f64 = 0.02;

impl<'a, const W: usize, const S: usize, const C: usize> Points<'a, W, S, C> {
    fn new(built: &Built, run: &'a Run, gains: &'a Gains<W, S, C>, tolerant: bool) -> Self {
        let wagon = wagon(built, run, tolerant);
        let mut filter = Filter::<W, S>::start(run, &wagon);
        let mut points = Vec::with_capacity(run.len());
        for (k, (sample, gain)) in run.samples.iter().zip(&gains.gains).enumerate() {
            let before = filter.motion;
            let reading = wagon.read(&before, &sample.input, &filter.hidden);
            let innovation = sample.innovation(&filter.reading(&wagon, sample));
            filter.correct(gain, &innovation, gains.decay.pushes);
            let after = filter.motion;
            let loading = wagon.loading_at(&after, &sample.input, &filter.disturbance, &filter.hidden);
            points.push(Point {
                before,
                after,
                disturbance: filter.disturbance,
                reading,
                innovation,
                resistance_n: wagon.resistance(&after, &loading),
                ahead: wagon.coarse(&after, &loading),
                slopes: wagon.slopes(&after, &loading),
                by_push: gains.decay.pushes.force(&wagon, &after, &loading),
                loading,
            });
            if k + 1 < run.len() {
                filter.predict(&wagon, sample, &gains.decay);
            }
        }
        Self { run, gains, tolerant, points, constants: wagon.constants().clone() }
    }

    fn residuals(&self, built: &Built, out: &mut Vec<f64>) {
        let run = self.run;
        let wagon = wagon(built, run, self.tolerant);
        let first = &run.samples[0];
        let mut hidden = wagon.start_hidden(&first.outputs, &first.input);
        let start = wagon.start_motion(&first.measured_motion(), &first.input, &hidden);
        let mut change = [0.0; C];
        for j in 0..S {
            change[j] = start.state[j] - self.points[0].before.state[j];
        }
        let stepped = steps_otherwise(&self.constants, wagon.constants());
        let decay = &self.gains.decay;
        for (k, (sample, (point, gain))) in
            run.samples.iter().zip(self.points.iter().zip(&self.gains.gains)).enumerate()
        {
            let reading = wagon.read(&point.before, &sample.input, &hidden);
            let other: [f64; S] = std::array::from_fn(|j| {
                if sample.measured[j] {
                    point.reading[j] - reading[j] - change[j] - change[states(W) + j]
                } else {
                    0.0
                }
            });
            let innovation: [f64; S] = std::array::from_fn(|j| point.innovation[j] + other[j]);
            let white = gain.whitened(&innovation);
            out.extend(white.map(|white| if white.is_finite() { white.clamp(-CLAMP, CLAMP) } else { CLAMP }));
            let correction = gain.correction(&other);
            (0..C).for_each(|i| change[i] += correction[i]);
            if k + 1 == self.points.len() {
                break;
            }
            let loading = wagon.loading_at(&point.after, &sample.input, &point.disturbance, &hidden);
            let driven = if stepped || adhesion_differs(&loading, &point.loading) {
                let speeds = wagon.coarse(&point.after, &loading);
                std::array::from_fn(|j| speeds[j] - point.ahead[j])
            } else {
                point.driven(&loading, wagon.resistance(&point.after, &loading))
            };
            change = point.carried(&change, &driven, decay);
            wagon.follow(&point.after, &sample.input, &mut hidden);
        }
    }
}

impl<const W: usize, const S: usize> Point<W, S> {
    /// Change of the speeds after the sample by another loading and resistance.
    fn driven(&self, loading: &Loading, resistance_n: f64) -> [f64; S] {
        let force = loading.other_n - self.loading.other_n - resistance_n + self.resistance_n;
        let torque = |i: usize| {
            let brake = loading.brake_torque_nm[i] - self.loading.brake_torque_nm[i];
            loading.drive_torque_nm[i] - self.loading.drive_torque_nm[i] - self.sense(i) * brake
        };
        let torques: [f64; W] = std::array::from_fn(torque);
        let slopes = &self.slopes;
        std::array::from_fn(|j| {
            let adhesion = |i: usize| loading.adhesion_peak[i] - self.loading.adhesion_peak[i];
            let of = |i: usize| slopes.by_torque[j][i] * torques[i] + slopes.by_adhesion[j][i] * adhesion(i);
            slopes.by_force[j] * force + (0..W).map(of).sum::<f64>()
        })
    }

    fn sense(&self, wheelset: usize) -> f64 {
        let omega = self.after.state[1 + wheelset];
        if omega == 0.0 { 0.0 } else { omega.signum() }
    }

    /// The change one sample later.
    fn carried<const C: usize>(&self, change: &[f64; C], driven: &[f64; S], decay: &Decay) -> [f64; C] {
        let slopes = &self.slopes;
        // A change of pad friction is relative to the disturbed level.
        let torque = |i: usize| {
            let level = 1.0 + self.disturbance.pad[i];
            -self.sense(i) * self.loading.brake_torque_nm[i] / level * change[S + i]
        };
        let torques: [f64; W] = std::array::from_fn(torque);
        let force = self.by_push * change[push(W)];
        let mut next = [0.0; C];
        for j in 0..S {
            let speeds: f64 = (0..S).map(|i| slopes.by_speed[j][i] * change[i]).sum();
            let pads: f64 = (0..W).map(|i| slopes.by_torque[j][i] * torques[i]).sum();
            next[j] = speeds + pads + slopes.by_force[j] * force + driven[j];
        }
        for i in 0..W {
            next[S + i] = decay.pad * change[S + i];
        }
        next[push(W)] = decay.push * change[push(W)];
        for j in 0..S {
            next[states(W) + j] = decay.colour[j] * change[states(W) + j];
        }
        next
    }
}

/// Whether constants differ in what the recursion does not know: masses, radii, creep, the spread of load.
fn steps_otherwise(a: &Constants, b: &Constants) -> bool {
    a.mass_kg != b.mass_kg
        || a.com_height_m != b.com_height_m
        || a.inertia_kg_m2 != b.inertia_kg_m2
        || a.wheel_radius_m != b.wheel_radius_m
        || a.wheelset_positions_m != b.wheelset_positions_m
        || a.bogie != b.bogie
        || a.fixed_load_n != b.fixed_load_n
        || a.contact != b.contact
}

fn adhesion_differs(a: &Loading, b: &Loading) -> bool {
    (0..a.adhesion_peak.len())
        .any(|i| (a.adhesion_peak[i] - b.adhesion_peak[i]).abs() > STEPPED * b.adhesion_peak[i].abs())
}
