//! The report for people: one self-contained HTML file that needs no network, reads in light and dark, prints, and says everything in
//! text, too. Colours never stand alone: lines differ in dashes, heat cells carry their numbers.
//!
//! [`render`] makes it from a [`Report`] and the [`Detail`] that the engine fills beside it; sections without data are left out.

mod chart;
mod curves;
mod facts;
mod gaps;
mod location;
mod markdown;
mod places;
mod ranking;
mod sentence;
mod traces;
pub mod words;

pub use markdown::summary;
pub use sentence::{evidence, headline};

use crate::answer::schema::Report;
use crate::answer::supplement::Detail;
use maud::{DOCTYPE, html};

const STYLE: &str = include_str!("page.css");

/// The whole page.
pub fn render(report: &Report, detail: &Detail) -> String {
    let title = format!("{}: sim-to-real gap", detail.case);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (chart::raw(STYLE)) }
            }
            body {
                main {
                    (facts::header(report, detail))
                    (gaps::section(report))
                    (location::section(report, detail))
                    (traces::section(detail))
                    (curves::effects(report, detail))
                    (curves::missing(report, detail))
                    (ranking::section(report, detail))
                    (facts::next_run(report))
                    (facts::parameters(detail))
                    (facts::runs(detail))
                    (facts::settings(report, detail))
                }
                footer { p { "railgrip · gap = RMS error over sensor sigma; 1 is as good as the sensors can tell." } }
            }
        }
    }
    .into_string()
}
