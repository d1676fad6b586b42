//! Learning how probable findings are, from reports on cases of which it is known what was at work.

use crate::answer::schema::{FoundEffect, PosteriorSet, Report, Verdict};
use crate::decide::holds::{Held, Holds, Lean, Signs};
use crate::decide::posterior::Calibration;
use crate::decide::scaling::{Grounds, Scaling, grounds};
use crate::decide::sets::{WhenWrong, fewest};
use crate::decide::spread::{Judged, Spread};
use crate::decide::test_run::TestWeights;
use railgrip_vehicle::effects;
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
    /// True values of parameters that mean the same in the plant and in the library.
    pub values: Vec<TrueValue>,
}

/// The true value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueValue {
    /// Id of its effect.
    pub effect: String,
    /// Its name in the library.
    pub parameter: &'static str,
    /// Value in the library's unit.
    pub value: f64,
}

impl Truth {
    /// Whether a set is what was at work.
    pub fn is(&self, set: &PosteriorSet) -> bool {
        let nothing = set.effects.is_empty() && !set.unknown;
        let says = set.unknown || !set.effects.is_empty();
        let at_work = says && set.effects.iter().all(|id| self.effects.contains(id));
        let whole = self.effects.iter().all(|id| set.effects.contains(id) || self.hidden.contains(id));
        (nothing && !self.visible) || (set.unknown == self.unknown && at_work && whole)
    }
}

/// A case with what was found and what was at work.
pub type Case = (Report, Truth);

/// Parts into which cases are dealt: each is told by what was learnt from the others.
const PARTS: usize = 5;
/// Widths of the priors that are tried, as shares of the widest.
const WIDTHS: [f64; 6] = [0.05, 0.1, 0.2, 0.3, 0.5, 1.0];

/// How wide the priors of what is learnt are: of names, and of what a verdict holds.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Widths {
    names: f64,
    lean: f64,
}

/// Learns a calibration from reports and what was at work in them. How far it may go from its prior, and from which sum of
/// probabilities sets hold the truth, is what tells cases best that were left out.
pub fn learn(cases: &[Case], provenance: String) -> Calibration {
    let widths = likeliest(cases);
    Calibration { set_level: level_apart(&parts(cases, widths)), ..with(cases, provenance, widths) }
}

/// How well cases agree with what is learnt from others of them, see [`agreement`]. Widths and level are those of [`learn`], so that
/// the share of sets that hold the truth is near the one wanted by its making.
pub fn agreement_apart(cases: &[Case]) -> Agreement {
    let apart = parts(cases, likeliest(cases));
    let level = level_apart(&apart);
    let settled = apart.into_iter().flat_map(|(mut learnt, others)| {
        learnt.set_level = level;
        others.into_iter().map(move |(mut report, truth)| {
            learnt.settle(&mut report);
            (report, truth)
        })
    });
    agreement(&settled.collect::<Vec<Case>>())
}

/// The level at which verdict sets hold the truth in nine of ten cases that were left out.
fn level_apart(apart: &[(Calibration, Vec<Case>)]) -> f64 {
    let posteriors: Vec<(Vec<PosteriorSet>, &Truth)> = apart
        .iter()
        .flat_map(|(learnt, others)| others.iter().map(|(report, truth)| (learnt.sets(report), truth)))
        .collect();
    level_that_holds(&posteriors, HELD)
}

/// What is learnt from all parts but one, and the cases of that one, for each.
fn parts(cases: &[Case], widths: Widths) -> Vec<(Calibration, Vec<Case>)> {
    let of = |part: usize| {
        let (held, others): (Vec<_>, Vec<_>) =
            cases.iter().cloned().enumerate().partition(|(index, _)| index % PARTS == part);
        let cases =
            |dealt: Vec<(usize, Case)>| dealt.into_iter().map(|(_, case)| case).collect::<Vec<Case>>();
        (with(&cases(others), String::new(), widths), cases(held))
    };
    (0..PARTS).map(of).collect()
}

