//! Pads and drag, from creepage against its own past and beside the others.

use super::limits::{
    AHEAD, ALONE, CLEARER, DRAGS, DRAGS_ALONE, DRAGS_BEYOND, HELD_ROLLS, NEIGHBOURS, ONE_DID, PADS,
    PADS_GONE, PEERS, REST_UNKNOWN, SHOWS, SLIPS, WITHOUT_PAST,
};
use super::{deviation, shift, without_strongest};
use crate::cause::{Cause, Grade};
use crate::creepage::{Braked, Change};
use crate::grip::{self, NEW_BETWEEN, NEW_WITHIN, Since, Usual};
use crate::robust::spread;
use crate::watch::{TrainWatch, Wagon};

impl TrainWatch {
    /// Creepage while rolling free: what holds a wheelset back.
    pub(crate) fn judge_rolls(&mut self) {
        let wheels = || self.wagons.iter().flat_map(|wagon| &wagon.wheel);
        let usual = spread(wheels().filter_map(|wheel| Some(wheel.rolled.last()?.value)), 8);
        let beyond = DRAGS.0.min(DRAGS_BEYOND * usual);
        let mut accused: Vec<(usize, Vec<usize>, f64)> = Vec::new();
        for index in 0..self.wagons.len() {
            let wagon = &self.wagons[index];
            if self.book.open(index).any(|cause| cause != Cause::Dragging && cause.explains(Cause::Dragging))
            {
                continue;
            }
            let shifts: Vec<Option<Change>> = wagon
                .wheel
                .iter()
                .map(|wheel| shift(&wheel.rolled, 2).filter(|_| stays(&wheel.rolled)))
                .collect();
            let drags = |k: usize| {
                let change = shifts[k].as_ref().filter(|it| it.value < beyond && deviation(it) < DRAGS.1);
                let again = |_: &&Change| {
                    without_strongest(&wagon.wheel[k].rolled).is_some_and(|it| deviation(&it) < 0.5 * DRAGS.1)
                };
                change.filter(again).map(|it| it.value).or_else(|| self.held_since(index, k))
            };
            let trusted = (0..wagon.wheel.len()).filter(|k| self.trusts(index, *k));
            let held: Vec<(usize, f64)> = trusted.filter_map(|k| Some((k, drags(k)?))).collect();
            if self.one_is_fast(index, &held) {
                continue;
            }
            if !held.is_empty() {
                let strongest = held.iter().map(|(_, by)| -by).fold(0.0, f64::max);
                let held = held.into_iter().map(|(k, _)| k).collect();
                accused.push((index, held, strongest / wagon.file.compliance_per_n));
                continue;
            }
            let alone = shift(&wagon.balance_rolled, 2);
            if let Some(alone) = alone.filter(|it| it.value < DRAGS_ALONE.0 && deviation(it) < DRAGS_ALONE.1)
            {
                let most = |k: &usize| shifts[*k].as_ref().map_or(0.0, deviation);
                let mut likely: Vec<usize> = (0..wagon.wheel.len()).collect();
                likely.sort_by(|a, b| most(a).total_cmp(&most(b)));
                // The balance tells of the wagon only; where creepage does not tell which, both are named.
                let clear = likely.len() < 2 || most(&likely[0]) < most(&likely[1]) - CLEARER;
                likely.truncate(if clear { 1 } else { 2 });
                let force_n = -alone.value * 9.81 * wagon.file.mass_kg;
                let reason = format!("rolls as if held back by {:.1} kN since lately", 1e-3 * force_n);
                self.suspect(Cause::Dragging, (index, likely), (Grade::Act, 0.8, 1), &[], reason);
            }
        }
        self.tell_held(&accused);
    }

    /// Creepage by which a wheelset is held back since some roll, where a single roll says too little: negative.
    fn held_since(&self, index: usize, k: usize) -> Option<f64> {
        let since = self.wagons[index].wheel[k].rest.lost(HELD_ROLLS, REST_UNKNOWN)?;
        let tells = since.past >= 2 && since.change.value < DRAGS.0;
        if !tells || since.sigmas() > DRAGS.1 || since.without > 0.5 * DRAGS.1 {
            return None;
        }
        // Beyond what the others changed by in as many rolls.
        let wheels = self.wagons.iter().flat_map(|wagon| &wagon.wheel);
        let usual = spread(wheels.filter_map(|it| Some(it.rest.latest(since.count, REST_UNKNOWN)?.value)), 8);
        (since.change.value < DRAGS_BEYOND * usual).then_some(since.change.value)
    }

