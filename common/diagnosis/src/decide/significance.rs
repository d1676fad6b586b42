//! How well the best of the whole library scores where there is nothing to find.
//!
//! Under no effect, whitened innovations are white but for what the disturbance model misses. Stretches of the final
//! model's innovations get random signs (a wild block bootstrap, which keeps whatever colour is left in them), each
//! candidate's gain is refitted in linear form with the nuisances projected out and counted as it is counted in the recordings, and
//! the maximum over the library is kept. A quantile of it is the alarm threshold, so that one case in a hundred without an
//! effect gains more by a filter.

use crate::decide::criteria::{Criteria, Significance};
use crate::decide::round::Round;
use crate::fit::frozen::FrozenFit;
use crate::fit::solver::dot;
use crate::predict::disturbances::OUTLIER_SIGMA;
use crate::predict::localise;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Maxima over the library under no effect, rising.
#[derive(Clone, Debug)]
pub struct Chance {
    maxima: Vec<f64>,
    level: f64,
}

impl Chance {
    /// Bootstraps the candidates of a round with the innovations of `best`.
    pub fn new(round: &Round, nuisances: usize, best: &FrozenFit, criteria: &Criteria, seed: u64) -> Self {
        let significance = &criteria.significance;
        let clip = |r: &f64| r.clamp(-OUTLIER_SIGMA, OUTLIER_SIGMA);
        let residuals: Vec<f64> = best.fitted.residuals.iter().map(clip).collect();
        let length = best.whitening.stretch(significance.stretch_s);
        let scores: Vec<Scores> = round
            .gains
            .iter()
            .filter_map(|g| Scores::new(&g.fitted.columns, nuisances, &residuals, length))
            .collect();
        Self::of(&scores, residuals.len().div_ceil(length), criteria, seed)
    }

    /// The largest gain in each of the replicates over so many stretches.
    fn of(scores: &[Scores], stretches: usize, criteria: &Criteria, seed: u64) -> Self {
        let Significance { level, replicates, search_factor, .. } = criteria.significance;
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut maxima: Vec<f64> = (0..replicates)
            .map(|_| {
                let signs: Vec<f64> =
                    (0..stretches).map(|_| if random.random::<bool>() { 1.0 } else { -1.0 }).collect();
                search_factor * largest(scores, &signs, criteria)
            })
            .collect();
        maxima.sort_by(f64::total_cmp);
        Self { maxima, level }
    }

    /// The alarm threshold.
    pub fn threshold(&self) -> f64 {
        let index = ((1.0 - self.level) * self.maxima.len() as f64) as usize;
        self.maxima.get(index.min(self.maxima.len().saturating_sub(1))).copied().unwrap_or(0.0)
    }

    /// Probability that the best of the library gains as much by chance.
    pub fn p_value(&self, gain: f64) -> f64 {
        let above = self.maxima.iter().filter(|m| **m >= gain).count();
        (above + 1) as f64 / (self.maxima.len() + 1) as f64
    }
}

/// What the best candidate gains, see [`Scores::more_than`].
fn largest(scores: &[Scores], signs: &[f64], criteria: &Criteria) -> f64 {
    scores.iter().fold(0.0, |best, scores| scores.more_than(best, signs, criteria))
}

/// A candidate's score in each stretch and its curvature there, nuisances projected out.
struct Scores {
    stretches: Vec<(DVector<f64>, DMatrix<f64>)>,
    inverse: DMatrix<f64>,
}

impl Scores {
    fn new(columns: &[Vec<f64>], nuisances: usize, residuals: &[f64], length: usize) -> Option<Self> {
        if columns.len() <= nuisances || columns[0].len() != residuals.len() {
            return None;
        }
        let (known, own) = columns.split_at(nuisances);
        let own = beside(known, own)?;
        let stretches: Vec<(DVector<f64>, DMatrix<f64>)> = residuals
            .chunks(length)
            .enumerate()
            .map(|(stretch, residuals)| {
                let part = |c: usize| &own[c][stretch * length..stretch * length + residuals.len()];
                (DVector::from_fn(own.len(), |i, _| dot(part(i), residuals)), gram(own.len(), part))
            })
            .collect();
        let whole = stretches.iter().fold(DMatrix::zeros(own.len(), own.len()), |sum, (_, part)| sum + part);
        Some(Self { stretches, inverse: ridged(whole).try_inverse()? })
    }

    /// What the candidate gains where the innovations of each stretch have this sign, counted as [`counted`] counts what it gains in the
    /// recordings, or `best` if that is more.
    fn more_than(&self, best: f64, signs: &[f64], criteria: &Criteria) -> f64 {
        let sum = |sum, ((score, _), sign): (&(DVector<f64>, DMatrix<f64>), &f64)| sum + score * *sign;
        let none = DVector::zeros(self.inverse.nrows());
        let score: DVector<f64> = self.stretches.iter().zip(signs).fold(none, sum);
        let step = &self.inverse * &score;
        let all = 0.5 * score.dot(&step);
        // What is counted is no more than all; most candidates end here.
        if all.is_nan() || all <= best {
            return best;
        }
        let gained = |((score, curvature), sign): (&(DVector<f64>, DMatrix<f64>), &f64)| {
            sign * score.dot(&step) - 0.5 * step.dot(&(curvature * &step))
        };
        best.max(counted(all, || self.stretches.iter().zip(signs).map(gained).collect(), criteria))
    }
}

