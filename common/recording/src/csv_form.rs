//! Tables as CSV: comma, one header line, empty cell = missing. Numbers are written in the shortest text that reads back to the
//! same bits.

use crate::error::{Place, Problem, RecordingError, Result};
use crate::instant::instant_s;
use crate::table::{ColumnChoice, MOST_BYTES, Table, Words, fits};
use csv::ByteRecord;
use std::cell::Cell;
use std::io::{BufRead, Read, Write};
use std::path::Path;
use std::rc::Rc;

const BYTE_ORDER_MARK: &str = "\u{feff}";

/// Bytes of one row, or of what holds no row at all; more is no table, or is made to fill the memory.
const LONGEST_ROW: u64 = 1 << 20;

/// Counts the bytes since the last row, and ends where they are too many.
struct Rowwise<R> {
    source: R,
    since_row: Rc<Cell<u64>>,
}

impl<R: Read> Read for Rowwise<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        if self.since_row.get() > LONGEST_ROW {
            return Err(std::io::Error::other(TOO_LONG));
        }
        let read = self.source.read(buffer)?;
        self.since_row.set(self.since_row.get() + read as u64);
        Ok(read)
    }
}

const TOO_LONG: &str = "the row is too long";

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
    read_at_most(source, file, choose, missing, MOST_BYTES)
}

fn read_at_most(
    source: impl Read,
    file: &Path,
    choose: ColumnChoice<'_>,
    missing: Missing,
    most_bytes: u64,
) -> Result<Table> {
    let since_row = Rc::new(Cell::new(0));
    let mut source = std::io::BufReader::new(Rowwise { source, since_row: Rc::clone(&since_row) });
    let dialect = Dialect::of(source.fill_buf().map_err(|e| RecordingError::new(file, Problem::Io(e)))?);
    let mut builder = csv::ReaderBuilder::new();
    let mut reader =
        builder.has_headers(false).flexible(true).delimiter(dialect.delimiter).from_reader(source);
    let mut record = ByteRecord::new();
    let (names, wanted) = header(&mut reader, &mut record, file, choose, dialect)?;
    let mut columns = vec![Vec::new(); names.len()];
    let mut lines = Vec::new();
    let mut signs = Signs::default();
    let columns_wanted = wanted.iter().filter(|wanted| **wanted).count();
    since_row.set(0);
    while next(&mut reader, &mut record, file)? {
        since_row.set(0);
        let line = line_of(&record, &reader, dialect);
        let error = |problem| RecordingError::new(file, problem).at(Place::Line(line));
        // Its number of the line takes as much as a cell, though nobody asks for it.
        fits(lines.len() as u64 + 1, columns_wanted.max(1), most_bytes).map_err(error)?;
        if record.len() != names.len() {
            return Err(error(Problem::Ragged { expected: names.len(), found: record.len() }));
        }
        for (index, cell) in record.iter().enumerate().filter(|(index, _)| wanted[*index]) {
            let name = &names[index];
            let value =
                number(cell, name, missing, dialect).map_err(|problem| error(problem).column(name))?;
            if dialect.decimal_comma {
                signs.see(cell, name, line).map_err(|(text, column, line)| {
                    let problem = Problem::TwoDecimalSigns(text);
                    RecordingError::new(file, problem).at(Place::Line(line)).column(&column)
                })?;
            }
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
    dialect: Dialect,
) -> Result<(Vec<String>, Vec<bool>)> {
    if !next(reader, record, file)? {
        return Err(RecordingError::new(file, Problem::NoHeader));
    }
    let line = line_of(record, reader, dialect);
    let error = |problem| RecordingError::new(file, problem).at(Place::Line(line));
    let mut names: Vec<String> = Vec::with_capacity(record.len());
    let mut known = std::collections::HashSet::new();
    for cell in record.iter() {
        let text = std::str::from_utf8(cell).map_err(|_| error(Problem::NotText))?;
        let name = text.trim_start_matches(BYTE_ORDER_MARK).trim();
        if !known.insert(name.to_owned()) {
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
            csv::ErrorKind::Io(e) if e.get_ref().is_some_and(|inner| inner.to_string() == TOO_LONG) => {
                let problem = Problem::RowTooLong { most_mib: LONGEST_ROW >> 20 };
                RecordingError::new(file, problem).at(Place::Line(reader.position().line()))
            }
            csv::ErrorKind::Io(e) => RecordingError::new(file, Problem::Io(e)),
            _ => RecordingError::new(file, Problem::Io(std::io::Error::other(text))),
        }
    })
}

/// The line on which a row that has just been read stands. A row begins where the one before ended, which may be some empty lines above,
/// and with `\r\n` on the line of that one; so it is told by where it ends: before its `\r`, or behind its `\n`.
fn line_of(record: &ByteRecord, reader: &csv::Reader<impl Read>, dialect: Dialect) -> u64 {
    let (begin, end) = (record.position().map_or(0, csv::Position::line), reader.position().line());
    if dialect.carriage_returns { end } else { begin.max(end.saturating_sub(1)) }
}

/// How a file separates cells, and whole numbers from their fractions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Dialect {
    delimiter: u8,
    decimal_comma: bool,
    /// Whether lines end in `\r\n`.
    carriage_returns: bool,
}

impl Dialect {
    /// By the header, of which `beginning` holds at least a part: many spreadsheets write semicolons, because their numbers have
    /// commas.
    fn of(beginning: &[u8]) -> Self {
        let header = beginning.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let has = |byte: u8| header.contains(&byte);
        let (delimiter, decimal_comma) = match (has(b','), has(b';'), has(b'\t')) {
            (false, true, _) => (b';', true),
            (false, false, true) => (b'\t', true),
            _ => (b',', false),
        };
        Self { delimiter, decimal_comma, carriage_returns: header.ends_with(b"\r") }
    }
}

