//! Slip averaged over a while, to see how far contacts are bent from the linear law.

/// Time over which slip is averaged to see that ratio, s.
const SLIP_WINDOW_S: f64 = 1.0;
/// Creep below which slip says nothing about it, m/s.
const LEAST_CREEP_M_S: f64 = 0.01;

/// Slip and the creep of the linear law, averaged over the last second, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MeanSlip {
    pub slip_m_s: f64,
    pub creep_m_s: f64,
}

impl MeanSlip {
    pub(crate) fn note(&mut self, slip_m_s: f64, creep_m_s: f64, dt_s: f64) {
        let share = dt_s / (dt_s + SLIP_WINDOW_S);
        self.slip_m_s += share * (slip_m_s - self.slip_m_s);
        self.creep_m_s += share * (creep_m_s - self.creep_m_s);
    }

    /// Force over creepage against that of small creepage, as slip shows it.
    pub(crate) fn secant(&self) -> f64 {
        if self.creep_m_s.abs() < LEAST_CREEP_M_S {
            return 1.0;
        }
        (self.creep_m_s / self.slip_m_s).clamp(0.0, 1.0)
    }
}
