//! What a decision does in practice: the gap, which is what people want to see smaller, asked after the fits on windows.
//!
//! The table of [`verdict`](crate::decide::verdict) weighs the evidence of filters. A filter that allows for errors of the model
//! can be sure of what moves no gap, and see nothing of what makes a large one; the rules here are about both.

use crate::answer::schema::Verdict;
use crate::decide::criteria::{Criteria, VerdictLimits};
use crate::decide::verdict::{Decision, Missing, Rule};

/// What effects do to the gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Practice {
    /// Gap of the fitted runs with tolerances alone, and with the effects.
    pub fitted: [f64; 2],
    /// The same of the runs only predicted; `None` without such runs.
    pub held_out: Option<[f64; 2]>,
    /// As [`Self::held_out`], windows on the wrong side between holding and sliding counting little.
    pub predicted: Option<[f64; 2]>,
    /// By how much the effects change what is predicted of runs that were not fitted: RMS over the sigmas of the sensors.
    pub moved: f64,
    /// Gap with tolerances alone, and with the effects, in all runs but for the few windows that err most, see
    /// [`Localisation::event_share`](crate::decide::criteria::Localisation::event_share): a wheelset that slides in the model and held on the track is no effect.
    pub lasting: [f64; 2],
    /// The gap that a right model would leave on fitted and on predicted runs, see [`natural`](crate::predict::natural); the same twice
    /// without runs that are only predicted.
    pub natural: [f64; 2],
}

/// When a rule of this table decides.
type Holds = fn(&Practice, &VerdictLimits) -> bool;

/// The rules in their order: the verdict that each revises, the rule, and when it does.
pub static RULES: [(Verdict, Rule, Holds); 7] = [
    (
        Verdict::None,
        Rule {
            name: "gap_left",
            words: "Neither a candidate nor a free curve is beyond chance, but the gap is larger than tolerances and noise make it.",
            verdict: Verdict::Unknown,
            missing: Missing::BesideEffects,
        },
        |practice, limits| practice.lasting[0] > practice.unnatural(limits),
    ),
    (Verdict::Effects, NEXT_TO_NOTHING, |practice, limits| {
        practice.does_nothing(limits) && practice.calibrated() <= practice.unnatural(limits)
    }),
    (Verdict::Effects, NAMES_DO_NOTHING, Practice::does_nothing),
    (Verdict::EffectsAndUnknown, NEXT_TO_NOTHING, |practice, limits| {
        practice.does_nothing(limits) && practice.calibrated() <= practice.unnatural(limits)
    }),
    (Verdict::EffectsAndUnknown, NAMES_DO_NOTHING, Practice::does_nothing),
    (
        Verdict::Effects,
        Rule {
            name: "does_not_carry_over",
            words: "The effects explain the runs that were fitted and predict others no better than tolerances alone do, so something else is missing.",
            verdict: Verdict::EffectsAndUnknown,
            missing: Missing::BesideEffects,
        },
        Practice::stays,
    ),
    (
        Verdict::Effects,
        Rule {
            name: "gap_left_beside",
            words: "The effects gain more than chance, but they leave a gap that is larger than tolerances and noise make it.",
            verdict: Verdict::EffectsAndUnknown,
            missing: Missing::BesideEffects,
        },
        Practice::leaves_much,
    ),
];

/// Candidates that are beyond chance and do next to nothing to the gap.
const NEXT_TO_NOTHING: Rule = Rule {
    name: "next_to_nothing",
    words: "The best candidate gains more than chance, but the gap is next to nothing smaller with it than without.",
    verdict: Verdict::None,
    missing: Missing::Nothing,
};

/// The same, of a gap that tolerances and noise do not make.
const NAMES_DO_NOTHING: Rule = Rule {
    name: "names_do_nothing",
    words: "The candidates that were found gain more than chance, but the gap is next to nothing smaller with them, so none of them is named.",
    verdict: Verdict::Unknown,
    missing: Missing::InsteadOfEffects,
};

/// A free curve that is beyond chance and does next to nothing to the gap.
pub static CURVE_NEXT_TO_NOTHING: Rule = Rule {
    name: "curve_next_to_nothing",
    words: "A free curve gains more than chance, but the gap is next to nothing smaller with it than without.",
    verdict: Verdict::None,
    missing: Missing::Nothing,
};

impl Practice {
    /// Gaps of fitted and of predicted runs, with tolerances alone and with the effects.
    fn sets(&self) -> impl Iterator<Item = [f64; 2]> {
        [Some(self.fitted), self.held_out].into_iter().flatten()
    }

