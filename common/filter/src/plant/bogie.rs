//! The file of a bogie rig (`rig.toml`, `kind = "bogie"`): Shrestha, Spiryagin & Wu (2021).

use super::check::{Check, PlantError, check_head, contact_checks, refuse_first};
use railgrip_vehicle::bogie_rig::{
    BOGIE_WHEELSETS, BogieParameters, BrakeParameters, ContactLaw, RailCondition, SensorParameters,
};
use railgrip_vehicle::{
    Body, Brake, Contact, GRAVITY_M_S2, Rail, Resistance, Sensors, VehicleParameters, Wheelset,
};
use serde::{Deserialize, Serialize};

/// The file of a bogie rig.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BogieRigFile {
    /// Layout of the file; only 1 is known.
    pub schema: u32,
    /// `"bogie"`.
    pub kind: String,
    /// Name for people.
    pub name: String,
    /// Each wheelset.
    pub wheelset: Wheelset,
    /// Rollers with shafts and belt.
    pub roller: BogieRollers,
    /// Gear and motor.
    pub drive: BogieDrive,
    /// Hydraulic caliper brakes.
    pub brake: BogieBrake,
    /// Contact law on a dry rail.
    pub dry: BogieLaw,
    /// Contact law on a wet rail.
    pub wet: BogieLaw,
    /// Adhesion available by class, as a brake reaches it.
    pub rail: Rail,
    /// Sensors.
    pub sensors: BogieRigSensors,
}

/// Rollers of a bogie rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BogieRollers {
    /// R, m.
    pub radius_m: f64,
    /// J_r of both pairs of rollers with shafts and belt, kg m².
    pub inertia_kg_m2: f64,
    /// Loss of bearings and belt at the roller shaft, N m.
    pub loss_nm: f64,
    /// Its growth with roller speed, N m s/rad.
    pub loss_nm_s: f64,
    /// Normal load of each wheelset, front first, N.
    pub wheelset_load_n: [f64; BOGIE_WHEELSETS],
}

/// Gear and motor of a bogie rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BogieDrive {
    /// i: motor speed over roller speed.
    pub gear_ratio: f64,
    /// J_s: what turns with the motor beyond the torque transducer, kg m².
    pub shaft_inertia_kg_m2: f64,
    /// J_m, kg m².
    pub motor_inertia_kg_m2: f64,
}

/// Caliper brakes of a bogie rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BogieBrake {
    /// Diameter of a caliper's piston, m.
    pub piston_diameter_m: f64,
    /// Discs, and calipers, of a wheelset.
    pub discs: f64,
    /// Radius at which the pads rub, m.
    pub friction_radius_m: f64,
    /// Nominal pad friction.
    pub friction_coefficient: f64,
}

/// Contact law of one wheelset under a condition, (4) to (8) of the paper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BogieLaw {
    /// μ0: friction at zero slip velocity.
    pub friction_at_rest: f64,
    /// Stiffness, reduction factors and falling friction.
    pub contact: Contact,
}

/// Sensors of a bogie rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BogieRigSensors {
    /// Samples per second, Hz.
    pub sample_rate_hz: f64,
    /// Window of the rollers' counter, s; 0.125 is 8 Hz.
    pub roller_window_s: f64,
    /// Pulses a revolution of the motor shaft.
    pub roller_pulses_per_rev: f64,
    /// Pulses a revolution of a wheelset.
    pub wheel_pulses_per_rev: f64,
    /// Torque that the transducer can tell, N m.
    pub torque_capacity_nm: f64,
    /// One sigma of the transducer at no torque, N m.
    pub torque_sigma_nm: f64,
    /// Growth of that sigma, as a share of the torque.
    pub torque_sigma_share: f64,
    /// Force that the load cell can tell, N.
    pub load_cell_capacity_n: f64,
    /// One sigma of the load cell under load, N.
    pub load_cell_sigma_n: f64,
    /// The same of the rattle of its link without load, N.
    pub load_cell_rattle_n: f64,
}

const DRY_KEYS: [&str; 5] = [
    "dry.contact.stiffness_n",
    "dry.contact.k_a",
    "dry.contact.k_s",
    "dry.contact.friction_ratio",
    "dry.contact.friction_decay_s_per_m",
];
const WET_KEYS: [&str; 5] = [
    "wet.contact.stiffness_n",
    "wet.contact.k_a",
    "wet.contact.k_s",
    "wet.contact.friction_ratio",
    "wet.contact.friction_decay_s_per_m",
];

impl BogieRigFile {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of its range, with its key.
    pub fn check(&self) -> Result<(), PlantError> {
        check_head(self.schema, &self.kind, "bogie")?;
        refuse_first(&self.machine_checks())?;
        refuse_first(&self.sensor_checks())?;
        refuse_first(&contact_checks(&self.dry.contact, DRY_KEYS))?;
        refuse_first(&contact_checks(&self.wet.contact, WET_KEYS))
    }

