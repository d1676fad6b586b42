//! Left-out data: which points are predicted from which.

use super::solver::fit_once;
use crate::law_bench::data::point::{Covariate, Point, Spread};
use crate::law_bench::decide::criteria::Criteria;
use crate::law_bench::model::law::Model;

/// How points are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// One file at a time.
    Files,
    /// One block of neighbouring rows of every file at a time.
    Blocks,
}

/// The fold of each point, and how they were made.
#[derive(Clone, Debug)]
pub struct Folds {
    /// How points are left out.
    pub scheme: Scheme,
    /// Number of folds.
    pub count: usize,
    of: Vec<usize>,
}

impl Folds {
    /// Leaves one file out at a time where there are enough and none stands alone; blocks of rows otherwise.
    pub fn of(points: &[Point], covariates: &[Covariate], criteria: &Criteria) -> Self {
        let files = points.iter().map(|point| point.file + 1).max().unwrap_or(0);
        let lone = (0..files).any(|file| covariates.iter().any(|&c| stands_alone(points, file, c, criteria)));
        if files >= criteria.fewest_files && !lone {
            let of = points.iter().map(|point| point.file).collect();
            return Self { scheme: Scheme::Files, count: files, of };
        }
        let blocks = criteria.blocks;
        let block = |point: &Point| ((point.sequence * blocks as f64) as usize).min(blocks - 1);
        // Blocks of neighbouring files are shifted, so that one fold does not hold the same end of every sweep.
        let of = points.iter().map(|point| (block(point) + point.file) % blocks).collect();
        Self { scheme: Scheme::Blocks, count: blocks, of }
    }

    /// Squared errors over sigma² on each fold, predicted by `model` fitted to the other folds from `start`.
    pub fn errors(&self, model: &Model, points: &[Point], sigma: f64, start: &[f64]) -> Vec<f64> {
        (0..self.count)
            .map(|fold| {
                let split = |inside: bool| -> Vec<Point> {
                    let chosen = points.iter().zip(&self.of).filter(|(_, of)| (**of == fold) == inside);
                    chosen.map(|(point, _)| *point).collect()
                };
                let (test, train) = (split(true), split(false));
                let values = fit_once(model, &train, sigma, start).values;
                test.iter()
                    .map(|point| ((model.predict(point, &values) - point.measured) / sigma).powi(2))
                    .sum()
            })
            .collect()
    }
}

fn stands_alone(points: &[Point], file: usize, covariate: Covariate, criteria: &Criteria) -> bool {
    let (own, others): (Vec<Point>, Vec<Point>) = points.iter().partition(|point| point.file == file);
    let Some(all) = Spread::of(points, covariate) else { return false };
    let range = others.iter().map(|point| covariate.of(point));
    let (low, high) = range.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let margin = criteria.range_margin * all.width();
    let outside =
        own.iter().filter(|point| !(low - margin..=high + margin).contains(&covariate.of(point))).count();
    outside as f64 > criteria.most_outside * own.len() as f64
}
