//! Pad friction referred to standard conditions: what it would be at standard speed, pressing force and disc temperature.
//!
//! Over blocks of braking, the friction of the wagon is a linear function of how far the conditions are from standard,
//! `μ = μ_s + c_v (v/v_s − 1) + c_F (F/F_s − 1) + c_T (T − T_s)/100 K`, fitted by recursive least squares with a prior on the
//! coefficients (Bayesian linear regression; older blocks fade). Wheelsets take the wagon's coefficients. The temperature
//! is that of a lumped disc, `C dT/dt = P − C T/τ` above the surroundings; nothing measures it.

use crate::measure::mean::{BlockMean, Mean};
use crate::settings::StandardSettings;
use bytemuck::{Pod, Zeroable};

const N: usize = 4;
/// Neighbouring blocks resemble each other: a block counts as this share of an independent one.
const INDEPENDENCE: f64 = 0.4;
/// 1 σ of the prior of the friction, and of each coefficient, as a share of the nominal friction.
const PRIOR: [f64; N] = [0.6, 0.1, 0.1, 0.1];
/// What a block cannot know, 1 σ of the friction.
const FLOOR: f64 = 0.003;

/// The conditions of an instant, as distances from standard.
pub(crate) type Conditions = [f64; N];

/// The regression of one wagon.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(crate) struct Standard {
    information: [[f64; N]; N],
    weighted: [f64; N],
    /// Mean squared misfit over its expectation.
    misfit: f64,
    misfit_weight: f64,
    /// Braking behind it, s.
    pub seconds: f64,
    block_s: f64,
    block_y: f64,
    block_x: [f64; N],
    block_variance: f64,
}

impl Standard {
    /// Takes in the wagon's friction (mean and 1 σ) under some conditions, for `dt_s`.
    pub fn add(
        &mut self,
        dt_s: f64,
        (mu, sigma): (f64, f64),
        at: Conditions,
        nominal: f64,
        block_s: f64,
        memory_s: f64,
    ) {
        if !(mu.is_finite() && sigma.is_finite() && at.iter().all(|x| x.is_finite())) {
            return;
        }
        self.seconds += dt_s;
        self.block_s += dt_s;
        self.block_y += dt_s * mu;
        self.block_variance += dt_s * sigma * sigma;
        for (sum, x) in self.block_x.iter_mut().zip(at) {
            *sum += dt_s * x;
        }
        if self.block_s >= block_s {
            self.close(nominal, memory_s);
        }
    }

    fn close(&mut self, nominal: f64, memory_s: f64) {
        let seconds = std::mem::take(&mut self.block_s);
        let y = std::mem::take(&mut self.block_y) / seconds;
        let x = std::mem::take(&mut self.block_x).map(|sum| sum / seconds);
        let variance = std::mem::take(&mut self.block_variance) / seconds + FLOOR * FLOOR;
        let keep = (-seconds / memory_s).exp();
        if let Some((mean, covariance)) = self.solve(nominal) {
            let misfit = y - dot(&x, &mean);
            let expected = variance + quadratic(&covariance, &x);
            self.misfit = keep * self.misfit + misfit * misfit / expected;
            self.misfit_weight = keep * self.misfit_weight + 1.0;
        }
        let weight = INDEPENDENCE / variance;
        for row in 0..N {
            self.weighted[row] = keep * self.weighted[row] + weight * x[row] * y;
            for column in 0..N {
                self.information[row][column] =
                    keep * self.information[row][column] + weight * x[row] * x[column];
            }
        }
    }

    /// Mean and covariance of friction and coefficients; the prior does not fade.
    fn solve(&self, nominal: f64) -> Option<([f64; N], [[f64; N]; N])> {
        let mut matrix = self.information;
        let mut right = self.weighted;
        for i in 0..N {
            let prior = (PRIOR[i] * nominal).powi(-2);
            matrix[i][i] += prior;
            right[i] += if i == 0 { prior * nominal } else { 0.0 };
        }
        let covariance = inverse(matrix)?;
        Some((std::array::from_fn(|i| dot(&covariance[i], &right)), covariance))
    }

    /// Friction at standard conditions; `None` before the first block.
    pub fn mean(&self, nominal: f64) -> Option<Mean> {
        let (mean, covariance) = self.solve(nominal)?;
        if self.seconds <= self.block_s {
            return None;
        }
        let misfit =
            if self.misfit_weight >= 3.0 { (self.misfit / self.misfit_weight).max(1.0) } else { 1.0 };
        let sigma = (covariance[0][0] * misfit).sqrt();
        Some(Mean { value: mean[0], sigma, half_width: 1.96 * sigma })
    }

    /// What conditions add to the friction, with the 1 σ of that.
    pub fn offset(&self, at: Conditions, nominal: f64) -> (f64, f64) {
        let away = [0.0, at[1], at[2], at[3]];
        self.solve(nominal).map_or((0.0, 0.0), |(mean, covariance)| {
            (dot(&away, &mean), quadratic(&covariance, &away).max(0.0).sqrt())
        })
    }

