//! Finds keys in the text of a config file, so that an error about a value can name its line.

use crate::SettingsError;
use std::cell::RefCell;
use std::fmt::Display;
use std::ops::{Range, RangeInclusive};
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A config file while it is checked, and what was found wrong with it so far.
pub(crate) struct ConfigText<'a> {
    /// Its path, for messages.
    pub file: &'a Path,
    /// What it says.
    pub text: &'a str,
    found: RefCell<Vec<SettingsError>>,
    /// Dotted keys of which something wrong is known.
    blamed: RefCell<Vec<String>>,
}

impl<'a> ConfigText<'a> {
    /// Nothing is found yet.
    pub const fn new(file: &'a Path, text: &'a str) -> Self {
        Self { file, text, found: RefCell::new(Vec::new()), blamed: RefCell::new(Vec::new()) }
    }

    /// Everything that was noted, in the order in which it was found.
    pub fn into_found(self) -> Vec<SettingsError> {
        self.found.into_inner()
    }

    /// Notes a mistake, unless its key is blamed already: it would be one that does not exist.
    pub fn note(&self, error: SettingsError) {
        if let SettingsError::Value { key, .. } | SettingsError::Named { key, .. } = &error {
            if self.is_blamed(key) {
                return;
            }
            self.blame(key.clone());
        }
        self.push(error);
    }

    /// Notes a mistake as it is.
    pub fn push(&self, error: SettingsError) {
        self.found.borrow_mut().push(error);
    }

    /// Something is wrong with this key.
    pub fn blame(&self, key: String) {
        self.blamed.borrow_mut().push(key);
    }

    /// Whether something is wrong with this key, or with a table that it lies in.
    pub fn is_blamed(&self, key: &str) -> bool {
        let above = |blamed: &String| key.strip_prefix(blamed.as_str()).is_some_and(below_or_same);
        self.blamed.borrow().iter().any(above)
    }

    /// Whether something is wrong with this table or with any key in it.
    pub fn doubts(&self, table: &str) -> bool {
        let inside = |blamed: &String| blamed.strip_prefix(table).is_some_and(below_or_same);
        self.is_blamed(table) || self.blamed.borrow().iter().any(inside)
    }

    /// What was found, or `otherwise` with the mistake noted, so that the rest is looked at, too.
    pub fn or<T>(&self, found: Result<T, SettingsError>, otherwise: T) -> T {
        found.unwrap_or_else(|error| {
            self.note(error);
            otherwise
        })
    }

    /// Parses the text into the form `T`.
    pub fn parse<T: serde::de::DeserializeOwned>(&self) -> Result<T, SettingsError> {
        toml::from_str(self.text).map_err(|error| {
            let (line, column) = position(self.text, error.span().map_or(0, |span| span.start));
            let message = in_words(&error);
            SettingsError::Form { file: self.file.to_owned(), line, column, message }
        })
    }

    /// A path that the file gives, relative to the folder of the file.
    pub fn beside(&self, path: &str) -> PathBuf {
        self.file.parent().unwrap_or(Path::new("")).join(path)
    }

    /// Refuses the value of a dotted key such as `http.listen` or `wagon.2.name`.
    pub fn refuse(&self, key: &str, value: impl Display, allowed: impl Display) -> SettingsError {
        SettingsError::Value {
            file: self.file.to_owned(),
            line: line_of(self.text, key),
            key: key.to_owned(),
            value: value.to_string(),
            allowed: allowed.to_string(),
        }
    }

    /// Refuses a file that a key names, with what is wrong in that file.
    pub fn refuse_file(&self, key: &str, problem: impl Display) -> SettingsError {
        SettingsError::Named {
            file: self.file.to_owned(),
            line: line_of(self.text, key),
            key: key.to_owned(),
            problem: problem.to_string(),
        }
    }

    /// Passes a number that lies in its range.
    pub fn within(&self, key: &str, value: f64, range: RangeInclusive<f64>) -> Result<f64, SettingsError> {
        if range.contains(&value) {
            return Ok(value);
        }
        Err(self.refuse(key, value, format!("{} to {}", range.start(), range.end())))
    }

    /// A number, noted where it lies outside its range.
    pub fn number(&self, key: &str, value: f64, range: RangeInclusive<f64>) -> f64 {
        let least = *range.start();
        self.or(self.within(key, value, range), least)
    }
}

