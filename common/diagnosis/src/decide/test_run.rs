//! What a run made to tell models apart says of the sets that were possible before it.
//!
//! Every model predicts the run with what earlier recordings taught it. Errors of a model whose law has another form are neither
//! white nor of known size, so each window counts as `per_window` independent errors of a size that is not known: its likelihood falls with that
//! power of the gap (profile likelihood of a normal law). Something that no id names leaves what a right model would, times an
//! `allowance`, or what tolerances alone leave if that is less: a window in which they err as little says nothing of it. Both figures are
//! learnt from simulated cases.

use crate::answer::schema::PosteriorSet;
use serde::{Deserialize, Serialize};

/// A model that was tested.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tested {
    /// Ids of its effects; empty for the calibrated model.
    pub effects: Vec<String>,
    /// Gap of each window of the test, sensor sigmas.
    pub windows: Vec<f64>,
}

/// What models did on a test.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TestRun {
    /// The models, the calibrated one first.
    pub models: Vec<Tested>,
    /// Gap of each window that a right model would leave.
    pub natural: Vec<f64>,
}

/// How far a test moves probabilities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TestWeights {
    /// Which tests both were learnt from.
    pub provenance: String,
    /// Independent errors that a window counts as.
    pub per_window: f64,
    /// Gap that a model of the right cause leaves, over that of a right model.
    pub allowance: f64,
    /// Number of tests from which both were learnt.
    pub tests: usize,
}

impl Default for TestWeights {
    /// Set by hand, for a program that has learnt nothing.
    fn default() -> Self {
        Self { provenance: "set by hand".to_owned(), per_window: 1.0, allowance: 1.5, tests: 0 }
    }
}

/// Values that are tried when learning.
const PER_WINDOW: [f64; 8] = [0.0, 0.1, 0.2, 0.4, 0.7, 1.0, 2.0, 4.0];
const ALLOWANCE: [f64; 7] = [1.0, 1.25, 1.5, 2.0, 3.0, 5.0, 8.0];
/// Least probability of the truth that counts, so that one surprise does not decide.
const LEAST: f64 = 0.02;

/// A test, the sets before it, and whether each of them is the truth.
pub type Taught = (TestRun, Vec<PosteriorSet>, Vec<bool>);

impl TestWeights {
    /// The weights with which the truth is likeliest after tests whose answer is known.
    pub fn fit(taught: &[Taught], provenance: &str) -> Self {
        let score = |weights: &Self| -> f64 {
            let of = |(test, sets, right): &Taught| {
                let after = test.reweigh(sets, weights);
                let p: f64 = after.iter().zip(right).filter(|(_, right)| **right).map(|(set, _)| set.p).sum();
                p.max(LEAST).ln()
            };
            taught.iter().map(of).sum()
        };
        let tried = PER_WINDOW.iter().flat_map(|per_window| {
            ALLOWANCE.map(|allowance| Self {
                provenance: provenance.to_owned(),
                per_window: *per_window,
                allowance,
                tests: taught.len(),
            })
        });
        tried.max_by(|a, b| score(a).total_cmp(&score(b))).unwrap_or_default()
    }
}

impl TestRun {
    /// The sets in their order, with the probabilities that they have after this test. A set is as likely as the best model whose
    /// effects it holds.
    pub fn reweigh(&self, sets: &[PosteriorSet], weights: &TestWeights) -> Vec<PosteriorSet> {
        if self.models.is_empty() {
            return sets.to_vec();
        }
        let logs: Vec<f64> = sets.iter().map(|set| self.log_likelihood(set, weights)).collect();
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut after: Vec<PosteriorSet> = sets
            .iter()
            .zip(&logs)
            .map(|(set, log)| PosteriorSet { p: set.p * (log - most).exp(), ..set.clone() })
            .collect();
        let total: f64 = after.iter().map(|set| set.p).sum();
        if total > 0.0 {
            // What is not listed keeps its share.
            let listed: f64 = sets.iter().map(|set| set.p).sum();
            after.iter_mut().for_each(|set| set.p *= listed / total);
        }
        after
    }

    fn log_likelihood(&self, set: &PosteriorSet, weights: &TestWeights) -> f64 {
        let of_gaps = |gap: &dyn Fn(usize) -> f64| -> f64 {
            let known = (0..self.natural.len()).filter(|k| self.is_known(*k));
            -weights.per_window * known.map(|k| gap(k).ln()).sum::<f64>()
        };
        let of_model = |model: &Tested| of_gaps(&|k| model.windows[k]);
        let calibrated = self.models.iter().find(|model| model.effects.is_empty());
        if set.unknown {
            let at_most = |k: usize| calibrated.map_or(f64::INFINITY, |model| model.windows[k]);
            return of_gaps(&|k| at_most(k).min(weights.allowance * self.natural[k]));
        }
        let is_of = |model: &&Tested| {
            !model.effects.is_empty() && model.effects.iter().all(|id| set.effects.contains(id))
        };
        let best = self.models.iter().filter(is_of).map(of_model).fold(f64::NEG_INFINITY, f64::max);
        if best.is_finite() { best } else { calibrated.map_or(f64::NEG_INFINITY, of_model) }
    }

