//! The file of a roller rig (`rig.toml`, `kind = "roller"`): Schwarz & Keck (2020), section 3.

use super::as_vehicle::{one_wheelset, usual_rail};
use super::check::{CONTACT_KEYS, PlantError, check_head, contact_checks, refuse_first};
use railgrip_vehicle::roller_rig::RigParameters;
use railgrip_vehicle::{Brake, Contact, Rail, Sensors, VehicleParameters, WagonModel, Wheelset};
use serde::{Deserialize, Serialize};

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
        RigParameters {
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
