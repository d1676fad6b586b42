//! How a real wagon may depart from its data sheet: the places in the equations where something can differ.
//!
//! A departure sees the [`Moment`] and answers at the places it touches; everywhere else the defaults leave the wagon
//! alone. Hidden states (a temperature, a film, a lag) live in the departure and advance once an integration step.

use crate::{sheet::Rail, wagon::TrueWagon};

/// What is going on at the start of an integration step. Index 0 is the leading wheelset.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// Length of the step, s.
    pub step_s: f64,
    /// Time since the run began, s.
    pub time_s: f64,
    /// Rail class of the run.
    pub rail: Rail,
    /// Speed of the wagon, m/s.
    pub v_m_s: f64,
    /// Its acceleration, m/s².
    pub acceleration_m_s2: f64,
    /// Distance run, m (of the leading wheelset).
    pub position_m: f64,
    /// Wheel speeds, rad/s.
    pub wheel_speed_rad_s: [f64; 2],
    /// Angle turned since the run began, rad.
    pub wheel_angle_rad: [f64; 2],
    /// Place of each contact on the track, m.
    pub contact_m: [f64; 2],
    /// Pressing force that the brake cylinder gives, N.
    pub cylinder_force_n: [f64; 2],
    /// Brake torque at the disc, N m (positive retards a wheel that rolls forward).
    pub brake_torque_nm: [f64; 2],
    /// Traction torque, N m.
    pub drive_torque_nm: [f64; 2],
    /// Power that the contact burns by sliding, W.
    pub sliding_power_w: [f64; 2],
    /// Whether the sanders run.
    pub sanding: bool,
}

/// What the sensors would show, before their noise.
#[derive(Debug, Clone, Copy)]
pub struct Sensed {
    /// Speed, m/s.
    pub v_m_s: f64,
    /// Wheel speeds, rad/s.
    pub wheel_speed_rad_s: [f64; 2],
}

/// One way in which the wagon is not what its sheet says.
pub trait Departure: Send {
    /// Forgets every hidden state: a run begins.
    fn begin(&mut self) {}

    /// Changes constants of the wagon.
    fn adapt(&self, _wagon: &mut TrueWagon) {}

    /// Advances hidden states over the step that begins now.
    fn advance(&mut self, _now: &Moment) {}

    /// Factor on pad friction.
    fn pad_friction(&self, _wheelset: usize, _now: &Moment) -> f64 {
        1.0
    }

    /// Force at the pad, given the force that the cylinder pressure stands for, N.
    fn pad_force_n(&self, _wheelset: usize, cylinder_n: f64, _now: &Moment) -> f64 {
        cylinder_n
    }

    /// Extra torque that retards a wheelset, N m.
    fn drag_torque_nm(&self, _wheelset: usize, _now: &Moment) -> f64 {
        0.0
    }

    /// Factor on the traction torque.
    fn drive(&self, _wheelset: usize, _now: &Moment) -> f64 {
        1.0
    }

    /// Torque that reaches the wheel out of what acts on its shaft, N m.
    fn shaft_torque_nm(&self, _wheelset: usize, torque_nm: f64, _now: &Moment) -> f64 {
        torque_nm
    }

    /// Factor on peak adhesion at this slip velocity (m/s, never negative).
    fn rail_friction(&self, _wheelset: usize, _slip_velocity_m_s: f64, _now: &Moment) -> f64 {
        1.0
    }

    /// Factor on the transfer of load between the wheelsets.
    fn load_transfer(&self, _now: &Moment) -> f64 {
        1.0
    }

    /// Extra force on the body, forward positive, N.
    fn body_force_n(&self, _now: &Moment) -> f64 {
        0.0
    }

    /// Wind against the wagon, m/s.
    fn headwind_m_s(&self, _now: &Moment) -> f64 {
        0.0
    }

    /// What the grade is more than its map says, rad.
    fn grade_error_rad(&self, _now: &Moment) -> f64 {
        0.0
    }

    /// Changes what the sensors show; called once a sample, every 10 ms.
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

    /// A quantity handed through all departures in turn.
    pub fn chain(&self, start: f64, link: impl Fn(&dyn Departure, f64) -> f64) -> f64 {
        self.0.iter().fold(start, |value, departure| link(departure.as_ref(), value))
    }
}

/// What a draw yields: the departure and its parameters by name, in this plant's own terms.
pub type Drawn = (Box<dyn Departure>, Vec<(&'static str, f64)>);
