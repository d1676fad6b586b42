//! What chance alone can score: simulated noise, and the best score that the whole library reaches on it.
//!
//! Under no effect the library's forms act linearly, so a simulated set of points needs no refit: noise of the estimated size
//! and colour is projected onto every direction of every form, orthogonal to what the nuisances can move.

use super::criteria::Criteria;
use crate::law_bench::data::case::Nominal;
use crate::law_bench::data::point::Point;
use crate::law_bench::fit::noise::Noise;
use crate::law_bench::model::candidates::Form;
use crate::law_bench::model::discrepancy::{Discrepancy, Tangent, orthonormal};
use crate::law_bench::model::law::Model;
use crate::law_bench::model::shape::Shape;
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// A fitted model beyond which nothing is supposed to be missing.
pub struct Supposed<'a> {
    /// The model.
    pub model: &'a Model,
    /// Its parameters.
    pub values: &'a [f64],
    /// What the simulator believes.
    pub nominal: Nominal,
    /// Points to fit on.
    pub points: &'a [Point],
    /// Noise of the measured column.
    pub noise: Noise,
    /// What the model's parameters can move.
    pub tangent: &'a Tangent,
}

/// A block of orthonormal directions and the price of its parameters.
struct Block {
    columns: DMatrix<f64>,
    price: f64,
}

/// The best scores that chance reaches, sorted.
pub struct Chance {
    library: Vec<f64>,
    structure: Vec<f64>,
}

impl Chance {
    /// The best scores of `forms` and of `discrepancies` on noise alone.
    pub fn of(
        supposed: &Supposed<'_>,
        forms: &[Form],
        discrepancies: &[Discrepancy],
        criteria: &Criteria,
        seed: u64,
    ) -> Self {
        let (points, noise, tangent) = (supposed.points, &supposed.noise, supposed.tangent);
        let library: Vec<Block> = forms.iter().flat_map(|form| blocks_of(supposed, form)).collect();
        let smooth: Vec<Block> = discrepancies
            .iter()
            .map(|one| Block { columns: one.beyond(tangent), price: 0.0 })
            .filter(|block| block.columns.ncols() > 0)
            .collect();
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let (mut named, mut structure) = (Vec::new(), Vec::new());
        for _ in 0..criteria.replicates {
            let mut sample = coloured(points, noise.correlation, &mut random);
            sample += drift(points, tangent, criteria, &mut random) / noise.excess;
            let scale = (1.0 - noise.correlation) / (1.0 + noise.correlation);
            let energy = |block: &Block| block.columns.tr_mul(&sample).norm_squared() * scale;
            let best = |scores: &mut dyn Iterator<Item = f64>| scores.fold(f64::NEG_INFINITY, f64::max);
            named.push(best(&mut library.iter().map(|block| energy(block) - block.price)));
            structure.push(best(
                &mut smooth.iter().map(|block| standardised(energy(block), block.columns.ncols())),
            ));
        }
        named.sort_by(f64::total_cmp);
        structure.sort_by(f64::total_cmp);
        Self { library: named, structure }
    }

    /// Probability that chance reaches `score` with the best of the library.
    pub fn p_library(&self, score: f64) -> f64 {
        tail(&self.library, score)
    }

    /// Probability that chance reaches `score` with the best smooth discrepancy.
    pub fn p_structure(&self, score: f64) -> f64 {
        tail(&self.structure, score)
    }

    /// Score of the library that chance reaches with probability `level`.
    pub fn library_threshold(&self, level: f64) -> f64 {
        quantile(&self.library, 1.0 - level)
    }

    /// The same for the smooth discrepancies.
    pub fn structure_threshold(&self, level: f64) -> f64 {
        quantile(&self.structure, 1.0 - level)
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

/// The directions of a form beside the supposed model, block by block.
fn blocks_of(supposed: &Supposed<'_>, form: &Form) -> Vec<Block> {
    let Supposed { model, values, points, noise, tangent, .. } = supposed;
    let mut forms = model.forms().to_vec();
    forms.push(*form);
    let extended = Model::new(supposed.nominal, &forms);
    let base: Vec<f64> = points.iter().map(|point| model.predict(point, values)).collect();
    let column = |own: &[f64]| {
        let mut all = values.to_vec();
        all.extend_from_slice(own);
        let change = points.iter().zip(&base).map(|(p, b)| (extended.predict(p, &all) - b) / noise.sigma);
        DVector::from_iterator(points.len(), change)
    };
    let directions = match (form.shape(), supposed.nominal) {
        (Shape::CreepShape, Nominal::Creep { k_a, k_s, .. }) => {
            vec![vec![vec![1.01 * k_a, k_s], vec![k_a, 1.01 * k_s]]]
        }
        _ => form.shape().directions(&form.scale).into_iter().map(|direction| direction.values).collect(),
    };
    let price = (points.len() as f64).ln();
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

/// Slow drift of the level within files, in units of sigma.
fn drift(points: &[Point], tangent: &Tangent, criteria: &Criteria, random: &mut Pcg64Mcg) -> DVector<f64> {
    let mut sample = DVector::zeros(points.len());
    let mut level = 0.0;
    for i in 0..points.len() {
        let fresh: f64 = StandardNormal.sample(random);
        let follows = i > 0 && points[i].file == points[i - 1].file;
        level = if follows {
            let memory = (-(points[i].sequence - points[i - 1].sequence) / criteria.drift_memory).exp();
            memory * level + (1.0 - memory * memory).sqrt() * fresh
        } else {
            fresh
        };
        sample[i] = criteria.drift_share * level * tangent.level[i];
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
