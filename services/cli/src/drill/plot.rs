//! The score as two figures: how soon faults are found against their size, and which cause is named for which.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use plotters::prelude::*;

use super::score::{Found, Score, at_place};
use crate::CliError;

const INK: RGBColor = RGBColor(30, 30, 30);
const FOUND: RGBColor = RGBColor(0, 96, 160);
const MISSED: RGBColor = RGBColor(190, 60, 30);
/// What was named where nothing was, and where another place was.
const NOTHING: &str = "nothing";
const ELSEWHERE: &str = "another place";

/// Applications until a fault was found, over its size as a share of what must be found; those never found stand at the top.
pub(super) fn delays(score: &Score, file: &Path) -> Result<(), CliError> {
    let told: Vec<&Found> = score.found.iter().filter(|found| found.could_show()).collect();
    let mut kinds: BTreeMap<&str, Vec<&Found>> = BTreeMap::new();
    for found in told {
        kinds.entry(&found.fault.id).or_default().push(found);
    }
    let top =
        kinds.values().flatten().filter_map(|found| found.after_brakings).max().unwrap_or(0).max(10) + 2;
    let height = 60 + 26 * kinds.len().max(4) as u32;
    let root = SVGBackend::new(file, (860, height)).into_drawing_area();
    let failed = |error: &dyn std::fmt::Display| CliError::failed(format!("{}: {error}", file.display()));
    root.fill(&WHITE).map_err(|error| failed(&error))?;
    let mut chart = ChartBuilder::on(&root)
        .margin(12)
        .x_label_area_size(34)
        .y_label_area_size(170)
        .build_cartesian_2d(-0.5..top as f64 + 0.5, -0.5..kinds.len().max(1) as f64 - 0.5)
        .map_err(|error| failed(&error))?;
    let names: Vec<&str> = kinds.keys().copied().collect();
    let name = |at: &f64| {
        let whole = (at - at.round()).abs() < 1e-6 && *at > -0.5;
        whole
            .then(|| names.get(at.round() as usize))
            .flatten()
            .map_or_else(String::new, |name| (*name).to_owned())
    };
    let count = |at: &f64| match at.round() as usize {
        at if at == top => "never".to_owned(),
        at => at.to_string(),
    };
    chart
        .configure_mesh()
        .disable_y_mesh()
        .y_labels(2 * names.len().max(1) + 1)
        .y_label_formatter(&name)
        .x_labels(top + 1)
        .x_label_formatter(&count)
        .x_desc("brake applications from the onset to the alert; a larger disc is a larger fault")
        .label_style(("sans-serif", 12).into_font().color(&INK))
        .draw()
        .map_err(|error| failed(&error))?;
    let discs = kinds.values().enumerate().flat_map(|(row, list)| {
        let largest = list.iter().map(|found| found.fault.size.abs()).fold(f64::MIN_POSITIVE, f64::max);
        list.iter().map(move |found| {
            let (at, colour) = match found.after_brakings {
                Some(after) => (after, FOUND),
                None => (top, MISSED),
            };
            let size = 3.0 + 6.0 * found.fault.size.abs() / largest;
            Circle::new((at as f64, row as f64), size, colour.mix(0.55).filled())
        })
    });
    chart.draw_series(discs).map_err(|error| failed(&error))?;
    root.present().map_err(|error| failed(&error))
}

/// Which cause was named first (across) for which (down), with how often.
pub(super) fn confusion(score: &Score, file: &Path) -> Result<(), CliError> {
    let told = || score.found.iter().filter(|found| found.could_show());
    let named = |found: &Found| match &found.first {
        Some(alert) if at_place(alert, &found.fault) => alert.cause.word(),
        Some(_) => ELSEWHERE,
        None => NOTHING,
    };
    let mut cells: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for found in told() {
        *cells.entry((&found.fault.cause, named(found))).or_default() += 1;
    }
    let truths: Vec<&str> =
        cells.keys().map(|(truth, _)| *truth).collect::<BTreeSet<_>>().into_iter().collect();
    let mut named: Vec<&str> =
        cells.keys().map(|(_, named)| *named).collect::<BTreeSet<_>>().into_iter().collect();
    named.sort_by_key(|name| (matches!(*name, NOTHING | ELSEWHERE), *name));
    let (left, above, side) = (160, 150, 34);
    let whole = (
        left as u32 + side as u32 * named.len().max(1) as u32 + 20,
        above as u32 + side as u32 * truths.len().max(1) as u32 + 20,
    );
    let root = SVGBackend::new(file, whole).into_drawing_area();
    let failed = |error: &dyn std::fmt::Display| CliError::failed(format!("{}: {error}", file.display()));
    root.fill(&WHITE).map_err(|error| failed(&error))?;
    let style = ("sans-serif", 12).into_font().color(&INK);
    let upright = ("sans-serif", 12).into_font().transform(FontTransform::Rotate270).color(&INK);
    for (column, name) in named.iter().enumerate() {
        let at = (left + side * column as i32 + 10, above - 6);
        root.draw(&Text::new((*name).to_owned(), at, &upright)).map_err(|error| failed(&error))?;
    }
    for (row, truth) in truths.iter().enumerate() {
        let y = above + side * row as i32;
        root.draw(&Text::new((*truth).to_owned(), (8, y + 10), &style)).map_err(|error| failed(&error))?;
        let all: usize = cells.iter().filter(|((own, _), _)| own == truth).map(|(_, count)| count).sum();
        for (column, name) in named.iter().enumerate() {
            let Some(count) = cells.get(&(*truth, *name)) else { continue };
            let x = left + side * column as i32;
            let colour = if name == truth { FOUND } else { MISSED };
            let share = 0.15 + 0.75 * *count as f64 / all.max(1) as f64;
            let cell = Rectangle::new([(x, y), (x + side - 2, y + side - 2)], colour.mix(share).filled());
            root.draw(&cell).map_err(|error| failed(&error))?;
            root.draw(&Text::new(count.to_string(), (x + 12, y + 10), &style))
                .map_err(|error| failed(&error))?;
        }
    }
    root.present().map_err(|error| failed(&error))
}
