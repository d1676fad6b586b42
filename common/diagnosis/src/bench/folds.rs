//! Left-out data: which points are predicted from which.

use super::fit::fit_once;
use super::model::Model;
use super::points::{Covariate, Point, Spread};

/// Folds where files cannot be left out whole.
const BLOCKS: usize = 5;

/// Share of a file's points that may lie outside the ranges of the others before leaving it out counts as extrapolation.
const MOST_OUTSIDE: f64 = 0.4;

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
    /// Leaves one file out at a time where there are at least three and none stands alone; blocks of rows otherwise.
    pub fn of(points: &[Point], covariates: &[Covariate]) -> Self {
        let files = points.iter().map(|point| point.file + 1).max().unwrap_or(0);
        let lone = (0..files).any(|file| covariates.iter().any(|&c| stands_alone(points, file, c)));
        if files >= 3 && !lone {
            let of = points.iter().map(|point| point.file).collect();
            return Self { scheme: Scheme::Files, count: files, of };
        }
        let block = |point: &Point| ((point.sequence * BLOCKS as f64) as usize).min(BLOCKS - 1);
        // Blocks of neighbouring files are shifted, so that one fold does not hold the same end of every sweep.
        let of = points.iter().map(|point| (block(point) + point.file) % BLOCKS).collect();
        Self { scheme: Scheme::Blocks, count: BLOCKS, of }
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

fn stands_alone(points: &[Point], file: usize, covariate: Covariate) -> bool {
    let (own, others): (Vec<Point>, Vec<Point>) = points.iter().partition(|point| point.file == file);
    let Some(all) = Spread::of(points, covariate) else { return false };
    let range = others.iter().map(|point| covariate.of(point));
    let (low, high) = range.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let margin = 0.05 * all.width();
    let outside =
        own.iter().filter(|point| !(low - margin..=high + margin).contains(&covariate.of(point))).count();
    outside as f64 > MOST_OUTSIDE * own.len() as f64
}
