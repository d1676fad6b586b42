//! From evidence to a verdict: the first rule of an ordered table that holds. Nothing is computed here but comparisons.

use crate::answer::schema::Verdict;
use crate::decide::criteria::{Criteria, VerdictLimits};

/// What the verdict on a wagon's case rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Number of effects that were selected.
    pub effects: usize,
    /// Evidence that they gain over the calibrated model, never negative.
    pub gain: f64,
    /// What the best of the library gains by chance in one case of fifty, see [`crate::decide::significance`].
    pub alarm: f64,
    /// Whether the strength of one of them sits on a bound.
    pub on_bound: bool,
    /// Whether one of them may show where freeing a place gains most over the calibrated model.
    pub at_likely_place: bool,
    /// Gain of the strongest flexible discrepancy beside them (beside the nuisances alone if there are none); zero where
    /// nothing is left to explain.
    pub discrepancy_gain: f64,
    /// The same on left-out runs.
    pub discrepancy_predictive: f64,
    /// Evidence that freeing the likeliest place gains over the calibrated model.
    pub place_evidence: f64,
    /// What freeing the likeliest place still gains beside the effects, as a share of that; one if none are named.
    pub left: f64,
    /// Evidence that the strongest flexible discrepancy at a likely place gains instead of the effects; `None` where it was
    /// not asked.
    pub instead_evidence: Option<f64>,
    /// Whether that discrepancy is in the term of one of the effects.
    pub instead_at_effects: bool,
    /// Whether it is in the term of the strongest of them.
    pub instead_at_strongest: bool,
}

impl Evidence {
    /// Whether the effects selected gain more than chance.
    pub fn is_named(&self) -> bool {
        self.effects > 0 && self.gain > self.alarm
    }

    /// Whether a flexible discrepancy explains more than chance of what is left.
    pub fn has_structure(&self, criteria: &Criteria) -> bool {
        let limits = &criteria.verdict;
        let predicts =
            self.discrepancy_predictive > limits.structure_predictive_share * self.discrepancy_gain;
        self.discrepancy_gain > limits.structure_gain
            && (predicts || self.discrepancy_gain > limits.structure_certain_gain)
    }

    /// Whether freeing a place shows an error although no effect is named.
    pub fn has_place_alone(&self, criteria: &Criteria) -> bool {
        self.place_evidence > criteria.verdict.place_alone_evidence
    }

    /// Share of what the effects and a discrepancy beside them explain together that the effects explain.
    pub fn recovered(&self) -> f64 {
        let all = self.gain + self.discrepancy_gain.max(0.0);
        if all > 0.0 { self.gain / all } else { 1.0 }
    }

    /// Whether a curve at one place explains much more than the effects.
    fn is_outdone(&self, criteria: &Criteria) -> bool {
        let limits = &criteria.verdict;
        let least = limits.outdone_factor * self.gain + limits.outdone_margin;
        self.instead_evidence.is_some_and(|evidence| evidence > least)
    }

    /// Whether the curve that explains much more is in the term of an effect, which explains a good part of what it does: the
    /// place is right, and its law has another form.
    fn has_other_form(&self, criteria: &Criteria) -> bool {
        let most = self.gain / criteria.verdict.other_form_share;
        self.instead_at_effects && self.instead_evidence.is_some_and(|evidence| evidence < most)
    }

    /// Whether a curve at one place, another one than the strongest effect's, explains as much as several effects together.
    fn is_one_for_several(&self) -> bool {
        let as_much = self.instead_evidence.is_some_and(|evidence| evidence > self.gain);
        self.effects > 1 && as_much && !self.instead_at_strongest
    }

    /// Whether the effects explain less than `share` of what can be explained, and what they leave has structure.
    fn explains_less_than(&self, share: f64, criteria: &Criteria) -> bool {
        self.has_structure(criteria) && self.recovered() < share
    }
}

/// Which flexible discrepancy shows what is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// Nothing is missing.
    Nothing,
    /// The strongest beside the effects.
    BesideEffects,
    /// The strongest instead of the effects, or beside them where that was not asked.
    InsteadOfEffects,
}

/// A rule of the table.
#[derive(Debug)]
pub struct Rule {
    /// Name in the report.
    pub name: &'static str,
    /// Why it leads to its verdict, in one sentence for people.
    pub words: &'static str,
    /// What it leads to.
    pub verdict: Verdict,
    /// What shows the rest.
    pub missing: Missing,
    holds: fn(&Evidence, &Criteria) -> bool,
}