/// What follows a key's name, where that is the same key or one below it.
fn below_or_same(rest: &str) -> bool {
    rest.is_empty() || rest.starts_with(['.', '['])
}

/// The line around a place of the text, without its end.
pub(crate) fn line_at(text: &str, offset: usize) -> Range<usize> {
    let offset = text.floor_char_boundary(offset);
    let start = text[..offset].rfind('\n').map_or(0, |newline| newline + 1);
    let end = text[offset..].find('\n').map_or(text.len(), |newline| offset + newline);
    start..end
}

/// Line and column of a place of the text, counted from 1.
pub(crate) fn position(text: &str, offset: usize) -> (usize, usize) {
    let before = &text[..text.floor_char_boundary(offset)];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// Line of a dotted key, or of the innermost table on the way to it; 1 if nothing of it is there.
fn line_of(text: &str, dotted: &str) -> usize {
    let Ok(root) = DeTable::parse(text) else { return 1 };
    let mut offset = 0;
    let mut parts = dotted.split('.');
    let Some((key, value)) = parts.next().and_then(|part| root.get_ref().get_key_value(part)) else {
        return 1;
    };
    offset = offset.max(key.span().start);
    let mut value: &Spanned<DeValue<'_>> = value;
    for part in parts {
        let next = match value.get_ref() {
            DeValue::Table(table) => table.get_key_value(part).map(|(key, value)| (key.span().start, value)),
            DeValue::Array(array) => part
                .parse::<usize>()
                .ok()
                .and_then(|number| array.get(number.wrapping_sub(1)))
                .map(|value| (value.span().start, value)),
            _ => None,
        };
        let Some((start, inner)) = next else { break };
        (offset, value) = (start, inner);
    }
    position(text, offset).0
}

/// Letters, digits, `-`, `_` and `.`, at most 32 of them: fit for names of files.
pub(crate) fn name(at: &ConfigText<'_>, key: &str, name: &str) -> Result<String, SettingsError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    if (1..=32).contains(&name.len()) && name.chars().all(plain) && !name.starts_with('.') {
        return Ok(name.to_owned());
    }
    Err(at.refuse(key, format!("{name:?}"), "1 to 32 letters, digits, `-`, `_`, `.`"))
}

/// The folder that paths in a file are relative to.
pub(crate) fn folder(file: &Path) -> PathBuf {
    file.parent().map_or_else(PathBuf::new, Path::to_owned)
}

/// What is wrong with the form of a text, on one line and in the words of whoever writes configs, not of whoever writes Rust.
pub(crate) fn in_words(error: &toml::de::Error) -> String {
    let mut message = error.message().replace('\n', "; ").replace(" as i128", "");
    for (of_rust, in_words) in [
        ("f64", "a number"),
        ("u8", "a whole number, not negative"),
        ("u16", "a whole number, 0 to 65535"),
        ("u32", "a whole number, not negative"),
        ("u64", "a whole number, not negative"),
        ("usize", "a whole number, not negative"),
        ("i64", "a whole number"),
        ("a boolean", "true or false"),
        ("a sequence", "a list"),
        ("a map", "a table"),
    ] {
        if let Some(before) = message.strip_suffix(&format!("expected {of_rust}")) {
            message = format!("{before}expected {in_words}");
        }
    }
    message
}

/// The same with the line and the key that it stands in.
pub(crate) fn on_its_line(text: &str, error: &toml::de::Error) -> String {
    let Some(span) = error.span() else { return in_words(error) };
    let (line, _) = position(text, span.start);
    let words = text.lines().nth(line - 1).and_then(|line| line.split_once('='));
    match words.map(|(key, _)| key.trim()).filter(|key| !key.is_empty() && key.len() < 60) {
        Some(key) => format!("line {line}, {key}: {}", in_words(error)),
        None => format!("line {line}: {}", in_words(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_in_tables_and_lists() {
        let text =
            "a = 1\n[http]\n# note\nlisten = \"x\"\n[[wagon]]\nname = \"one\"\n[[wagon]]\nname = \"two\"\n";
        assert_eq!(line_of(text, "http.listen"), 4);
        assert_eq!(line_of(text, "http.absent"), 2);
        assert_eq!(line_of(text, "wagon.2.name"), 8);
        assert_eq!(line_of(text, "nothing.here"), 1);
        assert_eq!(position("ab\nµx", 5), (2, 2));
    }
}
