//! The reference of a config: every key that there is, read off the types that take the file, with what it takes, its default as the
//! types have it, and what their comments say of it.

mod docs;
mod notes;
pub(crate) mod tracer;

use crate::file::TrainFile;
use crate::reference::tracer::Traced;
use crate::wagons::DEFAULT_CONFIG;
use railgrip_indicators::IndicatorSettings;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A key of a config.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Key {
    /// Dotted; `[]` stands for one of a list of tables, `NAME` for a name that is free.
    pub name: String,
    /// What it takes.
    pub takes: String,
    /// What it is by default, or `required`, or `none`; an example in brackets.
    pub default: String,
    /// What it means, with its unit.
    pub note: String,
}

/// The old form of `receiver`, still read and no longer told.
const OLD: [&str; 1] = ["delivery"];

/// A config of nothing but what is required, with one of each table that may be left out.
const LEAST: &str = r#"
schema = 1
[train]
name = "x"
[[wagon]]
[[microphone]]
wagon = 1
[source]
kind = "simulate"
[mapping.NAME]
from = "x"
[http.tls]
certificate = "x"
key = "x"
[[receiver]]
kind = "webhook"
"#;

/// Every key, in the order of the types.
///
/// # Errors
/// A type that does not say what it takes; a test keeps that from happening.
pub fn keys() -> Result<Vec<Key>, String> {
    let notes = notes::of(DEFAULT_CONFIG);
    let described = docs::all();
    let indicators: BTreeMap<String, &str> = IndicatorSettings::default()
        .entries()
        .into_iter()
        .map(|entry| (format!("indicators.{}", entry.key), entry.words))
        .collect();
    let least: toml::Table = toml::from_str(LEAST).map_err(|error| error.to_string())?;
    let form: TrainFile = toml::from_str(LEAST).map_err(|error| error.to_string())?;
    let whole = toml::Table::try_from(&form).map_err(|error| error.to_string())?;
    let traced = tracer::trace::<TrainFile>("", &OLD).map_err(|error| error.to_string())?;
    let of = |key: Traced| {
        let (example, own_note) = notes.get(&key.name.replace("[]", "")).cloned().unwrap_or_default();
        let field = key.name.rsplit('.').next().unwrap_or_default();
        let documented = described.get(&(key.of, field)).map(String::as_str);
        let words = indicators.get(&key.name).copied().or(documented).unwrap_or_default();
        let note = if words.is_empty() { own_note } else { words.to_owned() };
        let default = match (value(&least, &key.name), value(&whole, &key.name)) {
            (Some(_), _) => "required".to_owned(),
            (None, Some(value)) => value.to_string(),
            (None, None) if example.starts_with('(') => format!("none {example}"),
            (None, None) => "none".to_owned(),
        };
        Key { name: key.name, takes: key.takes, default, note }
    };
    Ok(traced.into_iter().map(of).collect())
}

/// The value of a dotted key; of a list of tables, that of the first.
fn value<'a>(table: &'a toml::Table, name: &str) -> Option<&'a toml::Value> {
    let (first, rest) = name.split_once('.').map_or((name, None), |(first, rest)| (first, Some(rest)));
    let mut value = table.get(first.trim_end_matches("[]"))?;
    if first.ends_with("[]") {
        value = value.as_array()?.first()?;
    }
    match rest {
        None => Some(value),
        Some(rest) => self::value(value.as_table()?, rest),
    }
}

/// The reference as Markdown, one table a section.
///
/// # Errors
/// As [`keys`].
pub fn reference() -> Result<String, String> {
    let mut text = "# Keys of a config\n\nWritten by `railgrip reference` from the types that read the file. `none`: nothing where the key is absent; in brackets an example.\n"
        .to_owned();
    let mut section = None;
    for key in keys()? {
        let (table, name) = key.name.rsplit_once('.').unwrap_or(("", &key.name));
        if section.as_deref() != Some(table) {
            let title =
                if table.is_empty() { "At the top".to_owned() } else { format!("`{}`", heading(table)) };
            // Writing into a string cannot fail.
            let _ =
                write!(text, "\n## {title}\n\n| key | takes | default | note |\n| --- | --- | --- | --- |\n");
            section = Some(table.to_owned());
        }
        let cell = |text: &str| text.replace('|', "\\|");
        let default = if key.default.is_empty() { String::new() } else { format!("`{}`", key.default) };
        let _ =
            writeln!(text, "| `{name}` | {} | {} | {} |", cell(&key.takes), cell(&default), cell(&key.note));
    }
    Ok(text)
}

