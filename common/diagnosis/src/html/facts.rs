//! The rule, parameters, runs and settings: the parts that are words and tables.

use super::document::filled;
use crate::answer::schema::{ParameterEstimate, Report};
use crate::answer::supplement::{Detail, ParameterRow};
use crate::words::format::{decimals, gap, interval, number, plain};
use crate::words::parameters::{self, estimate, shown};
use crate::words::sentences::remark;
use maud::{Markup, html};
use railgrip_words::{reword, t};

/// The rule that decided, and what a reader must know of the case.
pub fn rule(report: &Report, detail: &Detail) -> Markup {
    html! {
        @if !detail.rule.is_empty() || !detail.notes.is_empty() {
            section aria-labelledby="why" {
                h2 id="why" { (t("Why this answer")) }
                @if !detail.rule.is_empty() {
                    p.say {
                        (reword(&detail.rule)) " "
                        (filled("A table of named rules turns the evidence into the verdict, and the first that holds decides: here {code}.", &[("code", html! { code { (report.rule) } })]))
                    }
                }
                @if !detail.notes.is_empty() { ul.notes { @for note in &detail.notes { li { (remark(note)) } } } }
            }
        }
    }
}

/// Sets of effects that may be the cause, with their probabilities; nothing in reports without a posterior.
pub fn posterior(report: &Report) -> Markup {
    html! {
        @if !report.posterior.is_empty() {
            section aria-labelledby="sets" {
                h2 id="sets" { (t("What else it may be")) }
                p.say {
                    (t("Each row is a set of effects that may be at work together, with its probability. On simulated trains the truth was among the marked rows in about nine of ten cases."))
                }
                div.scroll { table {
                    caption { (t("Sets of effects, the likeliest first")) }
                    thead { tr { th scope="col" { (t("At work")) } th.n scope="col" { (t("Probability")) } th scope="col" { (t("In the set of nine in ten")) } } }
                    tbody {
                        @for (index, set) in report.posterior.iter().enumerate() {
                            tr {
                                th scope="row" {
                                    @if set.effects.is_empty() && !set.unknown { (t("tolerances and noise alone")) }
                                    (set.effects.iter().map(|id| plain(id)).collect::<Vec<_>>().join(t(" with ")))
                                    @if set.unknown { @if !set.effects.is_empty() { (t(" with ")) } (t("something that no candidate describes")) }
                                }
                                td.n { (crate::words::format::percent(set.p)) }
                                td { @if report.verdict_set.contains(&index) { (t("yes")) } @else { (t("no")) } }
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
                h2 id="parameters" { (t("Parameters of the extended model")) }
                p.say {
                    (t("Tolerances are what differs from wagon to wagon and day to day without being a cause: pad friction of each wheelset, adhesion of each class of rail, running resistance, mass, inertia. They are fitted first and never named as the answer. A tolerance in per cent is the difference from the vehicle file."))
                }
                div.scroll { table.rows {
                    caption { (t("Tolerances and effects, fitted together")) }
                    thead { tr {
                        th scope="col" { (t("Parameter")) } th scope="col" { (t("Belongs to")) } th.n scope="col" { (t("Vehicle file")) }
                        th.n scope="col" { (t("Fitted (95 % interval)")) } th.n scope="col" { (t("Allowed range")) }
                    } }
                    tbody { @for row in &detail.parameters { (parameter(row)) } }
                } }
            }
        }
    }
}

fn parameter(row: &ParameterRow) -> Markup {
    let unit = shown(&row.owner, &row.name);
    let fitted = ParameterEstimate::new(row.value, row.ci95);
    let beside =
        if unit.unit.is_empty() { String::new() } else { format!(" {}", parameters::unit(unit.unit)) };
    html! {
        tr {
            th scope="row" { (parameters::name(&row.name)) " " code { (row.name) } }
            td data-label=(t("Belongs to")) { @if row.owner == "nuisance" { (t("tolerance")) } @else { (plain(&row.owner)) } }
            td.n data-label=(t("Vehicle file")) { (row.nominal.map_or_else(|| "–".to_owned(), |x| number(unit.factor * x) + &beside)) }
            td.n data-label=(t("Fitted")) { b { (estimate(&row.owner, &row.name, &fitted)) } }
            td.n data-label=(t("Allowed")) { (interval(row.bounds.map(|x| unit.factor * x))) (beside) }
        }
    }
}

/// Runs of the case.
pub fn runs(detail: &Detail) -> Markup {
    let timed = detail.runs.iter().any(|run| run.duration_s.is_some());
    html! {
        @if !detail.runs.is_empty() {
            section aria-labelledby="runs" {
                h2 id="runs" { (t("Runs")) }
                div.scroll { table.rows {
                    caption { (t("Gap of every run")) }
                    thead { tr {
                        th scope="col" { (t("Run")) } th scope="col" { (t("Used")) } th.n scope="col" { (t("Samples")) }
                        @if timed { th.n scope="col" { (t("Length (s)")) } }
                        th.n scope="col" { (t("Nominal")) } th.n scope="col" { (t("Calibrated")) } th.n scope="col" { (t("Extended")) }
                    } }
                    tbody {
                        @for run in &detail.runs {
                            tr {
                                th scope="row" { code { (run.name) } }
                                td data-label=(t("Used")) { @if run.holdout { (t("only predicted")) } @else { (t("fitted")) } }
                                td.n data-label=(t("Samples")) { (run.samples) }
                                @if timed { td.n data-label=(t("Length (s)")) { (run.duration_s.map_or_else(|| "–".to_owned(), number)) } }
                                td.n data-label=(t("Nominal")) { (gap(run.nominal)) }
                                td.n data-label=(t("Calibrated")) { (gap(run.calibrated)) }
                                td.n data-label=(t("Extended")) { (gap(run.extended)) }
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
            h2 id="again" { (t("To make this report again")) }
            dl.settings {
                @if !settings.command.is_empty() { dt { (t("Command")) } dd { code { (settings.command) } } }
                @if !settings.version.is_empty() { dt { (t("Version")) } dd { (settings.version) } }
                dt { (t("Seed")) } dd { (settings.seed) }
                @if !settings.without.is_empty() { dt { (t("Effects left out")) } dd { code { (settings.without.join(", ")) } } }
                @for (name, value) in &settings.more { dt { (reword(name)) } dd { (reword(value)) } }
                dt { (t("Time taken")) } dd { (decimals(report.seconds, 1)) " s" }
                dt { (t("Format")) } dd { code { (report.schema) } }
            }
        }
    }
}
