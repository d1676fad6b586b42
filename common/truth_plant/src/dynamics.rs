//! The equations of motion and their integration: substeps of a two-stage Rosenbrock method (ROS2 of Verwer et al. 1999, L-stable,
//! second order with any Jacobian), so that the stiff contact needs no small step and yet is resolved.

use crate::{sheet::GRAVITY_M_S2, wagon::TrueWagon};

/// Speed below which creepage is referred to this speed, m/s.
const CREEPAGE_FLOOR_M_S: f64 = 0.5;

/// Wagon speed (m/s) and both wheel speeds (rad/s).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Speed, m/s.
    pub v_m_s: f64,
    /// Wheel speeds, leading first, rad/s.
    pub wheel_speed_rad_s: [f64; 2],
}

/// What acts on the wagon during a step, besides the contacts.
#[derive(Debug, Clone, Copy)]
pub struct Action {
    /// Torque that reaches each wheel, N m.
    pub shaft_torque_nm: [f64; 2],
    /// Slope, rad.
    pub grade_rad: f64,
    /// Air speed against the wagon beyond its own speed, m/s.
    pub headwind_m_s: f64,
    /// Other force on the body, forward positive, N.
    pub body_force_n: f64,
    /// Factor on the transfer of load.
    pub load_transfer: f64,
}

/// Forces and rates of one instant.
#[derive(Debug, Clone, Copy, Default)]
pub struct Rates {
    /// Acceleration of the wagon, m/s².
    pub acceleration_m_s2: f64,
    /// Angular accelerations, rad/s².
    pub wheel_rad_s2: [f64; 2],
    /// Contact forces, forward positive, N.
    pub contact_n: [f64; 2],
    /// Wheel loads of each wheelset, N.
    pub load_n: [f64; 2],
    /// Slope of the contact forces with slip velocity, N s/m.
    pub slope_n_s_per_m: [f64; 2],
}

/// Smoothed sign of a motion. Beyond 20 the hyperbolic tangent is 1 to the last digit, and most steps are there.
#[must_use]
pub fn direction(scaled: f64) -> f64 {
    if scaled > 20.0 { 1.0 } else { scaled.tanh() }
}

/// The rates at a state; `friction(wheelset, slip_velocity)` is peak adhesion there. `lagged_m_s2`, the acceleration
/// of an instant ago, loads the wheelsets first and is then corrected once (the contraction factor is about 0.03).
pub fn rates(
    wagon: &TrueWagon,
    motion: &Motion,
    action: &Action,
    lagged_m_s2: f64,
    friction: &impl Fn(usize, f64) -> f64,
) -> Rates {
    let v = motion.v_m_s;
    let [constant, linear, drag] = wagon.resistance;
    let air_m_s = v + action.headwind_m_s;
    let resistance_n = (constant + linear * v) * direction(v / 0.05) + drag * air_m_s * air_m_s.abs();
    let weight_n = wagon.mass_kg * GRAVITY_M_S2;
    let outer_n = action.body_force_n - resistance_n - weight_n * action.grade_rad.sin();
    let reference_m_s = v.max(CREEPAGE_FLOOR_M_S);
    let mut rates = Rates { acceleration_m_s2: lagged_m_s2, ..Rates::default() };
    let peak: [f64; 2] = std::array::from_fn(|k| {
        let slip_m_s = wagon.radius_m[k] * motion.wheel_speed_rad_s[k] - v;
        friction(k, slip_m_s.abs())
    });
    for _pass in 0..2 {
        let transfer_n =
            action.load_transfer * wagon.height_over_wheelbase * wagon.mass_kg * rates.acceleration_m_s2;
        rates.load_n = [weight_n / 2.0 - transfer_n, weight_n / 2.0 + transfer_n];
        for k in 0..2 {
            let radius = wagon.radius_m[k];
            let creepage = (radius * motion.wheel_speed_rad_s[k] - v) / reference_m_s;
            let (force_n, slope_n) = wagon.creep_force(creepage, rates.load_n[k], peak[k]);
            rates.contact_n[k] = force_n;
            rates.wheel_rad_s2[k] = (action.shaft_torque_nm[k] - radius * force_n) / wagon.inertia_kg_m2[k];
            rates.slope_n_s_per_m[k] = slope_n / reference_m_s;
        }
        rates.acceleration_m_s2 = (rates.contact_n.iter().sum::<f64>() + outer_n) / wagon.mass_kg;
    }
    rates
}

/// Longest substep over the time constant of the contact in pure rolling. In longer ones the two stages can throw a wheel from
/// one side of rolling to the other and cancel, so that it sits in a slide that nothing holds.
const LONGEST_SUBSTEP: f64 = 1.5;

