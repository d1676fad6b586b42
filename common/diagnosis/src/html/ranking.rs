//! The ranking of candidates, the test against chance, and groups that the data cannot separate.

use super::document::filled;
use crate::answer::schema::{Candidate, Report};
use crate::answer::supplement::{Alarm, CandidateDetail, Detail};
use crate::words::format::{gap, number, p_value, part, percent, plain};
use crate::words::parameters;
use crate::words::sentences::{caution, law};
use maud::{Markup, html};
use railgrip_words::{reword, say, t};

/// The section.
pub fn section(report: &Report, detail: &Detail) -> Markup {
    html! {
        section aria-labelledby="which" {
            h2 id="which" { (say("Which effect: all {count} candidates", &[("count", &report.candidates.len())])) }
            p.say { (t("Each candidate was added alone to the calibrated model and fitted together with the tolerances.")) }
            dl.words {
                dt { (t("Gap, fitted")) }
                dd {
                    (t("gap of the runs that were fitted, with the candidate as the errors of the filter fit it; open loop it can be larger than before. What was found is fitted to predictions as well at the end, which gives the gap called extended."))
                }
                dt { (t("Gain")) } dd { (t("share of the removable squared error that it removes on data left out of the fit; “all” where nothing is left")) }
                dt { "p" }
                dd {
                    (t("probability that the best of all candidates gains as much by chance, where there is no effect. It cannot be told below one in the number of draws, so many candidates share the smallest."))
                    @if let Some(alarm) = &detail.alarm { " " (chance(alarm)) }
                }
                dt { (t("Settled")) }
                dd {
                    (t("whether the search for the candidate's best values ended by itself. Where it did not, they were still moving a little and the gain is a lower limit. An effect that was found is fitted again at the end, together with all others."))
                }
            }
            @if let Some(words) = caution(report) { p.say { b { (words) } } }
            div.scroll { table.rows {
                caption { (t("Candidates, the best at predicting left-out data first")) }
                thead { tr {
                    th scope="col" { (t("Effect")) } th.n scope="col" { (t("Gap, fitted")) } th scope="col" { (t("Gain on left-out data")) }
                    th.n scope="col" { "p" } th scope="col" { (t("Settled")) }
                    @if detail.candidates.iter().any(|c| !c.form.is_empty()) { th scope="col" { (t("Best form")) } }
                } }
                tbody {
                    @for candidate in &report.candidates { (row(report, detail, candidate)) }
                    @if let Some(without) = detail.gap_without_any { (without_any(without, detail)) }
                }
            } }
            @if !detail.ties.is_empty() {
                h3 { (t("What these data cannot tell apart")) }
                @for tie in &detail.ties {
                    div.tie {
                        p style="margin:0" { b { (tie.ids.iter().map(|id| plain(id)).collect::<Vec<_>>().join(" · ")) } }
                        p.note style="margin:.15rem 0 0" { (reword(&tie.because)) }
                    }
                }
            }
        }
    }
}

/// How the threshold against chance was found.
fn chance(alarm: &Alarm) -> Markup {
    html! {
        (filled(
            "For the comparison with chance, {how} {times} times; in {share} of these draws the best candidate scores more than {threshold}, and in the recordings it scores {observed}. The score is the {statistic}.",
            &[
                ("how", html! { (reword(&alarm.how)) }),
                ("times", html! { (alarm.replicates) }),
                ("share", html! { (percent(alarm.level)) }),
                ("threshold", html! { b { (number(alarm.threshold)) } }),
                ("observed", html! { b { (number(alarm.observed)) } }),
                ("statistic", html! { (reword(&alarm.statistic)) }),
            ],
        ))
    }
}

fn row(report: &Report, detail: &Detail, candidate: &Candidate) -> Markup {
    let found = report.effects.iter().any(|effect| effect.id == candidate.id);
    let more = detail.candidates.iter().find(|more| more.id == candidate.id);
    let forms = detail.candidates.iter().any(|c| !c.form.is_empty());
    html! {
        tr class=[found.then_some("found")] {
            th scope="row" { code { (candidate.id) } }
            td.n data-label=(t("Gap, fitted")) { (gap(candidate.fit_gap)) }
            td.gain data-label=(t("Gain on left-out data")) { (gain(candidate, more)) }
            td.n data-label="p" { (p_value(candidate.p_value, detail.alarm.as_ref().map(|alarm| alarm.replicates))) }
            td data-label=(t("Settled")) {
                @if candidate.converged { (t("yes")) } @else if found { (t("no; fitted again at the end")) } @else { (t("no")) }
                @if let Some(bound) = more.filter(|more| !more.on_bound.is_empty()) {
                    span.form { " · " (say("at the limit of what is allowed: {names}", &[("names", &on_bound(bound))])) }
                }
            }
            @if forms { td.form data-label=(t("Best form")) { @if let Some(more) = more { (law(&more.form)) } } }
        }
    }
}

/// What the candidates' gaps compare with.
fn without_any(without: f64, detail: &Detail) -> Markup {
    let empty = if detail.candidates.iter().any(|c| !c.form.is_empty()) { 4 } else { 3 };
    html! {
        tr {
            th scope="row" { (t("tolerances alone")) }
            td.n data-label=(t("Gap, fitted")) { (gap(without)) }
            @for _ in 0..empty { td {} }
        }
    }
}

/// Parameters that ended on a bound, by their names.
fn on_bound(candidate: &CandidateDetail) -> String {
    candidate.on_bound.iter().map(|name| parameters::name(name)).collect::<Vec<_>>().join(", ")
}

/// A bar from zero with its interval, and the number.
fn gain(candidate: &Candidate, more: Option<&CandidateDetail>) -> Markup {
    let place = |x: f64| 20.0 + 84.0 * x.clamp(-0.2, 1.0);
    let (zero, end) = (place(0.0), place(candidate.cv_gain));
    let class = if candidate.cv_gain >= 0.0 { "var(--extended)" } else { "var(--nominal)" };
    html! {
        svg viewBox="0 0 150 18" role="img" aria-label={ (t("Gain")) " " (part(candidate.cv_gain)) } {
            line class="axis" x1=(zero) x2=(zero) y1="1" y2="17" {}
            rect x=(format!("{:.1}", zero.min(end))) y="5" width=(format!("{:.1}", (end - zero).abs().max(1.0))) height="8" rx="1"
                style={ "fill:" (class) } {}
            @if let Some([low, high]) = more.and_then(|more| more.cv_gain_interval) {
                line x1=(format!("{:.1}", place(low))) x2=(format!("{:.1}", place(high))) y1="9" y2="9" style="stroke:var(--ink);stroke-width:1.3" {}
            }
            text x="148" y="13.5" text-anchor="end" { (part(candidate.cv_gain)) }
        }
    }
}
