//! Mobilities: velocity by force, at the contact, of wheel, track and contact spring.

use super::contact::Patch;
use super::rig::{Mode, Rig, Support};
use realfft::num_complex::Complex;
use std::f64::consts::TAU;

type C = Complex<f64>;

/// Loss factor of the contact spring, which stands for bearings, frame and axle as well; without it a stiff wheel on a
/// roller would ring on its contact like a bell (chosen).
const CONTACT_LOSS_FACTOR: f64 = 0.2;

/// The three mobilities in series at one frequency, m/(s N).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mobilities {
    pub support: C,
    pub sum: C,
    /// Σ |Y_n|² of the modes' own mobilities, each with its share of radiation.
    pub wheel_radiation: f64,
    /// The same for a force along the tread, which drives axial modes.
    pub creep_radiation: f64,
}

impl Mobilities {
    pub fn of(rig: &Rig, patch: &Patch, wetness: f64, frequency_hz: f64) -> Self {
        let omega = TAU * frequency_hz;
        let (mut wheel, mut wheel_radiation, mut creep_radiation) =
            (free_mass(rig.wheel_mass_kg, omega), 0.0, 0.0);
        for mode in &rig.modes {
            let mobility = modal(mode, rig.loss_factor(mode, wetness), omega);
            wheel += mobility * mode.radial_share;
            wheel_radiation += mobility.norm_sqr() * mode.radial_share;
            creep_radiation += mobility.norm_sqr() * (1.0 - mode.radial_share);
        }
        // The rigid wheel radiates as well, ever less the higher the frequency.
        wheel_radiation += free_mass(rig.wheel_mass_kg, omega).norm_sqr();
        let support = match &rig.support {
            Support::Track { bending_n_m2, mass_kg_m, stiffness_n_m2, loss_factor } => {
                beam(*bending_n_m2, *mass_kg_m, *stiffness_n_m2, *loss_factor, omega)
            }
            Support::Roller { mass_kg, modes } => {
                let start = free_mass(*mass_kg, omega);
                modes.iter().fold(start, |sum, mode| sum + modal(mode, mode.loss_factor, omega))
            }
        };
        let contact = C::new(0.0, omega) / (C::new(1.0, CONTACT_LOSS_FACTOR) * patch.stiffness_n_per_m);
        Self { support, sum: wheel + support + contact, wheel_radiation, creep_radiation }
    }
}

fn free_mass(mass_kg: f64, omega: f64) -> C {
    C::new(0.0, -1.0 / (omega * mass_kg))
}

/// jω / (m (ω_n² (1 + jη) − ω²)).
fn modal(mode: &Mode, loss_factor: f64, omega: f64) -> C {
    let omega_n2 = (TAU * mode.frequency_hz).powi(2);
    C::new(0.0, omega) / (C::new(omega_n2 - omega * omega, omega_n2 * loss_factor) * mode.mass_kg)
}

/// Infinite beam on an elastic foundation: receptance 1 / (2√2 EI γ³) with γ⁴ = (s (1 + jη) − μ ω²) / EI.
fn beam(bending: f64, mass_kg_m: f64, stiffness: f64, loss_factor: f64, omega: f64) -> C {
    let gamma4 = C::new(stiffness - mass_kg_m * omega * omega, stiffness * loss_factor) / bending;
    let gamma3 = gamma4.powf(0.75);
    C::new(0.0, omega) / (gamma3 * (8_f64.sqrt() * bending))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beam_is_a_spring_below_and_a_free_beam_above_its_resonance() {
        let (bending, mass, stiffness) = (6.4e6, 60.0, 1e8);
        let omega = TAU * 5.0;
        let still = beam(bending, mass, stiffness, 0.2, omega) / C::new(0.0, omega);
        // Deflection of a beam on a foundation under 1 N: β / (2 s) with β⁴ = s / (4 EI).
        let beta = (stiffness / (4.0 * bending)).powf(0.25);
        let expected = beta / (2.0 * stiffness);
        assert!((still.norm() / expected - 1.0).abs() < 0.05, "{} m/N against {expected}", still.norm());
        let above = beam(bending, mass, stiffness, 0.2, TAU * 3000.0);
        assert!((above.arg().to_degrees() + 45.0).abs() < 3.0, "{}°", above.arg().to_degrees());
    }
}
