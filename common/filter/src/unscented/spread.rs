//! Where the sigma points lie and what they weigh.

/// Parameters of the unscented transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    alpha: f64,
    beta: f64,
    kappa: f64,
}

impl Default for Spread {
    /// The customary α = 1e-3, β = 2, κ = 0, as Zhao et al. take them.
    fn default() -> Self {
        Self { alpha: 1e-3, beta: 2.0, kappa: 0.0 }
    }
}

/// Parameters that give no filter.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SpreadError {
    /// α out of range.
    #[error("alpha is {0}, allowed is 1e-4 to 2")]
    Alpha(f64),
    /// β too small for a covariance that is positive by construction.
    #[error("beta is {0}, allowed is alpha² and above")]
    Beta(f64),
    /// κ that is negative or not finite.
    #[error("kappa is {0}, allowed is 0 and above")]
    Kappa(f64),
}

impl Spread {
    /// Checked parameters.
    ///
    /// # Errors
    /// If α, β or κ lies outside what keeps the covariance positive by construction.
    pub fn new(alpha: f64, beta: f64, kappa: f64) -> Result<Self, SpreadError> {
        if !(1e-4..=2.0).contains(&alpha) {
            return Err(SpreadError::Alpha(alpha));
        }
        if !(beta >= alpha * alpha && beta.is_finite()) {
            return Err(SpreadError::Beta(beta));
        }
        if !(kappa >= 0.0 && kappa.is_finite()) {
            return Err(SpreadError::Kappa(kappa));
        }
        Ok(Self { alpha, beta, kappa })
    }

    /// c² = p + λ for `p` states.
    pub fn reach_squared(&self, p: usize) -> f64 {
        self.alpha * self.alpha * (p as f64 + self.kappa)
    }

    /// W_m(0) = λ/(p+λ): (4-5).
    pub fn central_mean_weight(&self, p: usize) -> f64 {
        1.0 - p as f64 / self.reach_squared(p)
    }

    /// W_c(0) = λ/(p+λ) + 1 − α² + β: (4-6), whose left side reads W_m in the paper.
    pub fn central_covariance_weight(&self, p: usize) -> f64 {
        self.central_mean_weight(p) + 1.0 - self.alpha * self.alpha + self.beta
    }

    /// W(i) for i ≥ 1: (4-7).
    pub fn outer_weight(&self, p: usize) -> f64 {
        0.5 / self.reach_squared(p)
    }

    /// β − α², the weight of m mᵀ when differences are taken from the central point.
    pub fn shift_weight(&self) -> f64 {
        self.beta - self.alpha * self.alpha
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn erratum_7_weights_add_up_over_all_2p_plus_1_points() {
        let spread = Spread::default();
        let p = 13;
        // (4-8) must start at i = 0 and (4-4) end at 2p, else the weights do not add up to one.
        let sum = spread.central_mean_weight(p) + 2.0 * p as f64 * spread.outer_weight(p);
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        let difference = spread.central_covariance_weight(p) - spread.central_mean_weight(p);
        assert!((difference - (1.0 - 1e-6 + 2.0)).abs() < 1e-9);
    }

    #[test]
    fn erratum_8_central_weight_is_about_minus_a_million() {
        let weight = Spread::default().central_covariance_weight(13);
        println!("central covariance weight {weight:.1}");
        assert!((weight + 1e6).abs() < 10.0);
    }

    #[test]
    fn parameters_without_a_positive_covariance_are_refused() {
        assert_eq!(Spread::new(1.0, 0.5, 0.0), Err(SpreadError::Beta(0.5)));
        assert_eq!(Spread::new(0.0, 2.0, 0.0), Err(SpreadError::Alpha(0.0)));
        assert!(Spread::new(1.0, 2.0, f64::NAN).is_err());
        assert!(Spread::new(0.5, 2.0, 0.0).is_ok());
    }
}
