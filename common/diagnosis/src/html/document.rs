//! A whole page around its body: head, style and foot, with nothing from elsewhere.

use super::chart::raw;
use maud::{DOCTYPE, Markup, html};
use railgrip_words::{Piece, pieces, spoken, t};

const STYLE: &str = include_str!("page.css");

/// The page.
pub fn frame(title: &str, body: &Markup) -> String {
    html! {
        (DOCTYPE)
        html lang=(spoken().tag()) {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (raw(STYLE)) }
            }
            body {
                main { (body) }
                footer { p { (t("railgrip advises people; it drives no brake and no traction.")) } }
            }
        }
    }
    .into_string()
}

/// A message of the table, filled in with more than text.
pub fn filled(message: &'static str, arguments: &[(&str, Markup)]) -> Markup {
    let argument = |name: &str| arguments.iter().find(|(other, _)| *other == name).map(|(_, markup)| markup);
    html! {
        @for piece in pieces(message) {
            @match piece {
                Piece::Text(text) => { (text) }
                Piece::Name(name) => { @if let Some(markup) = argument(name) { (markup) } }
            }
        }
    }
}

/// A text whose intervals in brackets stay on one line.
pub fn unbroken(text: &str) -> Markup {
    html! {
        @for (index, piece) in text.split('(').enumerate() {
            @match piece.split_once(')') {
                Some((inside, rest)) if index > 0 => { span.whole { "(" (inside) ")" } (rest) }
                _ => { @if index > 0 { "(" } (piece) }
            }
        }
    }
}
