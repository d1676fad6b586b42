//! Probabilities of sets of effects, from what a report found and how often such findings were right.
//!
//! The step from evidence to probability is meant to be fitted, not set: `railgrip gap calibrate` counts on cases of the truth plant how
//! often a verdict holds a known effect, an unknown one or none, and how often a name at a score is right. The result is
//! a small file with its provenance. [`Calibration::shipped`] is the one in the program, whose provenance says whether it was
//! learnt.
//!
//! # The model
//! * A named effect is right with the probability 1 / (1 + exp(−w·x)) (logistic regression), where x are its grounds: one, its
//!   score (log-odds of [`confidence`](crate::decide::confidence)), by how much the effects shrink the gap of runs that were
//!   not fitted and whether they leave it at least as it was, how many parameters it has to imitate others with, whether all that is
//!   named acts elsewhere than where freeing a place gains most, how near the next candidate comes to it, by how much the gap grows
//!   without it, and how much more than a right model the extended one leaves.
//! * Where it is wrong, one of its rivals is at work in its place, or nothing, or something that is not listed, with shares
//!   counted on the cases. Rivals share theirs by the square of how near they came.
//! * A verdict says with counted frequency that the truth holds none, known effects only, or an unknown one, and the evidence of
//!   the likeliest place and what is left of the gap lean it ([`holds`](crate::decide::holds)).

use crate::answer::schema::{FoundEffect, PosteriorSet, Report, Verdict};
use crate::decide::holds::{Holds, Lean, Signs};
use crate::decide::scaling::{Scaling, grounds};
use crate::decide::sets::{WhenWrong, add, fewest, options, without_names};
use crate::decide::spread::Spread;
use crate::decide::test_run::TestWeights;
use railgrip_vehicle::effects;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Sets below this probability are not listed.
const LEAST_LISTED: f64 = 0.01;

/// How findings become probabilities, and from which cases that was learnt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Which cases it was learnt from.
    pub provenance: String,
    /// Their number.
    pub cases: usize,
    /// Sum of probabilities from which the fewest likeliest sets hold the truth in nine of ten of those cases.
    pub set_level: f64,
    /// Names.
    pub names: Scaling,
    /// Which cases [`Scaling::fails`] was learnt from, where it was learnt alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fails_provenance: Option<String>,
    /// What is at work where the first name is wrong.
    pub first_wrong: WhenWrong,
    /// The same for further names.
    pub further_wrong: WhenWrong,
    /// How far gaps scatter around those that a right model would leave where nothing shows: RMS of the logarithm of their ratio.
    /// Zero where that was not learnt; then a gap excludes nothing.
    #[serde(default)]
    pub alone: f64,
    /// How the evidence of a place leans what the truth holds.
    #[serde(default)]
    pub places: Lean,
    /// How far fitted values lie from true ones beyond noise.
    #[serde(default)]
    pub spread: Spread,
    /// How far a test moves probabilities.
    #[serde(default)]
    pub tests: TestWeights,
    /// What the truth holds, by verdict.
    pub verdicts: BTreeMap<String, Holds>,
}

/// The calibration that is part of the program.
const SHIPPED: &str = include_str!("calibration.toml");

impl Calibration {
    /// The calibration that is part of the program.
    ///
    /// # Panics
    /// Never with the file as it is tested.
    #[expect(clippy::expect_used, reason = "the file is compiled in, and a test reads it")]
    pub fn shipped() -> Self {
        toml::from_str(SHIPPED).expect("the calibration that is part of the program")
    }

    /// Writes the probabilities of names and of sets into a report, and intervals that know of laws of another form. A name's
    /// probability is that it, or an id which the report calls equivalent, is at work.
    pub fn settle(&self, report: &mut Report) {
        let stated: Vec<f64> = self.of_names(report);
        for (effect, p) in report.effects.iter_mut().zip(stated) {
            effect.confidence = p;
            effect.p = Some(p);
            self.widen(effect);
        }
        report.posterior = self.sets(report);
        report.verdict_set = fewest(&report.posterior, self.set_level);
    }

    /// Widens the intervals of what was fitted.
    fn widen(&self, effect: &mut FoundEffect) {
        let Some((spec, _)) = effects::find(&effect.id) else { return };
        for parameter in spec.parameters {
            if let Some(estimate) = effect.parameters.get_mut(parameter.name) {
                self.spread.widen(estimate, parameter);
            }
        }
    }

    /// Probability that each name is right.
    fn of_names(&self, report: &Report) -> Vec<f64> {
        let of = |effect: &FoundEffect| {
            grounds(report, effect).map_or(effect.confidence, |grounds| self.names.probability(&grounds))
        };
        report.effects.iter().map(of).collect()
    }

