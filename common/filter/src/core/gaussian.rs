//! A Gaussian belief about a state, and the two steps that change it.

use nalgebra::{SMatrix, SVector};

/// Belief about a state of `N` components: mean and covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian<const N: usize> {
    /// Best estimate x.
    pub mean: SVector<f64, N>,
    /// Covariance P of its error, symmetric and positive definite.
    pub covariance: SMatrix<f64, N, N>,
}

/// What one measured number did to the belief.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScalarUpdate {
    /// Measured minus predicted value ν.
    pub innovation: f64,
    /// Its predicted variance s = h P hᵀ + r.
    pub innovation_variance: f64,
}

impl ScalarUpdate {
    /// ν²/s, χ² with one degree of freedom.
    #[inline]
    pub fn nis(&self) -> f64 {
        self.innovation * self.innovation / self.innovation_variance
    }
}

/// What a measured vector did to the belief.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointUpdate<const M: usize> {
    /// Measured minus predicted values.
    pub innovation: SVector<f64, M>,
    /// S = H P Hᵀ + R.
    pub innovation_covariance: SMatrix<f64, M, M>,
    /// νᵀ S⁻¹ ν.
    pub nis: f64,
}

impl<const N: usize> Gaussian<N> {
    /// A belief with independent components: means and one-sigma values.
    pub fn independent(mean: SVector<f64, N>, sigma: &SVector<f64, N>) -> Self {
        Self { mean, covariance: SMatrix::from_diagonal(&sigma.component_mul(sigma)) }
    }

    /// One sigma of component `index`.
    #[inline]
    pub fn sigma(&self, index: usize) -> f64 {
        self.covariance[(index, index)].max(0.0).sqrt()
    }

    /// One sigma of the linear combination `weights · x`.
    #[inline]
    pub fn sigma_along(&self, weights: &SVector<f64, N>) -> f64 {
        weights.dot(&(self.covariance * weights)).max(0.0).sqrt()
    }

    /// Moves the belief through a step: the mean is given (it may come from a non-linear model), the covariance
    /// becomes F P Fᵀ + Q, symmetrised.
    #[inline]
    pub fn predict(&mut self, mean: SVector<f64, N>, f: &SMatrix<f64, N, N>, q: &SMatrix<f64, N, N>) {
        self.mean = mean;
        self.covariance = f * self.covariance * f.transpose() + q;
        self.symmetrise();
    }

    /// Like [`Self::predict`] for a model of which only the rows before `moving` differ from the identity, with
    /// independent noise: the same result with less work.
    #[inline]
    pub fn predict_leading(
        &mut self,
        mean: SVector<f64, N>,
        f: &SMatrix<f64, N, N>,
        moving: usize,
        q_diagonal: &SVector<f64, N>,
    ) {
        self.mean = mean;
        let p = &self.covariance;
        // The first columns of P Fᵀ; the others are those of P.
        let mut half = *p;
        for row in 0..moving {
            let mut column = SVector::<f64, N>::zeros();
            for k in 0..N {
                let weight = f[(row, k)];
                if weight != 0.0 {
                    column.axpy(weight, &p.column(k), 1.0);
                }
            }
            half.set_column(row, &column);
        }
        let mut next = half;
        for column in 0..N {
            for row in 0..moving.min(column + 1) {
                let mut sum = 0.0;
                for k in 0..N {
                    sum += f[(row, k)] * half[(k, column)];
                }
                next[(row, column)] = sum;
                next[(column, row)] = sum;
            }
        }
        for i in 0..N {
            next[(i, i)] += q_diagonal[i];
        }
        self.covariance = next;
    }

    /// Like [`Self::predict`] without a mean, for a model of which only the rows before `moving` have more than their diagonal: the same
    /// result with less work.
    #[inline]
    pub fn predict_covariance(&mut self, f: &SMatrix<f64, N, N>, moving: usize, q: &SMatrix<f64, N, N>) {
        // P Fᵀ.
        let mut half = SMatrix::<f64, N, N>::zeros();
        for row in 0..N {
            if row >= moving {
                half.set_column(row, &(self.covariance.column(row) * f[(row, row)]));
                continue;
            }
            let mut column = SVector::<f64, N>::zeros();
            for k in 0..N {
                column.axpy(f[(row, k)], &self.covariance.column(k), 1.0);
            }
            half.set_column(row, &column);
        }
        for column in 0..N {
            for row in 0..=column {
                let moved = if row >= moving {
                    f[(row, row)] * half[(row, column)]
                } else {
                    (0..N).map(|k| f[(row, k)] * half[(k, column)]).sum()
                };
                self.covariance[(row, column)] = moved + q[(row, column)];
                self.covariance[(column, row)] = self.covariance[(row, column)];
            }
        }
    }

    /// What measuring component `index` with variance `r` as `measured` would say, without using it.
    #[inline]
    pub fn expect_component(&self, index: usize, measured: f64, r: f64) -> ScalarUpdate {
        ScalarUpdate {
            innovation: measured - self.mean[index],
            innovation_variance: self.covariance[(index, index)] + r,
        }
    }

