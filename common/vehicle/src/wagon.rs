//! The wagon: body and wheelsets coupled by contact, with brakes, resistance and effects.
//!
//! Equations (Schwarz & Keck (1)–(6) in one sign convention, their factor ½ on g mended):
//!
//! ```text
//! J ω̇_i = M_W,i − T_B,i sign(ω_i) − r_W,i F_x,i
//! m v̇   = Σ F_x,i − (a + b v) − k_d (v+w)|v+w| − m g sin(grade) + F_other
//! ```
//!
//! The integrator is the L-stable, stiffly accurate SDIRK method of order two (Alexander 1977, γ = 1 − 1/√2). Each
//! stage solves the wheelsets' equations one by one for a given body speed (they are monotone in ω), with Coulomb
//! friction of the brake as a set-valued law, so that lock and release need no event search; an outer Newton
//! iteration finds the body speed. It is stable at 10 ms down to standstill, where the creep force is stiffest.

use crate::adhesion::{ContactForce, creep_force};
use crate::effects::{self, Effect, Observation, Operating};
use crate::load::LoadDistribution;
use crate::resistance::{grade_force, running_resistance};
use crate::{Contact, MAX_WHEELSETS, PerWheelset, Resistance, VehicleParameters};

/// Diagonal coefficient of the SDIRK method.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// Why a model cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// An effect that the catalogue lacks.
    #[error("effect `{id}` is not in the catalogue; `railgrip gap effects` lists what is")]
    UnknownEffect {
        /// The id.
        id: String,
    },
    /// A parameter that the effect does not have.
    #[error("effect `{id}` has no parameter `{name}`")]
    UnknownParameter {
        /// The effect.
        id: &'static str,
        /// The parameter.
        name: String,
    },
    /// A value outside its bounds.
    #[error("effect `{id}`: `{name}` is {value}, allowed is {lower} to {upper}")]
    ParameterOutOfBounds {
        /// The effect.
        id: &'static str,
        /// The parameter.
        name: &'static str,
        /// The value.
        value: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
}

/// Motion of a wagon.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WagonState {
    /// Speed of the body, m/s.
    pub v_m_s: f64,
    /// Angular speed of each wheelset, rad/s.
    pub wheel_speed_rad_s: PerWheelset,
}

/// What acts on a wagon during a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WagonInput {
    /// Time at the start of the step, s.
    pub time_s: f64,
    /// Pressing force of each wheelset's pads as inferred from cylinder pressure, N.
    pub pressing_force_n: PerWheelset,
    /// Drive torque on each wheelset, N m, forward positive.
    pub drive_torque_nm: PerWheelset,
    /// Grade, rad, uphill positive.
    pub grade_rad: f64,
    /// Sanding demand, 0 to 1.
    pub sanding: f64,
    /// Position along the track, m.
    pub position_m: f64,
    /// Adhesion available (μ0) under each wheelset.
    pub adhesion_peak: PerWheelset,
    /// Pad friction of each wheelset relative to the model's.
    pub brake_friction_factor: PerWheelset,
    /// Headwind, m/s.
    pub wind_m_s: f64,
    /// Other force on the body (couplers), N, forward positive.
    pub body_force_n: f64,
}

impl Default for WagonInput {
    fn default() -> Self {
        Self {
            time_s: 0.0,
            pressing_force_n: [0.0; MAX_WHEELSETS],
            drive_torque_nm: [0.0; MAX_WHEELSETS],
            grade_rad: 0.0,
            sanding: 0.0,
            position_m: 0.0,
            adhesion_peak: [0.3; MAX_WHEELSETS],
            brake_friction_factor: [1.0; MAX_WHEELSETS],
            wind_m_s: 0.0,
            body_force_n: 0.0,
        }
    }
}

/// Constants of the equations after all effects had their say.
#[derive(Clone, Debug)]
pub struct Constants {
    /// Number of wheelsets.
    pub wheelsets: usize,
    /// Mass m, kg.
    pub mass_kg: f64,
    /// Height of the centre of mass h that load transfer sees, m.
    pub com_height_m: f64,
    /// Positions of wheelsets ahead of the centre of mass, m.
    pub wheelset_positions_m: PerWheelset,
    /// Load of every wheelset where it does not follow from the mass (on a rig), N.
    pub fixed_load_n: Option<f64>,
    /// Moment of inertia of each wheelset, kg m².
    pub inertia_kg_m2: PerWheelset,
    /// Rolling radius of each wheelset, m.
    pub wheel_radius_m: PerWheelset,
    /// Friction radius r_B, m.
    pub brake_radius_m: f64,
    /// Pad friction level of each wheelset.
    pub brake_friction: PerWheelset,
    /// Running resistance.
    pub resistance: Resistance,
    /// Contact law.
    pub contact: Contact,
}

