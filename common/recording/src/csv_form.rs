//! Tables as CSV: comma, one header line, empty cell = missing. Numbers are written in the shortest text that reads back to the
//! same bits.

use crate::error::{Place, Problem, RecordingError, Result};
use crate::instant::instant_s;
use crate::table::{ColumnChoice, Table, Words};
use csv::ByteRecord;
use std::io::{BufRead, Read, Write};
use std::path::Path;

const BYTE_ORDER_MARK: &str = "\u{feff}";

/// What a cell may hold where nothing was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Missing {
    /// Nothing, `NaN` or an infinity.
    AnyText,
    /// Nothing: `NaN` and infinities are errors.
    Empty,
}

/// Reads the columns that `choose` wants; cells of the others may hold any text.
pub(crate) fn read(
    source: impl Read,
    file: &Path,
    choose: ColumnChoice<'_>,
    missing: Missing,
) -> Result<Table> {
    let mut source = std::io::BufReader::new(source);
    let dialect = Dialect::of(source.fill_buf().map_err(|e| RecordingError::new(file, Problem::Io(e)))?);
    let mut builder = csv::ReaderBuilder::new();
    let mut reader =
        builder.has_headers(false).flexible(true).delimiter(dialect.delimiter).from_reader(source);
    let mut record = ByteRecord::new();
    let (names, wanted) = header(&mut reader, &mut record, file, choose)?;
    let mut columns = vec![Vec::new(); names.len()];
    let mut lines = Vec::new();
    while next(&mut reader, &mut record, file)? {
        let line = line_of(&record);
        let error = |problem| RecordingError::new(file, problem).at(Place::Line(line));
        if record.len() != names.len() {
            return Err(error(Problem::Ragged { expected: names.len(), found: record.len() }));
        }
        for (index, cell) in record.iter().enumerate().filter(|(index, _)| wanted[*index]) {
            let name = &names[index];
            let value =
                number(cell, name, missing, dialect).map_err(|problem| error(problem).column(name))?;
            columns[index].push(value);
        }
        lines.push(line);
    }
    Table::chosen(file, names, columns, &wanted, Some(lines))
}

fn header(
    reader: &mut csv::Reader<impl Read>,
    record: &mut ByteRecord,
    file: &Path,
    choose: ColumnChoice<'_>,
) -> Result<(Vec<String>, Vec<bool>)> {
    if !next(reader, record, file)? {
        return Err(RecordingError::new(file, Problem::NoHeader));
    }
    let error = |problem| RecordingError::new(file, problem).at(Place::Line(line_of(record)));
    let mut names: Vec<String> = Vec::with_capacity(record.len());
    for cell in record.iter() {
        let text = std::str::from_utf8(cell).map_err(|_| error(Problem::NotText))?;
        let name = text.trim_start_matches(BYTE_ORDER_MARK).trim();
        if names.iter().any(|known| known == name) {
            return Err(error(Problem::DuplicateColumn).column(name));
        }
        names.push(name.to_owned());
    }
    let wanted = choose(&names).map_err(|(column, problem)| error(problem).column(&column))?;
    Ok((names, wanted))
}

fn next(reader: &mut csv::Reader<impl Read>, record: &mut ByteRecord, file: &Path) -> Result<bool> {
    reader.read_byte_record(record).map_err(|e| {
        let text = e.to_string();
        match e.into_kind() {
            csv::ErrorKind::Io(e) => RecordingError::new(file, Problem::Io(e)),
            _ => RecordingError::new(file, Problem::Io(std::io::Error::other(text))),
        }
    })
}

fn line_of(record: &ByteRecord) -> u64 {
    record.position().map_or(0, csv::Position::line)
}

/// How a file separates cells, and whole numbers from their fractions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Dialect {
    delimiter: u8,
    decimal_comma: bool,
}

impl Dialect {
    /// By the header, of which `beginning` holds at least a part: many spreadsheets write semicolons, because their numbers have
    /// commas.
    fn of(beginning: &[u8]) -> Self {
        let header = beginning.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let has = |byte: u8| header.contains(&byte);
        match (has(b','), has(b';'), has(b'\t')) {
            (false, true, _) => Self { delimiter: b';', decimal_comma: true },
            (false, false, true) => Self { delimiter: b'\t', decimal_comma: true },
            _ => Self { delimiter: b',', decimal_comma: false },
        }
    }
}

fn number(
    cell: &[u8],
    column: &str,
    missing: Missing,
    dialect: Dialect,
) -> std::result::Result<f64, Problem> {
    let text = std::str::from_utf8(cell).map_err(|_| Problem::NotText)?.trim();
    if text.is_empty() {
        return Ok(f64::NAN);
    }
    let parsed = text.parse::<f64>().or_else(|error| match text.matches(',').count() {
        1 if dialect.decimal_comma => text.replace(',', ".").parse(),
        _ => Err(error),
    });
    if parsed.is_err()
        && let Some(seconds) = instant_s(text)
    {
        return Ok(seconds);
    }
    match parsed {
        Ok(value) if missing == Missing::Empty && !value.is_finite() => {
            Err(Problem::NotMeasured(text.to_owned()))
        }
        Ok(value) => Ok(value),
        Err(_) if text == column => Err(Problem::HeaderAgain),
        Err(_) => Err(Problem::NotANumber(text.chars().take(40).collect())),
    }
}

pub(crate) fn write_header(to: &mut impl Write, names: &[String]) -> std::io::Result<()> {
    writeln!(to, "{}", names.join(","))
}

pub(crate) fn write_rows(to: &mut impl Write, columns: &[Vec<f64>], words: &[Words]) -> std::io::Result<()> {
    for row in 0..columns.first().map_or(0, Vec::len) {
        for (position, column) in columns.iter().enumerate() {
            if position > 0 {
                to.write_all(b",")?;
            }
            if !column[row].is_nan() {
                write!(to, "{:?}", column[row])?;
            }
        }
        for column in words {
            write!(to, ",{}", column.cells[row])?;
        }
        to.write_all(b"\n")?;
    }
    Ok(())
}
