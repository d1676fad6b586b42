//! The rig as one machine: motor, contact and rollers, and the integrator that copes with their different speeds.
//!
//! The contact is stiff (some 2·10⁴ 1/s while rolling), the motor is not (some 10² 1/s). A step therefore integrates
//! the motor explicitly, then the mechanics with the L-stable SDIRK method of order two (Alexander 1977) under
//! the mean torque of the step; each stage is one scalar equation in the slip velocity, solved by safeguarded Newton.

use super::{Generator, Motor, MotorState, RigParameters};
use crate::Contact;
use crate::adhesion::{ContactForce, creep_force_at, friction};

/// Diagonal coefficient of the SDIRK method.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// Speed that creepage is referred to at least, m/s.
const SPEED_FLOOR_M_S: f64 = 0.05;

/// State of the rig.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigState {
    /// Currents and fluxes.
    pub motor: MotorState,
    /// ω_motor, rad/s.
    pub motor_speed_rad_s: f64,
    /// ω_roller, rad/s.
    pub roller_speed_rad_s: f64,
}

/// What happens between one wheel and its roller.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelContact {
    /// Creepage γ, positive in traction.
    pub creepage: f64,
    /// Slip velocity γ V, m/s.
    pub slip_velocity_m_s: f64,
    /// Traction coefficient μ at this slip velocity (3-11).
    pub friction: f64,
    /// Creep force F_γ, N, and its slope over slip velocity.
    pub force: ContactForce,
}

/// The rig.
#[derive(Clone, Debug)]
pub struct TractionRig {
    /// Motor.
    pub motor: Motor,
    /// Constants of the rest.
    pub parameters: RigParameters,
}

impl TractionRig {
    /// The rig with these constants.
    pub fn new(parameters: RigParameters) -> Self {
        Self { motor: Motor::new(parameters.motor), parameters }
    }

    /// Contact law of one wheel.
    pub fn contact(&self) -> &Contact {
        &self.parameters.contact
    }

    /// The generator with its load.
    pub fn generator(&self) -> &Generator {
        &self.parameters.generator
    }

    /// Slip velocity of the wheels on the rollers and the mean of both speeds V (3-12), m/s.
    #[inline]
    pub fn speeds_m_s(&self, motor_speed_rad_s: f64, roller_speed_rad_s: f64) -> (f64, f64) {
        let drivetrain = &self.parameters.drivetrain;
        let rim = drivetrain.rim_per_motor_m() * motor_speed_rad_s;
        let roller = drivetrain.roller_radius_m * roller_speed_rad_s;
        (rim - roller, (0.5 * (rim + roller)).abs().max(SPEED_FLOOR_M_S))
    }

    /// Contact of one wheel at these speeds, with friction coefficient `adhesion_peak` = μ0: (3-9) to (3-12).
    #[inline]
    pub fn wheel_contact(
        &self,
        motor_speed_rad_s: f64,
        roller_speed_rad_s: f64,
        adhesion_peak: f64,
    ) -> WheelContact {
        let (slip_velocity_m_s, speed) = self.speeds_m_s(motor_speed_rad_s, roller_speed_rad_s);
        let load = self.parameters.drivetrain.normal_load_n;
        WheelContact {
            creepage: slip_velocity_m_s / speed,
            slip_velocity_m_s,
            friction: friction(&self.parameters.contact, adhesion_peak, slip_velocity_m_s.abs()).0,
            force: creep_force_at(&self.parameters.contact, slip_velocity_m_s, speed, load, adhesion_peak),
        }
    }

    /// ω̇_motor and ω̇_roller, rad/s², (3-1) and (3-3), under an electric torque.
    #[inline]
    pub fn accelerations_rad_s2(
        &self,
        torque_nm: f64,
        creep_force_n: f64,
        roller_speed_rad_s: f64,
    ) -> [f64; 2] {
        let drivetrain = &self.parameters.drivetrain;
        let load = self.parameters.generator.load_coefficient_nm_s() * roller_speed_rad_s;
        // Two wheels a wheelset; the gear divides their torque by i on its way to the motor.
        [
            (torque_nm - 2.0 * drivetrain.rim_per_motor_m() * creep_force_n)
                / drivetrain.equivalent_inertia_kg_m2(),
            (2.0 * drivetrain.roller_radius_m * creep_force_n - load) / drivetrain.roller_inertia_kg_m2,
        ]
    }

