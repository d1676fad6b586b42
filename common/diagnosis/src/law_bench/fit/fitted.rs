//! A fitted model with its errors on left-out data.

use super::solver::Fit;
use crate::law_bench::model::law::Model;

/// A fitted model, and how well it predicts what was left out.
#[derive(Clone, Debug)]
pub struct FittedModel {
    /// The model.
    pub model: Model,
    /// Its fit.
    pub fit: Fit,
    /// Squared errors over sigma² on left-out data, by fold.
    pub left_out: Vec<f64>,
}
