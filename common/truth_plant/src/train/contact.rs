//! Creep force of one wheelset: two strips of the contact patch, each saturating by itself.
//!
//! A bristle strip that saturates as `h(x) = x / √(1 + x²)` describes clean steel; a second, ten times softer one the
//! layer of dust and wear between wheel and rail. Weight and softness are set so that the curve lies within 2 % of the
//! full-scale measurements that simpler laws are fitted to; neither form nor constants are those of the models under test.

/// Speed that bounds creepage near standstill, m/s.
const CREEPAGE_FLOOR_M_S: f64 = 0.3;
/// Slip velocity at which half of the fall of friction is reached, m/s.
const HALF_FALL_M_S: f64 = 4.0;

/// The curve of one train; what varies between trains is within ±5 %.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CreepLaw {
    /// Share of the clean strip.
    pub clean_share: f64,
    /// Stiffness of the clean strip over the total.
    pub clean_stiffness: f64,
    /// Stiffness of the layered strip over the total.
    pub layer_stiffness: f64,
    /// Share of friction that is lost at very high slip velocity.
    pub fall: f64,
}

impl Default for CreepLaw {
    fn default() -> Self {
        Self { clean_share: 0.675, clean_stiffness: 1.272, layer_stiffness: 0.10, fall: 0.35 }
    }
}

/// What a wheelset finds at the rail.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contact {
    /// Wheel load, N.
    pub load_n: f64,
    /// Friction at rest.
    pub friction: f64,
    /// Force per creepage at the origin of a curve without layer, N.
    pub stiffness_n: f64,
}

/// `x / √(1 + x²)` and its derivative.
#[inline]
fn bristles(x: f64) -> (f64, f64) {
    let root = (1.0 + x * x).sqrt();
    (x / root, 1.0 / (root * root * root))
}

impl CreepLaw {
    /// Force on the wagon (forward positive, N) and its slope with slip velocity (N s/m, never negative), where
    /// `slip_m_s = r ω − v`.
    #[inline]
    pub(crate) fn force(&self, contact: &Contact, slip_m_s: f64, v_m_s: f64) -> (f64, f64) {
        let reference_m_s = (v_m_s * v_m_s + CREEPAGE_FLOOR_M_S * CREEPAGE_FLOOR_M_S).sqrt();
        let speed = slip_m_s.abs();
        let limit_n =
            (contact.load_n * contact.friction * (1.0 - self.fall * speed / (speed + HALF_FALL_M_S)))
                .max(1.0);
        let strain = contact.stiffness_n * slip_m_s / (reference_m_s * limit_n);
        let (clean, clean_slope) = bristles(self.clean_stiffness * strain);
        let (layer, layer_slope) = bristles(self.layer_stiffness * strain);
        let rest = 1.0 - self.clean_share;
        let slope =
            self.clean_share * self.clean_stiffness * clean_slope + rest * self.layer_stiffness * layer_slope;
        (limit_n * (self.clean_share * clean + rest * layer), contact.stiffness_n / reference_m_s * slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRY: Contact = Contact { load_n: 1e5, friction: 0.3, stiffness_n: 6.5e6 };

    #[test]
    fn the_force_is_odd_bounded_and_has_its_stated_slope() {
        let law = CreepLaw { fall: 0.0, ..CreepLaw::default() };
        for slip in [-3.0, -0.4, -0.02, 0.001, 0.05, 0.7] {
            let (force, slope) = law.force(&DRY, slip, 20.0);
            assert!((force + law.force(&DRY, -slip, 20.0).0).abs() < 1e-9);
            assert!(force.abs() < 0.3e5);
            let ahead = law.force(&DRY, slip + 1e-6, 20.0).0;
            let behind = law.force(&DRY, slip - 1e-6, 20.0).0;
            assert!(((ahead - behind) / 2e-6 / slope - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn friction_falls_with_slip_velocity_after_a_peak_of_some_percent_creepage() {
        let law = CreepLaw::default();
        let force = |creepage: f64| law.force(&DRY, creepage * 20.0, 20.0).0;
        let peak =
            (1..400).map(|k| 1e-3 * f64::from(k)).max_by(|a, b| force(*a).total_cmp(&force(*b))).unwrap();
        assert!((0.01..0.12).contains(&peak), "peak at {peak}");
        assert!(force(0.5) < 0.93 * force(peak), "{} of {}", force(0.5), force(peak));
    }
}
