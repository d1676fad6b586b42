//! Vehicle and rig files: what a filter watches, by the file's `kind`.

use crate::place::on_its_line;
use crate::vehicle::{self, VehicleFileError, line_of_key};
use railgrip_filter::{BogieRigFile, Plant, PlantError, PlantKind, RollerRigFile, TractionRigFile};
use railgrip_vehicle::bogie_rig::RailCondition;
use railgrip_vehicle::traction_rig::Surface;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Reads and checks a vehicle file, or a rig's file.
///
/// # Errors
/// A file that cannot be read, an unknown or missing key, a value out of its range.
pub fn load(path: &Path) -> Result<Plant, VehicleFileError> {
    let text = railgrip_recording::read_text(path)
        .map_err(|source| VehicleFileError::Read { path: path.to_owned(), source })?;
    parse(path, &text)
}

/// The one key that tells what a file describes.
#[derive(Deserialize)]
struct Kind {
    kind: Option<toml::Value>,
}

/// Parses and checks the text of such a file; `path` is for messages only.
///
/// # Errors
/// As [`load`].
pub fn parse(path: &Path, text: &str) -> Result<Plant, VehicleFileError> {
    let kind = toml::from_str::<Kind>(text).ok().and_then(|head| head.kind);
    match kind.as_ref().map(toml::Value::as_str) {
        None => Ok(Plant::Wagon(vehicle::parse(path, text)?)),
        Some(Some("roller")) => {
            let rig: RollerRigFile = form(path, text)?;
            rig.check().map_err(|error| value(path, text, error))?;
            Ok(Plant::Roller(rig))
        }
        Some(Some("traction")) => {
            let rig: TractionRigFile = form(path, text)?;
            rig.check().map_err(|error| value(path, text, error))?;
            Ok(Plant::Traction(rig))
        }
        Some(Some("bogie")) => {
            let rig: BogieRigFile = form(path, text)?;
            rig.check().map_err(|error| value(path, text, error))?;
            Ok(Plant::Bogie(Box::new(rig)))
        }
        Some(_) => {
            let value = kind.map_or_else(String::new, |kind| kind.to_string());
            let error = PlantError {
                key: "kind",
                value,
                allowed: "\"roller\", \"traction\", \"bogie\", or no such key for a wagon",
            };
            Err(self::value(path, text, error))
        }
    }
}

fn form<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, VehicleFileError> {
    toml::from_str(text)
        .map_err(|error| VehicleFileError::Form { path: path.to_owned(), message: on_its_line(text, &error) })
}

fn value(path: &Path, text: &str, source: PlantError) -> VehicleFileError {
    VehicleFileError::Rig { path: path.to_owned(), line: line_of_key(text, source.key), source }
}

/// A published test of a rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RigProgramme {
    /// Schwarz & Keck, Fig. 4: slide protection from 120 km/h.
    SchwarzWsp,
    /// Schwarz & Keck, Figs. 5 and 6: sanding from 200 km/h.
    SchwarzSanding,
    /// Zhao et al., Table 2.
    Zhao {
        /// What lies between wheel and roller.
        surface: Surface,
        /// Load case, 0 (no load) to 4.
        case: u8,
    },
    /// Shrestha et al., Figs. 18 to 20: a stop from 4.14 m/s.
    ShresthaStop {
        /// What lies between wheel and roller.
        rail: RailCondition,
        /// Who controls the simulated brakes.
        controller: BrakeController,
    },
    /// Shrestha et al., Fig. 17: water under the braked wheelsets.
    ShresthaWater,
}

/// Controllers of the simulated bogie rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BrakeController {
    /// A constant effort.
    None,
    /// A fixed zone of slip.
    Conventional,
    /// A zone around the optimum slip of the heard condition.
    Proposed,
}

impl BrakeController {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::None, Self::Conventional, Self::Proposed];

    /// Name for files and people.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Conventional => "conventional",
            Self::Proposed => "proposed",
        }
    }
}

impl RigProgramme {
    /// The names, for people.
    pub const NAMES: &'static str = "schwarz-wsp, schwarz-sanding, zhao-SURFACE-CASE with SURFACE base, water or oil and CASE 0 to 4, shrestha-water, \
         shrestha-RAIL-CONTROLLER with RAIL dry or wet and CONTROLLER none, conventional or proposed";

