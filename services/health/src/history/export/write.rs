//! Writes the table while it is read.

use super::table::{ExportError, Form, Layout, Sink, Wanted, Whose};
use super::{csv, parquet};
use railgrip_history::Reader;
use std::io::Write;

/// Writes what is wanted and returns the number of rows.
///
/// # Errors
/// The database or the receiver refuses, or an indicator is unknown; then nothing has been written yet.
pub fn write(
    reader: &Reader,
    wanted: &Wanted,
    form: Form,
    to: impl Write + Send,
) -> Result<u64, ExportError> {
    let layout = Layout::of(reader, wanted.fields.as_deref())?;
    let rows;
    match form {
        Form::Csv => {
            let mut sink = csv::Sheet::begin(&layout, to)?;
            rows = pieces(reader, wanted, &layout, &mut sink)?;
            sink.finish()?;
        }
        Form::Parquet => {
            let mut sink = parquet::Columns::begin(&layout, wanted.step_s, to)?;
            rows = pieces(reader, wanted, &layout, &mut sink)?;
            sink.finish(&layout)?;
        }
    }
    Ok(rows)
}

fn pieces(
    reader: &Reader,
    wanted: &Wanted,
    layout: &Layout,
    sink: &mut impl Sink,
) -> Result<u64, ExportError> {
    let names: Vec<&str> = layout.read.iter().map(String::as_str).collect();
    let step_s = wanted.step_s.max(1);
    let from_s = wanted.from_s.div_euclid(step_s) * step_s;
    let consist = &wanted.consist;
    let asked = |id: &u32| {
        let here = |place| wanted.wagons.contains(&place);
        wanted.wagons.is_empty() || consist.place(*id).is_some_and(here)
    };
    let mut rows = 0;
    for id in reader.wagons()?.into_iter().filter(asked) {
        let whose = Whose { place: consist.place(id), vehicle: consist.vehicle(id).map(str::to_owned) };
        reader.steps(id, &names, from_s, wanted.to_s, step_s, |point| {
            rows += 1;
            sink.row(layout, &whose, point)
        })?;
    }
    Ok(rows)
}
