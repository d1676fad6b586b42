//! Numbers as a language writes them.

use super::language::Language;
use super::spoken::spoken;

/// Swaps the decimal point of a number for the mark of the language; anything else stays as it is. `−1.25 %` is a number.
pub fn localised(text: &str) -> String {
    match spoken() {
        Language::German if is_number(text) => text.replace('.', ","),
        _ => text.to_owned(),
    }
}

/// Units that may stand behind a number.
const UNITS: [&str; 16] =
    ["%", "s", "min", "h", "m", "km", "m/s", "km/h", "N", "kN", "J", "kJ", "MJ", "K", "µs", "Hz"];

/// Digits with at most one point, perhaps in groups with narrow spaces between, with a sign before and a unit behind.
pub(super) fn is_number(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-', '−', '±', '≥', '<', ' ']);
    let end =
        digits.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '\u{202f}'))).unwrap_or(digits.len());
    let (digits, unit) = digits.split_at(end);
    digits.starts_with(|c: char| c.is_ascii_digit())
        && digits.matches('.').count() <= 1
        && !digits.ends_with('.')
        && (unit.is_empty() || UNITS.contains(&unit.trim()))
}
