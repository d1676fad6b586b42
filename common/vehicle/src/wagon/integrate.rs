//! The wagon's integrator of the equations of [`crate::motion`].
//!
//! The L-stable, stiffly accurate SDIRK method of order two (Alexander 1977, γ = 1 − 1/√2). Each stage is solved by
//! Newton's method on all speeds at once; where a brake may hold its wheelset, or that does not converge at once, the
//! wheelsets' equations are solved one by one for a given body speed (they are monotone in ω), with the brake's
//! Coulomb friction as a set-valued law, so that lock and release need no event search. It is stable at 10 ms down to
//! standstill, where the creep force is stiffest.

use super::{Loading, WagonModel, WagonState};
use crate::adhesion::{ContactForce, creep_force};
use crate::motion::body_acceleration_m_s2;
use crate::resistance::running_resistance;
use crate::{MAX_WHEELSETS, PerWheelset};

/// Diagonal coefficient of the SDIRK method.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

impl WagonModel {
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
        let load_n = self.loads.loads_n(acceleration);
        for i in 0..constants.wheelsets {
            let without_contact =
                self.wheelset_after(i, base, loading, loading.brake_torque_nm[i], 0.0, stage_s);
            let reach = stage_s / constants.inertia_kg_m2[i]
                * constants.wheel_radius_m[i]
                * load_n[i]
                * loading.adhesion_peak[i].max(0.0);
            if without_contact <= 1.1 * reach {
                return None;
            }
        }
        for _ in 0..6 {
            let load_n = self.loads.loads_n(acceleration);
            let resistance = running_resistance(&constants.resistance, state.v_m_s, loading.wind_m_s);
            let (mut force, mut stiffness, mut coupling) = (0.0, 0.0, 0.0);
            let mut correction = [0.0; MAX_WHEELSETS];
            let mut follow = [0.0; MAX_WHEELSETS];
            for i in 0..constants.wheelsets {
                let contact = self.contact(i, &state, loading, &load_n);
                let radius = constants.wheel_radius_m[i];
                let braked = loading.brake_torque_nm[i];
                let residual = state.wheel_speed_rad_s[i]
                    - self.wheelset_after(i, base, loading, braked, contact.force_n, stage_s);
                let stiff = stage_s / constants.inertia_kg_m2[i] * radius * contact.slope_n_s_per_m;
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
            let rate =
                body_acceleration_m_s2(constants.mass_kg, force - coupling, resistance, loading.other_n);
            let residual = state.v_m_s - base.v_m_s - stage_s * rate;
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
            let resistance = running_resistance(&constants.resistance, state.v_m_s, loading.wind_m_s);
            let (mut force, mut stiffness) = (0.0, 0.0);
            for i in 0..constants.wheelsets {
                let contact = self.solve_wheelset(i, base, &mut state, loading, stage_s, &load_n);
                force += contact.force_n;
                stiffness += contact.slope_n_s_per_m;
            }
            let rate = body_acceleration_m_s2(constants.mass_kg, force, resistance, loading.other_n);
            let residual = state.v_m_s - base.v_m_s - stage_s * rate;
            let change = residual / (1.0 + stage_s * stiffness / constants.mass_kg);
            state.v_m_s -= change;
            *acceleration_m_s2 = (state.v_m_s - base.v_m_s) / stage_s;
            if change.abs() < 1e-9 {
                break;
            }
        }
        state
    }

    /// ω of wheelset `i` after a stage from `base` under a brake torque as it acts and a contact force, rad/s.
    #[inline]
    fn wheelset_after(
        &self,
        i: usize,
        base: &WagonState,
        loading: &Loading,
        brake_torque_nm: f64,
        contact_n: f64,
        stage_s: f64,
    ) -> f64 {
        base.wheel_speed_rad_s[i]
            + stage_s * self.wheelset_acceleration(i, loading, brake_torque_nm, contact_n)
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
        let holding_nm = loading.brake_torque_nm[i];
        let v = state.v_m_s;
        let contact_at = |omega: f64| {
            creep_force(&constants.contact, radius * omega, v, load_n[i], loading.adhesion_peak[i])
        };
        let at_rest = contact_at(0.0);
        let unbraked = self.wheelset_after(i, base, loading, 0.0, at_rest.force_n, stage_s);
        if unbraked.abs() <= gain * holding_nm {
            state.wheel_speed_rad_s[i] = 0.0;
            return at_rest;
        }
        let braked_nm = holding_nm * unbraked.signum();
        let target = self.wheelset_after(i, base, loading, braked_nm, 0.0, stage_s);
        // The contact force is bounded by the friction limit (and some rounding), hence so is the solution.
        let reach = 1.01 * gain * radius * load_n[i] * loading.adhesion_peak[i].max(0.0);
        let (mut low, mut high) = (target - reach, target + reach);
        let mut omega = state.wheel_speed_rad_s[i].clamp(low, high);
        let mut contact = contact_at(omega);
        for _ in 0..60 {
            let residual = omega - self.wheelset_after(i, base, loading, braked_nm, contact.force_n, stage_s);
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
