//! Puts the latest minutes of a wagon that the model does not explain into a folder that `railgrip gap diagnose` takes.

use crate::gap_watch::GapWatch;
use railgrip_recording::{Optional, RecordingError, Row, RunWriter};
use railgrip_vehicle::VehicleParameters;
use std::path::{Path, PathBuf};

/// Shortest run that is worth keeping, rows.
const LEAST_ROWS: usize = 2000;
/// Share of the rows that a diagnosis may fit on; it predicts the rest.
const FIT_SHARE: f64 = 0.65;

/// Why nothing was kept.
#[derive(Debug, thiserror::Error)]
pub enum GapRecordError {
    /// A recording cannot be written.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A folder or the vehicle file cannot be written.
    #[error("{}: {source}", path.display())]
    File {
        /// Folder or file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The vehicle cannot be put into a file.
    #[error("the vehicle cannot be written: {0}")]
    Vehicle(#[from] toml::ser::Error),
}

/// Writes `CASE/vehicle.toml`, `CASE/fit/live.RAIL.csv` and `CASE/holdout/live.RAIL.csv`; `false` if there is too little.
///
/// # Errors
/// If something cannot be written.
pub fn write(
    case: &Path,
    watch: &GapWatch,
    vehicle: &VehicleParameters,
    rail: &str,
) -> Result<bool, GapRecordError> {
    let rows: Vec<Row> = watch.rows().filter(|row| row.v_m_s.is_finite()).collect();
    if rows.len() < LEAST_ROWS {
        return Ok(false);
    }
    let (fit, holdout) = rows.split_at((FIT_SHARE * rows.len() as f64) as usize);
    for (part, rows) in [("fit", fit), ("holdout", holdout)] {
        let folder = case.join(part);
        std::fs::create_dir_all(&folder)
            .map_err(|source| GapRecordError::File { path: folder.clone(), source })?;
        let has = |value: fn(&Row) -> f64| rows.iter().all(|row| value(row).is_finite());
        let optional = Optional {
            grade: has(|row| row.grade_rad),
            sanding: has(|row| row.sanding),
            position: has(|row| row.position_m),
            wsp: false,
        };
        let mut writer =
            RunWriter::create(&folder.join(format!("live.{rail}.csv")), watch.wheelsets(), optional)?;
        for row in rows {
            writer.push(row)?;
        }
        writer.finish()?;
    }
    let path = case.join("vehicle.toml");
    std::fs::write(&path, toml::to_string(vehicle)?)
        .map_err(|source| GapRecordError::File { path, source })?;
    Ok(true)
}
