//! Reading the runs of a case.

use crate::data::case::{Case, Columns, Run};
use crate::data::dead::{self, MOVES_FROM_M_S};
use crate::data::noise::SensorNoise;
use railgrip_recording::{Mending, Place, Recording, RecordingError, RunFile, runs_in};
use railgrip_vehicle::{RailClass, VehicleParameters};
use std::path::{Path, PathBuf};

/// Rates that differ by more are said.
const RATE_TOLERANCE: f64 = 0.01;

/// Why a case was refused.
#[derive(Debug, thiserror::Error)]
pub enum CaseError {
    /// A recording is bad.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A recording has another number of wheelsets than the vehicle.
    #[error(
        "{}: {found} wheelsets where the vehicle file has {expected}; a wagon with two has the columns omega_f_rad_s and \
         omega_r_rad_s, any other omega_1_rad_s and so on", path.display()
    )]
    Wheelsets {
        /// The file.
        path: PathBuf,
        /// Number found.
        found: usize,
        /// Number of the vehicle.
        expected: usize,
    },
    /// A column cannot be in its unit.
    #[error("{}, {place}, {source}", path.display())]
    Units {
        /// The file.
        path: PathBuf,
        /// A row that gives it away.
        place: Place,
        /// The column, and what gives it away.
        source: crate::data::units::UnitError,
    },
    /// Nothing moves in any of the runs to fit on.
    #[error(
        "{}: in no run does the vehicle reach {MOVES_FROM_M_S} m/s; what brakes and rail do shows only while it runs",
        path.display()
    )]
    Standing {
        /// Their folder.
        path: PathBuf,
    },
}

/// Reads `CASE/fit` and `CASE/holdout`. What can be mended in a recording is mended, and said in the case's notes; a recording
/// with long gaps becomes several runs of one name.
///
/// # Errors
/// A folder without runs, or a bad recording; the message names file, line and column.
pub fn load(folder: &Path, vehicle: VehicleParameters) -> Result<Case, CaseError> {
    let mut notes = Vec::new();
    let path = folder.join("fit");
    let fit = read(&path, "fit", &vehicle, &mut notes)?;
    if !fit.iter().any(|run| dead::moves(run, vehicle.wheelset.radius_m)) {
        return Err(CaseError::Standing { path });
    }
    let holdout = read(&folder.join("holdout"), "holdout", &vehicle, &mut notes)?;
    let [mut fit, holdout] = [fit, holdout].map(|parts| parts.iter().map(run).collect::<Vec<Run>>());
    for (number, run) in (1..).zip(&mut fit) {
        run.samples.iter_mut().for_each(|sample| sample.input.recording = number);
    }
    if fit.iter().chain(&holdout).any(|run| run.rail == RailClass::Undeclared) {
        notes.push(
            "runs whose names declare no rail (dry, wet, low) are taken to be on one rail of their own; its adhesion is \
             fitted, starting from dry rail"
                .to_owned(),
        );
    }
    let noise = SensorNoise::of_file(&vehicle.sensors);
    Ok(Case { vehicle, fit, holdout, noise, notes })
}

/// Reads the runs of a folder that are to test models of a case.
///
/// # Errors
/// As [`load`].
pub fn load_test(folder: &Path, vehicle: VehicleParameters) -> Result<Case, CaseError> {
    let mut notes = Vec::new();
    let fit: Vec<Run> = read(folder, "test", &vehicle, &mut notes)?.iter().map(run).collect();
    let noise = SensorNoise::of_file(&vehicle.sensors);
    Ok(Case { vehicle, fit, holdout: Vec::new(), noise, notes })
}

/// The recordings of a folder in regular parts. Each note is told with the part of the case and the run that it is about.
fn read(
    folder: &Path,
    part: &str,
    vehicle: &VehicleParameters,
    notes: &mut Vec<String>,
) -> Result<Vec<Recording>, CaseError> {
    let mut parts = Vec::new();
    for RunFile { name, path, .. } in runs_in(folder)? {
        let mended = Recording::read_mended(&path, &Mending::default())?;
        notes.extend(mended.notes.into_iter().map(|note| format!("{part}/{name}: {note}")));
        let found_hz = mended.parts.first().map_or(0.0, Recording::sample_rate_hz);
        let declared_hz = vehicle.sensors.sample_rate_hz;
        if (found_hz / declared_hz - 1.0).abs() > RATE_TOLERANCE {
            notes.push(format!(
                "{part}/{name}: sampled at {found_hz:.2} Hz where the vehicle file says {declared_hz} Hz"
            ));
        }
        let rows = mended.rows;
        for recording in mended.parts {
            if recording.wheelsets != vehicle.wheelsets() {
                let (found, expected) = (recording.wheelsets, vehicle.wheelsets());
                return Err(CaseError::Wheelsets { path, found, expected });
            }
            let checked = crate::data::units::check(&recording, vehicle);
            let checked = checked.and_then(|()| dead::check(&recording, vehicle.wheelset.radius_m));
            checked.map_err(|source| CaseError::Units {
                path: path.clone(),
                place: rows.place(source.t_s),
                source,
            })?;
            parts.push(recording);
        }
    }
    Ok(parts)
}

/// A run of a recording.
fn run(recording: &Recording) -> Run {
    let rail = match recording.rail {
        Some(railgrip_recording::RailClass::Dry) => RailClass::Dry,
        Some(railgrip_recording::RailClass::Wet) => RailClass::Wet,
        Some(railgrip_recording::RailClass::Low) => RailClass::Low,
        None => RailClass::Undeclared,
    };
    let columns = Columns {
        t_s: recording.t_s.clone(),
        v_m_s: recording.v_m_s.clone(),
        wheel_speed_rad_s: recording.wheel_speed_rad_s.clone(),
        pressing_force_n: recording.pressing_force_n.clone(),
        drive_torque_nm: recording.drive_torque_nm.clone(),
        grade_rad: recording.grade_rad.clone().unwrap_or_default(),
        sanding: recording.sanding.clone().unwrap_or_default(),
        position_m: recording.position_m.clone().unwrap_or_default(),
    };
    Run::new(recording.name.clone(), rail, &columns)
}