impl Constants {
    /// The constants of a vehicle file, before effects.
    pub fn of(parameters: &VehicleParameters) -> Self {
        Self {
            wheelsets: parameters.wheelsets(),
            mass_kg: parameters.body.mass_kg,
            com_height_m: parameters.body.com_height_m,
            wheelset_positions_m: parameters.wheelset_positions_m(),
            fixed_load_n: None,
            inertia_kg_m2: [parameters.wheelset.inertia_kg_m2; MAX_WHEELSETS],
            wheel_radius_m: [parameters.wheelset.radius_m; MAX_WHEELSETS],
            brake_radius_m: parameters.brake.radius_m,
            brake_friction: [parameters.brake.friction_coefficient; MAX_WHEELSETS],
            resistance: parameters.resistance.clone(),
            contact: parameters.contact.clone(),
        }
    }
}

/// Forces and torques on a wagon at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forces {
    /// Contact force of each wheelset on the wagon, N.
    pub contact_n: PerWheelset,
    /// Normal load of each wheelset, N.
    pub load_n: PerWheelset,
    /// Torque of each brake as it acts, N m, signed (negative against forward rotation).
    pub brake_torque_nm: PerWheelset,
    /// Running resistance, N, positive against forward motion.
    pub resistance_n: f64,
    /// Grade, couplers and effects, N, forward positive.
    pub other_n: f64,
    /// Acceleration of the body, m/s².
    pub acceleration_m_s2: f64,
    /// Angular acceleration of each wheelset, rad/s².
    pub wheel_acceleration_rad_s2: PerWheelset,
}

impl Forces {
    /// Adhesion utilised by `wheelset`, signed like its contact force.
    pub fn adhesion_utilised(&self, wheelset: usize) -> f64 {
        if self.load_n[wheelset] > 0.0 { self.contact_n[wheelset] / self.load_n[wheelset] } else { 0.0 }
    }

    /// Adhesion utilised by the whole wagon, `Σ F_x / Σ F_z`, signed.
    pub fn wagon_adhesion_utilised(&self) -> f64 {
        self.contact_n.iter().sum::<f64>() / self.load_n.iter().sum::<f64>()
    }
}

/// What the laws of actuation, pad friction and rail give for one step; constant over the step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loading {
    /// Force that arrives at the pads of each wheelset, N.
    pub pad_force_n: PerWheelset,
    /// Pad friction of each wheelset.
    pub brake_friction: PerWheelset,
    /// Torque that each brake can hold, N m, never negative.
    pub brake_torque_nm: PerWheelset,
    /// Drive torque, N m.
    pub drive_torque_nm: PerWheelset,
    /// Adhesion available under each wheelset.
    pub adhesion_peak: PerWheelset,
    /// Grade, couplers and effects, N, forward positive.
    pub other_n: f64,
    /// Headwind, m/s.
    pub wind_m_s: f64,
}

/// A wagon with its laws and effects. `Clone` is cheap and shares the effects.
#[derive(Clone, Debug)]
pub struct WagonModel {
    constants: Constants,
    loads: LoadDistribution,
    effects: std::sync::Arc<[Box<dyn Effect>]>,
}

impl WagonModel {
    /// The model of a vehicle file, with the effects that it names.
    ///
    /// # Errors
    /// An effect that the catalogue does not know, or whose parameters are wrong.
    pub fn new(parameters: &VehicleParameters) -> Result<Self, ModelError> {
        let effects = parameters.effects.iter().map(effects::build).collect::<Result<Vec<_>, _>>()?;
        Ok(Self::with_effects(parameters, effects))
    }

    /// The model of `parameters` (whose own effect entries are ignored) with these effects.
    pub fn with_effects(parameters: &VehicleParameters, effects: Vec<Box<dyn Effect>>) -> Self {
        Self::from_constants(Constants::of(parameters), effects)
    }