    /// Whether one wheelset runs ahead of the others by more than they stay behind: nothing drives a wheel that rolls, so that it is
    /// its tachometer or its size, and the others only seem held back.
    fn one_is_fast(&self, index: usize, held: &[(usize, f64)]) -> bool {
        let wheels = &self.wagons[index].wheel;
        let behind = held.iter().map(|(_, by)| -by).fold(0.0, f64::max);
        let ahead = wheels.iter().filter_map(|wheel| Some(wheel.rest.latest(1, REST_UNKNOWN)?.value));
        wheels.len() > 2 && behind > 0.0 && ahead.fold(0.0, f64::max) > AHEAD * behind
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
            .filter(|index| {
                // Whose pads of a wagon they are may still be told.
                self.book.open(*index).all(|cause| cause == Cause::PadLow || !cause.explains(Cause::PadLow))
            })
            .filter(|index| (0..self.wagons[*index].wheel.len()).all(|k| self.trusts(*index, k)))
            .filter_map(|index| Some((index, self.pads_of(index, &usual)?)))
            .collect();
        // Several at once: the rail or the couplers did it, and nobody's pads.
        let strongest = accused.iter().min_by(|a, b| a.1.sigmas.total_cmp(&b.1.sigmas));
        let Some((index, accusation)) = strongest else { return };
        let rivals =
            accused.iter().any(|(other, one)| other != index && one.sigmas < ALONE * accusation.sigmas);
        if rivals {
            return;
        }
        let Accusation { cause, wheelsets, how, instead, reason, .. } = accusation.clone();
        self.suspect(cause, (*index, wheelsets), how, &[instead], reason);
    }

    /// How far pads of the train lie from one another: most are well.
    fn usual_pads(&self) -> Apart {
        let wheels = self.wagons.iter().flat_map(|wagon| &wagon.wheel);
        Apart {
            between: grip::apart(self.wagons.iter().map(|wagon| &wagon.grip), 4).max(NEW_BETWEEN),
            within: grip::apart(wheels.map(|wheel| &wheel.grip), 8).max(NEW_WITHIN),
        }
    }