/// What of a gain is compared with chance: a small one counts where it lasts, outside of the few stretches that gain most, as in its
/// acceptance.
pub(crate) fn counted(gain: f64, by_stretch: impl FnOnce() -> Vec<f64>, criteria: &Criteria) -> f64 {
    if gain > criteria.acceptance.certain_gain {
        return gain;
    }
    gain.min(localise::lasting(by_stretch(), criteria.localisation.event_share))
}

/// What of the columns `own` the columns `known` cannot make.
fn beside(known: &[Vec<f64>], own: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let inner = ridged(gram(known.len(), |c| known[c].as_slice())).try_inverse()?;
    let project = |column: &Vec<f64>| {
        let shares = &inner * DVector::from_fn(known.len(), |i, _| dot(&known[i], column));
        let mut rest = column.clone();
        for (known, share) in known.iter().zip(&shares) {
            rest.iter_mut().zip(known).for_each(|(rest, known)| *rest -= share * known);
        }
        rest
    };
    Some(own.iter().map(project).collect())
}

/// Products of columns with each other.
fn gram<'c>(count: usize, column: impl Fn(usize) -> &'c [f64]) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(count, count);
    for i in 0..count {
        for j in 0..=i {
            let product = dot(column(i), column(j));
            all[(i, j)] = product;
            all[(j, i)] = product;
        }
    }
    all
}

/// A curvature that can be inverted although a parameter does nothing.
fn ridged(mut curvature: DMatrix<f64>) -> DMatrix<f64> {
    let largest = (0..curvature.nrows()).map(|i| curvature[(i, i)]).fold(0.0, f64::max);
    (0..curvature.nrows()).for_each(|i| curvature[(i, i)] += 1e-9 * largest + 1e-12);
    curvature
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};

    /// Samples in a stretch, stretches, and candidates of the library.
    const LENGTH: usize = 50;
    const STRETCHES: usize = 60;
    const CANDIDATES: usize = 8;

    /// A column that goes up and down slowly, as what an effect does to innovations.
    fn slow(random: &mut Pcg64Mcg) -> Vec<f64> {
        let mut now: f64 = StandardNormal.sample(random);
        let mut next = || {
            let push: f64 = StandardNormal.sample(random);
            now = 0.97 * now + 0.24 * push;
            now
        };
        (0..LENGTH * STRETCHES).map(|_| next()).collect()
    }

    #[test]
    fn probabilities_of_what_is_gained_by_chance_are_even() {
        let mut random = Pcg64Mcg::seed_from_u64(41);
        let mut criteria = Criteria::default();
        criteria.significance.search_factor = 1.0;
        let draws = 200;
        let mut below = [0; 3];
        let levels = [0.02, 0.1, 0.5];
        for draw in 0..draws {
            let residuals: Vec<f64> =
                (0..LENGTH * STRETCHES).map(|_| StandardNormal.sample(&mut random)).collect();
            let scores: Vec<Scores> = (0..CANDIDATES)
                .map(|candidate| {
                    let columns: Vec<Vec<f64>> = (0..3 + candidate % 2).map(|_| slow(&mut random)).collect();
                    Scores::new(&columns, 2, &residuals, LENGTH).unwrap()
                })
                .collect();
            let found = largest(&scores, &[1.0; STRETCHES], &criteria);
            let p = Chance::of(&scores, STRETCHES, &criteria, draw).p_value(found);
            (0..3).for_each(|at| below[at] += usize::from(p <= levels[at]));
        }
        println!("p at most {levels:?}: {below:?} of {draws}");
        for (count, level) in below.into_iter().zip(levels) {
            let expected = level * draws as f64;
            let scatter = (expected * (1.0 - level)).sqrt();
            assert!((count as f64 - expected).abs() < 3.0 * scatter + 1.0, "{count} of {draws} at {level}");
        }
    }

    #[test]
    fn what_lasts_is_beyond_chance_and_what_happens_once_is_not() {
        let mut random = Pcg64Mcg::seed_from_u64(42);
        let criteria = Criteria::default();
        let columns: Vec<Vec<f64>> = (0..3).map(|_| slow(&mut random)).collect();
        let p_of = |shown: &dyn Fn(usize) -> f64, random: &mut Pcg64Mcg| {
            let noise = |k: usize| -> f64 {
                let noise: f64 = StandardNormal.sample(random);
                noise + shown(k / LENGTH) * columns[2][k]
            };
            let residuals: Vec<f64> = (0..LENGTH * STRETCHES).map(noise).collect();
            let scores = [Scores::new(&columns, 2, &residuals, LENGTH).unwrap()];
            let found = largest(&scores, &[1.0; STRETCHES], &criteria);
            Chance::of(&scores, STRETCHES, &criteria, 1).p_value(found)
        };
        let lasting = p_of(&|_| 0.15, &mut random);
        let once = p_of(&|stretch| if stretch == 7 { 1.2 } else { 0.0 }, &mut random);
        println!("p of what lasts {lasting:.4}, of what happens once {once:.4}");
        assert!(lasting < 0.01 && once > 0.1);
    }
}
