//! The table of places: what is gained by letting one place of the equations err at a time, before and after the effects.

use crate::answer::schema::Report;
use crate::answer::supplement::{Detail, FreedPlace};
use crate::words::format::{number, number_to, percent};
use crate::words::sentences::{disagreement, freed};
use maud::{Markup, html};
use railgrip_words::t;

/// Places that are shown.
const MOST: usize = 8;

/// The table; nothing where no place was freed, as on a bench.
pub fn table(report: &Report, detail: &Detail) -> Markup {
    let top = detail.freed.iter().map(|place| place.before).fold(1.0, f64::max);
    let extended = detail.freed.iter().any(|place| place.after.is_some());
    html! {
        @if !detail.freed.is_empty() {
            h3 { (t("By part of the model")) }
            p.note {
                (t("In each row one part of the model was allowed to be wrong by an amount that varies with time. The gain says how much more likely that makes the recordings (log-likelihood): where it is largest, the model is most likely wrong. Size: by how much that part would have to be wrong (one sigma). Lasts: for how long at a time."))
                @if extended { " " (t("With effects: the gain that is left once the effects are in the model; below zero means that nothing is left to gain there.")) }
            }
            div.scroll { table.rows {
                caption { (t("Parts of the model, the likeliest first")) }
                thead { tr {
                    th scope="col" { (t("Part")) } th scope="col" { (t("Gain")) } @if extended { th.n scope="col" { (t("With effects")) } }
                    th.n scope="col" { (t("Size")) } th.n scope="col" { (t("Lasts about")) }
                } }
                tbody { @for place in detail.freed.iter().take(MOST) { (row(place, top, extended)) } }
            } }
            @if let Some(words) = detail.freed.first().and_then(|first| disagreement(report, first)) { p.say { (words) } }
        }
    }
}

fn row(place: &FreedPlace, top: f64, extended: bool) -> Markup {
    let width = 72.0 * (place.before / top).clamp(0.0, 1.0);
    html! {
        tr {
            th scope="row" { (freed(&place.place)) }
            td.gain data-label=(t("Gain")) {
                svg viewBox="0 0 150 18" role="img" aria-label={ (t("Gain")) " " (number(place.before)) } {
                    rect x="0" y="5" width=(format!("{:.1}", width.max(1.0))) height="8" rx="1" style="fill:var(--calibrated)" {}
                    text x="148" y="13.5" text-anchor="end" { (number(place.before.round())) }
                }
            }
            @if extended { td.n data-label=(t("With effects")) { (place.after.map_or_else(|| "–".to_owned(), |after| number(after.round()))) } }
            td.n data-label=(t("Size")) { (size(place)) }
            td.n data-label=(t("Lasts about")) { (number(place.time_s)) " s" }
        }
    }
}

/// The size with its unit. A share of more than the whole means that the recordings set no limit to it.
fn size(place: &FreedPlace) -> String {
    match (place.unit.as_str(), place.size) {
        ("", size) if size > 1.0 => t("no limit seen").to_owned(),
        ("", size) if size < 0.1 => format!("{} %", number_to(100.0 * size, 2)),
        ("", size) => percent(size),
        (unit, size) => format!("{} {unit}", number_to(size, 2)),
    }
}
