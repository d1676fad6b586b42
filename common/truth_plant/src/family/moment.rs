//! What is going on in a step, and what sensors would show of it.

use super::{line::Line, units::PerWheelset, wagon::FamilyWagon};
use crate::sheet::Rail;

/// What is going on at the start of an integration step.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// Length of the step, s.
    pub step_s: f64,
    /// Interval of the recording's samples, s.
    pub sample_s: f64,
    /// Time since the run began, s.
    pub time_s: f64,
    /// Number of the run within its case.
    pub run: usize,
    /// Rail class of the run.
    pub rail: Rail,
    /// The mapped line.
    pub line: Line,
    /// Number of wheelsets.
    pub wheelsets: usize,
    /// Speed of the wagon, m/s.
    pub v_m_s: f64,
    /// Its acceleration in the step before, m/s².
    pub acceleration_m_s2: f64,
    /// Distance run, m (of the leading wheelset).
    pub position_m: f64,
    /// Wheel speeds, rad/s.
    pub wheel_speed_rad_s: PerWheelset,
    /// Angle turned since the run began, rad.
    pub wheel_angle_rad: PerWheelset,
    /// Place of each contact on the track, m.
    pub contact_m: PerWheelset,
    /// Slip velocity `r ω − v`, m/s.
    pub slip_m_s: PerWheelset,
    /// Power that each contact burns by sliding, W.
    pub sliding_power_w: PerWheelset,
    /// Pressing force that the brake cylinder gives, N.
    pub cylinder_force_n: PerWheelset,
    /// Brake torque of the step before, N m, never negative.
    pub brake_torque_nm: PerWheelset,
    /// Drive torque as it is reported, N m.
    pub drive_torque_nm: PerWheelset,
    /// Whether the sanders run.
    pub sanding: bool,
}

impl Moment {
    /// Mean of the cylinder forces, N.
    #[must_use]
    pub fn mean_force_n(&self) -> f64 {
        self.cylinder_force_n[..self.wheelsets].iter().sum::<f64>() / self.wheelsets as f64
    }

    /// 0 at standstill, 1 in motion, smooth between: what friction that opposes motion is multiplied with.
    #[must_use]
    pub fn moving(&self) -> f64 {
        let scaled = self.v_m_s / 0.3;
        if scaled > 20.0 { 1.0 } else { scaled.tanh() }
    }
}

/// What the sensors would show, before their noise.
#[derive(Debug, Clone, Copy)]
pub struct Sensed {
    /// Speed, m/s.
    pub v_m_s: f64,
    /// Wheel speeds, rad/s.
    pub wheel_speed_rad_s: PerWheelset,
}

/// One way in which the wagon is not what its sheet says: it answers at the places that it touches, elsewhere the
/// defaults leave the wagon alone. Hidden states (a temperature, a film, a lag) live in it.
pub trait Departure: Send {
    /// Forgets every hidden state: a run begins.
    fn begin(&mut self) {}
    /// Changes constants of the wagon.
    fn adapt(&self, _wagon: &mut FamilyWagon) {}
    /// Advances hidden states over the step that begins now.
    fn advance(&mut self, _now: &Moment) {}
    /// Factor on pad friction.
    fn pad_friction(&self, _wheelset: usize, _now: &Moment) -> f64 {
        1.0
    }
    /// Force at the pad, given the force that the cylinder pressure stands for, N.
    fn pad_force_n(&self, _wheelset: usize, force_n: f64, _now: &Moment) -> f64 {
        force_n
    }
    /// Extra torque that retards a wheelset, N m.
    fn drag_torque_nm(&self, _wheelset: usize, _now: &Moment) -> f64 {
        0.0
    }
    /// Factor on the drive torque that is reported.
    fn drive(&self, _wheelset: usize, _now: &Moment) -> f64 {
        1.0
    }
    /// Torque that reaches the wheel (N m, forward positive) where something lies between wheel and shaft.
    fn shaft_torque_nm(&self, _wheelset: usize, _torque_nm: f64, _now: &Moment) -> Option<f64> {
        None
    }
    /// Factor on the inertia that turns with the wheel.
    fn inertia(&self, _wheelset: usize, _now: &Moment) -> f64 {
        1.0
    }
    /// Factor on the rolling radius.
    fn radius(&self, _wheelset: usize, _now: &Moment) -> f64 {
        1.0
    }
    /// Factor on peak adhesion.
    fn rail_friction(&self, _wheelset: usize, _now: &Moment) -> f64 {
        1.0
    }
    /// Factor on the transfer of load between the wheelsets.
    fn load_transfer(&self, _now: &Moment) -> f64 {
        1.0
    }
    /// Extra mass, kg.
    fn extra_mass_kg(&self, _now: &Moment) -> f64 {
        0.0
    }
    /// Extra force on the body, forward positive, N.
    fn body_force_n(&self, _now: &Moment) -> f64 {
        0.0
    }
    /// Wind against the wagon, m/s.
    fn headwind_m_s(&self, _now: &Moment) -> f64 {
        0.0
    }
    /// What the slope is more than its map says, rad.
    fn grade_error_rad(&self, _now: &Moment) -> f64 {
        0.0
    }
    /// Changes what the sensors show; called once a sample.
    fn sense(&mut self, _now: &Moment, _shown: &mut Sensed) {}
}

/// All departures of one wagon acting together.
#[derive(Default)]
pub struct Departures(pub Vec<Box<dyn Departure>>);

impl Departures {
    /// Product of a factor over all departures.
    pub fn product(&self, factor: impl Fn(&dyn Departure) -> f64) -> f64 {
        self.0.iter().map(|departure| factor(departure.as_ref())).product()
    }

    /// Sum of a term over all departures.
    pub fn sum(&self, term: impl Fn(&dyn Departure) -> f64) -> f64 {
        self.0.iter().map(|departure| term(departure.as_ref())).sum()
    }
}
