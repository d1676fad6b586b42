//! Recordings of a driven rig: `t_s, i_alpha_a, i_beta_a, u_alpha_v, u_beta_v, omega_motor_rad_s, omega_roller_rad_s,
//! i_dc_a`, stator-fixed two-phase values, at 1 kHz or more.

use crate::rig::{RIG_VALUES, RigColumn, RigRecording, RigRow};

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

/// One run of a driven rig.
pub type MotorRecording = RigRecording<MotorRow>;

impl RigRow for MotorRow {
    const COLUMNS: [RigColumn; 1 + RIG_VALUES] = [
        RigColumn::new("t_s", -1e12..=1e12, "s"),
        RigColumn::new("i_alpha_a", -1e5..=1e5, "A"),
        RigColumn::new("i_beta_a", -1e5..=1e5, "A"),
        RigColumn::new("u_alpha_v", -1e5..=1e5, "V"),
        RigColumn::new("u_beta_v", -1e5..=1e5, "V"),
        RigColumn::new("omega_motor_rad_s", -1e4..=1e4, "rad/s"),
        RigColumn::new("omega_roller_rad_s", -1e4..=1e4, "rad/s"),
        RigColumn::new("i_dc_a", -1e5..=1e5, "A"),
    ];

    fn of(t_s: f64, values: [f64; RIG_VALUES]) -> Self {
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

    fn t_s(&self) -> f64 {
        self.t_s
    }

    fn values(&self) -> [f64; RIG_VALUES] {
        let ([i_alpha, i_beta], [u_alpha, u_beta]) = (self.current_a, self.voltage_v);
        let speeds = [self.motor_speed_rad_s, self.roller_speed_rad_s];
        [i_alpha, i_beta, u_alpha, u_beta, speeds[0], speeds[1], self.generator_current_a]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Strictness;

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
