//! Draw gear and buffers between two wagons: slack, preload, a spring that stiffens, and friction that makes unloading
//! softer than loading.

/// Speed of deflection at which friction is fully developed, m/s.
const FRICTION_SPEED_M_S: f64 = 0.008;
/// Deflection over which the preload is taken up, m.
const PRELOAD_PATH_M: f64 = 1.5e-3;

/// One kind of draw gear; tension and buff are alike.
#[derive(Debug, Clone, Copy)]
pub struct DrawGear {
    /// Free way from full buff to full tension, m.
    pub slack_m: f64,
    /// Force before the spring gives way, N.
    pub preload_n: f64,
    /// Spring, N/m.
    pub stiffness_n_per_m: f64,
    /// Stiffening with the cube of the deflection, N/m³.
    pub stiffening_n_per_m3: f64,
    /// Share of the force that is friction.
    pub friction: f64,
    /// Damping while the spring works, N s/m.
    pub damping_n_s_per_m: f64,
}

/// Force of a coupler (tension positive, N) with its derivatives by deflection (N/m) and by rate (N s/m).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Pull {
    pub(crate) force_n: f64,
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
}

impl DrawGear {
    /// The pull at an extension (m, zero in mid slack) that grows at `rate_m_s`.
    pub(crate) fn pull(&self, extension_m: f64, rate_m_s: f64) -> Pull {
        let depth_m = extension_m.abs() - 0.5 * self.slack_m;
        if depth_m <= 0.0 {
            return Pull::default();
        }
        let side = extension_m.signum();
        let left = (-depth_m / PRELOAD_PATH_M).exp();
        let spring_n = self.preload_n * (1.0 - left)
            + depth_m * (self.stiffness_n_per_m + self.stiffening_n_per_m3 * depth_m * depth_m);
        let tangent = self.preload_n / PRELOAD_PATH_M * left
            + self.stiffness_n_per_m
            + 3.0 * self.stiffening_n_per_m3 * depth_m * depth_m;
        let turn = (side * rate_m_s / FRICTION_SPEED_M_S).tanh();
        let wedge = 1.0 + self.friction * turn;
        let damping = self.damping_n_s_per_m * (depth_m / PRELOAD_PATH_M).min(1.0);
        let force_n = (spring_n * wedge + damping * side * rate_m_s).max(0.0);
        let rub = spring_n * self.friction * (1.0 - turn * turn) / FRICTION_SPEED_M_S;
        Pull { force_n: side * force_n, stiffness: tangent * wedge, damping: damping + rub }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCREW: DrawGear = DrawGear {
        slack_m: 0.02,
        preload_n: 2e4,
        stiffness_n_per_m: 8e6,
        stiffening_n_per_m3: 2e9,
        friction: 0.25,
        damping_n_s_per_m: 2e4,
    };

    #[test]
    fn slack_is_free_and_loading_is_harder_than_unloading() {
        assert_eq!(SCREW.pull(0.009, 0.3).force_n, 0.0);
        assert_eq!(SCREW.pull(-0.009, 0.3).force_n, 0.0);
        let (loading, unloading) = (SCREW.pull(0.02, 0.1).force_n, SCREW.pull(0.02, -0.1).force_n);
        assert!(loading > 1.4 * unloading && unloading > 0.0);
        assert!((SCREW.pull(-0.02, -0.1).force_n + loading).abs() < 1e-6);
    }

    #[test]
    fn a_cycle_of_deflection_takes_energy() {
        let steps = 2000;
        let way = |k: usize| 0.03 * (std::f64::consts::TAU * k as f64 / steps as f64).sin();
        let work: f64 = (0..steps)
            .map(|k| {
                let step_m = way(k + 1) - way(k);
                SCREW.pull(0.5 * (way(k) + way(k + 1)), step_m / 1e-3).force_n * step_m
            })
            .sum();
        assert!(work > 500.0, "{work} J");
    }
}
