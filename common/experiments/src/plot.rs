//! Figures of several panels as SVG.

use crate::ExperimentError;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::Path;

/// Colours that stay apart for the colour-blind (Okabe & Ito), in order of use.
pub const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Thin line.
    Line,
    /// Thick line.
    Bold,
    /// Dots.
    Dots,
}

/// One series.
#[derive(Clone, Debug)]
pub struct Series {
    /// Label in the legend; empty: none.
    pub label: String,
    /// Colour.
    pub colour: RGBColor,
    /// How.
    pub mark: Mark,
    /// Points.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// A series; `colour` counts in [`COLOURS`].
    pub fn new(label: impl Into<String>, colour: usize, mark: Mark, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.into(), colour: COLOURS[colour % COLOURS.len()], mark, points }
    }
}

/// One panel.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Title.
    pub title: String,
    /// Name of the horizontal axis, with its unit.
    pub x_label: &'static str,
    /// Name of the vertical axis, with its unit.
    pub y_label: &'static str,
    /// Ends of the horizontal axis; absent: from the data.
    pub x_range: Option<(f64, f64)>,
    /// Ends of the vertical axis; absent: from the data.
    pub y_range: Option<(f64, f64)>,
    /// Series, first below.
    pub series: Vec<Series>,
}

impl Panel {
    /// An empty panel.
    pub fn new(title: impl Into<String>, x_label: &'static str, y_label: &'static str) -> Self {
        Self { title: title.into(), x_label, y_label, x_range: None, y_range: None, series: Vec::new() }
    }

    /// With ends of the horizontal axis.
    pub fn x(mut self, from: f64, to: f64) -> Self {
        self.x_range = Some((from, to));
        self
    }

    /// With ends of the vertical axis.
    pub fn y(mut self, from: f64, to: f64) -> Self {
        self.y_range = Some((from, to));
        self
    }

    /// With one more series.
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    fn range(&self, given: Option<(f64, f64)>, pick: impl Fn(&(f64, f64)) -> f64) -> (f64, f64) {
        let from_data = || {
            let values = self.series.iter().flat_map(|series| &series.points).map(&pick);
            let (low, high) = values
                .filter(|value| value.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                    (low.min(value), high.max(value))
                });
            if low > high {
                return (0.0, 1.0);
            }
            let margin = if high > low { 0.05 * (high - low) } else { 0.5 * low.abs().max(1.0) };
            (low - margin, high + margin)
        };
        given.unwrap_or_else(from_data)
    }
}

/// Draws `panels` row by row in a grid of `columns`, each panel `size` pixels.
///
/// # Errors
/// If the file cannot be written.
pub fn write_svg(
    path: &Path,
    columns: usize,
    size: (u32, u32),
    panels: &[Panel],
) -> Result<(), ExperimentError> {
    let rows = panels.len().div_ceil(columns);
    let whole = (size.0 * columns as u32, size.1 * rows as u32);
    let draw = || -> Result<(), Box<dyn std::error::Error>> {
        let root = SVGBackend::new(path, whole).into_drawing_area();
        root.fill(&WHITE)?;
        for (area, panel) in root.split_evenly((rows, columns)).iter().zip(panels) {
            draw_panel(area, panel)?;
        }
        root.present()?;
        Ok(())
    };
    draw().map_err(|error| ExperimentError::Draw { path: path.to_owned(), message: error.to_string() })
}

/// A part of a figure.
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Names the series in a strip above the plot, where no curve runs; returns what is left of the area.
fn draw_legend<'a>(area: &Area<'a>, panel: &Panel) -> Result<Area<'a>, Box<dyn std::error::Error>> {
    const LEFT: i32 = 66;
    const ROW: i32 = 17;
    let style = ("sans-serif", 12).into_text_style(area);
    let (mut x, mut row, mut places) = (LEFT, 0, Vec::new());
    for series in panel.series.iter().filter(|series| !series.label.is_empty()) {
        let width = 40 + area.estimate_text_size(&series.label, &style)?.0 as i32;
        if x > LEFT && x + width > area.dim_in_pixel().0 as i32 {
            (x, row) = (LEFT, row + 1);
        }
        places.push((series, x, row * ROW + ROW / 2));
        x += width;
    }
    if places.is_empty() {
        return Ok(area.clone());
    }
    let (strip, rest) = area.split_vertically(ROW * (row + 1));
    for (series, x, y) in places {
        strip.draw(&PathElement::new(vec![(x, y), (x + 16, y)], series.colour.stroke_width(2)))?;
        strip.draw(&Text::new(series.label.as_str(), (x + 22, y - 6), style.clone()))?;
    }
    Ok(rest)
}

