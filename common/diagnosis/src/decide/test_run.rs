//! What a run made to tell models apart says of the sets that were possible before it.
//!
//! Every model predicts the run with what earlier recordings taught it. Errors of a model whose law has another form are neither
//! white nor of known size, so each window counts as `per_window` independent errors of a size that is not known: its likelihood falls with that
//! power of the gap (profile likelihood of a normal law). So one known cause is told from another.
//!
//! Something unknown, or a set that was not listed, predicts nothing of its own. A known law that resembles it does in its place, and which one
//! that is, is as uncertain as the cause: it is as likely as known sets are on average, so a test that tells these apart leaves it its
//! share. That a known cause passes a test in which much happens speaks for it, and that all of them leave much against it, by
//! `explains` and `leaves`. All weights are learnt from simulated cases.

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
    /// Which tests all were learnt from.
    pub provenance: String,
    /// Independent errors that a window counts as.
    pub per_window: f64,
    /// Log-odds that a known cause gains on anything else, per logarithm of how far it brings the gap of a window below that of tolerances.
    pub explains: f64,
    /// Log-odds that it loses, per logarithm of how far it stays above what a right cause leaves.
    pub leaves: f64,
    /// Gap that a model of the right cause leaves, over that of a right model, whose law may have another form: geometric mean.
    pub allowance: f64,
    /// Number of tests from which all were learnt.
    pub tests: usize,
}

impl Default for TestWeights {
    /// Set by hand, for a program that has learnt nothing.
    fn default() -> Self {
        Self {
            provenance: "set by hand".to_owned(),
            per_window: 1.0,
            explains: 0.5,
            leaves: 1.0,
            allowance: 1.5,
            tests: 0,
        }
    }
}

/// Values that are tried when learning.
const PER_WINDOW: [f64; 9] = [0.0, 0.1, 0.2, 0.4, 0.7, 1.0, 2.0, 4.0, 8.0];
const LOG_ODDS: [f64; 7] = [0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0];
/// Least probability of the truth that counts, so that one surprise does not decide.
pub const LEAST: f64 = 0.02;

/// A test, the sets before it, and whether each of them is the truth.
pub type Taught = (TestRun, Vec<PosteriorSet>, Vec<bool>);

impl TestWeights {
    /// The weights with which the truth is likeliest after tests whose answer is known. Where no listed set is the truth, what is not
    /// listed is.
    pub fn fit(taught: &[Taught], provenance: &str) -> Self {
        let allowance = allowance(taught);
        let score = |weights: &Self| -> f64 {
            taught.iter().map(|taught| weights.of_truth(taught).max(LEAST).ln()).sum()
        };
        let tried = PER_WINDOW.iter().flat_map(|&per_window| {
            LOG_ODDS.iter().flat_map(move |&explains| {
                LOG_ODDS.map(|leaves| Self {
                    provenance: provenance.to_owned(),
                    per_window,
                    explains,
                    leaves,
                    allowance,
                    tests: taught.len(),
                })
            })
        });
        tried.max_by(|a, b| score(a).total_cmp(&score(b))).unwrap_or_default()
    }

    /// Probability of the truth after a test.
    pub fn of_truth(&self, (test, sets, right): &Taught) -> f64 {
        truth(&test.reweigh(sets, self), right)
    }
}

/// Probability of the truth among sets, of which it is known whether they are it; of what is not listed if none is.
pub fn truth(sets: &[PosteriorSet], right: &[bool]) -> f64 {
    if right.contains(&true) {
        sets.iter().zip(right).filter(|(_, right)| **right).map(|(set, _)| set.p).sum()
    } else {
        not_listed(sets)
    }
}

/// Gap that models of right causes left in a window over that of a right model, geometric mean; that of the program that has learnt
/// nothing where none was tested.
fn allowance(taught: &[Taught]) -> f64 {
    let of = |(test, sets, right): &Taught| -> Option<f64> {
        let is_known = |set: &PosteriorSet| !set.unknown && !set.effects.is_empty();
        let (set, _) = sets.iter().zip(right).find(|(set, right)| **right && is_known(set))?;
        let model = test.models.iter().find(|model| model.effects == set.effects)?;
        test.mean_log(&model.windows, &test.natural)
    };
    let all: Vec<f64> = taught.iter().filter_map(of).collect();
    if all.is_empty() {
        return TestWeights::default().allowance;
    }
    (all.iter().sum::<f64>() / all.len() as f64).exp().max(1.0)
}

/// Probability of all sets that are not listed.
pub fn not_listed(sets: &[PosteriorSet]) -> f64 {
    (1.0 - sets.iter().map(|set| set.p).sum::<f64>()).max(0.0)
}