/// The rules in their order; the last one always holds. The first three are about cases in which no effect gains more than
/// chance.
pub static RULES: [Rule; 13] = [
    Rule {
        name: "structure_without_effect",
        words: "No candidate explains the recordings better than chance, but a free curve at one place of the equations does.",
        verdict: Verdict::Unknown,
        missing: Missing::InsteadOfEffects,
        holds: |e, c| !e.is_named() && e.has_structure(c),
    },
    Rule {
        name: "place_without_effect",
        words: "No candidate explains the recordings better than chance, but letting one place of the equations err does.",
        verdict: Verdict::Unknown,
        missing: Missing::InsteadOfEffects,
        holds: |e, c| !e.is_named() && e.has_place_alone(c),
    },
    Rule {
        name: "nothing_beyond_chance",
        words: "Neither a candidate, nor a free curve, nor an error at any place explains the recordings better than chance.",
        verdict: Verdict::None,
        missing: Missing::Nothing,
        holds: |e, _| !e.is_named(),
    },
    Rule {
        name: "form_differs",
        words: "A free curve explains much more than the best candidate, but at its own place: the candidate's law has another form.",
        verdict: Verdict::EffectsAndUnknown,
        missing: Missing::InsteadOfEffects,
        holds: |e, c| e.is_outdone(c) && e.has_other_form(c),
    },
    Rule {
        name: "curve_explains_more",
        words: "A free curve at the likeliest place explains much more than the best candidates, so they are not the cause.",
        verdict: Verdict::Unknown,
        missing: Missing::InsteadOfEffects,
        holds: Evidence::is_outdone,
    },
    Rule {
        name: "one_curve_for_several",
        words: "A free curve at one place explains as much as several candidates that act elsewhere, so they are not the cause.",
        verdict: Verdict::Unknown,
        missing: Missing::InsteadOfEffects,
        holds: |e, _| e.is_one_for_several(),
    },
    Rule {
        name: "effects_leave_everything",
        words: "With the best candidates in the model its likeliest error is no smaller than before, so they are not the cause.",
        verdict: Verdict::Unknown,
        missing: Missing::InsteadOfEffects,
        holds: |e, _| e.left > 1.0,
    },
    Rule {
        name: "effects_elsewhere",
        words: "The best candidates act where the model errs little and leave most of its error where it is, so they are not the cause.",
        verdict: Verdict::Unknown,
        missing: Missing::InsteadOfEffects,
        holds: |e, c| e.left > c.verdict.most_left && !e.at_likely_place,
    },
    Rule {
        name: "effects_explain_too_little",
        words: "The best candidates explain too small a part of what a free curve beside them shows can be explained.",
        verdict: Verdict::Unknown,
        missing: Missing::InsteadOfEffects,
        holds: |e, c| e.explains_less_than(c.verdict.answer_share, c),
    },
    Rule {
        name: "strength_on_bound",
        words: "The best candidate is as strong as it may be and still leaves a part that a free curve explains: it imitates something else.",
        verdict: Verdict::Unknown,
        missing: Missing::InsteadOfEffects,
        holds: |e, c| e.on_bound && e.explains_less_than(c.verdict.whole_answer_share, c),
    },
    Rule {
        name: "most_is_left",
        words: "The effects act where the model errs, but most of its error there is left.",
        verdict: Verdict::EffectsAndUnknown,
        missing: Missing::BesideEffects,
        holds: |e, c| e.left > c.verdict.most_left,
    },
    Rule {
        name: "effects_explain_part",
        words: "The effects explain the greater part, and a free curve beside them explains a part that they do not.",
        verdict: Verdict::EffectsAndUnknown,
        missing: Missing::BesideEffects,
        holds: |e, c| e.explains_less_than(c.verdict.whole_answer_share, c),
    },
    Rule {
        name: "effects_explain_gap",
        words: "The effects explain more than chance, and nothing that they leave asks for another cause.",
        verdict: Verdict::Effects,
        missing: Missing::Nothing,
        holds: |_, _| true,
    },
];

/// Beside the table, because it is asked last, of the models fitted to the windows: effects that are there beyond chance and
/// do next to nothing.
pub static NEXT_TO_NOTHING: Rule = Rule {
    name: "next_to_nothing",
    words: "The best candidate gains more than chance, but the gap is next to nothing smaller with it than without.",
    verdict: Verdict::None,
    missing: Missing::Nothing,
    holds: |_, _| true,
};

/// Effects with which runs that were not fitted are predicted no better than without, while much of the gap is left.
pub static DOES_NOT_CARRY_OVER: Rule = Rule {
    name: "does_not_carry_over",
    words: "The effects explain the runs that were fitted and predict others no better than tolerances alone do, so something else is missing.",
    verdict: Verdict::EffectsAndUnknown,
    missing: Missing::BesideEffects,
    holds: |_, _| true,
};

