//! Brake gear of one wagon: distributor, cylinders, pads and their heat.

use crate::random::{Stream, Wander};

use super::{
    faults::WagonDefects,
    protection::{Protection, Valve},
    units::PerWheelset,
};

/// Time constant of a cylinder behind an open valve, s.
const CYLINDER_S: f64 = 0.12;
/// The same through the choke after venting, s.
const REFILL_S: f64 = 0.3;
/// Temperature from which pads may fade, °C.
const FADE_FROM_C: f64 = 80.0;
/// Share of pressure that a leak takes in the end, against the feed.
const MOST_LEAKED: f64 = 0.8;

/// How the pads of a wagon behave.
#[derive(Debug, Clone, Copy)]
pub struct Pads {
    /// Level of friction of each wheelset.
    pub friction: PerWheelset,
    /// Relative loss from standstill to very high speed.
    pub speed_loss: f64,
    /// Relative loss from light to full pressing.
    pub pressing_loss: f64,
    /// Relative loss a 100 K of a healthy pad.
    pub heat_loss: f64,
    /// Standard deviation and correlation time (s) of its wander.
    pub wander: (f64, f64),
    /// Heat that one wheelset's discs or treads take up, J/K.
    pub heat_j_per_k: f64,
}

/// The brake gear of one wagon, as built.
#[derive(Debug, Clone, Copy)]
pub struct GearPlan {
    /// Pads.
    pub pads: Pads,
    /// Pressing force of one wheelset at full brake, N.
    pub full_force_n: PerWheelset,
    /// Effective radius of the pads, m.
    pub pad_radius_m: f64,
    /// Cylinder pressure of a full brake over what is ordered: spread of the distributor.
    pub gain: f64,
    /// Time from empty to full and back, s.
    pub fill_s: f64,
    /// Time of release, s.
    pub release_s: f64,
}

/// Brake gear at work.
#[derive(Debug, Clone)]
pub(crate) struct Gear {
    pub(crate) plan: GearPlan,
    distributor: f64,
    /// Pressure of each cylinder over that of a full brake.
    pub(crate) cylinder: PerWheelset,
    pub(crate) temperature_c: PerWheelset,
    wander: [Wander; 4],
    /// Friction of the pads now.
    pub(crate) friction: PerWheelset,
    /// Share of it that fade takes now.
    pub(crate) faded: PerWheelset,
    /// Pad force that comes from the cylinders, N.
    pub(crate) pad_force_n: PerWheelset,
    /// Torque that the pads can exert, N m.
    pub(crate) capacity_nm: PerWheelset,
    choked: [bool; 4],
    leaked: PerWheelset,
}

/// What the gear needs to know of the wheels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turning<'a> {
    pub(crate) wheelsets: usize,
    pub(crate) wheel_speed_rad_s: &'a PerWheelset,
    pub(crate) radius_m: &'a PerWheelset,
    pub(crate) braked_nm: &'a PerWheelset,
    pub(crate) air_c: f64,
}

impl Gear {
    pub(crate) fn new(plan: GearPlan, seed: u64, wagon: usize, air_c: f64, tick_s: f64) -> Self {
        let (sigma, correlation_s) = plan.pads.wander;
        let wander = |k: usize| {
            Wander::new(Stream::new(seed, "pad wander", (4 * wagon + k) as u64), sigma, correlation_s, tick_s)
        };
        let mut warm = Stream::new(seed, "pad warmth", wagon as u64);
        Self {
            plan,
            distributor: 0.0,
            cylinder: [0.0; 4],
            temperature_c: std::array::from_fn(|_| air_c + warm.uniform(0.0, 25.0)),
            wander: std::array::from_fn(wander),
            friction: plan.pads.friction,
            faded: [0.0; 4],
            pad_force_n: [0.0; 4],
            capacity_nm: [0.0; 4],
            choked: [false; 4],
            leaked: [0.0; 4],
        }
    }

