//! Learning how probable findings are, from reports on cases of which it is known what was at work.

use crate::answer::schema::{FoundEffect, PosteriorSet, Report, Verdict};
use crate::decide::holds::{Held, Holds, Lean, Signs};
use crate::decide::posterior::{Calibration, Grounds, Scaling, WhenWrong, fewest, grounds};
use serde::Serialize;
use std::collections::BTreeMap;

/// Share of the verdict sets that hold the truth.
const HELD: f64 = 0.9;

/// What was at work in a case whose report is known.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Effects of the library that were at work.
    pub effects: Vec<String>,
    /// Those of them that cannot be seen beside the others: a set is the truth with them or without.
    pub hidden: Vec<String>,
    /// Whether something else was.
    pub unknown: bool,
    /// Whether any of it could be seen at all.
    pub visible: bool,
}

impl Truth {
    fn is(&self, set: &PosteriorSet) -> bool {
        let nothing = set.effects.is_empty() && !set.unknown;
        let says = set.unknown || !set.effects.is_empty();
        let at_work = says && set.effects.iter().all(|id| self.effects.contains(id));
        let whole = self.effects.iter().all(|id| set.effects.contains(id) || self.hidden.contains(id));
        (nothing && !self.visible) || (set.unknown == self.unknown && at_work && whole)
    }
}

/// Learns a calibration from reports and what was at work in them.
pub fn learn(cases: &[(Report, Truth)], provenance: String) -> Calibration {
    let means = |effect: &FoundEffect, id: &String| effect.id == *id || effect.equivalent.contains(id);
    let mut names: Vec<(Grounds, bool)> = Vec::new();
    let mut wrong = [[1.0; 3]; 2];
    let mut classes: Vec<(Verdict, Signs, usize)> = Vec::new();
    for (report, truth) in cases {
        for (index, effect) in report.effects.iter().enumerate() {
            let further = usize::from(index > 0);
            let right = truth.effects.iter().any(|id| means(effect, id));
            names.extend(grounds(report, effect).map(|grounds| (grounds, right)));
            if !right {
                let unnamed =
                    || truth.effects.iter().filter(|id| !report.effects.iter().any(|e| means(e, id)));
                let rival = unnamed().any(|id| effect.rivals.iter().any(|rival| rival.id == *id));
                let what = if rival { 0 } else { 1 + usize::from(unnamed().next().is_some()) };
                wrong[further][what] += 1.0;
            }
        }
        let named = |id: &String| report.effects.iter().any(|effect| means(effect, id));
        let class = match truth {
            // What was named rightly was seen after all.
            Truth { visible: false, effects, .. } if !effects.iter().any(named) => 0,
            Truth { unknown: true, .. } => 2,
            Truth { effects, .. } => usize::from(!effects.is_empty()),
        };
        classes.push((report.verdict, Signs::of(report), class));
    }
    let when_wrong = |counts| {
        let [rival, nothing, other] = shares(counts);
        WhenWrong { rival, nothing, other }
    };
    let verdicts: BTreeMap<String, Holds> =
        [Verdict::None, Verdict::Effects, Verdict::Unknown, Verdict::EffectsAndUnknown]
            .map(|verdict| (verdict.name().to_owned(), counted(verdict, &classes)))
            .into();
    let held = |(verdict, signs, class): &(Verdict, Signs, usize)| -> Option<Held> {
        Some((*verdicts.get(verdict.name())?, *signs, *class))
    };
    let places = Lean::fit(&classes.iter().filter_map(held).collect::<Vec<Held>>());
    let mut calibration = Calibration {
        provenance,
        cases: cases.len(),
        set_level: HELD,
        names: Scaling::fit(&names),
        first_wrong: when_wrong(wrong[0]),
        further_wrong: when_wrong(wrong[1]),
        places,
        verdicts,
    };
    calibration.set_level = calibration.level_that_holds(cases, HELD);
    calibration
}

/// What the cases of a verdict held, half a case more of each, and the means of their signs.
fn counted(verdict: Verdict, classes: &[(Verdict, Signs, usize)]) -> Holds {
    let of = || classes.iter().filter(|(other, _, _)| *other == verdict);
    let [none, known, unknown] =
        shares([0, 1, 2].map(|class| 0.5 + of().filter(|(_, _, held)| *held == class).count() as f64));
    let mean = |sign: fn(&Signs) -> Option<f64>| {
        let signs: Vec<f64> = of().filter_map(|(_, signs, _)| sign(signs)).collect();
        signs.iter().sum::<f64>() / signs.len().max(1) as f64
    };
    Holds { none, known, unknown, place: mean(|signs| signs.place), left: mean(|signs| signs.left) }
}

