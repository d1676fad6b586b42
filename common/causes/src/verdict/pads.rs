//! Pads and drag, from creepage against its own past and beside the others.

use super::limits::{DRAGS, DRAGS_ALONE, DRAGS_BEYOND, PADS, PADS_APART, PADS_GONE};
use super::{deviation, mean, shift};
use crate::cause::{Cause, Grade};
use crate::creepage::{Braked, Change};
use crate::robust::median;
use crate::split::spread;
use crate::watch::{TrainWatch, Wagon, Wheel};

impl TrainWatch {
    /// Creepage while rolling free: what holds a wheelset back.
    pub(crate) fn judge_rolls(&mut self) {
        let wheels = || self.wagons.iter().flat_map(|wagon| &wagon.wheel);
        let usual = spread(wheels().filter_map(|wheel| Some(wheel.rolled.last()?.value)), 8);
        let beyond = DRAGS.0.min(DRAGS_BEYOND * usual);
        let mut accused: Vec<(usize, Vec<usize>, f64)> = Vec::new();
        for index in 0..self.wagons.len() {
            let wagon = &self.wagons[index];
            if self.book.open(index).is_some_and(|cause| cause != Cause::Dragging) {
                continue;
            }
            let shifts: Vec<Option<Change>> = wagon
                .wheel
                .iter()
                .map(|wheel| shift(&wheel.rolled, 2).filter(|_| stays(&wheel.rolled)))
                .collect();
            let drags = |(k, change): (usize, &Option<Change>)| {
                let held = change.as_ref().is_some_and(|it| it.value < beyond && deviation(it) < DRAGS.1);
                held.then_some(k).filter(|k| self.trusts(index, *k))
            };
            let held: Vec<usize> = shifts.iter().enumerate().filter_map(drags).collect();
            if !held.is_empty() {
                let strongest =
                    held.iter().filter_map(|k| shifts[*k]).map(|it| -it.value).fold(0.0, f64::max);
                accused.push((index, held, strongest / wagon.file.compliance_per_n));
                continue;
            }
            let alone = shift(&wagon.balance_rolled, 2);
            if let Some(alone) = alone.filter(|it| it.value < DRAGS_ALONE.0 && deviation(it) < DRAGS_ALONE.1)
            {
                let most = |k: &usize| shifts[*k].as_ref().map_or(0.0, deviation);
                let first = (0..wagon.wheel.len()).min_by(|a, b| most(a).total_cmp(&most(b))).unwrap_or(0);
                let force_n = -alone.value * 9.81 * wagon.file.mass_kg;
                let reason = format!("rolls as if held back by {:.1} kN since lately", 1e-3 * force_n);
                self.suspect(Cause::Dragging, (index, vec![first]), (Grade::Act, 0.8, 1), &[], reason);
            }
        }
        self.tell_held(&accused);
    }

    fn tell_held(&mut self, accused: &[(usize, Vec<usize>, f64)]) {
        for (index, held, force_n) in accused {
            // Neighbours that are held back in the same roll are so by their couplers.
            if accused.iter().any(|(other, ..)| other.abs_diff(*index) == 1) {
                continue;
            }
            let wagon = &self.wagons[*index];
            let reason = format!("rolls as if held back by {:.1} kN since lately", 1e-3 * force_n);
            let grade = if *force_n > 0.01 * 9.81 * wagon.file.mass_kg / wagon.wheel.len() as f64 {
                Grade::Act
            } else {
                Grade::Watch
            };
            self.suspect(Cause::Dragging, (*index, held.clone()), (grade, 0.9, 1), &[], reason);
        }
    }

    /// Creepage in braking: what the pads do.
    pub(crate) fn judge_pads(&mut self) {
        let usual = self.usual_pads();
        let accused: Vec<(usize, Accusation)> = (0..self.wagons.len())
            .filter(|index| self.book.open(*index).is_none())
            .filter(|index| (0..self.wagons[*index].wheel.len()).all(|k| self.trusts(*index, k)))
            .filter_map(|index| Some((index, self.pads_of(index, &usual)?)))
            .collect();
        // Several at once: the rail or the couplers did it, and nobody's pads.
        let [(index, accusation)] = &accused[..] else { return };
        let Accusation { cause, wheelsets, how, instead, reason } = accusation.clone();
        self.suspect(cause, (*index, wheelsets), how, &[instead], reason);
    }

