//! How well the best of the whole library scores where there is nothing to find.
//!
//! Under no effect, whitened innovations are white but for what the disturbance model misses. Stretches of the final
//! model's innovations get random signs (a wild block bootstrap, which keeps whatever colour is left in them), each
//! candidate's gain is refitted in linear form with the nuisances projected out, and the maximum over the library is
//! kept. A quantile of it is the alarm threshold, so that one case in fifty without an effect raises an alarm.

use crate::decide::criteria::Significance;
use crate::decide::round::Round;
use crate::fit::frozen::FrozenFit;
use crate::fit::solver::dot;
use crate::predict::disturbances::OUTLIER_SIGMA;
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
    pub fn new(
        round: &Round,
        nuisances: usize,
        best: &FrozenFit,
        criteria: &Significance,
        seed: u64,
    ) -> Self {
        let clip = |r: &f64| r.clamp(-OUTLIER_SIGMA, OUTLIER_SIGMA);
        let residuals: Vec<f64> = best.fitted.residuals.iter().map(clip).collect();
        let length = best.whitening.stretch(criteria.stretch_s);
        let scores: Vec<Scores> = round
            .gains
            .iter()
            .filter_map(|g| Scores::new(&g.fitted.columns, nuisances, &residuals, length))
            .collect();
        let blocks = residuals.len().div_ceil(length);
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut maxima: Vec<f64> = (0..criteria.replicates)
            .map(|_| {
                let signs: Vec<f64> =
                    (0..blocks).map(|_| if random.random::<bool>() { 1.0 } else { -1.0 }).collect();
                criteria.search_factor * scores.iter().map(|s| s.gain(&signs)).fold(0.0, f64::max)
            })
            .collect();
        maxima.sort_by(f64::total_cmp);
        Self { maxima, level: criteria.level }
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

/// A candidate's scores by block, nuisances projected out.
struct Scores {
    by_block: Vec<DVector<f64>>,
    inverse: DMatrix<f64>,
}

impl Scores {
    fn new(columns: &[Vec<f64>], nuisances: usize, residuals: &[f64], length: usize) -> Option<Self> {
        if columns.len() <= nuisances || columns[0].len() != residuals.len() {
            return None;
        }
        let n = columns.len();
        let gram = DMatrix::from_fn(n, n, |i, j| if j <= i { dot(&columns[i], &columns[j]) } else { 0.0 });
        let gram = DMatrix::from_fn(n, n, |i, j| gram[(i.max(j), i.min(j))]);
        let ridge = |m: &DMatrix<f64>| {
            let size = (0..m.nrows()).map(|i| m[(i, i)]).fold(0.0, f64::max);
            m + DMatrix::identity(m.nrows(), m.ncols()) * (1e-9 * size + 1e-12)
        };
        let inner = ridge(&gram.view((0, 0), (nuisances, nuisances)).into_owned()).try_inverse()?;
        let cross = gram.view((nuisances, 0), (n - nuisances, nuisances)).into_owned();
        let project = &cross * inner;
        let own = gram.view((nuisances, nuisances), (n - nuisances, n - nuisances)).into_owned();
        let inverse = ridge(&(own - &project * cross.transpose())).try_inverse()?;
        let by_block = residuals
            .chunks(length)
            .enumerate()
            .map(|(b, block)| {
                let part = |c: usize| dot(&columns[c][b * length..b * length + block.len()], block);
                let nuisance = DVector::from_fn(nuisances, |i, _| part(i));
                DVector::from_fn(n - nuisances, |i, _| part(nuisances + i)) - &project * nuisance
            })
            .collect();
        Some(Self { by_block, inverse })
    }

    fn gain(&self, signs: &[f64]) -> f64 {
        let mut score = DVector::zeros(self.inverse.nrows());
        for (block, sign) in self.by_block.iter().zip(signs) {
            score += block * *sign;
        }
        let gain = 0.5 * score.dot(&(&self.inverse * &score));
        if gain.is_finite() { gain } else { 0.0 }
    }
}
