//! What the answers are worth.

use serde::Serialize;

use super::{
    answer::Named,
    belief::{Agreement, Beliefs, Bin, agreements, beliefs, reliability},
    make::{CLEAR, VISIBLE},
    outcome::{Outcome, Rate},
};

/// What a mere ranking scores: it always names its first, so that it alarms on every case and never says `unknown`.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Baseline {
    pub top_1: Rate,
    pub pairs_both_named: Rate,
    pub false_alarms: Rate,
    pub unknown_called_unknown: Rate,
}

impl Baseline {
    fn of(outcomes: &[Outcome], ranking: impl Fn(&Outcome) -> &[String]) -> Self {
        let ranked =
            || outcomes.iter().filter(|outcome| outcome.is_visible() && !ranking(outcome).is_empty());
        let known = |count: usize| {
            ranked()
                .filter(move |outcome| !outcome.made.is_unknown() && outcome.made.nameable().len() == count)
        };
        let named = |outcome: &Outcome, count: usize| {
            let first = &ranking(outcome)[..count.min(ranking(outcome).len())];
            outcome.made.nameable().iter().all(|id| first.iter().any(|named| named == id))
        };
        Self {
            top_1: Rate::count(known(1), |outcome| named(outcome, 1)),
            pairs_both_named: Rate::count(known(2), |outcome| named(outcome, 2)),
            false_alarms: Rate::count(ranked().filter(|o| o.made.label.effects.is_empty()), |_| true),
            unknown_called_unknown: Rate::count(ranked().filter(|o| o.made.is_unknown()), |_| false),
        }
    }
}

/// The score of effects that the calibration under test leaves to be seen.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct OfLeft {
    /// How many times the floor the calibrated gap of the fitted runs is at least.
    pub times: f64,
    pub top_1: Rate,
    pub top_1_or_equivalent: Rate,
    pub unknown_called_unknown: Rate,
}

/// The score of a run.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Score {
    pub failed: usize,
    pub top_1: Rate,
    pub top_1_or_equivalent: Rate,
    pub term: Rate,
    pub false_alarms: Rate,
    pub unknown_called_unknown: Rate,
    /// What the diagnosis' own calibration leaves to be seen, and what it leaves clearly.
    pub left: [OfLeft; 2],
    pub unknown_and_nothing_else: Rate,
    pub unknown_with_right_term: Rate,
    pub withheld_called_unknown: Rate,
    pub nameless_called_unknown: Rate,
    pub pairs_both_named: Rate,
    pub triples_all_named: Rate,
    /// Of two and three effects: those that show beside the others, one by one.
    pub each_that_shows: Rate,
    /// Cases of two and three of which every effect that shows is named.
    pub all_that_show: Rate,
    pub unknown_beside_a_right_name: Rate,
    /// Cases of one effect beside which another was named.
    pub name_too_many: Rate,
    pub closure_median: f64,
    pub closure_lower_decile: f64,
    pub closure_cases: usize,
    pub gaps_follow_from_files: Rate,
    pub parameter_error_median: f64,
    pub in_ci95: Rate,
    pub in_90: Rate,
    pub baseline_rmse: Baseline,
    pub baseline_correlation: Baseline,
    pub confidence: Vec<Bin>,
    pub beliefs: Beliefs,
    pub seconds_median: f64,
    pub seconds_longest: f64,
}

