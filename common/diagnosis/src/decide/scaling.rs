//! How probable it is that a name is right, from the grounds that its report gives (logistic regression).

use crate::answer::schema::{FoundEffect, Report};
use crate::decide::holds::left_over;
use crate::decide::newton;
use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// What the probability of a name follows from, and how many figures that are.
pub type Grounds = SVector<f64, GROUNDS>;
const GROUNDS: usize = 9;
/// A rival that gains this share of what the name gains counts nothing, one that gains so much counts whole; set by hand.
const RIVAL: [f64; 2] = [0.5, 0.9];
/// Growth of the gap without a name, in sensor sigmas, within which it counts; set by hand.
const GROWTH: [f64; 2] = [0.03, 3.0];

/// The grounds of a name in its report.
pub fn grounds(report: &Report, effect: &FoundEffect) -> Option<Grounds> {
    let gap = &report.gap;
    let carried = match report.carries_over {
        Some(_) => gap.holdout.reduction,
        None => 1.0 - gap.fit.extended / gap.fit.calibrated,
    };
    let carried = if carried.is_finite() { carried.clamp(-0.5, 1.0) } else { 0.0 };
    let freedom = (effect.parameters.len().max(1) as f64).ln();
    let elsewhere = report.evidence.is_some_and(|evidence| !evidence.at_likely_place);
    let nearest =
        effect.rivals.iter().map(|rival| rival.share).filter(|share| share.is_finite()).fold(0.0, f64::max);
    let rival = ((nearest - RIVAL[0]) / (RIVAL[1] - RIVAL[0])).clamp(0.0, 1.0);
    let shows = effect.gap_grows_without.map_or(0.0, |gap| gap.clamp(GROWTH[0], GROWTH[1]).ln());
    let elsewhere = f64::from(u8::from(elsewhere));
    let left = left_over(report).unwrap_or(0.0);
    let fails = f64::from(u8::from(report.carries_over == Some(false)));
    Some(Grounds::from([1.0, effect.score?, carried, freedom, elsewhere, rival, shows, left, fails]))
}

/// From the grounds of a name to a probability.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scaling {
    /// Log-odds where all grounds are zero.
    pub offset: f64,
    /// Log-odds for each unit of score.
    pub slope: f64,
    /// Log-odds for the whole gap of runs that were not fitted.
    #[serde(default)]
    pub carries: f64,
    /// Log-odds for each factor of e in the number of the effect's parameters.
    #[serde(default)]
    pub freedom: f64,
    /// Log-odds where nothing that is named acts where freeing a place gains most.
    #[serde(default)]
    pub elsewhere: f64,
    /// Log-odds where the nearest rival gains nine tenths of what it gains, or more.
    #[serde(default)]
    pub rival: f64,
    /// Log-odds for each factor of e by which the gap grows without it, in sensor sigmas.
    #[serde(default)]
    pub shows: f64,
    /// Log-odds for each factor of e by which more is left of the gap than a right model would leave.
    #[serde(default)]
    pub left: f64,
    /// Log-odds where the runs that were not fitted are predicted no better with the effects than without.
    #[serde(default)]
    pub fails: f64,
}

impl Scaling {
    /// The score as it is.
    pub const PLAIN: Self = Self {
        offset: 0.0,
        slope: 1.0,
        carries: 0.0,
        freedom: 0.0,
        elsewhere: 0.0,
        rival: 0.0,
        shows: 0.0,
        left: 0.0,
        fails: 0.0,
    };
    /// Widest prior around [`Self::PLAIN`], which keeps it sensible where there are few cases.
    const WIDTHS: [f64; GROUNDS] = [2.0, 0.5, 3.0, 1.5, 1.0, 1.0, 0.5, 2.0, 0.5];

    fn weights(&self) -> Grounds {
        let Self { offset, slope, carries, freedom, elsewhere, rival, shows, left, fails } = *self;
        Grounds::from([offset, slope, carries, freedom, elsewhere, rival, shows, left, fails])
    }

    fn of(weights: &Grounds) -> Self {
        let [offset, slope, carries, freedom, elsewhere, rival, shows, left, fails] = (*weights).into();
        Self { offset, slope, carries, freedom, elsewhere, rival, shows, left, fails }
    }

    /// Probability on these grounds.
    pub fn probability(&self, grounds: &Grounds) -> f64 {
        1.0 / (1.0 + (-self.weights().dot(grounds)).exp())
    }

