//! Messages as they are said: by themselves, filled in, or found again in a sentence.

use super::catalogue::{GERMAN, german};
use super::language::Language;
use super::number::localised;
use super::pattern::{self, Piece};
use super::spoken::spoken;
use std::fmt::Display;

/// A message without arguments.
#[must_use]
pub fn t(message: &'static str) -> &'static str {
    match spoken() {
        Language::English => message,
        Language::German => GERMAN.exact(message).unwrap_or(message),
    }
}

/// A message filled in; numbers are written as the language does.
#[must_use]
pub fn say(message: &'static str, arguments: &[(&str, &dyn Display)]) -> String {
    let written: Vec<(&str, String)> =
        arguments.iter().map(|(name, value)| (*name, localised(&value.to_string()))).collect();
    pattern::fill(t(message), |name| {
        written.iter().find(|(other, _)| *other == name).map_or("", |(_, text)| text.as_str())
    })
}

/// A word or a name that was made elsewhere; what is no message of the table stays as it is.
#[must_use]
pub fn word(text: &str) -> String {
    match spoken() {
        Language::English => text.to_owned(),
        Language::German => GERMAN.exact(text).unwrap_or(text).to_owned(),
    }
}

/// A message in its parts.
#[must_use]
pub fn pieces(message: &'static str) -> Vec<Piece> {
    pattern::pieces(t(message)).collect()
}

/// A sentence that was made elsewhere, in English; what is no message of the table stays as it is.
#[must_use]
pub fn reword(sentence: &str) -> String {
    match spoken() {
        Language::English => sentence.to_owned(),
        Language::German => german(sentence).unwrap_or_else(|| sentence.to_owned()),
    }
}
