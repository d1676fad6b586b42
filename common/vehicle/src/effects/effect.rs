//! What an effect is: its entry in the catalogue, where it is asked, and the laws that it may change.

use crate::PerWheelset;
use crate::wagon::Constants;

/// A place in the equations at which a model can be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Term {
    /// Coefficient between pad and disc.
    BrakeFriction,
    /// From measured pressure to the force on the pad.
    BrakeActuation,
    /// Adhesion available and its shape over slip.
    Adhesion,
    /// Normal loads of the wheelsets.
    LoadDistribution,
    /// Mass and moments of inertia.
    Inertia,
    /// Wheel radii.
    Kinematics,
    /// Running resistance, wind and grade.
    Resistance,
    /// Other forces along the track.
    LongitudinalForce,
    /// Measurement of wheelset speeds.
    SensorWheelSpeed,
    /// Measurement of vehicle speed.
    SensorSpeed,
    /// Elasticity between brake or motor and wheel.
    Drivetrain,
}

impl Term {
    /// All terms.
    pub const ALL: [Self; 11] = [
        Self::BrakeFriction,
        Self::BrakeActuation,
        Self::Adhesion,
        Self::LoadDistribution,
        Self::Inertia,
        Self::Kinematics,
        Self::Resistance,
        Self::LongitudinalForce,
        Self::SensorWheelSpeed,
        Self::SensorSpeed,
        Self::Drivetrain,
    ];

    /// The term's stable name.
    pub fn name(self) -> &'static str {
        match self {
            Self::BrakeFriction => "brake_friction",
            Self::BrakeActuation => "brake_actuation",
            Self::Adhesion => "adhesion",
            Self::LoadDistribution => "load_distribution",
            Self::Inertia => "inertia",
            Self::Kinematics => "kinematics",
            Self::Resistance => "resistance",
            Self::LongitudinalForce => "longitudinal_force",
            Self::SensorWheelSpeed => "sensor_wheel_speed",
            Self::SensorSpeed => "sensor_speed",
            Self::Drivetrain => "drivetrain",
        }
    }
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterSpec {
    /// Name with its unit.
    pub name: &'static str,
    /// Unit for people.
    pub unit: &'static str,
    /// Smallest allowed value.
    pub lower: f64,
    /// Largest allowed value.
    pub upper: f64,
    /// Value where nothing else is known, and the start of a fit.
    pub default: f64,
    /// Value at which the parameter does nothing, if the effect vanishes there.
    pub neutral: Option<f64>,
    /// One-sigma width of the prior around `default`; infinite where nothing is known.
    pub prior_sigma: f64,
    /// Further values from which a fit starts; for a discrete parameter all the values that it can have.
    pub starts: &'static [f64],
    /// Whether only the values of `starts` make sense (the number of a wheelset, say).
    pub discrete: bool,
    /// Size of a change that matters, where the distance between default and neutral value does not tell.
    pub scale: Option<f64>,
}

impl ParameterSpec {
    /// A parameter without prior, hidden neutral value or further starts, for use with struct update syntax.
    pub const PLAIN: Self = Self {
        name: "",
        unit: "1",
        lower: 0.0,
        upper: 1.0,
        default: 0.0,
        neutral: None,
        prior_sigma: f64::INFINITY,
        starts: &[],
        discrete: false,
        scale: None,
    };
}

/// How much alike two effects are in recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Likeness {
    /// They look alike in some runs; others separate them.
    LookAlike,
    /// They span the same model over the range of a train, so that either name is right.
    SameModel,
}

/// Another effect that recordings may not tell from this one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Twin {
    /// Its id.
    pub id: &'static str,
    /// How much alike the two are.
    pub likeness: Likeness,
}

impl Twin {
    /// An effect that looks alike in some runs.
    pub const fn look_alike(id: &'static str) -> Self {
        Self { id, likeness: Likeness::LookAlike }
    }

    /// An effect that spans the same model.
    pub const fn same_model(id: &'static str) -> Self {
        Self { id, likeness: Likeness::SameModel }
    }
}

/// What the catalogue says about an effect.
#[derive(Debug, PartialEq)]
pub struct EffectSpec {
    /// Stable id.
    pub id: &'static str,
    /// The place in the equations.
    pub term: Term,
    /// The law in one line.
    pub equation: &'static str,
    /// Where the law and its range come from.
    pub source: &'static str,
    /// Parameters in the order in which the constructor takes them.
    pub parameters: &'static [ParameterSpec],
    /// Names of hidden states, with units.
    pub hidden: &'static [&'static str],
    /// Ids that look alike, and what separates them is in `separated_by`.
    pub twins: &'static [Twin],
    /// The run that tells the effect from its twins, in words.
    pub separated_by: &'static str,
}