    /// The model with these constants, before effects change them.
    pub fn from_constants(mut constants: Constants, effects: Vec<Box<dyn Effect>>) -> Self {
        effects.iter().for_each(|effect| effect.constants(&mut constants));
        let loads = match constants.fixed_load_n {
            Some(load_n) => LoadDistribution::fixed(load_n, constants.wheelsets),
            None => LoadDistribution::new(
                constants.mass_kg,
                constants.com_height_m,
                &constants.wheelset_positions_m,
                constants.wheelsets,
            ),
        };
        Self { constants, loads, effects: effects.into() }
    }

    /// Constants after all effects.
    pub fn constants(&self) -> &Constants {
        &self.constants
    }

    /// How load spreads over the wheelsets.
    pub fn load_distribution(&self) -> &LoadDistribution {
        &self.loads
    }

    /// The effects in the order in which they act.
    pub fn effects(&self) -> &[Box<dyn Effect>] {
        &self.effects
    }

    /// Hidden states of all effects at the start of a run.
    pub fn start_hidden(&self, at: &Operating, sample_period_s: f64) -> Vec<f64> {
        let mut hidden = Vec::new();
        for effect in self.effects.iter() {
            let from = hidden.len();
            hidden.resize(from + effect.hidden_len(sample_period_s), 0.0);
            effect.start(at, &mut hidden[from..]);
        }
        hidden
    }

    /// Advances the hidden states of all effects by one sample.
    pub fn advance_hidden(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        self.each_effect_mut(dt_s, hidden, |effect, own| effect.advance(at, dt_s, own));
    }

    /// What the sensors read at this operating point.
    pub fn observe(&self, at: &Operating, sample_period_s: f64, hidden: &[f64]) -> Observation {
        let mut reading = Observation { v_m_s: at.v_m_s, wheel_speed_rad_s: at.wheel_speed_rad_s };
        let mut from = 0;
        for effect in self.effects.iter() {
            let to = from + effect.hidden_len(sample_period_s);
            effect.observe(at, &hidden[from..to], &mut reading);
            from = to;
        }
        reading
    }

    /// Turns what the sensors read at the start of a simulation into the state of the vehicle, see [`Self::observe`].
    pub fn correct(&self, at: &Operating, sample_period_s: f64, hidden: &[f64], state: &mut Observation) {
        let mut from = 0;
        for effect in self.effects.iter() {
            let to = from + effect.hidden_len(sample_period_s);
            effect.correct(at, &hidden[from..to], state);
            from = to;
        }
    }

    fn each_effect_mut(&self, dt_s: f64, hidden: &mut [f64], mut visit: impl FnMut(&dyn Effect, &mut [f64])) {
        let mut rest = hidden;
        for effect in self.effects.iter() {
            let (own, others) = rest.split_at_mut(effect.hidden_len(dt_s));
            visit(effect.as_ref(), own);
            rest = others;
        }
    }

    /// Passes a value through the same law of every effect.
    fn compose(
        &self,
        dt_s: f64,
        hidden: &[f64],
        value: f64,
        law: impl Fn(&dyn Effect, &[f64], f64) -> f64,
    ) -> f64 {
        let mut from = 0;
        let mut value = value;
        for effect in self.effects.iter() {
            let to = from + effect.hidden_len(dt_s);
            value = law(effect.as_ref(), &hidden[from..to], value);
            from = to;
        }
        value
    }

    /// The operating point of `state` under `input`; powers and acceleration are zero until [`Self::note_forces`].
    pub fn operating(&self, state: &WagonState, input: &WagonInput) -> Operating {
        Operating {
            time_s: input.time_s,
            v_m_s: state.v_m_s,
            position_m: input.position_m,
            sanding: input.sanding,
            grade_rad: input.grade_rad,
            adhesion_peak: input.adhesion_peak,
            wheel_speed_rad_s: state.wheel_speed_rad_s,
            pressing_force_n: input.pressing_force_n,
            drive_torque_nm: input.drive_torque_nm,
            ..Operating::default()
        }
    }

    /// Writes acceleration and dissipated powers of `forces` into the operating point.
    pub fn note_forces(&self, at: &mut Operating, forces: &Forces) {
        at.acceleration_m_s2 = forces.acceleration_m_s2;
        at.wheel_acceleration_rad_s2 = forces.wheel_acceleration_rad_s2;
        for i in 0..self.constants.wheelsets {
            let omega = at.wheel_speed_rad_s[i];
            at.brake_power_w[i] = (-forces.brake_torque_nm[i] * omega).max(0.0);
            at.slip_power_w[i] =
                (forces.contact_n[i] * (self.constants.wheel_radius_m[i] * omega - at.v_m_s)).max(0.0);
        }
    }

