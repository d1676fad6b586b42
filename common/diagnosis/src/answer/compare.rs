//! Two reports of one vehicle, from different days or of different builds: what is new, what is gone, what has changed.

use super::schema::{FoundEffect, ParameterEstimate, Report};

/// Two-sided 95 % quantile of the normal distribution.
const NORMAL_95: f64 = 1.96;

/// What became of an effect between two reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Found in both, and no value differs by more than its intervals allow.
    Same,
    /// Found in both, and a value differs.
    Moved,
    /// Found in the second one only.
    New,
    /// Found in the first one only.
    Gone,
}

/// A parameter in both reports, as far as each has it.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterChange {
    /// Name in the catalogue.
    pub name: String,
    /// In the first report.
    pub first: Option<ParameterEstimate>,
    /// In the second.
    pub second: Option<ParameterEstimate>,
    /// Whether the two differ by more than chance, at 95 %; `false` where one is missing.
    pub differs: bool,
}

/// An effect in both reports, as far as each names it.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectChange {
    /// Id in the catalogue.
    pub id: String,
    /// What became of it.
    pub change: Change,
    /// In the first report.
    pub first: Option<FoundEffect>,
    /// In the second.
    pub second: Option<FoundEffect>,
    /// Its parameters, by name.
    pub parameters: Vec<ParameterChange>,
}

/// Compares the effects of two reports: those of the second in its order, then those that are gone.
pub fn effects(first: &Report, second: &Report) -> Vec<EffectChange> {
    let gone = first.effects.iter().filter(|effect| of(second, &effect.id).is_none());
    let ids = second.effects.iter().chain(gone).map(|effect| effect.id.as_str());
    ids.map(|id| effect(id, of(first, id), of(second, id))).collect()
}

fn of<'a>(report: &'a Report, id: &str) -> Option<&'a FoundEffect> {
    report.effects.iter().find(|effect| effect.id == id)
}

fn effect(id: &str, first: Option<&FoundEffect>, second: Option<&FoundEffect>) -> EffectChange {
    let mut names: Vec<&String> =
        [first, second].iter().flatten().flat_map(|e| e.parameters.keys()).collect();
    names.sort_unstable();
    names.dedup();
    let parameters: Vec<ParameterChange> = names
        .into_iter()
        .map(|name| {
            let [first, second] = [first, second].map(|e| e.and_then(|e| e.parameters.get(name)).copied());
            let differs = first.zip(second).is_some_and(|(a, b)| differ(&a, &b));
            ParameterChange { name: name.clone(), first, second, differs }
        })
        .collect();
    let change = match (first, second) {
        (Some(_), Some(_)) if parameters.iter().any(|p| p.differs) => Change::Moved,
        (Some(_), Some(_)) => Change::Same,
        (None, _) => Change::New,
        (_, None) => Change::Gone,
    };
    EffectChange { id: id.to_owned(), change, first: first.cloned(), second: second.cloned(), parameters }
}

/// Whether two estimates differ by more than their standard errors together explain. A value without an interval was chosen,
/// and any other choice differs. That a law has another form moves both alike, so noise alone counts.
fn differ(a: &ParameterEstimate, b: &ParameterEstimate) -> bool {
    let error = |p: &ParameterEstimate| {
        let [low, high] = p.by_noise.unwrap_or(p.ci95);
        (high - low) / (2.0 * NORMAL_95)
    };
    (a.value - b.value).abs() > NORMAL_95 * error(a).hypot(error(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_differ_by_more_than_their_errors_together() {
        let at = |value: f64, half: f64| ParameterEstimate::new(value, [value - half, value + half]);
        let same_law = |value: f64| ParameterEstimate {
            ci95: [0.0, 2.0],
            by_noise: Some([value - 0.1, value + 0.1]),
            value,
        };
        for (a, b, differs) in [
            (at(1.0, 0.1), at(1.05, 0.1), false),
            // The intervals overlap, and yet the difference is more than their errors explain.
            (at(1.0, 0.1), at(1.16, 0.1), true),
            (at(1.0, 0.1), at(1.13, 0.1), false),
            (same_law(1.0), same_law(1.16), true),
            (at(1.0, 0.0), at(2.0, 0.0), true),
            (at(1.0, 0.0), at(1.0, 0.0), false),
        ] {
            assert_eq!(differ(&a, &b), differs, "{a:?} {b:?}");
        }
    }
}