impl TestRun {
    /// The sets in their order, with the probabilities that they have after this test. A known set is as likely as the best model whose
    /// effects it holds, something unknown alone and what is not listed as known sets are on average. What is not listed may grow or
    /// shrink with the test.
    pub fn reweigh(&self, sets: &[PosteriorSet], weights: &TestWeights) -> Vec<PosteriorSet> {
        let logs: Vec<f64> = self.models.iter().map(|model| self.log_likelihood(model, weights)).collect();
        let Some(best) = (0..logs.len()).max_by(|a, b| logs[*a].total_cmp(&logs[*b])) else {
            return sets.to_vec();
        };
        let otherwise = (-self.passed(best, weights)).exp();
        let by_model = |set: &PosteriorSet| (self.of_set(set, &logs) - logs[best]).exp();
        let known = || sets.iter().filter(|set| !set.unknown);
        let (of_known, p_known) =
            (known().map(|set| set.p * by_model(set)).sum::<f64>(), known().map(|set| set.p).sum::<f64>());
        let on_average = if p_known > 0.0 { of_known / p_known } else { 1.0 };
        let likelihood = |set: &PosteriorSet| match (set.unknown, set.effects.is_empty()) {
            (false, _) => by_model(set),
            (true, false) => otherwise * by_model(set),
            (true, true) => otherwise * on_average,
        };
        let mut after: Vec<PosteriorSet> =
            sets.iter().map(|set| PosteriorSet { p: set.p * likelihood(set), ..set.clone() }).collect();
        let of_listed: f64 = after.iter().map(|set| set.p).sum();
        let total = of_listed + not_listed(sets) * otherwise * on_average;
        if total > 0.0 {
            after.iter_mut().for_each(|set| set.p /= total);
        }
        after
    }

    /// Log-odds by which the best model's test speaks for a known cause.
    fn passed(&self, best: usize, weights: &TestWeights) -> f64 {
        let model = &self.models[best].windows;
        let calibrated = self.models.iter().find(|model| model.effects.is_empty());
        let explained = calibrated.and_then(|calibrated| self.mean_log(&calibrated.windows, model));
        let left = self.mean_log(model, &self.natural).map(|log| log - weights.allowance.ln());
        weights.explains * explained.unwrap_or(0.0).max(0.0) - weights.leaves * left.unwrap_or(0.0).max(0.0)
    }

    /// Log-likelihood of a set: of the best model of its effects, of the calibrated one where there is none.
    fn of_set(&self, set: &PosteriorSet, logs: &[f64]) -> f64 {
        let most = |is: &dyn Fn(&Tested) -> bool| {
            self.models.iter().zip(logs).filter(|(model, _)| is(model)).map(|(_, log)| *log).reduce(f64::max)
        };
        let is_of = |model: &Tested| {
            !model.effects.is_empty() && model.effects.iter().all(|id| set.effects.contains(id))
        };
        most(&is_of).or_else(|| most(&|model| model.effects.is_empty())).unwrap_or(f64::NEG_INFINITY)
    }

    fn log_likelihood(&self, model: &Tested, weights: &TestWeights) -> f64 {
        let known = (0..self.natural.len()).filter(|k| self.is_known(*k));
        -weights.per_window * known.map(|k| model.windows[k].ln()).sum::<f64>()
    }

    /// Mean logarithm of what one model leaves of a window over what another does; `None` without windows.
    fn mean_log(&self, of: &[f64], over: &[f64]) -> Option<f64> {
        let known: Vec<usize> = (0..self.natural.len()).filter(|k| self.is_known(*k)).collect();
        let sum: f64 = known.iter().map(|k| (of[*k] / over[*k]).ln()).sum();
        (!known.is_empty()).then(|| sum / known.len() as f64)
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
    fn what_predicts_the_test_becomes_likelier_than_its_rival() {
        let p = after([4.0, 3.0, 1.2]);
        assert!(p[1] > 0.7 && p[0] < 0.02 && p[2] < 0.02, "{p:?}");
        // All fail: something else is at work, listed or not. All do alike: the test says nothing.
        let p = after([9.0, 9.0, 9.0]);
        assert!(p[3] > 0.4 && 1.0 - p.iter().sum::<f64>() > 0.1, "{p:?}");
        let p = after([1.5, 1.5, 1.5]);
        assert!(p.iter().zip(sets()).all(|(after, before)| (after - before.p).abs() < 1e-12), "{p:?}");
    }

    /// Two rivals, of which one fails: the other has what that one had, and nothing of what something unknown has.
    #[test]
    fn a_rival_that_fails_leaves_something_unknown_its_share() {
        let none = TestWeights { explains: 0.0, ..TestWeights::default() };
        let test = TestRun {
            models: vec![model(&[], 9.0), model(&["a"], 1.4), model(&["b"], 5.0)],
            natural: vec![1.0; 6],
        };
        let beside =
            [set(&["a"], false, 0.3), set(&["b"], false, 0.3), set(&["a"], true, 0.1), set(&[], true, 0.3)];
        let p: Vec<f64> = test.reweigh(&beside, &none).iter().map(|set| set.p).collect();
        assert!(p[1] < 1e-3 && (p[0] / p[3] - (0.3 + 0.3) / 0.3).abs() < 0.01, "{p:?}");
        assert!((p[0] / p[2] - 0.3 / 0.1).abs() < 1e-9, "{p:?}");
        // What explains a test in which much happens gains on it.
        assert!(test.reweigh(&beside, &TestWeights::default())[0].p > p[0] + 0.1);
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

    #[test]
    fn where_no_listed_set_is_the_truth_what_is_not_listed_is() {
        let sets = sets();
        assert!((truth(&sets, &[false, true, false, false]) - 0.3).abs() < 1e-12);
        assert!((truth(&sets, &[false; 4]) - 0.05).abs() < 1e-12);
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
