//! What the cells of a Parquet column mean, as numbers: instants and spans of time in seconds, decimals by their scale. A type
//! that is no number is refused by its name.

use crate::error::Problem;
use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{AsBytes, DataType};
use parquet::schema::types::ColumnDescriptor;

/// Values that are read at once.
const CHUNK_ROWS: u64 = 8192;

/// How the stored values of a column become numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Meaning {
    /// As they are.
    Number,
    /// Without a sign.
    Unsigned,
    /// So many counts a second: instants since 1970, times of a day, durations.
    Seconds(i64),
    /// So many digits behind the point.
    Decimal(i32),
}

/// What a column holds; `duration` is its counts a second where the file says elsewhere that it is one.
///
/// # Errors
/// A type that is no number, by its name.
pub(crate) fn meaning(column: &ColumnDescriptor, duration: Option<i64>) -> Result<Meaning, Problem> {
    let refuse = |name: &str| Err(Problem::ColumnType(name.to_owned()));
    match column.logical_type_ref() {
        Some(LogicalType::Timestamp(kind)) => return Ok(Meaning::Seconds(counts(&kind.unit))),
        Some(LogicalType::Time(kind)) => return Ok(Meaning::Seconds(counts(&kind.unit))),
        Some(LogicalType::Decimal(kind)) => return Ok(Meaning::Decimal(kind.scale)),
        Some(LogicalType::Integer(kind)) if kind.is_signed => return Ok(Meaning::Number),
        Some(LogicalType::Integer(_)) => return Ok(Meaning::Unsigned),
        Some(LogicalType::Date) => return refuse("dates (days, without a time)"),
        Some(LogicalType::Float16) => return refuse("16-bit floating-point numbers"),
        Some(LogicalType::String | LogicalType::Enum) => return refuse("text"),
        Some(LogicalType::Uuid) => return refuse("UUIDs"),
        Some(LogicalType::Json | LogicalType::Bson) => return refuse("JSON or BSON documents"),
        Some(LogicalType::Unknown) | None => {}
        Some(other) => return refuse(&format!("values of type {other:?}")),
    }
    match column.converted_type() {
        ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIME_MILLIS => Ok(Meaning::Seconds(1_000)),
        ConvertedType::TIMESTAMP_MICROS | ConvertedType::TIME_MICROS => Ok(Meaning::Seconds(1_000_000)),
        ConvertedType::DECIMAL => Ok(Meaning::Decimal(column.type_scale())),
        ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 | ConvertedType::UINT_64 => {
            Ok(Meaning::Unsigned)
        }
        ConvertedType::DATE => refuse("dates (days, without a time)"),
        ConvertedType::INTERVAL => refuse("intervals of months, days and milliseconds"),
        _ => match column.physical_type() {
            Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY => refuse("text or bytes"),
            Physical::INT64 => Ok(duration.map_or(Meaning::Number, Meaning::Seconds)),
            _ => Ok(Meaning::Number),
        },
    }
}

fn counts(unit: &TimeUnit) -> i64 {
    match unit {
        TimeUnit::MILLIS => 1_000,
        TimeUnit::MICROS => 1_000_000,
        TimeUnit::NANOS => 1_000_000_000,
    }
}

/// Where the cells of a column in one row group go.
pub(crate) struct Sink<'a> {
    /// Whether cells may be missing: only then are there marks of those that are present.
    pub(crate) nullable: bool,
    /// How many there are to be.
    pub(crate) rows: u64,
    /// The column so far.
    pub(crate) to: &'a mut Vec<f64>,
}

