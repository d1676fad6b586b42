//! The equations of motion and three ways of integrating them, none of which can come to rest where nothing balances.
//!
//! Every wheelset solves `J ω̇ = T − B − r F(r ω − v)` for itself against the predicted speed of the wagon, the wagon then
//! takes the sum of the contact forces. The prediction is a contraction with the ratio of turning to moving mass, about 0.1.
//! The contact force enters either at the end of the step (implicit Euler), weighted over the step (`θ = 0.6`, which damps
//! what it does not resolve), or explicitly over substeps that the stiffest slope of the contact allows. The solution of the
//! implicit equations is bracketed, and a rest point of either scheme is one of the equation itself.

use super::{units::PerWheelset, wagon::FamilyWagon};

/// Speed of the wagon (m/s) and of its wheels (rad/s).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Speed, m/s.
    pub v_m_s: f64,
    /// Wheel speeds, rad/s.
    pub wheel_speed_rad_s: PerWheelset,
}

/// What acts during a step.
#[derive(Debug, Clone, Copy, Default)]
pub struct Action {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Wheel loads, N.
    pub load_n: PerWheelset,
    /// Peak adhesion under each wheelset.
    pub peak: PerWheelset,
    /// Rolling radius, m.
    pub radius_m: PerWheelset,
    /// Inertia that turns with each wheel, kg m².
    pub inertia_kg_m2: PerWheelset,
    /// Torque that turns each wheel forward, N m.
    pub torque_nm: PerWheelset,
    /// Torque that holds each wheel back and cannot turn it backward, N m.
    pub brake_nm: PerWheelset,
    /// Force on the body, forward positive, N.
    pub outer_n: f64,
    /// Force that opposes motion and cannot move the body backward, N.
    pub resisting_n: f64,
}

/// How a step is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrator {
    /// Contact force at the end of the step.
    Implicit,
    /// Contact force weighted 0.4 and 0.6 between start and end of the step.
    Weighted,
    /// Heun's method over substeps.
    Explicit,
}

impl Integrator {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Implicit, Self::Weighted, Self::Explicit];

    /// Name in labels.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Implicit => "implicit",
            Self::Weighted => "weighted_implicit",
            Self::Explicit => "explicit_substeps",
        }
    }

    /// Longest step that resolves slides, s.
    #[must_use]
    pub fn longest_step_s(self) -> f64 {
        match self {
            Self::Implicit => 1.5e-3,
            Self::Weighted => 2.5e-3,
            Self::Explicit => 2.5e-3,
        }
    }
}

/// What a step gave.
#[derive(Debug, Clone, Copy, Default)]
pub struct Stepped {
    /// Motion at its end.
    pub motion: Motion,
    /// Contact forces in it, forward positive, N.
    pub contact_n: PerWheelset,
    /// Acceleration in it, m/s².
    pub acceleration_m_s2: f64,
}

/// One wheelset during a step.
struct Wheel<'a> {
    wagon: &'a FamilyWagon,
    limit_n: f64,
    radius_m: f64,
    inertia_kg_m2: f64,
    torque_nm: f64,
    brake_nm: f64,
}

