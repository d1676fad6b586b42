//! Each wheelset beside the others of its wagon, second by second.
//!
//! Wheelsets of one wagon share its speed, whatever couplers and the speed of the train do, so that the difference of their
//! creepages is free of both: on long trains that is most of what is uncertain. What is learnt of the difference is learnt as of
//! creepage itself: radius, pad friction, lag, each less that of the others.

use crate::creepage::Creep;
use crate::input::MAX_WHEELSETS;

/// Creepages of the wheelsets of one wagon in one second; `None` where it does not tell.
pub(crate) type Creeps = [Option<Creep>; MAX_WHEELSETS];

/// Creepage of each wheelset less that of the others, of a second of one wagon; `None` of those that do not tell, and of all
/// where one does not whose tachometer `is_trusted`.
pub(crate) fn beside(creeps: &Creeps, is_trusted: &[bool]) -> Creeps {
    let mut besides: Creeps = [None; MAX_WHEELSETS];
    let trusted = || (0..is_trusted.len()).filter(|k| is_trusted[*k]);
    let told: Vec<(usize, Creep)> = trusted().filter_map(|k| Some((k, creeps[k]?))).collect();
    let others = told.len() as f64 - 1.0;
    // Wheels differ in radius: beside fewer others a difference is another one.
    if others < 1.0 || told.len() < trusted().count() {
        return besides;
    }
    let sum = |of: fn(&Creep) -> f64| told.iter().map(|(_, creep)| of(creep)).sum::<f64>();
    let (creepage, brake) = (sum(|one| one.creepage), sum(|one| one.brake));
    let (drive, variance) = (sum(|one| one.drive), sum(|one| one.variance));
    for (k, own) in &told {
        let beside = |own: f64, sum: f64| own - (sum - own) / others;
        // What differs in force is known from pressures and currents.
        let forced = beside(own.drive, drive) - beside(own.brake, brake);
        besides[*k] = Some(Creep {
            creepage: beside(own.creepage, creepage) - forced,
            brake: own.brake,
            drive: own.drive,
            rate: own.rate,
            variance: own.variance + (variance - own.variance) / (others * others),
        });
    }
    besides
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creepage::{Belief, Creepage};
    use crate::grip::{Grip, Usual};

    /// A wagon that is moved to and fro by its couplers: what that does to creepage is no change of its wheelsets.
    #[test]
    fn what_couplers_do_to_a_wagon_does_not_show_and_a_dragging_wheelset_does() {
        let mut wheels = vec![Creepage::new(Belief::BESIDE); 4];
        let rolls = |wheels: &mut Vec<Creepage>, held: f64| {
            for turn in 0..45 {
                let runs_in = 4e-4 * (0.2 * f64::from(turn)).sin();
                let creeps = std::array::from_fn(|k| {
                    let radius = [0.0, 1.1e-3, -0.7e-3, 0.4e-3][k];
                    let creepage = radius + runs_in - if k == 1 { held } else { 0.0 };
                    Some(Creep { creepage, brake: 0.0, drive: 0.0, rate: 0.0, variance: 4e-10 })
                });
                for (wheel, creep) in wheels.iter_mut().zip(beside(&creeps, &[true; 4])) {
                    wheel.take(&creep.expect("all tell"), 0.0);
                }
            }
            let changes: Vec<_> =
                wheels.iter_mut().filter_map(|wheel| Some(wheel.end_of_roll(false)?.change)).collect();
            wheels.iter_mut().for_each(|wheel| wheel.settle(true));
            changes
        };
        for _ in 0..4 {
            rolls(&mut wheels, 0.0);
        }
        let changes = rolls(&mut wheels, 1e-4);
        assert!(
            (changes[1].value + 1e-4).abs() < 2e-5 && changes[1].value / changes[1].variance.sqrt() < -4.0,
            "{changes:?}"
        );
        assert!([0, 2, 3].iter().all(|k| changes[*k].value > 0.0));
    }

    /// Drag of which each roll says one or two sigmas is learnt by a past that follows it; all rolls together tell it.
    #[test]
    fn drag_that_no_single_roll_tells_is_told_by_all_of_them() {
        let told = |held: f64| {
            let (mut wheel, mut rest) = (Creepage::new(Belief::BESIDE), Grip::default());
            let mut strongest = 0.0_f64;
            for roll in 0..28 {
                // Noise of a roll of a fixed pattern without mean, as large as it is declared.
                let noise = [6e-5, -6e-5, -3e-5, 3e-5][roll % 4];
                let by = if roll < 12 { 0.0 } else { held };
                for second in 0..40 {
                    let creepage = 1.1e-3 + noise - by + if second % 2 == 0 { 4e-4 } else { -4e-4 };
                    let creep = Creep { creepage, brake: 0.0, drive: 0.0, rate: 0.0, variance: 1.6e-7 };
                    wheel.take(&creep, 0.0);
                    if let Some(rolled) = wheel.end_of_roll(false) {
                        strongest = strongest.min(rolled.change.sigmas());
                        wheel.settle(rolled.change.sigmas().abs() < 4.0);
                        rest.take_of(rolled.alone, 30);
                    }
                }
            }
            (strongest, rest.lost(3, Usual::radii(0.02)).expect("rolls"))
        };
        let (strongest, since) = told(1.5e-4);
        assert!(strongest > -4.0, "each roll by itself: {strongest}");
        assert!(since.sigmas() < -6.0 && since.without < -3.0 && since.past >= 2, "{since:?}");
        assert!((since.change.value + 1.5e-4).abs() < 3e-5, "{since:?}");
        assert!(told(0.0).1.sigmas() > -3.0);
    }
}
