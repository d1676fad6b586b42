//! One step of the rig as the filter sees it.

use nalgebra::SVector;
use railgrip_vehicle::adhesion::{creep_force_at, initial_creep_slope_n};
use railgrip_vehicle::traction_rig::{MotorState, TractionRig};

/// Number of states.
pub const STATES: usize = 13;

/// State vector.
pub type State = SVector<f64, STATES>;

/// Place of each state, in the order of (5-3).
pub mod index {
    /// Stator current, α and the one after it β, A.
    pub const CURRENT: usize = 0;
    /// Rotor flux, α and the one after it β, Wb.
    pub const FLUX: usize = 2;
    /// Speed of the motor, rad/s.
    pub const MOTOR_SPEED: usize = 4;
    /// Stator voltage, α and the one after it β, V.
    pub const VOLTAGE: usize = 5;
    /// Creepage γ.
    pub const CREEPAGE: usize = 7;
    /// Creep force of one wheel F_γ, N.
    pub const CREEP_FORCE: usize = 8;
    /// Speed of the roller, rad/s.
    pub const ROLLER_SPEED: usize = 9;
    /// Traction coefficient μ at the present slip velocity.
    pub const FRICTION: usize = 10;
    /// Natural logarithm of the friction coefficient μ0.
    pub const LN_ADHESION_PEAK: usize = 11;
    /// Generator current, A.
    pub const GENERATOR_CURRENT: usize = 12;
}

/// One sigma of ln μ0 without any evidence: from oil to dry steel.
pub const PRIOR_LN_SIGMA: f64 = 0.9;

/// Noise of model and sensors, one sigma. Model values are those of one second for states that move by
/// themselves (they grow with √t) and of one sample for γ, F_γ, μ and I_dc, which follow from the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TractionNoise {
    /// Of each state.
    pub model: State,
    /// Of each measured value, in the order of (5-4).
    pub sensors: SVector<f64, 7>,
    /// True if all values of `model` are those of one sample, as the paper's are.
    pub per_sample: bool,
}

impl Default for TractionNoise {
    /// Physical: what voltage ripple, belts and bearings leave unexplained; sensors as (5-4) lists them, read as
    /// standard deviations.
    fn default() -> Self {
        let model = [0.1, 0.1, 1e-3, 1e-3, 3e-3, 0.5, 0.5, 1e-6, 0.05, 3e-4, 1e-5, 0.15, 2e-3];
        Self { model: State::from(model), sensors: SVector::repeat(1e-2), per_sample: false }
    }
}

impl TractionNoise {
    /// w_k and v_k as the paper prints them, read as standard deviations of one sample; the value missing for the
    /// thirteenth state is put at μ0 and made that of μ.
    pub fn zhao2014() -> Self {
        let model = [1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-1, 1e-1, 1e-1, 1e-1, 1e-1, 1e-3];
        Self { model: State::from(model), sensors: SVector::repeat(1e-2), per_sample: true }
    }

    /// One sigma of each state over a step of `dt_s`.
    pub fn over(&self, dt_s: f64) -> State {
        let mut sigma = self.model;
        if !self.per_sample {
            let root = dt_s.sqrt();
            for moving in [0, 1, 2, 3, 4, 5, 6, index::ROLLER_SPEED, index::LN_ADHESION_PEAK] {
                sigma[moving] *= root;
            }
        }
        sigma
    }
}

/// The rig's equations as a transition of the 13 states.
#[derive(Clone, Debug)]
pub struct TractionModel {
    /// Motor, gear, contact law and generator; the friction coefficient is a state.
    pub rig: TractionRig,
    /// Time in which μ0 returns to `prior_adhesion_peak` without evidence, s; infinite: random walk.
    pub friction_memory_s: f64,
    /// μ0 as known beforehand, give or take a factor of e^[`PRIOR_LN_SIGMA`].
    pub prior_adhesion_peak: f64,
    /// True: the voltage vector turns with the flux; false: it keeps still between samples, as in the paper.
    pub voltage_turns: bool,
}

/// ln μ0 that the contact law is evaluated for: μ0 of 0.002 to 2; outside there is no surface.
const LN_ADHESION_RANGE: (f64, f64) = (-6.2, 0.7);

/// μ0 of a state.
#[inline]
pub fn adhesion_peak(x: &State) -> f64 {
    x[index::LN_ADHESION_PEAK].clamp(LN_ADHESION_RANGE.0, LN_ADHESION_RANGE.1).exp()
}

impl TractionModel {
    /// The model of a rig with the filter's default assumptions.
    pub fn new(rig: TractionRig) -> Self {
        Self { rig, friction_memory_s: 60.0, prior_adhesion_peak: 0.12, voltage_turns: true }
    }

