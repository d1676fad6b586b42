//! Effects between brake or motor and wheel.

use super::{Effect, EffectSpec, Observation, Operating, ParameterSpec, Term, Twin};
use crate::MAX_WHEELSETS;

/// The axle twists.
pub static TORSION: EffectSpec = EffectSpec {
    id: "axle_torsion",
    term: Term::Drivetrain,
    equation: "q'' + 2 zeta w q' + w^2 q = g T / 1 t m^2, omega_read = omega + q', w = 2 pi f",
    source: "twist modes of 10 to 25 Hz of drivelines and 40 to 90 Hz of axles, 10.3390/vibration4010003",
    parameters: &[
        ParameterSpec {
            name: "gain",
            lower: 0.0,
            upper: 200.0,
            default: 1.0,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "frequency_hz",
            unit: "Hz",
            lower: 1.0,
            upper: 45.0,
            default: 12.0,
            starts: &[4.0, 7.0, 20.0, 32.0],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "damping_ratio",
            lower: 0.002,
            upper: 0.5,
            default: 0.03,
            starts: &[],
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &["twist and its rate of each wheelset, rad and rad/s"],
    twins: &[Twin::look_alike("wheel_encoder_eccentricity")],
    separated_by: "abrupt torque at two speeds: a resonance keeps its frequency, an encoder's ripple follows the angle",
};

/// See [`TORSION`].
#[derive(Debug)]
pub struct Torsion {
    gain: f64,
    angular_rad_s: f64,
    damping_ratio: f64,
}

/// Torque over this inertia drives the twist, kg m².
const REFERENCE_INERTIA_KG_M2: f64 = 1e3;

impl Torsion {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self {
            gain: values[0],
            angular_rad_s: std::f64::consts::TAU * values[1],
            damping_ratio: values[2],
        })
    }
}

impl Effect for Torsion {
    fn spec(&self) -> &'static EffectSpec {
        &TORSION
    }

    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        2 * MAX_WHEELSETS
    }

    fn start(&self, at: &Operating, hidden: &mut [f64]) {
        let w = self.angular_rad_s;
        for i in 0..MAX_WHEELSETS {
            hidden[2 * i] = self.gain * at.drive_torque_nm[i] / REFERENCE_INERTIA_KG_M2 / (w * w);
        }
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        // Exact for a torque that is constant over the sample.
        let (w, zeta) = (self.angular_rad_s, self.damping_ratio);
        let damped = w * (1.0 - zeta * zeta).sqrt();
        let decay = (-zeta * w * dt_s).exp();
        let (sin, cos) = (damped * dt_s).sin_cos();
        for (i, pair) in hidden.chunks_exact_mut(2).enumerate() {
            let omega = at.wheel_speed_rad_s[i];
            let brake = if omega > 0.1 { at.brake_power_w[i] / omega } else { 0.0 };
            let rest = self.gain * (at.drive_torque_nm[i] - brake) / REFERENCE_INERTIA_KG_M2 / (w * w);
            let (q, rate) = (pair[0] - rest, pair[1]);
            pair[0] = rest + decay * (q * cos + (rate + zeta * w * q) / damped * sin);
            pair[1] = decay * (rate * cos - (zeta * w * rate + w * w * q) / damped * sin);
        }
    }

    fn observe(&self, _at: &Operating, hidden: &[f64], reading: &mut Observation) {
        for (i, speed) in reading.wheel_speed_rad_s.iter_mut().enumerate() {
            *speed += hidden[2 * i + 1];
        }
    }
}