/// Counts as shares.
fn shares(counts: [f64; 3]) -> [f64; 3] {
    let all: f64 = counts.iter().sum();
    counts.map(|count| count / all)
}

impl Calibration {
    /// The least level, in steps of a hundredth, at which verdict sets hold the truth in this share of cases; the share itself
    /// where none does, because the truth is often in no set that is listed.
    fn level_that_holds(&self, cases: &[(Report, Truth)], share: f64) -> f64 {
        let posteriors: Vec<(Vec<PosteriorSet>, &Truth)> =
            cases.iter().map(|(report, truth)| (self.sets(report), truth)).collect();
        let held = |level: f64| {
            let holds = |(sets, truth): &&(Vec<PosteriorSet>, &Truth)| {
                fewest(sets, level).into_iter().any(|index| truth.is(&sets[index]))
            };
            posteriors.iter().filter(holds).count() as f64 / posteriors.len().max(1) as f64
        };
        (50..100)
            .map(|percent| f64::from(percent) / 100.0)
            .find(|level| held(*level) >= share)
            .unwrap_or(share)
    }
}

/// How well the probabilities of some reports agree with what was at work.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Names that were given.
    pub names: usize,
    /// Expected calibration error of their probabilities: mean distance between stated and observed, in five bins.
    pub calibration_error: f64,
    /// Mean negative logarithm of the probability of what turned out, of names stated, nats; NaN without names. Probabilities
    /// are held a thousandth away from 0 and 1.
    pub log_loss: f64,
    /// How well their probabilities sort right names from wrong ones: the share of pairs in the right order; NaN without both.
    pub names_area: f64,
    /// Share of verdict sets that hold the truth.
    pub sets_hold: f64,
    /// Mean number of sets in a verdict set.
    pub mean_size: f64,
    /// How well the probability of something unknown sorts the cases that hold such from the others: the share of pairs of one of
    /// each in the right order (area under the curve of the receiver); NaN without both.
    pub unknown_area: f64,
}

/// Compares reports, settled with a calibration, with what was at work.
pub fn agreement(cases: &[(Report, Truth)]) -> Agreement {
    const BINS: usize = 5;
    let mut bins = [(0.0, 0.0, 0.0); BINS];
    let (mut right_names, mut wrong_names) = (Vec::new(), Vec::new());
    for (report, truth) in cases {
        for effect in &report.effects {
            let right = truth.effects.iter().any(|id| *id == effect.id || effect.equivalent.contains(id));
            if right { &mut right_names } else { &mut wrong_names }.push(effect.confidence);
            let bin = &mut bins[((effect.confidence * BINS as f64) as usize).min(BINS - 1)];
            *bin = (bin.0 + 1.0, bin.1 + effect.confidence, bin.2 + f64::from(u8::from(right)));
        }
    }
    let names: f64 = bins.iter().map(|bin| bin.0).sum();
    let error: f64 = bins.iter().map(|(_, stated, right)| (stated - right).abs()).sum();
    let holds = cases.iter().filter(|(report, truth)| {
        report.verdict_set.iter().filter_map(|index| report.posterior.get(*index)).any(|set| truth.is(set))
    });
    let number = cases.len().max(1) as f64;
    Agreement {
        names: names as usize,
        calibration_error: error / names.max(1.0),
        log_loss: log_loss(&right_names, &wrong_names),
        names_area: area(&right_names, &wrong_names),
        sets_hold: holds.count() as f64 / number,
        mean_size: cases.iter().map(|(report, _)| report.verdict_set.len()).sum::<usize>() as f64 / number,
        unknown_area: unknown_area(cases),
    }
}

/// See [`Agreement::unknown_area`].
fn unknown_area(cases: &[(Report, Truth)]) -> f64 {
    let stated =
        |report: &Report| -> f64 { report.posterior.iter().filter(|set| set.unknown).map(|set| set.p).sum() };
    let of = |unknown: bool| {
        let held = cases.iter().filter(move |(_, truth)| (truth.unknown && truth.visible) == unknown);
        held.map(|(report, _)| stated(report)).collect::<Vec<f64>>()
    };
    area(&of(true), &of(false))
}

/// Share of pairs of one of each in which that of `with` is larger; ties count half; NaN without both.
pub fn area(with: &[f64], without: &[f64]) -> f64 {
    let above = |p: &f64| -> f64 {
        without.iter().map(|other| if p > other { 1.0 } else { 0.5 * f64::from(u8::from(p == other)) }).sum()
    };
    with.iter().map(above).sum::<f64>() / (with.len() * without.len()) as f64
}

