//! The mathematics of Kalman filtering, fixed in size at compile time, pure and free of allocation; it knows no physics.
//!
//! Letters, used in this folder only:
//!
//! | letter | here | meaning |
//! | --- | --- | --- |
//! | x | `mean` | state estimate |
//! | P | `covariance` | covariance of the error of x |
//! | F | `f` | derivative of the predicted state with respect to the state |
//! | Q | `q` | covariance of the process noise of one step |
//! | H, h | `h` | derivative of the measured values with respect to the state; one row of it |
//! | R, r | `r` | covariance of the measurement noise; its variance where one value is measured |
//! | S, s | `innovation_covariance` | H P Hᵀ + R |
//! | K, k | `gain` | Kalman gain P Hᵀ S⁻¹ |
//! | W | `whitening` | inverse of the lower Cholesky factor of S, so that S⁻¹ = Wᵀ W |
//!
//! The *innovation* is measured minus predicted value; its *nis* (normalised innovation squared) is νᵀ S⁻¹ ν and
//! follows a χ² law with as many degrees of freedom as values were measured. Source of all forms: Simon, Optimal
//! State Estimation (2006), chapters 5, 6 and 9.

mod consistency;
mod gaussian;
mod joint_gain;
mod smoother;

pub use consistency::{ChiSquareBand, chi_square_mean_band};
pub use gaussian::{Gaussian, JointUpdate, ScalarUpdate};
pub use joint_gain::JointGain;
pub use smoother::{SmootherError, SmootherStep, smooth};
