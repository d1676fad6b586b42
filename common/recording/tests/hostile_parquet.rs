//! Parquet files whose metadata and data disagree are refused before they fill the memory; columns without missing cells are read.

use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::data_type::{
    BoolType, DoubleType, FixedLenByteArray, FixedLenByteArrayType, Int32Type, Int64Type,
};
use parquet::file::metadata::{
    ParquetMetaData, ParquetMetaDataReader, ParquetMetaDataWriter, RowGroupMetaDataBuilder,
};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};
use railgrip_recording::{Problem, Recording, Strictness, Table};
use std::path::Path;
use std::sync::Arc;

const RUN: [&str; 6] = ["t_s", "v_m_s", "omega_f_rad_s", "omega_r_rad_s", "f_perp_f_n", "f_perp_r_n"];

fn column(name: &str, physical: Physical, repetition: Repetition) -> Type {
    Type::primitive_type_builder(name, physical).with_repetition(repetition).build().expect("column")
}

/// A file of so many row groups, each of which `group` writes.
fn file(
    fields: Vec<Type>,
    groups: usize,
    group: impl Fn(usize, &mut SerializedRowGroupWriter<'_, Vec<u8>>),
) -> Vec<u8> {
    let fields: Vec<TypePtr> = fields.into_iter().map(Arc::new).collect();
    let schema = Type::group_type_builder("run").with_fields(fields).build().expect("schema");
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer =
        SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties)).expect("writer");
    for index in 0..groups {
        let mut to = writer.next_row_group().expect("group");
        group(index, &mut to);
        to.close().expect("group");
    }
    writer.into_inner().expect("file")
}

macro_rules! write {
    ($to:expr, $kind:ty, $values:expr) => {
        write!($to, $kind, $values, None)
    };
    ($to:expr, $kind:ty, $values:expr, $levels:expr) => {{
        let mut cells = $to.next_column().expect("column").expect("one more column");
        cells.typed::<$kind>().write_batch($values, $levels, None).expect("cells");
        cells.close().expect("column");
    }};
}

/// Columns of a run, all of one value, which a dictionary packs into next to nothing.
fn constant(rows: usize) -> Vec<u8> {
    let fields = RUN.iter().map(|name| column(name, Physical::DOUBLE, Repetition::OPTIONAL)).collect();
    let (values, levels) = (vec![1.0; rows], vec![1; rows]);
    file(fields, 1, |_, to| RUN.iter().for_each(|_| write!(to, DoubleType, &values, Some(&levels))))
}

/// The same data, and some more behind it, under other metadata.
fn forged(bytes: &[u8], more: &[u8], change: impl Fn(ParquetMetaData) -> ParquetMetaData) -> Vec<u8> {
    let owned = bytes::Bytes::copy_from_slice(bytes);
    let metadata = change(ParquetMetaDataReader::new().parse_and_finish(&owned).expect("metadata"));
    let mut forged = [&bytes[..footer(bytes)], more].concat();
    ParquetMetaDataWriter::new(&mut forged, &metadata).finish().expect("footer");
    forged
}

/// Where the metadata begin.
fn footer(bytes: &[u8]) -> usize {
    let end = bytes.len() - 8;
    end - u32::from_le_bytes(bytes[end..end + 4].try_into().expect("length")) as usize
}

/// Metadata that claim so many rows, on which the file and its only row group agree.
fn claiming(rows: i64) -> impl Fn(ParquetMetaData) -> ParquetMetaData {
    with_groups(move |group| group.set_num_rows(rows))
}

/// Metadata by which every column lies elsewhere.
fn lying_at(start: i64, bytes: i64) -> impl Fn(ParquetMetaData) -> ParquetMetaData {
    with_groups(move |group| {
        let group = group.build().expect("group");
        let columns = group.columns().iter().cloned().map(|chunk| {
            let chunk = chunk.into_builder().set_total_compressed_size(bytes);
            chunk.set_dictionary_page_offset(Some(start)).build().expect("chunk")
        });
        let columns = columns.collect();
        group.into_builder().set_column_metadata(columns)
    })
}

