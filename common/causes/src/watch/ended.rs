//! What is over: rolls and applications that have ended become changes of each wheelset against its own past.

use super::{MANY_WHEELSETS, TrainWatch};
use crate::creepage::{Belief, Braked, Change, Creepage, Rolled};
use crate::grip::{self, Grip};
use crate::robust::median;

/// Variance of a change of pad friction, over nominal, from which on it says nothing.
const LEAST_TELLING: f64 = 0.05;
/// Common change of creepage in braking from which on it is another rail.
const OTHER_RAIL: f64 = 0.08;
/// Changes of so many applications, or rolls, are kept.
const KEPT: usize = 10;
/// So many rolls are kept one by one, twenty minutes of them; older ones are merged.
const ROLLS_KEPT: usize = 30;
/// So long after an application cylinders are empty, and their falls are judged, s.
const FALLS_S: f64 = 60.0;

impl TrainWatch {
    /// What rolls that are over say: of all wheelsets, of each beside the others, and of the balance of a wagon that runs alone, which
    /// tells also where one that is held hard never coasts.
    pub(super) fn end_all_rolls(&mut self, interrupted: bool) {
        let balanced = self.end_rolls(interrupted);
        if self.end_rolls_beside(interrupted) || balanced {
            self.judge_rolls();
        }
    }

    /// Rolls that are over become changes; what is common to all wheelsets is the speed's, not theirs. Whether a balance of forces tells.
    fn end_rolls(&mut self, interrupted: bool) -> bool {
        let mut ended: Vec<(usize, usize, Change)> = Vec::new();
        let mut balanced = false;
        for (index, wagon) in self.wagons.iter_mut().enumerate() {
            for (k, wheel) in wagon.wheel.iter_mut().enumerate() {
                let Some(Rolled { change, alone }) = wheel.creepage.end_of_roll(interrupted) else {
                    continue;
                };
                wheel.at_rest = if change.variance <= 1e-6 { Some(alone.value) } else { wheel.at_rest };
                ended.push((index, k, change));
            }
            if let Some(Rolled { change, .. }) =
                wagon.balance.as_mut().and_then(|of| of.end_of_roll(interrupted))
            {
                keep(&mut wagon.balance_rolled, change);
                balanced = true;
                let small = change.value.abs() < 3.0 * change.variance.sqrt();
                wagon.balance.iter_mut().for_each(|of| of.settle(small));
            }
        }
        if ended.is_empty() {
            return balanced;
        }
        let common = common(
            ended.iter().filter(|(.., change)| change.variance <= 1e-6).map(|(.., change)| change.value),
        );
        for (index, k, _) in ended.iter().filter(|(.., change)| change.variance > 1e-6) {
            self.wagons[*index].wheel[*k].creepage.settle(true);
        }
        ended.retain(|(.., change)| change.variance <= 1e-6);
        ended.iter_mut().for_each(|(.., change)| change.value -= common);
        for (index, k, own) in &self.of_trusted(ended) {
            let wheel = &mut self.wagons[*index].wheel[*k];
            let small = own.value.abs() < 4.0 * own.variance.sqrt() || wheel.applications < 1;
            wheel.creepage.settle(small);
        }
        balanced
    }

    /// What wheelsets tell whose tachometers can be trusted; one that is late or rings says nothing of the others of its wagon
    /// either.
    fn of_trusted<T>(&mut self, ended: Vec<(usize, usize, T)>) -> Vec<(usize, usize, T)> {
        let (trusted, doubtful): (Vec<_>, Vec<_>) =
            ended.into_iter().partition(|(index, k, _)| self.trusts(*index, *k));
        for (index, k, _) in doubtful {
            self.wagons[index].wheel[k].creepage.settle(true);
        }
        trusted
    }

    /// The same of each wheelset beside the others of its wagon; whether any tells.
    fn end_rolls_beside(&mut self, interrupted: bool) -> bool {
        let mut any = false;
        for wheel in self.wagons.iter_mut().flat_map(|wagon| &mut wagon.wheel) {
            let Some(Rolled { change, alone }) = wheel.beside.end_of_roll(interrupted) else { continue };
            let small = change.value.abs() < 4.0 * change.variance.sqrt() || wheel.applications < 1;
            // Before the first application there is no past.
            if change.variance <= 1e-6 && wheel.trusted {
                any = true;
                keep(&mut wheel.rolled, change);
                wheel.rest.take_of(alone, ROLLS_KEPT);
            }
            wheel.beside.settle(small);
        }
        any
    }