    /// Uses a measurement of component `index` whose innovation was computed by [`Self::expect_component`].
    ///
    /// Joseph form P ← (I − k h) P (I − k h)ᵀ + r k kᵀ, written out for a row h that picks one component; its
    /// factor 1 − k_index is taken as r/s, which does not cancel for an accurate sensor.
    #[inline]
    pub fn update_component(&mut self, index: usize, update: &ScalarUpdate, r: f64) {
        let inverse = 1.0 / update.innovation_variance;
        let measured_column: SVector<f64, N> = self.covariance.column(index).into_owned();
        let gain = measured_column * inverse;
        self.mean.axpy(update.innovation, &gain, 1.0);
        let kept = r * inverse;
        let reduced = {
            let mut column = measured_column - gain * measured_column[index];
            column[index] = measured_column[index] * kept;
            column - gain * r
        };
        for column in 0..N {
            let along = measured_column[column];
            let back = gain[column];
            for row in 0..N {
                self.covariance[(row, column)] -= gain[row] * along + reduced[row] * back;
            }
        }
        for i in 0..N {
            let value = measured_column[i] * kept;
            self.covariance[(i, index)] = value;
            self.covariance[(index, i)] = value;
        }
        self.symmetrise();
    }

    /// Like [`Self::update_component`], but the components `considered` only lend their uncertainty (Schmidt): their means
    /// and covariances among each other stay, all others are updated as they would be.
    #[inline]
    pub fn update_component_considering(
        &mut self,
        index: usize,
        update: &ScalarUpdate,
        r: f64,
        considered: impl Iterator<Item = usize> + Clone,
    ) {
        let before = *self;
        self.update_component(index, update, r);
        for i in considered.clone() {
            self.mean[i] = before.mean[i];
            for j in considered.clone() {
                self.covariance[(i, j)] = before.covariance[(i, j)];
            }
        }
    }

    /// Forgets component `index`: it takes a new value and sigma, and its ties to the others are cut.
    pub fn reset_component(&mut self, index: usize, value: f64, sigma: f64) {
        self.mean[index] = value;
        self.covariance.row_mut(index).fill(0.0);
        self.covariance.column_mut(index).fill(0.0);
        self.covariance[(index, index)] = sigma * sigma;
    }

    /// Moves the mean to the most probable state whose component `index` is `value`, as when an estimate leaves the
    /// physically possible range; the covariance stays, because the bound adds no measurement.
    pub fn constrain_component(&mut self, index: usize, value: f64) {
        let shift = (value - self.mean[index]) / self.covariance[(index, index)];
        let column: SVector<f64, N> = self.covariance.column(index).into_owned();
        self.mean.axpy(shift, &column, 1.0);
        self.mean[index] = value;
    }

    /// What measuring `h · x` would say when its innovation is `innovation`.
    #[inline]
    pub fn expect_row(&self, h: &SVector<f64, N>, innovation: f64, r: f64) -> ScalarUpdate {
        ScalarUpdate { innovation, innovation_variance: h.dot(&(self.covariance * h)) + r }
    }

    /// Uses a measurement of the linear combination `h · x` (Joseph form).
    #[inline]
    pub fn update_row(&mut self, h: &SVector<f64, N>, update: &ScalarUpdate, r: f64) {
        let projected = self.covariance * h;
        let gain = projected / update.innovation_variance;
        self.mean.axpy(update.innovation, &gain, 1.0);
        let keep = SMatrix::<f64, N, N>::identity() - gain * h.transpose();
        self.covariance = keep * self.covariance * keep.transpose() + gain * gain.transpose() * r;
        self.symmetrise();
    }

    /// Uses `M` values measured at once with correlated noise: Cholesky solve for the gain, Joseph form for the
    /// covariance. `None`, and no change, if S is not positive definite.
    pub fn update<const M: usize>(
        &mut self,
        innovation: SVector<f64, M>,
        h: &SMatrix<f64, M, N>,
        r: &SMatrix<f64, M, M>,
    ) -> Option<JointUpdate<M>> {
        let projected = h * self.covariance;
        let innovation_covariance = projected * h.transpose() + r;
        let factor = innovation_covariance.cholesky()?;
        let gain = factor.solve(&projected).transpose();
        let nis = innovation.dot(&factor.solve(&innovation));
        self.mean += gain * innovation;
        let keep = SMatrix::<f64, N, N>::identity() - gain * h;
        self.covariance = keep * self.covariance * keep.transpose() + gain * r * gain.transpose();
        self.symmetrise();
        Some(JointUpdate { innovation, innovation_covariance, nis })
    }

    /// Makes P exactly symmetric again after rounding.
    #[inline]
    pub fn symmetrise(&mut self) {
        for column in 1..N {
            for row in 0..column {
                let mean = 0.5 * (self.covariance[(row, column)] + self.covariance[(column, row)]);
                self.covariance[(row, column)] = mean;
                self.covariance[(column, row)] = mean;
            }
        }
    }

