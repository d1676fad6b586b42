//! Recordings of a driven rig: `t_s, i_alpha_a, i_beta_a, u_alpha_v, u_beta_v, omega_motor_rad_s, omega_roller_rad_s,
//! i_dc_a`, stator-fixed two-phase values, at 1 kHz or more.

use crate::checks::{Strictness, check_time};
use crate::error::{Problem, RecordingError, Result};
use crate::table::{Table, expect_columns};
use std::ops::RangeInclusive;
use std::path::Path;

/// Values in a row beside its time.
const VALUES: usize = 7;

/// The columns in the order of a file, with what a sensor can give and its unit.
const COLUMNS: [(&str, RangeInclusive<f64>, &str); 1 + VALUES] = [
    ("t_s", -1e12..=1e12, "s"),
    ("i_alpha_a", -1e5..=1e5, "A"),
    ("i_beta_a", -1e5..=1e5, "A"),
    ("u_alpha_v", -1e5..=1e5, "V"),
    ("u_beta_v", -1e5..=1e5, "V"),
    ("omega_motor_rad_s", -1e4..=1e4, "rad/s"),
    ("omega_roller_rad_s", -1e4..=1e4, "rad/s"),
    ("i_dc_a", -1e5..=1e5, "A"),
];

/// One sample of a driven rig; NaN is not measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorRow {
    /// Time on the recorder's base, s.
    pub t_s: f64,
    /// Stator current (α, β), A.
    pub current_a: [f64; 2],
    /// Stator voltage (α, β), V.
    pub voltage_v: [f64; 2],
    /// Speed of the motor, rad/s.
    pub motor_speed_rad_s: f64,
    /// Speed of the roller, rad/s.
    pub roller_speed_rad_s: f64,
    /// Current of the generator, A.
    pub generator_current_a: f64,
}

impl MotorRow {
    /// A row from the values of a file's columns.
    const fn of(t_s: f64, values: [f64; VALUES]) -> Self {
        let [i_alpha, i_beta, u_alpha, u_beta, motor, roller, generator] = values;
        Self {
            t_s,
            current_a: [i_alpha, i_beta],
            voltage_v: [u_alpha, u_beta],
            motor_speed_rad_s: motor,
            roller_speed_rad_s: roller,
            generator_current_a: generator,
        }
    }

    /// The values in the order of a file's columns.
    #[must_use]
    pub const fn values(&self) -> [f64; VALUES] {
        let ([i_alpha, i_beta], [u_alpha, u_beta]) = (self.current_a, self.voltage_v);
        [
            i_alpha,
            i_beta,
            u_alpha,
            u_beta,
            self.motor_speed_rad_s,
            self.roller_speed_rad_s,
            self.generator_current_a,
        ]
    }

    /// Whether a value, counted as in [`MotorRow::values`], is one that its sensor can give.
    #[must_use]
    pub fn is_plausible(&self, index: usize) -> bool {
        COLUMNS[1 + index].1.contains(&self.values()[index])
    }
}

/// One run of a driven rig.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MotorRecording {
    /// Name: the file's without its ending.
    pub name: String,
    /// Its samples.
    pub rows: Vec<MotorRow>,
}

impl MotorRecording {
    /// Names of the columns in the order of a file.
    #[must_use]
    pub fn columns() -> [&'static str; 1 + VALUES] {
        COLUMNS.map(|(name, _, _)| name)
    }