    /// The programme of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "schwarz-wsp" => return Some(Self::SchwarzWsp),
            "schwarz-sanding" => return Some(Self::SchwarzSanding),
            "shrestha-water" => return Some(Self::ShresthaWater),
            _ => {}
        }
        if let Some((rail, controller)) = name.strip_prefix("shrestha-").and_then(|rest| rest.split_once('-'))
        {
            let rail = RailCondition::ALL.into_iter().find(|known| known.name() == rail)?;
            let controller = BrakeController::ALL.into_iter().find(|known| known.name() == controller)?;
            return Some(Self::ShresthaStop { rail, controller });
        }
        let (surface, case) = name.strip_prefix("zhao-")?.split_once('-')?;
        let surface = Surface::ALL.into_iter().find(|known| known.name() == surface)?;
        let case: u8 = case.parse().ok().filter(|case| *case <= 4)?;
        Some(Self::Zhao { surface, case })
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::SchwarzWsp => "schwarz-wsp".to_owned(),
            Self::SchwarzSanding => "schwarz-sanding".to_owned(),
            Self::Zhao { surface, case } => format!("zhao-{}-{case}", surface.name()),
            Self::ShresthaStop { rail, controller } => {
                format!("shrestha-{}-{}", rail.name(), controller.name())
            }
            Self::ShresthaWater => "shrestha-water".to_owned(),
        }
    }

    /// What it runs on.
    #[must_use]
    pub const fn plant(self) -> PlantKind {
        match self {
            Self::SchwarzWsp | Self::SchwarzSanding => PlantKind::Roller,
            Self::Zhao { .. } => PlantKind::Traction,
            Self::ShresthaStop { .. } | Self::ShresthaWater => PlantKind::Bogie,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_vehicle::traction_rig::RigParameters;

    #[test]
    fn names_lead_to_programmes_and_back() {
        for name in [
            "schwarz-wsp",
            "schwarz-sanding",
            "zhao-base-0",
            "zhao-oil-4",
            "shrestha-dry-none",
            "shrestha-wet-proposed",
            "shrestha-water",
        ] {
            assert_eq!(RigProgramme::from_name(name).map(RigProgramme::name).as_deref(), Some(name));
        }
        for name in ["zhao-oil-5", "zhao-ice-1", "zhao-oil", "schwarz", "shrestha-ice-none", "shrestha-dry"] {
            assert_eq!(RigProgramme::from_name(name), None);
        }
    }

    #[test]
    fn a_bogie_rigs_file_is_read_and_what_is_wrong_is_named() {
        let rig = BogieRigFile::of("bogie", &railgrip_vehicle::bogie_rig::BogieParameters::default());
        let text = toml::to_string(&rig).expect("text");
        let path = Path::new("rig.toml");
        assert_eq!(parse(path, &text).expect("good"), Plant::Bogie(Box::new(rig)));
        for (good, bad, key) in [
            ("gear_ratio = 7.68", "gear_ratio = 0.0", "drive.gear_ratio"),
            ("roller_window_s = 0.125", "roller_window_s = -1.0", "sensors.roller_window_s"),
            ("friction_at_rest = 0.241", "friction_at_rest = 9.0", "wet.friction_at_rest"),
        ] {
            assert!(text.contains(good), "{text}");
            let said = parse(path, &text.replace(good, bad)).expect_err(key).to_string();
            println!("{said}");
            assert!(said.contains(key) && said.contains("rig.toml:"), "{said}");
        }
    }

    #[test]
    fn a_rigs_file_is_read_and_what_is_wrong_is_named() {
        let rig = TractionRigFile::of("zhao", &RigParameters::new(Surface::Water, f64::INFINITY), 1e-2);
        let text = toml::to_string(&rig).expect("text");
        let path = Path::new("rig.toml");
        assert_eq!(parse(path, &text).expect("good"), Plant::Traction(rig));
        let said = |text: String| parse(path, &text).expect_err("bad").to_string();
        let negative = said(text.replace("normal_load_n = 2000.0", "normal_load_n = -3.0"));
        assert!(
            negative.contains("rig.toml:") && negative.contains("drivetrain.normal_load_n"),
            "{negative}"
        );
        let unknown = said(text.replace("gear_ratio", "gear_rato"));
        assert!(unknown.contains("line") && unknown.contains("gear_rato"), "{unknown}");
        let kind = said(text.replace("\"traction\"", "\"tractor\""));
        assert!(kind.contains("`kind`") && kind.contains("roller"), "{kind}");
    }
}
