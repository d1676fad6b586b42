//! `railgrip estimate`: the estimator on a recording, with the same step as in the live process.
//!
//! One row for each row of the recording. Dirty data (gaps, repeats, cells without a value) are the estimator's business; a
//! file of another form is bad input.

use std::io::IsTerminal;
use std::path::PathBuf;

use indicatif::ProgressBar;
use railgrip_filter::{EstimatorConfig, EstimatorInput, EstimatorOutput, WagonEstimator};
use railgrip_recording::{Recording, Row, Strictness, Table, suffix};
use railgrip_settings::{Overrides, TrainSettings};

use crate::CliError;
use crate::output::say;

/// Estimate adhesion and pad friction of a recording, sample by sample.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording of one wagon, CSV or Parquet
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Vehicle file of the wagon
    #[arg(long, value_name = "FILE")]
    vehicle: PathBuf,
    /// File for the estimates, CSV or Parquet
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Filter: default, paper or rig [default: as the config says, else "default"]
    #[arg(long, value_name = "NAME")]
    filter: Option<String>,
    /// Config of a train whose [estimator] settings apply
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let mut config = match &args.config {
        Some(file) => TrainSettings::load(Some(file), &Overrides::default())?.estimator,
        None => EstimatorConfig::default(),
    };
    if let Some(filter) = &args.filter {
        config.filter.clone_from(filter);
    }
    let vehicle = railgrip_settings::vehicle::load(&args.vehicle).map_err(CliError::bad_input)?;
    let recording = Recording::read(&args.run, Strictness::Tolerant).map_err(CliError::bad_input)?;
    if recording.wheelsets != vehicle.wheelsets() {
        return Err(CliError::bad_input(format!(
            "{} has {} wheelsets, {} has {}",
            args.run.display(),
            recording.wheelsets,
            args.vehicle.display(),
            vehicle.wheelsets()
        )));
    }
    let mut estimator = WagonEstimator::new(&config, &vehicle).map_err(CliError::bad_input)?;
    let bar = match std::io::stderr().is_terminal() {
        true => ProgressBar::new(recording.len() as u64),
        false => ProgressBar::hidden(),
    };
    let mut estimates = Vec::with_capacity(recording.len());
    for row in recording.rows() {
        estimates.push(estimator.step(&input(&row)));
        if estimates.len() % 4096 == 0 {
            bar.set_position(estimates.len() as u64);
        }
    }
    bar.finish_and_clear();
    let table = Table::new(columns(&estimates, recording.wheelsets)).map_err(CliError::failed)?;
    table.write(&args.out).map_err(CliError::failed)?;
    say(&format!("{}: {} estimates by filter \"{}\"", args.out.display(), estimates.len(), config.filter));
    Ok(())
}

fn input(row: &Row) -> EstimatorInput {
    let wsp_active = (0..row.wsp_active.len()).filter(|&i| row.wsp_active[i] > 0.5).map(|i| 1 << i).sum();
    EstimatorInput {
        time_s: row.t_s,
        v_m_s: row.v_m_s,
        wheel_speed_rad_s: row.wheel_speed_rad_s,
        pressing_force_n: row.pressing_force_n,
        drive_torque_nm: row.drive_torque_nm,
        grade_rad: row.grade_rad,
        sanding: row.sanding,
        position_m: row.position_m,
        wsp_active,
        ..EstimatorInput::missing(row.t_s)
    }
}

/// The columns of the file; `f` and `r` for two wheelsets, else numbers from the front.
fn columns(estimates: &[EstimatorOutput], wheelsets: usize) -> Vec<(String, Vec<f64>)> {
    let column = |value: &dyn Fn(&EstimatorOutput) -> f64| estimates.iter().map(value).collect::<Vec<_>>();
    let bit = |mask: u32, i: usize| f64::from((mask >> i) & 1);
    let mut columns = vec![
        ("t_s".to_owned(), column(&|e| e.time_s)),
        ("v_m_s".to_owned(), column(&|e| e.v_m_s)),
        ("mu_w".to_owned(), column(&|e| e.mu_w)),
        ("mu_w_sigma".to_owned(), column(&|e| e.mu_w_sigma)),
    ];
    for i in 0..wheelsets {
        let name = suffix(i, wheelsets);
        columns.push((format!("mu_b_{name}"), column(&|e| e.mu_b[i])));
        columns.push((format!("mu_b_{name}_sigma"), column(&|e| e.mu_b_sigma[i])));
    }
    for i in 0..wheelsets {
        columns.push((format!("slip_{}", suffix(i, wheelsets)), column(&|e| e.slip[i])));
    }
    columns.push(("nis".to_owned(), column(&|e| e.nis)));
    for i in 0..wheelsets {
        columns.push((format!("observable_{}", suffix(i, wheelsets)), column(&|e| bit(e.observable, i))));
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_those_of_the_design() {
        let names: Vec<_> = columns(&[], 2).into_iter().map(|(name, _)| name).collect();
        assert_eq!(
            names.join(", "),
            "t_s, v_m_s, mu_w, mu_w_sigma, mu_b_f, mu_b_f_sigma, mu_b_r, mu_b_r_sigma, slip_f, slip_r, nis, \
             observable_f, observable_r"
        );
    }
}
