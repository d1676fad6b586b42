//! Dragging brakes: a retarding force while the brakes are released.
//!
//! Over blocks of a few seconds with the brakes off, the acceleration is the slope of the measured speed. What is missing in
//! `m_eff v̇ = F_drive − R(v) − m g sin(grade) − F_drag`, with `m_eff = m + Σ J / r²`, is the drag. Forces are shares of the
//! weight here. The force of couplers is not in the balance: in a coupled train the whole train shows the drag of one wagon.

use crate::measure::mean::BlockMean;
use crate::nominal::Nominal;
use bytemuck::{Pod, Zeroable};
use railgrip_messages::GRAVITY_M_S2;

/// Length of a block, s.
const BLOCK_S: f64 = 4.0;
/// The brakes must have been off for so long, s.
const RELEASED_S: f64 = 4.0;
/// Slower than this is manoeuvring, m/s.
const LEAST_SPEED_M_S: f64 = 3.0;
/// Running resistance is known to this share (1 σ): wind, load.
const RESISTANCE_SIGMA: f64 = 0.2;
/// The grade is known to this (1 σ), rad, where it is given and where it is not.
const GRADE_SIGMA_RAD: [f64; 2] = [0.0005, 0.005];

/// What is known about dragging.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(crate) struct Dragging {
    drag: BlockMean,
    resistance: BlockMean,
    released_s: f64,
    /// 1 if the grade was missing in some block.
    grade_unknown: u64,
    block: Block,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
struct Block {
    seconds: f64,
    count: f64,
    t: f64,
    tt: f64,
    v: f64,
    vv: f64,
    tv: f64,
    force: f64,
    resistance: f64,
}

/// One instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rolling {
    /// Measured speed, m/s.
    pub v_m_s: f64,
    /// Drive torques of all wheelsets, N m.
    pub drive_torque_nm: f64,
    /// Grade, rad; NaN if missing.
    pub grade_rad: f64,
    /// True if the brakes are off and nothing slides.
    pub released: bool,
}

impl Dragging {
    /// Takes in one instant that holds for `dt_s`.
    pub fn add(&mut self, dt_s: f64, now: Rolling, nominal: &Nominal, memory_s: f64) {
        self.released_s = if now.released { self.released_s + dt_s } else { 0.0 };
        let fits = self.released_s >= RELEASED_S && now.v_m_s.is_finite() && now.v_m_s > LEAST_SPEED_M_S;
        if !fits {
            self.block = Block::default();
            return;
        }
        let weight_n = nominal.weight_n();
        let grade_rad = if now.grade_rad.is_finite() { now.grade_rad } else { 0.0 };
        if !now.grade_rad.is_finite() {
            self.grade_unknown = 1;
        }
        let resistance = nominal.resistance_n(now.v_m_s) / weight_n;
        let block = &mut self.block;
        let t = block.seconds;
        block.seconds += dt_s;
        block.count += 1.0;
        block.t += t;
        block.tt += t * t;
        block.v += now.v_m_s;
        block.vv += now.v_m_s * now.v_m_s;
        block.tv += t * now.v_m_s;
        block.force += now.drive_torque_nm / (nominal.wheel_radius_m * weight_n) - grade_rad.sin();
        block.resistance += resistance;
        if block.seconds >= BLOCK_S {
            self.close(nominal, memory_s);
        }
    }

    fn close(&mut self, nominal: &Nominal, memory_s: f64) {
        let block = std::mem::take(&mut self.block);
        let n = block.count;
        let spread_t = block.tt - block.t * block.t / n;
        if n < 8.0 || spread_t <= 0.0 {
            return;
        }
        let slope_m_s2 = (block.tv - block.t * block.v / n) / spread_t;
        let spread_v = (block.vv - block.v * block.v / n).max(0.0);
        let left = (spread_v - slope_m_s2 * slope_m_s2 * spread_t).max(0.0) / (n - 2.0);
        let share = (1.0 + nominal.rotating_mass_kg() / nominal.mass_kg) / GRAVITY_M_S2;
        let drag = block.force / n - block.resistance / n - share * slope_m_s2;
        let sigma = share * (left / spread_t).sqrt();
        self.drag.add(block.seconds, drag, sigma, block.seconds, memory_s);
        self.resistance.add(block.seconds, block.resistance / n, 0.0, block.seconds, memory_s);
    }

    /// Drag as a share of the weight, with half its 95 % interval and the seconds behind it.
    pub fn drag(&self) -> Option<(f64, f64, f64)> {
        let (drag, resistance) = (self.drag.mean()?, self.resistance.mean()?);
        let grade = GRADE_SIGMA_RAD[usize::from(self.grade_unknown != 0)];
        let systematic = 1.96 * (RESISTANCE_SIGMA * resistance.value).hypot(grade);
        Some((drag.value, drag.half_width.hypot(systematic), self.drag.seconds))
    }
}
