//! Roughness and the contact that feels it.

use super::{Rolling, from_db};
use std::f64::consts::{FRAC_PI_4, TAU};

/// Half the contact modulus of steel on steel is `E / (4 (1 − ν²))`; this is `E* = E / (2 (1 − ν²))`, Pa.
const CONTACT_MODULUS_PA: f64 = 210e9 / (2.0 * (1.0 - 0.3 * 0.3));
/// Width of a third-octave band over its centre.
const THIRD_OCTAVE: f64 = 0.2316;
/// Wavelength at which the roughness curve bends, m.
const BEND_M: f64 = 0.0315;
/// Wavelength below which a film of water carries part of the roughness, m (chosen).
const FILM_M: f64 = 0.012;
/// What a closed film takes from the finest roughness, dB (chosen; films of a micrometre are as high as that roughness).
const FILM_DB: f64 = 6.0;

/// Roughness of a smooth, well kept rail in third-octave bands of wavelength, dB re 1 µm.
///
/// Limit curve of EN ISO 3095:2013: −5 dB at 31.5 mm, 2 dB more a band towards long wavelengths up to 17.1 dB, 0.6 dB
/// less a band towards short ones.
pub fn smooth_roughness_db(wavelength_m: f64) -> f64 {
    let bands = 10.0 * (wavelength_m / BEND_M).log10();
    if bands > 0.0 { (-5.0 + 2.0 * bands).min(17.1) } else { -5.0 + 0.6 * bands }
}

/// A Hertzian contact of equal curvature in both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Radius of the patch, m.
    pub radius_m: f64,
    /// Stiffness for small changes of load, N/m.
    pub stiffness_n_per_m: f64,
}

impl Patch {
    /// Contact of curvature radius `curvature_m` under `load_n` (Hertz): a³ = 3 F R / (4 E*), k = 2 E* a.
    pub fn hertz(load_n: f64, curvature_m: f64) -> Self {
        let radius_m = (0.75 * load_n.max(1.0) * curvature_m / CONTACT_MODULUS_PA).cbrt();
        Self { radius_m, stiffness_n_per_m: 2.0 * CONTACT_MODULUS_PA * radius_m }
    }

    /// Share of a roughness' power that the patch does not average away: 1 / (1 + π/4 (k a)³), Remington's filter as
    /// Thompson simplifies it.
    pub fn passes(&self, wavelength_m: f64) -> f64 {
        1.0 / (1.0 + FRAC_PI_4 * (TAU / wavelength_m * self.radius_m).powi(3))
    }
}

/// Power density of the roughness under a rolling wheel at a frequency, m²/Hz: a wavelength λ passes with v/λ.
pub(crate) fn roughness_density(rolling: &Rolling, patch: &Patch, frequency_hz: f64) -> f64 {
    let speed_m_s = rolling.speed_m_s.max(1e-3);
    let wavelength_m = speed_m_s / frequency_hz;
    let octaves_short = (BEND_M / wavelength_m).log2().clamp(-5.0, 5.0);
    let level_db =
        smooth_roughness_db(wavelength_m) + rolling.roughness_db + rolling.roughness_tilt_db * octaves_short
            - rolling.wetness * FILM_DB / (1.0 + (wavelength_m / FILM_M).powi(2));
    let band_m2 = 1e-12 * from_db(level_db);
    band_m2 / (THIRD_OCTAVE * frequency_hz) * patch.passes(wavelength_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_roughness_curve_has_the_standards_corners() {
        for (wavelength_m, level_db) in [(0.0315, -5.0), (0.1, 5.0), (1.0, 17.1), (0.00315, -11.0)] {
            let found = smooth_roughness_db(wavelength_m);
            assert!((found - level_db).abs() < 0.1, "{wavelength_m} m: {found} dB");
        }
    }

    #[test]
    fn a_patch_of_a_full_wheel_is_some_millimetres_and_filters_what_is_shorter() {
        let patch = Patch::hertz(50e3, 0.36);
        println!("radius {:.2} mm, stiffness {:.2e} N/m", 1e3 * patch.radius_m, patch.stiffness_n_per_m);
        assert!((4e-3..7e-3).contains(&patch.radius_m));
        assert!((0.9e9..1.5e9).contains(&patch.stiffness_n_per_m), "about 1.2 GN/m in the literature");
        assert!(patch.passes(0.2) > 0.95 && patch.passes(0.005) < 0.01);
    }
}
