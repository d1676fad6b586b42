//! Newton's method for convex costs of a few weights.

use nalgebra::{Const, DimMin, SMatrix, SVector};

/// Steps at most.
const STEPS: usize = 50;
/// A step shorter than this ends the search.
const SHORTEST: f64 = 1e-10;

/// The weights of least cost, from `start` on; `slopes` gives the cost's gradient and curvature. A full step overshoots where nearly
/// all probabilities are near 0 or 1: it is halved until it leads down.
pub(super) fn least<const N: usize>(
    start: SVector<f64, N>,
    cost: impl Fn(&SVector<f64, N>) -> f64,
    slopes: impl Fn(&SVector<f64, N>) -> (SVector<f64, N>, SMatrix<f64, N, N>),
) -> SVector<f64, N>
where
    Const<N>: DimMin<Const<N>, Output = Const<N>>,
{
    let mut at = start;
    for _ in 0..STEPS {
        let (gradient, curvature) = slopes(&at);
        let Some(mut step) = curvature.lu().solve(&gradient) else { break };
        let before = cost(&at);
        while cost(&(at - step)) > before && step.norm() > SHORTEST {
            step *= 0.5;
        }
        at -= step;
        if step.norm() < SHORTEST {
            break;
        }
    }
    at
}
