//! The fast integrator: one sample of a wagon with its effects and their hidden states, of two wheelsets in a fifth of a
//! microsecond, for whoever simulates the same runs thousands of times.
//!
//! The laws are those of [`WagonModel`]; only the integrator differs from [`WagonModel::step`], see [`SampleStep`]: it
//! evaluates the contact law once or twice a sample where wheelsets roll or slide on.

pub use super::quantities::SPEEDS;
use super::{SampleStep, Slopes};
use crate::effects::{Observation, Operating};
use crate::resistance::running_resistance;
use crate::{Constants, Loading, MAX_WHEELSETS, PerWheelset, WagonInput, WagonModel, WagonState};

/// Change of headwind over which resistance is differenced, m/s.
const WIND_CHANGE_M_S: f64 = 0.1;

/// What acts on a wagon over one sample: measured or known, never simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampleInput {
    /// Time since the start of the run, s.
    pub time_s: f64,
    /// Pressing forces at this sample, N.
    pub pressing_force_n: PerWheelset,
    /// Mean pressing forces between this sample and the next, N.
    pub mid_pressing_force_n: PerWheelset,
    /// Mean drive torques between this sample and the next, N m, forward positive.
    pub mid_drive_torque_nm: PerWheelset,
    /// Grade, rad, uphill positive.
    pub grade_rad: f64,
    /// Sanding demand, 0 to 1.
    pub sanding: f64,
    /// Position along the track, m.
    pub position_m: f64,
    /// Number of the recording that this sample belongs to, from one; 0 where it is of none that is told apart.
    pub recording: usize,
    /// Angle of each wheelset since the start of the run, rad: the integral of its recorded speed.
    pub wheel_angle_rad: PerWheelset,
}

/// Where a simulation stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Vehicle speed, m/s, and wheelset speeds, rad/s.
    pub state: [f64; SPEEDS],
    /// Acceleration of the body over the last step, m/s².
    pub acceleration_m_s2: f64,
    /// Angular acceleration of the wheelsets over the last step, rad/s².
    pub wheel_acceleration_rad_s2: PerWheelset,
}

/// Disturbances of the laws, which a filter may carry as states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Relative change of each pad's friction.
    pub pad: PerWheelset,
    /// Additional headwind, m/s.
    pub wind_m_s: f64,
    /// Force of the couplers on the body, along the running direction, N.
    pub coupler_n: f64,
}

/// A wagon model bound to the adhesion of a run's rail and to a sample period.
#[derive(Clone, Debug)]
pub struct FastWagon<'a> {
    model: &'a WagonModel,
    adhesion: f64,
    dt_s: f64,
    bare: bool,
    wheelsets: usize,
    step: Step<'a>,
}

