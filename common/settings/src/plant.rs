//! Vehicle and rig files: what a filter watches, by the file's `kind`.

use crate::vehicle::{self, VehicleFileError, line_of, line_of_key};
use railgrip_filter::{Plant, PlantError, RollerRigFile, TractionRigFile};
use railgrip_vehicle::traction_rig::Surface;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Reads and checks a vehicle file, or a rig's file.
///
/// # Errors
/// A file that cannot be read, an unknown or missing key, a value out of its range.
pub fn load(path: &Path) -> Result<Plant, VehicleFileError> {
    let text = std::fs::read_to_string(path)
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
        Some(_) => {
            let value = kind.map_or_else(String::new, |kind| kind.to_string());
            let error = PlantError {
                key: "kind",
                value,
                allowed: "\"roller\", \"traction\", or no such key for a wagon",
            };
            Err(self::value(path, text, error))
        }
    }
}

fn form<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, VehicleFileError> {
    toml::from_str(text).map_err(|error| VehicleFileError::Form {
        path: path.to_owned(),
        message: match error.span() {
            Some(span) => format!("line {}: {}", line_of(text, span.start), error.message()),
            None => error.message().to_owned(),
        },
    })
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
}

impl RigProgramme {
    /// The names, for people.
    pub const NAMES: &'static str =
        "schwarz-wsp, schwarz-sanding, zhao-SURFACE-CASE with SURFACE base, water or oil and CASE 0 to 4";

    /// The programme of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "schwarz-wsp" => return Some(Self::SchwarzWsp),
            "schwarz-sanding" => return Some(Self::SchwarzSanding),
            _ => {}
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
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_vehicle::traction_rig::RigParameters;

    #[test]
    fn names_lead_to_programmes_and_back() {
        for name in ["schwarz-wsp", "schwarz-sanding", "zhao-base-0", "zhao-oil-4"] {
            assert_eq!(RigProgramme::from_name(name).map(RigProgramme::name).as_deref(), Some(name));
        }
        for name in ["zhao-oil-5", "zhao-ice-1", "zhao-oil", "schwarz"] {
            assert_eq!(RigProgramme::from_name(name), None);
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
