//! Two reports of one vehicle on a page: what has changed, both gaps, and each value beside its predecessor.

use super::chart::{Frame, range, svg, ticks};
use super::document::{frame, unbroken};
use crate::answer::compare::{EffectChange, ParameterChange, effects};
use crate::answer::schema::ParameterEstimate;
use crate::words::compare::{Named, changes, differs, value};
use crate::words::format::{capital, gap, list, number, percent, plain, signal};
use crate::words::parameters::{self, shown};
use crate::words::sentences::verdict;
use maud::{Markup, html};
use railgrip_words::{say, t};

/// The page.
pub fn render(first: Named<'_>, second: Named<'_>) -> String {
    let said = changes(first, second);
    let body = html! {
        div.sheet {
            header.top {
                p.eyebrow { span { (t("Sim-to-real gap, compared")) } strong { (first.name) " → " (second.name) } }
                h1 { (unbroken(said.first().map_or("", String::as_str))) }
                @for words in said.iter().skip(1) { p.lede { (words) } }
            }
            (gaps(first, second))
            (values(first, second))
        }
        (places(first, second))
    };
    frame(&format!("{} → {}: {}", first.name, second.name, t("sim-to-real gap")), &body)
}

fn gaps(first: Named<'_>, second: Named<'_>) -> Markup {
    let both = [first, second];
    html! {
        section aria-labelledby="gaps" {
            h2 id="gaps" { (t("Holdout gap")) }
            div.scroll { table {
                caption { (t("RMS error of a prediction over ten seconds, divided by the noise of the sensor, on runs that were only predicted")) }
                thead { tr {
                    th scope="col" { (t("Report")) } th scope="col" { (t("Verdict")) } th.n scope="col" { (t("Nominal")) }
                    th.n scope="col" { (t("Calibrated")) } th.n scope="col" { (t("Extended")) } th.n scope="col" { (t("Reduction (95 % interval)")) }
                } }
                tbody {
                    @for Named { name, report } in both {
                        @let holdout = &report.gap.holdout;
                        @let [low, high] = holdout.reduction_ci95.map(percent);
                        tr {
                            th scope="row" { (name) }
                            td { (verdict(report)) }
                            td.n { (gap(holdout.nominal)) }
                            td.n { (gap(holdout.calibrated)) }
                            td.n { b { @if report.effects.is_empty() { "–" } @else { (gap(holdout.extended)) } } }
                            td.n { @if report.effects.is_empty() { "–" } @else { (percent(holdout.reduction)) " (" (say("{low} to {high}", &[("low", &low), ("high", &high)])) ")" } }
                        }
                    }
                }
            } }
        }
    }
}

fn values(first: Named<'_>, second: Named<'_>) -> Markup {
    let all = effects(first.report, second.report);
    html! {
        @if !all.is_empty() {
            section aria-labelledby="values" {
                h2 id="values" { (t("What was found, value by value")) }
                p.note {
                    (say(
                        "Ring: {first}. Dot: {second}. Lines are 95 % intervals. Two values differ where their distance is more than both intervals together explain.",
                        &[("first", &first.name), ("second", &second.name)],
                    ))
                }
                div.scroll { table.rows {
                    caption { (t("Parameters of the effects")) }
                    thead { tr {
                        th scope="col" { (t("Parameter")) } th scope="col" { (first.name) } th scope="col" { (second.name) }
                        th scope="col" { (t("Both")) } th scope="col" { (t("Differs")) }
                    } }
                    tbody {
                        @for effect in &all { @for p in &effect.parameters { (row(effect, p)) } }
                    }
                } }
            }
        }
    }
}

fn row(effect: &EffectChange, p: &ParameterChange) -> Markup {
    let told = |estimate: &Option<ParameterEstimate>| value(&effect.id, &p.name, estimate.as_ref());
    html! {
        tr {
            th scope="row" { (capital(&plain(&effect.id))) ": " (parameters::name(&p.name)) }
            td { (told(&p.first)) }
            td { (told(&p.second)) }
            td { (picture(&effect.id, p)) }
            td data-label=(t("Differs")) { @if p.differs { b { (t("yes")) } } @else { (differs(p)) } }
        }
    }
}

/// Both values with their intervals on one axis; nothing for values that were chosen.
fn picture(id: &str, p: &ParameterChange) -> Markup {
    let scale = shown(id, &p.name);
    let told = |e: &ParameterEstimate| [e.ci95[0], e.value, e.ci95[1]].map(|x| scale.factor * x);
    let (first, second) = (p.first.as_ref().map(told), p.second.as_ref().map(told));
    let ends = [first, second].into_iter().flatten().flatten();
    let wide = [first, second].iter().flatten().any(|[low, _, high]| high > low);
    let Some(x) = range(ends).filter(|_| wide) else { return html! {} };
    let at = Frame { left: 4.0, top: 2.0, width: 202.0, height: 26.0, x, y: (0.0, 1.0) };
    let marks = html! {
        @for tick in ticks(x, 3) { (at.tick(tick, &number(tick))) }
        @for (class, y, told) in [("first", 0.75, first), ("second", 0.3, second)] {
            @if let Some([low, value, high]) = told {
                (at.line("interval", [[low, y], [high, y]].into_iter()))
                (at.dots(class, 3.4, &[[value, y]]))
            }
        }
    };
    let both = [&p.first, &p.second].map(|estimate| value(id, &p.name, estimate.as_ref()));
    let describe = list(&both);
    svg("both", 210.0, 44.0, &parameters::name(&p.name), &describe, &marks)
}

fn places(first: Named<'_>, second: Named<'_>) -> Markup {
    let (before, after) = (&first.report.location.signals, &second.report.location.signals);
    html! {
        @if after.len() > 1 {
            section aria-labelledby="outputs" {
                h2 id="outputs" { (t("Where it lies")) }
                div.scroll { table {
                    caption { (t("Gap of the calibrated model on the fitted runs, and share of the whole")) }
                    thead { tr { th scope="col" { (t("Output")) } th.n scope="col" { (first.name) } th.n scope="col" { (second.name) } } }
                    tbody {
                        @for entry in after {
                            @let other = before.iter().find(|other| other.name == entry.name);
                            tr {
                                th scope="row" { (signal(&entry.name)) }
                                td.n { @if let Some(other) = other { (gap(other.gap)) " · " (percent(other.share)) } @else { "–" } }
                                td.n { (gap(entry.gap)) " · " (percent(entry.share)) }
                            }
                        }
                    }
                } }
            }
        }
    }
}