    fn pads_of(&self, index: usize, usual: &Apart) -> Option<Accusation> {
        let wagon = &self.wagons[index];
        let alone = wagon.balance.is_some();
        let stands_out = |since: &Since| {
            since.change.value < PADS.0 && since.sigmas() < PADS.1 && since.without < 0.5 * PADS.1
        };
        let couplers_did = |since: &Since| since.level.min(since.change.value) <= PADS_GONE;
        // Load presses the contact flat and stiff, so that an unknown load looks like other pads.
        let new = Usual::pads((0.67 * wagon.file.mass_sigma).hypot(usual.between));
        // A driven wagon tells nothing of its own level, only of its change.
        let known = |since: &Since| since.past > 0 || (since.count >= WITHOUT_PAST && !wagon.drives);
        let whole = wagon.grip.lost(2, new).filter(stands_out).filter(|since| alone || known(since));
        let whole = whole.filter(|since| !couplers_did(since) && !self.neighbours_as_well(index, since, new));
        let within = Usual::pads(usual.within);
        let lost = |k: usize| wagon.wheel[k].grip.lost(2, within);
        // One wheelset of a wagon that runs alone takes its share of the wagon's braking with it.
        let count = wagon.wheel.len() as f64;
        let shows_in_balance = |since: &Since| {
            let seen = wagon.grip.latest(since.count, new).filter(|_| alone);
            seen.is_none_or(|seen| seen.value < SHOWS.0 / count && seen.sigmas() < SHOWS.1)
        };
        let single = |k: usize| {
            let since = lost(k).filter(stands_out)?;
            if (since.past == 0 && since.count < WITHOUT_PAST) || !shows_in_balance(&since) {
                return None;
            }
            // Two wheelsets of a wagon that lose together are led by the rail: what is glazed is glazed alone.
            let alike = |it: &Since| it.level < 0.4 * since.level && it.sigmas() < -2.5;
            let others = || (0..wagon.wheel.len()).filter(|other| *other != k);
            let alone = others().all(|other| !lost(other).as_ref().is_some_and(alike));
            // One that creeps more by as much as this one creeps less is nearer to sliding: the others only seem to have lost.
            let more = |other: usize| {
                let since = wagon.wheel[other].grip.latest(since.count, within)?;
                Some(since.value)
            };
            let most = others().filter_map(more).fold(0.0, f64::max);
            let slips = wagon.wheel.len() > 2 && most > SLIPS * -since.change.value;
            (alone && !slips && !self.peers_as_well(index, k, &since, within)).then_some((k, since))
        };
        let worst =
            (0..wagon.wheel.len()).filter_map(single).min_by(|a, b| a.1.sigmas().total_cmp(&b.1.sigmas()));
        // A wagon grips less also where one wheelset does: what that does not explain, of the same applications, is its own.
        let own = |whole: &Since, (k, since): &(usize, Since)| {
            let lately = wagon.wheel[*k].grip.latest(whole.count, within).filter(|_| since.past == 0);
            let one = lately.unwrap_or(since.change);
            let own = Change {
                value: whole.change.value - one.value / count,
                variance: whole.change.variance + one.variance / (count * count),
            };
            own.value < PADS.0 && own.sigmas() < PADS.1
        };
        if let Some((k, since)) = worst.filter(|one| whole.is_none_or(|whole| !own(&whole, one))) {
            return Some(uneven(k, &since));
        }
        let whole = whole?;
        // Whether a loss of all of them explains how they differ, or that of one.
        let one_did = |k: &usize| {
            let Some(seen) = wagon.wheel[*k].grip.lost(1, within) else { return false };
            let lost = (count * whole.change.value).max(-1.0);
            let off = |expected: f64| (seen.change.value - expected).powi(2) / seen.change.variance;
            0.5 * (off(0.0) - off(lost)) > ONE_DID
        };
        let told_apart = |k: usize| wagon.wheel[k].grip.lost(1, within).map_or(0.0, |seen| seen.sigmas());
        let first = (0..wagon.wheel.len()).min_by(|a, b| told_apart(*a).total_cmp(&told_apart(*b)));
        match first.filter(one_did).filter(|_| count > 1.0) {
            Some(k) => Some(uneven_by(k, count, &whole)),
            None => {
                Some(low(wagon, &whole, first.is_some_and(|k| wagon.wheel[k].grip.lost(1, within).is_some())))
            }
        }
    }

    /// Whether the wagons next to one have come to grip less in as many applications, too.
    fn neighbours_as_well(&self, index: usize, since: &Since, usual: Usual) -> bool {
        let (reach, share, sigmas) = NEIGHBOURS;
        let near = index.saturating_sub(reach)..(index + reach + 1).min(self.wagons.len());
        let others = near.filter(|other| *other != index);
        let changes = others.filter_map(|other| self.wagons[other].grip.latest(since.count, usual));
        lost_as_well(changes, since, (share, sigmas))
    }

    /// Whether the same wheelset of the other wagons that drive as this one does, or do not, has come to creep less as well: a body that
    /// pitches and wheels that clean the rail for those behind do the same to each wagon, and on a wet rail it shows.
    fn peers_as_well(&self, index: usize, k: usize, since: &Since, usual: Usual) -> bool {
        let own = &self.wagons[index];
        let alike = |it: &Wagon| it.drives == own.drives && it.wheel.len() == own.wheel.len();
        let peers = self.wagons.iter().enumerate().filter(|(other, it)| *other != index && alike(it));
        lost_as_well(peers.filter_map(|(_, it)| it.wheel[k].grip.latest(since.count, usual)), since, PEERS)
    }
}

/// Whether others have lost as well, all in all: this share of a loss, and so many sigmas.
fn lost_as_well(others: impl Iterator<Item = Change>, since: &Since, (share, sigmas): (f64, f64)) -> bool {
    weighted(others).is_some_and(|all| all.value < share * since.change.value && all.sigmas() < sigmas)
}

/// What may be wrong with the pads of a wagon.
#[derive(Debug, Clone)]
struct Accusation {
    cause: Cause,
    wheelsets: Vec<usize>,
    how: (Grade, f64, u32),
    instead: (Cause, f64),
    /// The change over its sigma.
    sigmas: f64,
    reason: String,
}