    /// The state after `dt_s`.
    #[inline]
    pub fn step(&self, x: &State, dt_s: f64) -> State {
        let motor = MotorState {
            current_a: [x[index::CURRENT], x[index::CURRENT + 1]],
            flux_wb: [x[index::FLUX], x[index::FLUX + 1]],
        };
        let motor_speed = x[index::MOTOR_SPEED];
        let voltages = self.voltages(&motor, motor_speed, [x[index::VOLTAGE], x[index::VOLTAGE + 1]], dt_s);
        let next = self.rig.motor.step(&motor, motor_speed, voltages, dt_s);
        let torque = 0.5 * (self.rig.motor.torque_nm(&motor) + self.rig.motor.torque_nm(&next));
        let peak = adhesion_peak(x);
        let speeds = [motor_speed, x[index::ROLLER_SPEED]];
        let [motor_speed, roller_speed] = self.speeds(speeds, torque, peak, dt_s);
        let remembered = (-dt_s / self.friction_memory_s).exp();
        let prior = self.prior_adhesion_peak.ln();
        let mut out = *x;
        out[index::CURRENT] = next.current_a[0];
        out[index::CURRENT + 1] = next.current_a[1];
        out[index::FLUX] = next.flux_wb[0];
        out[index::FLUX + 1] = next.flux_wb[1];
        out[index::MOTOR_SPEED] = motor_speed;
        out[index::VOLTAGE] = voltages[2][0];
        out[index::VOLTAGE + 1] = voltages[2][1];
        out[index::ROLLER_SPEED] = roller_speed;
        out[index::LN_ADHESION_PEAK] = prior + (x[index::LN_ADHESION_PEAK] - prior) * remembered;
        self.follow(&mut out);
        out
    }

    /// Sets γ, F_γ, μ and I_dc to what speeds and μ0 make them.
    #[inline]
    pub fn follow(&self, x: &mut State) {
        let contact = self.rig.wheel_contact(x[index::MOTOR_SPEED], x[index::ROLLER_SPEED], adhesion_peak(x));
        x[index::CREEPAGE] = contact.creepage;
        x[index::CREEP_FORCE] = contact.force.force_n;
        x[index::FRICTION] = contact.friction;
        x[index::GENERATOR_CURRENT] = self.rig.generator().current_a(x[index::ROLLER_SPEED]);
    }

    /// How far the creep force at this creepage stays behind the straight line of small creepages, relative: 0 on the
    /// line, towards 1 in full slip. On the line the force depends on creep stiffness alone, so this bend is all that
    /// speaks about μ0.
    pub fn bend(&self, creepage: f64, adhesion_peak: f64) -> f64 {
        let contact = &self.rig.parameters.contact;
        let load = self.rig.parameters.drivetrain.normal_load_n;
        let force = creep_force_at(contact, creepage.abs(), 1.0, load, adhesion_peak).force_n;
        let line = initial_creep_slope_n(contact) * creepage.abs();
        if line > 0.0 { 1.0 - force / line } else { 0.0 }
    }

    /// Rotor flux in steady state from one sample of current and voltage, neglecting slip: a place to start from.
    pub fn flux_guess_wb(
        &self,
        current_a: [f64; 2],
        voltage_v: [f64; 2],
        motor_speed_rad_s: f64,
    ) -> [f64; 2] {
        let p = self.rig.motor.parameters();
        let frequency = (p.pole_pairs * motor_speed_rad_s).abs().max(1.0);
        let coupling = p.mutual_inductance_h / p.rotor_inductance_h;
        let transient = p.stator_inductance_h - p.mutual_inductance_h * coupling;
        let emf = [
            voltage_v[0] - p.stator_resistance_ohm * current_a[0],
            voltage_v[1] - p.stator_resistance_ohm * current_a[1],
        ];
        // u = R i + jω (σL i + (L_m/L_r) ψ); dividing by j turns the vector back by a right angle.
        let gain = 1.0 / (coupling * frequency);
        [
            emf[1] * gain - transient / coupling * current_a[0],
            -emf[0] * gain - transient / coupling * current_a[1],
        ]
    }

    /// Voltage at start, middle and end of a step.
    #[inline]
    fn voltages(
        &self,
        motor: &MotorState,
        motor_speed_rad_s: f64,
        start_v: [f64; 2],
        dt_s: f64,
    ) -> [[f64; 2]; 3] {
        if !self.voltage_turns {
            return [start_v; 3];
        }
        let frequency = self.rig.motor.parameters().pole_pairs * motor_speed_rad_s
            + self.rig.motor.slip_frequency_rad_s(motor);
        let (sin, cos) = (0.5 * frequency * dt_s).sin_cos();
        let turn = |[a, b]: [f64; 2]| [cos * a - sin * b, sin * a + cos * b];
        let middle = turn(start_v);
        [start_v, middle, turn(middle)]
    }

