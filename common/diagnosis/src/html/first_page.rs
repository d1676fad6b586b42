//! The first page, made for one sheet of A4: the sentence with the number, how sure, where and when, one picture of before
//! and after, and what to do.

use super::document::{filled, unbroken};
use super::{gaps, traces};
use crate::answer::schema::{Report, Verdict};
use crate::answer::supplement::{Detail, Event};
use crate::words::advice::advice;
use crate::words::format::{decimals, gap, list, term};
use crate::words::regime::regime;
use crate::words::sentences::{certainty, evidence, headline, likelier, place, verdict};
use maud::{Markup, html};
use railgrip_words::{reword, say, t};

/// Events that are named where none is in the picture.
const MOST_EVENTS: usize = 3;

/// The page.
pub fn page(report: &Report, detail: &Detail) -> Markup {
    let class = match report.verdict {
        Verdict::None if likelier(report).is_some() => "badge unknown",
        Verdict::None => "badge none",
        Verdict::Effects => "badge",
        Verdict::Unknown | Verdict::EffectsAndUnknown => "badge unknown",
    };
    html! {
        div.sheet {
            header.top {
                p.eyebrow {
                    span { (t("Sim-to-real gap")) }
                    strong { (detail.case) }
                    span { (reword(&detail.subject)) }
                    span class=(class) title={ (t("in report.json:")) " " (report.verdict.name()) } { (verdict(report)) }
                }
                h1 { (unbroken(&headline(report))) }
                p.lede {
                    @for (index, piece) in evidence(report).iter().enumerate() {
                        @if index % 2 == 1 { b { (piece) } } @else { (piece) }
                    }
                }
            }
            div.answers {
                section aria-labelledby="sure" {
                    h2 id="sure" { (t("How sure")) }
                    @for words in certainty(report) { p { (words) } }
                }
                section aria-labelledby="where-short" {
                    h2 id="where-short" { (t("Where and when")) }
                    (where_and_when(report, detail))
                }
                section aria-labelledby="do" {
                    h2 id="do" { (t("What to do")) }
                    ol { @for step in advice(report) { li { (step) } } }
                }
            }
            (traces::before_and_after(report, detail))
            (gaps::bars(report))
            p.note {
                (t("Gap: RMS error of a prediction over ten seconds, divided by the noise of the sensor; 1 (dotted) is as good as the sensors can tell.")) " "
                b { (t("Nominal")) } ": " (t("the model as the vehicle file states it.")) " "
                b { (t("Calibrated")) } ": " (t("with its tolerances fitted.")) " "
                b { (t("Extended")) } ": " (t("with tolerances and effects fitted.")) " "
                @if report.gap.natural.is_some() {
                    b { (t("A right model")) } ": " (t("what drifting pads, gusts and noise would leave if the calibrated model were right.")) " "
                }
                b { (t("Holdout")) } ": " (t("runs that no model was fitted on, only predicted."))
            }
        }
    }
}

fn where_and_when(report: &Report, detail: &Detail) -> Markup {
    let terms: Vec<String> = report.effects.iter().map(|effect| effect.term.clone()).collect();
    let mut named: Vec<String> = Vec::new();
    for words in terms.iter().map(|name| term(name)) {
        if !named.contains(&words) {
            named.push(words);
        }
    }
    html! {
        p {
            @if report.verdict == Verdict::None { (t("No part of the model stands out.")) }
            @else if named.is_empty() { (filled("In {place}.", &[("place", html! { b { (place(report)) } })])) }
            @else { (filled("In {place}.", &[("place", html! { b { (list(&named)) } })])) }
            @if let Some(found) = &report.location.regime {
                " "
                (filled("Largest with {range}: gap {inside} there, {outside} elsewhere.", &[
                    ("range", html! { b { (regime(found, &detail.heat_map)) } }),
                    ("inside", html! { (gap(found.gap_inside)) }),
                    ("outside", html! { (gap(found.gap_outside)) }),
                ]))
            }
        }
        @let seen = seen(detail);
        @if !seen.is_empty() { p { (say("Seen in the recordings: {text}.", &[("text", &list(&seen))])) } }
    }
}

/// Events in words: those of the picture, else the most severe ones of the case.
fn seen(detail: &Detail) -> Vec<String> {
    let pictured: Vec<&Event> =
        detail.worst_window.iter().flat_map(|window| window.among(&detail.events)).collect();
    let mut events = if pictured.is_empty() { detail.events.iter().collect() } else { pictured };
    events.sort_by(|a, b| b.severity.total_cmp(&a.severity));
    events.truncate(MOST_EVENTS);
    events.sort_by(|a, b| {
        (&a.run, a.from_s).partial_cmp(&(&b.run, b.from_s)).unwrap_or(std::cmp::Ordering::Equal)
    });
    let words = |event: &&Event| {
        let (what, at) = (reword(&event.words), decimals(event.from_s, 1));
        say("{what} at {time} s of {free}", &[("what", &what), ("time", &at), ("free", &event.run)])
    };
    events.iter().map(words).collect()
}