    pub(super) fn trust_wheels(&mut self) {
        for index in 0..self.wagons.len() {
            let trusts: Vec<bool> =
                (0..self.wagons[index].wheel.len()).map(|k| self.trusts(index, k)).collect();
            let wheels = &mut self.wagons[index].wheel;
            // Beside other wheels a difference is another one.
            if wheels.iter().map(|wheel| wheel.trusted).ne(trusts.iter().copied()) {
                for (wheel, trusted) in wheels.iter_mut().zip(trusts) {
                    wheel.trusted = trusted;
                    wheel.beside = Creepage::new(Belief::BESIDE);
                    wheel.rolled.clear();
                    wheel.rest = Grip::default();
                }
            }
        }
    }

    /// What the application that has just ended says of pads, beside those next to them.
    fn take_grip(&mut self, ended: &[(usize, usize, Braked)]) {
        let tells = |(index, k, braked): &&(usize, usize, Braked)| {
            braked.alone.variance < LEAST_TELLING && self.trusts(*index, *k)
        };
        let known: Vec<_> =
            ended.iter().filter(tells).map(|(index, k, one)| (*index, *k, one.alone)).collect();
        // On a wet rail all creep more, the first wheelsets most: what differs then says little of pads.
        let alike = common(ended.iter().map(|(.., braked)| braked.level.value));
        let wetter = self.rails.take(known.iter().map(|(.., one)| one.value).collect());
        let wet = 0.7 * alike.abs().max(wetter);
        let wagons = grip::beside_train(&known);
        let mut wheels = Vec::new();
        for (index, wagon) in self.wagons.iter_mut().enumerate() {
            let mut looks: Vec<(usize, Change)> = Vec::new();
            for (k, wheel) in wagon.wheel.iter_mut().enumerate() {
                let Some(braked) = wheel.beside.end_of_braking() else { continue };
                wheel.beside.settle(true);
                if wheel.trusted && braked.alone.variance < LEAST_TELLING {
                    // Of what pads do on this rail: where all creep more, what one lacks makes more creepage, too.
                    let usual = (wheel.creepage.friction().value + alike).max(0.5);
                    // A rail that makes pads creep more does so with motors.
                    let wet = wet * (1.0 + braked.driven);
                    let Change { value, variance } = braked.alone;
                    looks.push((
                        k,
                        Change { value: value / usual, variance: (variance + wet * wet) / (usual * usual) },
                    ));
                }
            }
            wheels.extend(possible(looks).into_iter().map(|(k, look)| (index, k, look)));
        }
        let past = |index: usize, k: usize| self.wagons[index].wheel[k].grip.mean().map(|mean| mean.value);
        let within = grip::scatter(wheels.iter().map(|(index, k, look)| (look.value, past(*index, *k))), 8);
        let past = |index: usize| self.wagons[index].grip.mean().map(|mean| mean.value);
        let between = grip::scatter(wagons.iter().map(|(index, look)| (look.value, past(*index))), 4);
        for (index, k, look) in wheels {
            let variance = look.variance.max(within * within);
            self.wagons[index].wheel[k].grip.take(Change { variance, ..look });
        }
        if wagons.len() < 2 {
            return;
        }
        // No pads grip less than not at all: such a look is of something else.
        for (index, look) in wagons.into_iter().filter(|(_, look)| look.value > -1.0 - look.variance.sqrt()) {
            let variance = look.variance.max(between * between) + wet * wet;
            self.wagons[index].grip.take(Change { variance, ..look });
        }
    }

