//! What the default config says of its keys: `key = value   # note`, the note going on in lines of nothing but a comment further
//! in. A line that is commented out as a whole shows a key that is off, or an example.

use std::collections::BTreeMap;

/// Default and note of each dotted key.
pub(super) fn of(config: &str) -> BTreeMap<String, (String, String)> {
    let mut notes: BTreeMap<String, (String, String)> = BTreeMap::new();
    let mut table = String::new();
    let mut last: Option<String> = None;
    for line in config.lines() {
        let indented = line.starts_with(' ');
        let (off, text) = match line.trim().strip_prefix("# ") {
            Some(text) if !indented => (true, text),
            _ => (false, line.trim()),
        };
        if indented && let Some(more) = text.strip_prefix("# ") {
            if let Some((_, note)) = last.as_ref().and_then(|name| notes.get_mut(name)) {
                *note = format!("{note} {more}").trim().to_owned();
            }
            continue;
        }
        last = None;
        if let Some(header) = text.strip_prefix('[') {
            let end = header.find(']').unwrap_or(header.len());
            table = header[..end].trim_start_matches('[').to_owned();
            continue;
        }
        let Some((name, rest)) = text.split_once(" = ") else { continue };
        if name.is_empty() || !name.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'_') {
            continue;
        }
        let (value, note) = rest.split_once(" #").unwrap_or((rest, ""));
        let value = value.trim();
        let default = if off { format!("({value})") } else { value.to_owned() };
        let full = if table.is_empty() { name.to_owned() } else { format!("{table}.{name}") };
        notes.insert(full.clone(), (default, note.trim().to_owned()));
        last = Some(full);
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_examples_and_long_notes_are_found() {
        let text = "# A title = of the file.\nschema = 1\n\n[train]\nname = \"x\"   # a name\n    # of letters\n# coupled = true # when\n\
                    # [[wagon]]   # one each\n# number = \"5\"\n";
        let notes = of(text);
        let of = |name: &str| notes.get(name).cloned().unwrap_or_default();
        assert_eq!(of("schema"), ("1".into(), String::new()));
        assert_eq!(of("train.name"), ("\"x\"".into(), "a name of letters".into()));
        assert_eq!(of("train.coupled"), ("(true)".into(), "when".into()));
        assert_eq!(of("wagon.number").0, "(\"5\")");
        assert_eq!(notes.len(), 4);
    }
}
