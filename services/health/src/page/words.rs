//! Figures, ages and grades as people read them. Every grade has a word and a shape, never a colour alone.

use crate::api::figure::Figure;
use crate::api::grade::{Condition, DataState, Grade};
use crate::time::parse_rfc3339;
use maud::{Markup, html};
use railgrip_causes::Cause;
use railgrip_indicators::{Form, INDICATORS, IndicatorSpec};
use railgrip_words::{localised, reword, say, t};

/// What stands for something unknown.
pub(super) const NOTHING: &str = "–";

/// A number with a fixed count of decimals, with a true minus sign.
pub(super) fn number(value: f64, digits: usize) -> String {
    let text = localised(&format!("{value:.digits$}"));
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.' | ',')) => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

/// A number that may be unknown.
pub(super) fn maybe(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| NOTHING.to_owned(), |value| number(value, digits))
}

/// Writes figures in the form that the table of indicators gives them.
pub(super) trait Written {
    /// The figure with its unit.
    fn value(self, value: Option<f64>) -> String;
    /// `0.344 to 0.367`, or nothing if there is no interval.
    fn interval(self, figure: &Figure) -> Option<String>;
}

impl Written for Form {
    fn value(self, value: Option<f64>) -> String {
        let Some(value) = value else { return NOTHING.to_owned() };
        format!("{}{}", number(value * self.factor, self.digits), self.unit)
    }

    fn interval(self, figure: &Figure) -> Option<String> {
        let (low, high) = (figure.low?, figure.high?);
        if low == high {
            return None;
        }
        let end = |value: f64| number(value * self.factor, self.digits);
        Some(say("{low} to {high}", &[("low", &end(low)), ("high", &format!("{}{}", end(high), self.unit))]))
    }
}

/// An energy in a unit that keeps it short.
pub(super) fn energy(joules: f64) -> String {
    match joules {
        energy if energy >= 1e6 => format!("{}\u{202f}MJ", number(energy / 1e6, 2)),
        energy if energy >= 1e3 => format!("{}\u{202f}kJ", number(energy / 1e3, 0)),
        energy => format!("{}\u{202f}J", number(energy, 0)),
    }
}

/// An age: `< 1 s`, `12 s`, `3 min`, `5 h`, `2 days`.
pub(super) fn age(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => t("< 1 s").to_owned(),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", (s / 60.0).floor()),
        s if s < 172_800.0 => format!("{:.0} h", (s / 3600.0).floor()),
        s => say("{count} days", &[("count", &(s / 86_400.0).floor())]),
    }
}

/// `wheelset 2`.
pub(super) fn wheelset(number: u32) -> String {
    say("wheelset {number}", &[("number", &number)])
}

/// The number of a vehicle beside the wagon that it is.
pub(super) fn vehicle(number: Option<&str>) -> Markup {
    html! { @if let Some(number) = number { " " small .vehicle { (number) } } }
}

/// A name of the interface for people: `brake_friction` becomes `brake friction`.
pub(super) fn plain(name: &str) -> String {
    name.replace('_', " ")
}

/// What an indicator or the cause of an alert is called on the pages: the heading of its meaning, or its id in words.
pub(super) fn named(id: &str) -> String {
    let spec = INDICATORS.iter().find(|spec| spec.id == id).map(IndicatorSpec::name);
    let name = spec.or_else(|| Cause::from_word(id).map(Cause::title));
    name.map_or_else(|| sentence(&plain(id)), |name| t(name).to_owned())
}

/// A sentence of the service, such as a reason, in the language of the page and with a large letter at its start.
pub(super) fn sentence(text: &str) -> String {
    capital(&reword(text))
}

/// The same at the start of a sentence.
pub(super) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The shape of a grade: a tick, a triangle, an octagon, a question mark.
pub(super) fn icon(grade: Grade) -> Markup {
    let path = match grade {
        Grade::Ok => "M8 1a7 7 0 1 0 0 14A7 7 0 0 0 8 1ZM7 11.4 3.9 8.3l1.2-1.2L7 9l4-4.1 1.2 1.2Z",
        Grade::Watch => "M8 1 .6 14.5h14.8ZM7.1 6h1.8v4.2H7.1Zm0 5.2h1.8V13H7.1Z",
        Grade::Act => "M5 .8h6L15.2 5v6L11 15.2H5L.8 11V5ZM7.1 3.6h1.8v5.6H7.1Zm0 6.8h1.8v1.9H7.1Z",
        Grade::Unknown => {
            "M8 1a7 7 0 1 0 0 14A7 7 0 0 0 8 1Zm0 1.5a5.5 5.5 0 1 1 0 11 5.5 5.5 0 0 1 0-11ZM4.8 7.2h6.4v1.6H4.8Z"
        }
    };
    html! { svg .icon viewBox="0 0 16 16" aria-hidden="true" { path fill-rule="evenodd" d=(path) {} } }
}

/// A grade as a chip: shape, word and colour. The style sheet puts the shape there, which spares a long train many nodes.
pub(super) fn chip(grade: Grade) -> Markup {
    html! { span class={ "chip g-" (grade.word()) } { (t(grade.word())) } }
}

/// An instant; the script writes it in the reader's own time zone.
pub(super) fn instant(rfc3339: &str) -> Markup {
    let short = rfc3339.get(..16).unwrap_or(rfc3339).replace('T', " ");
    html! { time datetime=(rfc3339) { (short) " UTC" } }
}

/// A sentence in which instants are written as everywhere on the page.
pub(super) fn timed(text: &str) -> Markup {
    html! {
        @for (index, word) in text.split(' ').enumerate() {
            @if index > 0 { " " }
            @let bare = word.trim_end_matches([',', ';', '.', ':']);
            @if word.len() > 19 && parse_rfc3339(bare).is_some() { (instant(bare)) (word[bare.len()..]) } @else { (word) }
        }
    }
}

/// The age of data. It is said loudly when the data are not live; the script lets it grow while nothing arrives.
pub(super) fn data_age(state: DataState, age_s: Option<f64>) -> Markup {
    match (state, age_s) {
        (DataState::Live, Some(age_s)) => html! {
            span .age data-age=(age_s.floor()) { (age(age_s)) }
        },
        (DataState::Stale, Some(age_s)) => html! {
            span .age.loud { (t("stale,")) " " span data-age=(age_s.floor()) { (age(age_s)) } }
        },
        _ => html! { span .age.loud { (t("no data yet")) } },
    }
}

/// The condition of the rail in a word.
pub(super) fn condition(condition: Option<Condition>) -> &'static str {
    condition.map_or(NOTHING, |condition| t(condition.word()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_within_a_sentence_are_elements_of_their_own() {
        let told = timed("no data since 2026-11-22T10:53:40.680Z; before: well").into_string();
        let time = "<time datetime=\"2026-11-22T10:53:40.680Z\">2026-11-22 10:53 UTC</time>";
        assert_eq!(told, format!("no data since {time}; before: well"));
    }

    #[test]
    fn numbers_and_ages_read_well() {
        let numbers = [(-0.0004, 3, "0.000"), (-1.25, 1, "−1.2"), (0.35615, 3, "0.356")];
        for (value, digits, text) in numbers {
            assert_eq!(number(value, digits), text);
        }
        let ages = [
            (0.2, "< 1 s"),
            (12.3, "12 s"),
            (119.4, "119 s"),
            (125.0, "2 min"),
            (7300.0, "2 h"),
            (2e5, "2 days"),
        ];
        for (seconds, text) in ages {
            assert_eq!(age(seconds), text);
        }
        assert_eq!(Form::PERCENT.value(Some(0.123)), "12\u{202f}%");
    }
}
