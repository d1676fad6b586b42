//! How often alerts of each cause were right: what their probability is made of.

use crate::cause::Cause;

/// Cause, alerts that named cause and wagon rightly, and all alerts of that cause: development decks of seeds 7101 to 7104 (390
/// trains, 273 train-hours at 20 Hz), the first three of which the thresholds were set on, and 7401 (161 trains, 113 train-hours).
const COUNTED: &[(Cause, u32, u32)] = &[
    (Cause::Dragging, 27, 27),
    (Cause::Isolated, 28, 28),
    (Cause::PadLow, 5, 7),
    (Cause::PadUneven, 5, 5),
    (Cause::BrakeFade, 1, 1),
    (Cause::SlowCylinder, 23, 23),
    (Cause::LateDistributor, 16, 16),
    (Cause::WspValve, 13, 16),
    (Cause::WheelFlat, 12, 12),
    (Cause::WheelDiameter, 15, 15),
    (Cause::TachometerEccentric, 13, 13),
    (Cause::TachometerLate, 15, 15),
    (Cause::TachometerDropout, 27, 27),
    (Cause::SpeedSensor, 27, 27),
    (Cause::PressureSensor, 12, 12),
    (Cause::LowAdhesion, 5, 5),
    (Cause::Payload, 9, 9),
    (Cause::Silent, 13, 13),
];
/// Before anything is counted: share that is right, and so many alerts' worth of it. 59 of 62 alerts were right on the deck of seed
/// 7104, which nothing had been set on when it was first run.
const BEFORE: (f64, f64) = (0.95, 8.0);
/// The same of pads, which are taken for one another more often than anything else: 11 of 13 alerts were right on all these decks.
const BEFORE_OF_PADS: (f64, f64) = (0.85, 4.0);

/// Probability that an alert of this cause is right; `None` where none was ever counted.
pub(super) fn probability(cause: Cause) -> Option<f64> {
    let (_, right, all) = COUNTED.iter().find(|(one, ..)| *one == cause)?;
    let of_pads = matches!(cause, Cause::PadLow | Cause::PadUneven | Cause::BrakeFade);
    let (share, weight) = if of_pads { BEFORE_OF_PADS } else { BEFORE };
    Some((f64::from(*right) + share * weight) / (f64::from(*all) + weight))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_wrong_more_often_is_less_probable_and_nothing_is_certain() {
        let of = |cause| probability(cause).expect("counted");
        assert!(of(Cause::PadLow) < of(Cause::WspValve) && of(Cause::WspValve) < of(Cause::Isolated));
        assert!((0.7..0.8).contains(&of(Cause::PadLow)), "what fades or is glazed is called low, too");
        assert!(
            Cause::ALL.iter().filter_map(|cause| probability(*cause)).all(|one| (0.5..0.99).contains(&one))
        );
        assert_eq!(probability(Cause::Clock), None);
    }
}
