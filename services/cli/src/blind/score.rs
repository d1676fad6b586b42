//! What the answers are worth.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

use super::make::Made;

/// An effect that a report names.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Named {
    /// Id.
    pub id: String,
    /// Term of the equations.
    pub term: String,
    /// Stated probability of being right.
    pub confidence: f64,
    /// Ids that the report declares equivalent.
    pub equivalent: Vec<String>,
    /// Value and 95 % interval of each parameter.
    pub parameters: BTreeMap<String, (f64, f64, f64)>,
}

impl Named {
    fn is(&self, id: &str) -> bool {
        self.id == id || self.equivalent.iter().any(|other| other == id)
    }
}

/// What the score reads from a report.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Answer {
    /// The answer in one word.
    pub verdict: String,
    /// Where the gap lies.
    pub term: Option<String>,
    /// Term of what is left over.
    pub unexplained_term: Option<String>,
    /// Effects, strongest first.
    pub effects: Vec<Named>,
    /// Holdout gaps of the calibrated and the extended model.
    pub calibrated: f64,
    /// The same of the extended model.
    pub extended: f64,
    /// Baseline: every candidate with its nuisances refitted, lowest RMSE on the fit runs first.
    pub rmse_ranking: Vec<String>,
}

impl Answer {
    /// Reads a report; what is missing counts as not said.
    pub(super) fn read(report: &Value) -> Self {
        let text = |value: &Value, key: &str| value.get(key).and_then(Value::as_str).map(str::to_owned);
        let number = |pointer: &str| report.pointer(pointer).and_then(Value::as_f64).unwrap_or(f64::NAN);
        let list = |key: &str| report.get(key).and_then(Value::as_array).cloned().unwrap_or_default();
        let named = |effect: &Value| Named {
            id: text(effect, "id").unwrap_or_default(),
            term: text(effect, "term").unwrap_or_default(),
            confidence: effect.get("confidence").and_then(Value::as_f64).unwrap_or(f64::NAN),
            equivalent: effect
                .get("equivalent")
                .and_then(Value::as_array)
                .map(|ids| ids.iter().filter_map(|id| id.as_str().map(str::to_owned)).collect())
                .unwrap_or_default(),
            parameters: parameters(effect),
        };
        let gap_of =
            |candidate: &Value| candidate.get("fit_gap").and_then(Value::as_f64).unwrap_or(f64::INFINITY);
        let mut candidates = list("candidates");
        candidates.sort_by(|a, b| gap_of(a).total_cmp(&gap_of(b)));
        Self {
            verdict: text(report, "verdict").unwrap_or_default(),
            term: report.pointer("/where/term").and_then(Value::as_str).map(str::to_owned),
            unexplained_term: report.pointer("/unexplained/term").and_then(Value::as_str).map(str::to_owned),
            effects: list("effects").iter().map(named).collect(),
            calibrated: number("/gap/holdout/calibrated"),
            extended: number("/gap/holdout/extended"),
            rmse_ranking: candidates.iter().filter_map(|candidate| text(candidate, "id")).collect(),
        }
    }

    /// The word for the confusion matrix.
    pub(super) fn word(&self) -> String {
        match (self.effects.first(), self.verdict.contains("unknown")) {
            (Some(effect), false) => effect.id.clone(),
            (Some(effect), true) => format!("{} + unknown", effect.id),
            (None, true) => format!("unknown ({})", self.term.as_deref().unwrap_or("no term")),
            (None, false) => self.verdict.clone(),
        }
    }
}

fn parameters(effect: &Value) -> BTreeMap<String, (f64, f64, f64)> {
    let entries = effect.get("parameters").and_then(Value::as_object);
    let read = |(name, value): (&String, &Value)| {
        let number = |pointer: &str| value.pointer(pointer).and_then(Value::as_f64);
        Some((name.clone(), (number("/value")?, number("/ci95/0")?, number("/ci95/1")?)))
    };
    entries.map(|entries| entries.iter().filter_map(read).collect()).unwrap_or_default()
}

/// A case with its answer.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Outcome {
    /// The case and its label.
    pub made: Made,
    /// What was said; `None` if the diagnosis failed.
    pub answer: Option<Answer>,
    /// Holdout gap of the calibrated nominal model on the twin.
    pub floor: Option<f64>,
    /// Whether the stated holdout gaps follow from the prediction files.
    pub verified: Option<Result<(), String>>,
    /// Wall-clock time of the diagnosis, s.
    pub seconds: f64,
    /// Why there is no answer.
    pub failure: Option<String>,
    /// Baseline: ids by correlation of the calibrated model's residuals with one-shot sensitivities, best first.
    pub correlation_ranking: Vec<String>,
}

