//! Effects between brake or motor and wheel.

use super::{Effect, EffectSpec, Observation, Operating, ParameterSpec, Term, Twin};
use crate::{Constants, MAX_WHEELSETS, PerWheelset};

/// The axle twists: discs and gear on one side of it, the wheels on the other, the encoder on either.
pub static TORSION: EffectSpec = EffectSpec {
    id: "axle_torsion",
    term: Term::Drivetrain,
    equation: "J_d (omega' + q'') = t - t_s, J omega' = t + r F - J_d q'', t_s = q / c + 2 zeta sqrt(J_d / c) q', omega_read = omega + q' or omega",
    source: "two masses on a shaft, as for twist modes of 10 to 25 Hz of drivelines and 40 to 90 Hz of axles, 10.3390/vibration4010003",
    parameters: &[
        ParameterSpec {
            name: "compliance_rad_per_knm",
            unit: "rad/kN m",
            lower: 0.0,
            upper: 0.2,
            default: 0.01,
            neutral: Some(0.0),
            starts: &[0.0025, 0.025],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "disc_inertia_kg_m2",
            unit: "kg m\u{b2}",
            lower: 5.0,
            upper: 300.0,
            default: 60.0,
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "damping_ratio",
            lower: 0.002,
            upper: 0.5,
            default: 0.03,
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "encoder_at_wheels",
            lower: 0.0,
            upper: 1.0,
            default: 0.0,
            starts: &[0.0, 1.0],
            discrete: true,
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &[
        "twist and its rate of each wheelset, rad and rad/s",
        "torque that the shaft adds to each, N m",
    ],
    twins: &[Twin::look_alike("wheel_encoder_eccentricity")],
    separated_by: "abrupt torque at two speeds: a resonance keeps its frequency, an encoder's ripple follows the angle",
};

/// See [`TORSION`].
#[derive(Debug)]
pub struct Torsion {
    /// Twist under a torque, rad/(N m).
    compliance: f64,
    disc_inertia_kg_m2: PerWheelset,
    damping_ratio: f64,
    encoder_at_wheels: bool,
}

/// Hidden states of a wheelset.
const STATES: usize = 3;
/// Largest share of a wheelset's moment of inertia that discs and gear can have.
pub const LARGEST_DISC_SHARE: f64 = 0.65;
/// Turn of the oscillation over a sample, rad, beyond which samples cannot follow it and the shaft is a stiff one.
const FASTEST_TURN_RAD: f64 = 1.5;
/// Speed below which a brake that is clamped holds the wheelset and its torque is not known, rad/s.
const STANDSTILL_RAD_S: f64 = 0.1;
/// Pressing force from which a brake is clamped, N: above the noise of a released one.
const CLAMPED_N: f64 = 1e3;
/// Torque that a brake holds for each newton that presses, m: low, 0.2 of friction at a radius of 0.25 m.
const HELD_M: f64 = 0.05;

/// Discs on their shaft.
struct Shaft {
    /// Twist under a torque, rad/(N m).
    compliance: f64,
    inertia_kg_m2: f64,
    damping_ratio: f64,
}

/// A twist and its rate.
type Twist = [f64; 2];

impl Shaft {
    /// Undamped angular frequency while the wheels are held, rad/s.
    fn angular_rad_s(&self) -> f64 {
        (self.compliance * self.inertia_kg_m2).sqrt().recip()
    }

    /// Twist at which a torque on the discs is in balance while the wheels accelerate evenly.
    fn rest(&self, torque_nm: f64, acceleration_rad_s2: f64) -> f64 {
        self.compliance * (torque_nm - self.inertia_kg_m2 * acceleration_rad_s2)
    }

    /// The twist after `dt_s` at a twist of rest: exact.
    fn after(&self, [twist, rate]: Twist, rest: f64, dt_s: f64) -> Twist {
        let (w, zeta) = (self.angular_rad_s(), self.damping_ratio);
        let damped = w * (1.0 - zeta * zeta).sqrt();
        let decay = (-zeta * w * dt_s).exp();
        let (sin, cos) = (damped * dt_s).sin_cos();
        let from_rest = twist - rest;
        [
            rest + decay * (from_rest * cos + (rate + zeta * w * from_rest) / damped * sin),
            decay * (rate * cos - (zeta * w * rate + w * w * from_rest) / damped * sin),
        ]
    }
}

impl Torsion {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self {
            compliance: 1e-3 * values[0],
            disc_inertia_kg_m2: [values[1]; MAX_WHEELSETS],
            damping_ratio: values[2],
            encoder_at_wheels: values[3] > 0.5,
        })
    }

    fn shaft(&self, wheelset: usize) -> Shaft {
        Shaft {
            compliance: self.compliance,
            inertia_kg_m2: self.disc_inertia_kg_m2[wheelset],
            damping_ratio: self.damping_ratio,
        }
    }

    /// How much faster the encoder turns than the wheels, rad/s.
    fn ahead_rad_s(&self, hidden: &[f64], wheelset: usize) -> f64 {
        if self.encoder_at_wheels { 0.0 } else { hidden[STATES * wheelset + 1] }
    }
}

