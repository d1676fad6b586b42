//! A small plotting kit: one frame with axes, and marks in it, as SVG that takes its colours from the page.

use crate::answer::supplement::Axis;
use crate::words::format::{number, plain};
use maud::{Markup, PreEscaped, html};
use railgrip_words::{t, word};
use std::fmt::Write;

/// Most points of a line; longer lines are thinned.
const MOST_POINTS: usize = 700;

/// A plot area within an SVG.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Left edge of the plot area, px.
    pub left: f64,
    /// Top edge.
    pub top: f64,
    /// Width of the plot area.
    pub width: f64,
    /// Height of the plot area.
    pub height: f64,
    /// Range of x.
    pub x: (f64, f64),
    /// Range of y.
    pub y: (f64, f64),
}

/// The range of finite values, a little widened; `None` where there are none.
pub fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    (low <= high).then(|| {
        let width = (high - low).max(1e-9 * high.abs().max(1e-9));
        let pad = if width > 1e-6 * high.abs() { 0.06 * width } else { 0.05 * high.abs().max(1e-6) };
        (low - pad, high + pad)
    })
}

impl Frame {
    fn sx(&self, x: f64) -> f64 {
        self.left + (x - self.x.0) / (self.x.1 - self.x.0) * self.width
    }

    fn sy(&self, y: f64) -> f64 {
        self.top + (self.y.1 - y) / (self.y.1 - self.y.0) * self.height
    }

    fn bottom(&self) -> f64 {
        self.top + self.height
    }

    /// Grid, ticks and axis labels; `x_axis` is left out for panels that share the one below.
    pub fn axes(&self, x_axis: Option<&Axis>, y_axis: &str, y_ticks: usize) -> Markup {
        let right = self.left + self.width;
        html! {
            @for tick in ticks(self.y, y_ticks) {
                @let y = round(self.sy(tick));
                line class="grid" x1=(self.left) x2=(right) y1=(y) y2=(y) {}
                text x=(self.left - 7.0) y=(y + 4.0) text-anchor="end" { (number(tick)) }
            }
            line class="axis" x1=(self.left) x2=(right) y1=(self.bottom()) y2=(self.bottom()) {}
            @if let Some(axis) = x_axis {
                @for tick in ticks(self.x, 7) {
                    @let x = round(self.sx(tick));
                    line class="axis" x1=(x) x2=(x) y1=(self.bottom()) y2=(self.bottom() + 4.0) {}
                    text x=(x) y=(self.bottom() + 17.0) text-anchor="middle" { (number(tick)) }
                }
                text x=(right) y=(self.bottom() + 34.0) text-anchor="end" { (with_unit(axis)) }
            }
            text class="label" x=(self.left) y=(self.top - 8.0) { (y_axis) }
        }
    }

    /// A line; gaps where values are not finite.
    pub fn line(&self, class: &str, points: impl ExactSizeIterator<Item = [f64; 2]>) -> Markup {
        let step = points.len().div_ceil(MOST_POINTS).max(1);
        let mut path = String::new();
        let mut drawing = false;
        for [x, y] in points.step_by(step) {
            if !(x.is_finite() && y.is_finite()) {
                drawing = false;
                continue;
            }
            let y = y.clamp(self.y.0 - 4.0 * (self.y.1 - self.y.0), self.y.1 + 4.0 * (self.y.1 - self.y.0));
            let command = if drawing { 'L' } else { 'M' };
            // Writing to a string cannot fail.
            let _ = write!(path, "{command}{:.1} {:.1}", self.sx(x), self.sy(y));
            drawing = true;
        }
        // A path without points is no mark, and some programs warn of it.
        html! { @if !path.is_empty() { path class=(class) d=(path) {} } }
    }

    /// A tick below the frame.
    pub fn tick(&self, x: f64, name: &str) -> Markup {
        let (at, bottom) = (round(self.sx(x)), self.bottom());
        html! {
            line class="grid" x1=(at) x2=(at) y1=(self.top) y2=(bottom) {}
            text x=(at) y=(bottom + 13.0) text-anchor="middle" { (name) }
        }
    }

    /// A moment on the axis across, with its name, if it has one, at the top of the frame.
    pub fn moment(&self, x: f64, name: &str) -> Markup {
        let at = round(self.sx(x.clamp(self.x.0, self.x.1)));
        // Names stand on the side on which there is room.
        let (anchor, beside) =
            if x > 0.5 * (self.x.0 + self.x.1) { ("end", at - 5.0) } else { ("start", at + 5.0) };
        html! {
            line class="moment" x1=(at) x2=(at) y1=(self.top) y2=(self.bottom()) {}
            @if !name.is_empty() { text class="moment" x=(beside) y=(self.top + 11.0) text-anchor=(anchor) { (name) } }
        }
    }

