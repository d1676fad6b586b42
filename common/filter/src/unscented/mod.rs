//! Unscented Kalman filter in square-root form, any size, pure and free of allocation; it knows no physics.
//!
//! The belief is a mean and a square root S of its covariance, P = S Sᵀ; P itself is never formed, so it cannot
//! become indefinite. Letters beyond those of [`crate::core`]:
//!
//! | letter | here | meaning |
//! | --- | --- | --- |
//! | S | `root` | square root of P, lower triangular after a prediction |
//! | α, β, κ | [`Spread`] | spread and weights of the sigma points |
//! | c | `reach` | distance of sigma points in columns of S, c² = p + λ = α² (p + κ) |
//!
//! # Why there is no downdate here
//! With the usual α = 1e-3 and 13 states the central weight is W_c(0) = λ/(p+λ) + 1 − α² + β ≈ −10⁶ (the papers'
//! (4-6), where the left side must read W_c; Zhao et al. print W_m). The textbook square-root filter triangularises the outer points and then *removes* the
//! central one, a difference of numbers a million times larger than their result. But the weighted covariance about
//! the weighted mean equals, exactly and for every α,
//!
//! ```text
//! Σ W_c,i (Z_i − z̄)(Z_i − z̄)ᵀ = W Σ_{i≥1} (Z_i − Z_0)(Z_i − Z_0)ᵀ + (β − α²) m mᵀ ,  m = z̄ − Z_0 = W Σ_{i≥1} (Z_i − Z_0)
//! ```
//!
//! (expand the left side and use Σ W_m = 1). For β ≥ α² every term is positive, so one orthogonal triangularisation
//! of the stacked rows gives the new root. Differences of opposite points are split into odd and even parts, so that
//! the second-order term is not lost against the first.
//!
//! Sources: van der Merwe & Wan, "The square-root unscented Kalman filter", ICASSP 2001 (the filter); Potter's
//! square-root update in Simon, Optimal State Estimation (2006), section 6.3; array form ibid., section 6.4.

mod spread;
mod square_root;
mod triangular;

pub use spread::{Spread, SpreadError};
pub use square_root::SquareRootBelief;