    /// Evaluates the laws of actuation, pad friction, rail and body forces at an operating point.
    ///
    /// `sample_period_s` and `hidden` are those of [`Self::start_hidden`].
    pub fn loading(
        &self,
        at: &Operating,
        input: &WagonInput,
        sample_period_s: f64,
        hidden: &[f64],
    ) -> Loading {
        let constants = &self.constants;
        let mut loading = Loading {
            drive_torque_nm: input.drive_torque_nm,
            wind_m_s: input.wind_m_s,
            other_n: grade_force(constants.mass_kg, input.grade_rad) + input.body_force_n,
            ..Loading::default()
        };
        for i in 0..constants.wheelsets {
            let force =
                self.compose(sample_period_s, hidden, input.pressing_force_n[i], |effect, own, value| {
                    effect.pad_force_n(i, at, own, value)
                });
            let level = constants.brake_friction[i] * input.brake_friction_factor[i];
            let friction = self.compose(sample_period_s, hidden, level, |effect, own, value| {
                effect.brake_friction(i, at, own, value)
            });
            let torque = friction * force.max(0.0) * constants.brake_radius_m;
            loading.pad_force_n[i] = force.max(0.0);
            loading.brake_friction[i] = friction;
            loading.brake_torque_nm[i] = self
                .compose(sample_period_s, hidden, torque, |effect, own, value| {
                    effect.brake_torque_nm(i, at, own, value)
                })
                .max(0.0);
            loading.adhesion_peak[i] =
                self.compose(sample_period_s, hidden, input.adhesion_peak[i], |effect, own, value| {
                    effect.adhesion_peak(i, at, own, value)
                });
        }
        loading.wind_m_s = self.compose(sample_period_s, hidden, loading.wind_m_s, |effect, own, value| {
            effect.headwind_m_s(at, own, value)
        });
        loading.other_n = self.compose(sample_period_s, hidden, loading.other_n, |effect, own, value| {
            effect.body_force_n(at, own, value)
        });
        loading
    }

    /// Forces and accelerations at a state. Loads and acceleration are consistent with each other to rounding.
    pub fn forces(&self, state: &WagonState, loading: &Loading) -> Forces {
        let constants = &self.constants;
        let resistance_n = running_resistance(&constants.resistance, state.v_m_s, loading.wind_m_s);
        let mut forces = Forces { resistance_n, other_n: loading.other_n, ..Forces::default() };
        // The map acceleration → loads → contact forces → acceleration contracts by about (h/a)·Δμ, a few percent.
        for _ in 0..12 {
            forces.load_n = self.loads.loads_n(forces.acceleration_m_s2);
            for i in 0..constants.wheelsets {
                forces.contact_n[i] = self.contact(i, state, loading, &forces.load_n).force_n;
            }
            let sum = forces.contact_n.iter().sum::<f64>() - resistance_n + loading.other_n;
            let acceleration = sum / constants.mass_kg;
            let change = acceleration - forces.acceleration_m_s2;
            forces.acceleration_m_s2 = acceleration;
            if change.abs() < 1e-13 * (1.0 + acceleration.abs()) {
                break;
            }
        }
        for i in 0..constants.wheelsets {
            let free = loading.drive_torque_nm[i] - constants.wheel_radius_m[i] * forces.contact_n[i];
            let omega = state.wheel_speed_rad_s[i];
            let holding = loading.brake_torque_nm[i];
            forces.brake_torque_nm[i] =
                if omega == 0.0 { -free.clamp(-holding, holding) } else { -holding * omega.signum() };
            forces.wheel_acceleration_rad_s2[i] =
                (free + forces.brake_torque_nm[i]) / constants.inertia_kg_m2[i];
        }
        forces
    }

    #[inline]
    fn contact(&self, i: usize, state: &WagonState, loading: &Loading, load_n: &PerWheelset) -> ContactForce {
        let rim_speed = self.constants.wheel_radius_m[i] * state.wheel_speed_rad_s[i];
        creep_force(&self.constants.contact, rim_speed, state.v_m_s, load_n[i], loading.adhesion_peak[i])
    }

