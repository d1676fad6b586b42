//! Header, next run, parameters, runs and settings: the parts that are words and tables.

use crate::answer::schema::{Report, Verdict};
use crate::answer::supplement::Detail;
use crate::words::format::{gap, interval, number, number_to, plain};
use crate::words::sentences::{evidence, headline};
use maud::{Markup, html};

/// Case, verdict and evidence.
pub fn header(report: &Report, detail: &Detail) -> Markup {
    let class = match report.verdict {
        Verdict::None => "badge none",
        Verdict::Effects => "badge",
        Verdict::Unknown | Verdict::EffectsAndUnknown => "badge unknown",
    };
    html! {
        header.top {
            p.eyebrow {
                span { "Sim-to-real gap" }
                strong { (detail.case) }
                span { (detail.subject) }
                span class=(class) { (report.verdict.name()) }
            }
            h1 { (headline(report)) }
            p.lede {
                @for (index, piece) in evidence(report).iter().enumerate() {
                    @if index % 2 == 1 { b { (piece) } } @else { (piece) }
                }
            }
            @if !detail.rule.is_empty() {
                p.rule { "Decided by the rule " code { (report.rule) } ": " (detail.rule) }
            }
            @if !detail.notes.is_empty() { ul.notes { @for note in &detail.notes { li { (note) } } } }
        }
    }
}

/// The run to make next.
pub fn next_run(report: &Report) -> Markup {
    html! {
        @if let Some(next) = &report.next_run {
            section aria-labelledby="next" { h2 id="next" { "The run to make next" } p.next { (next) } }
        }
    }
}

/// Fitted parameters.
pub fn parameters(detail: &Detail) -> Markup {
    html! {
        @if !detail.parameters.is_empty() {
            section aria-labelledby="parameters" {
                h2 id="parameters" { "Parameters of the extended model" }
                div.scroll { table {
                    caption { "Tolerances and effects, fitted together" }
                    thead { tr {
                        th scope="col" { "Parameter" } th scope="col" { "Belongs to" } th.n scope="col" { "Nominal" }
                        th.n scope="col" { "Fitted" } th.n scope="col" { "95 % interval" } th.n scope="col" { "Allowed range" }
                    } }
                    tbody {
                        @for row in &detail.parameters {
                            tr {
                                th scope="row" { code { (row.name) } }
                                td { @if row.owner == "nuisance" { "tolerance" } @else { (plain(&row.owner)) } }
                                td.n { (row.nominal.map_or_else(|| "–".to_owned(), |x| number_to(x, 4))) }
                                td.n { b { (number_to(row.value, 4)) } }
                                td.n { (interval(row.ci95)) }
                                td.n { (interval(row.bounds)) }
                            }
                        }
                    }
                } }
            }
        }
    }
}

/// Runs of the case.
pub fn runs(detail: &Detail) -> Markup {
    let timed = detail.runs.iter().any(|run| run.duration_s.is_some());
    html! {
        @if !detail.runs.is_empty() {
            section aria-labelledby="runs" {
                h2 id="runs" { "Runs" }
                div.scroll { table {
                    caption { "Gap of every run" }
                    thead { tr {
                        th scope="col" { "Run" } th scope="col" { "Used" } th.n scope="col" { "Samples" }
                        @if timed { th.n scope="col" { "Length (s)" } }
                        th.n scope="col" { "Nominal" } th.n scope="col" { "Calibrated" } th.n scope="col" { "Extended" }
                    } }
                    tbody {
                        @for run in &detail.runs {
                            tr {
                                th scope="row" { code { (run.name) } }
                                td { @if run.holdout { "only predicted" } @else { "fitted" } }
                                td.n { (run.samples) }
                                @if timed { td.n { (run.duration_s.map_or_else(|| "–".to_owned(), number)) } }
                                td.n { (gap(run.nominal)) }
                                td.n { (gap(run.calibrated)) }
                                td.n { (gap(run.extended)) }
                            }
                        }
                    }
                } }
            }
        }
    }
}

/// How to make the report again.
pub fn settings(report: &Report, detail: &Detail) -> Markup {
    let settings = &detail.settings;
    html! {
        section aria-labelledby="again" {
            h2 id="again" { "To make this report again" }
            dl.settings {
                @if !settings.command.is_empty() { dt { "Command" } dd { code { (settings.command) } } }
                @if !settings.version.is_empty() { dt { "Version" } dd { (settings.version) } }
                dt { "Seed" } dd { (settings.seed) }
                @if !settings.without.is_empty() { dt { "Effects left out" } dd { code { (settings.without.join(", ")) } } }
                @for (name, value) in &settings.more { dt { (name) } dd { (value) } }
                dt { "Time taken" } dd { (format!("{:.1}", report.seconds)) " s" }
                dt { "Format" } dd { code { (report.schema) } }
            }
        }
    }
}
