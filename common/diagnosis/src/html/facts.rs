//! The rule, parameters, runs and settings: the parts that are words and tables.

use crate::answer::schema::{ParameterEstimate, Report};
use crate::answer::supplement::{Detail, ParameterRow};
use crate::words::format::{gap, interval, number, plain};
use crate::words::parameters::{self, estimate, shown};
use maud::{Markup, html};

/// The rule that decided, and what a reader must know of the case.
pub fn rule(report: &Report, detail: &Detail) -> Markup {
    html! {
        @if !detail.rule.is_empty() || !detail.notes.is_empty() {
            section aria-labelledby="why" {
                h2 id="why" { "Why this answer" }
                @if !detail.rule.is_empty() {
                    p.say {
                        (detail.rule) " A table of named rules turns the evidence into the verdict, and the first that holds decides: here "
                        code { (report.rule) } "."
                    }
                }
                @if !detail.notes.is_empty() { ul.notes { @for note in &detail.notes { li { (note) } } } }
            }
        }
    }
}

/// Sets of effects that may be the cause, with their probabilities; nothing in reports without a posterior.
pub fn posterior(report: &Report) -> Markup {
    html! {
        @if !report.posterior.is_empty() {
            section aria-labelledby="sets" {
                h2 id="sets" { "What else it may be" }
                p.say {
                    "Each row is a set of effects that may be at work together, with its probability. In nine of ten cases the truth is among the rows that are marked."
                }
                div.scroll { table {
                    caption { "Sets of effects, the likeliest first" }
                    thead { tr { th scope="col" { "At work" } th.n scope="col" { "Probability" } th scope="col" { "In the set of nine in ten" } } }
                    tbody {
                        @for (index, set) in report.posterior.iter().enumerate() {
                            tr {
                                th scope="row" {
                                    @if set.effects.is_empty() && !set.unknown { "tolerances and noise alone" }
                                    (set.effects.iter().map(|id| plain(id)).collect::<Vec<_>>().join(" with "))
                                    @if set.unknown { @if !set.effects.is_empty() { " with " } "something that no candidate describes" }
                                }
                                td.n { (crate::words::format::percent(set.p)) }
                                td { @if report.verdict_set.contains(&index) { "yes" } @else { "no" } }
                            }
                        }
                    }
                } }
            }
        }
    }
}

/// Fitted parameters.
pub fn parameters(detail: &Detail) -> Markup {
    html! {
        @if !detail.parameters.is_empty() {
            section aria-labelledby="parameters" {
                h2 id="parameters" { "Parameters of the extended model" }
                p.say {
                    "Tolerances are what differs from wagon to wagon and day to day without being a cause: pad friction of each wheelset, adhesion of each class of rail, "
                    "running resistance, mass, inertia. They are fitted first and never named as the answer. A tolerance in per cent is the difference from the vehicle file."
                }
                div.scroll { table.rows {
                    caption { "Tolerances and effects, fitted together" }
                    thead { tr {
                        th scope="col" { "Parameter" } th scope="col" { "Belongs to" } th.n scope="col" { "Vehicle file" }
                        th.n scope="col" { "Fitted (95 % interval)" } th.n scope="col" { "Allowed range" }
                    } }
                    tbody { @for row in &detail.parameters { (parameter(row)) } }
                } }
            }
        }
    }
}

fn parameter(row: &ParameterRow) -> Markup {
    let unit = shown(&row.owner, &row.name);
    let fitted = ParameterEstimate { value: row.value, ci95: row.ci95 };
    let beside = if unit.unit.is_empty() { String::new() } else { format!(" {}", unit.unit) };
    html! {
        tr {
            th scope="row" { (parameters::name(&row.name)) " " code { (row.name) } }
            td data-label="Belongs to" { @if row.owner == "nuisance" { "tolerance" } @else { (plain(&row.owner)) } }
            td.n data-label="Vehicle file" { (row.nominal.map_or_else(|| "–".to_owned(), |x| number(unit.factor * x) + &beside)) }
            td.n data-label="Fitted" { b { (estimate(&row.owner, &row.name, &fitted)) } }
            td.n data-label="Allowed" { (interval(row.bounds.map(|x| unit.factor * x))) (beside) }
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
                div.scroll { table.rows {
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
                                td data-label="Used" { @if run.holdout { "only predicted" } @else { "fitted" } }
                                td.n data-label="Samples" { (run.samples) }
                                @if timed { td.n data-label="Length (s)" { (run.duration_s.map_or_else(|| "–".to_owned(), number)) } }
                                td.n data-label="Nominal" { (gap(run.nominal)) }
                                td.n data-label="Calibrated" { (gap(run.calibrated)) }
                                td.n data-label="Extended" { (gap(run.extended)) }
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
