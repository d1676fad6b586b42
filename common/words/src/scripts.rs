//! The words of the scripts in another language.

use super::catalogue::GERMAN;
use super::language::Language;

/// A script with every string in double quotes that is a message put into this language.
#[must_use]
pub fn in_language(script: &str, language: Language) -> String {
    if language == Language::English {
        return script.to_owned();
    }
    let mut text = String::with_capacity(script.len());
    for (index, piece) in script.split('"').enumerate() {
        if index > 0 {
            text.push('"');
        }
        let within = index % 2 == 1;
        text.push_str(if within { GERMAN.exact(piece).unwrap_or(piece) } else { piece });
    }
    text
}
