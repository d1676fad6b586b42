//! Reads the form of a config so that one mistake hides no other: what cannot be read is noted, and left out or stood in for, and
//! the rest is read.

use crate::SettingsError;
use crate::place::{ConfigText, in_words, line_at, position};
use crate::reference::tracer::{self, Traced};
use serde::de::DeserializeOwned;
use std::ops::Range;
use toml::de::{DeTable, DeValue};
use toml::{Deserializer, Spanned};

/// Most mistakes of the form that are told.
const MOST: usize = 50;

/// Mistakes that are told of a file that is no config at all.
const TOLD_OF_ANOTHER_FILE: usize = 3;

/// Reads the text into the form `T`. Each mistake is noted in `at` with its line, and its key is blamed, so that nobody complains a
/// second time of what was left out or stood in for. `None` where nothing can be made of the text.
pub(crate) fn read<T: DeserializeOwned>(at: &ConfigText<'_>) -> Option<T> {
    let text = without_broken_lines(at)?;
    let mut tree = DeTable::parse(&text).ok()?;
    let kinds = tracer::trace::<T>("", &["delivery"]).unwrap_or_default();
    for _ in 0..MOST {
        let error = match T::deserialize(Deserializer::from(tree.clone())) {
            Ok(form) => return Some(form),
            Err(error) => error,
        };
        let message = in_words(&error);
        let span = error.span().unwrap_or(0..0);
        let missing = message.strip_prefix("missing field `").and_then(|rest| rest.split('`').next());
        let (path, mistake) = match missing {
            Some(field) => {
                let mut path = table_at(tree.get_ref(), &span).unwrap_or_default();
                path.push(field.to_owned());
                let stand_in = DeValue::parse(stand_in(&path, &kinds)).ok()?;
                insert(tree.get_mut(), &path, stand_in);
                (path, true)
            }
            None => match entry_at(tree.get_ref(), &span) {
                Some(path) => {
                    remove(tree.get_mut(), &path);
                    (path, true)
                }
                None => (Vec::new(), false),
            },
        };
        let (line, column) = position(at.text, span.start);
        let key = path.join(".");
        if !at.is_blamed(&key) {
            at.push(SettingsError::Form { file: at.file.to_owned(), line, column, message });
        }
        if !mistake {
            return None;
        }
        at.blame(key);
    }
    None
}

/// The text with lines that are no TOML left blank, each of them noted; `None` where that makes no TOML of it either.
fn without_broken_lines(at: &ConfigText<'_>) -> Option<String> {
    let mut text = at.text.to_owned();
    for _ in 0..MOST {
        let (_, errors) = DeTable::parse_recoverable(&text);
        if errors.is_empty() {
            return Some(text);
        }
        let mut blanks: Vec<Range<usize>> = Vec::new();
        // So many mistakes are another file, not a config.
        let hopeless = errors.len() > MOST;
        for error in errors.iter().take(if hopeless { TOLD_OF_ANOTHER_FILE } else { MOST }) {
            let start = error.span().map_or(0, |span| span.start);
            let line = line_at(&text, start);
            if blanks.contains(&line) {
                continue;
            }
            let (number, column) = position(at.text, start);
            let message = in_words(error);
            at.push(SettingsError::Form { file: at.file.to_owned(), line: number, column, message });
            blanks.push(line);
        }
        if hopeless {
            return None;
        }
        for line in blanks {
            let words = text[line.clone()].trim();
            // Without its header, the keys of a table would fall to the table before it.
            if words.is_empty() || words.starts_with(['[', '#']) {
                return None;
            }
            let name = words.split('=').next().unwrap_or_default().trim().to_owned();
            let table = table_of(&text[..line.start]);
            at.blame(if table.is_empty() { name } else { format!("{table}.{name}") });
            text.replace_range(line.clone(), &" ".repeat(line.len()));
        }
    }
    None
}

/// The table that a text ends in, `wagon.2` for the second `[[wagon]]`.
fn table_of(text: &str) -> String {
    let headers: Vec<&str> = text.lines().map(str::trim).filter(|line| line.starts_with('[')).collect();
    let Some(header) = headers.last() else { return String::new() };
    let header = header.split('#').next().unwrap_or_default().trim();
    let name = header.trim_matches(['[', ']', ' ']);
    if !header.starts_with("[[") {
        return name.to_owned();
    }
    let number = headers.iter().filter(|other| other.starts_with(header)).count();
    format!("{name}.{number}")
}