    fn machine_checks(&self) -> [Check; 19] {
        let (roller, drive, brake) = (&self.roller, &self.drive, &self.brake);
        let inertia = (1e-6, 1e5, "1e-6 to 100000");
        let friction = (1e-3, 1.5, "0.001 to 1.5");
        let load = (10.0, 1e6, "10 to 1000000");
        let check = |key, value, (low, high, words): (f64, f64, &'static str)| (key, value, low, high, words);
        [
            ("wheelset.radius_m", self.wheelset.radius_m, 0.01, 1.5, "0.01 to 1.5"),
            check("wheelset.inertia_kg_m2", self.wheelset.inertia_kg_m2, inertia),
            ("roller.radius_m", roller.radius_m, 0.01, 5.0, "0.01 to 5"),
            check("roller.inertia_kg_m2", roller.inertia_kg_m2, inertia),
            ("roller.loss_nm", roller.loss_nm, 0.0, 1e5, "0 to 100000"),
            ("roller.loss_nm_s", roller.loss_nm_s, 0.0, 1e4, "0 to 10000"),
            check("roller.wheelset_load_n", roller.wheelset_load_n[0], load),
            check("roller.wheelset_load_n", roller.wheelset_load_n[1], load),
            ("drive.gear_ratio", drive.gear_ratio, 0.05, 100.0, "0.05 to 100"),
            ("drive.shaft_inertia_kg_m2", drive.shaft_inertia_kg_m2, 0.0, 1e4, "0 to 10000"),
            ("drive.motor_inertia_kg_m2", drive.motor_inertia_kg_m2, 0.0, 1e4, "0 to 10000"),
            ("brake.piston_diameter_m", brake.piston_diameter_m, 1e-3, 1.0, "0.001 to 1"),
            ("brake.discs", brake.discs, 1.0, 8.0, "1 to 8"),
            ("brake.friction_radius_m", brake.friction_radius_m, 1e-3, 1.5, "0.001 to 1.5"),
            check("brake.friction_coefficient", brake.friction_coefficient, friction),
            check("dry.friction_at_rest", self.dry.friction_at_rest, friction),
            check("wet.friction_at_rest", self.wet.friction_at_rest, friction),
            check("rail.dry", self.rail.dry, friction),
            check("rail.wet", self.rail.wet, friction),
        ]
    }

    fn sensor_checks(&self) -> [Check; 11] {
        let sensors = &self.sensors;
        let pulses = (1.0, 1e7, "1 to 1e7");
        [
            ("rail.low", self.rail.low, 1e-3, 1.5, "0.001 to 1.5"),
            ("sensors.sample_rate_hz", sensors.sample_rate_hz, 10.0, 1e4, "10 to 10000"),
            ("sensors.roller_window_s", sensors.roller_window_s, 1e-4, 10.0, "0.0001 to 10"),
            ("sensors.roller_pulses_per_rev", sensors.roller_pulses_per_rev, pulses.0, pulses.1, pulses.2),
            ("sensors.wheel_pulses_per_rev", sensors.wheel_pulses_per_rev, pulses.0, pulses.1, pulses.2),
            ("sensors.torque_capacity_nm", sensors.torque_capacity_nm, 1e-2, 1e6, "0.01 to 1e6"),
            ("sensors.torque_sigma_nm", sensors.torque_sigma_nm, 1e-6, 1e5, "1e-6 to 1e5"),
            ("sensors.torque_sigma_share", sensors.torque_sigma_share, 0.0, 1.0, "0 to 1"),
            ("sensors.load_cell_capacity_n", sensors.load_cell_capacity_n, 1.0, 1e7, "1 to 1e7"),
            ("sensors.load_cell_sigma_n", sensors.load_cell_sigma_n, 1e-6, 1e6, "1e-6 to 1e6"),
            ("sensors.load_cell_rattle_n", sensors.load_cell_rattle_n, 0.0, 1e6, "0 to 1e6"),
        ]
    }

    /// The rig's constants.
    pub fn parameters(&self) -> BogieParameters {
        let sensors = &self.sensors;
        BogieParameters {
            wheel_radius_m: self.wheelset.radius_m,
            roller_radius_m: self.roller.radius_m,
            gear_ratio: self.drive.gear_ratio,
            wheelset_load_n: self.roller.wheelset_load_n,
            wheelset_inertia_kg_m2: self.wheelset.inertia_kg_m2,
            roller_inertia_kg_m2: self.roller.inertia_kg_m2,
            shaft_inertia_kg_m2: self.drive.shaft_inertia_kg_m2,
            motor_inertia_kg_m2: self.drive.motor_inertia_kg_m2,
            loss_nm: self.roller.loss_nm,
            loss_nm_s: self.roller.loss_nm_s,
            brake: BrakeParameters {
                piston_diameter_m: self.brake.piston_diameter_m,
                discs: self.brake.discs,
                friction_radius_m: self.brake.friction_radius_m,
                pad_friction: [self.brake.friction_coefficient; BOGIE_WHEELSETS],
                ..BrakeParameters::default()
            },
            sensors: SensorParameters {
                roller_pulses_per_rev: sensors.roller_pulses_per_rev,
                roller_window_s: sensors.roller_window_s,
                wheel_pulses_per_rev: sensors.wheel_pulses_per_rev,
                sample_period_s: 1.0 / sensors.sample_rate_hz,
                torque_offset_nm: 0.0,
                load_cell_offset_n: 0.0,
                torque_capacity_nm: sensors.torque_capacity_nm,
                load_cell_capacity_n: sensors.load_cell_capacity_n,
                torque_sigma: (sensors.torque_sigma_nm, sensors.torque_sigma_share),
                load_cell_sigma_n: (sensors.load_cell_sigma_n, sensors.load_cell_rattle_n),
            },
            ..BogieParameters::default()
        }
    }

    /// The contact law under a condition.
    pub fn law(&self, condition: RailCondition) -> ContactLaw {
        let law = match condition {
            RailCondition::Dry => &self.dry,
            RailCondition::Wet => &self.wet,
        };
        ContactLaw { contact: law.contact.clone(), friction_at_rest: law.friction_at_rest }
    }

    /// The file of a rig with these parameters under the paper's laws. What nobody can know stays out: zero errors, and
    /// how the pads of one wheelset differ from those of the other.
    pub fn of(name: &str, parameters: &BogieParameters) -> Self {
        let law = |condition| {
            let law = ContactLaw::of(condition);
            BogieLaw { friction_at_rest: law.friction_at_rest, contact: law.contact }
        };
        let (p, sensors) = (parameters, &parameters.sensors);
        Self {
            schema: 1,
            kind: "bogie".into(),
            name: name.into(),
            wheelset: Wheelset { radius_m: p.wheel_radius_m, inertia_kg_m2: p.wheelset_inertia_kg_m2 },
            roller: BogieRollers {
                radius_m: p.roller_radius_m,
                inertia_kg_m2: p.roller_inertia_kg_m2,
                loss_nm: p.loss_nm,
                loss_nm_s: p.loss_nm_s,
                wheelset_load_n: p.wheelset_load_n,
            },
            drive: BogieDrive {
                gear_ratio: p.gear_ratio,
                shaft_inertia_kg_m2: p.shaft_inertia_kg_m2,
                motor_inertia_kg_m2: p.motor_inertia_kg_m2,
            },
            brake: BogieBrake {
                piston_diameter_m: p.brake.piston_diameter_m,
                discs: p.brake.discs,
                friction_radius_m: p.brake.friction_radius_m,
                friction_coefficient: p.brake.pad_friction[0],
            },
            dry: law(RailCondition::Dry),
            wet: law(RailCondition::Wet),
            rail: Rail { dry: 0.4, wet: 0.2, low: 0.1 },
            sensors: BogieRigSensors {
                sample_rate_hz: 1.0 / sensors.sample_period_s,
                roller_window_s: sensors.roller_window_s,
                roller_pulses_per_rev: sensors.roller_pulses_per_rev,
                wheel_pulses_per_rev: sensors.wheel_pulses_per_rev,
                torque_capacity_nm: sensors.torque_capacity_nm,
                torque_sigma_nm: sensors.torque_sigma.0,
                torque_sigma_share: sensors.torque_sigma.1,
                load_cell_capacity_n: sensors.load_cell_capacity_n,
                load_cell_sigma_n: sensors.load_cell_sigma_n.0,
                load_cell_rattle_n: sensors.load_cell_sigma_n.1,
            },
        }
    }

    /// The rig as a wagon with two wheelsets, for what asks about wagons.
    pub fn as_vehicle(&self) -> VehicleParameters {
        let p = self.parameters();
        let pulse = std::f64::consts::TAU / p.sensors.wheel_pulses_per_rev;
        VehicleParameters {
            schema: 1,
            name: self.name.clone(),
            body: Body {
                mass_kg: p.load_n() / GRAVITY_M_S2,
                com_height_m: 0.0,
                wheelbase_m: 1.0,
                wheelset_positions_m: None,
                mass_sigma: None,
            },
            wheelset: self.wheelset.clone(),
            brake: Brake {
                radius_m: self.brake.friction_radius_m,
                friction_coefficient: self.brake.friction_coefficient,
                friction_by_wheelset: None,
            },
            resistance: Resistance { constant_n: 0.0, linear_n_s_per_m: 0.0, drag_n_s2_per_m2: 0.0 },
            contact: self.dry.contact.clone(),
            rail: self.rail.clone(),
            sensors: Sensors {
                sample_rate_hz: self.sensors.sample_rate_hz,
                speed_sigma_m_s: 0.02,
                wheel_speed_sigma_rad_s: pulse * self.sensors.sample_rate_hz,
                pressing_force_sigma_n: 0.0,
            },
            bogie: None,
            train: None,
            effects: Vec::new(),
        }
    }
}