/// A gap that no candidate and no curve shrinks beyond chance, but too large for tolerances and noise.
pub static GAP_LEFT: Rule = Rule {
    name: "gap_left",
    words: "Neither a candidate nor a free curve is beyond chance, but the gap is larger than tolerances and noise make it.",
    verdict: Verdict::Unknown,
    missing: Missing::BesideEffects,
    holds: |_, _| true,
};

/// Effects beside which most of a gap is left that tolerances and noise cannot make.
pub static MOST_OF_GAP_LEFT: Rule = Rule {
    name: "most_of_gap_left",
    words: "The effects gain more than chance, but most of the gap is left, and it is larger than tolerances and noise make it.",
    verdict: Verdict::EffectsAndUnknown,
    missing: Missing::BesideEffects,
    holds: |_, _| true,
};

/// A free curve that is beyond chance and does next to nothing to the gap.
pub static CURVE_NEXT_TO_NOTHING: Rule = Rule {
    name: "curve_next_to_nothing",
    words: "A free curve gains more than chance, but the gap is next to nothing smaller with it than without.",
    verdict: Verdict::None,
    missing: Missing::Nothing,
    holds: |_, _| true,
};

/// What effects do to the gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Practice {
    /// Gap of the fitted runs with tolerances alone, and with the effects.
    pub fitted: [f64; 2],
    /// The same of the runs only predicted; `None` without such runs.
    pub held_out: Option<[f64; 2]>,
    /// As [`Self::held_out`], windows on the wrong side between holding and sliding counting little.
    pub predicted: Option<[f64; 2]>,
}

impl Practice {
    /// Gaps of fitted and of predicted runs, with tolerances alone and with the effects.
    fn sets(&self) -> impl Iterator<Item = [f64; 2]> {
        [Some(self.fitted), self.held_out].into_iter().flatten()
    }

    /// Gap with tolerances alone, the smaller of the fitted runs' and of those only predicted.
    pub fn calibrated(&self) -> f64 {
        self.sets().map(|[calibrated, _]| calibrated).fold(f64::INFINITY, f64::min)
    }

    /// Whether effects shrink next to nothing even the gap of the runs that they were fitted to.
    fn does_nothing(&self, limits: &VerdictLimits) -> bool {
        is_unchanged(self.fitted, limits)
    }

    /// Whether a curve does next to nothing to fitted and predicted runs taken together: it can follow much in those that it was
    /// fitted to.
    fn curve_does_nothing(&self, limits: &VerdictLimits) -> bool {
        let squares = |model: usize| self.sets().map(|set| set[model].powi(2)).sum::<f64>();
        squares(1).sqrt() > (1.0 - limits.least_curve_reduction) * squares(0).sqrt()
    }

    /// Whether runs that were not fitted are predicted no better, while much of the gap is left.
    fn stays(&self, limits: &VerdictLimits) -> bool {
        self.predicted.is_some_and(|set| is_unchanged(set, limits) && set[1] > limits.noticeable_gap)
    }

    /// Whether less than most of the gap is closed in all runs, and more is left than tolerances and noise make.
    fn leaves_most(&self, limits: &VerdictLimits) -> bool {
        self.sets().all(|[calibrated, extended]| {
            let closed = calibrated - extended;
            extended > limits.unnatural_gap
                && closed < limits.most_of_gap * (calibrated - limits.noticeable_gap)
        })
    }
}

/// Whether a gap shrinks next to nothing.
fn is_unchanged([calibrated, extended]: [f64; 2], limits: &VerdictLimits) -> bool {
    extended > (1.0 - limits.least_reduction) * calibrated
}

/// The decision in view of what the effects do to the gap.
pub fn in_practice(decision: Decision, practice: &Practice, criteria: &Criteria) -> Decision {
    let limits = &criteria.verdict;
    let rule = match decision.verdict {
        Verdict::None if practice.calibrated() > limits.unnatural_gap => &GAP_LEFT,
        Verdict::Effects if practice.does_nothing(limits) => &NEXT_TO_NOTHING,
        Verdict::Effects if practice.stays(limits) => &DOES_NOT_CARRY_OVER,
        Verdict::Effects if practice.leaves_most(limits) => &MOST_OF_GAP_LEFT,
        _ => return decision,
    };
    Decision { verdict: rule.verdict, rule }
}

