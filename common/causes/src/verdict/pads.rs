//! Pads and drag, from creepage against its own past and beside the others.

use super::limits::{DRAGS, DRAGS_ALONE, PADS, PADS_APART};
use super::{deviation, mean, shift};
use crate::cause::{Cause, Grade};
use crate::creepage::{Braked, Change};
use crate::robust::median;
use crate::watch::TrainWatch;

impl TrainWatch {
    /// Creepage while rolling free: what holds a wheelset back.
    pub(crate) fn judge_rolls(&mut self) {
        for index in 0..self.wagons.len() {
            let wagon = &self.wagons[index];
            if self.book.open(index).is_some_and(|cause| cause != Cause::Dragging) {
                continue;
            }
            let shifts: Vec<Option<Change>> =
                wagon.wheel.iter().map(|wheel| shift(&wheel.rolled, 2)).collect();
            let drags = |(k, change): (usize, &Option<Change>)| {
                let held = change.as_ref().is_some_and(|it| it.value < DRAGS.0 && deviation(it) < DRAGS.1);
                held.then_some(k).filter(|k| self.trusts(index, *k))
            };
            let held: Vec<usize> = shifts.iter().enumerate().filter_map(drags).collect();
            if !held.is_empty() {
                let strongest =
                    held.iter().filter_map(|k| shifts[*k]).map(|it| -it.value).fold(0.0, f64::max);
                let force_n = strongest / wagon.file.compliance_per_n;
                let reason = format!("rolls as if held back by {:.1} kN since lately", 1e-3 * force_n);
                let grade = if force_n > 0.01 * 9.81 * wagon.file.mass_kg / wagon.wheel.len() as f64 {
                    Grade::Act
                } else {
                    Grade::Watch
                };
                self.suspect(Cause::Dragging, (index, held), (grade, 0.9, 1), &[], reason);
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
    }

    /// Creepage in braking: what the pads do.
    pub(crate) fn judge_pads(&mut self) {
        let frictions: Vec<f64> = self
            .wagons
            .iter()
            .filter_map(|wagon| mean(wagon.wheel.iter().map(|wheel| wheel.creepage.friction())))
            .map(|friction| friction.value)
            .collect();
        let train = median(&mut frictions.clone());
        for index in 0..self.wagons.len() {
            if self.book.open(index).is_some()
                || (0..self.wagons[index].wheel.len()).any(|k| !self.trusts(index, k))
            {
                continue;
            }
            let wheel = &self.wagons[index].wheel;
            let levels: Vec<Vec<Change>> =
                wheel.iter().map(|one| one.braked.iter().map(|braked| braked.level).collect()).collect();
            let shifts: Vec<Option<Change>> = levels.iter().map(|levels| shift(levels, 3)).collect();
            let stands_out = |change: &Change| change.value < PADS.0 && deviation(change) < PADS.1;
            let changed: Vec<usize> = (0..wheel.len())
                .filter(|k| shifts[*k].as_ref().is_some_and(stands_out) && persists(&levels[*k]))
                .collect();
            let rest = |k: usize| {
                mean((0..wheel.len()).filter(|other| *other != k).filter_map(|other| shifts[other]))
            };
            let alone = self.wagons[index].balance.is_some();
            let own = wagon_shift(&self.wagons[index].balance_braked, &levels, alone);
            let whole = own.as_ref().is_some_and(stands_out)
                && (0..wheel.len())
                    .all(|k| shifts[k].is_none_or(|it| it.value < 0.4 * own.map_or(0.0, |own| own.value)));
            if whole {
                self.tell_low(index, own.map_or(0.0, |own| own.value));
                continue;
            }
            if let Some(k) = changed.iter().copied().find(|k| {
                let (Some(own), Some(rest)) = (shifts[*k], rest(*k)) else { return false };
                own.value < 2.0 * rest.value.min(0.0) && own.value - rest.value < PADS.0
            }) {
                let percent = -100.0 * shifts[k].map_or(0.0, |it| it.value);
                let reason =
                    format!("grips {percent:.0} % of nominal less than it used to, the others do not");
                let instead = [(Cause::PadLow, 0.1)];
                let how = (Grade::Watch, 0.87, 1);
                self.suspect(Cause::PadUneven, (index, vec![k]), how, &instead, reason);
                continue;
            }
            self.judge_apart(index, train);
        }
    }

    fn tell_low(&mut self, index: usize, change: f64) {
        let wagon = &self.wagons[index];
        let braked: Vec<Braked> = match wagon.balance.is_some() {
            true => wagon.balance_braked.clone(),
            false => {
                wagon.wheel.iter().flat_map(|wheel| wheel.braked.iter().rev().take(3)).copied().collect()
            }
        };
        let trend = weighted(braked.iter().map(|braked| braked.trend));
        let fades = trend.is_some_and(|trend| deviation(&trend) < -3.5 && 12.0 * trend.value < 0.5 * change);
        let percent = -100.0 * change;
        if fades {
            let reason = format!("grips {percent:.0} % of nominal less than it used to, the longer the less");
            let instead = [(Cause::PadLow, 0.3)];
            self.suspect(Cause::BrakeFade, (index, vec![]), (Grade::Watch, 0.65, 1), &instead, reason);
        } else {
            let reason = format!("all pads grip {percent:.0} % of nominal less than they used to");
            let instead = [(Cause::BrakeFade, 0.25)];
            self.suspect(Cause::PadLow, (index, vec![]), (Grade::Watch, 0.7, 1), &instead, reason);
        }
    }

    /// Without a past: pads far from those beside them.
    fn judge_apart(&mut self, index: usize, train: f64) {
        let wagon = &self.wagons[index];
        let known = |wheel: &crate::watch::Wheel| wheel.applications >= 3;
        if !wagon.wheel.iter().all(known) || wagon.wheel.len() < 2 {
            return;
        }
        let friction: Vec<Change> = wagon.wheel.iter().map(|wheel| wheel.creepage.friction()).collect();
        for k in 0..friction.len() {
            let others = (0..friction.len()).filter(|other| *other != k).map(|other| friction[other]);
            let Some(rest) = mean(others) else { continue };
            let ratio = friction[k].value / rest.value;
            let sigma = friction[k].variance.sqrt().hypot(rest.variance.sqrt()) / rest.value;
            if ratio < PADS_APART.0 && (ratio - 1.0) / sigma < PADS_APART.1 {
                let reason = format!("grips {:.0} % of what the others of the wagon do", 100.0 * ratio);
                let how = (Grade::Watch, 0.8, 2);
                let instead = [(Cause::PadLow, 0.1)];
                self.suspect(Cause::PadUneven, (index, vec![k]), how, &instead, reason);
                return;
            }
        }
        let Some(own) = mean(friction.iter().copied()) else { return };
        let ratio = own.value / train;
        // Load presses the contact flat and stiff, so that an unknown load looks like other pads.
        let sigma = (own.variance.sqrt() / train).hypot(0.67 * wagon.file.mass_sigma);
        if self.wagons.len() >= 4 && ratio < PADS_APART.0 && (ratio - 1.0) / sigma < PADS_APART.1 {
            let reason = format!("all pads grip {:.0} % of what those of the train do", 100.0 * ratio);
            let instead = [(Cause::BrakeFade, 0.2)];
            self.suspect(Cause::PadLow, (index, vec![]), (Grade::Watch, 0.7, 2), &instead, reason);
        }
    }
}

/// Change of the pads of a whole wagon: by its balance where it runs alone, else by the creepage of its wheelsets.
fn wagon_shift(balance: &[Braked], levels: &[Vec<Change>], alone: bool) -> Option<Change> {
    if alone {
        let levels: Vec<Change> = balance.iter().map(|braked| braked.level).collect();
        return shift(&levels, 3).filter(|_| persists(&levels));
    }
    let count = levels.iter().map(Vec::len).min()?;
    let at = |back: usize| mean(levels.iter().map(|levels| levels[levels.len() - count + back]));
    let means: Vec<Change> = (0..count).filter_map(at).collect();
    shift(&means, 3).filter(|_| persists(&means))
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