fn with_groups(
    change: impl Fn(RowGroupMetaDataBuilder) -> RowGroupMetaDataBuilder,
) -> impl Fn(ParquetMetaData) -> ParquetMetaData {
    move |metadata| {
        let groups = metadata.row_groups().iter().cloned();
        let groups = groups.map(|group| change(group.into_builder()).build().expect("group")).collect();
        metadata.into_builder().set_row_groups(groups).build()
    }
}

fn refusal(bytes: Vec<u8>) -> (Problem, String) {
    let read = Table::read_parquet(bytes, Path::new("runs/lie.parquet"), &|_| Ok(()));
    let error = read.map(|table| table.rows()).expect_err("a lie");
    let said = error.to_string();
    assert!(said.starts_with("runs/lie.parquet"), "{said}");
    (error.problem, said)
}

#[test]
fn a_footer_that_hides_rows_is_told_from_the_pages() {
    let good = constant(300_000);
    assert!(good.len() < 10_000, "{} bytes", good.len());
    let table = Table::read_parquet(good.clone(), Path::new("good.parquet"), &|_| Ok(())).expect("good");
    assert_eq!((table.rows(), table.column("v_m_s").expect("column")[299_999]), (300_000, 1.0));

    for rows in [0_u64, 1_000, 299_999, 300_001, 1_000_000] {
        let (problem, said) = refusal(forged(&good, &[], claiming(rows.cast_signed())));
        let told = matches!(problem, Problem::RowCount { claimed, found: 300_000 } if claimed == rows);
        assert!(told && said.contains("column t_s: 300000 values"), "{said}");
    }
    for rows in [-1, i64::MIN] {
        refusal(forged(&good, &[], claiming(rows)));
    }
}

#[test]
fn a_footer_whose_row_groups_hold_other_rows_than_the_file_is_refused() {
    let mut bytes = constant(300_000);
    // The first such number of the metadata is that of the file; 300,000, then 100,000, as Thrift writes them.
    let at = footer(&bytes);
    let rows = bytes[at..].windows(4).position(|four| four == [0x16, 0xc0, 0xcf, 0x24]).expect("rows");
    bytes[at + rows + 1..at + rows + 4].copy_from_slice(&[0xc0, 0x9a, 0x0c]);
    let (problem, said) = refusal(bytes);
    assert!(matches!(problem, Problem::RowCount { claimed: 100_000, found: 300_000 }), "{said}");
}

#[test]
fn a_small_file_that_claims_more_than_the_memory_is_refused_with_the_limit() {
    for rows in [12_000_000, 1 << 40, i64::MAX] {
        let (problem, said) = refusal(forged(&constant(1_000), &[], claiming(rows)));
        assert!(matches!(problem, Problem::TooManyCells { columns: 6, .. }), "{said}");
        assert!(
            said.contains(&format!("{rows} rows of 6 columns")) && said.contains("at most 512 MiB"),
            "{said}"
        );
    }
}

#[test]
fn a_column_outside_of_the_file_or_between_pages_is_refused() {
    let good = constant(1_000);
    let places = [(-1, 10), (4, -1), (1 << 40, 10), (4, i64::MAX), (i64::MAX, i64::MAX), (4, 3), (5, 80)];
    for (start, bytes) in places {
        let (problem, said) = refusal(forged(&good, &[], lying_at(start, bytes)));
        assert!(matches!(problem, Problem::Parquet(_)), "{start}, {bytes}: {said}");
    }
}

