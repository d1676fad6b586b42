//! What the wagons are equipped with: traction, brake, wheel-slide protection, couplers.

use serde::{Deserialize, Serialize};

/// Traction: the same share of effort on every wheelset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TractionTable {
    /// Acceleration at full traction and low speed.
    pub acceleration_m_s2: f64,
    /// Speed above which power, not effort, is constant.
    pub full_power_speed_m_s: f64,
    /// Time constant of the effort.
    pub response_time_s: f64,
    /// Whether effort is taken back from a spinning wheelset.
    pub spin_protection: bool,
}

impl Default for TractionTable {
    fn default() -> Self {
        Self {
            acceleration_m_s2: 0.8,
            full_power_speed_m_s: 16.0,
            response_time_s: 0.4,
            spin_protection: true,
        }
    }
}

/// Train brake: pipe, relay and cylinders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BrakeTable {
    /// Deceleration at full service braking with nominal pads on a level dry track; sets the full pressing force.
    pub full_service_deceleration_m_s2: f64,
    /// Cylinder pressure at full service braking.
    pub full_pressure_pa: f64,
    /// Pressure below which the return spring holds the pads off.
    pub spring_pressure_pa: f64,
    /// Speed of a brake command along the train.
    pub propagation_speed_m_s: f64,
    /// Dead time of the distributor.
    pub dead_time_s: f64,
    /// Time constant of filling.
    pub fill_time_s: f64,
    /// Time constant of venting.
    pub vent_time_s: f64,
}

impl Default for BrakeTable {
    fn default() -> Self {
        Self {
            full_service_deceleration_m_s2: 1.1,
            full_pressure_pa: 3.8e5,
            spring_pressure_pa: 3e4,
            propagation_speed_m_s: 280.0,
            dead_time_s: 0.25,
            fill_time_s: 1.3,
            vent_time_s: 1.6,
        }
    }
}

/// Wheel-slide protection after the manner of EN 15595: a valve a wheelset that applies, holds or vents.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WspTable {
    /// Whether the wagons have it.
    pub enabled: bool,
    /// Relative slide from which pressure is held.
    pub hold_slip: f64,
    /// Relative slide from which pressure is vented.
    pub vent_slip: f64,
    /// Deceleration of the rim from which pressure is held or, beyond the hold slip, vented.
    pub rim_deceleration_m_s2: f64,
    /// Vehicle speed below which it does not act.
    pub minimum_speed_m_s: f64,
    /// Dead time of the valves.
    pub valve_dead_time_s: f64,
    /// Time constant of venting through the valve.
    pub valve_vent_time_s: f64,
    /// Time constant of filling through the valve.
    pub valve_fill_time_s: f64,
    /// Length of an apply pulse while it is active.
    pub apply_pulse_s: f64,
    /// Pause between two apply pulses.
    pub apply_pause_s: f64,
}

impl Default for WspTable {
    fn default() -> Self {
        Self {
            enabled: true,
            hold_slip: 0.05,
            vent_slip: 0.14,
            rim_deceleration_m_s2: 2.8,
            minimum_speed_m_s: 1.4,
            valve_dead_time_s: 0.02,
            valve_vent_time_s: 0.12,
            valve_fill_time_s: 0.15,
            apply_pulse_s: 0.04,
            apply_pause_s: 0.12,
        }
    }
}

/// Couplers between neighbours: spring and damper without slack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CouplerTable {
    /// Stiffness.
    pub stiffness_n_per_m: f64,
    /// Damping.
    pub damping_n_s_per_m: f64,
}
