//! Tables as Parquet: plain optional DOUBLE columns, null = missing, readable by pandas, Polars and the like. Reading accepts any
//! flat column of numbers, decimals and times (see [`parquet_cells`]) and ignores the index column that pandas may add.

use crate::error::{Problem, RecordingError, Result};
use crate::table::{ColumnChoice, Table, Words};
use crate::{arrow_schema, parquet_cells};
use bytes::Bytes;
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{SchemaDescriptor, Type};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where Arrow keeps its schema in the metadata of a file.
const ARROW_SCHEMA: &str = "ARROW:schema";
/// Most cells that are read of a file, wanted columns times rows: 16 columns of two days at 100 Hz. Beyond, a small file that
/// packs a repeated value well would fill the memory.
const MOST_CELLS: i64 = 300_000_000;

/// Reads the columns that `choose` wants.
pub(crate) fn read(bytes: Bytes, file: &Path, choose: ColumnChoice<'_>) -> Result<Table> {
    let broken = |e: ParquetError| RecordingError::new(file, Problem::Parquet(e.to_string()));
    let reader = SerializedFileReader::new(bytes).map_err(broken)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let kept: Vec<usize> = (0..schema.num_columns()).filter(|index| !is_index(&schema, *index)).collect();
    let names: Vec<String> = kept.iter().map(|index| schema.column(*index).path().string()).collect();
    let error = |column: &str, problem| RecordingError::new(file, problem).column(column);
    if let Some((_, twice)) = names.iter().enumerate().find(|(at, name)| names[..*at].contains(name)) {
        return Err(error(twice, Problem::DuplicateColumn));
    }
    let wanted = choose(&names).map_err(|(column, problem)| error(&column, problem))?;

    let rows = reader.metadata().file_metadata().num_rows();
    let cells = rows.saturating_mul(wanted.iter().filter(|wanted| **wanted).count() as i64);
    if cells > MOST_CELLS {
        return Err(RecordingError::new(file, Problem::TooManyCells { cells, most: MOST_CELLS }));
    }
    let durations = durations(&reader);
    let mut columns = vec![Vec::new(); names.len()];
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(broken)?;
        let each = kept.iter().zip(&names).zip(&mut columns).zip(&wanted);
        for ((index, name), column) in each.filter_map(|(each, wanted)| wanted.then_some(each)) {
            let flat =
                schema.column(*index).max_rep_level() == 0 && schema.column(*index).max_def_level() <= 1;
            if !flat {
                return Err(error(name, Problem::ColumnType("nested values".to_owned())));
            }
            let duration = durations.iter().find(|(known, _)| known == name).map(|(_, counts)| *counts);
            let meaning = parquet_cells::meaning(&schema.column(*index), duration);
            let cells = group.get_column_reader(*index).map_err(broken)?;
            meaning
                .and_then(|meaning| parquet_cells::append(cells, meaning, column))
                .map_err(|problem| error(name, problem))?;
        }
    }
    Table::chosen(file, names, columns, &wanted, None)
}

/// Columns that are durations, with their counts a second.
fn durations(reader: &SerializedFileReader<Bytes>) -> Vec<(String, i64)> {
    let entries = reader.metadata().file_metadata().key_value_metadata();
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