impl Outcome {
    fn effects(&self) -> &[Named] {
        self.answer.as_ref().map_or(&[], |answer| &answer.effects)
    }

    fn says_unknown(&self) -> bool {
        self.answer.as_ref().is_some_and(|answer| answer.verdict.contains("unknown"))
    }

    fn true_terms(&self) -> Vec<&str> {
        self.made.label.effects.iter().map(|effect| effect.term.as_str()).collect()
    }

    /// The term that the report blames first.
    fn first_term(&self) -> Option<&str> {
        let answer = self.answer.as_ref()?;
        answer.effects.first().map(|effect| effect.term.as_str()).or(answer.term.as_deref())
    }

    /// Whether the term is right; for an unknown the location or the term of the rest counts.
    fn term_is_right(&self) -> bool {
        let truth = self.true_terms();
        let Some(answer) = &self.answer else { return false };
        if self.made.is_unknown() {
            return [&answer.term, &answer.unexplained_term]
                .into_iter()
                .flatten()
                .any(|t| truth.contains(&t.as_str()));
        }
        self.first_term().is_some_and(|term| truth.contains(&term))
    }

    /// Whether the answer counts as right.
    pub(super) fn is_right(&self) -> bool {
        let nameable = self.made.nameable();
        match nameable.as_slice() {
            _ if self.made.is_unknown() => self.says_unknown(),
            [] => self.answer.as_ref().is_some_and(|answer| answer.verdict == "none"),
            [id] => self.effects().first().is_some_and(|named| named.is(id)),
            _ => nameable.iter().all(|id| self.effects().iter().any(|named| named.is(id))),
        }
    }

    fn closure(&self) -> Option<f64> {
        let (answer, floor) = (self.answer.as_ref()?, self.floor?);
        let room = answer.calibrated - floor;
        (room > 0.15 * floor).then(|| (answer.calibrated - answer.extended) / room)
    }
}

/// How often something was right.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(super) struct Rate {
    /// Times it was right.
    pub right: usize,
    /// Times it could have been.
    pub of: usize,
}

impl Rate {
    fn count<'a>(outcomes: impl Iterator<Item = &'a Outcome>, right: impl Fn(&Outcome) -> bool) -> Self {
        outcomes.fold(Self::default(), |rate, outcome| rate.and(right(outcome)))
    }

    fn and(self, right: bool) -> Self {
        Self { right: self.right + usize::from(right), of: self.of + 1 }
    }

    /// The share; `NaN` of nothing.
    pub(super) fn share(self) -> f64 {
        self.right as f64 / self.of as f64
    }
}

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
        let ranked = || outcomes.iter().filter(|outcome| !ranking(outcome).is_empty());
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

/// One bin of stated confidence.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Bin {
    /// Range of stated confidence.
    pub range: (f64, f64),
    /// Mean of what was stated.
    pub stated: f64,
    /// How often it was right.
    pub right: Rate,
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
    pub unknown_and_nothing_else: Rate,
    pub unknown_with_right_term: Rate,
    pub withheld_called_unknown: Rate,
    pub nameless_called_unknown: Rate,
    pub pairs_both_named: Rate,
    pub unknown_beside_a_right_name: Rate,
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
    pub seconds_median: f64,
    pub seconds_longest: f64,
}

impl Score {
    /// Scores the outcomes.
    pub(super) fn of(outcomes: &[Outcome]) -> Self {
        let none = || outcomes.iter().filter(|outcome| outcome.made.label.effects.is_empty());
        let unknown = || outcomes.iter().filter(|outcome| outcome.made.is_unknown());
        let count_of =
            |outcome: &Outcome| if outcome.made.is_unknown() { 0 } else { outcome.made.nameable().len() };
        let single = || outcomes.iter().filter(move |outcome| count_of(outcome) == 1);
        let pair = || outcomes.iter().filter(move |outcome| count_of(outcome) == 2);
        let first = |outcome: &Outcome, test: &dyn Fn(&Named, &str) -> bool| {
            outcome.effects().first().is_some_and(|named| test(named, outcome.made.nameable()[0]))
        };
        let mut closures: Vec<f64> = single().chain(pair()).filter_map(Outcome::closure).collect();
        closures.sort_by(f64::total_cmp);
        let mut seconds: Vec<f64> = outcomes.iter().map(|outcome| outcome.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        let agreeing: Vec<Agreement> = single().filter_map(agreement).collect();
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
            unknown_beside_a_right_name: Rate::count(single(), Outcome::says_unknown),
            closure_median: quantile(&closures, 0.5),
            closure_lower_decile: quantile(&closures, 0.1),
            closure_cases: closures.len(),
            gaps_follow_from_files: Rate::count(outcomes.iter(), |o| matches!(o.verified, Some(Ok(())))),
            parameter_error_median: quantile(&errors, 0.5),
            in_ci95: tally(&|agreement| agreement.in_ci95),
            in_90: tally(&|agreement| agreement.in_90),
            baseline_rmse: Baseline::of(outcomes, |outcome| {
                outcome.answer.as_ref().map_or(&[], |answer| answer.rmse_ranking.as_slice())
            }),
            baseline_correlation: Baseline::of(outcomes, |outcome| outcome.correlation_ranking.as_slice()),
            confidence: reliability(outcomes),
            seconds_median: quantile(&seconds, 0.5),
            seconds_longest: seconds.last().copied().unwrap_or(f64::NAN),
        }
    }
}

