//! Tests of the judging train.

mod balance;
mod behaviour;
mod family;
mod faults;

use super::{FaultWish, Journey, Reading, TrainOrder, TrainSpec, Truth};

/// One sample of a whole train.
pub(super) struct Sample {
    pub time_s: f64,
    pub order: f64,
    pub onset: bool,
    pub readings: Vec<Reading>,
    pub truths: Vec<Truth>,
}

/// Draws a train to an order that no test gets wrong.
pub(super) fn drawn(seed: u64, order: &TrainOrder<'_>) -> TrainSpec {
    TrainSpec::draw_to(seed, order).expect("a sound order")
}

/// A healthy train of a family.
pub(super) fn healthy(seed: u64, family: &str, wagons: Option<usize>, hours: f64) -> TrainSpec {
    let order = TrainOrder {
        family: Some(family),
        wagons,
        hours,
        rate_hz: 20.0,
        fault: FaultWish::None,
        ..TrainOrder::default()
    };
    let mut spec = drawn(seed, &order);
    spec.line.low.clear();
    spec
}

/// All samples of a day.
pub(super) fn run(spec: TrainSpec) -> Vec<Sample> {
    let mut journey = Journey::new(spec);
    let mut samples = Vec::new();
    while journey.advance() {
        samples.push(Sample {
            time_s: journey.truths()[0].time_s,
            order: journey.brake_ordered(),
            onset: journey.onset_s().is_some(),
            readings: journey.readings().to_vec(),
            truths: journey.truths().to_vec(),
        });
    }
    samples
}

/// Makes a rail of one friction, everywhere and always.
pub(super) fn on_rail(mut spec: TrainSpec, friction: f64) -> TrainSpec {
    (spec.weather.dry, spec.weather.wet) = (friction, friction);
    spec.weather.wetness = vec![(0.0, 0.0)];
    spec.line.low.clear();
    spec
}

/// Mean of what is there; `None` of nothing.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    (count > 0.0).then(|| sum / count)
}