    /// True if it holds numbers; a snapshot may bring anything.
    pub fn is_sound(&self) -> bool {
        self.information.iter().flatten().chain(&self.weighted).all(|value| value.is_finite())
    }
}

/// Friction of one wheelset at standard conditions, by the coefficients of its wagon.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(crate) struct WheelsetStandard {
    /// The corrected friction.
    pub mean: BlockMean,
    /// Disc temperature above the surroundings, K.
    pub rise_k: f64,
}

impl WheelsetStandard {
    /// Heats and cools the disc.
    pub fn heat(&mut self, dt_s: f64, power_w: f64, settings: &StandardSettings) {
        let power_w = if power_w.is_finite() { power_w.max(0.0) } else { 0.0 };
        self.rise_k += dt_s * (power_w / settings.disc_heat_j_per_k - self.rise_k / settings.disc_cooling_s);
    }
}

/// Distances from standard.
pub(crate) fn conditions(v_m_s: f64, force_n: f64, rise_k: f64, settings: &StandardSettings) -> Conditions {
    [
        1.0,
        v_m_s / settings.speed_m_s - 1.0,
        force_n / settings.pressing_force_n - 1.0,
        (rise_k - settings.disc_rise_k) / 100.0,
    ]
}

fn dot(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn quadratic(matrix: &[[f64; N]; N], x: &[f64; N]) -> f64 {
    matrix.iter().zip(x).map(|(row, x_row)| x_row * dot(row, x)).sum()
}

/// Inverse of a symmetric positive definite matrix by Gauss and Jordan; `None` if it is none.
fn inverse(mut matrix: [[f64; N]; N]) -> Option<[[f64; N]; N]> {
    let mut result = [[0.0; N]; N];
    for (i, row) in result.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    for pivot in 0..N {
        let value = matrix[pivot][pivot];
        if !(value.is_finite() && value > 0.0) {
            return None;
        }
        for column in 0..N {
            matrix[pivot][column] /= value;
            result[pivot][column] /= value;
        }
        for row in (0..N).filter(|row| *row != pivot) {
            let factor = matrix[row][pivot];
            for column in 0..N {
                matrix[row][column] -= factor * matrix[pivot][column];
                result[row][column] -= factor * result[pivot][column];
            }
        }
    }
    Some(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_is_one() {
        let matrix = [[4.0, 1.0, 0.5, 0.2], [1.0, 3.0, 0.1, 0.3], [0.5, 0.1, 2.0, 0.4], [0.2, 0.3, 0.4, 5.0]];
        let inverse = inverse(matrix).unwrap();
        for row in 0..N {
            for column in 0..N {
                let product: f64 = (0..N).map(|k| matrix[row][k] * inverse[k][column]).sum();
                assert!((product - f64::from(u8::from(row == column))).abs() < 1e-12);
            }
        }
        assert_eq!(super::inverse([[0.0; N]; N]), None);
    }

    #[test]
    fn stops_under_different_conditions_agree_on_the_standard() {
        let settings = StandardSettings::default();
        let law = |at: &Conditions| 0.33 - 0.02 * at[1] - 0.015 * at[2] - 0.01 * at[3];
        let mut standard = Standard::default();
        let mut plain = Vec::new();
        for stop in 0..12 {
            let (from_m_s, force_n) = (15.0 + 4.0 * f64::from(stop % 5), 30e3 + 15e3 * f64::from(stop % 3));
            let mut sum = 0.0;
            for step in 0..2000 {
                let share = f64::from(step) / 2000.0;
                let at = conditions(from_m_s * (1.0 - share), force_n, 20.0 + 80.0 * share, &settings);
                let wobble = 0.004 * (f64::from(step + 777 * stop) * 0.013).sin();
                sum += law(&at) / 2000.0;
                standard.add(0.01, (law(&at) + wobble, 0.008), at, 0.35, 5.0, 1800.0);
            }
            plain.push(sum);
        }
        let mean = standard.mean(0.35).unwrap();
        let spread =
            plain.iter().copied().fold(f64::MIN, f64::max) - plain.iter().copied().fold(f64::MAX, f64::min);
        println!(
            "standard {:.4} ± {:.4}, truth 0.3300; plain means of stops spread over {spread:.4}",
            mean.value, mean.half_width
        );
        assert!((mean.value - 0.33).abs() <= mean.half_width && mean.half_width < 0.02);
        assert!(spread > 0.012);
    }

    #[test]
    fn a_disc_heats_and_cools() {
        let settings = StandardSettings::default();
        let mut wheelset = WheelsetStandard::default();
        (0..1000).for_each(|_| wheelset.heat(0.01, 200e3, &settings));
        println!("10 s at 200 kW: {:.1} K", wheelset.rise_k);
        assert!((wheelset.rise_k - 33.0).abs() < 2.0);
        (0..100_000).for_each(|_| wheelset.heat(0.1, f64::NAN, &settings));
        assert!(wheelset.rise_k < 0.1);
    }
}
