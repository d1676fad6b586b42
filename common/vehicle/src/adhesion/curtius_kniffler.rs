//! Adhesion available over vehicle speed after Curtius and Kniffler.
//!
//! ```text
//! μ(v) = 7.5 / (3.6 v + 44) + 0.161            v in m/s, μ dimensionless
//!      = μ(0) [ α + (1 − α) / (1 + c v) ]      α = 0.486, c = 0.0818 s/m
//! ```
//!
//! Source: Curtius & Kniffler, Elektrische Bahnen 20 (1944): dry rail, a locomotive, up to 160 km/h. With speed the
//! adhesion falls towards its asymptote `α μ(0)` = 0.161, not towards zero. The second form is the law's shape alone, for
//! rails of another level.

/// Adhesion that the law tends to at high speed.
const ASYMPTOTE: f64 = 0.161;
/// What the law adds to it at standstill.
const FALL: f64 = 7.5 / 44.0;

/// α: the asymptote as a share of the adhesion at standstill.
pub const ASYMPTOTE_SHARE: f64 = ASYMPTOTE / (ASYMPTOTE + FALL);
/// c: decay over speed, s/m.
pub const SPEED_DECAY_S_PER_M: f64 = 3.6 / 44.0;

/// Adhesion at a vehicle speed as a share of that at standstill: `α + (1 − α) / (1 + c |v|)`.
#[inline]
pub fn share_of_standstill(v_m_s: f64, decay_s_per_m: f64, asymptote_share: f64) -> f64 {
    asymptote_share + (1.0 - asymptote_share) / (1.0 + decay_s_per_m * v_m_s.abs())
}

/// Dry-rail adhesion of a locomotive at vehicle speed `v_m_s`, dimensionless.
pub fn curtius_kniffler(v_m_s: f64) -> f64 {
    (ASYMPTOTE + FALL) * share_of_standstill(v_m_s, SPEED_DECAY_S_PER_M, ASYMPTOTE_SHARE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_points() {
        assert!((curtius_kniffler(0.0) - 0.3315).abs() < 1e-4);
        assert!((curtius_kniffler(100.0 / 3.6) - 0.2131).abs() < 1e-4);
    }

    #[test]
    fn the_shape_is_the_published_law_and_keeps_its_asymptote() {
        for v in [0.0, 3.0, 15.0, 44.4] {
            assert!((curtius_kniffler(v) - (7.5 / (3.6 * v + 44.0) + 0.161)).abs() < 1e-12);
        }
        assert!((curtius_kniffler(1e7) - 0.161).abs() < 1e-6);
    }
}