    /// What the truth holds in view of a report.
    pub(super) fn holds(&self, report: &Report) -> Holds {
        let counted = self.verdicts.get(report.verdict.name()).unwrap_or(&Holds::EVEN);
        counted.leant(&self.places, &Signs::of(report))
    }

    /// Sets of effects and their probabilities, the likeliest first.
    pub fn sets(&self, report: &Report) -> Vec<PosteriorSet> {
        let holds = self.holds(report);
        let mut sets = match report.verdict {
            Verdict::Effects | Verdict::EffectsAndUnknown => self.around_names(report, holds),
            Verdict::None | Verdict::Unknown => without_names(report, holds),
        };
        self.doubt_tolerances(report, &mut sets);
        sets.sort_by(|a, b| b.p.total_cmp(&a.p).then_with(|| a.effects.cmp(&b.effects)));
        sets.retain(|set| set.p >= LEAST_LISTED);
        sets
    }

    /// Leaves tolerances alone the share of their probability that a gap of this size leaves them; something unknown has the rest.
    fn doubt_tolerances(&self, report: &Report, sets: &mut Vec<PosteriorSet>) {
        let Some(over) = report.gap.unexplained().filter(|_| self.alone > 0.0) else { return };
        let beyond = over.ln().max(0.0) / self.alone;
        let mut lost = 0.0;
        for set in sets.iter_mut().filter(|set| set.effects.is_empty() && !set.unknown) {
            let left = set.p * (-0.5 * beyond * beyond).exp();
            lost += set.p - left;
            set.p = left;
        }
        add(sets, PosteriorSet { effects: Vec::new(), unknown: true, p: lost });
    }

