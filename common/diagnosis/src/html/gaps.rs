//! Gap bars: nominal, calibrated and extended, on fit and on holdout runs.

use crate::answer::schema::{Report, ThreeGaps};
use crate::words::format::{gap, percent, signal};
use maud::{Markup, html};

/// The section.
pub fn section(report: &Report) -> Markup {
    let holdout = &report.gap.holdout;
    let unseen =
        ThreeGaps { nominal: holdout.nominal, calibrated: holdout.calibrated, extended: holdout.extended };
    let top = [report.gap.fit, unseen]
        .iter()
        .flat_map(|gaps| [gaps.nominal, gaps.calibrated, gaps.extended])
        .filter(|x| x.is_finite())
        .fold(1.2, f64::max);
    let [low, high] = holdout.reduction_ci95.map(percent);
    html! {
        section aria-labelledby="how-far" {
            h2 id="how-far" { "How far it shrinks" }
            p.say {
                "The gap is the RMS error of a prediction, divided by the noise of the sensor (sigma). A gap of 1 is as good as the sensors can tell."
                @if !report.effects.is_empty() {
                    " On data that were not fitted it shrinks by " b { (percent(holdout.reduction)) } ", 95 % interval " (low) " to " (high) "."
                }
            }
            div.bars {
                (panel("Fitted data", &report.gap.fit, top))
                (panel("Holdout data, only predicted", &unseen, top))
            }
            p.note {
                "Nominal: the model as the case states it. Calibrated: with the vehicle's tolerances fitted. Extended: with tolerances and effects fitted. "
                "Dotted line: a gap of 1."
                @if report.effects.is_empty() { " No effect was added here, so the extended model is the calibrated one." }
            }
            @if holdout.by_signal.len() > 1 { (by_signal(report)) }
        }
    }
}

fn panel(title: &str, gaps: &ThreeGaps, top: f64) -> Markup {
    let rows = [
        ("nominal", "Nominal", gaps.nominal),
        ("calibrated", "Calibrated", gaps.calibrated),
        ("extended", "Extended", gaps.extended),
    ];
    html! {
        div.panel role="group" aria-label=(title) {
            h3 { (title) }
            @for (class, name, value) in rows {
                div.bar {
                    span { (name) }
                    div.track aria-hidden="true" {
                        div class={ "fill " (class) } style={ "width:" (share(value, top)) "%" } {}
                        div.floor style={ "left:" (share(1.0, top)) "%" } {}
                    }
                    span.value { (gap(value)) }
                }
            }
        }
    }
}

fn share(value: f64, top: f64) -> String {
    format!("{:.2}", 100.0 * (value / top).clamp(0.0, 1.0))
}

fn by_signal(report: &Report) -> Markup {
    html! {
        div.scroll { table {
            caption { "Holdout gap by output" }
            thead { tr {
                th scope="col" { "Output" } th.n scope="col" { "Calibrated" } th.n scope="col" { "Extended" }
                th.n scope="col" { "Reduction" }
            } }
            tbody {
                @for (name, gaps) in &report.gap.holdout.by_signal {
                    tr {
                        th scope="row" { (signal(name)) " " code { (name) } }
                        td.n { (gap(gaps.calibrated)) }
                        td.n { (gap(gaps.extended)) }
                        td.n { (percent(gaps.reduction())) }
                    }
                }
            }
        } }
    }
}
