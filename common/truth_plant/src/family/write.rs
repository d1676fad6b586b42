//! Writing a case of the family to disk in the form of the contract.

use std::{fmt::Write as _, path::Path};

use super::{make::FamilyCase, plant::FamilyRun, sheet::FamilySheet};
use crate::files::{WriteError, write};

/// `NAME.RAIL.csv` of a run.
#[must_use]
pub fn file_name(run: &FamilyRun) -> String {
    format!("{}.{}.csv", run.order.name, run.order.rail.name())
}

/// Writes `vehicle.toml`, `fit/` and `holdout/` into a folder.
///
/// # Errors
/// A file that cannot be written.
pub fn write_runs(folder: &Path, sheet: &FamilySheet, runs: &[FamilyRun]) -> Result<(), WriteError> {
    write(&folder.join("vehicle.toml"), &sheet.to_toml())?;
    for run in runs {
        let part = if run.order.holdout { "holdout" } else { "fit" };
        write(&folder.join(part).join(file_name(run)), &recording(sheet, run))?;
    }
    Ok(())
}

impl FamilyCase {
    /// Writes the case to a folder, and its twin to another if one is given.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path, twin: Option<&Path>) -> Result<(), WriteError> {
        write_runs(folder, &self.sheet, &self.runs)?;
        twin.map_or(Ok(()), |twin| write_runs(twin, &self.sheet, &self.twin))
    }
}

/// Suffix of a wheelset's columns: front and rear of two, else numbers.
fn suffix(wheelset: usize, wheelsets: usize) -> String {
    match (wheelsets, wheelset) {
        (2, 0) => "f".to_owned(),
        (2, _) => "r".to_owned(),
        _ => (wheelset + 1).to_string(),
    }
}

/// The text of a recording. A trailer has no column of torque, some vehicles none of position or sanding; cells without a
/// reading are empty.
#[must_use]
pub fn recording(sheet: &FamilySheet, run: &FamilyRun) -> String {
    let count = sheet.wheelsets;
    let columns = |before: &str, after: &str| {
        (0..count).map(|k| format!(",{before}{}{after}", suffix(k, count))).collect::<String>()
    };
    let mut text = format!("t_s,v_m_s{}{}", columns("omega_", "_rad_s"), columns("f_perp_", "_n"));
    if sheet.is_motored() {
        text += &columns("m_w_", "_nm");
    }
    text += ",grade_rad";
    text += if sheet.sander { ",sanding" } else { "" };
    text += if sheet.has_position { ",position_m\n" } else { "\n" };
    text.reserve(run.rows.len() * 12 * (4 + 2 * count));
    for row in &run.rows {
        let _ = write!(text, "{}", row.time_s);
        cell(&mut text, row.v_m_s, 1e4);
        row.wheel_speed_rad_s[..count].iter().for_each(|value| cell(&mut text, *value, 1e4));
        row.pressing_force_n[..count].iter().for_each(|value| cell(&mut text, *value, 1.0));
        if sheet.is_motored() {
            (0..count).for_each(|_| cell(&mut text, row.drive_torque_nm, 10.0));
        }
        cell(&mut text, row.grade_rad, 1e5);
        if sheet.sander {
            cell(&mut text, f64::from(u8::from(row.sanding)), 1.0);
        }
        if sheet.has_position {
            cell(&mut text, row.position_m, 1e2);
        }
        text.push('\n');
    }
    text
}

/// A comma, and the number in steps of `1 / per_one`; nothing after the comma where there is no number.
fn cell(text: &mut String, value: f64, per_one: f64) {
    text.push(',');
    if value.is_finite() {
        let _ = write!(text, "{}", (value * per_one).round() / per_one + 0.0);
    }
}
