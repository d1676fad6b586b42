//! What a run made to tell models apart says of the sets that were possible before it.
//!
//! Every model predicts the run with what earlier recordings taught it. Errors of a model whose law has another form are neither
//! white nor of known size, so each window counts as `per_window` independent errors of a size that is not known: its likelihood falls with that
//! power of the gap (profile likelihood of a normal law). Something that no id names leaves what a right model would, times an
//! `allowance`, or what tolerances alone leave if that is less: a window in which they err as little says nothing of it. Both figures are
//! learnt from simulated cases, and so is how far the likeliest set is believed after that ([`trust`](crate::decide::trust)).

use crate::answer::schema::PosteriorSet;
use crate::decide::trust::{self, Ground, Trust};
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
    /// How far the likeliest set is believed.
    #[serde(default)]
    pub trust: Trust,
}

impl Default for TestWeights {
    /// Set by hand, for a program that has learnt nothing.
    fn default() -> Self {
        Self {
            provenance: "set by hand".to_owned(),
            per_window: 1.0,
            allowance: 1.5,
            tests: 0,
            trust: Trust::PLAIN,
        }
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
    /// The weights with which the truth is likeliest after tests whose answer is known, and how far what is likeliest by them may be
    /// believed.
    pub fn fit(taught: &[Taught], provenance: &str) -> Self {
        let likeliest = Self::likeliest(taught, provenance);
        let grounds = taught.iter().filter_map(|(test, sets, right)| {
            let (index, ground) = test.likeliest(sets, &test.reweigh(sets, &likeliest))?;
            Some((ground, right[index]))
        });
        Self { trust: Trust::fit(&grounds.collect::<Vec<(Ground, bool)>>()), ..likeliest }
    }

    /// The weights alone.
    fn likeliest(taught: &[Taught], provenance: &str) -> Self {
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
                trust: Trust::PLAIN,
            })
        });
        tried.max_by(|a, b| score(a).total_cmp(&score(b))).unwrap_or_default()
    }
}

impl TestRun {
    /// The sets in their order, with the probabilities that they have after this test: the likeliest as far as it is believed, the
    /// others and what is not listed share the rest as before.
    pub fn after(&self, sets: &[PosteriorSet], weights: &TestWeights) -> Vec<PosteriorSet> {
        let mut after = self.reweigh(sets, weights);
        let Some((index, ground)) = self.likeliest(sets, &after) else { return after };
        let (stated, believed) = (after[index].p, weights.trust.probability(&ground));
        let others = if stated < 1.0 { (1.0 - believed) / (1.0 - stated) } else { 0.0 };
        for (k, set) in after.iter_mut().enumerate() {
            set.p = if k == index { believed } else { set.p * others };
        }
        after
    }

    /// Which set is likeliest, and what it is believed by; `None` where the test says nothing of it.
    fn likeliest(&self, sets: &[PosteriorSet], after: &[PosteriorSet]) -> Option<(usize, Ground)> {
        let index = (0..after.len()).max_by(|a, b| after[*a].p.total_cmp(&after[*b].p))?;
        let natural = self.root_mean_square(&self.natural)?;
        let left = self.best(&sets[index]).and_then(|model| self.root_mean_square(&model.windows));
        let left = left.filter(|_| !sets[index].unknown).map(|left| left / natural);
        Some((index, trust::ground(after[index].p, left)))
    }

    /// RMS over the windows in which every model has a gap; `None` without any.
    fn root_mean_square(&self, gaps: &[f64]) -> Option<f64> {
        let known: Vec<f64> =
            (0..gaps.len()).filter(|k| self.is_known(*k)).map(|k| gaps[k].powi(2)).collect();
        (!known.is_empty()).then(|| (known.iter().sum::<f64>() / known.len() as f64).sqrt())
    }

    /// The sets in their order, with the probabilities that follow from the gaps alone. A set is as likely as the best model whose
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
        if set.unknown {
            let at_most = |k: usize| self.calibrated().map_or(f64::INFINITY, |model| model.windows[k]);
            return of_gaps(&|k| at_most(k).min(weights.allowance * self.natural[k]));
        }
        self.best(set).map_or(f64::NEG_INFINITY, |model| of_gaps(&|k| model.windows[k]))
    }

    /// The model with tolerances alone.
    fn calibrated(&self) -> Option<&Tested> {
        self.models.iter().find(|model| model.effects.is_empty())
    }

    /// The model that leaves least by the logarithms of the known windows, of those whose effects a set holds; the calibrated one
    /// where there is none.
    fn best(&self, set: &PosteriorSet) -> Option<&Tested> {
        let is_of = |model: &&Tested| {
            !model.effects.is_empty() && model.effects.iter().all(|id| set.effects.contains(id))
        };
        let left = |model: &Tested| -> f64 {
            (0..self.natural.len()).filter(|k| self.is_known(*k)).map(|k| model.windows[k].ln()).sum()
        };
        let best = self.models.iter().filter(is_of).min_by(|a, b| left(a).total_cmp(&left(b)));
        best.or_else(|| self.calibrated())
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

    #[test]
    fn the_likeliest_is_believed_the_less_the_more_it_leaves() {
        let weights =
            TestWeights { trust: Trust { offset: 0.0, slope: 1.0, left: -1.0 }, ..TestWeights::default() };
        let after = |a: f64, sets: &[PosteriorSet]| -> Vec<f64> {
            let test = TestRun {
                models: vec![model(&[], 3.0 * a), model(&["a"], a), model(&["b"], 2.0 * a)],
                natural: vec![1.0; 6],
            };
            test.after(sets, &weights).iter().map(|set| set.p).collect()
        };
        let [natural, more] = [1.0, 1.4].map(|a| after(a, &sets()));
        assert!(natural[0] > 0.9, "{natural:?}");
        // The likeliest still, and less likely at least by what it leaves.
        let alone = |a: f64| ((a / (1.0 - a)).ln() - f64::ln(1.4)).exp();
        assert!(more[0] / (1.0 - more[0]) < alone(natural[0]) + 1e-9, "{more:?}");
        // What is not listed gains as others do.
        let unlisted = |p: &[f64]| 1.0 - p.iter().sum::<f64>();
        assert!(unlisted(&more) > 1.2 * unlisted(&natural), "{more:?} {natural:?}");
        // A set that was certain may be doubted too.
        let certain = after(2.0, &[set(&["a"], false, 1.0)]);
        assert!(certain[0] < 1.0 && certain[0] > 0.9, "{certain:?}");
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
