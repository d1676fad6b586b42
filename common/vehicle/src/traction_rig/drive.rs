//! Inverter with indirect field-oriented control (the paper's [11]): a PI speed loop asks for torque, PI current
//! loops turn it into stator voltage in the frame of the rotor flux.

use super::{Motor, MotorState, RigState, TractionRig};

/// Settings of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveParameters {
    /// Rotor flux to hold, Wb.
    pub flux_wb: f64,
    /// Largest torque-forming current, A (amplitude).
    pub current_limit_a: f64,
    /// Largest stator voltage, V (amplitude).
    pub voltage_limit_v: f64,
    /// Proportional gain of the speed loop, N m s/rad.
    pub speed_gain_nm_s: f64,
    /// Integral gain of the speed loop, N m/rad.
    pub speed_integral_nm: f64,
    /// Bandwidth of the current loops, rad/s.
    pub current_bandwidth_rad_s: f64,
    /// Steepest change of the speed command that is passed on, rad/s².
    pub ramp_rad_s2: f64,
}

impl Default for DriveParameters {
    /// Chosen: rated flux of the motor, speed loop near 15 rad/s on the whole inertia.
    fn default() -> Self {
        Self {
            flux_wb: 0.9,
            current_limit_a: 20.0,
            voltage_limit_v: 320.0,
            speed_gain_nm_s: 2.0,
            speed_integral_nm: 8.0,
            current_bandwidth_rad_s: 400.0,
            ramp_rad_s2: 40.0,
        }
    }
}

/// State of the control.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    parameters: DriveParameters,
    pole_pairs: f64,
    rotor_rate: f64,
    mutual_inductance_h: f64,
    transient_inductance_h: f64,
    resistance_ohm: f64,
    torque_per_current: f64,
    flux_angle_rad: f64,
    speed_command_rad_s: Option<f64>,
    speed_integral_nm: f64,
    current_integral_v: [f64; 2],
}

impl Drive {
    /// A drive for this motor, whose constants it knows exactly.
    pub fn new(parameters: DriveParameters, motor: &Motor) -> Self {
        let p = motor.parameters();
        let coupling = p.mutual_inductance_h / p.rotor_inductance_h;
        Self {
            parameters,
            pole_pairs: p.pole_pairs,
            rotor_rate: p.rotor_resistance_ohm / p.rotor_inductance_h,
            mutual_inductance_h: p.mutual_inductance_h,
            transient_inductance_h: p.stator_inductance_h - p.mutual_inductance_h * coupling,
            resistance_ohm: p.stator_resistance_ohm + coupling * coupling * p.rotor_resistance_ohm,
            torque_per_current: 1.5 * p.pole_pairs * coupling * parameters.flux_wb,
            flux_angle_rad: 0.0,
            speed_command_rad_s: None,
            speed_integral_nm: 0.0,
            current_integral_v: [0.0; 2],
        }
    }

    /// The rig turning without slip at a motor speed, its motor fluxed, no torque.
    pub fn fluxed_state(&self, rig: &TractionRig, motor_speed_rad_s: f64) -> RigState {
        let drivetrain = &rig.parameters.drivetrain;
        RigState {
            motor: MotorState {
                current_a: [self.parameters.flux_wb / self.mutual_inductance_h, 0.0],
                flux_wb: [self.parameters.flux_wb, 0.0],
            },
            motor_speed_rad_s,
            roller_speed_rad_s: drivetrain.rim_per_motor_m() * motor_speed_rad_s / drivetrain.roller_radius_m,
        }
    }

    /// Stator voltage (α, β) for the next `dt_s`, V.
    pub fn step(&mut self, state: &RigState, command_rad_s: f64, dt_s: f64) -> [f64; 2] {
        let q_wanted =
            self.torque_wanted_nm(state.motor_speed_rad_s, command_rad_s, dt_s) / self.torque_per_current;
        let limit = self.parameters.current_limit_a;
        let wanted = [self.parameters.flux_wb / self.mutual_inductance_h, q_wanted.clamp(-limit, limit)];
        let (sin, cos) = self.flux_angle_rad.sin_cos();
        let [ia, ib] = state.motor.current_a;
        let current = [cos * ia + sin * ib, cos * ib - sin * ia];
        let slip = self.rotor_rate * self.mutual_inductance_h * wanted[1] / self.parameters.flux_wb;
        let frequency = self.pole_pairs * state.motor_speed_rad_s + slip;
        let coupling = self.transient_inductance_h * frequency;
        let back_emf = frequency
            * self.parameters.flux_wb
            * (self.torque_per_current / (1.5 * self.pole_pairs * self.parameters.flux_wb));
        let forward = [-coupling * current[1], coupling * current[0] + back_emf];
        let mut voltage = [0.0; 2];
        for axis in 0..2 {
            let error = wanted[axis] - current[axis];
            let bandwidth = self.parameters.current_bandwidth_rad_s;
            self.current_integral_v[axis] += bandwidth * self.resistance_ohm * error * dt_s;
            voltage[axis] = bandwidth * self.transient_inductance_h * error
                + self.current_integral_v[axis]
                + forward[axis];
        }
        let scale = (self.parameters.voltage_limit_v / voltage[0].hypot(voltage[1]).max(1e-9)).min(1.0);
        // The voltage holds over the step, so it is laid where the flux is in the middle of it.
        let (sin, cos) = (self.flux_angle_rad + 0.5 * frequency * dt_s).sin_cos();
        self.flux_angle_rad = (self.flux_angle_rad + frequency * dt_s).rem_euclid(std::f64::consts::TAU);
        [scale * (cos * voltage[0] - sin * voltage[1]), scale * (sin * voltage[0] + cos * voltage[1])]
    }

    fn torque_wanted_nm(&mut self, speed_rad_s: f64, command_rad_s: f64, dt_s: f64) -> f64 {
        let last = self.speed_command_rad_s.unwrap_or(command_rad_s);
        let reach = self.parameters.ramp_rad_s2 * dt_s;
        let command = last + (command_rad_s - last).clamp(-reach, reach);
        self.speed_command_rad_s = Some(command);
        let error = command - speed_rad_s;
        let limit = self.torque_per_current * self.parameters.current_limit_a;
        self.speed_integral_nm =
            (self.speed_integral_nm + self.parameters.speed_integral_nm * error * dt_s).clamp(-limit, limit);
        self.parameters.speed_gain_nm_s * error + self.speed_integral_nm
    }
}