    /// State after `dt_s` under a constant stator voltage.
    pub fn step(&self, state: &RigState, voltage_v: [f64; 2], adhesion_peak: f64, dt_s: f64) -> RigState {
        // The motor turns at the speed of the middle of the step, foreseen from the mechanics at its start.
        let start_torque = self.motor.torque_nm(&state.motor);
        let start = [state.motor_speed_rad_s, state.roller_speed_rad_s];
        let middle = self.solve_stage(start, start_torque, adhesion_peak, 0.5 * dt_s)[0];
        let motor = self.motor.step(&state.motor, middle, [voltage_v; 3], dt_s);
        let torque = 0.5 * (start_torque + self.motor.torque_nm(&motor));
        let first = self.solve_stage(start, torque, adhesion_peak, GAMMA * dt_s);
        let weight = (1.0 - GAMMA) / GAMMA;
        let base = [start[0] + weight * (first[0] - start[0]), start[1] + weight * (first[1] - start[1])];
        let [motor_speed_rad_s, roller_speed_rad_s] =
            self.solve_stage(base, torque, adhesion_peak, GAMMA * dt_s);
        RigState { motor, motor_speed_rad_s, roller_speed_rad_s }
    }

    /// Solves `u = base + stage_s · f(u)` for the two speeds.
    fn solve_stage(&self, base: [f64; 2], torque_nm: f64, adhesion_peak: f64, stage_s: f64) -> [f64; 2] {
        let drivetrain = &self.parameters.drivetrain;
        let load_coefficient = self.parameters.generator.load_coefficient_nm_s();
        let rim = drivetrain.rim_per_motor_m();
        let roller_damping = 1.0 + stage_s * load_coefficient / drivetrain.roller_inertia_kg_m2;
        // Both speeds are linear in the creep force.
        let motor_per_n = -2.0 * rim * stage_s / drivetrain.equivalent_inertia_kg_m2();
        let roller_per_n =
            2.0 * drivetrain.roller_radius_m * stage_s / (drivetrain.roller_inertia_kg_m2 * roller_damping);
        let motor_free = base[0] + stage_s * torque_nm / drivetrain.equivalent_inertia_kg_m2();
        let roller_free = base[1] / roller_damping;
        let at = |force: f64| [motor_free + motor_per_n * force, roller_free + roller_per_n * force];
        let compliance = drivetrain.roller_radius_m * roller_per_n - rim * motor_per_n;
        let slip_free = rim * motor_free - drivetrain.roller_radius_m * roller_free;
        let reach = 1.01 * compliance * drivetrain.normal_load_n * adhesion_peak.max(0.0);
        let (mut low, mut high) = (slip_free - reach, slip_free + reach);
        let mut slip = (rim * base[0] - drivetrain.roller_radius_m * base[1]).clamp(low, high);
        let mut speeds = base;
        for _ in 0..60 {
            let (_, reference) = self.speeds_m_s(speeds[0], speeds[1]);
            let force = creep_force_at(
                &self.parameters.contact,
                slip,
                reference,
                drivetrain.normal_load_n,
                adhesion_peak,
            );
            let residual = slip - slip_free + compliance * force.force_n;
            if residual > 0.0 {
                high = high.min(slip)
            } else {
                low = low.max(slip)
            }
            let slope = 1.0 + compliance * force.slope_n_s_per_m;
            let newton = slip - residual / slope;
            let next =
                if slope > 0.0 && newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            let change = next - slip;
            slip = next;
            speeds = at((slip_free - slip) / compliance);
            // Newton converges quadratically: what is left after such a change is far below rounding of the speeds.
            if change.abs() < 1e-9 {
                break;
            }
        }
        speeds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traction_rig::{Drive, DriveParameters, Surface};

    fn run(dt_s: f64, seconds: f64, surface: Surface, load_ohm: f64) -> RigState {
        let rig = TractionRig::new(RigParameters::new(surface, load_ohm));
        let mut drive = Drive::new(DriveParameters::default(), &rig.motor);
        let mut state = drive.fluxed_state(&rig, 20.0);
        let control_s = 1e-4;
        let inner = (control_s / dt_s).round() as usize;
        for k in 0..(seconds / control_s).round() as usize {
            let command = if (k as f64) * control_s < 0.2 { 20.0 } else { 30.0 };
            let voltage = drive.step(&state, command, control_s);
            for _ in 0..inner {
                state = rig.step(&state, voltage, surface.adhesion_peak(), dt_s);
            }
        }
        state
    }

    #[test]
    fn erratum_4_power_balance_holds_with_the_torque_divided_by_the_gear_ratio() {
        let rig = TractionRig::new(RigParameters::default());
        let drivetrain = rig.parameters.drivetrain;
        let (motor_speed, roller_speed, torque) = (30.0, 4.8, 12.0);
        let contact = rig.wheel_contact(motor_speed, roller_speed, 0.28);
        let force = contact.force.force_n;
        let [motor_rate, roller_rate] = rig.accelerations_rad_s2(torque, force, roller_speed);
        let kinetic_rate = drivetrain.motor_inertia_kg_m2 * motor_speed * motor_rate
            + drivetrain.wheel_inertia_kg_m2
                * (motor_speed / drivetrain.gear_ratio)
                * (motor_rate / drivetrain.gear_ratio)
            + drivetrain.roller_inertia_kg_m2 * roller_speed * roller_rate;
        let put_in = torque * motor_speed;
        let taken = rig.generator().load_coefficient_nm_s() * roller_speed * roller_speed;
        let slip_loss = 2.0 * force * contact.slip_velocity_m_s;
        let missing = put_in - taken - slip_loss - kinetic_rate;
        println!(
            "in {put_in:.1} W, generator {taken:.1}, slip {slip_loss:.2}, kinetic {kinetic_rate:.1}, missing {missing:.2e}"
        );
        assert!(missing.abs() < 1e-9 * put_in);
        // As printed in the paper the contact would take i² times its power from the motor.
        let printed_rate = (torque - 2.0 * drivetrain.gear_ratio * drivetrain.wheel_radius_m * force)
            / drivetrain.equivalent_inertia_kg_m2();
        let printed_missing =
            (motor_rate - printed_rate) * drivetrain.equivalent_inertia_kg_m2() * motor_speed;
        assert!(printed_missing > 5.0 * put_in, "{printed_missing}");
    }

    #[test]
    fn steady_state_is_where_the_generator_takes_the_creep_force() {
        let state = run(1e-4, 6.0, Surface::Base, 1.0);
        let rig = TractionRig::new(RigParameters::new(Surface::Base, 1.0));
        let contact = rig.wheel_contact(state.motor_speed_rad_s, state.roller_speed_rad_s, 0.28);
        let demand = rig.generator().load_coefficient_nm_s() * state.roller_speed_rad_s / 0.4;
        println!(
            "speed {:.4} rad/s, creepage {:.4} %, force {:.2} N, demand {demand:.2} N",
            state.motor_speed_rad_s,
            100.0 * contact.creepage,
            contact.force.force_n
        );
        assert!((state.motor_speed_rad_s - 30.0).abs() < 0.01);
        assert!((contact.force.force_n / demand - 1.0).abs() < 1e-3);
        assert!((demand / 2000.0 - 0.13 / 1.5).abs() < 0.002);
    }

    #[test]
    fn slips_in_the_cases_in_which_the_papers_rig_slipped() {
        let creepage = |surface: Surface, load_ohm: f64| {
            let rig = TractionRig::new(RigParameters::new(surface, load_ohm));
            let state = run(1e-4, 5.0, surface, load_ohm);
            let peak = surface.adhesion_peak();
            rig.wheel_contact(state.motor_speed_rad_s, state.roller_speed_rad_s, peak).creepage
        };
        let cases = [
            (Surface::Base, 1.0, false),
            (Surface::Base, 0.0, true),
            (Surface::Water, 1.5, false),
            (Surface::Water, 1.0, true),
            (Surface::Oil, 3.0, false),
            (Surface::Oil, 1.5, true),
        ];
        for (surface, load_ohm, slips) in cases {
            let creepage = creepage(surface, load_ohm);
            println!("{:5} {load_ohm} Ω: creepage {:.3} %", surface.name(), 100.0 * creepage);
            assert_eq!(creepage > 0.02, slips);
        }
    }

    #[test]
    fn stiff_steps_converge_and_agree_with_small_ones() {
        let reference = run(1e-6, 0.3, Surface::Base, 1.0);
        let mut errors = Vec::new();
        for dt in [1e-4, 5e-5, 2.5e-5] {
            let state = run(dt, 0.3, Surface::Base, 1.0);
            errors.push((state.roller_speed_rad_s - reference.roller_speed_rad_s).abs());
        }
        println!("errors of roller speed after 0.3 s at 100, 50, 25 µs: {errors:?} rad/s");
        assert!(errors[0] < 1e-5 && errors[2] < 0.6 * errors[0]);
    }
}