/// The widths with which cases that were left out are likeliest.
fn likeliest(cases: &[Case]) -> Widths {
    let loss = |widths: Widths| {
        parts(cases, widths).iter().fold([0.0; 2], |[names, held], (learnt, others)| {
            let of_names = others.iter().flat_map(judged_names).map(|(grounds, right)| {
                let p = learnt.names.probability(&grounds);
                -(if right { p } else { 1.0 - p }).max(f64::MIN_POSITIVE).ln()
            });
            let of_held = others.iter().map(|(report, truth)| {
                -learnt.holds(report).shares()[class(report, truth)].max(f64::MIN_POSITIVE).ln()
            });
            [names + of_names.sum::<f64>(), held + of_held.sum::<f64>()]
        })
    };
    let losses: Vec<[f64; 2]> =
        WIDTHS.iter().map(|width| loss(Widths { names: *width, lean: *width })).collect();
    let best = |what: usize| {
        let order = |a: &usize, b: &usize| losses[*a][what].total_cmp(&losses[*b][what]);
        (0..WIDTHS.len()).min_by(order).map_or(1.0, |index| WIDTHS[index])
    };
    Widths { names: best(0), lean: best(1) }
}

/// Whether a name means an id.
fn means(effect: &FoundEffect, id: &String) -> bool {
    effect.id == *id || effect.equivalent.contains(id)
}

/// The names of a case by their grounds, and whether they were right.
fn judged_names((report, truth): &Case) -> Vec<(Grounds, bool)> {
    let of = |effect: &FoundEffect| {
        let right = truth.effects.iter().any(|id| means(effect, id));
        grounds(report, effect).map(|grounds| (grounds, right))
    };
    report.effects.iter().filter_map(of).collect()
}

/// A scaling with what it means for a name that its effects do not carry over, learnt from cases.
pub fn with_failing(scaling: &Scaling, cases: &[Case]) -> Scaling {
    scaling.with_failing(&cases.iter().flat_map(judged_names).collect::<Vec<(Grounds, bool)>>())
}

/// Learns how far fitted values lie from true ones, from cases in which some are known.
pub fn spread(cases: &[Case], provenance: String) -> Spread {
    Spread::fit(&cases.iter().flat_map(judged_values).collect::<Vec<Judged>>(), provenance)
}

/// How often 90 % intervals hold the true values that are known, and of how many.
pub fn values_held(cases: &[Case]) -> (usize, usize) {
    let judged: Vec<Judged> = cases.iter().flat_map(judged_values).collect();
    (judged.iter().filter(|one| one.is_held()).count(), judged.len())
}

/// The fitted values of a case whose true ones are known.
fn judged_values((report, truth): &Case) -> Vec<Judged> {
    let of = |known: &TrueValue| {
        let effect = report.effects.iter().find(|effect| effect.id == known.effect)?;
        let estimate = *effect.parameters.get(known.parameter)?;
        let (spec, _) = effects::find(&known.effect)?;
        let parameter = spec.parameters.iter().find(|parameter| parameter.name == known.parameter)?;
        Some(Judged { estimate, spec: parameter, truth: known.value })
    };
    truth.values.iter().filter_map(of).collect()
}

/// What a case held: nothing that shows, known effects, something unknown.
fn class(report: &Report, truth: &Truth) -> usize {
    let named = |id: &String| report.effects.iter().any(|effect| means(effect, id));
    match truth {
        // What was named rightly was seen after all.
        Truth { visible: false, effects, .. } if !effects.iter().any(named) => 0,
        Truth { unknown: true, .. } => 2,
        Truth { effects, .. } => usize::from(!effects.is_empty()),
    }
}