/// The operating point at which a law is asked: what was measured or simulated at this sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Operating {
    /// Number of wheelsets; 0 where nobody said.
    pub wheelsets: usize,
    /// Time since the start of the run, s.
    pub time_s: f64,
    /// Vehicle speed, m/s.
    pub v_m_s: f64,
    /// Acceleration of the vehicle as last known, m/s².
    pub acceleration_m_s2: f64,
    /// Position along the track, m.
    pub position_m: f64,
    /// Number of the recording, from one, for what differs from one to the next; 0 where nobody said.
    pub recording: usize,
    /// How far each wheelset is ahead of that position, m.
    pub wheelset_position_m: PerWheelset,
    /// Sanding demand, 0 to 1.
    pub sanding: f64,
    /// Grade of the track, rad, uphill positive.
    pub grade_rad: f64,
    /// Adhesion available under each wheelset as the input gives it, before any effect.
    pub adhesion_peak: PerWheelset,
    /// Angular speed of each wheelset, rad/s.
    pub wheel_speed_rad_s: PerWheelset,
    /// Pressing force of each wheelset as inferred from cylinder pressure, N.
    pub pressing_force_n: PerWheelset,
    /// Drive torque on each wheelset, N m.
    pub drive_torque_nm: PerWheelset,
    /// Heat into each wheelset's brake as last known, W, never negative.
    pub brake_power_w: PerWheelset,
    /// Power dissipated by slip in each contact as last known, W, never negative.
    pub slip_power_w: PerWheelset,
    /// Angular acceleration of each wheelset as last known, rad/s².
    pub wheel_acceleration_rad_s2: PerWheelset,
    /// Angle of each wheelset since the start of the run, rad: the integral of its recorded speed.
    pub wheel_angle_rad: PerWheelset,
}

/// What sensors read: vehicle speed and wheelset speeds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Vehicle speed, m/s.
    pub v_m_s: f64,
    /// Angular speed of each wheelset, rad/s.
    pub wheel_speed_rad_s: PerWheelset,
}

/// How late what the sensors read is: a reading at time t shows the speed at t minus this, s; negative where it is early.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lateness {
    /// Of vehicle speed, s.
    pub v_s: f64,
    /// Of wheelset speeds, s.
    pub wheel_speed_s: f64,
    /// Length of the stretch of time over which wheelset speeds are means, s.
    pub wheel_speed_mean_s: f64,
}

impl std::ops::Add for Lateness {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            v_s: self.v_s + other.v_s,
            wheel_speed_s: self.wheel_speed_s + other.wheel_speed_s,
            wheel_speed_mean_s: self.wheel_speed_mean_s + other.wheel_speed_mean_s,
        }
    }
}

/// A modifier of laws. Every method but [`Effect::spec`] leaves its law as it is unless the effect overrides it.
pub trait Effect: Send + Sync + std::fmt::Debug {
    /// The effect's entry in the catalogue.
    fn spec(&self) -> &'static EffectSpec;

    /// Number of hidden states at this sample period.
    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        0
    }

    /// Sets the hidden states at the start of a run.
    fn start(&self, _at: &Operating, _hidden: &mut [f64]) {}

    /// Advances the hidden states over `dt_s`, with the operating point at its start.
    fn advance(&self, _at: &Operating, _dt_s: f64, _hidden: &mut [f64]) {}

    /// Largest value of one of its parameters on a wagon, where that is less than the spec's bound.
    fn largest(&self, _parameter: &str, _constants: &Constants) -> Option<f64> {
        None
    }

    /// Told which wagon it joins, before any effect has changed that: what an effect may be can depend on it.
    fn join(&mut self, _constants: &Constants) {}

    /// Changes constants of the model, once, when the model is built.
    fn constants(&self, _constants: &mut Constants) {}

    /// Force that arrives at the pad of `wheelset`, N.
    fn pad_force_n(&self, _wheelset: usize, _at: &Operating, _hidden: &[f64], force_n: f64) -> f64 {
        force_n
    }

    /// Pad friction of `wheelset`.
    fn brake_friction(&self, _wheelset: usize, _at: &Operating, _hidden: &[f64], friction: f64) -> f64 {
        friction
    }

    /// Torque with which `wheelset` is held back, N m, never negative.
    fn brake_torque_nm(&self, _wheelset: usize, _at: &Operating, _hidden: &[f64], torque_nm: f64) -> f64 {
        torque_nm
    }

    /// Drive torque on `wheelset`, N m.
    fn drive_torque_nm(&self, _wheelset: usize, _at: &Operating, _hidden: &[f64], torque_nm: f64) -> f64 {
        torque_nm
    }

    /// Adhesion available under `wheelset`.
    fn adhesion_peak(&self, _wheelset: usize, _at: &Operating, _hidden: &[f64], peak: f64) -> f64 {
        peak
    }

    /// Headwind that the body sees, m/s.
    fn headwind_m_s(&self, _at: &Operating, _hidden: &[f64], wind_m_s: f64) -> f64 {
        wind_m_s
    }

    /// Force on the body beyond contact, resistance and grade, N, forward positive.
    fn body_force_n(&self, _at: &Operating, _hidden: &[f64], force_n: f64) -> f64 {
        force_n
    }

    /// What the sensors read.
    fn observe(&self, _at: &Operating, _hidden: &[f64], _reading: &mut Observation) {}

    /// How late the readings are on the whole, `time_s` after the start of the run: a delay as it is, a mean over the past as
    /// the mean age of what it holds. Zero unless the effect is one of time.
    fn lateness(&self, _time_s: f64) -> Lateness {
        Lateness::default()
    }

    /// Turns what the sensors read, at the start of a simulation, into the state of the vehicle.
    fn correct(&self, _at: &Operating, _hidden: &[f64], _state: &mut Observation) {}
}
