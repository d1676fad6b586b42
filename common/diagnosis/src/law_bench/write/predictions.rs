//! The prediction files, from which anyone can recompute the reported gaps.

use crate::law_bench::data::case::Kind;
use crate::law_bench::data::error::LawCaseError;
use crate::law_bench::predict::gaps::Predictions;
use railgrip_recording::Table;
use std::path::Path;

/// The prediction file of each file of a set: name and table.
pub fn tables(predictions: &Predictions<'_>, kind: Kind) -> Result<Vec<(String, Table)>, LawCaseError> {
    let signal = kind.signal();
    let mut tables = Vec::new();
    for (file, name) in predictions.set.files.iter().enumerate() {
        let rows: Vec<usize> = (0..predictions.set.points.len())
            .filter(|&row| predictions.set.points[row].file == file)
            .collect();
        let pick = |values: &[f64]| rows.iter().map(|&row| values[row]).collect::<Vec<f64>>();
        let measured = rows.iter().map(|&row| predictions.set.points[row].measured).collect();
        let table = Table::new(vec![
            ("window".to_owned(), vec![0.0; rows.len()]),
            (signal.to_owned(), measured),
            (format!("{signal}_nominal"), pick(&predictions.nominal)),
            (format!("{signal}_calibrated"), pick(&predictions.calibrated)),
            (format!("{signal}_extended"), pick(&predictions.extended)),
        ])?;
        tables.push((name.clone(), table));
    }
    Ok(tables)
}

/// Writes prediction files into a folder, which is made if it is not there.
pub fn write_predictions(folder: &Path, tables: &[(String, Table)]) -> Result<(), LawCaseError> {
    std::fs::create_dir_all(folder).map_err(|source| LawCaseError::Io { file: folder.to_owned(), source })?;
    for (name, table) in tables {
        table.write(&folder.join(format!("{name}.csv")))?;
    }
    Ok(())
}
