//! The fast integrator: one sample of a wagon with two wheelsets in a fifth of a microsecond, with its effects and their
//! hidden states, for whoever simulates the same runs thousands of times.
//!
//! The laws are those of [`WagonModel`]; only the integrator differs from [`WagonModel::step`]: a linearly implicit
//! L-stable two-stage method (ROS2 of Verwer, Spee, Blom & Hundsdorfer, SIAM J. Sci. Comput. 20 (1999), γ = 1 − 1/√2)
//! that needs four evaluations of the contact law and no iteration. It keeps order two with an approximate
//! Jacobian, which here leaves out what acceleration does to the loads.

use crate::adhesion::{ContactForce, creep_force_pair};
use crate::effects::{Observation, Operating};
use crate::resistance::running_resistance;
use crate::{Loading, MAX_WHEELSETS, PerWheelset, WagonInput, WagonModel};

/// Wheelsets of a wagon that the fast integrator can drive.
pub const WHEELSETS: usize = 2;
/// Speeds that it integrates, and outputs that it reads: the vehicle's, then each wheelset's.
pub const SPEEDS: usize = 1 + WHEELSETS;

/// Diagonal coefficient of the method.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// Embedded error of a wheelset's speed above which a sample is integrated in several steps, rad/s.
const TOLERANCE_RAD_S: f64 = 1e-3;
/// Steps of such a sample.
const SUBSTEPS: usize = 4;

/// What acts on a wagon over one sample: measured or known, never simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampleInput {
    /// Time since the start of the run, s.
    pub time_s: f64,
    /// Pressing forces at this sample, N.
    pub pressing_force_n: [f64; WHEELSETS],
    /// Mean pressing forces between this sample and the next, N.
    pub mid_pressing_force_n: [f64; WHEELSETS],
    /// Mean drive torques between this sample and the next, N m, forward positive.
    pub mid_drive_torque_nm: [f64; WHEELSETS],
    /// Grade, rad, uphill positive.
    pub grade_rad: f64,
    /// Sanding demand, 0 to 1.
    pub sanding: f64,
    /// Position along the track, m.
    pub position_m: f64,
    /// Angle of each wheelset since the start of the run, rad: the integral of its recorded speed.
    pub wheel_angle_rad: [f64; WHEELSETS],
}

/// Where a simulation stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Vehicle speed, m/s, and wheelset speeds, rad/s.
    pub state: [f64; SPEEDS],
    /// Acceleration of the body over the last step, m/s².
    pub acceleration_m_s2: f64,
    /// Angular acceleration of the wheelsets over the last step, rad/s².
    pub wheel_acceleration_rad_s2: [f64; WHEELSETS],
}

/// Disturbances of the laws, which a filter may carry as states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Relative change of each pad's friction.
    pub pad: [f64; WHEELSETS],
    /// Additional headwind, m/s.
    pub wind_m_s: f64,
}

/// A wagon model bound to the adhesion of a run's rail and to a sample period.
#[derive(Debug)]
pub struct FastWagon<'a> {
    model: &'a WagonModel,
    adhesion: f64,
    dt_s: f64,
    bare: bool,
    per_mass: f64,
    per_inertia: [f64; WHEELSETS],
}

impl<'a> FastWagon<'a> {
    /// `adhesion` is μ0 of the rail class, `dt_s` the sample period.
    pub fn new(model: &'a WagonModel, adhesion: f64, dt_s: f64) -> Self {
        let constants = model.constants();
        Self {
            model,
            adhesion,
            dt_s,
            bare: model.effects().is_empty(),
            per_mass: 1.0 / constants.mass_kg,
            per_inertia: std::array::from_fn(|i| 1.0 / constants.inertia_kg_m2[i]),
        }
    }