    /// Every name with its alternatives, independently of each other.
    fn around_names(&self, report: &Report, holds: Holds) -> Vec<PosteriorSet> {
        let mut sets: Vec<(Vec<String>, f64)> = vec![(Vec::new(), 1.0)];
        let stated = self.of_names(report);
        for (index, (effect, p)) in report.effects.iter().zip(stated).enumerate() {
            let wrong = if index == 0 { &self.first_wrong } else { &self.further_wrong };
            let options = options(effect, p, wrong);
            sets = sets
                .iter()
                .flat_map(|(ids, p)| {
                    options.iter().filter(|(id, _)| id.as_ref().is_none_or(|id| !ids.contains(id))).map(
                        move |(id, share)| {
                            (ids.iter().chain(id).cloned().collect::<Vec<String>>(), p * share)
                        },
                    )
                })
                .filter(|(_, p)| *p > 0.1 * LEAST_LISTED)
                .collect();
        }
        let something = 1.0 - holds.none;
        let unknown = holds.unknown / something.max(f64::MIN_POSITIVE);
        let mut all: Vec<PosteriorSet> =
            vec![PosteriorSet { effects: Vec::new(), unknown: false, p: holds.none }];
        for (mut effects, p) in sets {
            effects.sort();
            for (unknown, share) in [(false, 1.0 - unknown), (true, unknown)] {
                add(&mut all, PosteriorSet { effects: effects.clone(), unknown, p: p * share * something });
            }
        }
        all
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::answer::schema::{
        Candidate, Gap, HoldoutGap, Location, NaturalGap, ParameterEstimate, Rival, ThreeGaps,
    };

    pub(crate) fn named(id: &str, score: f64, rivals: &[(&str, f64)]) -> FoundEffect {
        FoundEffect {
            id: id.into(),
            term: "adhesion".into(),
            confidence: f64::NAN,
            p: None,
            score: Some(score),
            gap_grows_without: None,
            equivalent: Vec::new(),
            rivals: rivals.iter().map(|(id, share)| Rival { id: (*id).into(), share: *share }).collect(),
            parameters: BTreeMap::new(),
        }
    }

    pub(crate) fn report(verdict: Verdict, effects: Vec<FoundEffect>) -> Report {
        let candidate =
            |id: &str| Candidate { id: id.into(), fit_gap: 1.0, cv_gain: 0.1, p_value: 0.5, converged: true };
        Report {
            schema: String::new(),
            verdict,
            rule: String::new(),
            location: Location { term: None, signals: Vec::new(), regime: None, runs: Vec::new() },
            effects,
            posterior: Vec::new(),
            verdict_set: Vec::new(),
            carries_over: None,
            candidates: ["grade", "headwind"].map(candidate).to_vec(),
            gap: Gap {
                fit: ThreeGaps { nominal: 3.0, calibrated: 2.0, extended: 1.0 },
                holdout: HoldoutGap {
                    nominal: 3.0,
                    calibrated: 2.0,
                    extended: 1.0,
                    reduction: 0.5,
                    reduction_ci95: [0.4, 0.6],
                    by_signal: BTreeMap::new(),
                    worst_window: None,
                },
                natural: None,
            },
            unexplained: None,
            next_run: None,
            evidence: None,
            seconds: 0.0,
            notes: Vec::new(),
        }
    }

    #[test]
    fn probabilities_of_sets_are_a_distribution_and_the_verdict_set_is_the_fewest() {
        let calibration = Calibration::shipped();
        let names = || vec![named("a", 3.0, &[("c", 0.8), ("d", 0.2)]), named("b", 1.0, &[])];
        for (verdict, effects) in [
            (Verdict::Effects, names()),
            (Verdict::EffectsAndUnknown, names()),
            (Verdict::None, Vec::new()),
            (Verdict::Unknown, Vec::new()),
        ] {
            let mut report = report(verdict, effects);
            calibration.settle(&mut report);
            let sum: f64 = report.posterior.iter().map(|set| set.p).sum();
            assert!(sum <= 1.0 + 1e-12 && sum > 0.5, "{verdict:?}: {sum}");
            assert!(report.posterior.windows(2).all(|pair| pair[0].p >= pair[1].p));
            assert!(
                report
                    .effects
                    .iter()
                    .all(|e| (0.0..=1.0).contains(&e.confidence) && e.p == Some(e.confidence))
            );
            let held: f64 = report.verdict_set.iter().map(|index| report.posterior[*index].p).sum();
            let last = report.verdict_set.last().map_or(0.0, |index| report.posterior[*index].p);
            assert!(held - last < calibration.set_level, "{verdict:?}: one set too many");
        }
    }

    #[test]
    fn a_rival_that_came_near_is_the_first_alternative() {
        let mut report = report(Verdict::Effects, vec![named("a", 0.5, &[("c", 0.9), ("d", 0.3)])]);
        Calibration::shipped().settle(&mut report);
        let p = |id: &str| {
            report
                .posterior
                .iter()
                .filter(|set| set.effects == [id] && !set.unknown)
                .map(|set| set.p)
                .sum::<f64>()
        };
        assert!(p("a") > p("c") && p("c") > 5.0 * p("d"), "{:?}", report.posterior);
    }

    /// What a gap far beyond a right model's takes from tolerances alone goes to something unknown.
    #[test]
    fn tolerances_alone_do_not_make_a_large_gap() {
        let calibration = Calibration { alone: 0.1, ..Calibration::shipped() };
        let p = |verdict: Verdict, natural: f64| {
            let effects = if verdict == Verdict::None { Vec::new() } else { vec![named("a", -1.0, &[])] };
            let mut report = report(verdict, effects);
            report.gap.natural = Some(NaturalGap { fit: natural, holdout: Some(natural) });
            let sets = calibration.sets(&report);
            let of = |unknown: bool| {
                sets.iter()
                    .find(|set| set.effects.is_empty() && set.unknown == unknown)
                    .map_or(0.0, |set| set.p)
            };
            let sum: f64 = sets.iter().map(|set| set.p).sum();
            (of(false), of(true), sum)
        };
        for verdict in [Verdict::None, Verdict::Effects] {
            let (whole, large) = (p(verdict, 2.0), p(verdict, 1.0));
            assert!(whole.0 > 0.05 && large.0 < 0.01, "{verdict:?}: {whole:?} {large:?}");
            assert!(large.1 > whole.1 && large.2 < 1.0 + 1e-9, "{verdict:?}: {whole:?} {large:?}");
        }
    }

    /// A name whose effect does not carry over to runs that were not fitted is less probable once that was learnt.
    #[test]
    fn grounds_beside_the_score_count() {
        let learnt = Calibration {
            names: Scaling { carries: 4.0, freedom: -1.0, ..Scaling::PLAIN },
            ..Calibration::shipped()
        };
        let p = |reduction: f64, parameters: usize| {
            let mut effect = named("a", 1.0, &[]);
            let estimate = ParameterEstimate::new(1.0, [0.0, 2.0]);
            effect.parameters = (0..parameters).map(|number| (number.to_string(), estimate)).collect();
            let mut report = report(Verdict::Effects, vec![effect]);
            report.carries_over = Some(reduction > 0.0);
            report.gap.holdout.reduction = reduction;
            learnt.settle(&mut report);
            report.effects[0].confidence
        };
        assert!(p(0.8, 1) > p(0.1, 1) && p(0.1, 1) > p(-0.3, 1), "{} {}", p(0.8, 1), p(-0.3, 1));
        assert!(p(0.5, 1) > p(0.5, 6) && p(f64::NAN, 1).is_finite());
    }
}