    /// Both speeds after a step: the L-stable SDIRK method of order two with one Newton step a stage (linearly
    /// implicit), hence stable however stiff the contact is.
    #[inline]
    fn speeds(&self, start: [f64; 2], torque_nm: f64, peak: f64, dt_s: f64) -> [f64; 2] {
        const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
        const WEIGHT: f64 = (1.0 - GAMMA) / GAMMA;
        let first = self.stage(start, start, torque_nm, peak, GAMMA * dt_s);
        let base = [start[0] + WEIGHT * (first[0] - start[0]), start[1] + WEIGHT * (first[1] - start[1])];
        self.stage(base, first, torque_nm, peak, GAMMA * dt_s)
    }

    /// One Newton step from `guess` towards `u = base + stage_s · f(u)`.
    #[inline]
    fn stage(&self, base: [f64; 2], guess: [f64; 2], torque_nm: f64, peak: f64, stage_s: f64) -> [f64; 2] {
        let drivetrain = &self.rig.parameters.drivetrain;
        let (rim, radius) = (drivetrain.rim_per_motor_m(), drivetrain.roller_radius_m);
        let (motor_gain, roller_gain) =
            (stage_s / drivetrain.equivalent_inertia_kg_m2(), stage_s / drivetrain.roller_inertia_kg_m2);
        let damping = 1.0 + roller_gain * self.rig.generator().load_coefficient_nm_s();
        let contact = self.rig.wheel_contact(guess[0], guess[1], peak).force;
        let guess_slip = rim * guess[0] - radius * guess[1];
        // Both speeds are linear in the creep force, and the force is taken as linear in the slip velocity.
        let (motor_free, roller_free) = (base[0] + motor_gain * torque_nm, base[1] / damping);
        let (motor_per_n, roller_per_n) = (2.0 * rim * motor_gain, 2.0 * radius * roller_gain / damping);
        let compliance = rim * motor_per_n + radius * roller_per_n;
        let slip_free = rim * motor_free - radius * roller_free;
        let excess = slip_free - guess_slip - compliance * contact.force_n;
        let change = excess / (1.0 + compliance * contact.slope_n_s_per_m).max(0.2);
        let force = contact.force_n + contact.slope_n_s_per_m * change;
        [motor_free - motor_per_n * force, roller_free + roller_per_n * force]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_vehicle::traction_rig::{Drive, DriveParameters, RigParameters, Surface};

    #[test]
    fn the_filters_step_follows_the_rigs_own_integrator() {
        for (surface, load_ohm) in [(Surface::Base, 1.0), (Surface::Base, 0.0), (Surface::Water, 1.0)] {
            let rig = TractionRig::new(RigParameters::new(surface, load_ohm));
            let mut drive = Drive::new(DriveParameters::default(), &rig.motor);
            let mut state = drive.fluxed_state(&rig, 20.0);
            let model = TractionModel { friction_memory_s: f64::INFINITY, ..TractionModel::new(rig.clone()) };
            let mut worst = (0.0f64, 0.0f64, 0.0f64);
            let mut last_voltage = [0.0; 2];
            for k in 0..4000 {
                let mut x = State::zeros();
                let before = state;
                let command = if k < 1000 { 20.0 } else { 30.0 };
                for inner in 0..10 {
                    let voltage = drive.step(&state, command, 1e-4);
                    if inner == 0 {
                        x[index::VOLTAGE] = 0.5 * (voltage[0] + last_voltage[0]);
                        x[index::VOLTAGE + 1] = 0.5 * (voltage[1] + last_voltage[1]);
                    }
                    last_voltage = voltage;
                    state = rig.step(&state, voltage, surface.adhesion_peak(), 1e-4);
                }
                x[0] = before.motor.current_a[0];
                x[1] = before.motor.current_a[1];
                x[2] = before.motor.flux_wb[0];
                x[3] = before.motor.flux_wb[1];
                x[index::MOTOR_SPEED] = before.motor_speed_rad_s;
                x[index::ROLLER_SPEED] = before.roller_speed_rad_s;
                x[index::LN_ADHESION_PEAK] = surface.adhesion_peak().ln();
                model.follow(&mut x);
                let next = model.step(&x, 1e-3);
                if k > 100 {
                    worst.0 = worst.0.max((next[0] - state.motor.current_a[0]).abs());
                    worst.1 = worst.1.max((next[index::MOTOR_SPEED] - state.motor_speed_rad_s).abs());
                    worst.2 = worst.2.max((next[index::ROLLER_SPEED] - state.roller_speed_rad_s).abs());
                }
            }
            println!(
                "{} {load_ohm} Ω: worst one-step error: current {:.1e} A, motor {:.1e} rad/s, roller {:.1e} rad/s",
                surface.name(),
                worst.0,
                worst.1,
                worst.2
            );
            assert!(worst.0 < 0.1 && worst.1 < 2e-2 && worst.2 < 2e-3);
        }
    }
}
