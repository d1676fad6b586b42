//! Recordings with truth beside them, and the figures by which an estimator is judged.
#![allow(dead_code)]

pub mod plant;

use railgrip_filter::{EstimatorConfig, EstimatorOutput, WagonEstimator, WagonSample};
use railgrip_vehicle::VehicleParameters;
use std::path::Path;

/// A recording with truth.
pub struct Run {
    pub case: String,
    pub name: String,
    pub inputs: Vec<WagonSample>,
    pub truth: Vec<Truth>,
}

/// What no sensor sees.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    pub v_m_s: f64,
    pub mu_w: f64,
    pub mu_w_wheelset: [f64; 2],
    /// NaN where the brake hardly presses.
    pub mu_b: [f64; 2],
}

pub fn vehicle(case: &Path) -> VehicleParameters {
    toml::from_str(&std::fs::read_to_string(case.join("vehicle.toml")).unwrap()).unwrap()
}

fn table(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let header = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let number = |field: &str| field.parse().unwrap_or(f64::NAN);
    (header, lines.map(|line| line.split(',').map(number).collect()).collect())
}

/// Every run of a case that has truth.
pub fn runs(case: &Path) -> Vec<Run> {
    let mut names: Vec<_> =
        std::fs::read_dir(case.join("truth")).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    names.into_iter().map(|file| run(case, &file.into_string().unwrap())).collect()
}

fn run(case: &Path, file: &str) -> Run {
    let (set, name) = file.split_once('.').unwrap();
    let (header, rows) = table(&case.join(set).join(name));
    let at = |row: &[f64], column: &str| {
        header.iter().position(|known| known == column).map_or(f64::NAN, |index| row[index])
    };
    let two = |row: &[f64], front: &str, rear: &str| [at(row, front), at(row, rear), f64::NAN, f64::NAN];
    let inputs = rows
        .iter()
        .map(|row| WagonSample {
            time_s: at(row, "t_s"),
            v_m_s: at(row, "v_m_s"),
            wheel_speed_rad_s: two(row, "omega_f_rad_s", "omega_r_rad_s"),
            pressing_force_n: two(row, "f_perp_f_n", "f_perp_r_n"),
            drive_torque_nm: two(row, "m_w_f_nm", "m_w_r_nm"),
            grade_rad: at(row, "grade_rad"),
            sanding: at(row, "sanding"),
            position_m: at(row, "position_m"),
            wsp_active: 0,
            load_kg: f64::NAN,
        })
        .collect();
    let (_, rows) = table(&case.join("truth").join(file));
    let truth = rows
        .iter()
        .map(|row| Truth {
            v_m_s: row[1],
            mu_w: row[2],
            mu_w_wheelset: [row[3], row[4]],
            mu_b: [row.get(5).copied().unwrap_or(f64::NAN), row.get(6).copied().unwrap_or(f64::NAN)],
        })
        .collect();
    Run {
        case: case.file_name().unwrap().to_string_lossy().into_owned(),
        name: name.trim_end_matches(".csv").to_owned(),
        inputs,
        truth,
    }
}

pub fn estimate(
    config: &EstimatorConfig,
    vehicle: &VehicleParameters,
    inputs: &[WagonSample],
) -> Vec<EstimatorOutput> {
    let mut estimator = WagonEstimator::new(config, vehicle).unwrap();
    inputs.iter().map(|input| estimator.step(input)).collect()
}

/// Share and squares of one estimated quantity.
#[derive(Clone, Copy, Debug, Default)]
pub struct Score {
    pub count: f64,
    pub squares: f64,
    pub sum: f64,
    pub inside: f64,
    pub worst: f64,
}

impl Score {
    pub fn add(&mut self, error: f64, sigma: f64) {
        self.count += 1.0;
        self.squares += error * error;
        self.sum += error;
        self.worst = self.worst.max(error.abs());
        if error.abs() <= 1.96 * sigma {
            self.inside += 1.0;
        }
    }
    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.squares += other.squares;
        self.sum += other.sum;
        self.inside += other.inside;
        self.worst = self.worst.max(other.worst);
    }
    pub fn rmse(&self) -> f64 {
        (self.squares / self.count.max(1.0)).sqrt()
    }
    /// Share of samples whose 95 % interval holds the truth.
    pub fn coverage(&self) -> f64 {
        self.inside / self.count.max(1.0)
    }
}

/// The figures of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Figures {
    pub adhesion: Score,
    /// Samples whose adhesion is off by more than 0.02.
    pub far: f64,
    pub pad_mean: Score,
    pub pad_observable: Score,
    pub pad_other: Score,
    pub nis: f64,
    pub nis_dof: f64,
    pub rejected: f64,
}

impl Figures {
    pub fn merge(&mut self, other: &Self) {
        self.adhesion.merge(&other.adhesion);
        self.pad_mean.merge(&other.pad_mean);
        self.pad_observable.merge(&other.pad_observable);
        self.pad_other.merge(&other.pad_other);
        self.far += other.far;
        self.nis += other.nis;
        self.nis_dof += other.nis_dof;
        self.rejected += other.rejected;
    }
    pub fn line(&self) -> String {
        format!(
            "mu_w rmse {:.5} bias {:8.5} far {:.3}% cov {:.1}% | pad mean {:.4} bias {:7.4} cov {:5.1}% | pad own obs n{:6} {:.4} cov {:5.1}% rest n{:6} {:.4} cov {:5.1}% | nis/dof {:.3} rej {}",
            self.adhesion.rmse(),
            self.adhesion.sum / self.adhesion.count,
            100.0 * self.far / self.adhesion.count,
            100.0 * self.adhesion.coverage(),
            self.pad_mean.rmse(),
            self.pad_mean.sum / self.pad_mean.count.max(1.0),
            100.0 * self.pad_mean.coverage(),
            self.pad_observable.count,
            self.pad_observable.rmse(),
            100.0 * self.pad_observable.coverage(),
            self.pad_other.count,
            self.pad_other.rmse(),
            100.0 * self.pad_other.coverage(),
            self.nis / self.nis_dof,
            self.rejected,
        )
    }
}

/// Judges a run: adhesion from 1 s on, pads from 3 s after each brake application began.
pub fn judge(run: &Run, outputs: &[EstimatorOutput]) -> Figures {
    let mut figures = Figures::default();
    let mut since_release_s = 0.0;
    for (index, out) in outputs.iter().enumerate() {
        let (input, truth) = (&run.inputs[index], &run.truth[index]);
        if index >= 100 {
            let error = out.mu_w - truth.mu_w;
            figures.adhesion.add(error, out.mu_w_sigma);
            figures.far += f64::from(u8::from(error.abs() > 0.02));
            figures.nis += out.nis;
            figures.nis_dof += f64::from(out.nis_dof);
            figures.rejected += f64::from(u8::from(out.rejected != 0));
        }
        let force = input.pressing_force_n;
        since_release_s = if force[0] + force[1] < 4000.0 { 0.0 } else { since_release_s + 0.01 };
        if since_release_s < 3.0 || truth.mu_b.iter().any(|mu| mu.is_nan()) {
            continue;
        }
        let share = force[0] / (force[0] + force[1]);
        let mean = share * truth.mu_b[0] + (1.0 - share) * truth.mu_b[1];
        figures.pad_mean.add(out.mu_b_mean - mean, out.mu_b_mean_sigma);
        for i in 0..2 {
            let score = if out.observable & (1 << i) != 0 {
                &mut figures.pad_observable
            } else {
                &mut figures.pad_other
            };
            score.add(out.mu_b[i] - truth.mu_b[i], out.mu_b_sigma[i]);
        }
    }
    figures
}
