//! What was understood of a file of unknown columns: the first minute of each, and the mapping that is proposed.

use super::chart::{Frame, range, svg};
use super::document;
use crate::answer::supplement::Axis;
use maud::html;
use railgrip_recording::FirstMinute;
use railgrip_words::{say, t};

const WIDTH: f64 = 860.0;
const LEFT: f64 = 64.0;
const HEIGHT: f64 = 112.0;

/// The page; `timed` says whether a time was understood, without which the rows are counted.
pub fn render(file: &str, columns: &[FirstMinute], proposal: &str, timed: bool) -> String {
    let body = html! {
        header { h1 { (say("What {file} may mean", &[("file", &file)])) } }
        section {
            p.say {
                @if timed { (t("The first minute of each column that was understood, as the mapping below reads it.")) }
                @else { (t("No time was understood: the first rows of each column, as the mapping below reads it.")) }
            }
            @for (index, column) in columns.iter().enumerate() {
                @let across = column.points.last().map_or(1.0, |last| last[0]).max(1e-3);
                @let points = || column.points.iter().copied();
                @let title = format!("{} ({}): {}", column.to, column.unit, column.from);
                @if let Some(y) = range(points().map(|point| point[1])) {
                    @let frame = Frame { left: LEFT, top: 30.0, width: WIDTH - LEFT - 12.0, height: HEIGHT, x: (0.0, across), y };
                    @let axis = match timed {
                        true => Axis { label: "time".to_owned(), unit: "s".to_owned() },
                        false => Axis { label: "row".to_owned(), unit: String::new() },
                    };
                    @let marks = html! {
                        (frame.axes(Some(&axis), &title, 4))
                        (frame.clipped(&format!("column-{index}"), frame.line("calibrated-line", points().collect::<Vec<_>>().into_iter())))
                    };
                    figure { (svg("plot", WIDTH, HEIGHT + 74.0, &title, t("As it was understood, over time."), &marks)) }
                } @else {
                    p { (title) ": " (t("no value in the first minute")) }
                }
            }
        }
        section {
            h2 { (t("Proposed mapping")) }
            pre { code { (proposal) } }
        }
    };
    document::frame(file, &body)
}
