//! From comparisons to suspicions, each kind of evidence in a file of its own. Every threshold stands in [`limits`].

mod brakes;
mod calibration;
mod limits;
mod load;
mod pads;
mod rail;
mod sensors;

use crate::book::{Runner, Suspicion};
use crate::cause::{Cause, Grade};
use crate::creepage::Change;
use crate::robust::median;
use crate::watch::{MANY_WHEELSETS, TrainWatch};

/// The mean of the latest changes that stands out most, over its sigma; at least `least` of them.
fn shift(changes: &[Change], least: usize) -> Option<Change> {
    let (mut weight, mut sum) = (0.0, 0.0);
    let mut best: Option<Change> = None;
    for (index, change) in changes.iter().rev().enumerate() {
        weight += 1.0 / change.variance;
        sum += change.value / change.variance;
        let found = Change { value: sum / weight, variance: 1.0 / weight };
        let beats = |best: &Change| deviation(&found) < deviation(best);
        if index + 1 >= least && best.as_ref().is_none_or(beats) {
            best = Some(found);
        }
    }
    best
}

/// The same without the one that says most: one wild look is none.
fn without_strongest(changes: &[Change]) -> Option<Change> {
    let strength = |change: &Change| change.value / change.variance;
    let strongest =
        (0..changes.len()).min_by(|a, b| strength(&changes[*a]).total_cmp(&strength(&changes[*b])))?;
    let others: Vec<Change> = changes
        .iter()
        .enumerate()
        .filter(|(index, _)| *index != strongest)
        .map(|(_, change)| *change)
        .collect();
    shift(&others, 1)
}

/// A change over its sigma.
fn deviation(change: &Change) -> f64 {
    change.value / change.variance.sqrt()
}

impl TrainWatch {
    fn suspect(
        &mut self,
        cause: Cause,
        (wagon, wheelsets): (usize, Vec<usize>),
        (grade, probability, needed): (Grade, f64, u32),
        instead: &[(Cause, f64)],
        reason: String,
    ) {
        self.suspect_wagons(cause, (vec![wagon], wheelsets), (grade, probability, needed), instead, reason);
    }

    /// Two causes that what was seen does not tell from one another, the first no less likely; neither was counted by itself.
    fn suspect_either(
        &mut self,
        cause: Cause,
        other: Cause,
        (wagon, wheelsets): (usize, Vec<usize>),
        reason: String,
    ) {
        let (first, second) = limits::EITHER;
        self.raise(cause, (vec![wagon], wheelsets), (Grade::Watch, first, 2), &[(other, second)], reason);
    }

    fn suspect_wagons(
        &mut self,
        cause: Cause,
        place: (Vec<usize>, Vec<usize>),
        (grade, probability, needed): (Grade, f64, u32),
        instead: &[(Cause, f64)],
        reason: String,
    ) {
        let probability = calibration::probability(cause).unwrap_or(probability);
        self.raise(cause, place, (grade, probability, needed), instead, reason);
    }

    fn raise(
        &mut self,
        cause: Cause,
        (wagons, wheelsets): (Vec<usize>, Vec<usize>),
        (grade, probability, needed): (Grade, f64, u32),
        instead: &[(Cause, f64)],
        reason: String,
    ) {
        // What it may be instead shares what is left.
        let all: f64 = instead.iter().map(|(_, probability)| probability).sum();
        let part = ((1.0 - probability) / all.max(1e-9)).min(1.0);
        let instead = instead
            .iter()
            .map(|(cause, probability)| Runner { cause: *cause, probability: part * probability });
        let suspicion = Suspicion {
            cause,
            wagons,
            wheelsets,
            grade,
            probability,
            instead: instead.collect(),
            reason,
            needed,
        };
        self.book.suspect(suspicion, self.time_s, self.brakings);
    }

    /// Whether the tachometer of a wheelset can be trusted with what creepage says.
    pub(crate) fn trusts(&self, wagon: usize, k: usize) -> bool {
        let wheel = &self.wagons[wagon].wheel[k];
        let lag_s = wheel.rim.errors(false).1.map(|lag_s| lag_s - self.usual_lag_s());
        // A wrong scale that is known, and nothing that comes late, is no reason to ask no more.
        let known =
            || wheel.at_rest.is_some_and(|at_rest| (at_rest - wheel.creepage.radius()).abs() < limits::KNOWN);
        let in_time = || lag_s.is_some_and(|lag_s| lag_s.abs() < limits::LATE_DOUBTFUL_S);
        let hides =
            |cause: Cause| cause.is_of_wheel_speeds() && !(cause.is_of_scale() && known() && in_time());
        let open = self.book.open(wagon).any(hides);
        // A late tachometer shows too little speed while the train gathers it, as a dragging wheelset does.
        let late = lag_s.is_some_and(|lag_s| lag_s > limits::LATE_DOUBTFUL_S);
        let whole = wheel.tachometer.missing < 0.3
            && wheel.tachometer.stands_s <= 0.0
            && wheel.tachometer.largest < limits::RINGS_DOUBTFUL;
        !open && !late && whole
    }

    /// Lag of most wheels behind the speed of the train, s.
    fn usual_lag_s(&self) -> f64 {
        let wheels = self.wagons.iter().flat_map(|wagon| &wagon.wheel);
        let mut lags: Vec<f64> = wheels.filter_map(|wheel| wheel.rim.errors(false).1).collect();
        if lags.len() < MANY_WHEELSETS { 0.0 } else { median(&mut lags) }
    }
}
