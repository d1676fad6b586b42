//! Roller drive: the rig computer's PI loop at 8 Hz, voltage law (1), digital-to-analogue converter, and the inverter
//! that turns the motor to the commanded speed.

use std::f64::consts::TAU;

/// Slope of the voltage law (1), rpm/V.
const RPM_PER_VOLT: f64 = 773.46;

/// Offset of the voltage law (1), rpm.
const RPM_AT_ZERO_VOLT: f64 = -3.5084;

/// Full scale of the converter, V.
const CONVERTER_FULL_SCALE_V: f64 = 10.0;

/// Steps of the converter on one side of zero: 16 bits over both.
const CONVERTER_STEPS: f64 = 32_768.0;

/// Speed of the motor at a voltage, rpm: (1).
pub fn motor_speed_rpm(voltage_v: f64) -> f64 {
    RPM_PER_VOLT * voltage_v + RPM_AT_ZERO_VOLT
}

/// Voltage for a speed of the motor, V: (1) turned around.
pub fn voltage_v(motor_speed_rpm: f64) -> f64 {
    (motor_speed_rpm - RPM_AT_ZERO_VOLT) / RPM_PER_VOLT
}

/// What the converter makes of a voltage: the nearest of its 16-bit steps.
pub fn dac_voltage_v(voltage_v: f64) -> f64 {
    let code = (CONVERTER_STEPS + (voltage_v / CONVERTER_FULL_SCALE_V * CONVERTER_STEPS).round())
        .clamp(CONVERTER_STEPS, 2.0 * CONVERTER_STEPS - 1.0);
    (code - CONVERTER_STEPS) / CONVERTER_STEPS * CONVERTER_FULL_SCALE_V
}

/// rad/s from rpm.
pub fn rad_s_from_rpm(rpm: f64) -> f64 {
    rpm * TAU / 60.0
}

/// rpm from rad/s.
pub fn rpm_from_rad_s(rad_s: f64) -> f64 {
    rad_s * 60.0 / TAU
}

/// Settings of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveParameters {
    /// Proportional gain of the PI loop.
    pub gain: f64,
    /// Integral gain of the PI loop, 1/s.
    pub integral_per_s: f64,
    /// Largest voltage, V.
    pub voltage_limit_v: f64,
    /// Torque of the motor per speed that it lacks, N m s/rad.
    pub stiffness_nm_s: f64,
    /// Largest torque, N m.
    pub torque_limit_nm: f64,
    /// Time in which torque follows, s.
    pub torque_lag_s: f64,
}

impl Default for DriveParameters {
    /// Chosen: a loop of about 1 s around a counter of 8 Hz; the voltage that 4.14 m/s needs with some reserve; an
    /// inverter with speed feedback that sags by 0.3 % at rated torque; twice rated torque (the inverter is rated for
    /// three times the motor's power).
    fn default() -> Self {
        Self {
            gain: 0.2,
            integral_per_s: 0.8,
            voltage_limit_v: 2.1,
            stiffness_nm_s: 20.0,
            torque_limit_nm: 100.0,
            torque_lag_s: 0.005,
        }
    }
}

/// State of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollerDrive {
    parameters: DriveParameters,
    integral_rpm: f64,
    command_rad_s: f64,
    torque_nm: f64,
}

impl RollerDrive {
    /// A drive that turns the motor at a speed.
    pub fn turning(parameters: DriveParameters, motor_rpm: f64) -> Self {
        let voltage = dac_voltage_v(voltage_v(motor_rpm).clamp(0.0, parameters.voltage_limit_v));
        let command_rad_s = rad_s_from_rpm(motor_speed_rpm(voltage));
        Self { parameters, integral_rpm: 0.0, command_rad_s, torque_nm: 0.0 }
    }

    /// One turn of the PI loop, `dt_s` after the last; returns the voltage given out.
    pub fn control(&mut self, reference_rpm: f64, measured_rpm: f64, dt_s: f64) -> f64 {
        let error = reference_rpm - measured_rpm;
        let asked = |integral: f64| voltage_v(reference_rpm + self.parameters.gain * error + integral);
        let integral = self.integral_rpm + self.parameters.integral_per_s * error * dt_s;
        // The limiter must not wind the integral up.
        if (0.0..=self.parameters.voltage_limit_v).contains(&asked(integral)) {
            self.integral_rpm = integral;
        }
        let limited = asked(self.integral_rpm).clamp(0.0, self.parameters.voltage_limit_v);
        let voltage = dac_voltage_v(limited);
        self.command_rad_s = rad_s_from_rpm(motor_speed_rpm(voltage)).max(0.0);
        voltage
    }

    /// Torque of the motor over the next `dt_s` at its present speed, N m.
    #[inline]
    pub fn torque_nm(&mut self, motor_speed_rad_s: f64, dt_s: f64) -> f64 {
        let limit = self.parameters.torque_limit_nm;
        let wanted =
            (self.parameters.stiffness_nm_s * (self.command_rad_s - motor_speed_rad_s)).clamp(-limit, limit);
        self.torque_nm += (dt_s / self.parameters.torque_lag_s).min(1.0) * (wanted - self.torque_nm);
        self.torque_nm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voltage_law_is_the_papers() {
        assert!((motor_speed_rpm(1.8) - 1388.72).abs() < 0.01);
        assert!((voltage_v(motor_speed_rpm(0.37)) - 0.37).abs() < 1e-12);
        // One step of the converter is 0.3 mV, 0.24 rpm of the motor.
        assert!((dac_voltage_v(1.234_56) - 1.234_56).abs() < 0.5 * 10.0 / 32_768.0 + 1e-12);
        assert_eq!(dac_voltage_v(-1.0), 0.0);
    }

    #[test]
    fn loop_takes_the_sag_away() {
        let (inertia, load) = (0.13, 40.0);
        let mut drive = RollerDrive::turning(DriveParameters::default(), 600.0);
        let mut speed = rad_s_from_rpm(600.0);
        let mut lowest = f64::INFINITY;
        for k in 0..100_000 {
            if k % 1250 == 0 {
                drive.control(600.0, rpm_from_rad_s(speed), 0.125);
            }
            speed += 1e-4 / inertia * (drive.torque_nm(speed, 1e-4) - load);
            lowest = f64::min(lowest, rpm_from_rad_s(speed));
        }
        let last = rpm_from_rad_s(speed);
        println!("600 rpm under 40 N m: lowest {lowest:.1}, after 10 s {last:.2} rpm");
        assert!((last - 600.0).abs() < 0.5 && lowest > 550.0);
    }
}
