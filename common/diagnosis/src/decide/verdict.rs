//! From evidence to a verdict: the first rule of an ordered table that holds. Nothing is computed here but comparisons.

use crate::answer::schema::{Evidence, Verdict};
use crate::decide::criteria::Criteria;

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
}

/// When a rule of the table decides.
type Holds = fn(&Evidence, &Criteria) -> bool;

/// The rules in their order; the last one always holds. The first three are about cases in which no effect gains more than
/// chance.
pub static RULES: [(Rule, Holds); 13] = [
    (
        Rule {
            name: "structure_without_effect",
            words: "No candidate explains the recordings better than chance, but a free curve at one place of the equations does.",
            verdict: Verdict::Unknown,
            missing: Missing::InsteadOfEffects,
        },
        |e, c| !e.is_named() && e.has_structure(c),
    ),
    (
        Rule {
            name: "place_without_effect",
            words: "No candidate explains the recordings better than chance, but letting one place of the equations err does.",
            verdict: Verdict::Unknown,
            missing: Missing::InsteadOfEffects,
        },
        |e, c| !e.is_named() && e.has_place_alone(c),
    ),
    (
        Rule {
            name: "nothing_beyond_chance",
            words: "Neither a candidate, nor a free curve, nor an error at any place explains the recordings better than chance.",
            verdict: Verdict::None,
            missing: Missing::Nothing,
        },
        |e, _| !e.is_named(),
    ),
    (
        Rule {
            name: "form_differs",
            words: "A free curve explains much more than the best candidate, but at its own place: the candidate's law has another form.",
            verdict: Verdict::EffectsAndUnknown,
            missing: Missing::InsteadOfEffects,
        },
        |e, c| e.is_outdone(c) && e.has_other_form(c),
    ),
    (
        Rule {
            name: "curve_explains_more",
            words: "A free curve at the likeliest place explains much more than the best candidates, so they are not the cause.",
            verdict: Verdict::Unknown,
            missing: Missing::InsteadOfEffects,
        },
        Evidence::is_outdone,
    ),
    (
        Rule {
            name: "one_curve_for_several",
            words: "A free curve at one place explains as much as several candidates that act elsewhere, so they are not the cause.",
            verdict: Verdict::Unknown,
            missing: Missing::InsteadOfEffects,
        },
        |e, _| e.is_one_for_several(),
    ),
    (
        Rule {
            name: "effects_leave_everything",
            words: "With the best candidates in the model its likeliest error is no smaller than before, so they are not the cause.",
            verdict: Verdict::Unknown,
            missing: Missing::InsteadOfEffects,
        },
        |e, _| e.left > 1.0,
    ),
    (
        Rule {
            name: "effects_elsewhere",
            words: "The best candidates act where the model errs little and leave most of its error where it is, so they are not the cause.",
            verdict: Verdict::Unknown,
            missing: Missing::InsteadOfEffects,
        },
        |e, c| e.left > c.verdict.most_left && !e.at_likely_place,
    ),
    (
        Rule {
            name: "effects_explain_too_little",
            words: "The best candidates explain too small a part of what a free curve beside them shows can be explained.",
            verdict: Verdict::Unknown,
            missing: Missing::InsteadOfEffects,
        },
        |e, c| e.explains_less_than(c.verdict.answer_share, c),
    ),
    (
        Rule {
            name: "strength_on_bound",
            words: "The best candidate is as strong as it may be and still leaves a part that a free curve explains: it imitates something else.",
            verdict: Verdict::Unknown,
            missing: Missing::InsteadOfEffects,
        },
        |e, c| e.on_bound && e.explains_less_than(c.verdict.whole_answer_share, c),
    ),
    (
        Rule {
            name: "most_is_left",
            words: "The effects act where the model errs, but most of its error there is left.",
            verdict: Verdict::EffectsAndUnknown,
            missing: Missing::BesideEffects,
        },
        |e, c| e.left > c.verdict.most_left,
    ),
    (
        Rule {
            name: "effects_explain_part",
            words: "The effects explain the greater part, and a free curve beside them explains a part that they do not.",
            verdict: Verdict::EffectsAndUnknown,
            missing: Missing::BesideEffects,
        },
        |e, c| e.explains_less_than(c.verdict.whole_answer_share, c),
    ),
    (
        Rule {
            name: "effects_explain_gap",
            words: "The effects explain more than chance, and nothing that they leave asks for another cause.",
            verdict: Verdict::Effects,
            missing: Missing::Nothing,
        },
        |_, _| true,
    ),
];

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
    let [.., (last, _)] = &RULES;
    let first = RULES.iter().find(|(_, holds)| holds(evidence, criteria));
    let rule = first.map_or(last, |(rule, _)| rule);
    Decision { verdict: rule.verdict, rule }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// One effect that explains everything.
    pub(in super::super) const EXPLAINED: Evidence = Evidence {
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
    pub(in super::super) const NOTHING: Evidence =
        Evidence { effects: 0, gain: 0.0, place_evidence: 10.0, left: 1.0, ..EXPLAINED };

    /// One effect beside which a discrepancy gains this much.
    pub(in super::super) fn beside(discrepancy_gain: f64) -> Evidence {
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
        for (rule, _) in &RULES {
            assert!(cases.iter().any(|(name, _)| *name == rule.name), "{} decides no case", rule.name);
        }
    }

    #[test]
    fn names_of_rules_are_unique() {
        for (k, (rule, _)) in RULES.iter().enumerate() {
            assert!(
                RULES[k + 1..].iter().all(|(other, _)| other.name != rule.name),
                "{} stands twice",
                rule.name
            );
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
