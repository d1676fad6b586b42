//! The wagon: body and wheelsets coupled by contact, with brakes, resistance and effects.
//!
//! [`WagonModel`] puts the laws of this crate together: [`crate::motion`] with the loads of [`crate::load`], the creep
//! force of [`crate::adhesion`], the torque of [`crate::brake`] and [`crate::resistance`], each passed through the effects.

pub mod fast;
mod flow;
mod guarded;
mod integrate;
mod quantities;
mod rest;
mod sample_step;
mod slopes;

pub use quantities::{Constants, Forces, Loading, WagonInput, WagonState};
pub use sample_step::SampleStep;
pub use slopes::Slopes;

use crate::adhesion::{ContactForce, creep_force};
use crate::brake::pad_torque_nm;
use crate::effects::{self, Effect, ModelError, Observation, Operating};
use crate::load::LoadDistribution;
use crate::motion::{body_acceleration_m_s2, wheelset_acceleration_rad_s2};
use crate::resistance::{grade_force, running_resistance};
use crate::{PerWheelset, VehicleParameters};

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
        let constants = Constants::of(parameters);
        for (entry, effect) in parameters.effects.iter().zip(&effects) {
            effects::check_on(&**effect, entry, &constants)?;
        }
        Ok(Self::from_constants(constants, effects))
    }

    /// The model of `parameters` (whose own effect entries are ignored) with these effects.
    pub fn with_effects(parameters: &VehicleParameters, effects: Vec<Box<dyn Effect>>) -> Self {
        Self::from_constants(Constants::of(parameters), effects)
    }

    /// The model with these constants, before effects change them.
    pub fn from_constants(mut constants: Constants, mut effects: Vec<Box<dyn Effect>>) -> Self {
        effects.iter_mut().for_each(|effect| effect.join(&constants));
        effects.iter().for_each(|effect| effect.constants(&mut constants));
        let loads = match (constants.fixed_load_n, constants.bogie) {
            (Some(load_n), _) => LoadDistribution::fixed(load_n, constants.wheelsets),
            (None, Some(bogie)) => LoadDistribution::on_bogies(
                constants.mass_kg,
                constants.com_height_m,
                &constants.wheelset_positions_m,
                bogie.pivot_height_m,
            ),
            (None, None) => LoadDistribution::new(
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
        self.each_effect(sample_period_s, hidden, |effect, own| effect.observe(at, own, &mut reading));
        reading
    }

    /// Turns what the sensors read at the start of a simulation into the state of the vehicle, see [`Self::observe`].
    pub fn correct(&self, at: &Operating, sample_period_s: f64, hidden: &[f64], state: &mut Observation) {
        self.each_effect(sample_period_s, hidden, |effect, own| effect.correct(at, own, state));
    }

    fn each_effect_mut(&self, dt_s: f64, hidden: &mut [f64], mut visit: impl FnMut(&dyn Effect, &mut [f64])) {
        let mut rest = hidden;
        for effect in self.effects.iter() {
            let (own, others) = rest.split_at_mut(effect.hidden_len(dt_s));
            visit(effect.as_ref(), own);
            rest = others;
        }
    }

    /// Visits each effect with its hidden states, in the order in which they act.
    fn each_effect(&self, dt_s: f64, hidden: &[f64], mut visit: impl FnMut(&dyn Effect, &[f64])) {
        let mut rest = hidden;
        for effect in self.effects.iter() {
            let (own, others) = rest.split_at(effect.hidden_len(dt_s));
            visit(effect.as_ref(), own);
            rest = others;
        }
    }

    /// The operating point of `state` under `input`; powers and acceleration are zero until [`Self::note_forces`].
    pub fn operating(&self, state: &WagonState, input: &WagonInput) -> Operating {
        Operating {
            wheelsets: self.constants.wheelsets,
            time_s: input.time_s,
            v_m_s: state.v_m_s,
            position_m: input.position_m,
            wheelset_position_m: self.constants.wheelset_positions_m,
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
        let wheelsets = 0..constants.wheelsets;
        for i in wheelsets.clone() {
            loading.pad_force_n[i] = input.pressing_force_n[i];
            loading.brake_friction[i] = constants.brake_friction[i] * input.brake_friction_factor[i];
            loading.adhesion_peak[i] = input.adhesion_peak[i];
        }
        self.each_effect(sample_period_s, hidden, |effect, own| {
            let of = &mut loading;
            for i in wheelsets.clone() {
                of.pad_force_n[i] = effect.pad_force_n(i, at, own, of.pad_force_n[i]);
                of.brake_friction[i] = effect.brake_friction(i, at, own, of.brake_friction[i]);
                of.drive_torque_nm[i] = effect.drive_torque_nm(i, at, own, of.drive_torque_nm[i]);
                of.adhesion_peak[i] = effect.adhesion_peak(i, at, own, of.adhesion_peak[i]);
            }
            of.wind_m_s = effect.headwind_m_s(at, own, of.wind_m_s);
            of.other_n = effect.body_force_n(at, own, of.other_n);
        });
        for i in wheelsets.clone() {
            let force = loading.pad_force_n[i].max(0.0);
            loading.pad_force_n[i] = force;
            loading.brake_torque_nm[i] =
                pad_torque_nm(loading.brake_friction[i], force, constants.brake_radius_m);
        }
        self.each_effect(sample_period_s, hidden, |effect, own| {
            for i in wheelsets.clone() {
                loading.brake_torque_nm[i] = effect.brake_torque_nm(i, at, own, loading.brake_torque_nm[i]);
            }
        });
        for i in wheelsets {
            loading.brake_torque_nm[i] = loading.brake_torque_nm[i].max(0.0);
        }
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
            let contact = forces.contact_n.iter().sum();
            let acceleration =
                body_acceleration_m_s2(constants.mass_kg, contact, resistance_n, loading.other_n);
            let change = acceleration - forces.acceleration_m_s2;
            forces.acceleration_m_s2 = acceleration;
            if change.abs() < 1e-13 * (1.0 + acceleration.abs()) {
                break;
            }
        }
        for i in 0..constants.wheelsets {
            let contact_n = forces.contact_n[i];
            let omega = state.wheel_speed_rad_s[i];
            let holding = loading.brake_torque_nm[i];
            let against = if omega == 0.0 {
                // What a standing wheelset would turn with, as far as the brake can hold it.
                let free =
                    constants.inertia_kg_m2[i] * self.wheelset_acceleration(i, loading, 0.0, contact_n);
                free.clamp(-holding, holding)
            } else {
                holding * omega.signum()
            };
            forces.brake_torque_nm[i] = -against;
            forces.wheel_acceleration_rad_s2[i] = self.wheelset_acceleration(i, loading, against, contact_n);
        }
        forces
    }

    /// ω̇ of wheelset `i`, rad/s², under the drive torque of `loading` and a brake torque as it acts.
    #[inline]
    fn wheelset_acceleration(
        &self,
        i: usize,
        loading: &Loading,
        brake_torque_nm: f64,
        contact_n: f64,
    ) -> f64 {
        let constants = &self.constants;
        wheelset_acceleration_rad_s2(
            constants.inertia_kg_m2[i],
            constants.wheel_radius_m[i],
            loading.drive_torque_nm[i],
            brake_torque_nm,
            contact_n,
        )
    }

    #[inline]
    fn contact(&self, i: usize, state: &WagonState, loading: &Loading, load_n: &PerWheelset) -> ContactForce {
        let rim_speed = self.constants.wheel_radius_m[i] * state.wheel_speed_rad_s[i];
        creep_force(&self.constants.contact, rim_speed, state.v_m_s, load_n[i], loading.adhesion_peak[i])
    }
}
