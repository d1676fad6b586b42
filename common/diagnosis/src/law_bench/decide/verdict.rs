//! From evidence to a verdict: the first rule of an ordered table that holds. Nothing is computed here but comparisons.

use super::criteria::Criteria;
use crate::answer::schema::Verdict;

/// What a verdict on a law measured alone rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Number of effects that were selected.
    pub effects: usize,
    /// Probability that chance leaves as much structure as the extended model does.
    pub structure_p: f64,
    /// What all smooth discrepancies together explain of what the extended model leaves, beyond chance, in degrees of freedom
    /// a point.
    pub structure_per_point: f64,
    /// The same as a share of the excess, 0 to 1.
    pub share_left: f64,
    /// What the calibrated model leaves beyond noise, in degrees of freedom.
    pub excess: f64,
    /// Score by which the best function of one variable without a selected effect beats all selected effects together;
    /// minus infinity where there is none.
    pub simpler_lead: f64,
}

impl Evidence {
    /// Whether the extended model leaves more structure than chance, and enough to matter.
    fn leaves_structure(&self, criteria: &Criteria) -> bool {
        self.structure_p < criteria.structure_level
            && self.structure_per_point > criteria.least_structure_per_point
    }

    /// Whether one variable without a selected effect is the simpler cause.
    fn has_simpler_cause(&self, criteria: &Criteria) -> bool {
        let in_doubt =
            self.effects > 1 || (self.leaves_structure(criteria) && self.share_left >= criteria.weigh_from);
        let margin = criteria.simpler_margin.max(criteria.simpler_margin_share * self.excess);
        in_doubt && self.simpler_lead > margin
    }
}

/// Which smooth discrepancy shows what is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// Nothing is missing.
    Nothing,
    /// The best one on top of the extended model.
    BesideEffects,
    /// The best one on top of the calibrated model.
    InsteadOfEffects,
    /// The best one of a single variable without a selected effect.
    SimplerCause,
}

/// A rule of the table.
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

/// The rules in their order; the last one always holds.
pub static RULES: [Rule; 7] = [
    Rule {
        name: "structure_without_effect",
        words: "No candidate explains the measured points better than chance, but they follow a curve that the model lacks.",
        verdict: Verdict::Unknown,
        missing: Missing::BesideEffects,
        holds: |e, c| e.effects == 0 && e.leaves_structure(c),
    },
    Rule {
        name: "nothing_beyond_chance",
        words: "Neither a candidate nor a free curve explains the measured points better than chance would.",
        verdict: Verdict::None,
        missing: Missing::Nothing,
        holds: |e, _| e.effects == 0,
    },
    Rule {
        name: "simpler_cause",
        words: "A free curve over one variable explains more than all candidates found, and none of them depends on that variable.",
        verdict: Verdict::Unknown,
        missing: Missing::SimplerCause,
        holds: Evidence::has_simpler_cause,
    },
    Rule {
        name: "rest_is_chance",
        words: "What the extended model leaves unexplained is no more than chance.",
        verdict: Verdict::Effects,
        missing: Missing::Nothing,
        holds: |e, c| !e.leaves_structure(c),
    },
    Rule {
        name: "rest_is_form",
        words: "What the extended model leaves unexplained is so little that a slightly different formula would take it up.",
        verdict: Verdict::Effects,
        missing: Missing::Nothing,
        holds: |e, c| e.share_left <= c.most_left_by_form,
    },
    Rule {
        name: "effects_explain_part",
        words: "The extended model explains more than half of the excess error, but leaves more than a slightly different formula would take up.",
        verdict: Verdict::EffectsAndUnknown,
        missing: Missing::BesideEffects,
        holds: |e, c| e.share_left <= c.most_left_by_effects,
    },
    Rule {
        name: "effects_explain_too_little",
        words: "Even the best candidates explain less than half of the excess error, so they are not its cause.",
        verdict: Verdict::Unknown,
        missing: Missing::InsteadOfEffects,
        holds: |_, _| true,
    },
];

/// The rule that decides.
pub fn decide(evidence: &Evidence, criteria: &Criteria) -> &'static Rule {
    let [.., last] = &RULES;
    RULES.iter().find(|rule| (rule.holds)(evidence, criteria)).unwrap_or(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One effect that leaves nothing.
    const EXPLAINED: Evidence = Evidence {
        effects: 1,
        structure_p: 0.6,
        structure_per_point: 0.0,
        share_left: 0.0,
        excess: 1000.0,
        simpler_lead: f64::NEG_INFINITY,
    };

    /// One effect that leaves a share of the excess.
    fn left(share_left: f64) -> Evidence {
        Evidence { structure_p: 0.002, structure_per_point: 0.5, share_left, ..EXPLAINED }
    }

    #[test]
    fn every_rule_decides_some_case() {
        let none = Evidence { effects: 0, ..EXPLAINED };
        let cases = [
            ("structure_without_effect", Evidence { effects: 0, ..left(1.0) }),
            ("nothing_beyond_chance", none),
            // Significant, but smaller than a sensor's calibration is good for.
            ("nothing_beyond_chance", Evidence { structure_p: 0.002, structure_per_point: 0.01, ..none }),
            ("simpler_cause", Evidence { simpler_lead: 30.0, ..left(0.1) }),
            ("simpler_cause", Evidence { effects: 2, simpler_lead: 30.0, ..EXPLAINED }),
            ("rest_is_chance", EXPLAINED),
            // A single effect that leaves nothing is not weighed against free curves.
            ("rest_is_chance", Evidence { simpler_lead: 30.0, ..EXPLAINED }),
            // The lead is within two per cent of the excess.
            ("rest_is_chance", Evidence { effects: 2, simpler_lead: 15.0, ..EXPLAINED }),
            ("rest_is_form", left(0.03)),
            ("rest_is_form", Evidence { simpler_lead: 30.0, ..left(0.03) }),
            ("rest_is_form", left(0.12)),
            ("effects_explain_part", left(0.3)),
            ("effects_explain_too_little", left(0.7)),
        ];
        for (name, evidence) in cases {
            assert_eq!(decide(&evidence, &Criteria::default()).name, name, "{evidence:?}");
        }
        for rule in &RULES {
            assert!(cases.iter().any(|(name, _)| *name == rule.name), "{} decides no case", rule.name);
        }
    }

    #[test]
    fn a_share_that_cannot_be_computed_names_nothing() {
        assert_eq!(decide(&left(f64::NAN), &Criteria::default()).verdict, Verdict::Unknown);
    }
}