impl Wheel<'_> {
    /// Contact force (N) and its slope with slip velocity (N s/m).
    fn contact(&self, wheel_rad_s: f64, v_m_s: f64) -> (f64, f64) {
        let slip_m_s = self.radius_m * wheel_rad_s - v_m_s;
        self.wagon.law.force(self.limit_n, self.wagon.stiffness_n, self.wagon.tail, slip_m_s, v_m_s)
    }

    /// Wheel speed (rad/s, never negative) and mean contact force (N) after a step in which the force at the end has the
    /// weight `theta` and the wagon reaches `v_m_s`.
    fn implicit(&self, before: (f64, f64), v_m_s: f64, step_s: f64, theta: f64) -> (f64, f64) {
        let (wheel_rad_s, v_before_m_s) = before;
        let early_n = if theta < 1.0 { self.contact(wheel_rad_s, v_before_m_s).0 } else { 0.0 };
        let free_nm = self.torque_nm - self.brake_nm - (1.0 - theta) * self.radius_m * early_n;
        let gain = step_s / self.inertia_kg_m2;
        let mismatch = |at: f64| {
            let (force_n, slope) = self.contact(at, v_m_s);
            let value = at - wheel_rad_s - gain * (free_nm - theta * self.radius_m * force_n);
            (value, 1.0 + gain * theta * self.radius_m * self.radius_m * slope, force_n)
        };
        let reach = gain * theta * self.radius_m * self.limit_n;
        let middle = wheel_rad_s + gain * free_nm;
        let (mut low, mut high) = (middle - reach, middle + reach);
        if low <= 0.0 {
            // At rest the brake takes what it can.
            let (at_rest, _, rest_n) = mismatch(0.0);
            if at_rest >= 0.0 {
                return (0.0, (1.0 - theta) * early_n + theta * rest_n);
            }
            low = 0.0;
        }
        let mut at = (wheel_rad_s + (v_m_s - v_before_m_s) / self.radius_m).clamp(low, high);
        let mut force_n = 0.0;
        for _ in 0..60 {
            let (value, slope, force) = mismatch(at);
            force_n = force;
            if value > 0.0 {
                high = at
            } else {
                low = at
            }
            let newton = at - value / slope;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let moved = (next - at).abs();
            at = next;
            if moved < 1e-7 * (1.0 + at) {
                break;
            }
        }
        (at, (1.0 - theta) * early_n + theta * force_n)
    }

    /// The same by Heun's method over substeps that the stiffest slope of the contact allows.
    fn explicit(&self, before: (f64, f64), v_m_s: f64, step_s: f64) -> (f64, f64) {
        let (mut wheel_rad_s, v_before_m_s) = before;
        let slowest_m_s = v_m_s.min(v_before_m_s);
        let stiffest = self.contact(slowest_m_s / self.radius_m, slowest_m_s).1;
        let rate = stiffest * self.radius_m * self.radius_m / self.inertia_kg_m2;
        // Bounded slopes and substeps below the contact's own time: no substep leaps over the contact.
        let substeps = (rate * step_s / 0.9).ceil().max(1.0);
        let (sub_s, mut force_n) = (step_s / substeps, 0.0);
        for sub in 0..substeps as usize {
            let v_at = |share: f64| v_before_m_s + (v_m_s - v_before_m_s) * share / substeps;
            let turn = |wheel_rad_s: f64, v_m_s: f64| {
                let force = self.contact(wheel_rad_s, v_m_s).0;
                ((self.torque_nm - self.brake_nm - self.radius_m * force) / self.inertia_kg_m2, force)
            };
            let (first, first_n) = turn(wheel_rad_s, v_at(sub as f64));
            let ahead = (wheel_rad_s + sub_s * first).max(0.0);
            let (second, second_n) = turn(ahead, v_at(sub as f64 + 1.0));
            wheel_rad_s = (wheel_rad_s + 0.5 * sub_s * (first + second)).max(0.0);
            force_n += 0.5 * (first_n + second_n) / substeps;
        }
        (wheel_rad_s, force_n)
    }
}

/// One step.
#[must_use]
pub fn step(
    wagon: &FamilyWagon,
    motion: &Motion,
    action: &Action,
    acceleration_before_m_s2: f64,
    step_s: f64,
    integrator: Integrator,
) -> Stepped {
    let predicted_m_s = (motion.v_m_s + step_s * acceleration_before_m_s2).max(0.0);
    let mut stepped = Stepped::default();
    for k in 0..wagon.wheelsets {
        let wheel = Wheel {
            wagon,
            limit_n: action.load_n[k] * action.peak[k],
            radius_m: action.radius_m[k],
            inertia_kg_m2: action.inertia_kg_m2[k],
            torque_nm: action.torque_nm[k],
            brake_nm: action.brake_nm[k],
        };
        let before = (motion.wheel_speed_rad_s[k], motion.v_m_s);
        let (wheel_rad_s, force_n) = match integrator {
            Integrator::Implicit => wheel.implicit(before, predicted_m_s, step_s, 1.0),
            Integrator::Weighted => wheel.implicit(before, predicted_m_s, step_s, 0.6),
            Integrator::Explicit => wheel.explicit(before, predicted_m_s, step_s),
        };
        stepped.motion.wheel_speed_rad_s[k] = wheel_rad_s;
        stepped.contact_n[k] = force_n;
    }
    let driving_n = stepped.contact_n.iter().sum::<f64>() + action.outer_n;
    let free_m_s = motion.v_m_s + step_s * (driving_n - action.resisting_n) / action.mass_kg;
    stepped.motion.v_m_s = free_m_s.max(0.0);
    stepped.acceleration_m_s2 = (stepped.motion.v_m_s - motion.v_m_s) / step_s;
    stepped
}