    /// Reads a run of either form.
    ///
    /// # Errors
    /// What is wrong, with file, line and column; see [`Strictness`] for what counts as wrong.
    pub fn read(path: &Path, strictness: Strictness) -> Result<Self> {
        let names = Self::columns();
        let table = Table::read_checked(path, &expect_columns(&names, &[]))?;
        if table.rows() == 0 {
            return Err(RecordingError::new(path, Problem::EmptyRun));
        }
        table.require_finite(names[0])?;
        if strictness == Strictness::Strict {
            for (name, allowed, unit) in &COLUMNS {
                table.require_finite(name)?;
                let cells = table.column(name).unwrap_or_default();
                if let Some(row) = cells.iter().position(|value| !allowed.contains(value)) {
                    let (low, high) = (*allowed.start(), *allowed.end());
                    let problem = Problem::OutOfRange { value: cells[row], low, high, unit };
                    return Err(table.cell_error(row, name, problem));
                }
            }
            check_time(&table, names[0])?;
        }
        let cell =
            |index: usize, row: usize| table.column(names[index]).map_or(f64::NAN, |column| column[row]);
        let rows = (0..table.rows())
            .map(|row| MotorRow::of(cell(0, row), std::array::from_fn(|index| cell(1 + index, row))))
            .collect();
        let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        Ok(Self { name, rows })
    }

    /// Writes the run atomically; the ending of `path` names the form.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut columns = vec![("t_s".to_owned(), self.rows.iter().map(|row| row.t_s).collect::<Vec<_>>())];
        for (index, (name, _, _)) in COLUMNS[1..].iter().enumerate() {
            let cells = self.rows.iter().map(|row| row.values()[index]).collect();
            columns.push(((*name).to_owned(), cells));
        }
        Table::new(columns)?.write(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run() -> MotorRecording {
        let row = |k: usize| {
            MotorRow::of(1e-3 * k as f64, [1.0, 2.0, 30.0, 40.0, 20.0, 3.3, 0.5 + 1e-3 * k as f64])
        };
        MotorRecording { name: "run".into(), rows: (0..1200).map(row).collect() }
    }

    #[test]
    fn a_run_survives_both_forms() {
        let folder = tempfile::tempdir().expect("folder");
        for ending in ["csv", "parquet"] {
            let path = folder.path().join(format!("run.{ending}"));
            run().write(&path).expect("written");
            assert_eq!(MotorRecording::read(&path, Strictness::Strict).expect("strict"), run());
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_file_line_and_column() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("run.csv");
        run().write(&path).expect("written");
        let good = std::fs::read_to_string(&path).expect("text");
        let line = |text: &str, number: usize, new: &str| {
            let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
            lines[number - 1] = new.to_owned();
            lines.join("\n")
        };
        let cases = [
            (good.replacen("u_beta_v", "u_gamma_v", 1), Strictness::Tolerant, "u_gamma_v"),
            (good.replacen(",i_dc_a", "", 1), Strictness::Tolerant, "run.csv"),
            (line(&good, 5, "0.003,1,2,x,40,20,3.3,0.5"), Strictness::Tolerant, "line 5"),
            (line(&good, 5, "0.003,1,2,,40,20,3.3,0.5"), Strictness::Strict, "u_alpha_v"),
            (line(&good, 5, "0.003,1,2,3e7,40,20,3.3,0.5"), Strictness::Strict, "u_alpha_v"),
            (line(&good, 5, "0.001,1,2,3,40,20,3.3,0.5"), Strictness::Strict, "t_s"),
            (
                "t_s,i_alpha_a,i_beta_a,u_alpha_v,u_beta_v,omega_motor_rad_s,omega_roller_rad_s,i_dc_a\n"
                    .into(),
                Strictness::Tolerant,
                "run.csv",
            ),
        ];
        for (text, strictness, words) in cases {
            std::fs::write(&path, text).expect("write");
            let said = MotorRecording::read(&path, strictness).expect_err(words).to_string();
            println!("{said}");
            assert!(said.contains(words) && said.contains("run.csv"), "{said}");
        }
        std::fs::write(&path, line(&good, 5, "0.003,1,2,,40,20,3.3,0.5")).expect("write");
        let run =
            MotorRecording::read(&path, Strictness::Tolerant).expect("an empty cell is a missing value");
        assert!(run.rows[3].voltage_v[0].is_nan());
    }
}