#[test]
fn a_page_of_a_few_bytes_that_claims_gigabytes_is_refused_before_it_is_unpacked() {
    let good = constant(1_000);
    let at = footer(&good) as i64;
    let two_gigabytes = [0x15, 0xfe, 0xff, 0xff, 0xff, 0x0f];
    // Kind, bytes unpacked and stored, number of values, encoding.
    let unpacked = [&[0x15, 0x00], &two_gigabytes[..], &[0x15, 0x04, 0x2c, 0x15, 0xd0, 0x0f, 0x15, 0x00]];
    let words = [&[0x15, 0x04, 0x15, 0x04, 0x15, 0x04, 0x4c], &two_gigabytes[..], &[0x15, 0x00]];
    for page in [unpacked.concat(), words.concat()] {
        let page = [&page[..], &[0, 0, 0x01, 0x00]].concat();
        let (problem, said) = refusal(forged(&good, &page, lying_at(at, page.len() as i64)));
        assert!(matches!(problem, Problem::PageSize { most_mib: 64, .. }), "{said}");
        assert!(said.contains("column t_s") && said.contains("at most 64 MiB"), "{said}");
    }
}

#[test]
fn a_run_whose_columns_are_never_missing_is_the_same_run_as_its_nullable_twin() {
    let written = |repetition: Repetition| {
        let fields = RUN.iter().map(|name| column(name, Physical::DOUBLE, repetition)).collect();
        file(fields, 3, |group, to| {
            for index in 0..RUN.len() {
                let cell = |row: usize| match index {
                    0 => 0.01 * (10_000 * group + row) as f64,
                    _ => 1.0 + 0.001 * (row % 100 + index) as f64,
                };
                let values: Vec<f64> = (0..10_000).map(cell).collect();
                let levels = vec![1; values.len()];
                let levels = (repetition == Repetition::OPTIONAL).then_some(levels.as_slice());
                write!(to, DoubleType, &values, levels);
            }
        })
    };
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("run.dry.parquet");
    let read = |repetition| {
        std::fs::write(&path, written(repetition)).expect("write");
        Recording::read(&path, Strictness::Strict).expect("a run")
    };
    let required = read(Repetition::REQUIRED);
    assert_eq!((required.len(), required.t_s[29_999]), (30_000, 299.99));
    assert_eq!(required, read(Repetition::OPTIONAL));
}

#[test]
fn required_columns_of_other_types_are_numbers_too() {
    let required =
        |name, physical| Type::primitive_type_builder(name, physical).with_repetition(Repetition::REQUIRED);
    let instant = LogicalType::timestamp(true, TimeUnit::MICROS);
    let decimal = required("large", Physical::FIXED_LEN_BYTE_ARRAY).with_length(9);
    let decimal =
        decimal.with_logical_type(Some(LogicalType::decimal(2, 20))).with_precision(20).with_scale(2);
    let fields = vec![
        required("at_us", Physical::INT64).with_logical_type(Some(instant)).build().expect("instant"),
        column("counter", Physical::INT32, Repetition::REQUIRED),
        column("flag", Physical::BOOLEAN, Repetition::REQUIRED),
        decimal.build().expect("decimal"),
    ];
    let bytes = file(fields, 2, |group, to| {
        let base = group as i64;
        write!(to, Int64Type, &[1_772_366_400_010_000 + base, -1_000_000]);
        write!(to, Int32Type, &[7 + group as i32, -7]);
        write!(to, BoolType, &[true, false]);
        let decimal = |last: [u8; 9]| FixedLenByteArray::from(last.to_vec());
        let cells = [decimal([0, 0, 0, 0, 0, 0, 0, 0x08, 0x02]), decimal([0xff; 9])];
        write!(to, FixedLenByteArrayType, &cells);
    });
    let table = Table::read_parquet(bytes, Path::new("types.parquet"), &|_| Ok(())).expect("read");
    let cells = |name: &str| table.column(name).expect(name).to_vec();
    let at = cells("at_us");
    assert!((at[0] - 1_772_366_400.01).abs() < 3e-7 && [at[1], at[3]] == [-1.0; 2], "{at:?}");
    assert_eq!(cells("counter"), [7.0, -7.0, 8.0, -7.0]);
    assert_eq!(cells("flag"), [1.0, 0.0, 1.0, 0.0]);
    assert_eq!(cells("large"), [20.5, -0.01, 20.5, -0.01]);
}
