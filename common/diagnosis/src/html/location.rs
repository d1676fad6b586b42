//! Where the gap lies: term, outputs, region, and the heat map of output × region.

use super::document::filled;
use crate::answer::schema::Report;
use crate::answer::supplement::{Detail, HeatGroup, HeatMap};
use crate::words::format::{gap, number_to, on_axis, percent, plain, signal, term};
use crate::words::regime::regime;
use maud::{Markup, html};
use railgrip_words::{say, t};

/// Strongest tint of a cell.
const DEEPEST: f64 = 0.72;

/// The section.
pub fn section(report: &Report, detail: &Detail) -> Markup {
    let place = &report.location;
    html! {
        section aria-labelledby="where" {
            h2 id="where" { (t("Where it lies")) }
            p.say {
                @match &place.term {
                    Some(name) => { (filled("In {place} ({code}).", &[("place", html! { b { (term(name)) } }), ("code", html! { code { (name) } })])) }
                    None => { (t("No part of the model stands out.")) }
                }
                @if let Some(found) = &place.regime {
                    " "
                    (filled("The gap is largest with {range}: {inside} there, {outside} elsewhere.", &[
                        ("range", html! { b { (regime(found, &detail.heat_map)) } }),
                        ("inside", html! { b { (gap(found.gap_inside)) } }),
                        ("outside", html! { (gap(found.gap_outside)) }),
                    ]))
                }
            }
            @if place.signals.len() > 1 { (signals(report)) }
            (super::places::table(report, detail))
            (heat(&detail.heat_map))
        }
    }
}

fn signals(report: &Report) -> Markup {
    let mut signals = report.location.signals.clone();
    signals.sort_by(|a, b| b.share.total_cmp(&a.share));
    html! {
        div.panel role="group" aria-label=(t("Share of each output in the gap")) {
            @for entry in &signals {
                div class="bar share" {
                    span { (signal(&entry.name)) }
                    div.track aria-hidden="true" {
                        div class="fill calibrated" style={ "width:" (format!("{:.1}", 100.0 * entry.share.clamp(0.0, 1.0))) "%" } {}
                    }
                    span.value { (percent(entry.share)) " · " (say("gap {gap}", &[("gap", &gap(entry.gap))])) }
                }
            }
        }
    }
}

fn heat(map: &HeatMap) -> Markup {
    let top = map
        .groups
        .iter()
        .flat_map(|group| group.calibrated.iter().flatten())
        .filter(|x| x.is_finite())
        .fold(2.0_f64, |top, x| top.max(*x));
    html! {
        @if !map.groups.is_empty() {
            h3 { (t("Gap by operating range")) }
            p.note {
                @if map.groups.iter().any(|group| !group.extended.is_empty()) {
                    (t("Each cell shows the gap of the calibrated model, and after the arrow that of the extended model. Deeper colour: larger gap."))
                } @else { (t("Each cell shows the gap of the calibrated model. Deeper colour: larger gap.")) }
                @if map.groups.iter().any(|group| group.variable == "temperature") {
                    " " (t("Temperature is that of the disc, worked out from the heat of braking, with 20 °C at the start of each run."))
                }
            }
            div.pair { @for group in &map.groups { (table(map, group, top)) } }
        }
    }
}

fn table(map: &HeatMap, group: &HeatGroup, top: f64) -> Markup {
    let regions = group.edges.len().saturating_sub(1);
    let scale = Scale::of(&group.unit, group.edges.last().copied().unwrap_or(0.0));
    let unit = if scale.unit.is_empty() { String::new() } else { format!(" ({})", scale.unit) };
    let ends = group.edges.first().copied().zip(group.edges.last().copied());
    let span = scale.factor * ends.map_or(0.0, |(first, last)| last - first);
    let limit = |at: usize| edge(group.edges[at] * scale.factor, span);
    html! {
        div.scroll { table.heat {
            caption { @if group.variable == "temperature" { (t("disc temperature")) } @else { (plain(&group.variable)) } (unit) }
            thead { tr {
                td style="--a:0" {}
                @for region in 0..regions {
                    th scope="col" { (limit(region)) "–" (limit(region + 1)) }
                }
            } }
            tbody {
                @for (row, name) in map.signals.iter().enumerate() {
                    tr {
                        th scope="row" { (signal(name)) }
                        @for region in 0..regions { (cell(group, row, region, top)) }
                    }
                }
            }
        } }
    }
}

/// A unit that keeps large numbers short.
struct Scale {
    factor: f64,
    unit: String,
}

impl Scale {
    fn of(unit: &str, largest: f64) -> Self {
        match unit {
            "N" | "W" | "J" if largest.abs() >= 1e4 => Self { factor: 1e-3, unit: format!("k{unit}") },
            _ => Self { factor: 1.0, unit: unit.to_owned() },
        }
    }
}

/// A limit of a region: two digits are enough below ten.
fn edge(x: f64, span: f64) -> String {
    if x != 0.0 && x.abs() < 1.0 {
        // Beside much larger limits, too: rounded, it would be zero.
        number_to(x, 1)
    } else if span > 0.0 && span < 10.0 {
        number_to((100.0 * x / span).round() * span / 100.0 + 0.0, 2)
    } else {
        on_axis(x.round(), span)
    }
}

fn cell(group: &HeatGroup, row: usize, region: usize, top: f64) -> Markup {
    let at = |table: &[Vec<f64>]| table.get(row).and_then(|r| r.get(region)).copied().unwrap_or(f64::NAN);
    let (before, after) = (at(&group.calibrated), at(&group.extended));
    let depth = if before.is_finite() && before > 1.0 { DEEPEST * before.ln() / top.ln() } else { 0.0 };
    let samples = group.samples.get(region).copied().unwrap_or(0);
    html! {
        td style={ "--a:" (format!("{depth:.2}")) } title=(say("{count} samples", &[("count", &samples)])) {
            b { (gap(before)) }
            @if after.is_finite() { small { "→ " (gap(after)) } }
        }
    }
}
