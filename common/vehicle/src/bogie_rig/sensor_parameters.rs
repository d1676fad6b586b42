//! Constants of the sensors of the rig.

/// Force over which the rattle of the link fades, N. Chosen after the paper's Fig. 8.
const RATTLE_FADES_N: f64 = 250.0;

/// Constants of the sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorParameters {
    /// Pulses a revolution of the motor shaft.
    pub roller_pulses_per_rev: f64,
    /// Window of the rollers' counter, s.
    pub roller_window_s: f64,
    /// Pulses a revolution of a wheelset.
    pub wheel_pulses_per_rev: f64,
    /// Window of the wheelsets' counters and period of the analogue inputs, s.
    pub sample_period_s: f64,
    /// Zero error of the transducer, N m.
    pub torque_offset_nm: f64,
    /// Zero error of the load cell, N.
    pub load_cell_offset_n: f64,
    /// Torque that the transducer can tell, N m.
    pub torque_capacity_nm: f64,
    /// Force that the load cell can tell, N.
    pub load_cell_capacity_n: f64,
    /// One sigma of the transducer at no torque, N m, and its growth as a share of the torque.
    pub torque_sigma: (f64, f64),
    /// One sigma of the load cell under load, N, and that of its link's rattle, which a force of
    /// 250 N damps to 37 %, N.
    pub load_cell_sigma_n: (f64, f64),
}

impl Default for SensorParameters {
    /// From the paper: 90 pulses a revolution counted for 0.125 s, acquisition at 100 Hz, 100 N m, 500 kg. Chosen:
    /// wheelset encoders of 3600 pulses counted at 100 Hz (slip beyond the peak grows within some 30 ms; nothing could
    /// hold it from counts at 8 Hz), zero errors of 0.3 % of capacity, and noise after the paper's Fig. 8: the transducer
    /// jitters more under load, the link rattles until it is loaded.
    fn default() -> Self {
        Self {
            roller_pulses_per_rev: 90.0,
            roller_window_s: 0.125,
            wheel_pulses_per_rev: 3600.0,
            sample_period_s: 0.01,
            torque_offset_nm: 0.3,
            load_cell_offset_n: -15.0,
            torque_capacity_nm: 100.0,
            load_cell_capacity_n: 500.0 * crate::GRAVITY_M_S2,
            torque_sigma: (0.4, 0.02),
            load_cell_sigma_n: (12.0, 40.0),
        }
    }
}

impl SensorParameters {
    /// One sigma of the transducer at a torque, N m.
    pub fn torque_sigma_nm(&self, torque_nm: f64) -> f64 {
        self.torque_sigma.0 + self.torque_sigma.1 * torque_nm.abs()
    }

    /// One sigma of the load cell at a force, N.
    pub fn load_cell_sigma_n(&self, force_n: f64) -> f64 {
        self.load_cell_sigma_n.0 + self.load_cell_sigma_n.1 * (-force_n.abs() / RATTLE_FADES_N).exp()
    }
}
