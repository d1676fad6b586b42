//! Damped Newton steps that keep to the bounds of their parameters.

use crate::model::parameters::Parameter;
use nalgebra::{DMatrix, DVector};

/// Solves a damped Newton step.
fn step(
    parameters: &[Parameter],
    gradient: &DVector<f64>,
    curvature: &DMatrix<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    let mut damped = curvature.clone();
    for (i, p) in parameters.iter().enumerate() {
        damped[(i, i)] +=
            damping * (curvature[(i, i)] + 1e-3 / (p.scale * p.scale)) + 1e-12 / (p.scale * p.scale);
    }
    Some(-damped.cholesky()?.solve(gradient))
}

/// A step that keeps to the bounds: parameters that would leave are held at their bound and the rest solved again.
pub(super) fn step_within(
    parameters: &[Parameter],
    theta: &[f64],
    gradient: &DVector<f64>,
    curvature: &DMatrix<f64>,
    damping: f64,
) -> Option<DVector<f64>> {
    step_with(parameters, theta, (gradient, curvature), damping, vec![None; theta.len()])
}

/// The same, where some parameters change by what is `held`.
pub(super) fn step_with(
    parameters: &[Parameter],
    theta: &[f64],
    (gradient, curvature): (&DVector<f64>, &DMatrix<f64>),
    damping: f64,
    mut held: Vec<Option<f64>>,
) -> Option<DVector<f64>> {
    let n = theta.len();
    let wanted = held.clone();
    for _ in 0..4 {
        let (mut g, mut h) = (gradient.clone(), curvature.clone());
        for (i, hold) in held.iter().enumerate() {
            if let Some(change) = hold {
                g += curvature.column(i) * *change;
            }
        }
        for (i, hold) in held.iter().enumerate() {
            if hold.is_some() {
                h.row_mut(i).fill(0.0);
                h.column_mut(i).fill(0.0);
                h[(i, i)] = 1.0 / (parameters[i].scale * parameters[i].scale);
                g[i] = 0.0;
            }
        }
        let mut change = step(parameters, &g, &h, damping)?;
        let mut more = false;
        for i in 0..n {
            if let Some(fixed) = held[i] {
                change[i] = fixed;
                continue;
            }
            let bounded = (theta[i] + change[i]).clamp(parameters[i].lower, parameters[i].upper);
            if (bounded - theta[i] - change[i]).abs() > 1e-12 * parameters[i].scale {
                held[i] = Some(bounded - theta[i]);
                more = true;
            }
        }
        if !more {
            return Some(change);
        }
    }
    let mut change = step(parameters, gradient, curvature, damping)?;
    for i in 0..n {
        change[i] = wanted[i].unwrap_or_else(|| {
            (theta[i] + change[i]).clamp(parameters[i].lower, parameters[i].upper) - theta[i]
        });
    }
    Some(change)
}