    /// True if everything is finite and P is positive definite.
    pub fn is_sound(&self) -> bool {
        self.mean.iter().all(|value| value.is_finite())
            && self.covariance.iter().all(|value| value.is_finite())
            && self.covariance.cholesky().is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    fn belief() -> Gaussian<3> {
        let root = Matrix3::new(1.0, 0.0, 0.0, 0.3, 0.8, 0.0, -0.2, 0.5, 1.7);
        Gaussian { mean: Vector3::new(1.0, -2.0, 0.5), covariance: root * root.transpose() }
    }

    #[test]
    fn scalar_row_and_joint_updates_agree() {
        let (mut by_component, mut by_row, mut joint) = (belief(), belief(), belief());
        for (index, measured, r) in [(0, 1.3, 0.04), (2, 0.1, 0.5)] {
            let update = by_component.expect_component(index, measured, r);
            by_component.update_component(index, &update, r);
            let mut h = Vector3::zeros();
            h[index] = 1.0;
            let update = by_row.expect_row(&h, measured - by_row.mean[index], r);
            by_row.update_row(&h, &update, r);
        }
        let h = SMatrix::<f64, 2, 3>::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        let innovation = SVector::<f64, 2>::new(1.3, 0.1) - h * joint.mean;
        let r = SMatrix::<f64, 2, 2>::new(0.04, 0.0, 0.0, 0.5);
        joint.update(innovation, &h, &r).unwrap();
        assert!((by_component.covariance - joint.covariance).norm() < 1e-13);
        assert!((by_row.covariance - joint.covariance).norm() < 1e-13);
        assert!((by_component.mean - joint.mean).norm() < 1e-13);
        assert!((by_row.mean - joint.mean).norm() < 1e-13);
    }

    #[test]
    fn a_considered_component_matches_the_joseph_form_of_its_gain() {
        let (before, mut after) = (belief(), belief());
        let update = after.expect_component(0, 1.4, 0.3);
        after.update_component_considering(0, &update, 0.3, std::iter::once(2));
        let mut gain = before.covariance.column(0) / update.innovation_variance;
        gain[2] = 0.0;
        let keep = Matrix3::identity() - gain * Vector3::new(1.0, 0.0, 0.0).transpose();
        let joseph = keep * before.covariance * keep.transpose() + gain * gain.transpose() * 0.3;
        assert!((after.covariance - joseph).norm() < 1e-13);
        assert!((after.mean - before.mean - gain * update.innovation).norm() < 1e-13);
    }

    #[test]
    fn leading_rows_predict_like_the_dense_form() {
        let f = Matrix3::new(1.0, 0.1, -0.4, 0.0, 0.9, 0.2, 0.0, 0.0, 1.0);
        let q = Vector3::new(0.1, 0.2, 0.3);
        let (mut dense, mut leading) = (belief(), belief());
        dense.predict(f * belief().mean, &f, &Matrix3::from_diagonal(&q));
        leading.predict_leading(f * belief().mean, &f, 2, &q);
        assert!((dense.covariance - leading.covariance).norm() < 1e-14);
        assert_eq!(leading.covariance, leading.covariance.transpose());
    }

    #[test]
    fn rows_that_only_decay_predict_like_the_dense_form() {
        let f = Matrix3::new(1.0, 0.1, -0.4, 0.0, 0.9, 0.0, 0.0, 0.0, 0.7);
        let q = Matrix3::new(0.1, 0.02, 0.0, 0.02, 0.2, 0.0, 0.0, 0.0, 0.3);
        let (mut dense, mut sparse) = (belief(), belief());
        dense.predict(belief().mean, &f, &q);
        sparse.predict_covariance(&f, 1, &q);
        assert!((dense.covariance - sparse.covariance).norm() < 1e-14);
        assert_eq!(sparse.covariance, sparse.covariance.transpose());
        assert_eq!(sparse.mean, belief().mean);
    }

    #[test]
    fn a_nearly_exact_sensor_leaves_a_sound_belief() {
        let mut belief = belief();
        belief.covariance *= 1e8;
        for _ in 0..3 {
            for index in 0..3 {
                let update = belief.expect_component(index, 1.0, 1e-12);
                belief.update_component(index, &update, 1e-12);
            }
        }
        assert!(belief.is_sound());
        assert!((belief.sigma(1) - 1e-6).abs() < 1e-6);
    }

    #[test]
    fn an_indefinite_innovation_covariance_is_refused() {
        let mut belief = belief();
        let before = belief;
        let h = SMatrix::<f64, 1, 3>::new(1.0, 0.0, 0.0);
        assert!(belief.update(SVector::<f64, 1>::new(1.0), &h, &SMatrix::<f64, 1, 1>::new(-50.0)).is_none());
        assert_eq!(belief, before);
    }
}
