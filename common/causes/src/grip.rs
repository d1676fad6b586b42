//! How well pads grip, application by application: a wheelset beside the others of its wagon, a wagon beside its train.
//!
//! Each application measures pad friction anew, whatever was believed before. Evidence adds up over applications: the split into
//! before and since that says most is sought, and weighed by how well both sides are known. Before anything is known, pads are as
//! far from one another as new pads of this train are.

use crate::creepage::Change;
use crate::robust::{median, spread};

/// So many applications are kept one by one; older ones are merged.
const KEPT: usize = 12;
/// Relative spread of pads before anything is known, at least: of a wheelset beside its wagon, and of a wagon beside its train.
pub(crate) const NEW_WITHIN: f64 = 0.06;
pub(crate) const NEW_BETWEEN: f64 = 0.1;
/// Share by which a difference that has always been there comes and goes. Set by hand: of 700 trains (development seed 271131)
/// six healthy wagons were accused because they had differed by 0.3 to 1.0 all day, and then did so by half of it more or less.
const VARIES: f64 = 0.5;

/// So many wheelsets at least tell how dry a rail is, and so many applications are kept, of which the driest quarter counts. Hand-set.
const FEW_WHEELSETS: usize = 4;
const RAILS_KEPT: usize = 24;

/// Pads of a train grip at least so much, over nominal.
const LEAST_GRIP: f64 = 0.3;

/// What pads differ by in good health, one sigma each.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Usual {
    /// From those beside them, relative, before anything is known.
    pub apart: f64,
    /// From their own past, as a share of the difference that has always been there.
    pub varies: f64,
}

impl Usual {
    /// Of pads, which lie so far from one another.
    pub(crate) const fn pads(apart: f64) -> Self {
        Self { apart, varies: VARIES }
    }

    /// Of radii, which stay what they are.
    pub(crate) const fn radii(apart: f64) -> Self {
        Self { apart, varies: 0.0 }
    }
}

/// What applications said of one wheelset or one wagon: relative difference from those beside it; latest last.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Grip {
    looks: Vec<Change>,
}

/// A difference since some application.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Since {
    /// Relative difference from what was before, and what it is since from those beside it.
    pub change: Change,
    pub level: f64,
    /// The change over its sigma without the look that says most, before or since.
    pub without: f64,
    /// Looks before, and since.
    pub past: usize,
    pub count: usize,
}

impl Grip {
    pub(crate) fn take(&mut self, look: Change) {
        self.take_of(look, KEPT);
    }

    /// The same where so many looks are kept one by one.
    pub(crate) fn take_of(&mut self, look: Change, kept: usize) {
        if self.looks.len() >= kept {
            let first = self.looks.remove(0);
            let second = self.looks[0];
            let weight = 1.0 / first.variance + 1.0 / second.variance;
            let value = (first.value / first.variance + second.value / second.variance) / weight;
            self.looks[0] = Change { value, variance: 1.0 / weight };
        }
        self.looks.push(look);
    }

    /// Mean so far, and how well it is known.
    pub(crate) fn mean(&self) -> Option<Change> {
        (!self.looks.is_empty()).then(|| weighed(&self.looks))
    }

    /// Whether all numbers are.
    pub(crate) fn is_sound(&self) -> bool {
        self.looks.iter().all(|look| look.value.is_finite() && look.variance.is_finite())
    }

    /// The loss that stands out most: of the latest `least` looks or more, against those before and what is usual.
    pub(crate) fn lost(&self, least: usize, usual: Usual) -> Option<Since> {
        let sigmas = |from: usize| self.change(from, &self.looks[from..], usual).sigmas();
        let all = 0..=self.looks.len().checked_sub(least)?;
        let from = all.min_by(|a, b| sigmas(*a).total_cmp(&sigmas(*b)))?;
        // One wild look says nothing, be it since or before: a wheelset that once spun has not been held back ever since.
        let without = (0..self.looks.len()).map(|left_out| {
            let others = |range: std::ops::Range<usize>| -> Vec<Change> {
                range.filter(|index| *index != left_out).map(|index| self.looks[index]).collect()
            };
            let (before, after) =
                (others(0..if from >= 2 { from } else { 0 }), others(from..self.looks.len()));
            if after.is_empty() { 0.0 } else { change(before, &after, usual).sigmas() }
        });
        Some(Since {
            change: self.change(from, &self.looks[from..], usual),
            level: weighed(&self.looks[from..]).value,
            without: without.fold(f64::NEG_INFINITY, f64::max),
            past: from,
            count: self.looks.len() - from,
        })
    }

