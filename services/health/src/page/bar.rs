//! An indicator drawn on its scale: zones between the limits, the 95 % interval as a band, the figure as a stroke.
//! Drawn with attributes only, as a strict content policy allows; the words beside it say the same.

use crate::api::figure::Figure;
use maud::{Markup, html};
use railgrip_indicators::Limit;

const WIDTH: f64 = 200.0;
const HEIGHT: f64 = 22.0;

/// The bar of a figure; an empty scale if it is unknown.
pub(super) fn bar(figure: &Figure, limit: &Limit) -> Markup {
    let (low, high) = limit.scale;
    let at = |value: f64| ((value - low) / (high - low)).clamp(0.0, 1.0) * WIDTH;
    let bottom = at(limit.act_low.unwrap_or(low));
    let (left, right) = (at(limit.watch_low.unwrap_or(low)), at(limit.watch_high.unwrap_or(high)));
    let top = at(limit.act_high.unwrap_or(high));
    let zones = [
        ("z-act", 0.0, bottom),
        ("z-watch", bottom, left),
        ("z-ok", left, right),
        ("z-watch", right, top),
        ("z-act", top, WIDTH),
    ];
    let ends = figure.low.zip(figure.high).map(|(low, high)| (at(low), at(high)));
    let text = |x: f64| format!("{x:.1}");
    html! {
        svg .bar viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } preserveAspectRatio="none" aria-hidden="true" {
            @for (class, from, to) in zones.into_iter().filter(|(_, from, to)| to - from > 0.05) {
                rect class=(class) x=(text(from)) y="8" width=(text(to - from)) height="6" {}
            }
            @for x in [bottom, left, right, top].into_iter().filter(|x| *x > 0.0 && *x < WIDTH) {
                rect .tick x=(text(x - 0.5)) y="5" width="1" height="12" {}
            }
            @if let Some((from, to)) = ends {
                rect .band x=(text(from)) y="6" width=(text((to - from).max(1.5))) height="10" rx="1" {}
            }
            @if let Some(value) = figure.value {
                rect .stroke x=(text((at(value) - 1.5).clamp(0.0, WIDTH - 3.0))) y="2" width="3" height="18" rx="1" {}
            }
        }
    }
}
