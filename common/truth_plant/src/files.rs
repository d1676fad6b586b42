//! Writing a case to disk in the form of the contract.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use crate::plant::Run;

/// A case could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {path}: {source}", path = path.display())]
pub struct WriteError {
    path: PathBuf,
    source: std::io::Error,
}

impl WriteError {
    pub(crate) fn new(path: &Path, source: std::io::Error) -> Self {
        Self { path: path.to_path_buf(), source }
    }
}

/// Columns of a recording.
pub const HEADER: &str = "t_s,v_m_s,omega_f_rad_s,omega_r_rad_s,f_perp_f_n,f_perp_r_n,m_w_f_nm,m_w_r_nm,grade_rad,sanding,position_m";
/// Columns of the truth beside it.
pub const TRUTH_HEADER: &str = "t_s,v_m_s,mu_w,mu_w_f,mu_w_r,mu_b_f,mu_b_r";

/// `NAME.RAIL.csv` of a run.
#[must_use]
pub fn file_name(run: &Run) -> String {
    format!("{}.{}.csv", run.order.name, run.order.rail.name())
}

/// Writes `vehicle.toml`, `fit/` and `holdout/` into a folder.
pub fn write_case(folder: &Path, vehicle_toml: &str, runs: &[Run]) -> Result<(), WriteError> {
    write(&folder.join("vehicle.toml"), vehicle_toml)?;
    for run in runs {
        let part = if run.order.holdout { "holdout" } else { "fit" };
        write(&folder.join(part).join(file_name(run)), &recording(run))?;
    }
    Ok(())
}

/// Writes `truth/PART.NAME.RAIL.csv` for every run.
pub fn write_truth(folder: &Path, runs: &[Run]) -> Result<(), WriteError> {
    for run in runs {
        let part = if run.order.holdout { "holdout" } else { "fit" };
        write(&folder.join("truth").join(format!("{part}.{}", file_name(run))), &truth(run))?;
    }
    Ok(())
}

fn recording(run: &Run) -> String {
    let mut text = String::with_capacity(run.rows.len() * 90);
    text.push_str(HEADER);
    text.push('\n');
    for row in &run.rows {
        let [omega_f, omega_r] = row.wheel_speed_rad_s;
        let [force_f, force_r] = row.pressing_force_n;
        let [drive_f, drive_r] = row.drive_torque_nm;
        let _ = writeln!(
            text,
            "{:?},{:?},{omega_f:?},{omega_r:?},{force_f:?},{force_r:?},{drive_f:?},{drive_r:?},{:?},{:?},{:?}",
            row.time_s,
            row.v_m_s,
            row.grade_rad,
            f64::from(u8::from(row.sanding)),
            row.position_m
        );
    }
    text
}

fn truth(run: &Run) -> String {
    let mut text = String::with_capacity(run.rows.len() * 60);
    text.push_str(TRUTH_HEADER);
    text.push('\n');
    let pad = |value: Option<f64>| value.map(|value| format!("{value:.5}")).unwrap_or_default();
    for (row, truth) in run.rows.iter().zip(&run.truth) {
        let [mu_w_f, mu_w_r] = truth.mu_w_wheelset;
        let [mu_b_f, mu_b_r] = truth.mu_b.map(pad);
        let _ = writeln!(
            text,
            "{:?},{:.5},{:.5},{mu_w_f:.5},{mu_w_r:.5},{mu_b_f},{mu_b_r}",
            row.time_s, truth.v_m_s, truth.mu_w
        );
    }
    text
}

/// Writes a file, making its folder first.
pub fn write(path: &Path, text: &str) -> Result<(), WriteError> {
    let wrap = |source| WriteError { path: path.to_path_buf(), source };
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent).map_err(wrap)?;
    }
    fs::write(path, text).map_err(wrap)
}
