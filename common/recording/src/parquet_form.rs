//! Tables as Parquet: plain optional DOUBLE columns, null = missing, readable by pandas, Polars and the like. Reading accepts any
//! flat column of numbers, decimals and times (see [`parquet_cells`]) and ignores the index column that pandas may add.

use crate::error::{Problem, RecordingError, Result};
use crate::parquet_cells::{Meaning, Sink};
use crate::table::{ColumnChoice, MOST_BYTES, Table, Words, fits};
use crate::{arrow_schema, parquet_cells, parquet_pages};
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::get_column_reader;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData, ParquetMetaDataReader};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::ChunkReader;
use parquet::file::serialized_reader::SerializedPageReader;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnDescPtr, SchemaDescriptor, Type};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where Arrow keeps its schema in the metadata of a file.
const ARROW_SCHEMA: &str = "ARROW:schema";

/// Reads the columns that `choose` wants.
///
/// The memory is that of the [`Table`], 8 bytes a cell in one `Vec<f64>` a column and at most [`MOST_BYTES`], and beside it one page
/// of one column, as stored and unpacked, with its dictionary. Columns that nobody wants are not looked at. What the file claims
/// is checked against its pages' headers before there is room made for it.
pub(crate) fn read<R: ChunkReader + 'static>(
    source: R,
    file: &Path,
    choose: ColumnChoice<'_>,
) -> Result<Table> {
    read_at_most(source, file, choose, MOST_BYTES)
}

fn read_at_most<R: ChunkReader + 'static>(
    source: R,
    file: &Path,
    choose: ColumnChoice<'_>,
    most_bytes: u64,
) -> Result<Table> {
    let whole = |problem| RecordingError::new(file, problem);
    let error = |column: &str, problem| RecordingError::new(file, problem).column(column);
    let metadata = ParquetMetaDataReader::new()
        .parse_and_finish(&source)
        .map_err(|e| whole(Problem::Parquet(e.to_string())))?;
    let schema = metadata.file_metadata().schema_descr();
    let kept: Vec<usize> = (0..schema.num_columns()).filter(|index| !is_index(schema, *index)).collect();
    let names: Vec<String> = kept.iter().map(|index| schema.column(*index).path().string()).collect();
    if let Some((_, twice)) = names.iter().enumerate().find(|(at, name)| names[..*at].contains(name)) {
        return Err(error(twice, Problem::DuplicateColumn));
    }
    let wanted = choose(&names).map_err(|(column, problem)| error(&column, problem))?;

    let durations = durations(&metadata);
    let mut chosen = Vec::new();
    for ((index, name), _) in kept.into_iter().zip(names).zip(wanted).filter(|(_, wanted)| *wanted) {
        let column = Column::of(schema.column(index), index, &durations).map_err(|p| error(&name, p))?;
        chosen.push((name, column));
    }
    let rows = rows(&metadata).map_err(whole)?;
    fits(rows, chosen.len(), most_bytes).map_err(whole)?;

    let source = Arc::new(source);
    let (mut names, mut columns) = (Vec::new(), Vec::new());
    for (name, column) in chosen {
        columns.push(column.read(&source, &metadata, rows).map_err(|problem| error(&name, problem))?);
        names.push(name);
    }
    Table::assemble(file, names, columns, None)
}

/// Rows of a file, on which its row groups agree.
fn rows(metadata: &ParquetMetaData) -> std::result::Result<u64, Problem> {
    let count = |rows: i64| u64::try_from(rows).map_err(|_| Problem::Parquet("less than no rows".to_owned()));
    let claimed = count(metadata.file_metadata().num_rows())?;
    let mut found = 0_u64;
    for group in metadata.row_groups() {
        found = found.saturating_add(count(group.num_rows())?);
    }
    match found == claimed {
        true => Ok(claimed),
        false => Err(Problem::RowCount { claimed, found }),
    }
}

/// A column that is read.
struct Column {
    index: usize,
    described: ColumnDescPtr,
    meaning: Meaning,
}

