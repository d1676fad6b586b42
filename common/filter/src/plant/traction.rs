//! The file of a traction rig (`rig.toml`, `kind = "traction"`): Zhao et al. (2014).

use super::as_vehicle::{one_wheelset, usual_rail};
use super::check::{CONTACT_KEYS, PlantError, check_head, contact_checks, refuse_first};
use railgrip_vehicle::traction_rig::{Drivetrain, Generator, MotorParameters, RigParameters, TractionRig};
use railgrip_vehicle::{Brake, Contact, Sensors, VehicleParameters, Wheelset};
use serde::{Deserialize, Serialize};

/// The file of a traction rig (`rig.toml`, `kind = "traction"`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TractionRigFile {
    /// Layout of the file; only 1 is known.
    pub schema: u32,
    /// `"traction"`.
    pub kind: String,
    /// Name for people.
    pub name: String,
    /// Induction motor, referred to the stator.
    pub motor: MotorParameters,
    /// Gear, wheels and rollers.
    pub drivetrain: Drivetrain,
    /// Contact law of one wheel.
    pub contact: Contact,
    /// Generator with its load; `load_resistance_ohm = inf` where it is not connected.
    pub generator: Generator,
    /// Accuracy of the sensors.
    pub sensors: MotorSensors,
}

/// Sensors of a traction rig, one sigma each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotorSensors {
    /// Samples per second, Hz.
    pub sample_rate_hz: f64,
    /// Stator currents, A.
    pub current_sigma_a: f64,
    /// Stator voltages, V.
    pub voltage_sigma_v: f64,
    /// Speed of the motor, rad/s.
    pub motor_speed_sigma_rad_s: f64,
    /// Speed of the roller, rad/s.
    pub roller_speed_sigma_rad_s: f64,
    /// Current of the generator, A.
    pub generator_current_sigma_a: f64,
    /// Largest voltage (amplitude of the vector) that the inverter can give, V.
    pub voltage_limit_v: f64,
}

impl TractionRigFile {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of its range, with its key.
    pub fn check(&self) -> Result<(), PlantError> {
        check_head(self.schema, &self.kind, "traction")?;
        let (motor, drive, generator) = (&self.motor, &self.drivetrain, &self.generator);
        let sensors = &self.sensors;
        let leaks = motor.stator_inductance_h.min(motor.rotor_inductance_h) * 0.9999;
        let sigma = (1e-9, 1e3, "1e-9 to 1000");
        refuse_first(&[
            ("motor.stator_resistance_ohm", motor.stator_resistance_ohm, 1e-4, 1e3, "0.0001 to 1000"),
            ("motor.rotor_resistance_ohm", motor.rotor_resistance_ohm, 1e-4, 1e3, "0.0001 to 1000"),
            ("motor.stator_inductance_h", motor.stator_inductance_h, 1e-5, 100.0, "0.00001 to 100"),
            ("motor.rotor_inductance_h", motor.rotor_inductance_h, 1e-5, 100.0, "0.00001 to 100"),
            ("motor.mutual_inductance_h", motor.mutual_inductance_h, 1e-6, leaks, "below both inductances"),
            ("motor.pole_pairs", motor.pole_pairs, 1.0, 32.0, "1 to 32"),
            ("drivetrain.gear_ratio", drive.gear_ratio, 0.05, 100.0, "0.05 to 100"),
            ("drivetrain.motor_inertia_kg_m2", drive.motor_inertia_kg_m2, 1e-6, 1e4, "1e-6 to 10000"),
            ("drivetrain.wheel_inertia_kg_m2", drive.wheel_inertia_kg_m2, 1e-6, 1e4, "1e-6 to 10000"),
            ("drivetrain.roller_inertia_kg_m2", drive.roller_inertia_kg_m2, 1e-6, 1e5, "1e-6 to 100000"),
            ("drivetrain.wheel_radius_m", drive.wheel_radius_m, 0.01, 1.5, "0.01 to 1.5"),
            ("drivetrain.roller_radius_m", drive.roller_radius_m, 0.01, 3.0, "0.01 to 3"),
            ("drivetrain.normal_load_n", drive.normal_load_n, 1.0, 1e6, "1 to 1000000"),
            ("generator.constant_v_s_per_rad", generator.constant_v_s_per_rad, 1e-6, 1e3, "1e-6 to 1000"),
            (
                "generator.armature_resistance_ohm",
                generator.armature_resistance_ohm,
                1e-6,
                1e4,
                "1e-6 to 10000",
            ),
            ("generator.belt_ratio", generator.belt_ratio, 1e-3, 1e3, "0.001 to 1000"),
            ("generator.load_resistance_ohm", generator.load_resistance_ohm, 0.0, f64::INFINITY, "0 to inf"),
            ("sensors.sample_rate_hz", sensors.sample_rate_hz, 100.0, 5e4, "100 to 50000"),
            ("sensors.current_sigma_a", sensors.current_sigma_a, sigma.0, sigma.1, sigma.2),
            ("sensors.voltage_sigma_v", sensors.voltage_sigma_v, sigma.0, sigma.1, sigma.2),
            ("sensors.motor_speed_sigma_rad_s", sensors.motor_speed_sigma_rad_s, sigma.0, sigma.1, sigma.2),
            ("sensors.roller_speed_sigma_rad_s", sensors.roller_speed_sigma_rad_s, sigma.0, sigma.1, sigma.2),
            (
                "sensors.generator_current_sigma_a",
                sensors.generator_current_sigma_a,
                sigma.0,
                sigma.1,
                sigma.2,
            ),
            ("sensors.voltage_limit_v", sensors.voltage_limit_v, 1.0, 1e5, "1 to 100000"),
        ])?;
        refuse_first(&contact_checks(&self.contact, CONTACT_KEYS))
    }