    /// The state after `dt_s` under a constant loading (pass the loading of the middle of the step for order two).
    ///
    /// `acceleration_m_s2` is the body's acceleration as last known; it is updated, and serves the loads.
    pub fn step(
        &self,
        state: &WagonState,
        loading: &Loading,
        dt_s: f64,
        acceleration_m_s2: &mut f64,
    ) -> WagonState {
        let stage_s = GAMMA * dt_s;
        let first = self.solve_stage(state, state, loading, stage_s, acceleration_m_s2);
        // Derivatives of the first stage follow from its own equation, so that it need not be evaluated again.
        let weight = (1.0 - GAMMA) / GAMMA;
        let mut base = WagonState { v_m_s: state.v_m_s + weight * (first.v_m_s - state.v_m_s), ..*state };
        for i in 0..self.constants.wheelsets {
            let start = state.wheel_speed_rad_s[i];
            base.wheel_speed_rad_s[i] = start + weight * (first.wheel_speed_rad_s[i] - start);
        }
        self.solve_stage(&base, &first, loading, stage_s, acceleration_m_s2)
    }

    /// Solves `u = base + stage_s · f(u)`, starting from `guess`: by Newton's method on all speeds at once where
    /// that converges at once (rolling, steady slides), else by the guarded nested iteration.
    fn solve_stage(
        &self,
        base: &WagonState,
        guess: &WagonState,
        loading: &Loading,
        stage_s: f64,
        acceleration_m_s2: &mut f64,
    ) -> WagonState {
        let mut state = *guess;
        state.v_m_s = base.v_m_s + stage_s * *acceleration_m_s2;
        for i in 0..self.constants.wheelsets {
            // A guess that keeps the slip is close both in rolling and in a steady slide.
            state.wheel_speed_rad_s[i] += (state.v_m_s - guess.v_m_s) / self.constants.wheel_radius_m[i];
        }
        self.solve_jointly(base, &state, loading, stage_s, acceleration_m_s2)
            .unwrap_or_else(|| self.solve_nested(base, &state, loading, stage_s, acceleration_m_s2))
    }

    /// Newton's method on body and wheelset speeds together; the Jacobian is an arrow, so that the body speed can be
    /// eliminated first. `None` when a brake may hold its wheelset or the iteration does not converge quickly.
    fn solve_jointly(
        &self,
        base: &WagonState,
        guess: &WagonState,
        loading: &Loading,
        stage_s: f64,
        acceleration_m_s2: &mut f64,
    ) -> Option<WagonState> {
        let constants = &self.constants;
        let per_mass = stage_s / constants.mass_kg;
        let mut state = *guess;
        let mut acceleration = *acceleration_m_s2;
        let mut target = [0.0; MAX_WHEELSETS];
        let mut gain = [0.0; MAX_WHEELSETS];
        let load_n = self.loads.loads_n(acceleration);
        for i in 0..constants.wheelsets {
            gain[i] = stage_s / constants.inertia_kg_m2[i];
            target[i] = base.wheel_speed_rad_s[i]
                + gain[i] * (loading.drive_torque_nm[i] - loading.brake_torque_nm[i]);
            let reach = gain[i] * constants.wheel_radius_m[i] * load_n[i] * loading.adhesion_peak[i].max(0.0);
            if target[i] <= 1.1 * reach {
                return None;
            }
        }
        for _ in 0..6 {
            let load_n = self.loads.loads_n(acceleration);
            let resistance = running_resistance(&constants.resistance, state.v_m_s, loading.wind_m_s);
            let (mut force, mut stiffness, mut coupling) = (loading.other_n - resistance, 0.0, 0.0);
            let mut correction = [0.0; MAX_WHEELSETS];
            let mut follow = [0.0; MAX_WHEELSETS];
            for i in 0..constants.wheelsets {
                let contact = self.contact(i, &state, loading, &load_n);
                let radius = constants.wheel_radius_m[i];
                let residual = state.wheel_speed_rad_s[i] - target[i] + gain[i] * radius * contact.force_n;
                let stiff = gain[i] * radius * contact.slope_n_s_per_m;
                let slope = 1.0 + radius * stiff;
                if slope < 0.2 {
                    return None;
                }
                correction[i] = residual / slope;
                follow[i] = stiff / slope;
                force += contact.force_n;
                stiffness += contact.slope_n_s_per_m / slope;
                coupling += contact.slope_n_s_per_m * radius * correction[i];
            }
            let residual = state.v_m_s - base.v_m_s - per_mass * (force - coupling);
            let change = residual / (1.0 + per_mass * stiffness);
            state.v_m_s -= change;
            acceleration = (state.v_m_s - base.v_m_s) / stage_s;
            let mut largest = change.abs();
            for i in 0..constants.wheelsets {
                let change = correction[i] + follow[i] * change;
                state.wheel_speed_rad_s[i] -= change;
                largest = largest.max(change.abs());
            }
            // Quadratic convergence: what is left after a change of 1e-5 is below 1e-9.
            if largest < 1e-5 {
                *acceleration_m_s2 = acceleration;
                return Some(state);
            }
        }
        None
    }