    /// What the latest `count` looks differ by from those before.
    pub(crate) fn latest(&self, count: usize, usual: Usual) -> Option<Change> {
        let from = self.looks.len().checked_sub(count)?;
        Some(self.change(from, &self.looks[from..], usual))
    }

    /// The mean of `after` less that of the looks before `from`.
    fn change(&self, from: usize, after: &[Change], usual: Usual) -> Change {
        // A single look before may be the wild one.
        change(if from >= 2 { self.looks[..from].to_vec() } else { Vec::new() }, after, usual)
    }
}

/// The mean of `after` less that of `before` and of new ones.
fn change(mut before: Vec<Change>, after: &[Change], usual: Usual) -> Change {
    before.push(Change { value: 0.0, variance: usual.apart * usual.apart });
    let (before, after) = (weighed(&before), weighed(after));
    // What has always differed does so by the rail, the load or the way the wagon runs, and changes with them.
    let varies = usual.varies * before.value;
    Change { value: after.value - before.value, variance: after.variance + before.variance + varies * varies }
}

impl Since {
    /// The change over its sigma.
    pub(crate) fn sigmas(&self) -> f64 {
        self.change.sigmas()
    }
}

/// Mean by weight.
fn weighed(looks: &[Change]) -> Change {
    let (weight, sum) = looks
        .iter()
        .fold((0.0, 0.0), |(weight, sum), one| (weight + 1.0 / one.variance, sum + one.value / one.variance));
    Change { value: sum / weight, variance: 1.0 / weight }
}

/// How much more wheelsets creep for their forces than on the driest rails of late: the nearer a rail is to its limit, the steeper its
/// curve, and the more creepage exaggerates what forces differ by.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Rails {
    /// Middle of all pad frictions over nominal as creepage shows them, application by application; latest last.
    middles: Vec<f64>,
}

impl Rails {
    /// Takes what creepage said of pads in one application; zero where too few say anything.
    pub(crate) fn take(&mut self, mut frictions: Vec<f64>) -> f64 {
        if frictions.len() < FEW_WHEELSETS {
            return 0.0;
        }
        let now = median(&mut frictions);
        if self.middles.len() == RAILS_KEPT {
            self.middles.remove(0);
        }
        self.middles.push(now);
        let mut driest = self.middles.clone();
        driest.sort_by(f64::total_cmp);
        (now - driest[(driest.len() - 1) / 4]).max(0.0)
    }

    /// Whether all numbers are.
    pub(crate) fn is_sound(&self) -> bool {
        self.middles.iter().all(|middle| middle.is_finite())
    }
}

/// Pad friction of wheelsets (wagon, wheelset, friction) in one application, those of one wagon in a row: of each wagon beside the
/// train, relative.
pub(crate) fn beside_train(known: &[(usize, usize, Change)]) -> Vec<(usize, Change)> {
    let whole = |of_wagon: &[(usize, usize, Change)]| {
        let count = of_wagon.len() as f64;
        let sum = |of: fn(&Change) -> f64| of_wagon.iter().map(|(.., one)| of(one)).sum::<f64>();
        let change = Change {
            value: sum(|one| one.value) / count,
            variance: sum(|one| one.variance) / (count * count),
        };
        (of_wagon[0].0, change)
    };
    let mut wagons: Vec<(usize, Change)> = known.chunk_by(|a, b| a.0 == b.0).map(whole).collect();
    let middle = median(&mut wagons.iter().map(|(_, one)| one.value).collect());
    // Of two, each is held against the other, which is not known better than itself.
    let beside = match wagons[..] {
        [(_, first), (_, second)] => vec![second, first],
        _ => vec![Change { value: middle, variance: 0.0 }; wagons.len()],
    };
    for ((_, one), beside) in wagons.iter_mut().zip(beside) {
        let train = beside.value.max(LEAST_GRIP);
        let value = one.value / train;
        *one = Change {
            value: value - 1.0,
            variance: (one.variance + value * value * beside.variance) / (train * train),
        };
    }
    wagons
}

/// How far looks lie from what their own past says, robustly: no look of this application is worth more than that. `None` of a
/// past counts as nothing.
pub(crate) fn scatter(looks: impl Iterator<Item = (f64, Option<f64>)>, least: usize) -> f64 {
    spread(looks.filter_map(|(now, past)| Some(now - past?)), least)
}