/// Which decimal signs the numbers of a file have.
#[derive(Default)]
struct Signs {
    comma: bool,
    /// The first with a point, its column and its line.
    point: Option<(String, String, u64)>,
}

impl Signs {
    /// Looks at a cell that was read; fails with the one that has a point where others have commas.
    fn see(
        &mut self,
        cell: &[u8],
        column: &str,
        line: u64,
    ) -> std::result::Result<(), (String, String, u64)> {
        self.comma |= cell.contains(&b',');
        let text = std::str::from_utf8(cell).unwrap_or_default().trim();
        // Instants have points of their own.
        if self.point.is_none() && text.contains('.') && text.parse::<f64>().is_ok() {
            self.point = Some((text.to_owned(), column.to_owned(), line));
        }
        match &self.point {
            Some(point) if self.comma => Err(point.clone()),
            _ => Ok(()),
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

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: impl Read, most_bytes: u64) -> Result<Table> {
        let all = |names: &[String]| Ok(vec![true; names.len()]);
        read_at_most(text, Path::new("x.csv"), &all, Missing::AnyText, most_bytes)
    }

    #[test]
    fn rows_fit_exactly_or_are_refused_with_the_limit() {
        let text = format!("a,b\n{}", "1,2\n".repeat(1000));
        assert_eq!(of(text.as_bytes(), 16_000).expect("it fits").rows(), 1000);
        let error = of(text.as_bytes(), 15_999).expect_err("too much");
        assert!(matches!(error.problem, Problem::TooManyCells { rows: 1000, columns: 2, .. }), "{error}");
        assert!(error.to_string().starts_with("x.csv, line 1001: 1000 rows of 2 columns fill"), "{error}");
    }

    /// However lines end, empty ones between them or not, and with the last one unfinished.
    #[test]
    fn a_row_is_told_by_the_line_on_which_it_stands() {
        for end in ["\n", "\r\n"] {
            for (rows, line) in [("x,2", 2), ("1,2|x,2|", 3), ("|1,2|||x,2|3,4|", 6), ("1,2|||x,2", 5)] {
                let text = format!("a,b|{rows}").replace('|', end);
                let error = of(text.as_bytes(), MOST_BYTES).expect_err("no number").to_string();
                // Empty lines before an unfinished last one are the one thing that nothing tells.
                let line = if end == "\n" && rows == "1,2|||x,2" { line - 1 } else { line };
                assert!(error.starts_with(&format!("x.csv, line {line}, column a: ")), "{text:?}: {error}");
            }
            let twice =
                of(format!("a,a{end}").as_bytes(), MOST_BYTES).expect_err("one name for two").to_string();
            assert!(twice.starts_with("x.csv, line 1, column a"), "{twice}");
        }
    }

    #[test]
    fn points_among_decimal_commas_are_refused_whichever_comes_first() {
        for (rows, line) in [("1,5;2,5\n1,6;134.052\n", 3), ("1.5;2\n1,6;3\n", 2)] {
            let error =
                of(format!("a;b\n{rows}").as_bytes(), MOST_BYTES).expect_err("both signs").to_string();
            assert!(error.contains(&format!("line {line}")) && error.contains("decimal commas"), "{error}");
        }
        assert_eq!(of("a;b\n1.5;2\n1.6;3\n".as_bytes(), MOST_BYTES).expect("points alone").rows(), 2);
        let instants = "a;b\n2026-01-01T00:00:00.5Z;2,5\n2026-01-01T00:00:01.5Z;3,5\n";
        assert_eq!(of(instants.as_bytes(), MOST_BYTES).expect("instants").rows(), 2);
    }

    /// Each would fill any memory, or never end.
    #[test]
    fn a_row_without_end_is_refused_wherever_it_stands() {
        let endless: [(&str, &[u8]); 6] = [
            ("", b"x"),
            ("a,b\n1,2\n", b"1"),
            ("a,b\n1,2\n", b"1,"),
            ("a,b\n1,2\n", b"\n"),
            ("a,b\n1,2\n\"", b"1\n"),
            ("\"", b"a\n"),
        ];
        for (begin, more) in endless {
            let rest = std::io::BufReader::new(Endless { of: more, at: 0, left: 1 << 30 });
            let error = of(begin.as_bytes().chain(rest), MOST_BYTES).expect_err("no end");
            assert!(matches!(error.problem, Problem::RowTooLong { .. }), "{begin:?} {more:?}: {error}");
            assert!(error.to_string().contains("line "), "{error}");
        }
    }

    /// The same bytes again and again, and a failure of the test where a whole gigabyte of them was taken.
    struct Endless {
        of: &'static [u8],
        at: usize,
        left: usize,
    }

    impl Read for Endless {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            assert!(self.left >= buffer.len(), "a gigabyte was read");
            self.left -= buffer.len();
            for byte in buffer.iter_mut() {
                *byte = self.of[self.at];
                self.at = (self.at + 1) % self.of.len();
            }
            Ok(buffer.len())
        }
    }

    #[test]
    fn a_packed_file_that_grows_without_end_is_refused() {
        use flate2::{Compression, read::GzEncoder};
        let rows = Endless { of: b"1\n", at: 0, left: 1 << 30 }.take(64 << 20);
        let packed = GzEncoder::new("a\n".as_bytes().chain(rows), Compression::best());
        let error = of(flate2::read::MultiGzDecoder::new(std::io::BufReader::new(packed)), 1 << 20)
            .expect_err("too much");
        assert!(matches!(error.problem, Problem::TooManyCells { .. }), "{error}");
    }
}
