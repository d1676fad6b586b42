//! The reference of a config: every key that there is, read off the types that take the file, with what it takes, its default and a note
//! from the default config, which comments its keys.

mod notes;
pub(crate) mod tracer;

use crate::file::TrainFile;
use crate::wagons::DEFAULT_CONFIG;
use std::fmt::Write as _;

/// A key of a config.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Key {
    /// Dotted; `[]` stands for one of a list of tables, `NAME` for a name that is free.
    pub name: String,
    /// What it takes.
    pub takes: String,
    /// What it is by default, where the default config says so.
    pub default: String,
    /// What it means, where the default config says so.
    pub note: String,
}

/// The old form of `receiver`, still read and no longer told.
const OLD: [&str; 1] = ["delivery"];

/// Every key, in the order of the types.
///
/// # Errors
/// A type that does not say what it takes; a test keeps that from happening.
pub fn keys() -> Result<Vec<Key>, String> {
    let notes = notes::of(DEFAULT_CONFIG);
    let noted = |(name, takes): (String, String)| {
        let (default, note) = notes.get(&name.replace("[]", "")).cloned().unwrap_or_default();
        Key { name, takes, default, note }
    };
    let traced = tracer::trace::<TrainFile>("", &OLD).map_err(|error| error.to_string())?;
    let keys = traced.into_iter().map(noted).collect();
    Ok(keys)
}

/// The reference as Markdown, one table a section.
///
/// # Errors
/// As [`keys`].
pub fn reference() -> Result<String, String> {
    let mut text = "# Keys of a config\n\nWritten by `railgrip reference` from the types that read the file. A default in brackets is only an example.\n"
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
        assert_eq!(key("wagon[].number").default, "(\"51 80 21-75 019-3\")");
        assert_eq!(key("http.stale_after_s").note, "a wagon without news for so long is stale");
        assert_eq!(key("mapping.NAME.from").takes, "a text or a list");
        assert!(
            key("train.vehicle").note.ends_with("what the estimator is not told"),
            "{:?}",
            key("train.vehicle")
        );
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
}
