//! What the score reads from a report, by the keys of the contract alone.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

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
    /// Whether it means this id, by name or by declared equivalence.
    pub(super) fn is(&self, id: &str) -> bool {
        self.id == id || self.equivalent.iter().any(|other| other == id)
    }
}

/// A set of effects that a report lists as possible.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Set {
    /// Ids, in their order.
    pub effects: Vec<String>,
    /// Whether something that no id names is among them.
    pub unknown: bool,
    /// Probability.
    pub p: f64,
}

impl Set {
    fn read(set: &Value) -> Option<Self> {
        let ids = set.get("effects")?.as_array()?.iter().filter_map(Value::as_str);
        let mut effects: Vec<String> = ids.map(str::to_owned).collect();
        effects.sort();
        let unknown = set.get("unknown").and_then(Value::as_bool).unwrap_or(false);
        Some(Self { effects, unknown, p: set.get("p")?.as_f64()? })
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
    /// Sets of effects with their probabilities; empty in reports without a posterior.
    pub sets: Vec<Set>,
    /// Which of them the report holds the truth to be among, in nine of ten cases.
    pub verdict_set: Vec<usize>,
    /// Probability of the likeliest set of effects; not a number in reports without a posterior.
    pub most_p: f64,
    /// Entropy of the sets, nats; those that are not listed count as one.
    pub entropy: f64,
    /// Gap of the fitted runs that the calibrated model leaves.
    pub calibrated_fit: f64,
    /// Holdout gaps of the calibrated and the extended model.
    pub calibrated: f64,
    /// The same of the extended model.
    pub extended: f64,
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
        let sets: Vec<Set> = list("posterior").iter().filter_map(Set::read).collect();
        let verdict_set = list("verdict_set").iter().filter_map(Value::as_u64).map(|k| k as usize).collect();
        let p = || sets.iter().map(|set| set.p);
        Self {
            verdict: text(report, "verdict").unwrap_or_default(),
            term: report.pointer("/where/term").and_then(Value::as_str).map(str::to_owned),
            unexplained_term: report.pointer("/unexplained/term").and_then(Value::as_str).map(str::to_owned),
            effects: list("effects").iter().map(named).collect(),
            most_p: p().fold(f64::NAN, f64::max),
            entropy: -p()
                .chain([1.0 - p().sum::<f64>()])
                .filter(|p| *p > 0.0)
                .map(|p| p * p.ln())
                .sum::<f64>(),
            verdict_set,
            calibrated_fit: number("/gap/fit/calibrated"),
            calibrated: number("/gap/holdout/calibrated"),
            extended: number("/gap/holdout/extended"),
            sets,
        }
    }

    /// The sets among which the report holds the truth to be.
    pub(super) fn held(&self) -> impl Iterator<Item = &Set> {
        self.verdict_set.iter().filter_map(|index| self.sets.get(*index))
    }

    /// How probable it says that something unknown is at work.
    pub(super) fn unknown(&self) -> f64 {
        self.sets.iter().filter(|set| set.unknown).map(|set| set.p).sum()
    }

    /// How probable it says that it is right: the first name, else the likeliest set.
    pub(super) fn stated(&self) -> f64 {
        self.effects.first().map_or(self.most_p, |effect| effect.confidence)
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

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn an_answer_is_read_from_the_contracts_keys() {
        let report = json!({
            "verdict": "effects+unknown", "where": {"term": "adhesion"}, "unexplained": {"gap": 2.0, "term": "inertia"},
            "effects": [{"id": "sanding", "term": "adhesion", "confidence": 0.9, "equivalent": ["self_cleaning"],
                         "parameters": {"gain": {"value": 0.3, "ci95": [0.2, 0.4]}}}],
            "posterior": [{"effects": ["sanding"], "unknown": true, "p": 0.5}, {"effects": [], "unknown": false, "p": 0.5}],
            "verdict_set": [0, 7],
            "gap": {"fit": {"calibrated": 9.0}, "holdout": {"calibrated": 8.0, "extended": 2.0}}
        });
        let answer = Answer::read(&report);
        assert_eq!((answer.stated(), answer.most_p), (0.9, 0.5));
        assert!((answer.entropy - 2.0_f64.ln()).abs() < 1e-12);
        assert_eq!(answer.unknown(), 0.5);
        let held: Vec<&Set> = answer.held().collect();
        assert_eq!(
            held,
            [&Set { effects: vec!["sanding".into()], unknown: true, p: 0.5 }],
            "there is no eighth set"
        );
        assert_eq!(answer.word(), "sanding + unknown");
        assert!(answer.effects[0].is("self_cleaning") && !answer.effects[0].is("brake_lag"));
        assert_eq!(answer.effects[0].parameters["gain"], (0.3, 0.2, 0.4));
        assert_eq!((answer.calibrated_fit, answer.calibrated, answer.extended), (9.0, 8.0, 2.0));
    }
}
