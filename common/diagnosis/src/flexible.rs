//! Flexible discrepancies: one place of the equations freed as a smooth function of one covariate.
//!
//! They are what could be explained at all. A named effect that recovers little of what the best of them recovers is not
//! the answer, and where no effect is named they say at which place, over which variable and by how much the model
//! errs. Each is a piecewise linear function over six knots at quantiles of its covariate, with a weak prior that pulls
//! it towards zero, and is fitted like any candidate.

use crate::case::{Case, WHEELSETS};
use crate::library::Candidate;
use crate::parameters::{FittedEffect, Parameter};
use railgrip_vehicle::MAX_WHEELSETS;
use railgrip_vehicle::effects::{Effect, EffectSpec, Observation, Operating, Term};
use std::sync::Arc;

/// A place that can be freed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Force on the body, N.
    BodyForce,
    /// Relative change of pad friction.
    PadFriction,
    /// Relative change of the adhesion available.
    Adhesion,
    /// Error of wheelset speeds, rad/s.
    WheelSensor,
    /// Error of vehicle speed, m/s.
    SpeedSensor,
    /// Relative change of drive torque.
    DriveTorque,
}

/// A variable over which it is freed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Covariate {
    /// Vehicle speed, m/s.
    Speed,
    /// Position, m.
    Position,
    /// Time since the start of the run, s.
    Time,
    /// Sum of pressing forces, N.
    BrakeForce,
    /// Time since the brake was applied, s; 0 while released.
    TimeInBraking,
    /// Rise of disc temperature by a lumped model, K.
    Temperature,
    /// Power dissipated by slip, W.
    SlipPower,
    /// Energy dissipated by slip since the start of the run, J.
    SlipEnergy,
    /// Angle of the wheel within a revolution, rad.
    WheelAngle,
    /// Drive torque, N m.
    DriveTorque,
}

impl Covariate {
    /// Name in the report.
    pub fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Position => "position",
            Self::Time => "time",
            Self::BrakeForce => "brake_force",
            Self::TimeInBraking => "time_since_brake_onset",
            Self::Temperature => "temperature",
            Self::SlipPower => "slip_power",
            Self::SlipEnergy => "slip_energy",
            Self::WheelAngle => "wheel_angle",
            Self::DriveTorque => "drive_torque",
        }
    }

    /// Unit for people.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Speed => "m/s",
            Self::Position => "m",
            Self::Time | Self::TimeInBraking => "s",
            Self::BrakeForce => "N",
            Self::Temperature => "°C",
            Self::SlipPower => "W",
            Self::SlipEnergy => "J",
            Self::WheelAngle => "rad",
            Self::DriveTorque => "N m",
        }
    }
}

/// Places and covariates that are tried, with the term of the equations that each speaks for.
const TRIED: &[(Place, Covariate, Term)] = &[
    (Place::BodyForce, Covariate::Speed, Term::Resistance),
    (Place::BodyForce, Covariate::Position, Term::Resistance),
    (Place::BodyForce, Covariate::Time, Term::Resistance),
    (Place::BodyForce, Covariate::BrakeForce, Term::LongitudinalForce),
    (Place::BodyForce, Covariate::TimeInBraking, Term::LongitudinalForce),
    (Place::PadFriction, Covariate::Speed, Term::BrakeFriction),
    (Place::PadFriction, Covariate::Temperature, Term::BrakeFriction),
    (Place::PadFriction, Covariate::BrakeForce, Term::BrakeFriction),
    (Place::PadFriction, Covariate::WheelAngle, Term::BrakeFriction),
    (Place::PadFriction, Covariate::TimeInBraking, Term::BrakeActuation),
    (Place::Adhesion, Covariate::Speed, Term::Adhesion),
    (Place::Adhesion, Covariate::Position, Term::Adhesion),
    (Place::Adhesion, Covariate::SlipPower, Term::Adhesion),
    (Place::Adhesion, Covariate::SlipEnergy, Term::Adhesion),
    (Place::WheelSensor, Covariate::Speed, Term::SensorWheelSpeed),
    (Place::WheelSensor, Covariate::BrakeForce, Term::SensorWheelSpeed),
    (Place::WheelSensor, Covariate::WheelAngle, Term::SensorWheelSpeed),
    (Place::SpeedSensor, Covariate::Speed, Term::SensorSpeed),
    (Place::SpeedSensor, Covariate::Position, Term::SensorSpeed),
    (Place::SpeedSensor, Covariate::BrakeForce, Term::SensorSpeed),
    (Place::DriveTorque, Covariate::DriveTorque, Term::Drivetrain),
];

/// Knots of a curve.
const KNOTS: usize = 6;