    /// One tick: `order` is the brake that the distributor hears, 0 to 1.
    pub(crate) fn advance(
        &mut self,
        order: f64,
        protection: &Protection,
        defects: &WagonDefects,
        turning: &Turning<'_>,
        step_s: f64,
    ) {
        self.distribute(order, defects, step_s);
        for k in 0..turning.wheelsets {
            self.fill(k, protection.valve[k], defects, step_s);
            self.press(k, defects, turning);
            self.warm(k, turning, step_s);
        }
    }

    fn distribute(&mut self, order: f64, defects: &WagonDefects, step_s: f64) {
        let order = if defects.cut_off { 0.0 } else { order };
        // The first stroke brings the pads to the discs at once.
        let wanted = if order > 0.03 { (self.plan.gain * order).max(0.08) } else { 0.0 };
        let wanted = wanted.max(defects.residual);
        let slow = 1.0 + defects.slowness;
        let (up, down) = (0.95 / (self.plan.fill_s * slow), -0.95 / (self.plan.release_s * slow));
        let rate = ((wanted - self.distributor) / 0.3).clamp(down, up);
        self.distributor += step_s * rate;
    }

    fn fill(&mut self, k: usize, valve: Valve, defects: &WagonDefects, step_s: f64) {
        let defect = &defects.wheelset[k];
        let valve = if defect.valve_dead { Valve::Fill } else { valve };
        let behind = self.distributor * (1.0 - defect.pressure_lost);
        let (target, time_s) = match valve {
            Valve::Fill => (behind, if self.choked[k] { REFILL_S } else { CYLINDER_S }),
            Valve::Hold => (self.cylinder[k].min(behind), CYLINDER_S),
            Valve::Vent => (0.0, CYLINDER_S),
        };
        self.choked[k] = match valve {
            Valve::Fill => self.choked[k] && self.cylinder[k] < 0.97 * behind,
            Valve::Hold | Valve::Vent => true,
        };
        // Fed through a choke, a leaking cylinder sags while the brake is held and is whole again with the next filling.
        self.leaked[k] = if self.distributor > 0.03 {
            self.leaked[k] + step_s * defect.leak_per_s * (MOST_LEAKED - self.leaked[k])
        } else {
            0.0
        };
        let rate = (target * (1.0 - self.leaked[k]) - self.cylinder[k]) / time_s;
        self.cylinder[k] = (self.cylinder[k] + step_s * rate).max(0.0);
    }

    fn press(&mut self, k: usize, defects: &WagonDefects, turning: &Turning<'_>) {
        let pads = &self.plan.pads;
        let defect = &defects.wheelset[k];
        let full_n = self.plan.full_force_n[k];
        let rim_m_s = (turning.wheel_speed_rad_s[k] * turning.radius_m[k]).abs();
        let heat = 0.01 * (self.temperature_c[k] - FADE_FROM_C).max(0.0);
        let level = pads.friction[k] * (1.0 + self.wander[k].advance()) * (1.0 - defect.friction_lost);
        let speed = 1.0 - pads.speed_loss * (rim_m_s / (rim_m_s + 18.0) - 0.5);
        let pressing = 1.0 - pads.pressing_loss * (self.cylinder[k].min(1.2) - 0.5);
        let left = 1.0 / (1.0 + defect.fade * heat);
        self.faded[k] = 1.0 - left;
        let warm = (1.0 - pads.heat_loss * heat.min(4.0)) * left;
        self.friction[k] = level * speed * pressing * warm;
        self.pad_force_n[k] = full_n * self.cylinder[k];
        self.capacity_nm[k] =
            self.friction[k] * self.plan.pad_radius_m * (self.pad_force_n[k] + full_n * defect.drag);
    }

    fn warm(&mut self, k: usize, turning: &Turning<'_>, step_s: f64) {
        let omega = turning.wheel_speed_rad_s[k].abs();
        let power_w = (turning.braked_nm[k] * omega).abs();
        let cooling_w_per_k = 25.0 + 6.0 * omega * turning.radius_m[k];
        let lost_w = cooling_w_per_k * (self.temperature_c[k] - turning.air_c);
        self.temperature_c[k] += step_s * (power_w - lost_w) / self.plan.pads.heat_j_per_k;
    }
}