/// Appends the cells of a column in one row group; a null is NaN.
///
/// # Errors
/// Other than as many cells as there are rows; more are not taken.
pub(crate) fn append(cells: ColumnReader, meaning: Meaning, to: Sink<'_>) -> Result<(), Problem> {
    match cells {
        ColumnReader::DoubleColumnReader(cells) => append_typed(cells, to, |value| *value),
        ColumnReader::FloatColumnReader(cells) => append_typed(cells, to, |value| f64::from(*value)),
        ColumnReader::Int32ColumnReader(cells) => append_typed(cells, to, |value| match meaning {
            Meaning::Unsigned => f64::from(value.cast_unsigned()),
            meaning => whole(i64::from(*value), meaning),
        }),
        ColumnReader::Int64ColumnReader(cells) => append_typed(cells, to, |value| match meaning {
            Meaning::Unsigned => value.cast_unsigned() as f64,
            meaning => whole(*value, meaning),
        }),
        ColumnReader::BoolColumnReader(cells) => append_typed(cells, to, |value| f64::from(*value)),
        // Instants of old writers: nanoseconds of a day, and the day.
        ColumnReader::Int96ColumnReader(cells) => {
            append_typed(cells, to, |value| whole(value.to_nanos(), Meaning::Seconds(1_000_000_000)))
        }
        ColumnReader::ByteArrayColumnReader(cells) => {
            append_typed(cells, to, |value| decimal(value.as_bytes(), meaning))
        }
        ColumnReader::FixedLenByteArrayColumnReader(cells) => {
            append_typed(cells, to, |value| decimal(value.as_bytes(), meaning))
        }
    }
}

/// A stored whole number. Whole seconds and the rest are divided apart, so that nanoseconds since 1970 keep their digits.
fn whole(value: i64, meaning: Meaning) -> f64 {
    match meaning {
        Meaning::Number | Meaning::Unsigned => value as f64,
        Meaning::Seconds(counts) => {
            value.div_euclid(counts) as f64 + value.rem_euclid(counts) as f64 / counts as f64
        }
        Meaning::Decimal(scale) => value as f64 / 10_f64.powi(scale),
    }
}

/// A decimal as bytes: two's complement, the highest byte first.
fn decimal(bytes: &[u8], meaning: Meaning) -> f64 {
    let Meaning::Decimal(scale) = meaning else { return f64::NAN };
    let negative = bytes.first().is_some_and(|byte| *byte >= 0x80);
    let magnitude = bytes.iter().fold(0.0, |sum, byte| {
        let byte = if negative { !*byte } else { *byte };
        sum * 256.0 + f64::from(byte)
    });
    let value = if negative { -(magnitude + 1.0) } else { magnitude };
    value / 10_f64.powi(scale)
}

fn append_typed<T: DataType>(
    mut cells: ColumnReaderImpl<T>,
    sink: Sink<'_>,
    convert: impl Fn(&T::T) -> f64,
) -> Result<(), Problem> {
    let Sink { nullable, rows, to } = sink;
    let mut values = Vec::new();
    let mut present = Vec::new();
    let mut found = 0;
    // One more is asked for than there are to be, so that a surplus shows.
    while found <= rows {
        values.clear();
        present.clear();
        let most = (rows - found + 1).min(CHUNK_ROWS);
        let (read, _, _) = cells
            .read_records(most as usize, Some(&mut present), None, &mut values)
            .map_err(|e| Problem::Parquet(e.to_string()))?;
        if read == 0 {
            break;
        }
        found += read as u64;
        if found > rows {
            break;
        }
        let mut values = values.iter().map(&convert);
        if nullable {
            to.extend(
                present
                    .iter()
                    .map(|level| if *level > 0 { values.next().unwrap_or(f64::NAN) } else { f64::NAN }),
            );
        } else {
            to.extend(values);
        }
    }
    match found == rows {
        true => Ok(()),
        false => Err(Problem::RowCount { claimed: rows, found }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_of_bytes_have_their_sign_and_scale() {
        assert_eq!(decimal(&[0xff, 0x83], Meaning::Decimal(2)), -1.25);
        assert_eq!(decimal(&[0x08, 0x02], Meaning::Decimal(2)), 20.5);
        assert_eq!(decimal(&[0x80], Meaning::Decimal(0)), -128.0);
        assert!(decimal(&[1], Meaning::Number).is_nan());
    }

    #[test]
    fn instants_keep_their_nanoseconds_as_far_as_a_number_can() {
        let seconds = whole(1_772_366_400_010_000_000, Meaning::Seconds(1_000_000_000));
        assert!((seconds - 1_772_366_400.01).abs() < 3e-7, "{seconds}");
        assert!((whole(-1, Meaning::Seconds(1000)) + 0.001).abs() < 1e-15);
    }
}
