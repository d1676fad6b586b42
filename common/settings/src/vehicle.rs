//! Vehicle files: `vehicle.toml` into [`VehicleParameters`].

use crate::place::on_its_line;
use railgrip_vehicle::{ParameterError, VehicleParameters, WagonModel};
use std::path::{Path, PathBuf};

/// Why a vehicle file was refused.
#[derive(Debug, thiserror::Error)]
pub enum VehicleFileError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not TOML of the expected form; the message names line and key.
    #[error("{}: {message}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// Line, key and what is expected there.
        message: String,
    },
    /// A value is out of its range.
    #[error("{}:{line}: {source}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Line of the key, counted from 1.
        line: usize,
        /// Key, value and range.
        source: ParameterError,
    },
    /// A value of a rig's file is out of its range.
    #[error("{}:{line}: {source}", path.display())]
    Rig {
        /// The file.
        path: PathBuf,
        /// Line of the key, counted from 1.
        line: usize,
        /// Key, value and range.
        source: railgrip_filter::PlantError,
    },
    /// An effect is unknown or its parameters are wrong.
    #[error("{}:{line}: {source}", path.display())]
    Effect {
        /// The file.
        path: PathBuf,
        /// Line of the effect's key, counted from 1.
        line: usize,
        /// Effect and parameter.
        source: railgrip_vehicle::ModelError,
    },
}

/// Reads and checks a vehicle file.
///
/// # Errors
/// A file that cannot be read, an unknown or missing key, a value out of its range, an unknown effect.
pub fn load(path: &Path) -> Result<VehicleParameters, VehicleFileError> {
    let text = railgrip_recording::read_text(path)
        .map_err(|source| VehicleFileError::Read { path: path.to_owned(), source })?;
    parse(path, &text)
}

/// Parses and checks the text of a vehicle file; `path` is for messages only.
///
/// # Errors
/// As [`load`].
pub fn parse(path: &Path, text: &str) -> Result<VehicleParameters, VehicleFileError> {
    let parameters: VehicleParameters = toml::from_str(text).map_err(|error| VehicleFileError::Form {
        path: path.to_owned(),
        message: on_its_line(text, &error),
    })?;
    parameters.check().map_err(|source| VehicleFileError::Value {
        path: path.to_owned(),
        line: line_of_key(text, source.key),
        source,
    })?;
    WagonModel::new(&parameters).map_err(|source| {
        let (id, name) = source.place();
        let line = line_of_effect(text, id, name.unwrap_or("id"));
        VehicleFileError::Effect { path: path.to_owned(), line, source }
    })?;
    Ok(parameters)
}

pub(crate) fn line_of(text: &str, offset: usize) -> usize {
    text[..offset.min(text.len())].matches('\n').count() + 1
}

/// Line of a dotted `table.key`, or 1 where the key stands in another form.
pub(crate) fn line_of_key(text: &str, dotted: &str) -> usize {
    let (table, key) = dotted.rsplit_once('.').unwrap_or(("", dotted));
    let mut current = String::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if let Some(header) = line.strip_prefix('[') {
            current = header.trim_matches(['[', ']', ' ']).to_owned();
        } else if current == table && line.split('=').next().is_some_and(|name| name.trim() == key) {
            return index + 1;
        }
    }
    1
}