impl Column {
    fn of(
        described: ColumnDescPtr,
        index: usize,
        durations: &[(String, i64)],
    ) -> std::result::Result<Self, Problem> {
        if described.max_rep_level() > 0 || described.max_def_level() > 1 {
            return Err(Problem::ColumnType("nested values".to_owned()));
        }
        let name = described.path().string();
        let duration = durations.iter().find(|(known, _)| *known == name).map(|(_, counts)| *counts);
        let meaning = parquet_cells::meaning(&described, duration)?;
        Ok(Self { index, described, meaning })
    }

    /// All cells. Room is made when the pages of all row groups were found to hold so many.
    fn read<R: ChunkReader + 'static>(
        &self,
        source: &Arc<R>,
        metadata: &ParquetMetaData,
        rows: u64,
    ) -> std::result::Result<Vec<f64>, Problem> {
        let groups =
            || metadata.row_groups().iter().map(|group| (group.column(self.index), group.num_rows()));
        for (chunk, rows) in groups() {
            let packed = chunk.compression();
            if !matches!(packed, Compression::UNCOMPRESSED | Compression::SNAPPY | Compression::ZSTD(_)) {
                let name = packed.to_string().split('(').next().unwrap_or_default().to_lowercase();
                return Err(Problem::Packed(name));
            }
            parquet_pages::check(source.as_ref(), chunk, rows.cast_unsigned())?;
        }
        let mut cells = Vec::new();
        cells
            .try_reserve_exact(rows as usize)
            .map_err(|e| Problem::Io(std::io::Error::new(std::io::ErrorKind::OutOfMemory, e)))?;
        for (chunk, rows) in groups() {
            // The decoders assert what every writer does; a forged page may do otherwise.
            let read = std::panic::AssertUnwindSafe(|| self.append(source, chunk, rows, &mut cells));
            std::panic::catch_unwind(read)
                .unwrap_or_else(|_| Err(Problem::Parquet("a page cannot be decoded".to_owned())))?;
        }
        Ok(cells)
    }

    fn append<R: ChunkReader + 'static>(
        &self,
        source: &Arc<R>,
        chunk: &ColumnChunkMetaData,
        rows: i64,
        to: &mut Vec<f64>,
    ) -> std::result::Result<(), Problem> {
        let rows = rows.cast_unsigned();
        let pages = SerializedPageReader::new(Arc::clone(source), chunk, rows as usize, None)
            .map_err(|e| Problem::Parquet(e.to_string()))?;
        let cells = get_column_reader(Arc::clone(&self.described), Box::new(pages));
        let nullable = self.described.max_def_level() > 0;
        parquet_cells::append(cells, self.meaning, Sink { nullable, rows, to })
    }
}

/// Columns that are durations, with their counts a second.
fn durations(metadata: &ParquetMetaData) -> Vec<(String, i64)> {
    let entries = metadata.file_metadata().key_value_metadata();
    let schema = entries.into_iter().flatten().find(|entry| entry.key == ARROW_SCHEMA);
    schema.and_then(|entry| entry.value.as_deref()).map(arrow_schema::durations).unwrap_or_default()
}

/// pandas stores a row index that is no range under such a name.
fn is_index(schema: &SchemaDescriptor, column: usize) -> bool {
    schema.column(column).name().starts_with("__index_level_")
}

/// Writes row groups of optional doubles.
pub(crate) struct Writer<W: Write + Send> {
    file: PathBuf,
    inner: SerializedFileWriter<W>,
}

impl Writer<crate::atomic::AtomicFile> {
    pub(crate) fn new(to: crate::atomic::AtomicFile, names: &[String], words: &[Words]) -> Result<Self> {
        let file = to.target().to_owned();
        Self::with_sink(to, file, names, words)
    }
}

