//! What a flexible discrepancy could explain: smooth functions of the variables at the places of the law.
//!
//! The discrepancy is linear: around a fitted model each residual is a sum of smooth functions of the operating point,
//! times the sensitivity of the prediction to the level (or to the stiffness, or to the force itself). What it
//! explains beyond the best candidate is structure that no candidate describes.

use super::law::Model;
use crate::law_bench::data::case::Kind;
use crate::law_bench::data::point::{Covariate, Point, Spread};
use nalgebra::{DMatrix, DVector};

/// Where a flexible function acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActsOn {
    /// Relative change of adhesion or pad friction.
    Level,
    /// Relative change of the contact's stiffness.
    Stiffness,
    /// Change of force as a share of the normal load.
    Force,
}

/// A flexible function of one variable, or of two.
#[derive(Clone, Debug)]
pub struct Discrepancy {
    /// The variable that names it.
    pub covariate: Covariate,
    /// The second variable of an interaction.
    pub second: Option<Covariate>,
    /// Where it acts.
    pub acts_on: ActsOn,
    /// Its columns in units of sigma, not orthogonal.
    pub columns: DMatrix<f64>,
    knots: Vec<f64>,
}

/// Sensitivities and tangent of a fitted model.
pub struct Tangent {
    /// Orthonormal columns that the fitted parameters can already move along.
    pub basis: DMatrix<f64>,
    /// Change of each prediction with the logarithm of the level, in units of sigma.
    pub level: DVector<f64>,
    stiffness: DVector<f64>,
    force: DVector<f64>,
}

impl Tangent {
    /// The tangent of `model` at `values`.
    pub fn of(model: &Model, points: &[Point], values: &[f64], sigma: f64) -> Self {
        let base: Vec<f64> = points.iter().map(|point| model.predict(point, values)).collect();
        let nudge = 1e-4_f64;
        let sense = |level: f64, stiffness: f64| {
            DVector::from_iterator(
                points.len(),
                points.iter().zip(&base).map(|(point, base)| {
                    (model.predict_scaled(point, values, level, stiffness) - base) / (nudge * sigma)
                }),
            )
        };
        let force = points.iter().map(|p| match model.kind() {
            Kind::Creep => p.creepage.signum() * p.load_n / sigma,
            Kind::Brake => 1.0 / sigma,
        });
        let free: Vec<DVector<f64>> = model
            .parameters()
            .iter()
            .enumerate()
            .filter_map(|(index, parameter)| {
                let step = 1e-5 * (parameter.upper - parameter.lower);
                let room = values[index] - parameter.lower > step && parameter.upper - values[index] > step;
                room.then(|| {
                    let mut moved = values.to_vec();
                    moved[index] += step;
                    let column = points
                        .iter()
                        .zip(&base)
                        .map(|(p, b)| (model.predict(p, &moved) - b) / (step * sigma));
                    DVector::from_iterator(points.len(), column)
                })
            })
            .collect();
        Self {
            basis: orthonormal(&free, None, points.len()),
            level: sense(1.0 + nudge, 1.0),
            stiffness: sense(1.0, 1.0 + nudge),
            force: DVector::from_iterator(points.len(), force),
        }
    }

    fn sensitivity(&self, acts_on: ActsOn) -> &DVector<f64> {
        match acts_on {
            ActsOn::Level => &self.level,
            ActsOn::Stiffness => &self.stiffness,
            ActsOn::Force => &self.force,
        }
    }
}

