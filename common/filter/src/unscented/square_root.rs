//! Belief of the square-root filter and the two steps that change it.

use super::Spread;
use super::triangular::{fold_row, fold_rows};
use crate::core::{Gaussian, JointUpdate, ScalarUpdate};
use nalgebra::{SMatrix, SVector};

/// Belief about a state of `N` components: mean and a square root of its covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareRootBelief<const N: usize> {
    /// Best estimate x.
    pub mean: SVector<f64, N>,
    /// S with P = S Sᵀ.
    pub root: SMatrix<f64, N, N>,
}

impl<const N: usize> SquareRootBelief<N> {
    /// A belief with independent components: means and one-sigma values.
    pub fn independent(mean: SVector<f64, N>, sigma: &SVector<f64, N>) -> Self {
        Self { mean, root: SMatrix::from_diagonal(sigma) }
    }

    /// P = S Sᵀ, for reading.
    pub fn covariance(&self) -> SMatrix<f64, N, N> {
        self.root * self.root.transpose()
    }

    /// The same belief as mean and covariance.
    pub fn gaussian(&self) -> Gaussian<N> {
        let mut gaussian = Gaussian { mean: self.mean, covariance: self.covariance() };
        gaussian.symmetrise();
        gaussian
    }

    /// One sigma of component `index`.
    #[inline]
    pub fn sigma(&self, index: usize) -> f64 {
        self.root.row(index).norm()
    }

    /// True if everything is finite and S has no zero direction.
    pub fn is_sound(&self) -> bool {
        let finite = self.mean.iter().chain(self.root.iter()).all(|value| value.is_finite());
        let mut r = SMatrix::zeros();
        fold_rows(&mut r, &mut self.root.transpose());
        finite && (0..N).all(|i| r[(i, i)] != 0.0)
    }

    /// Normalised error squared of a known truth, χ² with `N` degrees of freedom; infinite if S is singular.
    pub fn nees(&self, truth: &SVector<f64, N>) -> f64 {
        let mut r = SMatrix::zeros();
        fold_rows(&mut r, &mut self.root.transpose());
        match r.transpose().solve_lower_triangular(&(truth - self.mean)) {
            Some(whitened) => whitened.norm_squared(),
            None => f64::INFINITY,
        }
    }

    /// Moves the belief through `step` with independent additive noise of one sigma `noise_sigma`.
    #[inline]
    pub fn predict(
        &mut self,
        spread: &Spread,
        noise_sigma: &SVector<f64, N>,
        mut step: impl FnMut(&SVector<f64, N>) -> SVector<f64, N>,
    ) {
        let reach = spread.reach_squared(N).sqrt();
        let weight = spread.outer_weight(N);
        let (odd_scale, even_scale) = ((0.5 * weight).sqrt(), (0.5 * weight).sqrt());
        let centre = step(&self.mean);
        let mut odd = SMatrix::<f64, N, N>::zeros();
        let mut even = SMatrix::<f64, N, N>::zeros();
        let mut shift = SVector::<f64, N>::zeros();
        for i in 0..N {
            let offset = self.root.column(i) * reach;
            let (ahead, behind) = (step(&(self.mean + offset)), step(&(self.mean - offset)));
            // Each minus the centre first: the sum of the two is of second order.
            let (forward, backward) = (ahead - centre, behind - centre);
            let sum = forward + backward;
            shift += sum;
            odd.set_row(i, &((ahead - behind) * odd_scale).transpose());
            even.set_row(i, &(sum * even_scale).transpose());
        }
        shift *= weight;
        let mut r = SMatrix::from_diagonal(noise_sigma);
        fold_rows(&mut r, &mut odd);
        fold_rows(&mut r, &mut even);
        fold_row(&mut r, shift * spread.shift_weight().sqrt());
        self.mean = centre + shift;
        self.root = r.transpose();
    }

    /// Forgets everything about component `index`, also what ties it to the others, and takes it as `mean` ± `sigma`.
    pub fn forget_component(&mut self, index: usize, mean: f64, sigma: f64) {
        self.mean[index] = mean;
        let mut rows = self.root.transpose();
        rows.column_mut(index).fill(0.0);
        let mut r = SMatrix::zeros();
        r[(index, index)] = sigma;
        fold_rows(&mut r, &mut rows);
        self.root = r.transpose();
    }