impl<W: Write + Send> Writer<W> {
    pub(crate) fn with_sink(to: W, file: PathBuf, names: &[String], words: &[Words]) -> Result<Self> {
        let broken = |e: ParquetError| RecordingError::new(&file, Problem::Parquet(e.to_string()));
        let column = |name: &String| {
            Type::primitive_type_builder(name, Physical::DOUBLE).with_repetition(Repetition::OPTIONAL).build()
        };
        let text = |words: &Words| {
            Type::primitive_type_builder(&words.name, Physical::BYTE_ARRAY)
                .with_repetition(Repetition::REQUIRED)
                .with_logical_type(Some(LogicalType::String))
                .build()
        };
        let fields = (names.iter().map(column).chain(words.iter().map(text)))
            .map(|field| field.map(Arc::new))
            .collect::<std::result::Result<Vec<_>, _>>();
        let schema = fields
            .and_then(|fields| Type::group_type_builder("run").with_fields(fields).build())
            .map_err(broken)?;
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        let inner = SerializedFileWriter::new(to, Arc::new(schema), Arc::new(properties)).map_err(broken)?;
        Ok(Self { file, inner })
    }

    pub(crate) fn write_group(&mut self, columns: &[Vec<f64>], words: &[Words]) -> Result<()> {
        Self::group(&mut self.inner, columns, words)
            .map_err(|e| RecordingError::new(&self.file, Problem::Parquet(e.to_string())))
    }

    fn group(
        writer: &mut SerializedFileWriter<W>,
        columns: &[Vec<f64>],
        words: &[Words],
    ) -> parquet::errors::Result<()> {
        let mut group = writer.next_row_group()?;
        for column in columns {
            let Some(mut cells) = group.next_column()? else { break };
            let present: Vec<i16> = column.iter().map(|value| i16::from(!value.is_nan())).collect();
            let values: Vec<f64> = column.iter().copied().filter(|value| !value.is_nan()).collect();
            cells.typed::<DoubleType>().write_batch(&values, Some(&present), None)?;
            cells.close()?;
        }
        for column in words {
            let Some(mut cells) = group.next_column()? else { break };
            let values: Vec<ByteArray> = column.cells.iter().map(|word| ByteArray::from(*word)).collect();
            cells.typed::<ByteArrayType>().write_batch(&values, None, None)?;
            cells.close()?;
        }
        group.close().map(|_| ())
    }

    pub(crate) fn finish(self) -> Result<W> {
        let file = self.file;
        self.inner.into_inner().map_err(|e| RecordingError::new(&file, Problem::Parquet(e.to_string())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytes::Bytes;

    /// 1,000 rows of `a`, `b` and `c` in two row groups.
    fn three_columns() -> Bytes {
        let names = ["a", "b", "c"].map(str::to_owned);
        let mut writer = Writer::with_sink(Vec::new(), PathBuf::from("x"), &names, &[]).expect("writer");
        for group in 0..2 {
            let column = |factor: f64| (0..500).map(|row| factor * f64::from(500 * group + row)).collect();
            writer.write_group(&[column(1.0), column(2.0), column(3.0)], &[]).expect("group");
        }
        writer.finish().expect("file").into()
    }

    fn read_of(names: &[&str], most_bytes: u64) -> Result<Table> {
        let choose =
            |header: &[String]| Ok(header.iter().map(|name| names.contains(&name.as_str())).collect());
        read_at_most(three_columns(), Path::new("x.parquet"), &choose, most_bytes)
    }

    #[test]
    fn the_columns_that_are_wanted_fit_exactly_or_are_refused_with_the_limit() {
        let table = read_of(&["a", "c"], 16_000).expect("it fits");
        assert_eq!((table.names(), table.rows()), (["a".to_owned(), "c".to_owned()].as_slice(), 1_000));
        assert_eq!(table.column("c").map(|cells| cells[999]), Some(2_997.0));
        assert!(table.columns.iter().all(|cells| cells.capacity() == 1_000), "no room beside the table");

        let error = read_of(&["a", "c"], 15_999).expect_err("too much");
        assert!(matches!(error.problem, Problem::TooManyCells { rows: 1_000, columns: 2, .. }), "{error}");
        let error = read_of(&["a", "b", "c"], 16_000).expect_err("one column more");
        assert!(error.to_string().starts_with("x.parquet: 1000 rows of 3 columns fill"), "{error}");
        assert_eq!(read_of(&[], 0).expect("nothing").rows(), 0);
    }
}