    /// Pads of the train, of which most are well.
    fn usual_pads(&self) -> Usual {
        let frictions: Vec<f64> = self
            .wagons
            .iter()
            .filter_map(|wagon| mean(wagon.wheel.iter().map(|wheel| wheel.creepage.friction())))
            .map(|friction| friction.value)
            .collect();
        let train = median(&mut frictions.clone());
        let ratios = self.wagons.iter().flat_map(|wagon| {
            let friction: Vec<Change> = wagon.wheel.iter().map(|wheel| wheel.creepage.friction()).collect();
            (0..friction.len()).filter_map(move |k| Some(beside(&friction, k)?.0)).collect::<Vec<_>>()
        });
        Usual { train, between: spread(frictions.iter().copied(), 4) / train, within: spread(ratios, 8) }
    }

    fn pads_of(&self, index: usize, usual: &Usual) -> Option<Accusation> {
        let wagon = &self.wagons[index];
        let stands_out = |change: &Change| change.value < PADS.0 && deviation(change) < PADS.1;
        let level =
            |wheel: &Wheel| shift(&wheel.braked.iter().map(|braked| braked.level).collect::<Vec<_>>(), 3);
        if let Some(own) = wagon_shift(wagon).filter(stands_out)
            && own.value > PADS_GONE
            && wagon.wheel.iter().all(|wheel| level(wheel).is_none_or(|it| it.value < 0.4 * own.value))
        {
            return Some(low(wagon, own.value));
        }
        let changed = |k: usize| {
            let changes = &wagon.wheel[k].braked_beside;
            Some((k, shift(changes, 3).filter(|change| stands_out(change) && persists(changes))?.value))
        };
        let worst = (0..wagon.wheel.len()).filter_map(changed).min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((k, change)) = worst.filter(|(_, change)| *change > PADS_GONE) {
            let percent = -100.0 * change;
            return Some(Accusation {
                cause: Cause::PadUneven,
                wheelsets: vec![k],
                how: (Grade::Watch, 0.87, 1),
                instead: (Cause::PadLow, 0.1),
                reason: format!("grips {percent:.0} % of nominal less than it used to, the others do not"),
            });
        }
        self.apart(index, usual)
    }

    /// Without a past: pads far from those beside them.
    fn apart(&self, index: usize, usual: &Usual) -> Option<Accusation> {
        let wagon = &self.wagons[index];
        let known = |wheel: &Wheel| wheel.applications >= 3;
        if !wagon.wheel.iter().all(known) || wagon.wheel.len() < 2 {
            return None;
        }
        let far = |ratio: f64, sigma: f64| {
            (PADS_GONE + 1.0..PADS_APART.0).contains(&ratio) && (ratio - 1.0) / sigma < PADS_APART.1
        };
        let friction: Vec<Change> = wagon.wheel.iter().map(|wheel| wheel.creepage.friction()).collect();
        for k in 0..friction.len() {
            let Some((ratio, sigma)) = beside(&friction, k) else { continue };
            if far(ratio, sigma.hypot(usual.within)) {
                return Some(Accusation {
                    cause: Cause::PadUneven,
                    wheelsets: vec![k],
                    how: (Grade::Watch, 0.8, 2),
                    instead: (Cause::PadLow, 0.1),
                    reason: format!("grips {:.0} % of what the others of the wagon do", 100.0 * ratio),
                });
            }
        }
        let own = mean(friction.iter().copied())?;
        let ratio = own.value / usual.train;
        // Load presses the contact flat and stiff, so that an unknown load looks like other pads.
        let unknown = (0.67 * wagon.file.mass_sigma).hypot(usual.between);
        let sigma = (own.variance.sqrt() / usual.train).hypot(unknown);
        (self.wagons.len() >= 4 && far(ratio, sigma)).then(|| Accusation {
            cause: Cause::PadLow,
            wheelsets: vec![],
            how: (Grade::Watch, 0.7, 2),
            instead: (Cause::BrakeFade, 0.2),
            reason: format!("all pads grip {:.0} % of what those of the train do", 100.0 * ratio),
        })
    }
}

