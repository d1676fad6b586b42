//! One number of the config file, changed in place.

use super::file::{CHANGED, ChangeError, document, noted, rewrite};
use railgrip_indicators::IndicatorSettings;
use std::path::Path;
use toml_edit::{Item, Table, value};

/// Changes `key` (dotted, below `[indicators]`) in the config file to `new`, with `note` as a comment above it. Everything
/// else in the file stays as it is.
///
/// # Errors
/// An unknown key, a value that the check of the whole file refuses, or a file that cannot be read or written. The file is
/// then as before.
pub fn change(file: &Path, key: &str, new: f64, note: &str) -> Result<(), ChangeError> {
    let known = IndicatorSettings::default().entries().into_iter().any(|entry| entry.key == key);
    let (table, name) =
        key.split_once('.').filter(|_| known).ok_or_else(|| ChangeError::Unknown(key.to_owned()))?;
    rewrite(file, |text| edit(text, table, name, new, note))
}

fn edit(text: &str, table: &str, name: &str, new: f64, note: &str) -> Result<String, ChangeError> {
    let form = |words: String| ChangeError::Form(words);
    let mut document = document(text)?;
    let no_table = || form(format!("[indicators.{table}] is no table"));
    let implicit = || {
        let mut table = Table::new();
        table.set_implicit(true);
        Item::Table(table)
    };
    let indicators = document.entry("indicators").or_insert_with(implicit);
    let indicators = indicators.as_table_like_mut().ok_or_else(no_table)?;
    let inner = indicators.entry(table).or_insert_with(|| Item::Table(Table::new()));
    let Some(inner) = inner.as_table_mut() else {
        return Err(form(format!(
            "`indicators.{table}` is written in one line; make it a table of its own to change it here"
        )));
    };
    // Whatever stood behind the value, such as a comment, stays there.
    let behind = inner.get(name).and_then(Item::as_value).and_then(|old| old.decor().suffix().cloned());
    let mut item = value(new);
    if let (Some(behind), Some(changed)) = (behind, item.as_value_mut()) {
        changed.decor_mut().set_suffix(behind);
    }
    match inner.get_mut(name) {
        Some(old) => *old = item,
        None => {
            inner.insert(name, item);
        }
    }
    if let Some(mut key) = inner.key_mut(name) {
        let before = key.leaf_decor().prefix().and_then(|raw| raw.as_str()).unwrap_or_default().to_owned();
        key.leaf_decor_mut().set_prefix(noted(&before, CHANGED, note));
    }
    Ok(document.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_settings::{Overrides, TrainSettings};

    const FILE: &str = "# the train\n[indicators.brake_friction]\n# after the trial of May\nratio_watch_low = 0.85 # was 0.8\n\n[alerts]\nraise_after_s = 3.0\n";

    #[test]
    fn comments_and_order_stay_and_one_line_says_who() {
        let once = edit(FILE, "brake_friction", "ratio_watch_low", 0.8, "changed from 0.85 by kim").unwrap();
        assert_eq!(
            once,
            "# the train\n[indicators.brake_friction]\n# after the trial of May\n# changed from 0.85 by kim\nratio_watch_low = 0.8 # was 0.8\n\n[alerts]\nraise_after_s = 3.0\n"
        );
        let twice = edit(&once, "brake_friction", "ratio_watch_low", 0.9, "changed from 0.8 by lee").unwrap();
        assert!(
            twice.contains("by lee\nratio_watch_low = 0.9 # was 0.8") && !twice.contains("by kim"),
            "{twice}"
        );
    }

    #[test]
    fn tables_that_are_missing_are_added() {
        let added =
            edit("[alerts]\nraise_after_s = 3.0\n", "wsp", "share_act", 0.7, "changed from 0.75 by kim")
                .unwrap();
        let table: toml::Table = added.parse().unwrap();
        assert_eq!(table["indicators"]["wsp"]["share_act"].as_float(), Some(0.7), "{added}");
        assert_eq!(table["alerts"]["raise_after_s"].as_float(), Some(3.0));
    }

    #[test]
    fn what_the_file_would_be_refused_for_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("train.toml");
        let text = "schema = 1\n[train]\nname = \"t\"\nwagons = 2\nvehicle = \"vehicle.toml\"\n[source]\nkind = \"stdin\"\n";
        let vehicle = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/vehicle.toml");
        std::fs::copy(vehicle, folder.path().join("vehicle.toml")).unwrap();
        std::fs::write(&file, text).unwrap();
        assert!(TrainSettings::parse(&file, text, &Overrides::default()).is_ok(), "the test's own config");
        for (key, new) in
            [("brake_friction.ratio_watch_low", 1.5), ("brake_friction.ratio_watch_low", 0.6), ("x.y", 1.0)]
        {
            assert!(change(&file, key, new, "changed from 0.85 by kim").is_err(), "{key} {new}");
            assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
        }
        change(&file, "brake_friction.ratio_watch_low", 0.9, "changed from 0.85 by kim").unwrap();
        let changed = TrainSettings::load(Some(&file), &Overrides::default()).unwrap();
        assert_eq!(changed.indicators.brake_friction.ratio_watch_low, 0.9);
    }
}