macro_rules! specs {
    ($($name:ident: $term:ident;)*) => {
        $(static $name: EffectSpec = EffectSpec {
            id: "discrepancy",
            term: Term::$term,
            equation: "piecewise linear in one covariate",
            source: "flexible discrepancy, not a law",
            parameters: &[],
            hidden: &["disc temperature rise, K", "time since brake onset, s", "slip energy, J"],
            twins: &[],
            separated_by: "",
        };)*
        fn spec_of(term: Term) -> &'static EffectSpec {
            match term { $(Term::$term => &$name,)* _ => &RESISTANCE }
        }
    };
}
specs! {
    BRAKE_FRICTION: BrakeFriction;
    BRAKE_ACTUATION: BrakeActuation;
    ADHESION: Adhesion;
    RESISTANCE: Resistance;
    LONGITUDINAL_FORCE: LongitudinalForce;
    SENSOR_WHEEL_SPEED: SensorWheelSpeed;
    SENSOR_SPEED: SensorSpeed;
    DRIVETRAIN: Drivetrain;
}

/// A flexible discrepancy that can be tried.
#[derive(Clone, Debug)]
pub struct Flexible {
    /// Where.
    pub place: Place,
    /// Over what.
    pub covariate: Covariate,
    /// The term it speaks for.
    pub term: Term,
    /// Knots.
    pub knots: Arc<[f64]>,
    /// As a candidate.
    pub candidate: Candidate,
}

/// All flexible discrepancies whose covariate varies in the runs to fit on.
pub fn all(case: &Case) -> Vec<Flexible> {
    TRIED.iter().filter_map(|&(place, covariate, term)| flexible(case, place, covariate, term)).collect()
}

fn flexible(case: &Case, place: Place, covariate: Covariate, term: Term) -> Option<Flexible> {
    let knots: Arc<[f64]> = knots(case, covariate)?.into();
    let (scale, bound) = match place {
        Place::BodyForce => (300.0, 3e4),
        Place::PadFriction | Place::Adhesion | Place::DriveTorque => (0.03, 0.9),
        Place::WheelSensor => (0.05, 5.0),
        Place::SpeedSensor => (0.05, 5.0),
    };
    let parameters: Vec<Parameter> = knots
        .iter()
        .map(|x| Parameter {
            name: format!("at {x:.4}"),
            start: 0.0,
            lower: -bound,
            upper: bound,
            scale,
            prior_mean: 0.0,
            prior_sigma: 30.0 * scale,
        })
        .collect();
    let spec = spec_of(term);
    let shared = Arc::clone(&knots);
    let builder = move |values: &[f64]| -> Box<dyn Effect> {
        Box::new(Curve { place, covariate, spec, knots: Arc::clone(&shared), values: values.to_vec() })
    };
    let effect = FittedEffect::custom(spec, parameters, Arc::new(builder));
    Some(Flexible { place, covariate, term, knots, candidate: Candidate { spec, starts: vec![effect] } })
}

/// Knots at quantiles of the covariate where it is at work; `None` where it hardly varies.
fn knots(case: &Case, covariate: Covariate) -> Option<Vec<f64>> {
    if covariate == Covariate::WheelAngle {
        return Some((0..KNOTS).map(|k| k as f64 * std::f64::consts::TAU / KNOTS as f64).collect());
    }
    let mut values = samples_of(case, covariate);
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let at = |share: f64| values[((n - 1) as f64 * share) as usize];
    if n < 200 || at(0.98) - at(0.02) < 1e-3 * at(0.98).abs().max(1e-9) {
        return None;
    }
    let (low, high) = (at(0.01), at(0.99));
    // Between quantiles and an even grid: neither crowded at a plateau nor empty where little was recorded.
    let knot = |k: usize| {
        let share = k as f64 / (KNOTS - 1) as f64;
        0.5 * (low + share * (high - low)) + 0.5 * at(0.01 + 0.98 * share)
    };
    let mut knots: Vec<f64> = (0..KNOTS).map(knot).collect();
    knots.dedup_by(|a, b| (*a - *b).abs() < 1e-6 * (high - low));
    (knots.len() >= 3).then_some(knots)
}

/// Values of a covariate along the recordings, thinned.
fn samples_of(case: &Case, covariate: Covariate) -> Vec<f64> {
    let mut values = Vec::new();
    for run in &case.fit {
        values.extend(along(case, run, covariate).into_iter().step_by(20).filter(|v| match covariate {
            Covariate::BrakeForce | Covariate::TimeInBraking | Covariate::Temperature => *v > 0.0,
            Covariate::SlipPower | Covariate::SlipEnergy => *v > 10.0,
            Covariate::DriveTorque => v.abs() > 10.0,
            _ => true,
        }));
    }
    values
}