/// How often first names are right, by stated confidence. A name given to an unknown or to nothing is wrong.
fn reliability(outcomes: &[Outcome]) -> Vec<Bin> {
    const EDGES: [f64; 6] = [0.0, 0.5, 0.7, 0.85, 0.95, 1.000_001];
    let bin = |range: &[f64]| {
        let inside = |named: &Named| (range[0]..range[1]).contains(&named.confidence);
        let named =
            outcomes.iter().filter_map(|o| Some((o, o.effects().first()?))).filter(|(_, n)| inside(n));
        let (mut stated, mut right) = (0.0, Rate::default());
        for (outcome, named) in named {
            stated += named.confidence;
            right = right.and(outcome.made.nameable().iter().any(|id| named.is(id)));
        }
        Bin { range: (range[0], range[1].min(1.0)), stated: stated / right.of as f64, right }
    };
    EDGES.windows(2).map(bin).collect()
}

struct Agreement {
    relative_error: f64,
    in_ci95: bool,
    in_90: bool,
}

/// Effects whose form in the plant is that of the catalogue: id, the plant's parameter, the catalogue's, and what to add
/// to the plant's value.
const AGREEING: [(&str, &str, &str, f64); 6] = [
    ("wheel_radius", "relative", "relative_error", 0.0),
    ("mass_error", "relative", "relative_error", 0.0),
    ("rotating_inertia", "relative", "relative_error", 0.0),
    ("load_transfer", "factor", "relative_error", -1.0),
    ("dragging_brake", "torque_nm", "torque_nm", 0.0),
    ("wheel_encoder_window", "window_s", "window_s", 0.0),
];

/// Compares the fitted parameter with the true one where the first name is right and the forms agree.
fn agreement(outcome: &Outcome) -> Option<Agreement> {
    let truth = outcome.made.label.effects.first()?;
    let (_, plants, catalogues, offset) = AGREEING.iter().find(|(id, ..)| *id == truth.id)?;
    let named = outcome.effects().iter().find(|named| named.id == truth.id)?;
    let value = truth.parameters.iter().find(|(name, _)| name == plants)?.1 + offset;
    let (fitted, low, high) = *named.parameters.get(*catalogues)?;
    let narrow = 1.645 / 1.96;
    Some(Agreement {
        relative_error: ((fitted - value) / value).abs(),
        in_ci95: (low..=high).contains(&value),
        in_90: (fitted + narrow * (low - fitted)..=fitted + narrow * (high - fitted)).contains(&value),
    })
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
    use serde_json::json;

    use super::*;

    #[test]
    fn quantiles_lie_between_neighbours() {
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.5), 2.0);
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.75), 3.0);
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn an_answer_is_read_from_the_contracts_keys() {
        let report = json!({
            "verdict": "effects+unknown", "where": {"term": "adhesion"}, "unexplained": {"gap": 2.0, "term": "inertia"},
            "effects": [{"id": "sanding", "term": "adhesion", "confidence": 0.9, "equivalent": ["self_cleaning"],
                         "parameters": {"gain": {"value": 0.3, "ci95": [0.2, 0.4]}}}],
            "candidates": [{"id": "a", "fit_gap": 3.0}, {"id": "b", "fit_gap": 2.0}],
            "gap": {"holdout": {"calibrated": 8.0, "extended": 2.0}}
        });
        let answer = Answer::read(&report);
        assert_eq!(answer.word(), "sanding + unknown");
        assert!(answer.effects[0].is("self_cleaning") && !answer.effects[0].is("brake_lag"));
        assert_eq!(answer.effects[0].parameters["gain"], (0.3, 0.2, 0.4));
        assert_eq!(answer.rmse_ranking, ["b", "a"]);
        assert_eq!((answer.calibrated, answer.extended), (8.0, 2.0));
    }
}
