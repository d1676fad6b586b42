//! Measured against calibrated against extended: traces of the worst window, or points of a bench.

use super::chart::{Frame, legend, range, svg};
use crate::answer::schema::Report;
use crate::answer::supplement::{Axis, Detail, Event, Scatter, Trace, TraceWindow, rms};
use crate::words::format::{capital, gap, number_to, signal};
use maud::{Markup, html};
use railgrip_words::{reword, say, t};

const WIDTH: f64 = 860.0;
const LEFT: f64 = 64.0;
const TRACE_HEIGHT: f64 = 112.0;
/// Points of an error line.
const ERROR_POINTS: usize = 160;
const ERROR_HEIGHT: f64 = 96.0;

/// The section; nothing where there is neither a window nor a scatter.
pub fn section(detail: &Detail) -> Markup {
    html! {
        @if let Some(window) = &detail.worst_window {
            section aria-labelledby="worst" {
                h2 id="worst" { (t("The worst window")) }
                p.say {
                    @if window.holdout {
                        (say("{stretch} is where the calibrated model errs most among the runs that were only predicted.", &[("stretch", &stretch(window))]))
                    } @else { (say("{stretch} is where the calibrated model errs most, a run that was fitted.", &[("stretch", &stretch(window))])) }
                    " "
                    (t("A window is ten seconds long; every model starts at the measured state and is then driven by the recorded inputs alone. Under each output stands its error in units of the sensor's noise (sigma), averaged over neighbouring samples."))
                }
                (legend(Some("line"), models(window.traces.iter().all(|trace| trace.extended.is_empty()))))
                @for (index, trace) in window.traces.iter().enumerate() { (output(window, trace, &format!("trace-{index}"), &detail.events)) }
            }
        }
        @if !detail.scatters.is_empty() {
            section aria-labelledby="points" {
                h2 id="points" { (t("Points and models")) }
                p.say { (t("Lines are the models' predictions at the measured points, averaged over neighbouring points.")) }
                (legend(Some("dots"), models(detail.scatters.iter().all(|panel| panel.extended.is_empty()))))
                div.pair { @for (index, panel) in detail.scatters.iter().enumerate() { (scatter(panel, index)) } }
            }
        }
    }
}

/// Line styles of the models.
const MODELS: [(&str, &str); 3] =
    [("nominal-line", "nominal"), ("calibrated-line", "calibrated"), ("extended-line", "extended")];

/// The models that are drawn: without an effect there is no extended one.
fn models(without_extended: bool) -> &'static [(&'static str, &'static str)] {
    if without_extended { &MODELS[..2] } else { &MODELS }
}

/// One picture of before and after for the first page: the output that the calibrated model misses most in the window, or
/// the first panel of a bench.
pub fn before_and_after(report: &Report, detail: &Detail) -> Markup {
    let worst = detail.worst_window.as_ref().and_then(|window| {
        let error = |trace: &Trace| rms(&trace.errors(&trace.calibrated));
        Some((window, window.traces.iter().max_by(|a, b| error(a).total_cmp(&error(b)))?))
    });
    let without = report.effects.is_empty();
    html! {
        @if let Some((window, trace)) = worst {
            section.picture aria-labelledby="picture" {
                h2 id="picture" { @if without { (t("What the model misses")) } @else { (t("Before and after")) } }
                p.note { (say("{stretch}, the worst for the calibrated model. Every model starts at the measured state and is then driven by the recorded inputs alone.", &[("stretch", &stretch(window))])) }
                (legend(Some("line"), models(trace.extended.is_empty())))
                (output(window, trace, "first", &detail.events))
            }
        } @else if let Some(panel) = detail.scatters.first() {
            section.picture aria-labelledby="picture" {
                h2 id="picture" { @if without { (t("What the model misses")) } @else { (t("Before and after")) } }
                (legend(Some("dots"), models(panel.extended.is_empty())))
                (scatter(panel, usize::MAX))
            }
        }
    }
}

/// `The seconds 30 to 40 of run dry_stop.dry`.
fn stretch(window: &TraceWindow) -> String {
    let end = |t: Option<&f64>| t.map_or_else(|| "–".to_owned(), |t| number_to(t.round(), 4));
    let (from, to) = (end(window.t_s.first()), end(window.t_s.last()));
    say("The seconds {from} to {to} of run {free}", &[("from", &from), ("to", &to), ("free", &window.run)])
}

