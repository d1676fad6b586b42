//! Forces along the track that do not come from the wagon itself.

use super::{Effect, EffectSpec, Operating, ParameterSpec, Term};

/// A neighbour in the train pushes and pulls.
pub static COUPLER: EffectSpec = EffectSpec {
    id: "coupler_force",
    term: Term::LongitudinalForce,
    equation: "x'' + 2 zeta w x' + w^2 x = a - a_n, T da_n/dt = a - a_n, F = -M (w^2 x + 2 zeta w x'), w = 2 pi f",
    source: "neighbour of mass M on a spring and damper whose brakes act T later; coupler dynamics of 0.2 to 5 Hz; general knowledge",
    parameters: &[
        ParameterSpec {
            name: "mass_kg",
            unit: "kg",
            lower: 0.0,
            upper: 1e5,
            default: 3e3,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "frequency_hz",
            unit: "Hz",
            lower: 0.05,
            upper: 8.0,
            default: 0.5,
            starts: &[0.15, 1.5, 3.5],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "damping_ratio",
            lower: 0.01,
            upper: 2.0,
            default: 0.15,
            starts: &[],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "neighbour_lag_s",
            unit: "s",
            lower: 0.05,
            upper: 20.0,
            default: 1.5,
            starts: &[],
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &["x, m", "dx/dt, m/s", "a_n, m/s^2"],
    twins: &["grade", "running_resistance"],
    separated_by: "the wagon alone, uncoupled, in the same braking",
};

/// See [`COUPLER`].
#[derive(Debug)]
pub struct Coupler {
    mass_kg: f64,
    angular_rad_s: f64,
    damping_ratio: f64,
    neighbour_lag_s: f64,
}

impl Coupler {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self {
            mass_kg: values[0],
            angular_rad_s: std::f64::consts::TAU * values[1],
            damping_ratio: values[2],
            neighbour_lag_s: values[3],
        })
    }
}

impl Effect for Coupler {
    fn spec(&self) -> &'static EffectSpec {
        &COUPLER
    }

    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        3
    }

    fn start(&self, at: &Operating, hidden: &mut [f64]) {
        hidden[2] = at.acceleration_m_s2;
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        let w = self.angular_rad_s;
        let drive = at.acceleration_m_s2 - hidden[2];
        // Implicit in the oscillator: stable at any frequency.
        let (x, speed) = (hidden[0], hidden[1]);
        let implicit = 1.0 + dt_s * (2.0 * self.damping_ratio * w + dt_s * w * w);
        hidden[1] = (speed + dt_s * (drive - w * w * x)) / implicit;
        hidden[0] = x + dt_s * hidden[1];
        hidden[2] += drive * (1.0 - (-dt_s / self.neighbour_lag_s).exp());
    }

    fn body_force_n(&self, _at: &Operating, hidden: &[f64], force_n: f64) -> f64 {
        let w = self.angular_rad_s;
        force_n - self.mass_kg * (w * w * hidden[0] + 2.0 * self.damping_ratio * w * hidden[1])
    }
}