    pub(super) fn end_application(&mut self) {
        self.brakings += 1;
        let mut ended: Vec<(usize, usize, Braked)> = Vec::new();
        for (index, wagon) in self.wagons.iter_mut().enumerate() {
            for (k, wheel) in wagon.wheel.iter_mut().enumerate() {
                ended.extend(wheel.creepage.end_of_braking().map(|braked| (index, k, braked)));
            }
            if let Some(braked) = wagon.balance.as_mut().and_then(Creepage::end_of_braking) {
                keep(&mut wagon.balance_braked, braked);
                let level = braked.level;
                if braked.alone.variance < LEAST_TELLING {
                    wagon.grip.take(Change { value: braked.alone.value - 1.0, ..braked.alone });
                }
                if level.variance > LEAST_TELLING {
                    wagon.balance_braked.pop();
                }
                let small = level.value.abs() < (4.0 * level.variance.sqrt()).max(0.09);
                wagon.balance.iter_mut().for_each(|of| of.settle(small));
            }
        }
        self.take_grip(&ended);
        // The first applications say nothing: there is no past yet.
        let tells = |braked: &Braked| braked.level.variance < LEAST_TELLING;
        for (index, k, _) in ended.iter().filter(|(.., braked)| !tells(braked)) {
            self.wagons[*index].wheel[*k].creepage.settle(true);
        }
        ended.retain(|(.., braked)| tells(braked));
        // Where few of many wheelsets tell, what is common to all is not known, and no single one can be judged.
        let all: usize = self.wagons.iter().map(|wagon| wagon.wheel.len()).sum();
        if all >= MANY_WHEELSETS && ended.len() < MANY_WHEELSETS {
            for (index, k, _) in std::mem::take(&mut ended) {
                self.wagons[index].wheel[k].creepage.settle(true);
            }
        }
        let level = common(ended.iter().map(|(.., braked)| braked.level.value));
        let trend = common(ended.iter().map(|(.., braked)| braked.trend.value));
        // On a wet rail all creep more, the first wheelsets most: what differs then says little of pads.
        let wet = level.abs() * 0.7;
        for (.., braked) in &mut ended {
            braked.level.value -= level;
            braked.level.variance += wet * wet;
            braked.trend.value -= trend;
        }
        for (index, k, own) in &self.of_trusted(ended) {
            let wheel = &mut self.wagons[*index].wheel[*k];
            keep(&mut wheel.braked, *own);
            wheel.applications += 1;
            let small = own.level.value.abs() < (3.5 * own.level.variance.sqrt()).max(0.08);
            wheel.creepage.settle((small && level < OTHER_RAIL) || wheel.applications < 2);
            if level < -OTHER_RAIL {
                wheel.creepage.shift_friction(level);
            }
        }
        self.judge_application();
        self.falls_due_s = self.time_s + FALLS_S;
        for wagon in &mut self.wagons {
            wagon.pressure.end();
            wagon.timing.forget_trace();
        }
    }
}

/// Looks of one wagon as pads can make them: none grips less than not at all. Where one of several seems to, creepage grows that much
/// faster with force than it should, for all of the wagon. Where one creeps more by as much, or where of two it is not told which, one
/// slips and nothing is known of any.
fn possible(mut looks: Vec<(usize, Change)>) -> Vec<(usize, Change)> {
    let values = || looks.iter().map(|(_, look)| look.value);
    let (least, most) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
    let beyond = |(_, look): &(usize, Change)| look.value < -1.0 - look.variance.sqrt();
    let one_slips = looks.len() < 3 || most > -least;
    if one_slips && looks.iter().any(beyond) {
        return Vec::new();
    }
    let steeper = if looks.len() < 3 { 1.0 } else { (-least).max(1.0) };
    for (_, look) in &mut looks {
        look.value = (look.value / steeper).max(-1.0);
        look.variance /= steeper * steeper;
    }
    looks
}

/// What all wheelsets do alike; nothing where there are too few to tell.
fn common(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    if values.len() < MANY_WHEELSETS { 0.0 } else { median(&mut values) }
}

fn keep<T>(list: &mut Vec<T>, item: T) {
    if list.len() == KEPT {
        list.remove(0);
    }
    list.push(item);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(values: &[f64]) -> Vec<f64> {
        let looks = values.iter().map(|value| Change { value: *value, variance: 0.04 }).enumerate().collect();
        possible(looks).into_iter().map(|(_, look)| look.value).collect()
    }

    #[test]
    fn a_pad_that_seems_to_grip_less_than_not_at_all_shows_how_steep_the_curve_is() {
        assert_eq!(told(&[0.6, -1.8, 0.5, 0.7]), [0.6 / 1.8, -1.0, 0.5 / 1.8, 0.7 / 1.8]);
        assert_eq!(told(&[0.1, -0.3, 0.1, 0.1]), [0.1, -0.3, 0.1, 0.1]);
    }

    #[test]
    fn beside_one_that_slips_nothing_is_known() {
        assert!(told(&[4.2, -1.4, -1.4, -1.4]).is_empty() && told(&[1.6, -1.6]).is_empty());
        assert_eq!(told(&[1.1, -1.1]), [1.1, -1.0]);
    }
}
