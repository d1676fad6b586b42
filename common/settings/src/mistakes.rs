//! Everything that is wrong with a config at once, not only the first thing.

use crate::place::ConfigText;
use crate::{Overrides, SettingsError, TrainSettings};
use std::path::Path;

/// Most mistakes that are told.
const MOST: usize = 50;

/// What is wrong with the text of a config, by the line; nothing if it is sound. What is wrong in a table whose header is no TOML
/// shows only once that is mended.
#[must_use]
pub fn mistakes(file: &Path, text: &str, overrides: &Overrides) -> Vec<SettingsError> {
    examine(file, text, overrides).0
}

/// The mistakes, and what could be made of the text in spite of them: good to look at what its other keys name, and for nothing else.
#[must_use]
pub fn examine(
    file: &Path,
    text: &str,
    overrides: &Overrides,
) -> (Vec<SettingsError>, Option<TrainSettings>) {
    let at = ConfigText::new(file, text);
    let settings = TrainSettings::of(&at, overrides);
    (in_order(at.into_found()), settings)
}

/// Refuses a file that a key of a config names, with what is wrong in that file.
#[must_use]
pub fn wrong_file(file: &Path, text: &str, key: &str, problem: impl std::fmt::Display) -> SettingsError {
    ConfigText::new(file, text).refuse_file(key, problem)
}

/// By the line, each once, and no more than somebody reads.
fn in_order(mut found: Vec<SettingsError>) -> Vec<SettingsError> {
    let mut told = std::collections::BTreeSet::new();
    found.retain(|error| told.insert(error.to_string()));
    found.sort_by_key(|error| error.line().unwrap_or(usize::MAX));
    found.truncate(MOST);
    found
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
        assert!(said.iter().any(|said| said.contains("expected a whole number")), "{said:#?}");
    }

    /// A recording that was named in place of a config once took minutes to refuse.
    #[test]
    fn another_file_is_refused_in_few_words() {
        let text = "1.0,2.0,3.0,4.0\n".repeat(20_000);
        let started = std::time::Instant::now();
        let said = mistakes(Path::new("run.csv"), &text, &Overrides::default());
        println!("{} mistakes in {:.2} s", said.len(), started.elapsed().as_secs_f64());
        assert!((1..=4).contains(&said.len()), "{said:#?}");
    }

    #[test]
    fn what_only_fails_later_is_found() {
        let text = include_str!("../../../config/railgrip.toml");
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/railgrip.toml"));
        let start = text.find("[source]").expect("a source");
        let end = start + text[start + 1..].find("\n[").expect("a table after it");
        let listen = |source: &str| {
            let text = format!("{}[source]\n{source}{}", &text[..start], &text[end..]);
            let said = mistakes(path, &text, &Overrides::default());
            said.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        let said = listen("kind = \"tcp\"\nlisten = \"0.0.0.0:8080\"\n");
        assert!(said.iter().any(|said| said.contains("[source] `listen` does not take")), "{said:#?}");
        let said = listen("kind = \"udp\"\nlisten = \"127.0.0.1:8080\"\n");
        assert!(said.is_empty(), "{said:#?}");
        for topic in ["#/x", "a/b+", "a/#/b", "a#"] {
            let said = listen(&format!("kind = \"mqtt\"\nhost = \"localhost\"\ntopic = \"{topic}\"\n"));
            assert!(said.iter().any(|said| said.contains("source.topic")), "{topic}: {said:#?}");
        }
        let said = listen("kind = \"mqtt\"\nhost = \"localhost\"\nport = 0\ntopic = \"a/+/#\"\n");
        assert!(said.len() == 1 && said[0].contains("source.port"), "{said:#?}");
    }
}