/// See [`Agreement::log_loss`].
fn log_loss(right: &[f64], wrong: &[f64]) -> f64 {
    const AWAY: f64 = 1e-3;
    let held = |p: f64| p.clamp(AWAY, 1.0 - AWAY);
    let sum: f64 = right.iter().map(|p| -held(*p).ln()).sum::<f64>()
        + wrong.iter().map(|p| -(1.0 - held(*p)).ln()).sum::<f64>();
    sum / (right.len() + wrong.len()) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decide::posterior::tests::{named, report};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    #[test]
    fn log_loss_and_area_are_those_of_the_book() {
        let (right, wrong) = ([0.9, 0.5], [0.5, 0.2]);
        let by_hand = -(0.9_f64.ln() + 0.5_f64.ln() + 0.5_f64.ln() + 0.8_f64.ln()) / 4.0;
        assert!((log_loss(&right, &wrong) - by_hand).abs() < 1e-12);
        // Of four pairs three are in order and one is a tie.
        assert_eq!(area(&right, &wrong), 0.875);
        assert!((log_loss(&[], &[1.0]) + 0.001_f64.ln()).abs() < 1e-9, "certain and wrong is not infinite");
        assert!(log_loss(&[], &[]).is_nan() && area(&right, &[]).is_nan());
    }

    #[test]
    fn a_set_is_the_truth_without_what_cannot_be_seen_beside_the_others() {
        let truth = Truth {
            effects: vec!["b".into(), "a".into()],
            hidden: vec!["a".into()],
            unknown: false,
            visible: true,
        };
        let is = |ids: &[&str], unknown: bool| {
            let effects = ids.iter().map(|id| (*id).to_owned()).collect();
            truth.is(&PosteriorSet { effects, unknown, p: 0.5 })
        };
        assert!(is(&["a", "b"], false) && is(&["b"], false));
        assert!(!is(&["a"], false) && !is(&["b", "c"], false) && !is(&["b"], true) && !is(&[], false));
    }

    /// A score that overstates is brought down to how often it was right, and the verdict sets then hold the truth.
    #[test]
    fn learning_makes_stated_probabilities_true() {
        let mut random = Pcg64Mcg::seed_from_u64(6);
        let mut cases: Vec<(Report, Truth)> = (0..400)
            .map(|_| {
                let right = random.random::<f64>() < 0.7;
                let effects = vec![named("a", 4.0, &[("c", 0.8)])];
                let truth = if right { "a" } else { "c" };
                let truth =
                    Truth { effects: vec![truth.into()], hidden: Vec::new(), unknown: false, visible: true };
                (report(Verdict::Effects, effects), truth)
            })
            .collect();
        let calibration = learn(&cases, "a test".into());
        cases.iter_mut().for_each(|(report, _)| calibration.settle(report));
        let agreement = agreement(&cases);
        println!("{agreement:?}");
        assert!(agreement.calibration_error < 0.03, "{agreement:?}");
        assert!(agreement.sets_hold >= 0.9, "{agreement:?}");
        assert_eq!(agreement.mean_size, 2.0);
        assert!(agreement.unknown_area.is_nan(), "no case holds something unknown");
    }

    /// Where nothing is named, a place that errs tells cases that hold something unknown from those that hold nothing.
    #[test]
    fn a_place_that_errs_sorts_what_is_unknown() {
        let mut random = Pcg64Mcg::seed_from_u64(7);
        let mut cases: Vec<(Report, Truth)> = (0..300)
            .map(|number| {
                let unknown = number % 4 == 0;
                let place = if unknown { 60.0 } else { 6.0 } * random.random::<f64>();
                let evidence = crate::decide::verdict::tests::NOTHING;
                let evidence = Some(crate::answer::schema::Evidence { place_evidence: place, ..evidence });
                let report = Report { evidence, ..report(Verdict::None, Vec::new()) };
                (report, Truth { effects: Vec::new(), hidden: Vec::new(), unknown, visible: unknown })
            })
            .collect();
        let calibration = learn(&cases, "a test".into());
        cases.iter_mut().for_each(|(report, _)| calibration.settle(report));
        let agreement = agreement(&cases);
        println!("{agreement:?}");
        assert!(calibration.places.unknown > 0.3 && agreement.unknown_area > 0.85, "{agreement:?}");
    }
}
