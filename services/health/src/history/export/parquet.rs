//! The table as Parquet: `time` as a UTC timestamp in milliseconds, figures as optional floats, units in the metadata.

use super::table::{ExportError, Layout, Sink, Whose};
use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, FloatType, Int32Type, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use railgrip_history::Point;
use std::io::Write;
use std::sync::Arc;

/// Rows of a group; what waits in memory.
const GROUP_ROWS: usize = 16_384;

/// A table being written.
pub(super) struct Columns<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    rows: Vec<(Whose, Point)>,
}

impl<W: Write + Send> Columns<W> {
    pub(super) fn begin(layout: &Layout, step_s: i64, to: W) -> Result<Self, ExportError> {
        let utc = LogicalType::timestamp(true, TimeUnit::MILLIS);
        let whole = |name: &'static str, kind| {
            Type::primitive_type_builder(name, kind).with_repetition(Repetition::REQUIRED)
        };
        let mut fields = vec![
            Arc::new(whole("time", Physical::INT64).with_logical_type(Some(utc)).build()?),
            Arc::new(
                Type::primitive_type_builder("wagon", Physical::INT32)
                    .with_repetition(Repetition::OPTIONAL)
                    .build()?,
            ),
            Arc::new(
                Type::primitive_type_builder("vehicle", Physical::BYTE_ARRAY)
                    .with_repetition(Repetition::OPTIONAL)
                    .with_logical_type(Some(LogicalType::String))
                    .build()?,
            ),
            Arc::new(whole("samples", Physical::INT32).build()?),
        ];
        for (name, ..) in &layout.figures {
            let figure = Type::primitive_type_builder(name, Physical::FLOAT);
            fields.push(Arc::new(figure.with_repetition(Repetition::OPTIONAL).build()?));
        }
        let schema = Type::group_type_builder("history").with_fields(fields).build()?;
        let units = layout.fields.iter().filter(|field| !field.unit.is_empty());
        let units: serde_json::Map<String, serde_json::Value> =
            units.map(|field| (field.name.replace('.', "_"), field.unit.into())).collect();
        let told = |key: &str, value: String| KeyValue { key: key.to_owned(), value: Some(value) };
        let metadata = vec![
            told("railgrip.step_s", step_s.to_string()),
            told("railgrip.units", serde_json::Value::from(units).to_string()),
        ];
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(ZstdLevel::try_new(3)?))
            .set_key_value_metadata(Some(metadata))
            .build();
        let writer = SerializedFileWriter::new(to, Arc::new(schema), Arc::new(properties))?;
        Ok(Self { writer, rows: Vec::new() })
    }

    pub(super) fn finish(mut self, layout: &Layout) -> Result<(), ExportError> {
        self.group(layout)?;
        let mut to = self.writer.into_inner()?;
        Ok(to.flush()?)
    }

    fn group(&mut self, layout: &Layout) -> Result<(), ExportError> {
        let rows = std::mem::take(&mut self.rows);
        if rows.is_empty() {
            return Ok(());
        }
        let mut group = self.writer.next_row_group()?;
        let times: Vec<i64> = rows.iter().map(|(_, point)| point.unix_s * 1000).collect();
        let there = |known: bool| i16::from(known);
        let placed: Vec<i16> = rows.iter().map(|(wagon, _)| there(wagon.place.is_some())).collect();
        let places: Vec<i32> =
            rows.iter().filter_map(|(wagon, _)| wagon.place).map(u32::cast_signed).collect();
        let named: Vec<i16> = rows.iter().map(|(wagon, _)| there(wagon.vehicle.is_some())).collect();
        let names: Vec<ByteArray> =
            rows.iter().filter_map(|(wagon, _)| wagon.vehicle.as_deref()).map(ByteArray::from).collect();
        let samples: Vec<i32> =
            rows.iter().map(|(_, point)| i32::try_from(point.samples).unwrap_or(i32::MAX)).collect();
        let mut at = 0;
        while let Some(mut column) = group.next_column()? {
            match at {
                0 => column.typed::<Int64Type>().write_batch(&times, None, None)?,
                1 => column.typed::<Int32Type>().write_batch(&places, Some(&placed), None)?,
                2 => column.typed::<ByteArrayType>().write_batch(&names, Some(&named), None)?,
                3 => column.typed::<Int32Type>().write_batch(&samples, None, None)?,
                _ => {
                    let all = rows.iter().map(|(_, point)| layout.figure(at - 4, point));
                    let all: Vec<f32> = all.collect();
                    let known: Vec<i16> = all.iter().map(|figure| i16::from(figure.is_finite())).collect();
                    let figures: Vec<f32> = all.into_iter().filter(|figure| figure.is_finite()).collect();
                    column.typed::<FloatType>().write_batch(&figures, Some(&known), None)?
                }
            };
            column.close()?;
            at += 1;
        }
        group.close()?;
        Ok(())
    }
}

impl<W: Write + Send> Sink for Columns<W> {
    fn row(&mut self, layout: &Layout, wagon: &Whose, point: Point) -> Result<(), ExportError> {
        self.rows.push((wagon.clone(), point));
        if self.rows.len() >= GROUP_ROWS { self.group(layout) } else { Ok(()) }
    }
}
