//! A curve at a place of the equations, as an effect that any model can carry.

use super::covariate::{self, Covariate, HIDDEN};
use railgrip_vehicle::effects::{Effect, EffectSpec, Observation, Operating};
use std::sync::Arc;

/// A place that can be freed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Force on the body, N.
    BodyForce,
    /// Torque on wheelsets, N m, forward positive.
    WheelTorque,
    /// Relative change of pad friction.
    PadFriction,
    /// Relative change of the adhesion available.
    Adhesion,
    /// Load taken from the rear wheelset by the front one, relative.
    LoadShift,
    /// Error of wheelset speeds, rad/s.
    WheelSensor,
    /// Relative error of wheelset speeds.
    WheelScale,
    /// Error of vehicle speed, m/s.
    SpeedSensor,
    /// Relative change of drive torque.
    DriveTorque,
}

impl Place {
    /// Size of a change that matters, and the bound.
    pub(crate) fn scale(self) -> (f64, f64) {
        match self {
            Self::BodyForce => (300.0, 3e4),
            Self::WheelTorque => (100.0, 1e4),
            Self::PadFriction | Self::Adhesion | Self::DriveTorque | Self::LoadShift => (0.03, 0.9),
            Self::WheelSensor | Self::SpeedSensor => (0.05, 5.0),
            Self::WheelScale => (0.002, 0.2),
        }
    }
}

/// The wheelsets concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// All of them.
    All,
    /// All but the leading one.
    Following,
    /// The one of this index.
    One(usize),
}

impl Scope {
    pub(crate) fn has(self, wheelset: usize) -> bool {
        match self {
            Self::All => true,
            Self::Following => wheelset > 0,
            Self::One(index) => wheelset == index,
        }
    }

    /// In words, of a wagon with so many wheelsets; empty for all of them.
    pub(crate) fn words(self, wheelsets: usize) -> String {
        match (self, wheelsets) {
            (Self::All, _) => String::new(),
            (Self::One(0), 2) => "front wheelset".to_owned(),
            (Self::One(1) | Self::Following, 2) => "rear wheelset".to_owned(),
            (Self::One(index), _) => format!("wheelset {}", index + 1),
            (Self::Following, _) => "all wheelsets but the first".to_owned(),
        }
    }
}

/// A piecewise linear curve at a place of the equations.
#[derive(Debug)]
pub(super) struct Curve {
    pub place: Place,
    pub scope: Scope,
    pub covariate: Covariate,
    pub spec: &'static EffectSpec,
    pub radius_m: f64,
    pub knots: Arc<[f64]>,
    pub values: Vec<f64>,
}

impl Curve {
    fn at(&self, at: &Operating, hidden: &[f64], wheelset: usize) -> f64 {
        let x = covariate::value(self.covariate, at, hidden, wheelset, self.radius_m);
        if self.covariate == Covariate::WheelAngle {
            let step = std::f64::consts::TAU / self.knots.len() as f64;
            let from = ((x / step) as usize).min(self.knots.len() - 1);
            let share = x / step - from as f64;
            return self.values[from]
                + share * (self.values[(from + 1) % self.knots.len()] - self.values[from]);
        }
        let shape = interpolate(&self.knots, &self.values, x);
        // A released brake, a rolling wheel and an idle motor add nothing: fade in below the first knot.
        match self.covariate {
            Covariate::BrakeForce
            | Covariate::PressingForce
            | Covariate::SlipVelocity
            | Covariate::SlipPower
            | Covariate::SlipEnergy
                if x < self.knots[0] =>
            {
                shape * (x / self.knots[0]).clamp(0.0, 1.0)
            }
            Covariate::TimeInBraking | Covariate::WetBrakeEnergy if x <= 0.0 => 0.0,
            _ => shape,
        }
    }

    fn on(&self, place: Place, wheelset: usize) -> bool {
        self.place == place && self.scope.has(wheelset)
    }
}

/// Piecewise linear, constant beyond the ends.
pub fn interpolate(knots: &[f64], values: &[f64], x: f64) -> f64 {
    if x <= knots[0] {
        return values[0];
    }
    for k in 1..knots.len() {
        if x < knots[k] {
            let share = (x - knots[k - 1]) / (knots[k] - knots[k - 1]);
            return values[k - 1] + share * (values[k] - values[k - 1]);
        }
    }
    values[knots.len() - 1]
}

impl Effect for Curve {
    fn spec(&self) -> &'static EffectSpec {
        self.spec
    }

    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        HIDDEN
    }

    fn start(&self, at: &Operating, hidden: &mut [f64]) {
        covariate::start(at, hidden);
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        covariate::advance(at, dt_s, hidden);
    }

    fn brake_friction(&self, wheelset: usize, at: &Operating, hidden: &[f64], friction: f64) -> f64 {
        if !self.on(Place::PadFriction, wheelset) {
            return friction;
        }
        friction * (1.0 + self.at(at, hidden, wheelset)).max(0.0)
    }

    fn adhesion_peak(&self, wheelset: usize, at: &Operating, hidden: &[f64], peak: f64) -> f64 {
        let factor = |change: f64| peak * (1.0 + change).max(0.05);
        match self.place {
            Place::Adhesion if self.scope.has(wheelset) => factor(self.at(at, hidden, wheelset)),
            Place::LoadShift => {
                let [first, ..] = at.wheelset_position_m;
                factor(self.at(at, hidden, 0) * at.wheelset_position_m[wheelset] / first)
            }
            _ => peak,
        }
    }

    fn body_force_n(&self, at: &Operating, hidden: &[f64], force_n: f64) -> f64 {
        if self.place == Place::BodyForce { force_n + self.at(at, hidden, 0) } else { force_n }
    }

    fn drive_torque_nm(&self, wheelset: usize, at: &Operating, hidden: &[f64], torque_nm: f64) -> f64 {
        if self.on(Place::DriveTorque, wheelset) {
            torque_nm * (1.0 + self.at(at, hidden, wheelset))
        } else if self.on(Place::WheelTorque, wheelset) {
            torque_nm + self.at(at, hidden, wheelset)
        } else {
            torque_nm
        }
    }

    fn observe(&self, at: &Operating, hidden: &[f64], reading: &mut Observation) {
        if self.place == Place::SpeedSensor {
            reading.v_m_s += self.at(at, hidden, 0);
        }
        for i in 0..railgrip_vehicle::MAX_WHEELSETS {
            if self.on(Place::WheelSensor, i) {
                reading.wheel_speed_rad_s[i] += self.at(at, hidden, i);
            } else if self.on(Place::WheelScale, i) {
                reading.wheel_speed_rad_s[i] *= 1.0 + self.at(at, hidden, i);
            }
        }
    }
}