/// How far pads lie from one another: what their means differ by, less what the means themselves are uncertain by.
pub(crate) fn apart<'a>(grips: impl Iterator<Item = &'a Grip>, least: usize) -> f64 {
    let means: Vec<Change> = grips.filter_map(Grip::mean).collect();
    let seen = spread(means.iter().map(|mean| mean.value), least);
    let unknown = median(&mut means.iter().map(|mean| mean.variance).collect()).max(0.0);
    (seen * seen - unknown).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grip(values: &[f64], sigma: f64) -> Grip {
        let mut grip = Grip::default();
        values.iter().for_each(|value| grip.take(Change { value: *value, variance: sigma * sigma }));
        grip
    }

    #[test]
    fn looks_that_say_little_each_add_up_and_one_wild_look_does_not() {
        // None of these is four sigmas by itself.
        let glazed = grip(&[0.02, -0.03, 0.01, -0.31, -0.28, -0.33, -0.3], 0.1)
            .lost(2, Usual::pads(NEW_WITHIN))
            .expect("looks");
        assert!(glazed.sigmas() < -4.5 && glazed.without < -4.0 && glazed.past == 3, "{glazed:?}");
        assert!((glazed.change.value + 0.3).abs() < 0.04);
        let wild = grip(&[0.02, -0.03, 0.01, 0.02, -1.2, 0.01, 0.0], 0.1)
            .lost(2, Usual::pads(NEW_WITHIN))
            .expect("looks");
        assert!(wild.without > -1.5, "{wild:?}");
    }

    /// A wheel that once spun ran ahead of the others; it has not been held back since.
    #[test]
    fn one_wild_look_before_is_no_loss_since() {
        let spun = grip(&[0.0, 1.4, 0.01, -0.01, 0.0, 0.01], 0.1).lost(2, Usual::radii(0.5)).expect("looks");
        assert!(spun.sigmas() < -3.7 && spun.without > -1.85, "{spun:?}");
    }

    /// A wheelset that has always gripped less does so by more on another rail; one that was like the others has lost.
    #[test]
    fn what_has_always_differed_may_differ_by_more() {
        let lost = |before: f64| {
            let looks = [[before; 6], [before - 0.3; 6]].concat();
            grip(&looks, 0.1).lost(2, Usual::pads(0.5)).expect("looks").sigmas()
        };
        assert!(lost(0.0) < -4.0 && lost(-0.5) > -2.0, "{} {}", lost(0.0), lost(-0.5));
    }

    #[test]
    fn pads_lie_apart_by_what_is_not_uncertainty() {
        let alike: Vec<Grip> = [-0.2, 0.15, 0.25, -0.1, 0.05, -0.15].map(|value| grip(&[value], 0.2)).into();
        assert!(apart(alike.iter(), 4) < 0.12);
        let known: Vec<Grip> = [-0.2, 0.15, 0.25, -0.1, 0.05, -0.15].map(|value| grip(&[value], 0.02)).into();
        assert!(apart(known.iter(), 4) > 0.15);
    }

    #[test]
    fn without_a_past_new_pads_are_what_it_is_held_against() {
        let near = grip(&[-0.09; 6], 0.03).lost(2, Usual::pads(NEW_WITHIN)).expect("looks");
        let far = grip(&[-0.4; 6], 0.03).lost(2, Usual::pads(NEW_WITHIN)).expect("looks");
        assert!(near.sigmas() > -2.0 && far.sigmas() < -5.0 && far.past == 0, "{near:?} {far:?}");
    }

    #[test]
    fn of_two_wagons_each_is_held_against_the_other() {
        let one = |wagon, value| (wagon, 0, Change { value, variance: 0.01 });
        let beside = beside_train(&[one(1, 0.6), one(3, 1.0)]);
        assert!((beside[0].1.value + 0.4).abs() < 1e-9 && (beside[1].1.value - 0.667).abs() < 1e-3);
        assert!(beside[0].1.variance > 0.01 && beside[1].1.variance > beside[0].1.variance);
    }

    #[test]
    fn a_rail_is_wet_beside_the_driest_and_few_wheelsets_tell_nothing() {
        let mut rails = Rails::default();
        for _ in 0..6 {
            assert!(rails.take(vec![1.0, 0.9, 1.1, 1.02]) < 0.01);
        }
        // Rain that comes little by little and stays.
        let wet: Vec<f64> = (1..=12).map(|n| rails.take(vec![1.0 + 0.1 * f64::from(n); 6])).collect();
        assert!((wet[0] - 0.09).abs() < 1e-9 && wet[11] > 1.0, "{wet:?}");
        assert_eq!(rails.take(vec![3.0; 3]), 0.0);
    }

    #[test]
    fn old_looks_are_merged_and_go_on_counting() {
        let long = grip(&[[0.0; 20], [-0.3; 20]].concat()[10..30], 0.1);
        assert_eq!(long.looks.len(), KEPT);
        assert!(long.lost(2, Usual::pads(NEW_WITHIN)).is_some_and(|since| since.sigmas() < -6.0));
    }
}
