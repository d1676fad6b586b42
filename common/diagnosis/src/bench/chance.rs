//! What chance alone can score: noise of the bench, and a parametric bootstrap of the best score of the whole library.
//!
//! Under no effect the library's forms act linearly, so a replicate needs no refit: noise of the estimated size and
//! colour is projected onto every direction of every form, orthogonal to what the nuisances can move.

use super::flexible::{Group, Tangent, orthonormal, residuals, union};
use super::forms::Shape;
use super::input::Nominal;
use super::library::Form;
use super::model::Model;
use super::points::{Covariate, Point};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// Replicates behind every threshold.
pub const REPLICATES: usize = 599;

/// Slow wander of friction that is a nuisance, not an effect, as a share of the level.
const WANDER_SHARE: f64 = 0.006;

/// Its memory, as a share of a file's length.
const WANDER_LENGTH: f64 = 0.3;

/// Noise of the measured column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Sensor sigma by which gaps are divided, in the column's unit.
    pub sigma: f64,
    /// Scatter about the richest smooth model over sigma; at least 1.
    pub excess: f64,
    /// Correlation of neighbouring points of a file.
    pub correlation: f64,
}

impl Noise {
    /// Squared residuals in units of sigma that count as one independent degree of freedom.
    pub fn unit(&self) -> f64 {
        self.excess * self.excess * (1.0 + self.correlation) / (1.0 - self.correlation)
    }
}

/// Scatter about the richest smooth model (in the unit of `sigma`) and correlation of neighbours.
pub fn scatter(
    model: &Model,
    points: &[Point],
    values: &[f64],
    sigma: f64,
    groups: &[Group],
    tangent: &Tangent,
) -> (f64, f64) {
    let rest = residuals(model, points, values, sigma);
    let rich = union(groups, tangent, |group| group.covariate == Covariate::Sequence);
    let rest = &rest - &tangent.basis * tangent.basis.tr_mul(&rest);
    let rest = &rest - &rich * rich.tr_mul(&rest);
    let used = rich.ncols() + tangent.basis.ncols();
    let freedom = points.len().saturating_sub(used).max(3) as f64;
    let (mut product, mut pairs) = (0.0, 0usize);
    for i in 1..points.len() {
        if points[i].file == points[i - 1].file {
            product += rest[i] * rest[i - 1];
            pairs += 1;
        }
    }
    let variance = rest.norm_squared() / points.len() as f64;
    let raw = product / (pairs.max(1) as f64 * variance.max(1e-300));
    // A smooth fit makes neighbours look opposed by about its degrees of freedom over the points.
    let correlation = raw + used as f64 / points.len() as f64;
    let chance = 2.5 / (pairs.max(1) as f64).sqrt();
    let correlation = if correlation > chance { correlation.min(0.9) } else { 0.0 };
    (sigma * (rest.norm_squared() / freedom).sqrt(), correlation)
}

/// A block of orthonormal directions and the price of its parameters.
struct Block {
    columns: DMatrix<f64>,
    price: f64,
}

/// The best scores that chance reaches, sorted.
pub struct Chance {
    library: Vec<f64>,
    flexible: Vec<f64>,
}

impl Chance {
    /// Bootstraps the best score of `forms` and of `groups` on top of a fitted model.
    pub fn of(
        model: &Model,
        points: &[Point],
        values: &[f64],
        noise: &Noise,
        forms: &[Form],
        groups: &[Group],
        tangent: &Tangent,
        nominal: &Nominal,
        seed: u64,
    ) -> Self {
        let price = (points.len() as f64).ln();
        let library: Vec<Block> = forms
            .iter()
            .flat_map(|f| form_blocks(model, points, values, noise.sigma, f, nominal, tangent, price))
            .collect();
        let flexible: Vec<Block> = groups
            .iter()
            .map(|group| Block { columns: group.beyond(tangent), price: 0.0 })
            .filter(|block| block.columns.ncols() > 0)
            .collect();
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let (mut best, mut rough) = (Vec::new(), Vec::new());
        for _ in 0..REPLICATES {
            let mut sample = coloured(points, noise.correlation, &mut random);
            sample += wander(points, tangent, &mut random) / noise.excess;
            let scale = (1.0 - noise.correlation) / (1.0 + noise.correlation);
            let energy = |block: &Block| block.columns.tr_mul(&sample).norm_squared() * scale;
            best.push(
                library.iter().map(|block| energy(block) - block.price).fold(f64::NEG_INFINITY, f64::max),
            );
            rough.push(
                flexible
                    .iter()
                    .map(|block| standardised(energy(block), block.columns.ncols()))
                    .fold(f64::NEG_INFINITY, f64::max),
            );
        }
        best.sort_by(f64::total_cmp);
        rough.sort_by(f64::total_cmp);
        Self { library: best, flexible: rough }
    }

