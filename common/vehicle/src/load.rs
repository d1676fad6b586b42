//! Normal load of the wheelsets and its transfer by acceleration.
//!
//! Schwarz & Keck (4) with the sign mended (braking loads the leading wheelset), for any number of wheelsets on equal
//! springs:
//!
//! ```text
//! F_z,i = m g / n − m h x_i / Σ x² · v̇        N;  two wheelsets at ± a/2:  m g/2 ∓ (h/a) m v̇
//! m v̇  = Σ μ_i F_z,i + F      ⇒      v̇ = (Σ μ_i F_z,i(0) + F) / (m − Σ μ_i ∂F_z,i/∂v̇)
//! ```
//!
//! h height of the centre of mass (m), x_i place of wheelset i ahead of it (m), a wheelbase (m), μ_i adhesion utilised,
//! signed. The second line is (2) in (1) with the exact load; (11) drops 2 (h/a) μ_W against 1 there. Quasi-static: how the
//! body and bogies swing on their springs is not in it.

use crate::{GRAVITY_M_S2, MAX_WHEELSETS, PerWheelset};

/// How a rigid body hands weight and pitching moment to its `W` wheelsets; entries beyond a wagon's own count are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadDistribution<const W: usize = MAX_WHEELSETS> {
    /// Load of each wheelset at rest, N.
    pub static_load_n: [f64; W],
    /// Change of load per acceleration ∂F_z/∂v̇, N/(m/s²), negative ahead of the centre of mass.
    pub transfer_kg: [f64; W],
}

impl LoadDistribution {
    /// Distribution of `mass_kg` whose centre lies `com_height_m` above the rail, on wheelsets at `positions_m` ahead of it.
    pub fn new(mass_kg: f64, com_height_m: f64, positions_m: &PerWheelset, wheelsets: usize) -> Self {
        let spread: f64 = positions_m[..wheelsets].iter().map(|x| x * x).sum();
        let mut loads = Self { static_load_n: [0.0; MAX_WHEELSETS], transfer_kg: [0.0; MAX_WHEELSETS] };
        for i in 0..wheelsets {
            loads.static_load_n[i] = mass_kg * GRAVITY_M_S2 / wheelsets as f64;
            loads.transfer_kg[i] = -mass_kg * com_height_m * positions_m[i] / spread;
        }
        loads
    }

    /// The same on two bogies with two wheelsets each: the body leans on its pivots by its moment about them, and each bogie
    /// by the force that its pivot hands on,
    ///
    /// ```text
    /// ∂F_z,i/∂v̇ = ∓ m (h − h_p) / (2 A)  ∓ m h_p / (2 b)        N/(m/s²)
    /// ```
    ///
    /// A distance of the bogies' centres, b wheelbase of a bogie, h_p height of the pivots (m); the first sign is that of the
    /// bogie, the second that of the wheelset in it, both negative in front. The mass of the bogies counts as the body's.
    pub fn on_bogies(
        mass_kg: f64,
        com_height_m: f64,
        positions_m: &PerWheelset,
        pivot_height_m: f64,
    ) -> Self {
        let [first, second, third, fourth] = *positions_m;
        let between_m = 0.5 * (first + second - third - fourth);
        let body_kg = 0.5 * mass_kg * (com_height_m - pivot_height_m) / between_m;
        let frame_kg = |base_m: f64| 0.5 * mass_kg * pivot_height_m / base_m;
        let (front, rear) = (frame_kg(first - second), frame_kg(third - fourth));
        Self {
            static_load_n: [mass_kg * GRAVITY_M_S2 / MAX_WHEELSETS as f64; MAX_WHEELSETS],
            transfer_kg: [-body_kg - front, -body_kg + front, body_kg - rear, body_kg + rear],
        }
    }

    /// Loads that acceleration does not change, as on a roller rig.
    pub fn fixed(load_n: f64, wheelsets: usize) -> Self {
        let mut static_load_n = [0.0; MAX_WHEELSETS];
        static_load_n[..wheelsets].fill(load_n);
        Self { static_load_n, transfer_kg: [0.0; MAX_WHEELSETS] }
    }

    /// The distribution over the first `W` wheelsets alone.
    pub fn leading<const W: usize>(&self) -> LoadDistribution<W> {
        LoadDistribution {
            static_load_n: std::array::from_fn(|i| self.static_load_n[i]),
            transfer_kg: std::array::from_fn(|i| self.transfer_kg[i]),
        }
    }
}

impl<const W: usize> LoadDistribution<W> {
    /// Load of wheelset `i` at an acceleration by the linear law, N.
    #[inline]
    pub fn load_n(&self, i: usize, acceleration_m_s2: f64) -> f64 {
        self.static_load_n[i] + self.transfer_kg[i] * acceleration_m_s2
    }

    /// Load of each wheelset at an acceleration, N; a wheelset cannot pull on the rail.
    #[inline]
    pub fn loads_n(&self, acceleration_m_s2: f64) -> [f64; W] {
        std::array::from_fn(|i| self.load_n(i, acceleration_m_s2).max(0.0))
    }

    /// Weight that the wheelsets carry, N.
    #[inline]
    pub fn weight_n(&self) -> f64 {
        self.static_load_n.iter().sum()
    }

    /// Mass over which `Σ μ_i F_z,i(0) + F` accelerates the wagon, kg: m less what the loads answer to acceleration.
    #[inline]
    pub fn answering_mass_kg(&self, mass_kg: f64, utilised: &[f64; W]) -> f64 {
        let mut mass = mass_kg;
        for i in 0..W {
            mass -= utilised[i] * self.transfer_kg[i];
        }
        mass
    }

    /// Exact acceleration, m/s², when each wheelset utilises the adhesion `utilised` (signed) and `other_force_n`
    /// (resistance and all else, forward positive) acts besides.
    #[inline]
    pub fn acceleration_m_s2(&self, mass_kg: f64, utilised: &[f64; W], other_force_n: f64) -> f64 {
        let mut force = other_force_n;
        for i in 0..W {
            force += utilised[i] * self.static_load_n[i];
        }
        force / self.answering_mass_kg(mass_kg, utilised)
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
    fn bogies_balance_weight_and_moment_and_load_their_own_leading_wheelset() {
        let (m, h, pivot) = (5e4, 1.7, 0.6);
        let positions = [9.5, 7.0, -7.0, -9.5];
        let loads = LoadDistribution::on_bogies(m, h, &positions, pivot).loads_n(-1.2);
        let weight: f64 = loads.iter().sum();
        let moment: f64 = loads.iter().zip(positions).map(|(f, x)| f * x).sum();
        assert!((weight / (m * GRAVITY_M_S2) - 1.0).abs() < 1e-12);
        assert!((moment / (m * 1.2 * h) - 1.0).abs() < 1e-12, "{moment} instead of {}", m * 1.2 * h);
        assert!(loads[0] > loads[1] && loads[2] > loads[3] && loads[0] > loads[2]);
        // With its pivots on the rail a bogie hands nothing from wheelset to wheelset.
        let level = LoadDistribution::on_bogies(m, h, &positions, 0.0);
        assert_eq!(level.transfer_kg[0], level.transfer_kg[1]);
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