/// The decision that something is missing without a name, in view of what the curve that shows it does to the gap.
pub fn in_practice_of_curve(decision: Decision, practice: &Practice, criteria: &Criteria) -> Decision {
    let limits = &criteria.verdict;
    let is_small = practice.calibrated() < limits.noticeable_gap;
    if decision.verdict != Verdict::Unknown || !is_small || !practice.curve_does_nothing(limits) {
        return decision;
    }
    Decision { verdict: CURVE_NEXT_TO_NOTHING.verdict, rule: &CURVE_NEXT_TO_NOTHING }
}

/// What was decided, and by which rule.
#[derive(Clone, Copy, Debug)]
pub struct Decision {
    /// The verdict.
    pub verdict: Verdict,
    /// The rule that fired.
    pub rule: &'static Rule,
}

impl Decision {
    /// Whether the effects selected are the answer or a part of it.
    pub fn names_effects(&self) -> bool {
        matches!(self.verdict, Verdict::Effects | Verdict::EffectsAndUnknown)
    }
}

/// Decides by the first rule that holds.
pub fn decide(evidence: &Evidence, criteria: &Criteria) -> Decision {
    let [.., last] = &RULES;
    let rule = RULES.iter().find(|rule| (rule.holds)(evidence, criteria)).unwrap_or(last);
    Decision { verdict: rule.verdict, rule }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One effect that explains everything.
    const EXPLAINED: Evidence = Evidence {
        effects: 1,
        gain: 1000.0,
        alarm: 12.0,
        on_bound: false,
        at_likely_place: true,
        discrepancy_gain: 0.0,
        discrepancy_predictive: 0.0,
        place_evidence: 900.0,
        left: 0.02,
        instead_evidence: None,
        instead_at_effects: false,
        instead_at_strongest: false,
    };

    /// No effect, and nothing to explain.
    const NOTHING: Evidence =
        Evidence { effects: 0, gain: 0.0, place_evidence: 10.0, left: 1.0, ..EXPLAINED };

    /// One effect beside which a discrepancy gains this much.
    fn beside(discrepancy_gain: f64) -> Evidence {
        Evidence { discrepancy_gain, discrepancy_predictive: discrepancy_gain, ..EXPLAINED }
    }

    #[test]
    fn every_rule_decides_some_case() {
        let cases = [
            ("structure_without_effect", Evidence { effects: 0, gain: 0.0, ..beside(100.0) }),
            // The best candidate gains no more than chance.
            ("structure_without_effect", Evidence { gain: 11.0, ..beside(100.0) }),
            ("place_without_effect", Evidence { place_evidence: 300.0, ..NOTHING }),
            ("nothing_beyond_chance", NOTHING),
            ("nothing_beyond_chance", Evidence { gain: 11.0, place_evidence: 200.0, ..EXPLAINED }),
            // A discrepancy that fails on left-out runs is chance, unless it gains very much.
            ("nothing_beyond_chance", Evidence { discrepancy_gain: 100.0, ..NOTHING }),
            ("structure_without_effect", Evidence { discrepancy_gain: 260.0, ..NOTHING }),
            ("curve_explains_more", Evidence { instead_evidence: Some(1400.0), ..EXPLAINED }),
            ("effects_explain_gap", Evidence { instead_evidence: Some(1300.0), ..EXPLAINED }),
            (
                "form_differs",
                Evidence { instead_evidence: Some(1400.0), instead_at_effects: true, ..EXPLAINED },
            ),
            (
                "curve_explains_more",
                Evidence { instead_evidence: Some(4000.0), instead_at_effects: true, ..EXPLAINED },
            ),
            ("one_curve_for_several", Evidence { effects: 3, instead_evidence: Some(1080.0), ..EXPLAINED }),
            (
                "effects_explain_gap",
                Evidence {
                    effects: 3,
                    instead_evidence: Some(1080.0),
                    instead_at_strongest: true,
                    ..EXPLAINED
                },
            ),
            ("effects_explain_gap", Evidence { instead_evidence: Some(1080.0), ..EXPLAINED }),
            ("effects_leave_everything", Evidence { left: 1.1, ..EXPLAINED }),
            ("effects_elsewhere", Evidence { left: 0.7, at_likely_place: false, ..EXPLAINED }),
            ("effects_explain_gap", Evidence { left: 0.3, at_likely_place: false, ..EXPLAINED }),
            ("effects_explain_too_little", beside(700.0)),
            ("strength_on_bound", Evidence { on_bound: true, ..beside(300.0) }),
            ("effects_explain_gap", Evidence { on_bound: true, ..beside(200.0) }),
            ("most_is_left", Evidence { left: 0.7, ..EXPLAINED }),
            ("effects_explain_part", beside(300.0)),
            ("effects_explain_gap", beside(200.0)),
            ("effects_explain_gap", EXPLAINED),
        ];
        for (name, evidence) in cases {
            assert_eq!(decide(&evidence, &Criteria::default()).rule.name, name, "{evidence:?}");
        }
        for rule in &RULES {
            assert!(cases.iter().any(|(name, _)| *name == rule.name), "{} decides no case", rule.name);
        }
    }

    #[test]
    fn effects_that_do_next_to_nothing_are_none() {
        let criteria = Criteria::default();
        let named = decide(&EXPLAINED, &criteria);
        let asked = |shrinks: [f64; 2]| {
            let [fitted, held_out] = shrinks.map(|share| [2.0, 2.0 * (1.0 - share)]);
            let practice = Practice { fitted, held_out: Some(held_out), predicted: None };
            in_practice(named, &practice, &criteria).rule.name
        };
        assert_eq!(asked([0.001, 0.002]), "next_to_nothing");
        assert_eq!(asked([0.001, 0.02]), "next_to_nothing", "fitted runs are no better");
        assert_eq!(asked([0.05, 0.001]), "effects_explain_gap");
        let unknown = decide(&beside(700.0), &criteria);
        let practice = Practice { fitted: [2.0; 2], held_out: None, predicted: None };
        assert_eq!(in_practice(unknown, &practice, &criteria).rule.name, unknown.rule.name);
    }

    #[test]
    fn a_curve_that_does_next_to_nothing_to_a_small_gap_is_none() {
        let criteria = Criteria::default();
        let unknown = decide(&Evidence { effects: 0, gain: 0.0, ..beside(100.0) }, &criteria);
        let asked = |fitted: [f64; 2]| {
            let practice = Practice { fitted, held_out: Some([1.7, 1.69]), predicted: None };
            in_practice_of_curve(unknown, &practice, &criteria).rule.name
        };
        assert_eq!(asked([1.64, 1.63]), "curve_next_to_nothing");
        assert_eq!(asked([1.64, 1.4]), "structure_without_effect");
        let large = Practice { fitted: [5.0, 4.99], held_out: None, predicted: None };
        assert_eq!(in_practice_of_curve(unknown, &large, &criteria).rule.name, unknown.rule.name);
    }

    #[test]
    fn effects_that_leave_most_of_a_large_gap_are_not_the_whole_answer() {
        let criteria = Criteria::default();
        let named = decide(&EXPLAINED, &criteria);
        let asked = |fitted: [f64; 2], held_out: [f64; 2]| {
            let practice = Practice { fitted, held_out: Some(held_out), predicted: Some([9.0, 5.0]) };
            in_practice(named, &practice, &criteria).rule.name
        };
        assert_eq!(asked([35.0, 33.0], [41.0, 41.0]), "most_of_gap_left");
        assert_eq!(asked([25.0, 10.0], [26.0, 10.0]), "effects_explain_gap", "the greater part is closed");
        assert_eq!(
            asked([5.0, 3.5], [5.0, 3.5]),
            "effects_explain_gap",
            "pads and gusts may make what is left"
        );
    }

    #[test]
    fn effects_that_predict_nothing_leave_something_unknown() {
        let criteria = Criteria::default();
        let named = decide(&EXPLAINED, &criteria);
        let asked = |calibrated: f64, extended: f64| {
            let practice = Practice {
                fitted: [5.0, 3.0],
                held_out: Some([calibrated, extended]),
                predicted: Some([calibrated, extended]),
            };
            in_practice(named, &practice, &criteria).rule.name
        };
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
        let asked = |calibrated: f64| {
            let practice = Practice { fitted: [calibrated; 2], held_out: None, predicted: None };
            in_practice(none, &practice, &criteria).rule.name
        };
        assert_eq!(asked(4.4), "gap_left");
        assert_eq!(asked(3.4), none.rule.name);
    }

    #[test]
    fn names_of_rules_are_unique() {
        for (k, rule) in RULES.iter().enumerate() {
            assert!(RULES[k + 1..].iter().all(|other| other.name != rule.name), "{} stands twice", rule.name);
        }
    }

    #[test]
    fn a_decision_says_what_its_rule_says() {
        let decision = decide(&beside(300.0), &Criteria::default());
        assert_eq!(decision.verdict, Verdict::EffectsAndUnknown);
        assert!(decision.names_effects());
        assert!(!decide(&beside(700.0), &Criteria::default()).names_effects());
    }
}