fn output(window: &TraceWindow, trace: &Trace, id: &str, events: &[Event]) -> Markup {
    let Some(frame) = outer_frame(window, trace) else { return html! {} };
    let time = &window.t_s;
    let line = |class: &str, values: &[f64]| frame.line(class, pairs(time, values));
    let axis = Axis { label: signal(&trace.name), unit: trace.unit.clone() };
    let (calibrated, extended) = (trace.errors(&trace.calibrated), trace.errors(&trace.extended));
    let (rms_before, rms_after) = (rms(&calibrated), rms(&extended));
    let reach =
        calibrated.iter().chain(&extended).filter(|x| x.is_finite()).fold(3.0_f64, |top, x| top.max(x.abs()));
    let below = Frame {
        top: 30.0 + TRACE_HEIGHT + 30.0,
        height: ERROR_HEIGHT,
        y: (-1.08 * reach, 1.08 * reach),
        ..frame.clone()
    };
    let time_axis = Axis { label: "time".to_owned(), unit: "s".to_owned() };
    let marks = html! {
        (frame.axes(None, &super::chart::with_unit(&axis), 4))
        (frame.clipped(id, html! {
            (line("measured-line", &trace.measured))
            (line("nominal-line", &trace.nominal))
            (line("calibrated-line", &trace.calibrated))
            (line("extended-line", &trace.extended))
        }))
        (moments(&frame, window, trace, events))
        (below.axes(Some(&time_axis), t("error in units of the sensor's noise; grey: within the noise"), 6))
        (below.stripe("limit", -1.0, 1.0))
        (below.line("calibrated-line", smoothed(time, &calibrated).into_iter()))
        (below.line("extended-line", smoothed(time, &extended).into_iter()))
    };
    let title = say("{what} over time, measured and predicted", &[("what", &signal(&trace.name))]);
    let describe = match trace.extended.is_empty() {
        true => say("RMS error {gap} times the sensor's noise, calibrated", &[("gap", &gap(rms_before))]),
        false => say(
            "RMS error {before} times the sensor's noise before (calibrated), {after} after (extended)",
            &[("before", &gap(rms_before)), ("after", &gap(rms_after))],
        ),
    };
    html! {
        figure {
            div.scroll { (svg("plot", WIDTH, 30.0 + TRACE_HEIGHT + 30.0 + ERROR_HEIGHT + 42.0, &title, &describe, &marks)) }
            figcaption { (capital(&signal(&trace.name))) ". " (describe) "." }
        }
    }
}

/// Beginnings of what happens to the wheelset of this output; names that would lie on another one are left out.
fn moments(frame: &Frame, window: &TraceWindow, trace: &Trace, events: &[Event]) -> Markup {
    let wheelset =
        window.traces.iter().position(|other| other.name == trace.name).and_then(|at| at.checked_sub(1));
    let mut named: Vec<f64> = Vec::new();
    let marks =
        window.among(events).into_iter().filter(|e| wheelset.is_none_or(|w| e.wheelset == w)).map(|event| {
            let apart = 0.25 * (frame.x.1 - frame.x.0);
            let room = named.iter().all(|at| (event.from_s - at).abs() > apart);
            if room {
                named.push(event.from_s);
            }
            let words = reword(&event.words);
            frame.moment(event.from_s, if room { &words } else { "" })
        });
    let marks: Vec<Markup> = marks.collect();
    html! { @for mark in marks { (mark) } }
}

fn outer_frame(window: &TraceWindow, trace: &Trace) -> Option<Frame> {
    let all = [&trace.measured, &trace.calibrated, &trace.extended];
    let y = range(all.into_iter().flatten().copied())?;
    let x = (window.t_s.first().copied()?, window.t_s.last().copied()?);
    Some(Frame { left: LEFT, top: 30.0, width: WIDTH - LEFT - 10.0, height: TRACE_HEIGHT, x, y })
}

fn pairs<'a>(time: &'a [f64], values: &'a [f64]) -> impl ExactSizeIterator<Item = [f64; 2]> + 'a {
    time.iter().zip(values).map(|(t, x)| [*t, *x])
}

/// Means over a few neighbours, so that a line shows the model's error and not the sensor's noise.
fn smoothed(time: &[f64], values: &[f64]) -> Vec<[f64; 2]> {
    let size = values.len().div_ceil(ERROR_POINTS).max(1);
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    time.chunks(size).zip(values.chunks(size)).map(|(t, x)| [mean(t), mean(x)]).collect()
}

fn scatter(panel: &Scatter, index: usize) -> Markup {
    let xs = panel.measured.iter().map(|point| point[0]);
    let ys = panel.measured.iter().chain(&panel.calibrated).chain(&panel.extended).map(|point| point[1]);
    let (Some(x), Some(y)) = (range(xs), range(ys)) else { return html! {} };
    let (width, height) = (430.0, 290.0);
    let frame = Frame { left: 58.0, top: 30.0, width: width - 68.0, height: height - 74.0, x, y };
    let marks = html! {
        (frame.axes(Some(&panel.x), &super::chart::with_unit(&panel.y), 5))
        (frame.clipped(&format!("scatter-{index}"), html! {
            (frame.dots("dot", 2.1, &panel.measured))
            (frame.line("nominal-line", panel.nominal.iter().copied()))
            (frame.line("calibrated-line", panel.calibrated.iter().copied()))
            (frame.line("extended-line", panel.extended.iter().copied()))
        }))
    };
    let count = panel.measured.len();
    let describe = say("{count} measured points and the lines of the models", &[("count", &count)]);
    let title = reword(&panel.title);
    html! { figure { (svg("plot", width, height, &title, &describe, &marks)) figcaption { (capital(&title)) } } }
}
