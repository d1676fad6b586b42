//! Normal load of the wheelsets and its transfer by acceleration.

use crate::{GRAVITY_M_S2, MAX_WHEELSETS, PerWheelset};

/// How a rigid body on equal springs hands weight and pitching moment to its wheelsets.
///
/// For two wheelsets this is the exact relation of Schwarz & Keck (4) with the sign mended:
/// `F_z,f = m g/2 − (h/a) m v̇`, `F_z,r = m g/2 + (h/a) m v̇`: braking loads the leading wheelset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadDistribution {
    static_load_n: PerWheelset,
    /// Change of load per acceleration, N/(m/s²), negative ahead of the centre of mass.
    transfer_kg: PerWheelset,
    wheelsets: usize,
}

impl LoadDistribution {
    /// Distribution of `mass_kg` whose centre lies `com_height_m` above the rail, on wheelsets at `positions_m` ahead of it.
    pub fn new(mass_kg: f64, com_height_m: f64, positions_m: &PerWheelset, wheelsets: usize) -> Self {
        let spread: f64 = positions_m[..wheelsets].iter().map(|x| x * x).sum();
        let mut static_load_n = [0.0; MAX_WHEELSETS];
        let mut transfer_kg = [0.0; MAX_WHEELSETS];
        for i in 0..wheelsets {
            static_load_n[i] = mass_kg * GRAVITY_M_S2 / wheelsets as f64;
            transfer_kg[i] = -mass_kg * com_height_m * positions_m[i] / spread;
        }
        Self { static_load_n, transfer_kg, wheelsets }
    }

    /// Loads that acceleration does not change, as on a roller rig.
    pub fn fixed(load_n: f64, wheelsets: usize) -> Self {
        let mut static_load_n = [0.0; MAX_WHEELSETS];
        static_load_n[..wheelsets].fill(load_n);
        Self { static_load_n, transfer_kg: [0.0; MAX_WHEELSETS], wheelsets }
    }

    /// Load of each wheelset at acceleration `acceleration_m_s2`, N; a wheelset cannot pull on the rail.
    #[inline]
    pub fn loads_n(&self, acceleration_m_s2: f64) -> PerWheelset {
        let mut loads = [0.0; MAX_WHEELSETS];
        for (i, load) in loads.iter_mut().enumerate().take(self.wheelsets) {
            *load = (self.static_load_n[i] + self.transfer_kg[i] * acceleration_m_s2).max(0.0);
        }
        loads
    }

    /// Exact acceleration, m/s², when each wheelset utilises the adhesion `utilised` (signed) and `other_force_n`
    /// acts besides: the small linear relation that Schwarz & Keck (11) cuts short by dropping 2 (h/a) μ_W against 1.
    pub fn acceleration_m_s2(&self, mass_kg: f64, utilised: &PerWheelset, other_force_n: f64) -> f64 {
        let mut force = other_force_n;
        let mut feedback = 0.0;
        for i in 0..self.wheelsets {
            force += utilised[i] * self.static_load_n[i];
            feedback += utilised[i] * self.transfer_kg[i];
        }
        force / (mass_kg - feedback)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn braking_loads_the_leading_wheelset() {
        let (m, h, a) = (4e4, 1.6, 10.0);
        let two = LoadDistribution::new(m, h, &[5.0, -5.0, 0.0, 0.0], 2);
        let loads = two.loads_n(-1.0);
        let shift = h / a * m;
        assert!((loads[0] - (m * GRAVITY_M_S2 / 2.0 + shift)).abs() < 1e-6);
        assert!((loads[1] - (m * GRAVITY_M_S2 / 2.0 - shift)).abs() < 1e-6);
    }

    #[test]
    fn four_wheelsets_balance_weight_and_moment() {
        let (m, h) = (5e4, 1.7);
        let positions = [9.5, 7.0, -7.0, -9.5];
        let loads = LoadDistribution::new(m, h, &positions, 4).loads_n(-1.2);
        let weight: f64 = loads.iter().sum();
        let moment: f64 = loads.iter().zip(positions).map(|(f, x)| f * x).sum();
        assert!((weight / (m * GRAVITY_M_S2) - 1.0).abs() < 1e-12);
        assert!((moment / (m * 1.2 * h) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn exact_acceleration_is_consistent_with_its_loads() {
        let m = 4e4;
        let two = LoadDistribution::new(m, 1.6, &[5.0, -5.0, 0.0, 0.0], 2);
        let utilised = [-0.12, -0.05, 0.0, 0.0];
        let acceleration = two.acceleration_m_s2(m, &utilised, -900.0);
        let loads = two.loads_n(acceleration);
        let sum = utilised[0] * loads[0] + utilised[1] * loads[1] - 900.0;
        assert!((m * acceleration / sum - 1.0).abs() < 1e-12);
    }
}