/// Spread of pads: of wagons beside the train and of wheelsets beside their wagon, relative: load, couplers, the rail and all
/// that nobody knows.
#[derive(Debug, Clone, Copy)]
struct Apart {
    between: f64,
    within: f64,
}

/// Pads of one wheelset have changed, or are far from the others.
fn uneven(k: usize, since: &Since) -> Accusation {
    // On a curve that bends, force that is missing takes more creepage with it than its share: the size is not told beyond this.
    let most = since.level.min(since.change.value) < PADS_GONE;
    let reason = match since.past {
        0 if most => "grips less than half as well as the others of the wagon".to_owned(),
        _ if most => "grips less than half as well as it used to, the others do not".to_owned(),
        0 => format!("grips {:.0} % of what the others of the wagon do", 100.0 * (1.0 + since.level)),
        _ => format!("grips {:.0} % less than it used to, the others do not", -100.0 * since.change.value),
    };
    Accusation {
        cause: Cause::PadUneven,
        wheelsets: vec![k],
        how: (Grade::Watch, 0.87, 1),
        instead: (Cause::PadLow, 0.1),
        sigmas: since.sigmas(),
        reason,
    }
}

/// The pads of a wagon have lost so much, which those of one wheelset have done of its `count`.
fn uneven_by(k: usize, count: f64, whole: &Since) -> Accusation {
    let percent = -100.0 * (count * whole.change.value).max(-1.0);
    Accusation {
        cause: Cause::PadUneven,
        wheelsets: vec![k],
        how: (Grade::Watch, 0.7, 1),
        instead: (Cause::PadLow, 0.25),
        sigmas: whole.sigmas(),
        reason: format!("the wagon grips less than it used to, as if this wheelset did by {percent:.0} %"),
    }
}

/// All pads of a wagon have changed: for good, or the more the longer it brakes.
/// `told_apart`: its wheelsets tell how they differ.
fn low(wagon: &Wagon, since: &Since, told_apart: bool) -> Accusation {
    let braked: Vec<Braked> = match wagon.balance.is_some() {
        true => wagon.balance_braked.clone(),
        false => wagon.wheel.iter().flat_map(|wheel| wheel.braked.iter().rev().take(3)).copied().collect(),
    };
    let trend = weighted(braked.iter().map(|braked| braked.trend));
    let change = since.change.value;
    let fades = trend.is_some_and(|trend| deviation(&trend) < -3.5 && 12.0 * trend.value < 0.5 * change);
    let percent = -100.0 * change;
    let (cause, other, how) = match fades {
        false if !told_apart => (Cause::PadLow, (Cause::PadUneven, 0.25), (Grade::Watch, 0.7, 1)),
        true => (Cause::BrakeFade, (Cause::PadLow, 0.3), (Grade::Watch, 0.65, 1)),
        false => (Cause::PadLow, (Cause::BrakeFade, 0.25), (Grade::Watch, 0.7, 1)),
    };
    let reason = match (fades, since.past) {
        (true, _) => format!("grips {percent:.0} % less than it used to, the longer the less"),
        (_, 0) => format!("all pads grip {:.0} % of what those of the train do", 100.0 * (1.0 + since.level)),
        _ if !told_apart => format!(
            "the pads grip {percent:.0} % less than they used to; an application without the electric brake would tell which"
        ),
        _ => format!("all pads grip {percent:.0} % less than they used to"),
    };
    Accusation { cause, wheelsets: vec![], how, instead: other, sigmas: since.sigmas(), reason }
}

/// Whether each of the latest rolls shows that something holds the wheelset back, and one before did not: slack that runs out does
/// so once, and what has always been so is not known well yet.
fn stays(changes: &[Change]) -> bool {
    let Some((past, latest)) = changes.len().checked_sub(3).map(|from| changes.split_at(from)) else {
        return false;
    };
    let least = latest.iter().map(|change| change.value).fold(f64::INFINITY, f64::min);
    latest.iter().all(|change| change.value < 0.5 * DRAGS.0)
        && past.iter().any(|change| change.value > 0.3 * least)
}

/// Mean by weight.
fn weighted(changes: impl Iterator<Item = Change>) -> Option<Change> {
    let (weight, sum) = changes
        .fold((0.0, 0.0), |(weight, sum), one| (weight + 1.0 / one.variance, sum + one.value / one.variance));
    (weight > 0.0).then(|| Change { value: sum / weight, variance: 1.0 / weight })
}