/// The flexible functions of a kind of bench around a fitted model.
pub fn discrepancies(kind: Kind, points: &[Point], tangent: &Tangent) -> Vec<Discrepancy> {
    let singles: &[(Covariate, ActsOn)] = match kind {
        Kind::Creep => &[
            (Covariate::SlipVelocity, ActsOn::Level),
            (Covariate::Speed, ActsOn::Level),
            (Covariate::Load, ActsOn::Level),
            (Covariate::Creepage, ActsOn::Force),
            (Covariate::Load, ActsOn::Stiffness),
            (Covariate::Speed, ActsOn::Stiffness),
            (Covariate::Sequence, ActsOn::Level),
        ],
        Kind::Brake => &[
            (Covariate::Speed, ActsOn::Level),
            (Covariate::Temperature, ActsOn::Level),
            (Covariate::PressingForce, ActsOn::Level),
            (Covariate::Sequence, ActsOn::Level),
        ],
    };
    let pairs: &[(Covariate, Covariate)] = match kind {
        Kind::Creep => &[
            (Covariate::SlipVelocity, Covariate::Speed),
            (Covariate::SlipVelocity, Covariate::Load),
            (Covariate::Speed, Covariate::Load),
        ],
        Kind::Brake => &[
            (Covariate::Speed, Covariate::Temperature),
            (Covariate::Speed, Covariate::PressingForce),
            (Covariate::Temperature, Covariate::PressingForce),
        ],
    };
    let smooth =
        singles.iter().filter_map(|&(covariate, acts_on)| single(points, tangent, covariate, acts_on));
    let joint = pairs.iter().filter_map(|&(first, second)| pair(points, tangent, first, second));
    smooth.chain(joint).collect()
}

fn single(points: &[Point], tangent: &Tangent, covariate: Covariate, acts_on: ActsOn) -> Option<Discrepancy> {
    let spread = Spread::of(points, covariate)?;
    let count = if points.len() < 60 { 4 } else { 7 };
    let mut sorted: Vec<f64> = points.iter().map(|point| covariate.of(point)).collect();
    sorted.sort_by(f64::total_cmp);
    let knots = knots(&sorted, &spread, count);
    let sensitivity = tangent.sensitivity(acts_on);
    let mut columns = DMatrix::zeros(points.len(), knots.len());
    for (row, point) in points.iter().enumerate() {
        for (column, value) in smooth_basis(covariate.of(point), &knots).into_iter().enumerate() {
            columns[(row, column)] = value * sensitivity[row];
        }
    }
    Some(Discrepancy { covariate, second: None, acts_on, columns, knots })
}

fn pair(points: &[Point], tangent: &Tangent, first: Covariate, second: Covariate) -> Option<Discrepancy> {
    let (a, b) = (Spread::of(points, first)?, Spread::of(points, second)?);
    let scaled = |spread: &Spread, value: f64| 2.0 * (value - spread.low) / spread.width() - 1.0;
    let mut columns = DMatrix::zeros(points.len(), 3);
    for (row, point) in points.iter().enumerate() {
        let (x, y) = (scaled(&a, first.of(point)), scaled(&b, second.of(point)));
        for (column, value) in joint_basis(x, y).into_iter().enumerate() {
            columns[(row, column)] = value * tangent.level[row];
        }
    }
    Some(Discrepancy {
        covariate: first,
        second: Some(second),
        acts_on: ActsOn::Level,
        columns,
        knots: Vec::new(),
    })
}

/// Lowest products of two variables, each scaled to −1 … 1.
fn joint_basis(x: f64, y: f64) -> Vec<f64> {
    vec![x * y, x * x * y, x * y * y]
}

fn knots(sorted: &[f64], spread: &Spread, count: usize) -> Vec<f64> {
    let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share).round() as usize];
    let mut knots: Vec<f64> = (0..count)
        .map(|i| {
            let share = i as f64 / (count - 1) as f64;
            0.5 * (at(share) + spread.low + share * spread.width())
        })
        .collect();
    knots.dedup_by(|next, last| *next - *last < 0.02 * spread.width());
    knots
}

