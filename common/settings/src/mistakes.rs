//! Everything that is wrong with a config at once, not only the first thing: each line that is to blame is left out, and the rest
//! is looked at again.

use crate::{Overrides, SettingsError, TrainSettings};
use std::path::Path;

/// Most mistakes that are told.
const MOST: usize = 50;

/// What is wrong with the text of a config, in the order in which it is found; nothing if it is sound. What hides behind a key that
/// is absent shows only once the key is there.
#[must_use]
pub fn mistakes(file: &Path, text: &str, overrides: &Overrides) -> Vec<SettingsError> {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut found = Vec::new();
    while found.len() < MOST {
        let Err(error) = TrainSettings::parse(file, &lines.join("\n"), overrides) else { break };
        let blamed = line_of(&error).and_then(|line| line.checked_sub(1)).filter(|at| *at < lines.len());
        found.push(error);
        // Without its header, the keys of a table would fall to the table before it.
        match blamed.map(|at| &mut lines[at]) {
            Some(line) if !line.trim_start().starts_with(['[', '#']) && !line.trim().is_empty() => {
                line.insert(0, '#');
            }
            _ => break,
        }
    }
    found
}

/// The line of this file that is to blame.
fn line_of(error: &SettingsError) -> Option<usize> {
    match error {
        SettingsError::Form { line, .. } => Some(*line),
        SettingsError::Value { line, value, .. } if value != "absent" => Some(*line),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_mistakes_are_found_each_with_its_line() {
        let text = include_str!("../../../config/railgrip.toml");
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/railgrip.toml"));
        assert!(mistakes(path, text, &Overrides::default()).is_empty());
        let wrong = text
            .replace("health_rate_hz = 5.0", "health_rate_hz = 5000.0")
            .replace("refresh_ms = 150.0", "refresh_sm = 150.0")
            .replace("flush_s = 30.0", "flush_s = -1.0")
            .replace("seed = 1", "seed = \"one\"");
        let said: Vec<String> =
            mistakes(path, &wrong, &Overrides::default()).iter().map(ToString::to_string).collect();
        for (line, key) in [
            ("seed", "invalid type"),
            ("refresh_sm", "refresh_sm"),
            ("flush_s", "history.flush_s"),
            ("health_rate_hz", "reporting.health_rate_hz"),
        ] {
            let number = 1 + wrong.lines().position(|text| text.starts_with(line)).expect(line);
            let told = said
                .iter()
                .any(|said| said.contains(&format!("railgrip.toml:{number}:")) && said.contains(key));
            assert!(told, "{line} in line {number}: {said:#?}");
        }
        assert_eq!(said.len(), 4, "{said:#?}");
    }
}
