//! The table of places: what it gains to free one place of the equations at a time, before and after the effects.

use super::words::number;
use crate::answer::supplement::{Detail, FreedPlace};
use maud::{Markup, html};

/// Places that are shown.
const MOST: usize = 8;

/// The table; nothing where no place was freed, as on a bench.
pub fn table(detail: &Detail) -> Markup {
    let top = detail.freed.iter().map(|place| place.before).fold(1.0, f64::max);
    let extended = detail.freed.iter().any(|place| place.after.is_some());
    html! {
        @if !detail.freed.is_empty() {
            h3 { "By place in the equations" }
            p.note {
                "One place at a time may err by a slowly wandering amount. The more the recordings gain by that (log-likelihood), the more likely the error is there; "
                "the size is what that place would have to err by, one sigma, and for how long at a time."
                @if extended { " After: what is left to gain once the effects are added." }
            }
            div.scroll { table {
                caption { "Places, the likeliest first" }
                thead { tr {
                    th scope="col" { "Place" } th scope="col" { "Gained by freeing it" } @if extended { th.n scope="col" { "After" } }
                    th.n scope="col" { "Size" } th.n scope="col" { "For about" }
                } }
                tbody { @for place in detail.freed.iter().take(MOST) { (row(place, top, extended)) } }
            } }
        }
    }
}

fn row(place: &FreedPlace, top: f64, extended: bool) -> Markup {
    let width = 92.0 * (place.before / top).clamp(0.0, 1.0);
    html! {
        tr {
            th scope="row" { (place.place) }
            td.gain {
                svg viewBox="0 0 150 18" role="img" aria-label={ "gain " (number(place.before)) } {
                    rect x="0" y="5" width=(format!("{:.1}", width.max(1.0))) height="8" rx="1" style="fill:var(--calibrated)" {}
                    text x="148" y="13.5" text-anchor="end" { (number(place.before.round())) }
                }
            }
            @if extended { td.n { (place.after.map_or_else(|| "–".to_owned(), |after| number(after.round()))) } }
            td.n { (number(place.size)) @if !place.unit.is_empty() { " " (place.unit) } }
            td.n { (number(place.time_s)) " s" }
        }
    }
}
