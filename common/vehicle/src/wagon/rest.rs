//! A sample of a wagon that its brakes hold at standstill: where recordings begin or end, hundreds of them come in a row, and noise
//! of the sensors throws a filter's state off at each.
//!
//! Where every wheelset stands, the body obeys one scalar equation, stiff in their creep:
//!
//! ```text
//! m v̇ = G(v) = R − Σ F_i(v) ,   v∞ : G(v∞) = 0
//! ```
//!
//! Creep force rises ever more slowly with slip, so that the distance from v∞ decays at least as fast as its first rate says, and ever
//! faster. A wheelset that creep turns on against its brake slows the body by what the brake takes, and turns with it. Where
//! these bounds leave next to nothing of the distance at the end of the sample, the wagon stands there, whatever happened in
//! between.

use super::sample_step::{SampleStep, UNSETTLED_M_S};
use super::{Loading, WagonState};
use crate::CREEPAGE_SPEED_FLOOR_M_S;
use crate::PerWheelset;
use crate::adhesion::{creep_force_at, initial_creep_slope_n};

/// Share of what rails and brakes can hold up to which creep counts as straight, so that v∞ is known at once.
const STRAIGHT: f64 = 0.05;
/// Share of the distance from v∞ at which the bound is asked again.
const CLOSER: f64 = 0.25;

impl<const PAIRS: usize> SampleStep<'_, PAIRS> {
    /// Speeds after a sample at standstill; `None` where the wagon may still move at its end.
    pub(super) fn rest(
        &self,
        state: &WagonState,
        load_n: &PerWheelset,
        loading: &Loading,
    ) -> Option<WagonState> {
        let constants = self.constants;
        let wheelsets = 0..constants.wheelsets;
        let at_zero_n = loading.other_n - self.resistance(0.0, loading);
        let mut brakes_n = [0.0; crate::MAX_WHEELSETS];
        let (mut holds_n, mut fastest_m_s, mut stop_s) = (0.0, state.v_m_s.abs(), 0.0);
        for i in wheelsets.clone() {
            let (radius_m, omega) = (constants.wheel_radius_m[i], state.wheel_speed_rad_s[i].abs());
            let spare_nm = loading.brake_torque_nm[i] - loading.drive_torque_nm[i].abs();
            brakes_n[i] = spare_nm / radius_m;
            holds_n += f64::min(brakes_n[i], load_n[i] * loading.adhesion_peak[i]);
            fastest_m_s = f64::max(fastest_m_s, radius_m * omega);
            stop_s = f64::max(stop_s, constants.inertia_kg_m2[i] * omega / spare_nm);
        }
        let can_hold = brakes_n[wheelsets.clone()].iter().all(|brake_n| *brake_n > 0.0);
        if !can_hold || at_zero_n.is_nan() || at_zero_n.abs() > STRAIGHT * holds_n {
            return None;
        }
        let contact = &constants.contact;
        let slope = constants.wheelsets as f64 * initial_creep_slope_n(contact) / CREEPAGE_SPEED_FLOOR_M_S;
        let stands_m_s = at_zero_n / (slope + self.drag(0.0, loading));
        let distance_m_s = fastest_m_s + stop_s * at_zero_n.abs() * self.per_mass + stands_m_s.abs();
        // At least, in the slower of both senses.
        let rate = |distance_m_s: f64| -> f64 {
            let towards = |sense: f64| {
                let v_m_s = stands_m_s + sense * distance_m_s;
                let slows_n = |i: usize| {
                    let peak = loading.adhesion_peak[i];
                    let creep = creep_force_at(contact, v_m_s, CREEPAGE_SPEED_FLOOR_M_S, load_n[i], peak);
                    creep.force_n.clamp(-brakes_n[i], brakes_n[i])
                };
                let slows_n: f64 = wheelsets.clone().map(slows_n).sum();
                sense * (slows_n - loading.other_n + self.resistance(v_m_s, loading)) / self.moving_kg
            };
            towards(1.0).min(towards(-1.0))
        };
        let near_m_s = CLOSER * distance_m_s;
        let nearly = rate(near_m_s);
        // Friction that falls with slip may make the start slower than what comes.
        let slowest = nearly.min(rate(distance_m_s));
        let left_s = self.dt_s - stop_s - (distance_m_s - near_m_s) / slowest;
        let left_m_s = near_m_s * (-left_s * nearly / near_m_s).exp();
        let stands = slowest > 0.0 && left_s > 0.0 && left_m_s < UNSETTLED_M_S;
        (stands || distance_m_s < UNSETTLED_M_S)
            .then(|| WagonState { v_m_s: stands_m_s, ..WagonState::default() })
    }
}