    /// Gap with tolerances alone, RMS of the fitted runs' and of those only predicted: an effect may show in either.
    pub fn calibrated(&self) -> f64 {
        self.root_mean_square(0)
    }

    /// The same of one of the two models.
    fn root_mean_square(&self, model: usize) -> f64 {
        let (sum, count) =
            self.sets().fold((0.0, 0.0), |(sum, count), set| (sum + set[model].powi(2), count + 1.0));
        f64::sqrt(sum / count)
    }

    /// The gap that a right model would leave, RMS of fitted and predicted runs.
    fn natural(&self) -> f64 {
        self.natural[0].hypot(self.natural[1]) * std::f64::consts::FRAC_1_SQRT_2
    }

    /// Gap beyond which something is missing.
    fn unnatural(&self, limits: &VerdictLimits) -> f64 {
        limits.unnatural_ratio * self.natural()
    }

    /// Whether effects leave a gap beyond that, and more of what tolerances alone have above a right model's than laws of another form
    /// leave.
    fn leaves_much(&self, limits: &VerdictLimits) -> bool {
        let above = |gap: f64| gap.powi(2) - self.natural().powi(2);
        let [calibrated, extended] = self.lasting;
        extended > self.unnatural(limits) && above(extended) > limits.other_form_leaves * above(calibrated)
    }

    /// Whether the greater part of the gap is closed in the fitted runs, and at least half as much in those only predicted, which may
    /// ask other things besides.
    fn closes_most(&self, limits: &VerdictLimits) -> bool {
        let closes = |[calibrated, extended]: [f64; 2], share: f64| extended < (1.0 - share) * calibrated;
        closes(self.fitted, limits.most_of_gap)
            && self.held_out.is_none_or(|set| closes(set, 0.5 * limits.most_of_gap))
    }

    /// Whether what is left is no more than noise and tolerances make.
    fn is_natural(&self, limits: &VerdictLimits) -> bool {
        self.root_mean_square(1) <= self.unnatural(limits)
    }

    /// Whether effects shrink next to nothing even the gap of the runs that they were fitted to, or, of a small gap, some hundredths
    /// there and next to nothing of all runs taken together.
    fn does_nothing(&self, limits: &VerdictLimits) -> bool {
        let hardly = self.fitted[1] > (1.0 - limits.least_curve_reduction) * self.fitted[0];
        let is_small = self.calibrated() < limits.noticeable_gap;
        is_unchanged(self.fitted, limits) || (is_small && hardly && self.keeps(limits.least_reduction))
    }

    /// Whether all runs taken together keep all of the gap but this share.
    fn keeps(&self, share: f64) -> bool {
        let squares = |model: usize| self.sets().map(|set| set[model].powi(2)).sum::<f64>();
        squares(1).sqrt() > (1.0 - share) * squares(0).sqrt()
    }

    /// Whether a curve does next to nothing to fitted and predicted runs taken together: it can follow much in those that it was
    /// fitted to.
    fn curve_does_nothing(&self, limits: &VerdictLimits) -> bool {
        self.keeps(limits.least_curve_reduction)
    }

    /// Whether runs that were not fitted are predicted no better, while much of the gap is left. What changes less in them than the
    /// sensors' noise is not asked there: a stretch of track that they do not pass, a rail that they do not run on.
    fn stays(&self, limits: &VerdictLimits) -> bool {
        let is_asked = self.moved > limits.least_moved;
        is_asked
            && self.predicted.is_some_and(|set| is_unchanged(set, limits) && set[1] > limits.noticeable_gap)
    }
}

/// Whether a gap shrinks next to nothing.
fn is_unchanged([calibrated, extended]: [f64; 2], limits: &VerdictLimits) -> bool {
    extended > (1.0 - limits.least_reduction) * calibrated
}

/// The decision in view of what the effects do to the gap.
pub fn in_practice(decision: Decision, practice: &Practice, criteria: &Criteria) -> Decision {
    let decides = |(revised, _, holds): &&(Verdict, Rule, Holds)| {
        *revised == decision.verdict && holds(practice, &criteria.verdict)
    };
    let rule = RULES.iter().find(decides);
    rule.map_or(decision, |(_, rule, _)| Decision { verdict: rule.verdict, rule })
}

