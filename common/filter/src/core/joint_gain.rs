//! The half of a joint update that does not depend on what is measured: gain and whitening. A filter with frozen gains keeps
//! it and repeats only the other half.

use super::Gaussian;
use nalgebra::SMatrix;

/// What measuring `M` values at once does to a belief of `N` components, whatever the values turn out to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointGain<const N: usize, const M: usize> {
    /// Kalman gain K.
    pub gain: SMatrix<f64, N, M>,
    /// Inverse of the lower Cholesky factor of S.
    pub whitening: SMatrix<f64, M, M>,
    /// ½ ln det S.
    pub half_log_determinant: f64,
}

impl<const N: usize, const M: usize> JointGain<N, M> {
    /// The gain of a measurement that cannot be weighed: it corrects nothing, and its whitened innovation is not a number.
    pub fn undefined() -> Self {
        Self { gain: SMatrix::zeros(), whitening: SMatrix::from_element(f64::NAN), half_log_determinant: 0.0 }
    }

    /// Change of the mean: K ν.
    #[inline]
    pub fn correction(&self, innovation: &[f64; M]) -> [f64; N] {
        std::array::from_fn(|i| (0..M).map(|j| self.gain[(i, j)] * innovation[j]).sum())
    }

    /// Innovation in units of its own uncertainty: independent components of variance one if the filter is right.
    #[inline]
    pub fn whitened(&self, innovation: &[f64; M]) -> [f64; M] {
        std::array::from_fn(|i| (0..=i).map(|j| self.whitening[(i, j)] * innovation[j]).sum())
    }
}

impl<const N: usize> Gaussian<N> {
    /// Reduces the covariance by `M` values measured at once, and leaves the mean to [`JointGain::correction`]. With S = L Lᵀ and
    /// W = L⁻¹ the gain is (W H P)ᵀ W, and P falls by (W H P)ᵀ (W H P): what is left is symmetric, and sound while no sensor is so
    /// exact that it leaves next to nothing of P. `None`, and no change, if S is not positive definite.
    #[inline]
    pub fn condition<const M: usize>(
        &mut self,
        h: &SMatrix<f64, M, N>,
        r: &SMatrix<f64, M, M>,
    ) -> Option<JointGain<N, M>> {
        let projected = h * self.covariance;
        let factor = (projected * h.transpose() + r).cholesky()?;
        let lower = factor.l();
        let whitening = lower.solve_lower_triangular(&SMatrix::<f64, M, M>::identity())?;
        let root = whitening * projected;
        let gain = root.transpose() * whitening;
        for column in 0..N {
            for row in 0..=column {
                let taken = root.column(row).dot(&root.column(column));
                let left = self.covariance[(row, column)] - taken;
                self.covariance[(row, column)] = left;
                self.covariance[(column, row)] = left;
            }
        }
        let half_log_determinant = (0..M).map(|j| lower[(j, j)].ln()).sum();
        Some(JointGain { gain, whitening, half_log_determinant })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Matrix3, SVector};

    #[test]
    fn gain_and_correction_are_the_two_halves_of_a_joint_update() {
        let root = Matrix3::new(1.0, 0.0, 0.0, 0.3, 0.8, 0.0, -0.2, 0.5, 1.7);
        let belief = Gaussian { mean: SVector::from([1.0, -2.0, 0.5]), covariance: root * root.transpose() };
        let h = SMatrix::<f64, 2, 3>::new(1.0, 0.0, 0.4, 0.0, 1.0, -1.0);
        let r = Matrix2::new(0.04, 0.01, 0.01, 0.5);
        let innovation = [0.3, -0.7];
        let (mut whole, mut halves) = (belief, belief);
        let update = whole.update(SVector::from(innovation), &h, &r).unwrap();
        let gain = halves.condition(&h, &r).unwrap();
        halves.mean += SVector::from(gain.correction(&innovation));
        assert!((whole.mean - halves.mean).norm() < 1e-13);
        assert!((whole.covariance - halves.covariance).norm() < 1e-13);
        let white = gain.whitened(&innovation);
        assert!((white.iter().map(|w| w * w).sum::<f64>() - update.nis).abs() < 1e-12);
        let determinant = update.innovation_covariance.determinant();
        assert!((gain.half_log_determinant - 0.5 * determinant.ln()).abs() < 1e-12);
    }

    #[test]
    fn an_indefinite_innovation_covariance_changes_nothing() {
        let mut belief = Gaussian::<2>::independent(SVector::zeros(), &SVector::from([1.0, 2.0]));
        let before = belief;
        let h = SMatrix::<f64, 1, 2>::new(1.0, 0.0);
        assert!(belief.condition(&h, &SMatrix::<f64, 1, 1>::new(-50.0)).is_none());
        assert_eq!(belief, before);
        assert!(JointGain::<2, 1>::undefined().whitened(&[1.0])[0].is_nan());
    }
}
