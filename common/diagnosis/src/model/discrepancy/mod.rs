//! Flexible discrepancies: one place of the equations freed as a smooth function of one covariate.
//!
//! They are what could be explained at all. A named effect that recovers little of what the best of them recovers is not
//! the answer, and where no effect is named they say at which place, over which variable and by how much the model
//! errs. Each is a piecewise linear function over a few knots at quantiles of its covariate, with a weak prior that pulls
//! it towards zero, and is fitted like any candidate.

mod covariate;
mod curve;

pub use covariate::{Covariate, along};
pub use curve::{Place, Scope, interpolate};

use crate::data::case::Case;
use crate::model::candidates::Candidate;
use crate::model::parameters::{FittedEffect, Parameter};
use curve::Curve;
use railgrip_vehicle::effects::{Effect, EffectSpec, Term};
use std::sync::Arc;

/// A place, wheelsets and covariate that are tried, and the term of the equations that they speak for.
type Tried = (Place, Scope, Covariate, Term);

/// All that is tried. What both wheelsets share is in the pads, the rail or the software; what one has alone is a fault
/// of its cylinder, rigging or encoder.
const TRIED: &[Tried] = &[
    (Place::BodyForce, Scope::All, Covariate::Speed, Term::Resistance),
    (Place::BodyForce, Scope::All, Covariate::Position, Term::Resistance),
    (Place::BodyForce, Scope::All, Covariate::Time, Term::Resistance),
    (Place::BodyForce, Scope::All, Covariate::BrakeForce, Term::LongitudinalForce),
    (Place::BodyForce, Scope::All, Covariate::TimeInBraking, Term::LongitudinalForce),
    (Place::BodyForce, Scope::All, Covariate::Acceleration, Term::Inertia),
    (Place::WheelTorque, Scope::All, Covariate::WheelAcceleration, Term::Inertia),
    (Place::WheelTorque, Scope::All, Covariate::ForceChange, Term::BrakeActuation),
    (Place::WheelTorque, Scope::One(0), Covariate::Speed, Term::BrakeActuation),
    (Place::PadFriction, Scope::All, Covariate::Speed, Term::BrakeFriction),
    (Place::PadFriction, Scope::All, Covariate::Temperature, Term::BrakeFriction),
    (Place::PadFriction, Scope::All, Covariate::PressingForce, Term::BrakeFriction),
    (Place::PadFriction, Scope::All, Covariate::WheelAngle, Term::BrakeFriction),
    (Place::PadFriction, Scope::All, Covariate::TimeInBraking, Term::BrakeFriction),
    (Place::PadFriction, Scope::All, Covariate::WetBrakeEnergy, Term::BrakeFriction),
    (Place::PadFriction, Scope::One(0), Covariate::TimeInBraking, Term::BrakeActuation),
    (Place::PadFriction, Scope::One(0), Covariate::PressingForce, Term::BrakeActuation),
    (Place::Adhesion, Scope::All, Covariate::Speed, Term::Adhesion),
    (Place::Adhesion, Scope::All, Covariate::Position, Term::Adhesion),
    (Place::Adhesion, Scope::All, Covariate::Time, Term::Adhesion),
    (Place::Adhesion, Scope::All, Covariate::SlipVelocity, Term::Adhesion),
    (Place::Adhesion, Scope::All, Covariate::SlipEnergy, Term::Adhesion),
    (Place::Adhesion, Scope::Following, Covariate::Speed, Term::Adhesion),
    (Place::LoadShift, Scope::All, Covariate::Acceleration, Term::LoadDistribution),
    (Place::WheelSensor, Scope::All, Covariate::Speed, Term::SensorWheelSpeed),
    (Place::WheelSensor, Scope::All, Covariate::WheelAcceleration, Term::SensorWheelSpeed),
    (Place::WheelSensor, Scope::All, Covariate::Time, Term::SensorWheelSpeed),
    (Place::WheelScale, Scope::One(0), Covariate::Speed, Term::Kinematics),
    (Place::WheelScale, Scope::One(0), Covariate::PressingForce, Term::SensorWheelSpeed),
    (Place::WheelScale, Scope::One(0), Covariate::WheelAngle, Term::SensorWheelSpeed),
    (Place::WheelSensor, Scope::All, Covariate::ForceChange, Term::Drivetrain),
    (Place::SpeedSensor, Scope::All, Covariate::Speed, Term::SensorSpeed),
    (Place::SpeedSensor, Scope::All, Covariate::Position, Term::SensorSpeed),
    (Place::SpeedSensor, Scope::All, Covariate::Acceleration, Term::SensorSpeed),
    (Place::DriveTorque, Scope::All, Covariate::DriveTorque, Term::Drivetrain),
];

