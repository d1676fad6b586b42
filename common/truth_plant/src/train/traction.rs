//! Motors of one wagon: traction within power and grip, and the electric brake blended with the pads.

use super::{dynamics::Body, gear::Gear, units::PerWheelset};

/// The electric brake fades between these speeds, m/s.
const FADES_M_S: (f64, f64) = (1.5, 4.0);
/// Time constant of motor torque, s.
const MOTOR_S: f64 = 0.25;
/// Creepage at which anti-spin takes torque back.
const SPIN: f64 = 0.025;

/// Motors at work.
#[derive(Debug, Clone)]
pub(crate) struct Traction {
    /// Largest traction force and electric braking force, N, and power, W.
    limits: (f64, f64, f64),
    wheelsets: usize,
    /// Torque of each wheelset now, N m.
    pub(crate) torque_nm: PerWheelset,
    /// What anti-spin and a slide leave of the torque, 0 to 1.
    grip: f64,
    electric: f64,
}

impl Traction {
    pub(crate) fn new(limits: (f64, f64, f64), wheelsets: usize) -> Self {
        Self { limits, wheelsets, torque_nm: [0.0; 4], grip: 1.0, electric: 1.0 }
    }

    /// One tick; returns the brake order that is left for the pads. `wishes` are traction and brake, 0 to 1.
    pub(crate) fn advance(
        &mut self,
        wishes: (f64, f64),
        gear: &Gear,
        body: &Body,
        sliding: bool,
        step_s: f64,
    ) -> f64 {
        let (traction, order) = wishes;
        let (pull_n, electric_n, power_w) = self.limits;
        if pull_n <= 0.0 {
            return order;
        }
        let v = body.v_m_s.max(0.1);
        self.regulate(body, sliding, step_s);
        let full_nm: f64 = (0..self.wheelsets)
            .map(|k| gear.plan.full_force_n[k] * gear.plan.pad_radius_m * gear.plan.pads.friction[k])
            .sum();
        let (low, high) = FADES_M_S;
        let fading = ((v - low) / (high - low)).clamp(0.0, 1.0);
        let electric_nm = (electric_n.min(power_w / v) * fading * self.electric * body.radius_m[0]).max(0.0);
        let braking_nm = (order * full_nm).min(electric_nm);
        let wanted_nm = traction * self.grip * pull_n.min(power_w / v) * body.radius_m[0] - braking_nm;
        let each_nm = wanted_nm / self.wheelsets as f64;
        for torque_nm in &mut self.torque_nm[..self.wheelsets] {
            *torque_nm += step_s / (step_s + MOTOR_S) * (each_nm - *torque_nm);
        }
        let now_nm = -self.torque_nm[0] * self.wheelsets as f64;
        let braking_now_nm = if order > 0.0 { now_nm.clamp(0.0, order * full_nm) } else { 0.0 };
        (order - braking_now_nm / full_nm).max(0.0)
    }

    /// Whether the wheels spin so much that a driver lays sand.
    pub(crate) fn wants_sand(&self) -> bool {
        self.grip < 0.6 && self.torque_nm[0] > 0.0
    }

    /// Torque goes down fast in a spin or slide and comes back slowly.
    fn regulate(&mut self, body: &Body, sliding: bool, step_s: f64) {
        let creepage =
            (0..self.wheelsets).map(|k| body.slip_m_s(k) / (body.v_m_s.abs() + 1.0)).fold(0.0, f64::max);
        // The further beyond the limit, the faster; a creepage just above it is held.
        let change = if creepage > SPIN { -25.0 * (creepage - SPIN).min(0.08) } else { 0.04 };
        self.grip = (self.grip + step_s * change).clamp(0.05, 1.0);
        let change = if sliding { -2.0 } else { 0.2 };
        self.electric = (self.electric + step_s * change).clamp(0.0, 1.0);
    }
}