    /// The guarded iteration: wheelsets one by one for a given body speed, and Newton's method on that speed.
    fn solve_nested(
        &self,
        base: &WagonState,
        guess: &WagonState,
        loading: &Loading,
        stage_s: f64,
        acceleration_m_s2: &mut f64,
    ) -> WagonState {
        let constants = &self.constants;
        let mut state = *guess;
        for _ in 0..8 {
            let load_n = self.loads.loads_n(*acceleration_m_s2);
            let mut force =
                loading.other_n - running_resistance(&constants.resistance, state.v_m_s, loading.wind_m_s);
            let mut stiffness = 0.0;
            for i in 0..constants.wheelsets {
                let contact = self.solve_wheelset(i, base, &mut state, loading, stage_s, &load_n);
                force += contact.force_n;
                stiffness += contact.slope_n_s_per_m;
            }
            let residual = state.v_m_s - base.v_m_s - stage_s * force / constants.mass_kg;
            let change = residual / (1.0 + stage_s * stiffness / constants.mass_kg);
            state.v_m_s -= change;
            *acceleration_m_s2 = (state.v_m_s - base.v_m_s) / stage_s;
            if change.abs() < 1e-9 {
                break;
            }
        }
        state
    }

    /// Solves one wheelset's stage equation for its speed at the body speed of `state`; returns its contact force,
    /// with the slope of that force over body speed (positive: resisting) *after* the wheelset has adapted.
    fn solve_wheelset(
        &self,
        i: usize,
        base: &WagonState,
        state: &mut WagonState,
        loading: &Loading,
        stage_s: f64,
        load_n: &PerWheelset,
    ) -> ContactForce {
        let constants = &self.constants;
        let radius = constants.wheel_radius_m[i];
        let gain = stage_s / constants.inertia_kg_m2[i];
        let holding = gain * loading.brake_torque_nm[i];
        let free = base.wheel_speed_rad_s[i] + gain * loading.drive_torque_nm[i];
        let v = state.v_m_s;
        let contact_at = |omega: f64| {
            creep_force(&constants.contact, radius * omega, v, load_n[i], loading.adhesion_peak[i])
        };
        let at_rest = contact_at(0.0);
        let unbraked = free - gain * radius * at_rest.force_n;
        if unbraked.abs() <= holding {
            state.wheel_speed_rad_s[i] = 0.0;
            return at_rest;
        }
        let target = free - holding * unbraked.signum();
        // The contact force is bounded by the friction limit (and some rounding), hence so is the solution.
        let reach = 1.01 * gain * radius * load_n[i] * loading.adhesion_peak[i].max(0.0);
        let (mut low, mut high) = (target - reach, target + reach);
        let mut omega = state.wheel_speed_rad_s[i].clamp(low, high);
        let mut contact = contact_at(omega);
        for _ in 0..60 {
            let residual = omega - target + gain * radius * contact.force_n;
            if residual > 0.0 {
                high = high.min(omega);
            } else {
                low = low.max(omega);
            }
            let slope = 1.0 + gain * radius * radius * contact.slope_n_s_per_m;
            let newton = omega - residual / slope;
            let next =
                if slope > 0.0 && newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            let change = next - omega;
            omega = next;
            contact = contact_at(omega);
            if change.abs() < 1e-10 * (1.0 + omega.abs()) {
                break;
            }
        }
        state.wheel_speed_rad_s[i] = omega;
        let adapted = 1.0 + gain * radius * radius * contact.slope_n_s_per_m;
        ContactForce { force_n: contact.force_n, slope_n_s_per_m: contact.slope_n_s_per_m / adapted.max(0.1) }
    }
}
