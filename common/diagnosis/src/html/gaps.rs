//! Gap bars: nominal, calibrated and extended, on fit and on holdout runs.

use crate::answer::schema::{Report, ThreeGaps};
use crate::words::format::{gap, percent, signal};
use maud::{Markup, html};
use railgrip_words::t;

/// Bars of the three models on both sets of runs, and what a right model would leave of them.
pub fn bars(report: &Report) -> Markup {
    let holdout = &report.gap.holdout;
    let unseen =
        ThreeGaps { nominal: holdout.nominal, calibrated: holdout.calibrated, extended: holdout.extended };
    let natural = report.gap.natural;
    let [fit, held_out] = [natural.map(|gap| gap.fit), natural.and_then(|gap| gap.holdout)];
    let top = [report.gap.fit, unseen]
        .iter()
        .flat_map(|gaps| [gaps.nominal, gaps.calibrated, gaps.extended])
        .chain(fit)
        .chain(held_out)
        .filter(|x| x.is_finite())
        .fold(1.2, f64::max);
    html! {
        div.bars {
            (panel(t("Holdout gap: runs only predicted"), (&unseen, held_out), top, report.effects.is_empty()))
            (panel(t("Gap of the runs that were fitted"), (&report.gap.fit, fit), top, report.effects.is_empty()))
        }
    }
}

/// Gaps by output; nothing where there is one output only.
pub fn section(report: &Report) -> Markup {
    html! {
        @if report.gap.holdout.by_signal.len() > 1 {
            section aria-labelledby="how-far" {
                h2 id="how-far" { @if report.effects.is_empty() { (t("The gap by output")) } @else { (t("How far it shrinks")) } }
                (by_signal(report))
            }
        }
    }
}

/// Without an effect the extended model is the calibrated one, and its bar is left out.
fn panel(title: &str, (gaps, natural): (&ThreeGaps, Option<f64>), top: f64, without: bool) -> Markup {
    let models = [
        ("nominal", t("Nominal"), gaps.nominal),
        ("calibrated", t("Calibrated"), gaps.calibrated),
        ("extended", t("Extended"), gaps.extended),
    ];
    let right = natural.map(|gap| ("natural", t("A right model"), gap));
    let rows = models.into_iter().take(if without { 2 } else { 3 }).chain(right);
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
    let found = !report.effects.is_empty();
    html! {
        div.scroll { table {
            caption { (t("Holdout gap by output")) }
            thead { tr {
                th scope="col" { (t("Output")) } th.n scope="col" { (t("Calibrated")) }
                @if found { th.n scope="col" { (t("Extended")) } th.n scope="col" { (t("Reduction")) } }
            } }
            tbody {
                @for (name, gaps) in &report.gap.holdout.by_signal {
                    tr {
                        th scope="row" { (signal(name)) " " code { (name) } }
                        td.n { (gap(gaps.calibrated)) }
                        @if found { td.n { (gap(gaps.extended)) } td.n { (percent(gaps.reduction())) } }
                    }
                }
            }
        } }
    }
}
