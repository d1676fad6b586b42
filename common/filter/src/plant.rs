//! What a filter watches: a wagon, or one of the rigs, with the file that describes it.
//!
//! A file without `kind` is a wagon (`vehicle.toml`); `kind = "roller"` is a roller rig with one braked wheelset
//! (Schwarz & Keck), `kind = "traction"` a rig whose wheelset is driven by an induction motor (Zhao et al.),
//! `kind = "bogie"` a braked bogie on driven rollers (Shrestha et al.).

mod bogie;

pub use bogie::{BogieBrake, BogieDrive, BogieLaw, BogieRigFile, BogieRigSensors, BogieRollers};

use railgrip_vehicle::roller_rig::RigParameters as RollerParameters;
use railgrip_vehicle::traction_rig::{
    Drivetrain, Generator, MotorParameters, RigParameters as TractionParameters, TractionRig,
};
use railgrip_vehicle::{
    Body, Brake, Contact, Rail, Resistance, Sensors, VehicleParameters, WagonModel, Wheelset,
};
use serde::{Deserialize, Serialize};

/// What a filter watches.
#[derive(Clone, Debug, PartialEq)]
pub enum Plant {
    /// A wagon.
    Wagon(VehicleParameters),
    /// A roller rig with one braked wheelset.
    Roller(RollerRigFile),
    /// A rig with a driven wheelset.
    Traction(TractionRigFile),
    /// A braked bogie on driven rollers.
    Bogie(Box<BogieRigFile>),
}

/// Kind of a plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PlantKind {
    /// A wagon.
    Wagon,
    /// A roller rig.
    Roller,
    /// A traction rig.
    Traction,
    /// A bogie rig.
    Bogie,
}

impl PlantKind {
    /// Name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Wagon => "wagon",
            Self::Roller => "roller rig",
            Self::Traction => "traction rig",
            Self::Bogie => "bogie rig",
        }
    }
}

/// The file of a roller rig (`rig.toml`, `kind = "roller"`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RollerRigFile {
    /// Layout of the file; only 1 is known.
    pub schema: u32,
    /// `"roller"`.
    pub kind: String,
    /// Name for people.
    pub name: String,
    /// Wheelset.
    pub wheelset: Wheelset,
    /// Brake unit.
    pub brake: Brake,
    /// Rollers.
    pub roller: Roller,
    /// Contact law.
    pub contact: Contact,
    /// Adhesion available by class.
    #[serde(default = "usual_rail")]
    pub rail: Rail,
    /// Accuracy of the sensors.
    pub sensors: Sensors,
}

/// Load and inertia of a roller rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Roller {
    /// Normal load of the wheelset, N.
    pub load_n: f64,
    /// Mass that roller and its drive represent, kg.
    pub equivalent_mass_kg: f64,
}

fn usual_rail() -> Rail {
    Rail { dry: 0.3, wet: 0.12, low: 0.06 }
}

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

/// A value of a rig's file that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{key}` is {value}, allowed is {allowed}")]
pub struct PlantError {
    /// Dotted key.
    pub key: &'static str,
    /// What stands there.
    pub value: String,
    /// What may stand there.
    pub allowed: &'static str,
}

/// One check: key, value, range, range in words.
type Check = (&'static str, f64, f64, f64, &'static str);

fn refuse_first(checks: &[Check]) -> Result<(), PlantError> {
    match checks.iter().find(|(_, value, low, high, _)| !(low..=high).contains(&value)) {
        Some((key, value, _, _, allowed)) => Err(PlantError { key, value: value.to_string(), allowed }),
        None => Ok(()),
    }
}

fn check_head(schema: u32, kind: &str, expected: &'static str) -> Result<(), PlantError> {
    if schema != 1 {
        return Err(PlantError { key: "schema", value: schema.to_string(), allowed: "1" });
    }
    if kind != expected {
        return Err(PlantError {
            key: "kind",
            value: format!("{kind:?}"),
            allowed: "\"roller\", \"traction\" or \"bogie\"",
        });
    }
    Ok(())
}

const CONTACT_KEYS: [&str; 5] = [
    "contact.stiffness_n",
    "contact.k_a",
    "contact.k_s",
    "contact.friction_ratio",
    "contact.friction_decay_s_per_m",
];