/// The decision that something is missing without a name, in view of what the curve that shows it does to the gap.
pub fn in_practice_of_curve(decision: Decision, practice: &Practice, criteria: &Criteria) -> Decision {
    let limits = &criteria.verdict;
    let is_small = practice.calibrated() <= practice.unnatural(limits);
    if decision.verdict != Verdict::Unknown || !is_small || !practice.curve_does_nothing(limits) {
        return decision;
    }
    Decision { verdict: CURVE_NEXT_TO_NOTHING.verdict, rule: &CURVE_NEXT_TO_NOTHING }
}

/// One candidate that closes the gap, whatever a free curve gains by a filter: the curve may be the candidate's own force at another
/// place.
static CLOSES_GAP: Rule = Rule {
    name: "effect_closes_gap",
    words: "A free curve gains more by a filter than the best candidate, but with the candidate no more of the gap is left than tolerances and noise make.",
    verdict: Verdict::Effects,
    missing: Missing::Nothing,
};

/// One that closes the greater part.
static CLOSES_MOST: Rule = Rule {
    name: "effect_closes_most",
    words: "A free curve gains more by a filter than the best candidate, but the candidate closes the greater part of the gap, also in runs that were not fitted.",
    verdict: Verdict::EffectsAndUnknown,
    missing: Missing::BesideEffects,
};

