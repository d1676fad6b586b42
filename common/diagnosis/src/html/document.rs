//! A whole page around its body: head, style and foot, with nothing from elsewhere.

use super::chart::raw;
use maud::{DOCTYPE, Markup, html};

const STYLE: &str = include_str!("page.css");

/// The page.
pub fn frame(title: &str, body: &Markup) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (raw(STYLE)) }
            }
            body {
                main { (body) }
                footer { p { "railgrip advises people; it drives no brake and no traction." } }
            }
        }
    }
    .into_string()
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