/// The step of a wagon by how many pairs of wheelsets it takes.
#[derive(Clone, Debug)]
enum Step<'a> {
    One(SampleStep<'a, 1>),
    Two(SampleStep<'a, 2>),
}

/// Asks the step of whichever wagon.
macro_rules! by_pairs {
    ($step:expr, $one:ident => $answer:expr) => {
        match $step {
            Step::One($one) => $answer,
            Step::Two($one) => $answer,
        }
    };
}

impl<'a> FastWagon<'a> {
    /// `adhesion` is μ0 of the rail class, `dt_s` the sample period.
    pub fn new(model: &'a WagonModel, adhesion: f64, dt_s: f64) -> Self {
        let constants = model.constants();
        let wheelsets = constants.wheelsets;
        let step = match wheelsets {
            ..=2 => Step::One(SampleStep::new(constants, dt_s)),
            _ => Step::Two(SampleStep::new(constants, dt_s)),
        };
        Self { model, adhesion, dt_s, bare: model.effects().is_empty(), wheelsets, step }
    }

    /// The same wagon in a filter, see [`SampleStep::quick`].
    pub fn quick(mut self) -> Self {
        self.step = match self.step {
            Step::One(step) => Step::One(step.quick()),
            Step::Two(step) => Step::Two(step.quick()),
        };
        self
    }

    /// The same wagon on a rail of this adhesion relative to its own.
    pub fn on_adhesion(&self, factor: f64) -> Self {
        Self { adhesion: factor * self.adhesion, ..self.clone() }
    }

    /// The operating point of a simulated motion at a sample.
    fn operating(&self, motion: &Motion, input: &SampleInput) -> Operating {
        let mut at = Operating {
            wheelsets: self.wheelsets,
            time_s: input.time_s,
            v_m_s: motion.state[0],
            acceleration_m_s2: motion.acceleration_m_s2,
            position_m: input.position_m,
            recording: input.recording,
            wheelset_position_m: self.model.constants().wheelset_positions_m,
            sanding: input.sanding,
            grade_rad: input.grade_rad,
            adhesion_peak: [self.adhesion; MAX_WHEELSETS],
            ..Operating::default()
        };
        for i in 0..self.wheelsets {
            at.wheel_speed_rad_s[i] = motion.state[1 + i];
            at.wheel_acceleration_rad_s2[i] = motion.wheel_acceleration_rad_s2[i];
            at.pressing_force_n[i] = input.pressing_force_n[i];
            at.drive_torque_nm[i] = input.mid_drive_torque_nm[i];
            at.wheel_angle_rad[i] = input.wheel_angle_rad[i];
        }
        at
    }

    fn loading(
        &self,
        at: &Operating,
        sample: &SampleInput,
        disturbance: &Disturbance,
        hidden: &[f64],
    ) -> Loading {
        let mut input = WagonInput {
            time_s: sample.time_s,
            grade_rad: sample.grade_rad,
            sanding: sample.sanding,
            position_m: sample.position_m,
            adhesion_peak: at.adhesion_peak,
            wind_m_s: disturbance.wind_m_s,
            ..WagonInput::default()
        };
        for i in 0..self.wheelsets {
            input.pressing_force_n[i] = sample.mid_pressing_force_n[i];
            input.drive_torque_nm[i] = sample.mid_drive_torque_nm[i];
            input.brake_friction_factor[i] = 1.0 + disturbance.pad[i];
        }
        let mut loading = self.model.loading(at, &input, self.dt_s, hidden);
        loading.other_n += disturbance.coupler_n;
        loading
    }

    /// Hidden states at the start of a run whose outputs read `measured` at its first sample.
    pub fn start_hidden(&self, measured: &[f64; SPEEDS], input: &SampleInput) -> Vec<f64> {
        let motion = Motion { state: *measured, ..Motion::default() };
        self.model.start_hidden(&self.operating(&motion, input), self.dt_s)
    }

    /// Advances hidden states over one sample by the motion that was measured, without simulating.
    pub fn follow(&self, measured: &Motion, input: &SampleInput, hidden: &mut [f64]) {
        if hidden.is_empty() {
            return;
        }
        let mut at = self.operating(measured, input);
        let loading = self.loading(&at, input, &Disturbance::default(), hidden);
        let constants = self.model.constants();
        let loads = self.model.load_distribution().loads_n(measured.acceleration_m_s2);
        let speed = measured.state[0];
        let mut force = loading.other_n - running_resistance(&constants.resistance, speed, loading.wind_m_s);
        for i in 0..self.wheelsets {
            let (omega, radius) = (measured.state[1 + i], constants.wheel_radius_m[i]);
            at.brake_power_w[i] = (loading.brake_torque_nm[i] * omega).max(0.0);
            // Contact force from the wheelset's own balance: the creep of a rolling wheel drowns in noise.
            let torque = loading.drive_torque_nm[i]
                - loading.brake_torque_nm[i]
                - constants.inertia_kg_m2[i] * measured.wheel_acceleration_rad_s2[i];
            let limit = loads[i] * loading.adhesion_peak[i];
            let contact = (torque / radius).clamp(-limit, limit);
            let slip = radius * omega - speed;
            at.slip_power_w[i] = if slip.abs() > 0.1 { (contact * slip).max(0.0) } else { 0.0 };
            force += contact;
        }
        // From forces, not from measured speed, whose sensor may be what is wrong.
        at.acceleration_m_s2 = force / constants.mass_kg;
        self.model.advance_hidden(&at, self.dt_s, hidden);
    }

    /// The motion behind `measured`, which the sensors read, at the start of a simulation.
    pub fn start_motion(&self, measured: &Motion, input: &SampleInput, hidden: &[f64]) -> Motion {
        let mut motion = *measured;
        if !self.bare {
            let at = self.operating(&motion, input);
            let mut reading = observation(&measured.state);
            self.model.correct(&at, self.dt_s, hidden, &mut reading);
            motion.state = speeds_of(&reading);
        }
        motion
    }

    /// What the laws of actuation, pad friction, rail and body forces give at a sample.
    pub fn loading_at(
        &self,
        motion: &Motion,
        input: &SampleInput,
        disturbance: &Disturbance,
        hidden: &[f64],
    ) -> Loading {
        self.loading(&self.operating(motion, input), input, disturbance, hidden)
    }

    /// Derivatives of the speeds after a sample under this loading, with room for `W` wheelsets.
    pub fn slopes<const W: usize, const S: usize>(&self, motion: &Motion, loading: &Loading) -> Slopes<W, S> {
        let start = motion.wagon();
        let load_n = self.model.load_distribution().loads_n(motion.acceleration_m_s2);
        by_pairs!(&self.step, step => step.slopes(&start, &load_n, loading, motion.acceleration_m_s2))
    }

    /// Speeds after a sample under this loading by the linear part of the step, see [`SampleStep::coarse`].
    pub fn coarse(&self, motion: &Motion, loading: &Loading) -> [f64; SPEEDS] {
        let start = motion.wagon();
        let load_n = self.model.load_distribution().loads_n(motion.acceleration_m_s2);
        let end =
            by_pairs!(&self.step, step => step.coarse(&start, &load_n, loading, motion.acceleration_m_s2));
        speeds(end.v_m_s, &end.wheel_speed_rad_s)
    }

    /// Constants of the model, after its effects.
    pub fn constants(&self) -> &Constants {
        self.model.constants()
    }

    /// Running resistance under this loading, N.
    pub fn resistance(&self, motion: &Motion, loading: &Loading) -> f64 {
        running_resistance(&self.model.constants().resistance, motion.state[0], loading.wind_m_s)
    }

    /// Derivative of the running resistance over headwind, N/(m/s).
    pub fn resistance_by_wind(&self, motion: &Motion, loading: &Loading) -> f64 {
        let resistance = &self.model.constants().resistance;
        let at = |wind_m_s: f64| running_resistance(resistance, motion.state[0], wind_m_s);
        (at(loading.wind_m_s + WIND_CHANGE_M_S) - at(loading.wind_m_s - WIND_CHANGE_M_S))
            / (2.0 * WIND_CHANGE_M_S)
    }

    /// Advances motion and hidden states from this sample to the next one.
    pub fn step(
        &self,
        motion: &mut Motion,
        input: &SampleInput,
        disturbance: &Disturbance,
        hidden: &mut [f64],
    ) {
        let mut at = self.operating(motion, input);
        let loading = self.loading(&at, input, disturbance, hidden);
        let contact_n = self.integrate(motion, &loading);
        if hidden.is_empty() {
            return;
        }
        let constants = self.model.constants();
        for i in 0..self.wheelsets {
            let omega = at.wheel_speed_rad_s[i];
            at.brake_power_w[i] = (loading.brake_torque_nm[i] * omega).max(0.0);
            at.slip_power_w[i] = (contact_n[i] * (constants.wheel_radius_m[i] * omega - at.v_m_s)).max(0.0);
        }
        at.acceleration_m_s2 = motion.acceleration_m_s2;
        at.wheel_acceleration_rad_s2 = motion.wheel_acceleration_rad_s2;
        self.model.advance_hidden(&at, self.dt_s, hidden);
    }

    /// What the sensors read at this sample, after the hidden states were advanced to it.
    pub fn read(&self, motion: &Motion, input: &SampleInput, hidden: &[f64]) -> [f64; SPEEDS] {
        if self.bare {
            return motion.state;
        }
        let at = self.operating(motion, input);
        speeds_of(&self.model.observe(&at, self.dt_s, hidden))
    }

    /// One sample; returns the contact forces at its start, N.
    fn integrate(&self, motion: &mut Motion, loading: &Loading) -> PerWheelset {
        let start = motion.wagon();
        let load_n = self.model.load_distribution().loads_n(motion.acceleration_m_s2);
        let (end, contact_n) =
            by_pairs!(&self.step, step => step.advance(&start, &load_n, loading, motion.acceleration_m_s2));
        motion.acceleration_m_s2 = (end.v_m_s - start.v_m_s) / self.dt_s;
        motion.state[0] = end.v_m_s;
        for i in 0..self.wheelsets {
            motion.state[1 + i] = end.wheel_speed_rad_s[i];
            motion.wheel_acceleration_rad_s2[i] =
                (end.wheel_speed_rad_s[i] - start.wheel_speed_rad_s[i]) / self.dt_s;
        }
        contact_n
    }
}

impl Motion {
    /// The speeds as those of a wagon.
    fn wagon(&self) -> WagonState {
        let [v_m_s, wheels @ ..] = self.state;
        WagonState { v_m_s, wheel_speed_rad_s: wheels }
    }
}

fn speeds(v_m_s: f64, wheels: &PerWheelset) -> [f64; SPEEDS] {
    let mut all = [v_m_s; SPEEDS];
    all[1..].copy_from_slice(wheels);
    all
}

fn observation(speeds: &[f64; SPEEDS]) -> Observation {
    let [v_m_s, wheel_speed_rad_s @ ..] = *speeds;
    Observation { v_m_s, wheel_speed_rad_s }
}

fn speeds_of(reading: &Observation) -> [f64; SPEEDS] {
    speeds(reading.v_m_s, &reading.wheel_speed_rad_s)
}