/// One step; returns the new motion and the rates at its start. It is made of substeps that the contact allows: one at line
/// speed, more near standstill, where creepage is stiff.
pub fn step(
    wagon: &TrueWagon,
    motion: &Motion,
    action: &Action,
    lagged_m_s2: f64,
    step_s: f64,
    friction: &impl Fn(usize, f64) -> f64,
) -> (Motion, Rates) {
    let reference_m_s = motion.v_m_s.max(CREEPAGE_FLOOR_M_S);
    let stiffness_n = wagon.stiffness_n * std::f64::consts::FRAC_2_PI * wagon.reduction.iter().sum::<f64>();
    let lever = |k: usize| wagon.radius_m[k] * wagon.radius_m[k] / wagon.inertia_kg_m2[k];
    let rate = stiffness_n / reference_m_s * lever(0).max(lever(1));
    let substeps = (rate * step_s / LONGEST_SUBSTEP).ceil().max(1.0);
    let (mut next, first) = substep(wagon, motion, action, lagged_m_s2, step_s / substeps, friction);
    let mut lagged_m_s2 = first.acceleration_m_s2;
    for _ in 1..substeps as usize {
        let (after, rates) = substep(wagon, &next, action, lagged_m_s2, step_s / substeps, friction);
        (next, lagged_m_s2) = (after, rates.acceleration_m_s2);
    }
    (next, first)
}

/// One substep. Integrated are the speed and the slip velocities `w = r ω − v`, whose stiff coupling through the contact is
/// solved in full.
fn substep(
    wagon: &TrueWagon,
    motion: &Motion,
    action: &Action,
    lagged_m_s2: f64,
    step_s: f64,
    friction: &impl Fn(usize, f64) -> f64,
) -> (Motion, Rates) {
    let first = rates(wagon, motion, action, lagged_m_s2, friction);
    let contact = Contact::new(wagon, &first, step_s);
    let k1 = contact.damp(derivative(wagon, &first));
    let ahead = moved(wagon, motion, k1.map(|k| step_s * k));
    let second = rates(wagon, &ahead, action, first.acceleration_m_s2, friction);
    let f2 = derivative(wagon, &second);
    let k2 = contact.damp(std::array::from_fn(|i| f2[i] - 2.0 * k1[i]));
    let next = moved(wagon, motion, std::array::from_fn(|i| step_s * (1.5 * k1[i] + 0.5 * k2[i])));
    (next, first)
}

/// Derivative of `[v, w_leading, w_rear]`.
fn derivative(wagon: &TrueWagon, rates: &Rates) -> [f64; 3] {
    let slip = |k: usize| wagon.radius_m[k] * rates.wheel_rad_s2[k] - rates.acceleration_m_s2;
    [rates.acceleration_m_s2, slip(0), slip(1)]
}

/// The motion after a change of `[v, w_leading, w_rear]`.
fn moved(wagon: &TrueWagon, motion: &Motion, change: [f64; 3]) -> Motion {
    let wheel = |k: usize| motion.wheel_speed_rad_s[k] + (change[1 + k] + change[0]) / wagon.radius_m[k];
    Motion { v_m_s: motion.v_m_s + change[0], wheel_speed_rad_s: [wheel(0), wheel(1)] }
}

/// The matrix `I − γ h A` of the method, with `A` the Jacobian with respect to the slip velocities.
struct Contact {
    /// `γ h F'/m` of each wheelset.
    pull: [f64; 2],
    /// Diagonal of the slip block.
    diagonal: [f64; 2],
}

impl Contact {
    const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

    fn new(wagon: &TrueWagon, rates: &Rates, step_s: f64) -> Self {
        let pull = rates.slope_n_s_per_m.map(|slope| Self::GAMMA * step_s * slope / wagon.mass_kg);
        let diagonal = std::array::from_fn(|k| {
            let lever = wagon.radius_m[k] * wagon.radius_m[k] / wagon.inertia_kg_m2[k];
            1.0 + Self::GAMMA * step_s * rates.slope_n_s_per_m[k] * lever + pull[k]
        });
        Self { pull, diagonal }
    }

    /// Solves `(I − γ h A) k = f`.
    fn damp(&self, [f_v, f_w, f_x]: [f64; 3]) -> [f64; 3] {
        let [p, q] = self.pull;
        let determinant = self.diagonal[0] * self.diagonal[1] - p * q;
        let k_w = (f_w * self.diagonal[1] - q * f_x) / determinant;
        let k_x = (f_x * self.diagonal[0] - p * f_w) / determinant;
        [f_v + p * k_w + q * k_x, k_w, k_x]
    }
}
