//! Recordings of a bogie rig: `t_s, shaft_torque_nm, load_cell_n, brake_pressure_pa, load_n, roller_pulses,
//! wheel_pulses_f, wheel_pulses_r`. The rollers' counter is read at 8 Hz: its cells are empty in between.

use crate::rig::{RIG_VALUES, RigColumn, RigRecording, RigRow};

/// One sample of a bogie rig; NaN is not measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BogieRow {
    /// Time on the recorder's base, s.
    pub t_s: f64,
    /// Torque between motor and gear, N m.
    pub shaft_torque_nm: f64,
    /// Force of the link that holds the bogie, N, positive in braking.
    pub load_cell_n: f64,
    /// Pressure at the calipers, Pa.
    pub brake_pressure_pa: f64,
    /// Normal load of the bogie, N.
    pub load_n: f64,
    /// Pulses of the rollers' encoder in the window that ends now; NaN within a window.
    pub roller_pulses: f64,
    /// Pulses of each wheelset's encoder since the last sample.
    pub wheel_pulses: [f64; 2],
}

/// One run of a bogie rig.
pub type BogieRecording = RigRecording<BogieRow>;

impl RigRow for BogieRow {
    const COLUMNS: [RigColumn; 1 + RIG_VALUES] = [
        RigColumn::new("t_s", -1e12..=1e12, "s"),
        RigColumn::new("shaft_torque_nm", -1e6..=1e6, "N m"),
        RigColumn::new("load_cell_n", -1e7..=1e7, "N"),
        RigColumn::new("brake_pressure_pa", -1e6..=1e8, "Pa"),
        RigColumn::new("load_n", 0.0..=1e7, "N"),
        RigColumn { sparse: true, ..RigColumn::new("roller_pulses", -1e6..=1e6, "pulses") },
        RigColumn::new("wheel_pulses_f", -1e6..=1e6, "pulses"),
        RigColumn::new("wheel_pulses_r", -1e6..=1e6, "pulses"),
    ];

    fn of(t_s: f64, values: [f64; RIG_VALUES]) -> Self {
        let [shaft_torque_nm, load_cell_n, brake_pressure_pa, load_n, roller_pulses, front, rear] = values;
        Self {
            t_s,
            shaft_torque_nm,
            load_cell_n,
            brake_pressure_pa,
            load_n,
            roller_pulses,
            wheel_pulses: [front, rear],
        }
    }

    fn t_s(&self) -> f64 {
        self.t_s
    }

    fn values(&self) -> [f64; RIG_VALUES] {
        let [front, rear] = self.wheel_pulses;
        let forces = [self.shaft_torque_nm, self.load_cell_n, self.brake_pressure_pa, self.load_n];
        [forces[0], forces[1], forces[2], forces[3], self.roller_pulses, front, rear]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Strictness;

    #[test]
    fn a_counter_that_is_read_seldom_is_no_gap_and_any_other_empty_cell_is() {
        let row = |k: usize| {
            let pulses = if k.is_multiple_of(12) { 13.0 } else { f64::NAN };
            BogieRow::of(0.01 * k as f64, [40.0, 1500.0, 8e5, 8120.0, pulses, 40.0, 39.0])
        };
        let run = BogieRecording { name: "run".into(), rows: (0..400).map(row).collect() };
        let folder = tempfile::tempdir().expect("folder");
        for ending in ["csv", "parquet"] {
            let path = folder.path().join(format!("run.{ending}"));
            run.write(&path).expect("written");
            let read = BogieRecording::read(&path, Strictness::Strict).expect("strict");
            assert_eq!((read.rows.len(), read.rows[12]), (400, run.rows[12]));
            assert!(read.rows[13].roller_pulses.is_nan() && read.rows[13].wheel_pulses == [40.0, 39.0]);
        }
        let mut torn = run;
        torn.rows[7].load_cell_n = f64::NAN;
        let path = folder.path().join("torn.csv");
        torn.write(&path).expect("written");
        let said = BogieRecording::read(&path, Strictness::Strict).expect_err("a missing force").to_string();
        println!("{said}");
        assert!(said.contains("line 9") && said.contains("load_cell_n"));
    }
}