    /// The most likely scaling for names of which it is known whether they were right, with a prior of this share of
    /// the widest; how often names are right at all may always be learnt.
    pub fn fit(names: &[(Grounds, bool)], width: f64) -> Self {
        let mut widths = Self::WIDTHS.map(|widest| width * widest);
        widths[0] = Self::WIDTHS[0];
        Self::PLAIN.moved(names, widths)
    }

    /// This scaling with [`Self::fails`] learnt from such names and all else kept.
    #[must_use]
    pub fn with_failing(&self, names: &[(Grounds, bool)]) -> Self {
        let mut widths = [KEPT; GROUNDS];
        widths[GROUNDS - 1] = Self::WIDTHS[GROUNDS - 1];
        Self { fails: Self { fails: 0.0, ..*self }.moved(names, widths).fails, ..*self }
    }

    /// The most likely scaling in view of names, around this one within these widths (Newton's method).
    fn moved(&self, names: &[(Grounds, bool)], widths: [f64; GROUNDS]) -> Self {
        let prior = self.weights();
        let precision = Precision::from_diagonal(&Grounds::from(widths.map(|width| width.powi(-2))));
        // Minus the log of the posterior.
        let cost = |at: &Grounds| {
            let off = at - prior;
            let of = |(grounds, right): &(Grounds, bool)| {
                let along = at.dot(grounds);
                (if *right { -along } else { along }).exp().ln_1p()
            };
            0.5 * off.dot(&(precision * off)) + names.iter().map(of).sum::<f64>()
        };
        let slopes = |at: &Grounds| {
            let mut gradient = precision * (at - prior);
            let mut curvature = precision;
            for (x, right) in names {
                let p = 1.0 / (1.0 + (-at.dot(x)).exp());
                gradient += x * (p - f64::from(u8::from(*right)));
                curvature += x * x.transpose() * (p * (1.0 - p));
            }
            (gradient, curvature)
        };
        Self::of(&newton::least(prior, cost, slopes))
    }
}

type Precision = SMatrix<f64, GROUNDS, GROUNDS>;
/// Width within which a weight that is to be kept may move.
const KEPT: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// Names that are right as often as a known scaling says: it is found again.
    #[test]
    fn a_scaling_is_learnt() {
        let truth = Scaling { offset: -1.0, slope: 0.6, carries: 2.0, ..Scaling::PLAIN };
        let mut random = Pcg64Mcg::seed_from_u64(5);
        let names: Vec<(Grounds, bool)> = (0..4000)
            .map(|_| {
                let [score, carried] = [6.0, 1.0].map(|size| size * random.random::<f64>());
                let grounds = Grounds::from([1.0, score - 1.0, carried, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                (grounds, random.random::<f64>() < truth.probability(&grounds))
            })
            .collect();
        let found = Scaling::fit(&names, 1.0);
        println!("{found:?}");
        for (score, carried) in [(-1.0, 0.0), (1.0, 1.0), (3.0, 0.0), (3.0, 0.8)] {
            let grounds = Grounds::from([1.0, score, carried, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let (found, truth) = (found.probability(&grounds), truth.probability(&grounds));
            assert!((found - truth).abs() < 0.05, "{score}, {carried}: {found} instead of {truth}");
        }
    }

    /// Names whose effects do not carry over are right less often than all else says: that alone is learnt.
    #[test]
    fn what_failing_to_carry_over_means_is_learnt_alone() {
        let stated = Scaling { offset: -2.0, carries: 0.02, ..Scaling::PLAIN };
        let truth = Scaling { fails: -1.5, ..stated };
        let mut random = Pcg64Mcg::seed_from_u64(6);
        let names: Vec<(Grounds, bool)> = (0..2000)
            .map(|_| {
                let fails = f64::from(u8::from(random.random::<f64>() < 0.2));
                let score = 6.0 * random.random::<f64>();
                let grounds = Grounds::from([1.0, score, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, fails]);
                (grounds, random.random::<f64>() < truth.probability(&grounds))
            })
            .collect();
        let learnt = stated.with_failing(&names);
        println!("{learnt:?}");
        assert!((learnt.fails - truth.fails).abs() < 0.3);
        assert_eq!(Scaling { fails: 0.0, ..learnt }, stated);
        assert_eq!(stated.with_failing(&[]), stated);
    }
}