/// Line of a key of the `[[effect]]` with that id, also in an inline table; that of the effect where the key is not found.
pub(crate) fn line_of_effect(text: &str, id: &str, key: &str) -> usize {
    let is = |part: &str, name: &str| {
        part.trim_end()
            .strip_suffix(name)
            .is_some_and(|before| before.is_empty() || before.ends_with([' ', '\t', ',', '{', '.']))
    };
    let has = |line: &str, name: &str| line.match_indices('=').any(|(at, _)| is(&line[..at], name));
    let lines: Vec<&str> = text.lines().collect();
    let named = |line: &&str| has(line, "id") && line.contains(&format!("\"{id}\""));
    let at = lines.iter().position(named).unwrap_or(0);
    let end = (at + 1..lines.len()).find(|k| lines[*k].trim() == "[[effect]]").unwrap_or(lines.len());
    let short = key.rsplit('.').next().unwrap_or(key);
    (at..end).find(|k| has(lines[*k], key) || has(lines[*k], short)).unwrap_or(at) + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    const COACH: &str = r#"schema = 1
name = "coach"
[body]
mass_kg = 40000.0
com_height_m = 1.6
wheelbase_m = 10.0
[wheelset]
radius_m = 0.44
inertia_kg_m2 = 120.0
[brake]
radius_m = 0.25
friction_coefficient = 0.35
[resistance]
constant_n = 400.0
linear_n_s_per_m = 8.0
drag_n_s2_per_m2 = 4.0
[contact]
stiffness_n = 6.0e6
k_a = 1.0
k_s = 0.4
[rail]
dry = 0.3
wet = 0.12
low = 0.06
[sensors]
sample_rate_hz = 100.0
speed_sigma_m_s = 0.03
wheel_speed_sigma_rad_s = 0.03
pressing_force_sigma_n = 150.0
"#;

    fn message(text: &str) -> String {
        parse(Path::new("coach.toml"), text).expect_err("must be refused").to_string()
    }

    #[test]
    fn what_has_the_wrong_form_is_named_in_the_words_of_the_file() {
        let said = message(&COACH.replace("mass_kg = 40000.0", "mass_kg = \"40 t\""));
        assert!(said.contains("line 4, mass_kg: ") && said.ends_with("expected a number"), "{said}");
        let said = message(&COACH.replace("dry = 0.3", "dry = 0.3\ndry = 0.4"));
        assert!(said.contains("line 23, dry: duplicate key"), "{said}");
    }

    #[test]
    fn a_good_file_is_read() {
        let vehicle = parse(Path::new("coach.toml"), COACH).expect("good");
        assert_eq!(vehicle.wheelsets(), 2);
        assert_eq!(vehicle.wheelset_positions_m()[..2], [5.0, -5.0]);
    }

    #[test]
    fn negative_mass_names_file_line_key_and_range() {
        let text = COACH.replace("mass_kg = 40000.0", "mass_kg = -3.0");
        assert_eq!(message(&text), "coach.toml:4: `body.mass_kg` is -3, allowed is 100 to 500000");
    }

    #[test]
    fn a_typo_in_a_key_names_line_and_key() {
        let said = message(&COACH.replace("mass_kg", "mas_kg"));
        assert!(said.contains("line 4") && said.contains("mas_kg"), "{said}");
    }

    #[test]
    fn a_missing_key_is_named() {
        let said = message(&COACH.replace("k_s = 0.4\n", ""));
        assert!(said.contains("k_s"), "{said}");
    }

    #[test]
    fn unknown_effects_and_parameters_are_named() {
        let said = message(&format!("{COACH}[[effect]]\nid = \"brake_fad\"\n"));
        assert!(said.contains("brake_fad"), "{said}");
        let said =
            message(&format!("{COACH}[[effect]]\nid = \"brake_fade\"\nparameters = {{ alpha = 1.0 }}\n"));
        assert!(said.contains("`alpha`"), "{said}");
    }

    #[test]
    fn discs_that_outweigh_their_wheelset_are_told_with_line_and_key() {
        let with = |discs: &str| {
            format!(
                "{COACH}[[effect]]\nid = \"axle_torsion\"\n[effect.parameters]\ndisc_inertia_kg_m2 = {discs}\n"
            )
        };
        assert_eq!(
            message(&with("90.0")),
            "coach.toml:33: effect `axle_torsion`: `disc_inertia_kg_m2` is 90, more than the 78.0 that this wagon leaves for it"
        );
        assert!(parse(Path::new("coach.toml"), &with("78.0")).is_ok());
        let inline =
            with("90.0").replace("[effect.parameters]\n", "parameters = { ").replace("90.0\n", "90.0 }\n");
        assert!(message(&inline).starts_with("coach.toml:32: "), "{}", message(&inline));
    }
}
