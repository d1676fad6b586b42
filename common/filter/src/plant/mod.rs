//! What a filter watches: a wagon, or one of the rigs, with the file that describes it.
//!
//! A file without `kind` is a wagon (`vehicle.toml`); `kind = "roller"` is a roller rig with one braked wheelset
//! (Schwarz & Keck), `kind = "traction"` a rig whose wheelset is driven by an induction motor (Zhao et al.),
//! `kind = "bogie"` a braked bogie on driven rollers (Shrestha et al.).

mod as_vehicle;
mod bogie;
mod check;
mod roller;
mod traction;

pub use bogie::{BogieBrake, BogieDrive, BogieLaw, BogieRigFile, BogieRigSensors, BogieRollers};
pub use check::PlantError;
pub use roller::{Roller, RollerRigFile};
pub use traction::{MotorSensors, TractionRigFile};

use railgrip_vehicle::VehicleParameters;

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
