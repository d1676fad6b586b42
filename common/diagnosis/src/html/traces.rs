//! Measured against calibrated against extended: traces of the worst window, or points of a bench.

use super::chart::{Frame, legend, range, svg};
use super::words::{gap, signal};
use crate::answer::supplement::{Axis, Detail, Scatter, Trace, TraceWindow};
use maud::{Markup, html};

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
                h2 id="worst" { "The worst window" }
                p.say {
                    "Run " code { (window.run) } ", window " (window.window) ", "
                    @if window.holdout { "a run that was only predicted" } @else { "a run that was fitted on" }
                    ". Every model starts at the measured state and runs open loop. Below each output its error in sensor sigmas, averaged over neighbours."
                }
                (legend(Some("line"), &MODELS))
                @for (index, trace) in window.traces.iter().enumerate() { (output(window, trace, index)) }
            }
        }
        @if !detail.scatters.is_empty() {
            section aria-labelledby="points" {
                h2 id="points" { "Points and models" }
                p.say { "Lines are the models' predictions at the measured points, averaged over neighbours." }
                (legend(Some("dots"), &MODELS))
                div.pair { @for (index, panel) in detail.scatters.iter().enumerate() { (scatter(panel, index)) } }
            }
        }
    }
}

/// Line styles of the models.
pub const MODELS: [(&str, &str); 3] =
    [("nominal-line", "nominal"), ("calibrated-line", "calibrated"), ("extended-line", "extended")];

fn output(window: &TraceWindow, trace: &Trace, index: usize) -> Markup {
    let Some(frame) = outer_frame(window, trace) else { return html! {} };
    let time = &window.t_s;
    let line = |class: &str, values: &[f64]| frame.line(class, pairs(time, values));
    let axis = Axis { label: signal(&trace.name), unit: trace.unit.clone() };
    let error = |values: &[f64]| -> Vec<f64> {
        values.iter().zip(&trace.measured).map(|(value, measured)| (value - measured) / trace.sigma).collect()
    };
    let (calibrated, extended) = (error(&trace.calibrated), error(&trace.extended));
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
        (frame.clipped(&format!("trace-{index}"), html! {
            (line("measured-line", &trace.measured))
            (line("nominal-line", &trace.nominal))
            (line("calibrated-line", &trace.calibrated))
            (line("extended-line", &trace.extended))
        }))
        (below.axes(Some(&time_axis), "error / sigma", 6))
        (below.stripe("limit", -1.0, 1.0))
        (below.line("calibrated-line", smoothed(time, &calibrated).into_iter()))
        (below.line("extended-line", smoothed(time, &extended).into_iter()))
    };
    let title = format!("{} over time, measured and predicted", signal(&trace.name));
    let describe =
        format!("RMS error {} sigmas calibrated, {} sigmas extended", gap(rms_before), gap(rms_after));
    html! {
        figure {
            div.scroll { (svg("plot", WIDTH, 30.0 + TRACE_HEIGHT + 30.0 + ERROR_HEIGHT + 42.0, &title, &describe, &marks)) }
            figcaption { (signal(&trace.name)) ": RMS error " (gap(rms_before)) " → " (gap(rms_after)) " sigma." }
        }
    }
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

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt()
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
    let describe = format!("{} measured points and the lines of three models", panel.measured.len());
    html! { figure { (svg("plot", width, height, &panel.title, &describe, &marks)) figcaption { (panel.title) } } }
}
