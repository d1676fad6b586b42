//! What the comments of the types say of their fields, read off the source that declares them.

use std::collections::BTreeMap;

/// The files that declare types of a config.
const SOURCES: [&str; 15] = [
    include_str!("../file.rs"),
    include_str!("../access.rs"),
    include_str!("../alerts.rs"),
    include_str!("../capability.rs"),
    include_str!("../diagnosis.rs"),
    include_str!("../history.rs"),
    include_str!("../instance.rs"),
    include_str!("../mapping.rs"),
    include_str!("../microphones.rs"),
    include_str!("../receivers/mod.rs"),
    include_str!("../receivers/table.rs"),
    include_str!("../source.rs"),
    include_str!("../topics.rs"),
    include_str!("../../../filter/src/config.rs"),
    include_str!("../../../indicators/src/settings/mod.rs"),
];

/// What is said of each field, by type and key.
pub(super) fn all() -> BTreeMap<(&'static str, &'static str), String> {
    let mut found = BTreeMap::new();
    SOURCES.iter().for_each(|source| read(source, &mut found));
    found
}

fn read(source: &'static str, found: &mut BTreeMap<(&'static str, &'static str), String>) {
    let mut of = "";
    let (mut words, mut renamed) = (String::new(), None);
    for line in source.lines() {
        if let Some((_, rest)) = line.split_once("struct ").filter(|(before, _)| before.len() < 12) {
            of = rest.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
        } else if line.starts_with('}') {
            of = "";
        }
        let line = line.trim();
        if let Some(more) = line.strip_prefix("///") {
            words = format!("{words} {}", more.trim()).trim().to_owned();
        } else if let Some(rest) = line.strip_prefix("#[serde(rename = \"") {
            renamed = rest.split('"').next();
        } else if !line.starts_with("#[") {
            let name = line.trim_start_matches("pub(crate) ").trim_start_matches("pub ").split(':').next();
            let name = renamed.take().or(name).unwrap_or_default();
            if !of.is_empty() && !words.is_empty() && !name.is_empty() {
                found.insert((of, name), std::mem::take(&mut words));
            }
            words.clear();
        }
    }
}