/// What may be wrong with the pads of a wagon.
#[derive(Debug, Clone)]
struct Accusation {
    cause: Cause,
    wheelsets: Vec<usize>,
    how: (Grade, f64, u32),
    instead: (Cause, f64),
    reason: String,
}

/// Pads of the train: their middle over nominal, and the spread of wagons beside it and of wheelsets beside their wagon,
/// relative: load, couplers, the rail and all that nobody knows.
#[derive(Debug, Clone, Copy)]
struct Usual {
    train: f64,
    between: f64,
    within: f64,
}

/// Pads of a wheelset over those of the others of its wagon, with the sigma of that.
fn beside(friction: &[Change], k: usize) -> Option<(f64, f64)> {
    let others = (0..friction.len()).filter(|other| *other != k).map(|other| friction[other]);
    let rest = mean(others)?;
    let sigma = friction[k].variance.sqrt().hypot(rest.variance.sqrt()) / rest.value;
    Some((friction[k].value / rest.value, sigma))
}

/// All pads of a wagon have changed: for good, or the more the longer it brakes.
fn low(wagon: &Wagon, change: f64) -> Accusation {
    let braked: Vec<Braked> = match wagon.balance.is_some() {
        true => wagon.balance_braked.clone(),
        false => wagon.wheel.iter().flat_map(|wheel| wheel.braked.iter().rev().take(3)).copied().collect(),
    };
    let trend = weighted(braked.iter().map(|braked| braked.trend));
    let fades = trend.is_some_and(|trend| deviation(&trend) < -3.5 && 12.0 * trend.value < 0.5 * change);
    let percent = -100.0 * change;
    let (cause, other, how) = match fades {
        true => (Cause::BrakeFade, (Cause::PadLow, 0.3), (Grade::Watch, 0.65, 1)),
        false => (Cause::PadLow, (Cause::BrakeFade, 0.25), (Grade::Watch, 0.7, 1)),
    };
    let reason = match fades {
        true => format!("grips {percent:.0} % of nominal less than it used to, the longer the less"),
        false => format!("all pads grip {percent:.0} % of nominal less than they used to"),
    };
    Accusation { cause, wheelsets: vec![], how, instead: other, reason }
}

/// Change of the pads of a whole wagon: by its balance where it runs alone, else by the creepage of its wheelsets.
fn wagon_shift(wagon: &Wagon) -> Option<Change> {
    let levels = match wagon.balance.is_some() {
        true => wagon.balance_braked.iter().map(|braked| braked.level).collect(),
        false => wagon.braked.clone(),
    };
    shift(&levels, 3).filter(|_| persists(&levels))
}

/// Whether each of the latest rolls shows that something holds the wheelset back: slack that runs out does so once.
fn stays(changes: &[Change]) -> bool {
    changes.len() >= 3 && changes.iter().rev().take(3).all(|change| change.value < 0.5 * DRAGS.0)
}

/// Whether each of the latest changes shows it: one wild application makes no worn pad.
fn persists(changes: &[Change]) -> bool {
    changes.len() >= 3 && changes.iter().rev().take(3).all(|change| change.value < 0.6 * PADS.0)
}

/// Mean by weight.
fn weighted(changes: impl Iterator<Item = Change>) -> Option<Change> {
    let (weight, sum) = changes
        .fold((0.0, 0.0), |(weight, sum), one| (weight + 1.0 / one.variance, sum + one.value / one.variance));
    (weight > 0.0).then(|| Change { value: sum / weight, variance: 1.0 / weight })
}