impl Effect for Torsion {
    fn spec(&self) -> &'static EffectSpec {
        &TORSION
    }

    fn largest(&self, parameter: &str, constants: &Constants) -> Option<f64> {
        let wheelsets = &constants.inertia_kg_m2[..constants.wheelsets];
        let lightest = wheelsets.iter().copied().fold(f64::INFINITY, f64::min);
        (parameter == "disc_inertia_kg_m2").then_some(LARGEST_DISC_SHARE * lightest)
    }

    fn join(&mut self, constants: &Constants) {
        for (discs, whole) in self.disc_inertia_kg_m2.iter_mut().zip(constants.inertia_kg_m2) {
            *discs = discs.min(LARGEST_DISC_SHARE * whole);
        }
    }

    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        STATES * MAX_WHEELSETS
    }

    fn start(&self, at: &Operating, hidden: &mut [f64]) {
        for (state, torque_nm) in hidden.chunks_exact_mut(STATES).zip(at.drive_torque_nm) {
            state[0] = self.compliance * torque_nm;
        }
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        if self.compliance <= 0.0 {
            return;
        }
        for (i, state) in hidden.chunks_exact_mut(STATES).enumerate() {
            let (omega, acceleration) = (at.wheel_speed_rad_s[i], at.wheel_acceleration_rad_s2[i]);
            let stands = omega < STANDSTILL_RAD_S;
            let pressed_n = at.pressing_force_n[i];
            if stands && pressed_n > CLAMPED_N && at.drive_torque_nm[i].abs() < HELD_M * pressed_n {
                // The pads hold the discs: the shaft stays twisted as it is, and nothing swings.
                state[1..].fill(0.0);
                continue;
            }
            let brake_nm = if stands { 0.0 } else { at.brake_power_w[i] / omega };
            let shaft = self.shaft(i);
            let rest = shaft.rest(at.drive_torque_nm[i] - brake_nm, acceleration);
            if shaft.angular_rad_s() * dt_s > FASTEST_TURN_RAD {
                state.copy_from_slice(&[rest, 0.0, 0.0]);
                continue;
            }
            let now = shaft.after([state[0], state[1]], rest, dt_s);
            // The wheelset is moved as one: over the next sample, what speeds the discs up beside it is missing from its torque.
            let next = shaft.after(now, rest, dt_s);
            let added_nm = -shaft.inertia_kg_m2 * (next[1] - now[1]) / dt_s;
            state.copy_from_slice(&[now[0], now[1], added_nm]);
        }
    }

    fn drive_torque_nm(&self, wheelset: usize, _at: &Operating, hidden: &[f64], torque_nm: f64) -> f64 {
        torque_nm + hidden[STATES * wheelset + 2]
    }

    fn observe(&self, _at: &Operating, hidden: &[f64], reading: &mut Observation) {
        for (i, speed) in reading.wheel_speed_rad_s.iter_mut().enumerate() {
            *speed += self.ahead_rad_s(hidden, i);
        }
    }

    fn correct(&self, _at: &Operating, hidden: &[f64], state: &mut Observation) {
        for (i, speed) in state.wheel_speed_rad_s.iter_mut().enumerate() {
            *speed -= self.ahead_rad_s(hidden, i);
        }
    }
}