fn contact_checks(contact: &Contact, keys: [&'static str; 5]) -> [Check; 5] {
    let [stiffness, k_a, k_s, ratio, decay] = keys;
    [
        (stiffness, contact.stiffness_n, 1e3, 1e9, "1e3 to 1e9"),
        (k_a, contact.k_a, 1e-3, 1.0, "0.001 to 1"),
        (k_s, contact.k_s, 1e-3, 1.0, "0.001 to 1"),
        (ratio, contact.friction_ratio, 0.05, 1.0, "0.05 to 1"),
        (decay, contact.friction_decay_s_per_m, 0.0, 10.0, "0 to 10"),
    ]
}

impl RollerRigFile {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of its range, with its key.
    pub fn check(&self) -> Result<(), PlantError> {
        check_head(self.schema, &self.kind, "roller")?;
        let sensors = &self.sensors;
        refuse_first(&[
            ("wheelset.radius_m", self.wheelset.radius_m, 0.05, 1.5, "0.05 to 1.5"),
            ("wheelset.inertia_kg_m2", self.wheelset.inertia_kg_m2, 1e-3, 1e4, "0.001 to 10000"),
            ("brake.radius_m", self.brake.radius_m, 0.01, 1.5, "0.01 to 1.5"),
            ("brake.friction_coefficient", self.brake.friction_coefficient, 0.01, 1.5, "0.01 to 1.5"),
            ("roller.load_n", self.roller.load_n, 10.0, 1e6, "10 to 1000000"),
            ("roller.equivalent_mass_kg", self.roller.equivalent_mass_kg, 1.0, 2e5, "1 to 200000"),
            ("rail.dry", self.rail.dry, 1e-3, 1.0, "0.001 to 1"),
            ("rail.wet", self.rail.wet, 1e-3, 1.0, "0.001 to 1"),
            ("rail.low", self.rail.low, 1e-3, 1.0, "0.001 to 1"),
            ("sensors.sample_rate_hz", sensors.sample_rate_hz, 1.0, 1e4, "1 to 10000"),
            ("sensors.speed_sigma_m_s", sensors.speed_sigma_m_s, 1e-6, 5.0, "1e-6 to 5"),
            ("sensors.wheel_speed_sigma_rad_s", sensors.wheel_speed_sigma_rad_s, 1e-6, 20.0, "1e-6 to 20"),
            ("sensors.pressing_force_sigma_n", sensors.pressing_force_sigma_n, 0.0, 1e5, "0 to 100000"),
        ])?;
        refuse_first(&contact_checks(&self.contact, CONTACT_KEYS))
    }

    /// The rig's model: the wagon's equations with one wheelset under a fixed load.
    pub fn model(&self) -> WagonModel {
        RollerParameters {
            wheel_radius_m: self.wheelset.radius_m,
            inertia_kg_m2: self.wheelset.inertia_kg_m2,
            brake_radius_m: self.brake.radius_m,
            brake_friction: self.brake.friction_coefficient,
            load_n: self.roller.load_n,
            equivalent_mass_kg: self.roller.equivalent_mass_kg,
            contact: self.contact.clone(),
        }
        .model()
    }

    /// The rig as a wagon with one wheelset, for what asks about wagons.
    pub fn as_vehicle(&self) -> VehicleParameters {
        one_wheelset(
            &self.name,
            self.roller.equivalent_mass_kg,
            self.wheelset.clone(),
            self.brake.clone(),
            &self.contact,
            self.rail.clone(),
            self.sensors.clone(),
        )
    }
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
        TractionRig::new(TractionParameters {
            motor: self.motor,
            drivetrain: self.drivetrain,
            contact: self.contact.clone(),
            generator: self.generator,
        })
    }

    /// The file of the paper's rig with these parameters, its sensors as (5-4) lists them.
    pub fn of(name: &str, parameters: &TractionParameters, sigma: f64) -> Self {
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

fn one_wheelset(
    name: &str,
    mass_kg: f64,
    wheelset: Wheelset,
    brake: Brake,
    contact: &Contact,
    rail: Rail,
    sensors: Sensors,
) -> VehicleParameters {
    VehicleParameters {
        schema: 1,
        name: name.into(),
        body: Body { mass_kg, com_height_m: 0.0, wheelbase_m: 1.0, wheelset_positions_m: Some(vec![0.0]) },
        wheelset,
        brake,
        resistance: Resistance { constant_n: 0.0, linear_n_s_per_m: 0.0, drag_n_s2_per_m2: 0.0 },
        contact: contact.clone(),
        rail,
        sensors,
        effects: Vec::new(),
    }
}

impl Plant {
    /// Its kind.
    pub const fn kind(&self) -> PlantKind {
        match self {
            Self::Wagon(_) => PlantKind::Wagon,
            Self::Roller(_) => PlantKind::Roller,
            Self::Traction(_) => PlantKind::Traction,
            Self::Bogie(_) => PlantKind::Bogie,
        }
    }

    /// Name for people.
    pub fn name(&self) -> &str {
        match self {
            Self::Wagon(vehicle) => &vehicle.name,
            Self::Roller(rig) => &rig.name,
            Self::Traction(rig) => &rig.name,
            Self::Bogie(rig) => &rig.name,
        }
    }

    /// Number of wheelsets.
    pub fn wheelsets(&self) -> usize {
        match self {
            Self::Wagon(vehicle) => vehicle.wheelsets(),
            Self::Roller(_) | Self::Traction(_) => 1,
            Self::Bogie(rig) => rig.roller.wheelset_load_n.len(),
        }
    }

    /// The plant as a wagon, for what asks about wagons.
    pub fn as_vehicle(&self) -> VehicleParameters {
        match self {
            Self::Wagon(vehicle) => vehicle.clone(),
            Self::Roller(rig) => rig.as_vehicle(),
            Self::Traction(rig) => rig.as_vehicle(),
            Self::Bogie(rig) => rig.as_vehicle(),
        }
    }

    /// Static load of one wheelset, N; on the traction rig that of one wheel.
    pub fn load_n(&self) -> f64 {
        match self {
            Self::Wagon(vehicle) => vehicle.axle_load_n(),
            Self::Roller(rig) => rig.roller.load_n,
            Self::Traction(rig) => rig.drivetrain.normal_load_n,
            Self::Bogie(rig) => rig.roller.wheelset_load_n[0],
        }
    }
}