    /// Whether every model has a gap in a window.
    fn is_known(&self, window: usize) -> bool {
        let is = |gaps: &Vec<f64>| gaps.get(window).is_some_and(|gap| gap.is_finite() && *gap > 0.0);
        is(&self.natural) && self.models.iter().all(|model| is(&model.windows))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    fn set(effects: &[&str], unknown: bool, p: f64) -> PosteriorSet {
        PosteriorSet { effects: effects.iter().map(|id| (*id).to_owned()).collect(), unknown, p }
    }

    fn model(effects: &[&str], gap: f64) -> Tested {
        Tested { effects: effects.iter().map(|id| (*id).to_owned()).collect(), windows: vec![gap; 6] }
    }

    fn sets() -> Vec<PosteriorSet> {
        vec![set(&["a"], false, 0.4), set(&["b"], false, 0.3), set(&[], false, 0.1), set(&[], true, 0.15)]
    }

    fn after(gaps: [f64; 3]) -> Vec<f64> {
        let [none, a, b] = gaps;
        let test = TestRun {
            models: vec![model(&[], none), model(&["a"], a), model(&["b"], b)],
            natural: vec![1.0; 6],
        };
        test.reweigh(&sets(), &TestWeights::default()).iter().map(|set| set.p).collect()
    }

    #[test]
    fn what_predicts_the_test_becomes_likely_and_what_is_not_listed_keeps_its_share() {
        let p = after([4.0, 3.0, 1.2]);
        assert!(p[1] > 0.8, "{p:?}");
        assert!((p.iter().sum::<f64>() - 0.95).abs() < 1e-12);
        // All fail: something else is at work. All do alike: the test says nothing of these, and little of others.
        assert!(after([9.0, 9.0, 9.0])[3] > 0.9);
        let p = after([1.5, 1.5, 1.5]);
        assert!(p.iter().zip(sets()).all(|(after, before)| (after - before.p).abs() < 1e-12), "{p:?}");
    }

    #[test]
    fn windows_without_a_figure_count_nothing_and_a_test_without_windows_changes_nothing() {
        let mut test = TestRun {
            models: vec![model(&[], 4.0), model(&["a"], 4.0), model(&["b"], 1.0)],
            natural: vec![1.0; 6],
        };
        test.models[2].windows[1..].fill(f64::NAN);
        let p = test.reweigh(&sets(), &TestWeights::default());
        assert!((p[1].p / p[0].p - 4.0 * 0.3 / 0.4).abs() < 1e-9, "one window: {p:?}");
        let p = TestRun::default().reweigh(&sets(), &TestWeights::default());
        assert!(p.iter().zip(sets()).all(|(after, before)| (after.p - before.p).abs() < 1e-12), "{p:?}");
    }

    /// Two models whose gaps scatter; the right one is better by a third on average. What is learnt states probabilities that come true.
    #[test]
    fn weights_are_learnt_so_that_probabilities_come_true() {
        let mut random = Pcg64Mcg::seed_from_u64(4);
        let mut taught = |number: usize| -> Vec<Taught> {
            let one = |_| {
                let is_a = random.random::<f64>() < 0.5;
                let mut windows = |mean: f64| -> Vec<f64> {
                    (0..6).map(|_| mean * (0.8 * (random.random::<f64>() - 0.5)).exp()).collect()
                };
                let [a, b] = if is_a { [1.5, 1.9] } else { [1.9, 1.5] }.map(&mut windows);
                let of = |id: &str, windows| Tested { effects: vec![id.to_owned()], windows };
                let test =
                    TestRun { models: vec![model(&[], 3.0), of("a", a), of("b", b)], natural: vec![1.0; 6] };
                (test, vec![set(&["a"], false, 0.5), set(&["b"], false, 0.5)], vec![is_a, !is_a])
            };
            (0..number).map(one).collect()
        };
        let weights = TestWeights::fit(&taught(200), "");
        let (mut stated, mut right) = (0.0, 0.0);
        for (test, sets, is_right) in taught(2000) {
            let after = test.reweigh(&sets, &weights);
            let best = usize::from(after[1].p > after[0].p);
            stated += after[best].p / 2000.0;
            right += f64::from(u8::from(is_right[best])) / 2000.0;
        }
        println!("{weights:?}: stated {stated:.3}, right {right:.3} of 2000 others");
        assert!(right > 0.9 && (stated - right).abs() < 0.05, "{stated} {right}");
    }
}
