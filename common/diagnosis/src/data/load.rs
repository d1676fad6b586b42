//! Reading the runs of a case.

use crate::data::case::{Case, Columns, Run, WHEELSETS};
use railgrip_recording::{Recording, RecordingError, RunFile, Strictness, runs_in};
use railgrip_vehicle::{RailClass, VehicleParameters};
use std::path::{Path, PathBuf};

/// Why a case was refused.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    /// A recording is bad.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A recording has another number of wheelsets than a case knows.
    #[error("{}: {found} wheelsets; the runs of a case have 2 (columns omega_f_rad_s and omega_r_rad_s)", path.display())]
    Wheelsets {
        /// The file.
        path: PathBuf,
        /// Number found.
        found: usize,
    },
    /// A column cannot be in its unit.
    #[error("{}, {source}", path.display())]
    Units {
        /// The file.
        path: PathBuf,
        /// The column, and what gives it away.
        source: crate::data::units::UnitError,
    },
    /// The vehicle has another number of wheelsets than a case knows.
    #[error("the vehicle has {found} wheelsets; a case is about a vehicle with 2")]
    VehicleWheelsets {
        /// Number found.
        found: usize,
    },
}

/// Reads `CASE/fit` and `CASE/holdout`.
///
/// # Errors
/// A folder without runs, or a bad recording; the message names file, line and column.
pub fn load(folder: &Path, vehicle: VehicleParameters) -> Result<Case, CaseError> {
    if vehicle.wheelsets() != WHEELSETS {
        return Err(CaseError::VehicleWheelsets { found: vehicle.wheelsets() });
    }
    let read = |part: &str| -> Result<Vec<Run>, CaseError> {
        runs_in(&folder.join(part))?.iter().map(|file| run(file, &vehicle)).collect()
    };
    let (fit, holdout) = (read("fit")?, read("holdout")?);
    Ok(Case { vehicle, fit, holdout })
}

fn run(file: &RunFile, vehicle: &VehicleParameters) -> Result<Run, CaseError> {
    let rail = match file.require_rail()? {
        railgrip_recording::RailClass::Dry => RailClass::Dry,
        railgrip_recording::RailClass::Wet => RailClass::Wet,
        railgrip_recording::RailClass::Low => RailClass::Low,
    };
    let mut recording = Recording::read(&file.path, Strictness::Strict)?;
    recording.require_rate(&file.path, vehicle.sensors.sample_rate_hz)?;
    if recording.wheelsets != WHEELSETS {
        return Err(CaseError::Wheelsets { path: file.path.clone(), found: recording.wheelsets });
    }
    let pair = |columns: &mut Vec<Vec<f64>>| -> [Vec<f64>; WHEELSETS] {
        std::array::from_fn(|i| std::mem::take(&mut columns[i]))
    };
    let columns = Columns {
        t_s: recording.t_s,
        v_m_s: recording.v_m_s,
        wheel_speed_rad_s: pair(&mut recording.wheel_speed_rad_s),
        pressing_force_n: pair(&mut recording.pressing_force_n),
        drive_torque_nm: pair(&mut recording.drive_torque_nm),
        grade_rad: recording.grade_rad.unwrap_or_default(),
        sanding: recording.sanding.unwrap_or_default(),
        position_m: recording.position_m.unwrap_or_default(),
    };
    crate::data::units::check(&columns, vehicle)
        .map_err(|source| CaseError::Units { path: file.path.clone(), source })?;
    Ok(Run::new(file.name.clone(), rail, &columns))
}