/// A table as the file writes it.
fn heading(table: &str) -> String {
    match table.split_once("[]") {
        Some((list, more)) => format!("[[{list}]]{more}"),
        None => format!("[{table}]"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_key_is_there_with_its_default_and_note() {
        let keys = keys().expect("every type says what it takes");
        let key = |name: &str| {
            keys.iter().find(|key| key.name == name).unwrap_or_else(|| panic!("{name}: {keys:#?}"))
        };
        assert_eq!(
            key("source.kind").takes,
            "simulate, rig, replay, stdin, tcp, udp, mqtt, can, trdp, external"
        );
        assert_eq!(key("source.speed").takes, "a number");
        assert_eq!(key("source.runs").takes, "a list of texts");
        assert_eq!(
            (key("http.limits.connections").takes.as_str(), key("history.enabled").default.as_str()),
            ("a whole number", "true")
        );
        assert_eq!(key("wagon[].number").default, "none (\"51 80 21-75 019-3\")");
        assert_eq!(key("http.stale_after_s").note, "A wagon without news for so long is stale, s.");
        assert_eq!(
            (key("train.name").default.as_str(), key("source.kind").default.as_str()),
            ("required", "required")
        );
        assert_eq!(key("http.limits.burst").default, "200.0");
        assert_eq!(key("mapping.NAME.from").takes, "a text or a list");
        assert!(
            keys.iter().any(|key| key.name.starts_with("estimator.")),
            "types of other crates are read, too"
        );
        let text = reference().expect("every type says what it takes");
        assert_eq!(key("receiver[].url").takes, "a text");
        for tls in ["source.tls", "receiver[].tls"] {
            assert_eq!(key(tls).takes, "true or false");
        }
        for ca_file in ["source.ca_file", "receiver[].ca_file"] {
            assert_eq!(key(ca_file).takes, "a text");
        }
        assert!(
            text.contains("## `[[wagon]]`")
                && text.contains("## `[[receiver]]`")
                && text.contains("| `hold_ms` | a number |"),
            "{text}"
        );
    }

    /// Most keys once had neither.
    #[test]
    fn every_key_has_a_note_and_a_default() {
        let keys = keys().expect("every type says what it takes");
        let bare: Vec<&str> = keys
            .iter()
            .filter(|key| key.note.len() < 8 || key.default.is_empty())
            .map(|key| key.name.as_str())
            .collect();
        assert!(bare.is_empty(), "{} of {}: {bare:#?}", bare.len(), keys.len());
        let units = [
            ("_ms", "ms"),
            ("_s", "s"),
            ("_m_s", "m/s"),
            ("_rad_s", "rad/s"),
            ("_per_s", "1/s"),
            ("_per_sqrt_s", "√s"),
            ("_hz", "Hz"),
            ("_days", "days"),
            ("_mb", "MB"),
            ("_kb", "kB"),
            ("_db", "dB"),
            ("_hours", "h"),
            ("_km_h", "km/h"),
            ("_m_s2", "m/s²"),
        ];
        let mut silent = Vec::new();
        for key in keys.iter().filter(|key| key.takes.contains("number")) {
            let unit = units.iter().filter(|(ending, _)| key.name.ends_with(ending));
            if let Some((_, unit)) = unit.max_by_key(|(ending, _)| ending.len()) {
                let said = key.note.split(|c: char| !(c.is_alphanumeric() || "/²√".contains(c)));
                if !said.clone().any(|word| word == *unit) {
                    silent.push(format!("{}: {} has no {unit}", key.name, key.note));
                }
            }
        }
        assert!(silent.is_empty(), "{silent:#?}");
    }
}
