//! Where: one place of the equations or one sensor freed at a time by an Ornstein–Uhlenbeck disturbance.
//!
//! The filter of the calibrated model gets one more state, a disturbance d with d' = −d/τ + noise, which acts at one
//! place. Where the model errs, freeing that place lets the recordings become far more likely than freeing any other,
//! whatever the error depends on. Amplitude and correlation time are those of the greatest likelihood on a coarse grid
//! (Kennedy & O'Hagan's discrepancy, put inside the equations).

use crate::data::case::Case;
use crate::model::discrepancy::{Place, Scope};
use crate::model::parameters::Built;
use crate::model::places;
use crate::predict::disturbances::DisturbanceModel;
use crate::predict::local_disturbance::{LocalDisturbance, costs};
use railgrip_vehicle::effects::Term;
use rayon::prelude::*;

/// What is freed, in the order of the report: on all wheelsets together, on each by itself.
const PLACES: [(Place, bool, bool); 8] = [
    (Place::BodyForce, true, false),
    (Place::WheelTorque, true, true),
    (Place::PadFriction, true, true),
    (Place::Adhesion, true, false),
    (Place::DriveTorque, true, false),
    (Place::SpeedSensor, true, false),
    (Place::WheelSensor, true, true),
    (Place::WheelScale, false, true),
];

/// The places of the wagon of a case. Where couplers push the body, what else does is not to be told from them.
fn places_of(case: &Case) -> Vec<(Place, Scope)> {
    let wheelsets = case.wheelsets();
    let of = |(place, together, alone): (Place, bool, bool)| {
        let each = (0..if alone { wheelsets } else { 0 }).map(Scope::One);
        together.then_some(Scope::All).into_iter().chain(each).map(move |scope| (place, scope))
    };
    let told = |(place, ..): &(Place, bool, bool)| !(case.is_coupled() && *place == Place::BodyForce);
    PLACES.into_iter().filter(told).flat_map(of).collect()
}
/// Amplitudes tried, relative to the size of a change that matters.
const AMPLITUDES: [f64; 5] = [0.3, 1.0, 3.0, 10.0, 30.0];
/// Correlation time at which amplitudes are tried, s.
const TIME_S: f64 = 1.0;
/// Further correlation times, s.
const TIMES_S: [f64; 2] = [0.1, 10.0];

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

/// How much of a case is looked at, and in what pieces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretches {
    /// Length of the stretches whose costs are kept apart, s.
    pub length_s: f64,
    /// Share of them that is not counted: those that gain most.
    pub event_share: f64,
}

/// Frees every place in turn; the most likely first.
pub fn localise(
    case: &Case,
    built: &Built,
    disturbances: &DisturbanceModel,
    stretches: Stretches,
) -> Vec<PlaceEvidence> {
    let cost = |freed: &LocalDisturbance| costs(case, built, disturbances, freed, stretches.length_s);
    let nothing = cost(&LocalDisturbance::nothing());
    let free = |&(place, scope): &(Place, Scope)| {
        let (freed, freed_costs) = likeliest(place, scope, &cost);
        let evidence = evidence(&nothing, &freed_costs, stretches.event_share);
        PlaceEvidence { place, scope, evidence, amplitude: freed.amplitude, time_s: freed.time_s }
    };
    let mut all: Vec<PlaceEvidence> = places_of(case).par_iter().map(free).collect();
    all.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    all
}

/// The likeliest disturbance at a place on the grid of amplitudes and times, and its cost by stretch.
fn likeliest(
    place: Place,
    scope: Scope,
    cost: &impl Fn(&LocalDisturbance) -> Vec<f64>,
) -> (LocalDisturbance, Vec<f64>) {
    let scale = place.scale().0;
    let try_one = |step: usize, time_s: f64| {
        let freed = LocalDisturbance { place, scope, amplitude: AMPLITUDES[step] * scale, time_s };
        let costs = cost(&freed);
        (costs.iter().sum::<f64>(), step, freed, costs)
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
    (best.2, best.3)
}

/// What is gained over all stretches but a share `event_share` of them, those that gain most: a wheelset at the edge between
/// holding and sliding may fall either way, and a filter that lost it there gains by whatever is freed.
pub(crate) fn evidence(nothing: &[f64], freed: &[f64], event_share: f64) -> f64 {
    lasting(nothing.iter().zip(freed).map(|(a, b)| a - b).collect(), event_share)
}

/// The same from what is gained in each stretch.
pub(crate) fn lasting(mut gains: Vec<f64>, event_share: f64) -> f64 {
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

/// What freeing a place gains beside the named effects, as a share of what it gained without them, or of what they gain themselves
/// where that is more: a filter that tolerates their error has little to gain from freeing any place.
pub fn share_left(before: &[PlaceEvidence], beside: &[PlaceEvidence], gained: f64) -> f64 {
    let best = |places: &[PlaceEvidence]| places.first().map_or(0.0, |w| w.evidence.max(0.0));
    best(beside) / best(before).max(gained).max(1.0)
}

/// Whether an effect of a term may show where freeing a place gained most.
pub fn may_act_at(term: Term, likely: &[PlaceEvidence]) -> bool {
    likely.iter().any(|place| places::of(term).contains(&place.place))
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
