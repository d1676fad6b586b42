//! Reading scenario files, with errors that name line and key.

use super::Scenario;
use crate::ScenarioError;
use std::path::Path;

/// The scenarios of `config/scenarios`, built in under the names of their files.
pub const BUILT_IN: &[(&str, &str)] = &[
    ("demo", include_str!("../../../../config/scenarios/demo.toml")),
    ("one_wagon_low", include_str!("../../../../config/scenarios/one_wagon_low.toml")),
    ("schwarz_keck_sanding", include_str!("../../../../config/scenarios/schwarz_keck_sanding.toml")),
    ("schwarz_keck_wsp", include_str!("../../../../config/scenarios/schwarz_keck_wsp.toml")),
];

impl Scenario {
    /// The scenario that is meant by the name of a built-in one, or by a file relative to `base`.
    ///
    /// # Errors
    /// Neither a built-in name nor a file; otherwise as [`Scenario::read`].
    pub fn load(name_or_file: &str, base: &Path) -> Result<Self, ScenarioError> {
        let built_in = BUILT_IN.iter().find(|(name, _)| *name == name_or_file);
        let file = base.join(name_or_file);
        match built_in {
            Some((name, text)) => Self::parse(Path::new(&format!("built-in scenario {name}")), text),
            None if file.extension().is_none() && !file.exists() => {
                let names: Vec<&str> = BUILT_IN.iter().map(|(name, _)| *name).collect();
                let name = name_or_file.to_owned();
                Err(ScenarioError::Unknown { name, built_in: names.join(", ") })
            }
            None => Self::read(&file),
        }
    }

    /// Reads and checks a scenario file.
    ///
    /// # Errors
    /// A file that cannot be read, an unknown or missing key, a value out of its range.
    pub fn read(file: &Path) -> Result<Self, ScenarioError> {
        let text = railgrip_recording::read_text(file)
            .map_err(|source| ScenarioError::Read { file: file.to_owned(), source })?;
        Self::parse(file, &text)
    }

    /// Parses and checks the text of a scenario file; `file` is for messages only.
    ///
    /// # Errors
    /// As [`Scenario::read`].
    pub fn parse(file: &Path, text: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = toml::from_str(text).map_err(|error| ScenarioError::Form {
            file: file.to_owned(),
            line: line_at(text, error.span().map_or(0, |span| span.start)),
            message: error.message().replace('\n', "; "),
        })?;
        scenario.check().map_err(|refusal| ScenarioError::Value {
            file: file.to_owned(),
            line: line_of(text, &refusal.key),
            key: refusal.key,
            value: refusal.value,
            allowed: refusal.allowed,
        })?;
        Ok(scenario)
    }
}

fn line_at(text: &str, offset: usize) -> usize {
    text.as_bytes()[..offset.min(text.len())].iter().filter(|byte| **byte == b'\n').count() + 1
}

/// Line of a dotted key such as `brake.fill_time_s` or `rail.2.from_m`, or of its table; 1 where neither stands in the text.
fn line_of(text: &str, dotted: &str) -> usize {
    let mut parts: Vec<&str> = dotted.split('.').collect();
    let key = parts.pop().unwrap_or_default();
    let table = parts.first().copied().unwrap_or_default();
    let wanted: usize = parts.get(1).and_then(|number| number.parse().ok()).unwrap_or(1);
    let (mut current, mut count, mut table_line) = ("", 0, 1);
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.starts_with('[') {
            current = line.split(']').next().unwrap_or_default().trim_start_matches('[').trim();
            count += usize::from(current == table);
            if current == table && count == wanted {
                table_line = index + 1;
            }
        } else if current == table
            && (table.is_empty() || count == wanted)
            && line.split('=').next().is_some_and(|name| name.trim() == key)
        {
            return index + 1;
        }
    }
    table_line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_scenario_is_good() {
        for (name, _) in BUILT_IN {
            let scenario = Scenario::load(name, Path::new("")).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(scenario.name, *name);
        }
        let error = Scenario::load("dema", Path::new("/nowhere")).expect_err("unknown").to_string();
        assert!(error.contains("`dema`") && error.contains("demo, one_wagon_low"), "{error}");
        let error = Scenario::load("dema.toml", Path::new("/nowhere")).expect_err("absent").to_string();
        assert!(error.starts_with("/nowhere/dema.toml: "), "{error}");
    }

    #[test]
    fn keys_are_found_in_lists_of_tables() {
        let text = "schema = 1\n[brake]\nfill_time_s = 1\n[[rail]]\nfrom_m = 0\n[[rail]] # low\nfrom_m = 9\n";
        assert_eq!(line_of(text, "schema"), 1);
        assert_eq!(line_of(text, "brake.fill_time_s"), 3);
        assert_eq!(line_of(text, "rail.2.from_m"), 7);
        assert_eq!(line_of(text, "rail.2.adhesion"), 6);
        assert_eq!(line_of(text, "wsp.hold_slip"), 1);
    }
}