/// The decision for an effect that gains more than chance and was overruled, in view of what it does to the gap; `None` where it
/// does too little.
pub fn in_spite_of_curve(practice: &Practice, criteria: &Criteria) -> Option<Decision> {
    let limits = &criteria.verdict;
    let rule = if practice.is_natural(limits) { &CLOSES_GAP } else { &CLOSES_MOST };
    practice.closes_most(limits).then_some(Decision { verdict: rule.verdict, rule })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::schema::Evidence;
    use crate::decide::verdict::decide;
    use crate::decide::verdict::tests::{EXPLAINED, NOTHING, beside};

    /// Gaps of fitted and of predicted runs of which a right model would leave 1.7.
    fn gaps(fitted: [f64; 2], held_out: Option<[f64; 2]>) -> Practice {
        Practice { fitted, held_out, predicted: None, moved: 3.0, lasting: [2.0; 2], natural: [1.7; 2] }
    }

    #[test]
    fn a_candidate_that_closes_the_gap_is_not_overruled_by_a_curve() {
        let criteria = Criteria::default();
        let asked = |fitted, held_out| {
            let practice = gaps(fitted, Some(held_out));
            in_spite_of_curve(&practice, &criteria).map(|decision| decision.rule.name)
        };
        assert_eq!(asked([6.8, 1.7], [6.6, 2.0]), Some("effect_closes_gap"));
        assert_eq!(asked([10.1, 3.6], [12.0, 4.0]), Some("effect_closes_most"));
        assert_eq!(asked([6.8, 1.7], [6.6, 4.0]), Some("effect_closes_most"));
        assert_eq!(asked([27.5, 17.8], [55.0, 20.0]), None);
        assert_eq!(asked([17.5, 3.3], [3.4, 3.6]), None, "it does not carry over");
    }

    #[test]
    fn effects_that_do_next_to_nothing_are_none() {
        let criteria = Criteria::default();
        let named = decide(&EXPLAINED, &criteria);
        let asked = |shrinks: [f64; 2]| {
            let [fitted, held_out] = shrinks.map(|share| [2.0, 2.0 * (1.0 - share)]);
            let practice = gaps(fitted, Some(held_out));
            in_practice(named, &practice, &criteria).rule.name
        };
        assert_eq!(asked([0.001, 0.002]), "next_to_nothing");
        assert_eq!(asked([0.001, 0.02]), "next_to_nothing", "fitted runs are no better");
        assert_eq!(asked([0.05, 0.001]), "effects_explain_gap");
        let large = gaps([8.0; 2], Some([24.0; 2]));
        assert_eq!(in_practice(named, &large, &criteria).rule.name, "names_do_nothing");
        let in_part = decide(&beside(300.0), &criteria);
        let practice = gaps([8.0, 8.1], Some([24.0, 50.0]));
        assert_eq!(in_practice(in_part, &practice, &criteria).rule.name, "names_do_nothing");
        let small = gaps([1.4, 1.4], Some([1.5, 1.5]));
        assert_eq!(in_practice(in_part, &small, &criteria).rule.name, "next_to_nothing");
        let unknown = decide(&beside(700.0), &criteria);
        let practice = gaps([2.0; 2], None);
        assert_eq!(in_practice(unknown, &practice, &criteria).rule.name, unknown.rule.name);
    }

    #[test]
    fn effects_that_do_a_hundredth_to_the_runs_they_fit_and_less_to_all_are_none() {
        let criteria = Criteria::default();
        let named = decide(&EXPLAINED, &criteria);
        let asked = |fitted: [f64; 2], held_out: [f64; 2]| {
            let practice = gaps(fitted, Some(held_out));
            in_practice(named, &practice, &criteria).rule.name
        };
        assert_eq!(asked([2.19, 2.16], [2.15, 2.145]), "next_to_nothing");
        assert_eq!(asked([2.19, 2.10], [2.15, 2.20]), named.rule.name);
        assert_eq!(asked([2.19, 2.16], [2.15, 2.10]), named.rule.name);
    }

    #[test]
    fn a_curve_that_does_next_to_nothing_to_a_small_gap_is_none() {
        let criteria = Criteria::default();
        let unknown = decide(&Evidence { effects: 0, gain: 0.0, ..beside(100.0) }, &criteria);
        let asked = |fitted: [f64; 2]| {
            let practice = gaps(fitted, Some([1.7, 1.69]));
            in_practice_of_curve(unknown, &practice, &criteria).rule.name
        };
        assert_eq!(asked([1.64, 1.63]), "curve_next_to_nothing");
        assert_eq!(asked([1.64, 1.4]), "structure_without_effect");
        let large = gaps([5.0, 4.99], None);
        assert_eq!(in_practice_of_curve(unknown, &large, &criteria).rule.name, unknown.rule.name);
    }

    #[test]
    fn effects_that_leave_more_than_a_right_model_would_are_not_the_whole_answer() {
        let criteria = Criteria::default();
        let named = decide(&EXPLAINED, &criteria);
        let asked_of = |natural: f64, lasting: [f64; 2]| {
            let practice =
                Practice { lasting, natural: [natural; 2], ..gaps([25.0, 10.0], Some([26.0, 10.0])) };
            in_practice(named, &practice, &criteria).rule.name
        };
        let asked = |natural: f64, lasting: f64| asked_of(natural, [20.0, lasting]);
        assert_eq!(asked(1.7, 9.0), "gap_left_beside", "however much the effects close");
        assert_eq!(asked_of(1.7, [5.0, 2.5]), "gap_left_beside");
        assert_eq!(
            asked(1.7, 3.0),
            "effects_explain_gap",
            "a law of another form leaves some hundredths of a gross gap"
        );
        assert_eq!(
            asked(1.7, 2.3),
            "effects_explain_gap",
            "a few windows in which a wheelset fell the other way"
        );
        assert_eq!(asked(7.0, 9.0), "effects_explain_gap", "pads and gusts make that on these recordings");
    }

    #[test]
    fn effects_that_predict_nothing_leave_something_unknown() {
        let criteria = Criteria::default();
        let named = decide(&EXPLAINED, &criteria);
        let changed = |moved: f64, calibrated: f64, extended: f64| {
            let practice = Practice {
                predicted: Some([calibrated, extended]),
                moved,
                ..gaps([5.0, 3.0], Some([calibrated, extended]))
            };
            in_practice(named, &practice, &criteria).rule.name
        };
        let asked = |calibrated: f64, extended: f64| changed(3.0, calibrated, extended);
        assert_eq!(changed(0.3, 4.1, 4.1), "effects_explain_gap", "the runs do not ask it");
        assert_eq!(asked(4.1, 4.2), "does_not_carry_over");
        assert_eq!(asked(4.1, 3.0), "effects_explain_gap");
        assert_eq!(
            asked(1.5, 1.6),
            "effects_explain_gap",
            "sensors that are noisier than stated leave as much"
        );
    }

    #[test]
    fn a_gap_that_tolerances_cannot_make_is_something() {
        let criteria = Criteria::default();
        let none = decide(&NOTHING, &criteria);
        let over = |natural: f64, lasting: f64| {
            let practice = Practice {
                lasting: [lasting; 2],
                natural: [natural, 1.1 * natural],
                ..gaps([1.3 * lasting; 2], None)
            };
            in_practice(none, &practice, &criteria).rule.name
        };
        assert_eq!(over(1.5, 2.3), "gap_left");
        assert_eq!(over(1.5, 1.9), none.rule.name, "whatever a single window does");
        assert_eq!(over(4.2, 5.1), none.rule.name, "at 20 samples a second a window starts from one sample");
        assert_eq!(over(4.2, 6.5), "gap_left");
    }
}