/// What may stand for a key that is missing, so that the rest can be read.
fn stand_in(path: &[String], kinds: &[Traced]) -> &'static str {
    let fits = |name: &str| {
        let parts: Vec<&str> = name.split('.').collect();
        let own = generic(path);
        parts.len() == own.len() && parts.iter().zip(&own).all(|(part, own)| part == own || *part == "NAME")
    };
    let prefix = format!("{}.", generic(path).join("."));
    match kinds.iter().find(|key| fits(&key.name)) {
        Some(key) => match key.takes.as_str() {
            "true or false" => "true",
            "a number" => "1.0",
            "a whole number" => "1",
            takes if takes.starts_with("a list of ") => "[]",
            takes if takes.starts_with("simulate") => "\"external\"",
            takes if takes.starts_with("webhook") => "\"webhook\"",
            _ => "\"x\"",
        },
        None if kinds.iter().any(|key| key.name.starts_with(&prefix)) => "{}",
        None => "\"x\"",
    }
}

/// A path with `wagon[]` for `wagon.2`, as the reference writes it.
fn generic(path: &[String]) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    for part in path {
        match parts.last_mut() {
            Some(last) if part.bytes().all(|byte| byte.is_ascii_digit()) => last.push_str("[]"),
            _ => parts.push(part.clone()),
        }
    }
    parts
}

/// The innermost table that lies at a place of the text.
fn table_at(table: &DeTable<'_>, span: &Range<usize>) -> Option<Vec<String>> {
    table.iter().find_map(|(name, value)| within(value, name.get_ref(), span))
}

fn within(value: &Spanned<DeValue<'_>>, name: &str, span: &Range<usize>) -> Option<Vec<String>> {
    let after = |mut path: Vec<String>| {
        path.insert(0, name.to_owned());
        path
    };
    match value.get_ref() {
        DeValue::Table(table) => table_at(table, span)
            .map(after)
            .or_else(|| (value.span() == *span).then(|| vec![name.to_owned()])),
        DeValue::Array(items) => {
            let mut numbered = (1..).zip(items.iter());
            numbered.find_map(|(number, item): (usize, _)| within(item, &number.to_string(), span)).map(after)
        }
        _ => None,
    }
}

/// The key or value that lies at a place of the text; of a list of plain values, the whole list.
fn entry_at(table: &DeTable<'_>, span: &Range<usize>) -> Option<Vec<String>> {
    for (name, value) in table {
        let own = || vec![name.get_ref().to_string()];
        if name.span() == *span {
            return Some(own());
        }
        let below = match value.get_ref() {
            DeValue::Table(inner) => entry_at(inner, span),
            DeValue::Array(items) => {
                (1..).zip(items.iter()).find_map(|(number, item): (usize, _)| match item.get_ref() {
                    DeValue::Table(inner) => {
                        let below =
                            entry_at(inner, span).map(|below| [vec![number.to_string()], below].concat());
                        below.or_else(|| (item.span() == *span).then(|| vec![number.to_string()]))
                    }
                    _ => (item.span() == *span).then(Vec::new),
                })
            }
            _ => None,
        };
        if let Some(below) = below {
            return Some([own(), below].concat());
        }
        if value.span() == *span {
            return Some(own());
        }
    }
    None
}

/// The table that holds the last part of a path; the tables on the way are there.
fn holder<'a, 'i>(table: &'a mut DeTable<'i>, path: &[String]) -> Option<&'a mut DeTable<'i>> {
    let Some((first, rest)) = path.split_first().filter(|(_, rest)| !rest.is_empty()) else {
        return Some(table);
    };
    let value = table.get_mut(first.as_str())?.get_mut();
    match value {
        DeValue::Table(inner) => holder(inner, rest),
        DeValue::Array(items) => {
            let (number, rest) = rest.split_first()?;
            let item = items.get_mut(number.parse::<usize>().ok()?.checked_sub(1)?)?;
            match item.get_mut() {
                DeValue::Table(inner) => holder(inner, rest),
                _ => None,
            }
        }
        _ => None,
    }
}

fn remove(table: &mut DeTable<'_>, path: &[String]) {
    let Some((last, before)) = path.split_last() else { return };
    // A table of a list leaves an empty one behind, so that those after it keep their numbers.
    if last.bytes().all(|byte| byte.is_ascii_digit())
        && let Some(list) = before.last()
        && let Some(holder) = holder(table, before)
        && let Some(DeValue::Array(items)) = holder.get_mut(list.as_str()).map(Spanned::get_mut)
    {
        let item = last.parse::<usize>().ok().and_then(|number| items.get_mut(number.wrapping_sub(1)));
        if let Some(item) = item {
            *item.get_mut() = DeValue::Table(DeTable::new());
        }
        return;
    }
    if let Some(holder) = holder(table, path) {
        holder.remove(last.as_str());
    }
}

fn insert<'i>(table: &mut DeTable<'i>, path: &[String], value: Spanned<DeValue<'i>>) {
    if let (Some(last), Some(holder)) = (path.last(), holder(table, path)) {
        holder.insert(Spanned::new(0..0, last.clone().into()), value);
    }
}