    /// Probability that chance reaches `score` with the best of the library.
    pub fn p_library(&self, score: f64) -> f64 {
        tail(&self.library, score)
    }

    /// Probability that chance reaches `score` with the best flexible function.
    pub fn p_flexible(&self, score: f64) -> f64 {
        tail(&self.flexible, score)
    }

    /// Score of the library that chance reaches with probability `level`.
    pub fn threshold(&self, level: f64) -> f64 {
        quantile(&self.library, 1.0 - level)
    }

    /// The same for the flexible functions.
    pub fn flexible_threshold(&self, level: f64) -> f64 {
        quantile(&self.flexible, 1.0 - level)
    }
}

/// Energy of `freedom` independent normals, centred and scaled.
pub fn standardised(energy: f64, freedom: usize) -> f64 {
    let k = freedom.max(1) as f64;
    (energy - k) / (2.0 * k).sqrt()
}

fn tail(sorted: &[f64], score: f64) -> f64 {
    let above = sorted.len() - sorted.partition_point(|&value| value < score);
    (above + 1) as f64 / (sorted.len() + 1) as f64
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    sorted.get((last as f64 * share).round() as usize).copied().unwrap_or(f64::INFINITY)
}

fn form_blocks(
    model: &Model,
    points: &[Point],
    values: &[f64],
    sigma: f64,
    form: &Form,
    nominal: &Nominal,
    tangent: &Tangent,
    price: f64,
) -> Vec<Block> {
    let mut forms = model.forms().to_vec();
    forms.push(*form);
    let extended = Model::new(*nominal, &forms);
    let base: Vec<f64> = points.iter().map(|point| model.predict(point, values)).collect();
    let column = |own: &[f64]| {
        let mut all = values.to_vec();
        all.extend_from_slice(own);
        let change = points.iter().zip(&base).map(|(p, b)| (extended.predict(p, &all) - b) / sigma);
        DVector::from_iterator(points.len(), change)
    };
    let directions = match (form.shape(), nominal) {
        (Shape::CreepShape, Nominal::Creep { k_a, k_s, .. }) => {
            vec![vec![vec![1.01 * k_a, *k_s], vec![*k_a, 1.01 * k_s]]]
        }
        _ => form.shape().directions(&form.scale).into_iter().map(|direction| direction.values).collect(),
    };
    directions
        .into_iter()
        .map(|block| {
            let columns: Vec<DVector<f64>> = block.iter().map(|own| column(own)).collect();
            Block {
                columns: orthonormal(&columns, Some(&tangent.basis), points.len()),
                price: price * form.shape().parameters() as f64,
            }
        })
        .filter(|block| block.columns.ncols() > 0)
        .collect()
}

/// Slow wander of the level within files, in units of sigma.
fn wander(points: &[Point], tangent: &Tangent, random: &mut Pcg64Mcg) -> DVector<f64> {
    let mut sample = DVector::zeros(points.len());
    let mut level = 0.0;
    for i in 0..points.len() {
        let fresh: f64 = StandardNormal.sample(random);
        let follows = i > 0 && points[i].file == points[i - 1].file;
        level = if follows {
            let memory = (-(points[i].sequence - points[i - 1].sequence) / WANDER_LENGTH).exp();
            memory * level + (1.0 - memory * memory).sqrt() * fresh
        } else {
            fresh
        };
        sample[i] = WANDER_SHARE * level * tangent.level[i];
    }
    sample
}

/// Normal noise of variance 1; neighbours within a file are correlated.
fn coloured(points: &[Point], correlation: f64, random: &mut Pcg64Mcg) -> DVector<f64> {
    let fresh = (1.0 - correlation * correlation).sqrt();
    let mut sample = DVector::zeros(points.len());
    for i in 0..points.len() {
        let white: f64 = StandardNormal.sample(random);
        let follows = i > 0 && points[i].file == points[i - 1].file;
        sample[i] = if follows { correlation * sample[i - 1] + fresh * white } else { white };
    }
    sample
}