/// Natural cubic spline with its constant: as many functions as knots.
fn smooth_basis(x: f64, knots: &[f64]) -> Vec<f64> {
    let last = knots.len() - 1;
    let width = knots[last] - knots[0];
    let z = (x - knots[0]) / width;
    let knot = |i: usize| (knots[i] - knots[0]) / width;
    let cube = |k: f64| (z - k).max(0.0).powi(3);
    let d = |i: usize| (cube(knot(i)) - cube(1.0)) / (1.0 - knot(i));
    let mut all = vec![1.0, z];
    all.extend((0..last.saturating_sub(1)).map(|i| d(i) - d(last - 1)));
    all
}

impl Discrepancy {
    /// Orthonormal columns of what the discrepancy adds to `tangent`.
    pub fn beyond(&self, tangent: &Tangent) -> DMatrix<f64> {
        let columns: Vec<DVector<f64>> = self.columns.column_iter().map(|c| c.into_owned()).collect();
        orthonormal(&columns, Some(&tangent.basis), tangent.basis.nrows())
    }

    /// The function that fits `residuals` (measured − predicted, in units of sigma) best: x, value and standard error, over the
    /// range of its variable. The value is relative for level and stiffness. An interaction is shown over its first variable, at
    /// the upper end of its second.
    pub fn curve(&self, residuals: &DVector<f64>, points: &[Point], at: usize) -> Option<Vec<[f64; 3]>> {
        let spread = Spread::of(points, self.covariate)?;
        let normal = self.columns.tr_mul(&self.columns);
        let ridge = 1e-7 * normal.trace() / normal.nrows() as f64;
        let system = &normal + DMatrix::identity(normal.nrows(), normal.ncols()) * ridge;
        let factor = system.cholesky()?;
        let weights = factor.solve(&self.columns.tr_mul(residuals));
        let covariance = factor.inverse();
        let curve = (0..at).map(|i| {
            let x = spread.low + spread.width() * i as f64 / (at - 1) as f64;
            let basis = DVector::from_vec(match self.second {
                None => smooth_basis(x, &self.knots),
                Some(_) => joint_basis(2.0 * (x - spread.low) / spread.width() - 1.0, 1.0),
            });
            [x, basis.dot(&weights), basis.dot(&(&covariance * &basis)).max(0.0).sqrt()]
        });
        Some(curve.collect())
    }
}

/// Orthonormal columns that span `columns` beyond `given`; columns that add nothing are dropped.
pub fn orthonormal(columns: &[DVector<f64>], given: Option<&DMatrix<f64>>, rows: usize) -> DMatrix<f64> {
    let mut kept: Vec<DVector<f64>> = Vec::new();
    for column in columns {
        let size = column.norm();
        if size < 1e-12 {
            continue;
        }
        let mut rest = column / size;
        for _ in 0..2 {
            if let Some(given) = given {
                rest -= given * given.tr_mul(&rest);
            }
            for known in &kept {
                let share = known.dot(&rest);
                rest.axpy(-share, known, 1.0);
            }
        }
        let left = rest.norm();
        if left > 1e-5 {
            kept.push(rest / left);
        }
    }
    if kept.is_empty() { DMatrix::zeros(rows, 0) } else { DMatrix::from_columns(&kept) }
}

/// Orthonormal columns of what all discrepancies together add to `tangent`, leaving out those in which `skip` holds.
pub fn union(all: &[Discrepancy], tangent: &Tangent, skip: impl Fn(&Discrepancy) -> bool) -> DMatrix<f64> {
    let columns: Vec<DVector<f64>> = all
        .iter()
        .filter(|one| !skip(one))
        .flat_map(|one| one.columns.column_iter().map(|c| c.into_owned()).collect::<Vec<_>>())
        .collect();
    orthonormal(&columns, Some(&tangent.basis), tangent.basis.nrows())
}

/// Residuals in units of sigma, measured − predicted.
pub fn residuals(model: &Model, points: &[Point], values: &[f64], sigma: f64) -> DVector<f64> {
    DVector::from_iterator(
        points.len(),
        points.iter().map(|point| (point.measured - model.predict(point, values)) / sigma),
    )
}