    /// Dots, those outside the frame left out.
    pub fn dots(&self, class: &str, radius: f64, points: &[[f64; 2]]) -> Markup {
        let inside =
            |[x, y]: &[f64; 2]| (self.x.0..=self.x.1).contains(x) && (self.y.0..=self.y.1).contains(y);
        html! {
            @for [x, y] in points.iter().filter(|point| inside(point)) {
                circle class=(class) cx=(round(self.sx(*x))) cy=(round(self.sy(*y))) r=(radius) {}
            }
        }
    }

    /// A band between two lines.
    pub fn band(&self, points: &[(f64, f64, f64)]) -> Markup {
        let finite = points.iter().filter(|(x, l, h)| x.is_finite() && l.is_finite() && h.is_finite());
        let finite: Vec<_> = finite.collect();
        let mut path = String::new();
        let upper = finite.iter().map(|(x, _, high)| (*x, *high));
        let lower = finite.iter().rev().map(|(x, low, _)| (*x, *low));
        for (index, (x, y)) in upper.chain(lower).enumerate() {
            let command = if index == 0 { 'M' } else { 'L' };
            let y = y.clamp(self.y.0, self.y.1);
            let _ = write!(path, "{command}{:.1} {:.1}", self.sx(x), self.sy(y));
        }
        html! { @if !path.is_empty() { path class="band" d={ (path) "Z" } {} } }
    }

    /// A region of x.
    pub fn region(&self, class: &str, low: f64, high: f64) -> Markup {
        let (from, to) = (self.sx(low.max(self.x.0)), self.sx(high.min(self.x.1)));
        html! {
            rect class=(class) x=(round(from)) y=(self.top) width=(round((to - from).max(0.0))) height=(self.height) {}
        }
    }

    /// A region of y.
    pub fn stripe(&self, class: &str, low: f64, high: f64) -> Markup {
        let (from, to) = (self.sy(high.min(self.y.1)), self.sy(low.max(self.y.0)));
        html! {
            rect class=(class) x=(self.left) y=(round(from)) width=(self.width) height=(round((to - from).max(0.0))) {}
        }
    }

    /// Cuts what is drawn inside to the frame.
    pub fn clipped(&self, id: &str, marks: Markup) -> Markup {
        html! {
            clipPath id=(id) { rect x=(self.left) y=(self.top) width=(self.width) height=(self.height) {} }
            g clip-path={ "url(#" (id) ")" } { (marks) }
        }
    }
}

/// An SVG with its text alternative.
pub fn svg(class: &str, width: f64, height: f64, title: &str, describe: &str, marks: &Markup) -> Markup {
    html! {
        svg class=(class) viewBox={ "0 0 " (width) " " (height) } role="img"
            aria-label={ (title) ". " (describe) } {
            title { (title) }
            desc { (describe) }
            (marks)
        }
    }
}

/// Key to the line styles; `measured` says how measurements are drawn, if they are.
pub fn legend(measured: Option<&str>, entries: &[(&str, &str)]) -> Markup {
    html! {
        ul.legend {
            @if let Some(kind) = measured {
                li {
                    svg viewBox="0 0 34 12" aria-hidden="true" {
                        @if kind == "dots" {
                            circle class="dot" cx="8" cy="6" r="2.6" {} circle class="dot" cx="18" cy="4" r="2.6" {}
                            circle class="dot" cx="27" cy="7" r="2.6" {}
                        } @else if kind == "bins" {
                            circle class="bin" cx="9" cy="6" r="3.4" {} circle class="bin" cx="24" cy="6" r="3.4" {}
                        } @else { path class="measured-line" d="M1 7L9 4L17 8L25 4L33 6" {} }
                    }
                    @if kind == "bins" { (t("measured, means of neighbours")) } @else { (t("measured")) }
                }
            }
            @for (class, text) in entries {
                li { svg viewBox="0 0 34 12" aria-hidden="true" { path class=(class) d="M1 6L33 6" {} } (word(text)) }
            }
        }
    }
}

/// `name (unit)`.
pub fn with_unit(axis: &Axis) -> String {
    let label = plain(&axis.label);
    if axis.unit.is_empty() { label } else { format!("{label} ({})", axis.unit) }
}

/// Round values within a range, about `count` of them.
pub fn ticks((low, high): (f64, f64), count: usize) -> Vec<f64> {
    let raw = (high - low) / count.max(1) as f64;
    if raw.is_nan() || raw <= 0.0 {
        return Vec::new();
    }
    let magnitude = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * magnitude).into_iter().find(|s| *s >= raw).unwrap_or(raw);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last).map(|i| i as f64 * step).map(|x| if x.abs() < 1e-12 * step { 0.0 } else { x }).collect()
}

fn round(x: f64) -> f64 {
    (10.0 * x).round() / 10.0
}

/// Text that is already markup.
pub fn raw(text: &str) -> Markup {
    PreEscaped(text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks((0.0, 10.0), 5), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(ticks((0.013, 0.029), 4), [0.015, 0.02, 0.025]);
        assert!(ticks((1.0, 1.0), 4).is_empty());
    }
}