    /// The operating point of a simulated motion at a sample.
    fn operating(&self, motion: &Motion, input: &SampleInput) -> Operating {
        let mut at = Operating {
            time_s: input.time_s,
            v_m_s: motion.state[0],
            acceleration_m_s2: motion.acceleration_m_s2,
            position_m: input.position_m,
            wheelset_position_m: self.model.constants().wheelset_positions_m,
            sanding: input.sanding,
            grade_rad: input.grade_rad,
            adhesion_peak: [self.adhesion; MAX_WHEELSETS],
            ..Operating::default()
        };
        for i in 0..WHEELSETS {
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
        for i in 0..WHEELSETS {
            input.pressing_force_n[i] = sample.mid_pressing_force_n[i];
            input.drive_torque_nm[i] = sample.mid_drive_torque_nm[i];
            input.brake_friction_factor[i] = 1.0 + disturbance.pad[i];
        }
        self.model.loading(at, &input, self.dt_s, hidden)
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
        for i in 0..WHEELSETS {
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
        let contacts = self.integrate(motion, &loading);
        if hidden.is_empty() {
            return;
        }
        let constants = self.model.constants();
        for (i, contact) in contacts.iter().enumerate() {
            let omega = at.wheel_speed_rad_s[i];
            at.brake_power_w[i] = (loading.brake_torque_nm[i] * omega).max(0.0);
            at.slip_power_w[i] =
                (contact.force_n * (constants.wheel_radius_m[i] * omega - at.v_m_s)).max(0.0);
        }
        at.acceleration_m_s2 = motion.acceleration_m_s2;
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

    fn contacts(
        &self,
        state: &[f64; SPEEDS],
        loads: &PerWheelset,
        loading: &Loading,
    ) -> [ContactForce; WHEELSETS] {
        let constants = self.model.constants();
        let rims = [constants.wheel_radius_m[0] * state[1], constants.wheel_radius_m[1] * state[2]];
        let first_two = |values: &PerWheelset| [values[0], values[1]];
        creep_force_pair(
            &constants.contact,
            rims,
            state[0],
            first_two(loads),
            first_two(&loading.adhesion_peak),
        )
    }

    /// One sample, in one step or, where a wheelset breaks away or catches, in several; returns the contact forces
    /// at the start.
    fn integrate(&self, motion: &mut Motion, loading: &Loading) -> [ContactForce; WHEELSETS] {
        let start = motion.state;
        let loads = self.model.load_distribution().loads_n(motion.acceleration_m_s2);
        let (end, contacts, error) = self.two_stages(&start, &loads, loading, self.dt_s);
        motion.state = end;
        if error > TOLERANCE_RAD_S {
            motion.state = start;
            let substep = self.dt_s / SUBSTEPS as f64;
            for _ in 0..SUBSTEPS {
                motion.state = self.two_stages(&motion.state, &loads, loading, substep).0;
            }
        }
        motion.acceleration_m_s2 = (motion.state[0] - start[0]) / self.dt_s;
        for i in 0..WHEELSETS {
            motion.wheel_acceleration_rad_s2[i] = (motion.state[1 + i] - start[1 + i]) / self.dt_s;
        }
        contacts
    }

    /// Two stages of ROS2 over `h`: the new state, the contact forces at the start, and the difference of the wheelset
    /// speeds to the embedded method of order one.
    fn two_stages(
        &self,
        start: &[f64; SPEEDS],
        loads: &PerWheelset,
        loading: &Loading,
        h: f64,
    ) -> ([f64; SPEEDS], [ContactForce; WHEELSETS], f64) {
        let first = self.contacts(start, loads, loading);
        let solver = self.solver(start, &first, loading, GAMMA * h);
        let k1 = solver.solve(self.rates(start, &first, loading, &solver));
        let inner: [f64; SPEEDS] = std::array::from_fn(|j| start[j] + h * k1[j]);
        let second = self.contacts(&inner, loads, loading);
        let rate = self.rates(&inner, &second, loading, &solver);
        let k2 = solver.solve(std::array::from_fn(|j| rate[j] - 2.0 * k1[j]));
        let mut end: [f64; SPEEDS] = std::array::from_fn(|j| start[j] + h * (1.5 * k1[j] + 0.5 * k2[j]));
        let error = (1..SPEEDS).map(|j| (0.5 * h * (k1[j] + k2[j])).abs()).fold(0.0, f64::max);
        // A brake stops a wheelset and never turns it backwards.
        for i in 1..SPEEDS {
            if end[i] < 0.0 && start[i] >= 0.0 && loading.brake_torque_nm[i - 1] > 0.0 {
                end[i] = 0.0;
            }
        }
        (end, first, error)
    }

    fn rates(
        &self,
        state: &[f64; SPEEDS],
        contacts: &[ContactForce; WHEELSETS],
        loading: &Loading,
        solver: &Solver,
    ) -> [f64; SPEEDS] {
        let constants = self.model.constants();
        let mut force =
            loading.other_n - running_resistance(&constants.resistance, state[0], loading.wind_m_s);
        let mut rates = [0.0; SPEEDS];
        for i in 0..WHEELSETS {
            force += contacts[i].force_n;
            let free = loading.drive_torque_nm[i] - constants.wheel_radius_m[i] * contacts[i].force_n;
            let torque = free - loading.brake_torque_nm[i] * state[1 + i].signum();
            rates[1 + i] = if solver.locked[i] { 0.0 } else { torque * self.per_inertia[i] };
        }
        rates[0] = force * self.per_mass;
        rates
    }

    fn solver(
        &self,
        state: &[f64; SPEEDS],
        contacts: &[ContactForce; WHEELSETS],
        loading: &Loading,
        step: f64,
    ) -> Solver {
        let constants = self.model.constants();
        let resistance = &constants.resistance;
        let drag = resistance.linear_n_s_per_m
            + 2.0 * resistance.drag_n_s2_per_m2 * (state[0] + loading.wind_m_s).abs();
        let mut solver = Solver::default();
        let mut body = drag;
        for i in 0..WHEELSETS {
            let (radius, per_inertia) = (constants.wheel_radius_m[i], self.per_inertia[i]);
            let slope = contacts[i].slope_n_s_per_m;
            let held = (loading.drive_torque_nm[i] - radius * contacts[i].force_n).abs()
                <= loading.brake_torque_nm[i];
            solver.locked[i] = state[1 + i] <= 0.0 && held;
            body += slope;
            if !solver.locked[i] {
                solver.wheel[i] = 1.0 / (1.0 + step * radius * radius * slope * per_inertia);
                solver.wheel_by_body[i] = step * radius * slope * per_inertia;
                solver.body_by_wheel[i] = step * radius * slope * self.per_mass;
            }
        }
        let mut pivot = 1.0 + step * body * self.per_mass;
        for i in 0..WHEELSETS {
            pivot -= solver.body_by_wheel[i] * solver.wheel[i] * solver.wheel_by_body[i];
        }
        solver.body = 1.0 / pivot;
        solver
    }
}

/// Factors of `I − γ h ∂f/∂u`, an arrow with the body as its head.
#[derive(Default)]
struct Solver {
    body: f64,
    wheel: [f64; WHEELSETS],
    wheel_by_body: [f64; WHEELSETS],
    body_by_wheel: [f64; WHEELSETS],
    locked: [bool; WHEELSETS],
}

impl Solver {
    fn solve(&self, right: [f64; SPEEDS]) -> [f64; SPEEDS] {
        let mut body = right[0];
        for i in 0..WHEELSETS {
            body += self.body_by_wheel[i] * self.wheel[i] * right[1 + i];
        }
        body *= self.body;
        let mut x = [body; SPEEDS];
        for i in 0..WHEELSETS {
            x[1 + i] = if self.locked[i] {
                0.0
            } else {
                self.wheel[i] * (right[1 + i] + self.wheel_by_body[i] * body)
            };
        }
        x
    }
}

fn observation(speeds: &[f64; SPEEDS]) -> Observation {
    let mut reading = Observation { v_m_s: speeds[0], ..Observation::default() };
    reading.wheel_speed_rad_s[..WHEELSETS].copy_from_slice(&speeds[1..]);
    reading
}

fn speeds_of(reading: &Observation) -> [f64; SPEEDS] {
    [reading.v_m_s, reading.wheel_speed_rad_s[0], reading.wheel_speed_rad_s[1]]
}
