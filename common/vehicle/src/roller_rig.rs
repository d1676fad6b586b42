//! Roller rig with one wheelset (Schwarz & Keck, section 3): the roller stands for the wagon.
//!
//! ```text
//! J ω̇ = M_W − T_B sign(ω) − r_W F_x
//! m v̇ = F_x + F_roller ,  v = ω_roller r_roller ,  m = J_roller / r_roller²
//! ```
//! Only the roller is loaded by an additional torque that imitates drag and the inertia of a wagon.

use crate::adhesion::creep_force;
use crate::{Contact, GRAVITY_M_S2};

/// Constants of a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct RollerRig {
    /// Rolling radius of the wheelset r_W, m.
    pub wheel_radius_m: f64,
    /// Moment of inertia of the wheelset J, kg m².
    pub inertia_kg_m2: f64,
    /// Friction radius r_B, m.
    pub brake_radius_m: f64,
    /// Normal load of the wheelset, N.
    pub load_n: f64,
    /// Mass that roller and its drive represent, kg.
    pub equivalent_mass_kg: f64,
    /// Contact law.
    pub contact: Contact,
}

/// Motion of a rig.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigState {
    /// Angular speed of the wheelset, rad/s.
    pub wheel_speed_rad_s: f64,
    /// Circumferential speed of the roller (the virtual vehicle speed), m/s.
    pub v_m_s: f64,
}

/// What acts on a rig.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigInput {
    /// Brake torque that the caliper can hold, N m.
    pub brake_torque_nm: f64,
    /// Torque on the wheelset besides, N m.
    pub drive_torque_nm: f64,
    /// Force of the roller's drive at its rim, N, forward positive.
    pub roller_force_n: f64,
    /// Adhesion available.
    pub adhesion_peak: f64,
}

impl RollerRig {
    /// A rig whose roller carries the share of a wagon that its wheelset's load stands for.
    pub fn with_load_share(mut self) -> Self {
        self.equivalent_mass_kg = self.load_n / GRAVITY_M_S2;
        self
    }

    /// Contact force on the virtual wagon, N.
    pub fn contact_force_n(&self, state: &RigState, adhesion_peak: f64) -> f64 {
        let rim_speed = self.wheel_radius_m * state.wheel_speed_rad_s;
        creep_force(&self.contact, rim_speed, state.v_m_s, self.load_n, adhesion_peak).force_n
    }

    /// The state after `dt_s` under constant input: implicit Euler with the brake as set-valued Coulomb friction,
    /// in `substeps` equal parts.
    pub fn step(&self, state: &RigState, input: &RigInput, dt_s: f64, substeps: usize) -> RigState {
        let step_s = dt_s / substeps.max(1) as f64;
        (0..substeps.max(1)).fold(*state, |state, _| self.implicit_step(&state, input, step_s))
    }

    fn implicit_step(&self, start: &RigState, input: &RigInput, dt_s: f64) -> RigState {
        let gain = dt_s / self.inertia_kg_m2;
        let mut state = *start;
        for _ in 0..6 {
            let v = state.v_m_s;
            let force_at = |omega: f64| {
                self.contact_force_n(&RigState { wheel_speed_rad_s: omega, v_m_s: v }, input.adhesion_peak)
            };
            let free = start.wheel_speed_rad_s + gain * input.drive_torque_nm;
            let unbraked = free - gain * self.wheel_radius_m * force_at(0.0);
            let holding = gain * input.brake_torque_nm;
            state.wheel_speed_rad_s = if unbraked.abs() <= holding {
                0.0
            } else {
                let target = free - holding * unbraked.signum();
                let reach = gain * self.wheel_radius_m * self.load_n * input.adhesion_peak;
                bisect(target - reach, target + reach, |omega| {
                    omega - target + gain * self.wheel_radius_m * force_at(omega)
                })
            };
            let force = self.contact_force_n(&state, input.adhesion_peak) + input.roller_force_n;
            let next = start.v_m_s + dt_s * force / self.equivalent_mass_kg;
            let change = next - v;
            // Half a step towards the fixed point: the wheelset adapts to each new speed, so full steps can swing.
            state.v_m_s = v + 0.5 * change;
            if change.abs() < 1e-10 {
                break;
            }
        }
        state
    }
}

/// Root of an increasing function between `low` and `high`.
fn bisect(mut low: f64, mut high: f64, function: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if function(middle) > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}