/// Knots of a curve.
const KNOTS: usize = 5;

macro_rules! specs {
    ($($name:ident: $term:ident;)*) => {
        $(static $name: EffectSpec = EffectSpec {
            id: "discrepancy",
            term: Term::$term,
            equation: "piecewise linear in one covariate",
            source: "flexible discrepancy, not a law",
            parameters: &[],
            hidden: &[
                "disc temperature rise, K", "time since brake onset, s", "slip energy, J", "lagged pressing force, N",
                "brake energy on wet rail, J",
            ],
            twins: &[],
            separated_by: "",
        };)*
        fn spec_of(term: Term) -> &'static EffectSpec {
            match term { $(Term::$term => &$name,)* }
        }
    };
}
specs! {
    BRAKE_FRICTION: BrakeFriction;
    BRAKE_ACTUATION: BrakeActuation;
    ADHESION: Adhesion;
    LOAD_DISTRIBUTION: LoadDistribution;
    INERTIA: Inertia;
    KINEMATICS: Kinematics;
    RESISTANCE: Resistance;
    LONGITUDINAL_FORCE: LongitudinalForce;
    SENSOR_WHEEL_SPEED: SensorWheelSpeed;
    SENSOR_SPEED: SensorSpeed;
    DRIVETRAIN: Drivetrain;
}

/// A flexible discrepancy that can be tried.
#[derive(Clone, Debug)]
pub struct Discrepancy {
    /// Where.
    pub place: Place,
    /// On which wheelsets.
    pub scope: Scope,
    /// Over what.
    pub covariate: Covariate,
    /// The term it speaks for.
    pub term: Term,
    /// Knots.
    pub knots: Arc<[f64]>,
    /// As a candidate.
    pub candidate: Candidate,
}

impl Discrepancy {
    /// The curve through fitted values, as points.
    pub fn curve(&self, fitted: &[f64]) -> Vec<[f64; 2]> {
        let values = all_values(self.covariate, &self.knots, fitted);
        self.knots.iter().zip(values).map(|(x, y)| [*x, y]).collect()
    }
}

/// Whether the curve's value at a knot is fitted: where nothing happens at zero it is not.
fn is_free(covariate: Covariate, knot: f64) -> bool {
    !(covariate.vanishes_at_zero() && knot == 0.0)
}

/// Values at all knots from those at the free ones.
fn all_values(covariate: Covariate, knots: &[f64], fitted: &[f64]) -> Vec<f64> {
    let mut rest = fitted.iter();
    let value = |x: &f64| if is_free(covariate, *x) { rest.next().copied().unwrap_or(0.0) } else { 0.0 };
    knots.iter().map(value).collect()
}

/// All flexible discrepancies whose covariate varies in the runs to fit on; what may be one wheelset's is tried on each. A force
/// on the body of a coupled wagon is not to be told from its couplers.
pub fn all(case: &Case) -> Vec<Discrepancy> {
    let of_each = |&(place, scope, covariate, term): &Tried| {
        let scopes = match scope {
            Scope::One(_) => (0..case.wheelsets()).map(Scope::One).collect(),
            other => vec![other],
        };
        scopes.into_iter().filter_map(move |scope| discrepancy(case, (place, scope, covariate, term)))
    };
    let told = |(place, ..): &&Tried| !(case.is_coupled() && *place == Place::BodyForce);
    TRIED.iter().filter(told).flat_map(of_each).collect()
}

fn discrepancy(case: &Case, (place, scope, covariate, term): Tried) -> Option<Discrepancy> {
    let knots: Arc<[f64]> = covariate.knots(case, KNOTS)?.into();
    let (scale, bound) = place.scale();
    let parameter = |x: &f64| Parameter {
        name: format!("at {x:.4}"),
        start: 0.0,
        lower: -bound,
        upper: bound,
        scale,
        prior_mean: 0.0,
        prior_sigma: 30.0 * scale,
        run: None,
        shows_in: None,
    };
    let parameters = knots.iter().filter(|x| is_free(covariate, **x)).map(parameter).collect();
    let spec = spec_of(term);
    let shared = Arc::clone(&knots);
    let radius_m = case.vehicle.wheelset.radius_m;
    let builder = move |values: &[f64]| -> Box<dyn Effect> {
        let values = all_values(covariate, &shared, values);
        Box::new(Curve { place, scope, covariate, spec, radius_m, knots: Arc::clone(&shared), values })
    };
    let effect = FittedEffect::custom(spec, parameters, Arc::new(builder));
    Some(Discrepancy {
        place,
        scope,
        covariate,
        term,
        knots,
        candidate: Candidate { spec, starts: vec![effect] },
    })
}
