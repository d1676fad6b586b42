//! The report for people: one self-contained HTML file that needs no network, reads in light and dark, prints, and says everything in
//! text, too, in the language that is spoken (`railgrip_words::speak`). Colours never stand alone: lines differ in dashes, heat cells carry their numbers.
//!
//! [`render`] draws a [`Report`] and the [`Detail`] beside it; sections without data are left out. Nothing is decided here, and
//! nothing is computed but where a mark is drawn.

mod chart;
pub mod compare;
mod curves;
mod document;
mod facts;
mod first_page;
mod gaps;
mod location;
mod places;
mod ranking;
pub mod survey;
mod traces;

use crate::answer::schema::Report;
use crate::answer::supplement::Detail;
use maud::html;
use railgrip_words::t;

/// The whole page.
pub fn render(report: &Report, detail: &Detail) -> String {
    let mut detail = detail.clone();
    if report.effects.is_empty() {
        leave_out_extended(&mut detail);
    }
    let detail = &detail;
    let title = format!("{}: {}", detail.case, t("sim-to-real gap"));
    let body = html! {
        (first_page::page(report, detail))
        (gaps::section(report))
        (location::section(report, detail))
        (traces::section(detail))
        (curves::effects(report, detail))
        (curves::missing(report, detail))
        (facts::rule(report, detail))
        (facts::posterior(report))
        (ranking::section(report, detail))
        (facts::parameters(detail))
        (facts::runs(detail))
        (facts::settings(report, detail))
    };
    document::frame(&title, &body)
}

/// Without an effect the extended model is the calibrated one, and its lines would hide those of the calibrated model.
fn leave_out_extended(detail: &mut Detail) {
    detail.scatters.iter_mut().for_each(|scatter| scatter.extended.clear());
    detail.heat_map.groups.iter_mut().for_each(|group| group.extended.clear());
    let traces = detail.worst_window.iter_mut().flat_map(|window| &mut window.traces);
    traces.for_each(|trace| trace.extended.clear());
}