/// A covariate at each sample of a run, from what was recorded; the front wheelset's where each has its own.
pub fn along(case: &Case, run: &crate::case::Run, covariate: Covariate) -> Vec<f64> {
    let vehicle = &case.vehicle;
    let mut memory = [0.0; HIDDEN];
    run.samples
        .iter()
        .map(|sample| {
            let mut at = Operating {
                time_s: sample.time_s,
                v_m_s: sample.smooth[0],
                position_m: sample.position_m,
                ..Operating::default()
            };
            for i in 0..WHEELSETS {
                let omega = sample.smooth[1 + i];
                at.pressing_force_n[i] = sample.pressing_force_n[i];
                at.drive_torque_nm[i] = sample.mid_drive_torque_nm[i];
                at.wheel_speed_rad_s[i] = omega;
                at.wheel_angle_rad[i] = sample.wheel_angle_rad[i];
                let torque =
                    vehicle.brake.friction_coefficient * vehicle.brake.radius_m * sample.pressing_force_n[i];
                at.brake_power_w[i] = (torque * omega).max(0.0);
                let slip = sample.smooth[0] - vehicle.wheelset.radius_m * omega;
                let limit = vehicle.rail.adhesion(run.rail) * vehicle.body.mass_kg * 9.81 / WHEELSETS as f64;
                at.slip_power_w[i] = if slip.abs() > 0.1 { slip.abs() * limit } else { 0.0 };
            }
            advance(&at, run.dt_s, &mut memory);
            value(covariate, &at, &memory, 0)
        })
        .collect()
}

/// Hidden states of a curve: temperatures, times since onset, slip energies.
const HIDDEN: usize = 3 * MAX_WHEELSETS;
/// Heat capacity and cooling time of the temperature covariate.
const HEAT_CAPACITY_J_PER_K: f64 = 6e4;
const COOLING_TIME_S: f64 = 120.0;
/// Pressing force above which a brake counts as applied, N.
const APPLIED_N: f64 = 3e3;

fn advance(at: &Operating, dt_s: f64, hidden: &mut [f64]) {
    let (heat, rest) = hidden.split_at_mut(MAX_WHEELSETS);
    let (onset, slip) = rest.split_at_mut(MAX_WHEELSETS);
    for i in 0..MAX_WHEELSETS {
        heat[i] += dt_s * (at.brake_power_w[i] / HEAT_CAPACITY_J_PER_K - heat[i] / COOLING_TIME_S);
        onset[i] = if at.pressing_force_n[i] > APPLIED_N { onset[i] + dt_s } else { 0.0 };
        slip[i] += dt_s * at.slip_power_w[i];
    }
}

fn value(covariate: Covariate, at: &Operating, hidden: &[f64], wheelset: usize) -> f64 {
    match covariate {
        Covariate::Speed => at.v_m_s,
        Covariate::Position => at.position_m,
        Covariate::Time => at.time_s,
        Covariate::BrakeForce => at.pressing_force_n.iter().sum(),
        Covariate::Temperature => hidden[wheelset],
        Covariate::TimeInBraking => hidden[MAX_WHEELSETS + wheelset],
        Covariate::SlipPower => at.slip_power_w[wheelset],
        Covariate::SlipEnergy => hidden[2 * MAX_WHEELSETS + wheelset],
        Covariate::WheelAngle => at.wheel_angle_rad[wheelset].rem_euclid(std::f64::consts::TAU),
        Covariate::DriveTorque => at.drive_torque_nm[wheelset],
    }
}

/// A piecewise linear curve at a place of the equations.
#[derive(Debug)]
struct Curve {
    place: Place,
    covariate: Covariate,
    spec: &'static EffectSpec,
    knots: Arc<[f64]>,
    values: Vec<f64>,
}

impl Curve {
    fn at(&self, at: &Operating, hidden: &[f64], wheelset: usize) -> f64 {
        let x = value(self.covariate, at, hidden, wheelset);
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
            Covariate::BrakeForce | Covariate::SlipPower | Covariate::SlipEnergy if x < self.knots[0] => {
                shape * (x / self.knots[0]).clamp(0.0, 1.0)
            }
            Covariate::TimeInBraking if x <= 0.0 => 0.0,
            _ => shape,
        }
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

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        advance(at, dt_s, hidden);
    }

    fn brake_friction(&self, wheelset: usize, at: &Operating, hidden: &[f64], friction: f64) -> f64 {
        if self.place != Place::PadFriction {
            return friction;
        }
        friction * (1.0 + self.at(at, hidden, wheelset)).max(0.0)
    }

    fn adhesion_peak(&self, wheelset: usize, at: &Operating, hidden: &[f64], peak: f64) -> f64 {
        if self.place == Place::Adhesion {
            peak * (1.0 + self.at(at, hidden, wheelset)).max(0.05)
        } else {
            peak
        }
    }

    fn body_force_n(&self, at: &Operating, hidden: &[f64], force_n: f64) -> f64 {
        if self.place == Place::BodyForce { force_n + self.at(at, hidden, 0) } else { force_n }
    }

    fn drive_torque_nm(&self, wheelset: usize, at: &Operating, hidden: &[f64], torque_nm: f64) -> f64 {
        if self.place == Place::DriveTorque {
            torque_nm * (1.0 + self.at(at, hidden, wheelset))
        } else {
            torque_nm
        }
    }

    fn observe(&self, at: &Operating, hidden: &[f64], reading: &mut Observation) {
        match self.place {
            Place::WheelSensor => {
                for i in 0..WHEELSETS {
                    reading.wheel_speed_rad_s[i] += self.at(at, hidden, i);
                }
            }
            Place::SpeedSensor => reading.v_m_s += self.at(at, hidden, 0),
            _ => {}
        }
    }
}