    /// What measuring component `index` with variance `r` as `measured` would say, without using it.
    #[inline]
    pub fn expect_component(&self, index: usize, measured: f64, r: f64) -> ScalarUpdate {
        ScalarUpdate {
            innovation: measured - self.mean[index],
            innovation_variance: self.root.row(index).norm_squared() + r,
        }
    }

    /// Uses a measurement of component `index` (Potter): S ← S − k φᵀ / (1 + √(r/s)), φ = Sᵀ h. For a measurement that
    /// picks a component the unscented update and this one are the same.
    #[inline]
    pub fn update_component(&mut self, index: usize, update: &ScalarUpdate, r: f64) {
        let phi: SVector<f64, N> = self.root.row(index).transpose();
        let variance = update.innovation_variance;
        let gain = self.root * phi / variance;
        self.mean.axpy(update.innovation, &gain, 1.0);
        let keep = 1.0 / (1.0 + (r / variance).sqrt());
        self.root -= gain * (phi * keep).transpose();
    }

    /// Uses `M` values measured at once through a non-linear `measure` with independent noise of one sigma
    /// `noise_sigma`: triangularises `[√R 0; √W ΔY √W ΔX]`, whose factor holds √S_y, the gain and the new root.
    /// `None`, and no change, if something is not finite.
    pub fn update<const M: usize>(
        &mut self,
        spread: &Spread,
        measured: &SVector<f64, M>,
        noise_sigma: &SVector<f64, M>,
        mut measure: impl FnMut(&SVector<f64, N>) -> SVector<f64, M>,
    ) -> Option<JointUpdate<M>> {
        let reach = spread.reach_squared(N).sqrt();
        let weight = spread.outer_weight(N);
        let half = (0.5 * weight).sqrt();
        let centre = measure(&self.mean);
        let mut output = SMatrix::<f64, N, M>::zeros();
        let mut even = SMatrix::<f64, N, M>::zeros();
        let mut shift = SVector::<f64, M>::zeros();
        for i in 0..N {
            let offset = self.root.column(i) * reach;
            let (ahead, behind) = (measure(&(self.mean + offset)), measure(&(self.mean - offset)));
            let sum = (ahead - centre) + (behind - centre);
            shift += sum;
            output.set_row(i, &((ahead - behind) * half).transpose());
            even.set_row(i, &(sum * half).transpose());
        }
        shift *= weight;
        // Rows without a part in the state go into the noise block first.
        let mut noise = SMatrix::from_diagonal(noise_sigma);
        fold_rows(&mut noise, &mut even);
        fold_row(&mut noise, shift * spread.shift_weight().sqrt());
        let mut state = self.root.transpose();
        let mut cross = SMatrix::<f64, M, N>::zeros();
        fold_joint(&mut noise, &mut cross, &mut output, &mut state);
        let innovation = measured - (centre + shift);
        let whitened = noise.transpose().solve_lower_triangular(&innovation)?;
        let mean = self.mean + cross.transpose() * whitened;
        if !(mean.iter().chain(state.iter()).all(|value| value.is_finite())) {
            return None;
        }
        self.mean = mean;
        self.root = state.transpose();
        Some(JointUpdate {
            innovation,
            innovation_covariance: noise.transpose() * noise,
            nis: whitened.norm_squared(),
        })
    }
}

/// Triangularises `[r cross; output state]` over the columns of `r`, carrying the state columns along.
fn fold_joint<const N: usize, const M: usize>(
    r: &mut SMatrix<f64, M, M>,
    cross: &mut SMatrix<f64, M, N>,
    output: &mut SMatrix<f64, N, M>,
    state: &mut SMatrix<f64, N, N>,
) {
    for pivot in 0..M {
        let column: SVector<f64, N> = output.column(pivot).into_owned();
        let below = column.norm_squared();
        if below == 0.0 {
            continue;
        }
        let head = r[(pivot, pivot)];
        let norm = (head * head + below).sqrt();
        let target = if head > 0.0 { -norm } else { norm };
        let lead = head - target;
        let scale = 2.0 / (lead * lead + below);
        r[(pivot, pivot)] = target;
        for other in pivot + 1..M {
            let along = (lead * r[(pivot, other)] + column.dot(&output.column(other))) * scale;
            r[(pivot, other)] -= along * lead;
            output.column_mut(other).axpy(-along, &column, 1.0);
        }
        for other in 0..N {
            let along = (lead * cross[(pivot, other)] + column.dot(&state.column(other))) * scale;
            cross[(pivot, other)] -= along * lead;
            state.column_mut(other).axpy(-along, &column, 1.0);
        }
    }
}

#[cfg(test)]
mod tests;