fn draw_panel(area: &Area<'_>, panel: &Panel) -> Result<(), Box<dyn std::error::Error>> {
    let area = draw_legend(&area.titled(&panel.title, ("sans-serif", 15))?, panel)?;
    let (x_low, x_high) = panel.range(panel.x_range, |point| point.0);
    let (y_low, y_high) = panel.range(panel.y_range, |point| point.1);
    let mut chart = ChartBuilder::on(&area)
        .margin(8)
        .margin_right(16)
        .x_label_area_size(34)
        .y_label_area_size(58)
        .build_cartesian_2d(x_low..x_high, y_low..y_high)?;
    let decimals = |low: f64, high: f64| (1.0 - (high - low).log10().floor()).clamp(0.0, 6.0) as usize;
    let (x_decimals, y_decimals) = (decimals(x_low, x_high), decimals(y_low, y_high));
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(225, 225, 225))
        .x_labels(8)
        .y_labels(6)
        .x_label_formatter(&|value| format!("{value:.x_decimals$}"))
        .y_label_formatter(&|value| format!("{value:.y_decimals$}"))
        .label_style(("sans-serif", 12))
        .x_desc(panel.x_label)
        .y_desc(panel.y_label)
        .draw()?;
    for series in &panel.series {
        let colour = series.colour;
        let width = if series.mark == Mark::Bold { 2 } else { 1 };
        if series.mark == Mark::Dots {
            let inside = (series.points.iter().copied())
                .filter(|(x, y)| (x_low..=x_high).contains(x) && (y_low..=y_high).contains(y));
            chart.draw_series(inside.map(|point| Circle::new(point, 1, colour.filled())))?;
        }
        // A value that is not a number interrupts a line.
        for piece in series.points.split(|(x, y)| !x.is_finite() || !y.is_finite()) {
            let clipped = (piece.iter().copied())
                .filter(|(x, _)| (x_low..=x_high).contains(x))
                .map(|(x, y)| (x, y.clamp(y_low, y_high)));
            let style = colour.stroke_width(width);
            if series.mark == Mark::Dots || piece.is_empty() {
                continue;
            }
            chart.draw_series(LineSeries::new(clipped, style))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vertical places of the points of all curves, and the vertical place of a label, in pixels from the top.
    fn places(svg: &str, label: &str) -> (Vec<f64>, f64) {
        let attribute = |element: &str, name: &str| {
            let (_, rest) = element.split_once(&format!("{name}=\"")).expect("attribute");
            rest.split('"').next().expect("an end").to_owned()
        };
        let curves = svg.split("<polyline ").skip(1).map(|element| attribute(element, "points"));
        // The samples in the legend have two points.
        let curves = curves.filter(|points| points.split_whitespace().count() > 2);
        let heights = curves.flat_map(|points| {
            let ends =
                points.split_whitespace().map(|point| point.split_once(',').expect("x,y").1.to_owned());
            ends.map(|y| y.parse().expect("a number")).collect::<Vec<f64>>()
        });
        let text = svg.split("<text ").skip(1).find(|text| text.contains(label)).expect("the label");
        (heights.collect(), attribute(text, " y").parse().expect("a number"))
    }

    #[test]
    fn legends_stand_above_every_curve() {
        let curve = |height: f64| (0..50).map(|x| (f64::from(x), height)).collect::<Vec<_>>();
        let labels =
            ["a label of some length", "another label of some length", "a third one, which needs a row"];
        let mut panel = Panel::new("Legends", "x", "y").y(0.0, 1.0);
        for (number, label) in labels.iter().enumerate() {
            panel = panel.with(Series::new(*label, number, Mark::Bold, curve(1.0 - 0.5 * number as f64)));
        }
        let path = std::env::temp_dir().join(format!("railgrip-legends-{}.svg", std::process::id()));
        write_svg(&path, 1, (360, 240), &[panel]).expect("drawn");
        let svg = std::fs::read_to_string(&path).expect("svg");
        std::fs::remove_file(&path).expect("removed");
        for label in labels {
            let (curves, label_y) = places(&svg, label);
            let top = curves.iter().copied().fold(f64::INFINITY, f64::min);
            assert!(curves.len() >= 150 && label_y < top, "{label}: {label_y} px, curves from {top} px");
        }
    }
}