    /// The rig's equations.
    pub fn rig(&self) -> TractionRig {
        TractionRig::new(RigParameters {
            motor: self.motor,
            drivetrain: self.drivetrain,
            contact: self.contact.clone(),
            generator: self.generator,
        })
    }

    /// The file of the paper's rig with these parameters, its sensors as (5-4) lists them.
    pub fn of(name: &str, parameters: &RigParameters, sigma: f64) -> Self {
        Self {
            schema: 1,
            kind: "traction".into(),
            name: name.into(),
            motor: parameters.motor,
            drivetrain: parameters.drivetrain,
            contact: parameters.contact.clone(),
            generator: parameters.generator,
            sensors: MotorSensors {
                sample_rate_hz: 1000.0,
                current_sigma_a: sigma,
                voltage_sigma_v: sigma,
                motor_speed_sigma_rad_s: sigma,
                roller_speed_sigma_rad_s: sigma,
                generator_current_sigma_a: sigma,
                voltage_limit_v: 400.0,
            },
        }
    }

    /// The rig as a wagon with one wheelset, for what asks about wagons.
    pub fn as_vehicle(&self) -> VehicleParameters {
        let drive = &self.drivetrain;
        let ratio = drive.gear_ratio;
        let inertia_kg_m2 = drive.wheel_inertia_kg_m2 + drive.motor_inertia_kg_m2 * ratio * ratio;
        let mass_kg = drive.roller_inertia_kg_m2 / (drive.roller_radius_m * drive.roller_radius_m);
        let sensors = Sensors {
            sample_rate_hz: self.sensors.sample_rate_hz,
            speed_sigma_m_s: self.sensors.roller_speed_sigma_rad_s * drive.roller_radius_m,
            wheel_speed_sigma_rad_s: self.sensors.motor_speed_sigma_rad_s / ratio,
            pressing_force_sigma_n: 0.0,
        };
        let wheelset = Wheelset { radius_m: drive.wheel_radius_m, inertia_kg_m2 };
        let brake =
            Brake { radius_m: drive.wheel_radius_m, friction_coefficient: 0.35, friction_by_wheelset: None };
        one_wheelset(&self.name, mass_kg, wheelset, brake, &self.contact, usual_rail(), sensors)
    }
}
