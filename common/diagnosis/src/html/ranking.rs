//! The ranking of candidates, the test against chance, and groups that the data cannot separate.

use crate::answer::schema::{Candidate, Report};
use crate::answer::supplement::{Alarm, CandidateDetail, Detail};
use crate::words::format::{gap, number, p_value, part, percent, plain};
use crate::words::sentences::caution;
use maud::{Markup, html};

/// The section.
pub fn section(report: &Report, detail: &Detail) -> Markup {
    html! {
        section aria-labelledby="which" {
            h2 id="which" { "Which effect: all " (report.candidates.len()) " candidates" }
            p.say { "Each candidate was added alone to the calibrated model and fitted together with the tolerances." }
            dl.words {
                dt { "Gain" } dd { "share of the removable squared error that it removes on data left out of the fit; “all” where nothing is left" }
                dt { "p" }
                dd {
                    "probability that the best of all candidates gains as much by chance, where there is no effect. It cannot be told below one in the number of draws, so many candidates share the smallest."
                    @if let Some(alarm) = &detail.alarm { " " (chance(alarm)) }
                }
                dt { "Settled" }
                dd {
                    "whether the search for the candidate's best values ended by itself. Where it did not, they were still moving a little and the gain is a lower limit. "
                    "An effect that was found is fitted again at the end, together with all others."
                }
            }
            @if let Some(words) = caution(report) { p.say { b { (words) } } }
            div.scroll { table.rows {
                caption { "Candidates, the best at predicting left-out data first" }
                thead { tr {
                    th scope="col" { "Effect" } th.n scope="col" { "Gap, fitted" } th scope="col" { "Gain on left-out data" }
                    th.n scope="col" { "p" } th scope="col" { "Settled" }
                    @if detail.candidates.iter().any(|c| !c.form.is_empty()) { th scope="col" { "Best form" } }
                } }
                tbody { @for candidate in &report.candidates { (row(report, detail, candidate)) } }
            } }
            @if !detail.ties.is_empty() {
                h3 { "What these data cannot tell apart" }
                @for tie in &detail.ties {
                    div.tie {
                        p style="margin:0" { b { (tie.ids.iter().map(|id| plain(id)).collect::<Vec<_>>().join(" · ")) } }
                        p.note style="margin:.15rem 0 0" { (tie.because) }
                    }
                }
            }
        }
    }
}

/// How the threshold against chance was found.
fn chance(alarm: &Alarm) -> Markup {
    html! {
        "For the comparison with chance, " (alarm.how) " " (alarm.replicates) " times; in " (percent(alarm.level))
        " of these draws the best candidate scores more than " b { (number(alarm.threshold)) } ", and in the recordings it scores "
        b { (number(alarm.observed)) } ". The score is the " (alarm.statistic) "."
    }
}

fn row(report: &Report, detail: &Detail, candidate: &Candidate) -> Markup {
    let found = report.effects.iter().any(|effect| effect.id == candidate.id);
    let more = detail.candidates.iter().find(|more| more.id == candidate.id);
    let forms = detail.candidates.iter().any(|c| !c.form.is_empty());
    html! {
        tr class=[found.then_some("found")] {
            th scope="row" { code { (candidate.id) } }
            td.n data-label="Gap, fitted" { (gap(candidate.fit_gap)) }
            td.gain data-label="Gain on left-out data" { (gain(candidate, more)) }
            td.n data-label="p" { (p_value(candidate.p_value, detail.alarm.as_ref().map(|alarm| alarm.replicates))) }
            td data-label="Settled" {
                @if candidate.converged { "yes" } @else if found { "no; fitted again at the end" } @else { "no" }
                @if let Some(bound) = more.filter(|more| !more.on_bound.is_empty()) {
                    span.form { " · at the limit of what is allowed: " (bound.on_bound.join(", ")) }
                }
            }
            @if forms { td.form data-label="Best form" { @if let Some(more) = more { (more.form) } } }
        }
    }
}

/// A bar from zero with its interval, and the number.
fn gain(candidate: &Candidate, more: Option<&CandidateDetail>) -> Markup {
    let place = |x: f64| 20.0 + 84.0 * x.clamp(-0.2, 1.0);
    let (zero, end) = (place(0.0), place(candidate.cv_gain));
    let class = if candidate.cv_gain >= 0.0 { "var(--extended)" } else { "var(--nominal)" };
    html! {
        svg viewBox="0 0 150 18" role="img" aria-label={ "gain " (part(candidate.cv_gain)) } {
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
