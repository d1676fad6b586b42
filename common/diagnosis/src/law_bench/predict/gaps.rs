//! The gap in numbers: by model, set, file and region, and the interval of the reduction.

use crate::answer::schema::{Interval, Regime};
use crate::law_bench::data::case::PointSet;
use crate::law_bench::data::point::{Covariate, Point, Spread};
use crate::law_bench::model::law::Model;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Replicates of the block bootstrap.
const REPLICATES: usize = 999;

/// Regions into which a variable is cut.
const REGIONS: usize = 6;

/// A model with the values of its parameters.
pub struct ModelAt<'a> {
    /// The model.
    pub model: &'a Model,
    /// Its parameters.
    pub values: &'a [f64],
}

/// Predictions of the three models on one set.
pub struct Predictions<'a> {
    /// The set.
    pub set: &'a PointSet,
    /// Of each point, in the order of the set.
    pub nominal: Vec<f64>,
    /// With fitted nuisances.
    pub calibrated: Vec<f64>,
    /// With nuisances and effects.
    pub extended: Vec<f64>,
    sigma: f64,
}

impl<'a> Predictions<'a> {
    /// Predicts a set by the three models.
    pub fn of(set: &'a PointSet, models: [ModelAt<'_>; 3], sigma: f64) -> Self {
        let [nominal, calibrated, extended] =
            models.map(|at| set.points.iter().map(|point| at.model.predict(point, at.values)).collect());
        Self { set, nominal, calibrated, extended, sigma }
    }

    /// Errors over sigma of one of the three.
    fn errors(&self, predicted: &[f64]) -> Vec<f64> {
        let pairs = self.set.points.iter().zip(predicted);
        pairs.map(|(point, predicted)| (predicted - point.measured) / self.sigma).collect()
    }

    /// Gaps of the three models over the points in which `inside` holds; NaN if there are none.
    pub fn gaps(&self, inside: impl Fn(&Point) -> bool) -> [f64; 3] {
        [&self.nominal, &self.calibrated, &self.extended].map(|predicted| {
            let errors = self.errors(predicted);
            let chosen = self.set.points.iter().zip(&errors).filter(|(point, _)| inside(point));
            let (sum, count) = chosen.fold((0.0, 0), |(sum, n), (_, e)| (sum + e * e, n + 1));
            (sum / f64::from(count)).sqrt()
        })
    }

    /// 95 % interval of `1 − extended / calibrated`, by resampling blocks of neighbouring rows.
    pub fn reduction_interval(&self, seed: u64) -> Interval {
        let squares = |predicted: &[f64]| -> Vec<f64> {
            self.errors(predicted).into_iter().map(|error| error * error).collect()
        };
        let (before, after) = (squares(&self.calibrated), squares(&self.extended));
        let blocks = self.blocks();
        let sums: Vec<(f64, f64)> = blocks
            .iter()
            .map(|block| (before[block.clone()].iter().sum(), after[block.clone()].iter().sum()))
            .collect();
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut reductions: Vec<f64> = (0..REPLICATES)
            .map(|_| {
                let (mut calibrated, mut extended) = (0.0, 0.0);
                for _ in 0..sums.len() {
                    let (b, a) = sums[random.random_range(0..sums.len())];
                    calibrated += b;
                    extended += a;
                }
                reduction(f64::sqrt(calibrated), f64::sqrt(extended))
            })
            .collect();
        reductions.sort_by(f64::total_cmp);
        let at = |share: f64| reductions[((REPLICATES - 1) as f64 * share).round() as usize];
        [at(0.025), at(0.975)]
    }

    /// Blocks of neighbouring rows within files, each about the square root of its file long.
    fn blocks(&self) -> Vec<std::ops::Range<usize>> {
        let points = &self.set.points;
        let mut blocks = Vec::new();
        let mut start = 0;
        for file in 0..self.set.files.len() {
            let end = start + points[start..].iter().take_while(|point| point.file == file).count();
            let length = ((end - start) as f64).sqrt().round().max(1.0) as usize;
            let mut at = start;
            while at < end {
                blocks.push(at..end.min(at + length));
                at += length;
            }
            start = end;
        }
        blocks
    }

    /// The range of `covariate` in which the calibrated model is worst.
    pub fn regime(&self, covariate: Covariate) -> Option<Regime> {
        let edges = edges(&self.set.points, covariate)?;
        let count = edges.len() - 1;
        let mut best: Option<(f64, Regime)> = None;
        for first in 0..count {
            for last in first..count {
                if last - first + 1 > (count * 2).div_ceil(3) {
                    continue;
                }
                let (low, high) = (edges[first], edges[last + 1]);
                let closed = last + 1 == count;
                let inside = |point: &Point| within(covariate.of(point), low, high, closed);
                let share = self.set.points.iter().filter(|p| inside(p)).count() as f64
                    / self.set.points.len() as f64;
                let gap_inside = self.gaps(inside)[1];
                let gap_outside = self.gaps(|point| !inside(point))[1];
                let contrast = share * (1.0 - share) * (gap_inside.powi(2) - gap_outside.powi(2));
                if contrast.is_finite() && best.as_ref().is_none_or(|(known, _)| contrast > *known) {
                    let variable = covariate.name().to_owned();
                    best = Some((contrast, Regime { variable, range: [low, high], gap_inside, gap_outside }));
                }
            }
        }
        best.filter(|(_, regime)| regime.gap_inside > regime.gap_outside).map(|(_, regime)| regime)
    }
}

/// `1 − extended / calibrated`; 0 where there was no gap.
pub fn reduction(calibrated: f64, extended: f64) -> f64 {
    if calibrated > 0.0 { 1.0 - extended / calibrated } else { 0.0 }
}

/// Limits of regions with about as many points each; `None` where the variable does not vary.
pub fn edges(points: &[Point], covariate: Covariate) -> Option<Vec<f64>> {
    let spread = Spread::of(points, covariate)?;
    let mut values: Vec<f64> = points.iter().map(|point| covariate.of(point)).collect();
    values.sort_by(f64::total_cmp);
    let mut edges: Vec<f64> = (0..=REGIONS).map(|i| values[(values.len() - 1) * i / REGIONS]).collect();
    edges.dedup_by(|next, last| *next - *last < 1e-3 * spread.width());
    if let Some(last) = edges.last_mut() {
        *last = spread.high;
    }
    (edges.len() > 2).then_some(edges)
}

/// Whether a value lies in a region that holds its upper limit only if it is `closed`.
pub fn within(value: f64, low: f64, high: f64, closed: bool) -> bool {
    value >= low && (value < high || (closed && value <= high))
}
