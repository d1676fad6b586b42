//! Adhesion available over vehicle speed after Curtius and Kniffler.

/// Dry-rail adhesion of a locomotive at vehicle speed `v_m_s`: `7.5 / (3.6 v + 44) + 0.161`, dimensionless.
///
/// Source: Curtius & Kniffler, Elektrische Bahnen 20 (1944). Measured up to 160 km/h.
pub fn curtius_kniffler(v_m_s: f64) -> f64 {
    7.5 / (3.6 * v_m_s.abs() + 44.0) + 0.161
}

#[cfg(test)]
mod tests {
    use super::curtius_kniffler;

    #[test]
    fn published_points() {
        assert!((curtius_kniffler(0.0) - 0.3315).abs() < 1e-4);
        assert!((curtius_kniffler(100.0 / 3.6) - 0.2131).abs() < 1e-4);
    }
}