impl Score {
    /// Scores the outcomes of the cases in which there is nothing, or something to see.
    pub(super) fn of(outcomes: &[Outcome]) -> Self {
        let all = || outcomes.iter().filter(|outcome| outcome.is_visible());
        let none = || all().filter(|outcome| outcome.made.label.effects.is_empty());
        let unknown = || all().filter(|outcome| outcome.made.is_unknown());
        let count_of =
            |outcome: &Outcome| if outcome.made.is_unknown() { 0 } else { outcome.made.nameable().len() };
        let single = || all().filter(move |outcome| count_of(outcome) == 1);
        let pair = || all().filter(move |outcome| count_of(outcome) == 2);
        let several = || all().filter(move |outcome| count_of(outcome) > 1);
        let first = |outcome: &Outcome, test: &dyn Fn(&Named, &str) -> bool| {
            outcome.effects().first().is_some_and(|named| test(named, outcome.made.nameable()[0]))
        };
        let mut closures: Vec<f64> = single().chain(pair()).filter_map(Outcome::closure).collect();
        closures.sort_by(f64::total_cmp);
        let mut seconds: Vec<f64> = outcomes.iter().map(|outcome| outcome.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        let agreeing: Vec<Agreement> = single().chain(pair()).flat_map(agreements).collect();
        let mut errors: Vec<f64> = agreeing.iter().map(|agreement| agreement.relative_error).collect();
        errors.sort_by(f64::total_cmp);
        let tally = |test: &dyn Fn(&Agreement) -> bool| {
            agreeing.iter().fold(Rate::default(), |rate, agreement| rate.and(test(agreement)))
        };
        Self {
            failed: outcomes.iter().filter(|outcome| outcome.answer.is_none()).count(),
            top_1: Rate::count(single(), |outcome| first(outcome, &|named, id| named.id == id)),
            top_1_or_equivalent: Rate::count(single(), |outcome| first(outcome, &|named, id| named.is(id))),
            term: Rate::count(single(), Outcome::term_is_right),
            false_alarms: Rate::count(none(), |outcome| {
                outcome.answer.as_ref().is_none_or(|answer| answer.verdict != "none")
            }),
            unknown_called_unknown: Rate::count(unknown(), Outcome::says_unknown),
            left: [VISIBLE, CLEAR].map(|times| {
                let single = || single().filter(move |outcome| outcome.is_left_by_calibration(times));
                let unknown = unknown().filter(move |outcome| outcome.is_left_by_calibration(times));
                OfLeft {
                    times,
                    top_1: Rate::count(single(), |outcome| first(outcome, &|named, id| named.id == id)),
                    top_1_or_equivalent: Rate::count(single(), |o| first(o, &|named, id| named.is(id))),
                    unknown_called_unknown: Rate::count(unknown, Outcome::says_unknown),
                }
            }),
            unknown_and_nothing_else: Rate::count(unknown(), |outcome| {
                outcome.answer.as_ref().is_some_and(|answer| answer.verdict == "unknown")
            }),
            unknown_with_right_term: Rate::count(unknown(), |o| o.says_unknown() && o.term_is_right()),
            withheld_called_unknown: Rate::count(
                unknown().filter(|o| o.made.withheld.is_some()),
                Outcome::says_unknown,
            ),
            nameless_called_unknown: Rate::count(
                unknown().filter(|o| o.made.withheld.is_none()),
                Outcome::says_unknown,
            ),
            pairs_both_named: Rate::count(pair(), Outcome::is_right),
            triples_all_named: Rate::count(all().filter(|o| count_of(o) == 3), Outcome::is_right),
            each_that_shows: several()
                .flat_map(|outcome| outcome.made.showing().into_iter().map(move |id| (outcome, id)))
                .fold(Rate::default(), |rate, (outcome, id)| rate.and(outcome.names(id))),
            all_that_show: Rate::count(
                several().filter(|outcome| !outcome.made.showing().is_empty()),
                |outcome| outcome.made.showing().iter().all(|id| outcome.names(id)),
            ),
            unknown_beside_a_right_name: Rate::count(single(), Outcome::says_unknown),
            name_too_many: Rate::count(single(), |outcome| outcome.effects().len() > 1),
            closure_median: quantile(&closures, 0.5),
            closure_lower_decile: quantile(&closures, 0.1),
            closure_cases: closures.len(),
            gaps_follow_from_files: Rate::count(outcomes.iter().filter(|o| o.verified.is_some()), |o| {
                matches!(o.verified, Some(Ok(())))
            }),
            parameter_error_median: quantile(&errors, 0.5),
            in_ci95: tally(&|agreement| agreement.in_ci95),
            in_90: tally(&|agreement| agreement.in_90),
            baseline_rmse: Baseline::of(outcomes, |outcome| &outcome.rankings.rmse),
            baseline_correlation: Baseline::of(outcomes, |outcome| &outcome.rankings.correlation),
            confidence: reliability(outcomes),
            beliefs: beliefs(outcomes),
            seconds_median: quantile(&seconds, 0.5),
            seconds_longest: seconds.last().copied().unwrap_or(f64::NAN),
        }
    }
}

/// Quantile of sorted values, between neighbours linearly.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    if sorted.is_empty() {
        return f64::NAN;
    }
    let place = share * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    below + (above - below) * place.fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_between_neighbours() {
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.5), 2.0);
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.75), 3.0);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
