//! Dynamics of the pad friction coefficient.

/// First-order pad friction, Schwarz & Keck (9): `μ̇ = (μ0 − μ) / (t_μ μ)`, a strong simplification of Ostermeyer's
/// friction dynamics (Wear 254, 2003). Note that t_μ / μ, not t_μ, is the time constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstOrderFriction {
    /// μ0, towards which friction tends, dimensionless.
    pub level: f64,
    /// t_μ, s.
    pub time_s: f64,
}

/// The law is not evaluated below this friction, where its time constant would vanish.
const LEAST_FRICTION: f64 = 0.01;

impl FirstOrderFriction {
    /// Rate of change at friction `mu`, 1/s.
    pub fn rate(&self, mu: f64) -> f64 {
        (self.level - mu) / (self.time_s * mu.max(LEAST_FRICTION))
    }

    /// Derivative of the rate with respect to the friction, 1/s: `−μ0 / (t_μ μ²)`.
    pub fn rate_slope(&self, mu: f64) -> f64 {
        let mu = mu.max(LEAST_FRICTION);
        -self.level / (self.time_s * mu * mu)
    }

    /// Friction after `dt_s` from `mu`: the linearised exponential step, which stays between `mu` and the level for
    /// any step length.
    pub fn step(&self, mu: f64, dt_s: f64) -> f64 {
        self.level + (mu - self.level) * (-dt_s / (self.time_s * mu.max(LEAST_FRICTION))).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::FirstOrderFriction;

    #[test]
    fn tends_to_its_level_with_the_published_rate() {
        let law = FirstOrderFriction { level: 0.35, time_s: 4.0 };
        assert!((law.rate(0.30) - 0.05 / (4.0 * 0.30)).abs() < 1e-15);
        let derivative = (law.step(0.30, 1e-6) - 0.30) / 1e-6;
        assert!((derivative / law.rate(0.30) - 1.0).abs() < 1e-4);
        let numeric = (law.rate(0.30 + 1e-6) - law.rate(0.30 - 1e-6)) / 2e-6;
        assert!((law.rate_slope(0.30) / numeric - 1.0).abs() < 1e-6);
        assert!((law.step(0.30, 1e3) - 0.35).abs() < 1e-12);
    }
}
