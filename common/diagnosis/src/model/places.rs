//! Places of the equations: where an effect of each term shows.

use crate::model::discrepancy::Place;
use railgrip_vehicle::effects::Term;

/// The places at which an effect of a term shows when they are freed one at a time.
pub fn of(term: Term) -> &'static [Place] {
    match term {
        Term::BrakeFriction | Term::BrakeActuation => &[Place::WheelTorque, Place::PadFriction],
        Term::Adhesion => &[Place::Adhesion],
        Term::LoadDistribution => &[Place::Adhesion, Place::WheelTorque, Place::PadFriction],
        Term::Inertia => &[Place::BodyForce, Place::WheelTorque, Place::PadFriction, Place::DriveTorque],
        Term::Resistance | Term::LongitudinalForce => &[Place::BodyForce],
        Term::Kinematics | Term::SensorWheelSpeed => &[Place::WheelSensor, Place::WheelScale],
        Term::SensorSpeed => &[Place::SpeedSensor],
        Term::Drivetrain => &[Place::WheelTorque, Place::PadFriction, Place::DriveTorque, Place::WheelSensor],
    }
}

/// Whether effects of two terms may show at the same place.
pub fn may_share(a: Term, b: Term) -> bool {
    of(a).iter().any(|place| of(b).contains(place))
}