/// What is learnt with priors of these widths; sets are not looked at.
fn with(cases: &[Case], provenance: String, widths: Widths) -> Calibration {
    let mut wrong = [[1.0; 3]; 2];
    for (report, truth) in cases {
        let is_right = |effect: &FoundEffect| truth.effects.iter().any(|id| means(effect, id));
        let unnamed = || truth.effects.iter().filter(|id| !report.effects.iter().any(|e| means(e, id)));
        for (index, effect) in report.effects.iter().enumerate().filter(|(_, effect)| !is_right(effect)) {
            let rival = unnamed().any(|id| effect.rivals.iter().any(|rival| rival.id == *id));
            let what = if rival { 0 } else { 1 + usize::from(unnamed().next().is_some()) };
            wrong[usize::from(index > 0)][what] += 1.0;
        }
    }
    let when_wrong = |counts| {
        let [rival, nothing, other] = shares(counts);
        WhenWrong { rival, nothing, other }
    };
    let classes: Vec<(Verdict, Signs, usize)> = cases
        .iter()
        .map(|(report, truth)| (report.verdict, Signs::of(report), class(report, truth)))
        .collect();
    let verdicts: BTreeMap<String, Holds> =
        [Verdict::None, Verdict::Effects, Verdict::Unknown, Verdict::EffectsAndUnknown]
            .map(|verdict| (verdict.name().to_owned(), counted(verdict, &classes)))
            .into();
    let held = |(verdict, signs, class): &(Verdict, Signs, usize)| -> Option<Held> {
        Some((*verdicts.get(verdict.name())?, *signs, *class))
    };
    let places = Lean::fit(&classes.iter().filter_map(held).collect::<Vec<Held>>(), widths.lean);
    let names: Vec<(Grounds, bool)> = cases.iter().flat_map(judged_names).collect();
    Calibration {
        provenance: provenance.clone(),
        cases: cases.len(),
        set_level: HELD,
        names: Scaling::fit(&names, widths.names),
        fails_provenance: None,
        first_wrong: when_wrong(wrong[0]),
        further_wrong: when_wrong(wrong[1]),
        alone: scatter(cases),
        spread: spread(cases, provenance),
        tests: TestWeights::default(),
        places,
        verdicts,
    }
}

/// Cases in which nothing shows from which their scatter can be told.
const FEWEST_ALONE: usize = 10;

/// See [`Calibration::alone`].
fn scatter(cases: &[Case]) -> f64 {
    let nothing = cases.iter().filter(|(report, truth)| class(report, truth) == 0);
    let over: Vec<f64> = nothing.filter_map(|(report, _)| Some(report.gap.unexplained()?.ln())).collect();
    if over.len() < FEWEST_ALONE {
        return 0.0;
    }
    (over.iter().map(|over| over * over).sum::<f64>() / over.len() as f64).sqrt()
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

/// The least level, in steps of a hundredth, at which verdict sets hold the truth in this share of cases; the share itself where
/// none does, because the truth is often in no set that is listed.
fn level_that_holds(posteriors: &[(Vec<PosteriorSet>, &Truth)], share: f64) -> f64 {
    let held = |level: f64| {
        let holds = |(sets, truth): &&(Vec<PosteriorSet>, &Truth)| {
            fewest(sets, level).into_iter().any(|index| truth.is(&sets[index]))
        };
        posteriors.iter().filter(holds).count() as f64 / posteriors.len().max(1) as f64
    };
    (50..100).map(|percent| f64::from(percent) / 100.0).find(|level| held(*level) >= share).unwrap_or(share)
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
            values: Vec::new(),
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
                let truth = Truth {
                    effects: vec![truth.into()],
                    hidden: Vec::new(),
                    unknown: false,
                    visible: true,
                    values: Vec::new(),
                };
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
                let truth = Truth {
                    effects: Vec::new(),
                    hidden: Vec::new(),
                    unknown,
                    visible: unknown,
                    values: Vec::new(),
                };
                (report, truth)
            })
            .collect();
        let calibration = learn(&cases, "a test".into());
        cases.iter_mut().for_each(|(report, _)| calibration.settle(report));
        let agreement = agreement(&cases);
        println!("{agreement:?}");
        assert!(calibration.places.unknown > 0.3 && agreement.unknown_area > 0.85, "{agreement:?}");
    }
}
