//! Motion of the whole train, one linearly implicit step for all of it.
//!
//! Unknown are the change of speed of every wagon and of every wheelset. Contact and pad friction are taken at the end
//! of the step (backward Euler; each wheelset is first brought near it, so that stiff creep neither rings nor slides
//! falsely), couplers at its middle (they keep
//! their energy). Wheelsets are eliminated wagon by wagon, wagons by a tridiagonal sweep: internal forces cancel to the
//! last digit, whatever the step.

use super::{
    contact::{Contact, CreepLaw},
    coupler::{DrawGear, Pull},
    pitch::{Pitch, Push},
    units::{GRAVITY_M_S2, PerWheelset},
};

/// Wheel speed below which pad friction turns into holding, rad/s.
const HOLDING_RAD_S: f64 = 0.02;
/// Speed below which running resistance fades, m/s.
const REST_M_S: f64 = 0.02;
/// A wheelset is linearised so near the end of the step: share of the strain at which the contact begins to give.
const STRAIN_TOLERANCE: f64 = 0.05;
/// Longest search for it; bisection alone would need no more.
const MOST_SEARCHES: usize = 40;

/// One wagon as a body: constants, state, what acts on it, and what came of the last step.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    pub(crate) wheelsets: usize,
    pub(crate) mass_kg: f64,
    pub(crate) radius_m: PerWheelset,
    pub(crate) inertia_kg_m2: PerWheelset,
    /// Running resistance: N, N s/m, N s²/m².
    pub(crate) resistance: [f64; 3],
    pub(crate) law: CreepLaw,
    pub(crate) pitch: Pitch,
    // State.
    pub(crate) v_m_s: f64,
    pub(crate) position_m: f64,
    pub(crate) wheel_speed_rad_s: PerWheelset,
    pub(crate) load_n: PerWheelset,
    // What acts during the step.
    pub(crate) drive_nm: PerWheelset,
    /// Torque that the pads can exert, N m.
    pub(crate) brake_nm: PerWheelset,
    pub(crate) friction: PerWheelset,
    pub(crate) stiffness_n: PerWheelset,
    pub(crate) slope_rad: f64,
    /// Resistance of the curve, N per N of weight.
    pub(crate) curve: f64,
    pub(crate) headwind_m_s: f64,
    // What came of it.
    pub(crate) contact_n: PerWheelset,
    pub(crate) braked_nm: PerWheelset,
    pub(crate) outer_n: f64,
    pub(crate) acceleration_m_s2: f64,
    /// Change of wheel speed in the last step, rad/s; where the next search begins.
    pub(crate) turn_rad_s: PerWheelset,
}

/// The part of a wagon's equation that is left when its wheelsets are eliminated.
#[derive(Debug, Clone, Copy, Default)]
struct Reduced {
    mass_over_step: f64,
    force_n: f64,
    wheel: [Wheel; 4],
}

#[derive(Debug, Clone, Copy, Default)]
struct Wheel {
    /// Wheel speed that it is linearised at, rad/s.
    at: f64,
    contact_n: f64,
    contact_slope: f64,
    brake_slope: f64,
    brake_nm: f64,
    /// What is left unbalanced there, N m.
    torque_nm: f64,
    stiffness: f64,
}

impl Body {
    /// Slip velocity `r ω − v` of a wheelset, m/s.
    pub(crate) fn slip_m_s(&self, wheelset: usize) -> f64 {
        self.radius_m[wheelset] * self.wheel_speed_rad_s[wheelset] - self.v_m_s
    }

    /// Resistance of running, wind, curve and grade, forward positive, N.
    fn outer_n(&self) -> f64 {
        let [constant, linear, drag] = self.resistance;
        let v = self.v_m_s;
        let moving = v / (v * v + REST_M_S * REST_M_S).sqrt();
        let weight_n = self.mass_kg * GRAVITY_M_S2;
        let air_m_s = v + self.headwind_m_s;
        -moving * (constant + linear * v.abs() + self.curve * weight_n)
            - drag * air_m_s * air_m_s.abs()
            - weight_n * self.slope_rad.sin()
    }

    fn reduce(&mut self, step_s: f64) -> Reduced {
        self.outer_n = self.outer_n();
        let mut reduced = Reduced {
            mass_over_step: self.mass_kg / step_s,
            force_n: self.outer_n,
            wheel: [Wheel::default(); 4],
        };
        for k in 0..self.wheelsets {
            let radius = self.radius_m[k];
            let wheel = self.wheel(k, step_s);
            let slope = wheel.contact_slope;
            reduced.force_n += wheel.contact_n + slope * radius * wheel.torque_nm / wheel.stiffness;
            reduced.mass_over_step += slope * (1.0 - slope * radius * radius / wheel.stiffness);
            reduced.wheel[k] = wheel;
        }
        reduced
    }

    /// One wheelset linearised near the end of the step, with the wagon's speed held. What it balances grows with wheel
    /// speed throughout, so that there is one end of the step and a bracketed Newton search finds it: no false slide.
    fn wheel(&self, k: usize, step_s: f64) -> Wheel {
        let omega = self.wheel_speed_rad_s[k];
        let radius = self.radius_m[k];
        let limit_n = (self.load_n[k] * self.friction[k]).max(1.0);
        let most =
            step_s / self.inertia_kg_m2[k] * (self.drive_nm[k].abs() + self.brake_nm[k] + radius * limit_n);
        let (mut low, mut high) = (omega - most, omega + most);
        let mut at = (omega + self.turn_rad_s[k]).clamp(low, high);
        let mut wheel = self.balance(k, at, step_s);
        let strain_per_rad_s =
            radius * self.stiffness_n[k] / ((self.v_m_s * self.v_m_s + 0.1).sqrt() * limit_n);
        let mut before = f64::INFINITY;
        for _ in 0..MOST_SEARCHES {
            let newton = wheel.torque_nm / wheel.stiffness;
            let holding = newton.abs() < 0.2 * HOLDING_RAD_S || at.abs() > 20.0 * HOLDING_RAD_S;
            if newton.abs() * strain_per_rad_s < STRAIN_TOLERANCE && holding {
                break;
            }
            if wheel.torque_nm > 0.0 {
                low = at
            } else {
                high = at
            }
            // Newton's method can swing from one side of a saturating force to the other; then halves do it.
            let next = at + newton;
            let converges = (low..=high).contains(&next) && newton.abs() < 0.5 * before;
            at = if converges { next } else { 0.5 * (low + high) };
            before = newton.abs();
            wheel = self.balance(k, at, step_s);
        }
        wheel
    }

    /// What acts on a wheelset that turns at `at` at the end of the step.
    #[inline]
    fn balance(&self, k: usize, at: f64, step_s: f64) -> Wheel {
        let radius = self.radius_m[k];
        let contact =
            Contact { load_n: self.load_n[k], friction: self.friction[k], stiffness_n: self.stiffness_n[k] };
        let (contact_n, contact_slope) = self.law.force(&contact, radius * at - self.v_m_s, self.v_m_s);
        let root = (at * at + HOLDING_RAD_S * HOLDING_RAD_S).sqrt();
        let brake_nm = self.brake_nm[k] * at / root;
        let brake_slope = self.brake_nm[k] * HOLDING_RAD_S * HOLDING_RAD_S / (root * root * root);
        let inertia = self.inertia_kg_m2[k] / step_s;
        let stiffness = inertia + brake_slope + contact_slope * radius * radius;
        let spun_nm = inertia * (at - self.wheel_speed_rad_s[k]);
        let torque_nm = self.drive_nm[k] - brake_nm - radius * contact_n - spun_nm;
        Wheel { at, contact_n, contact_slope, brake_slope, brake_nm, torque_nm, stiffness }
    }

    fn complete(&mut self, reduced: &Reduced, change_m_s: f64, coupler_n: f64, step_s: f64) {
        let mut spin_nm = [0.0; 4];
        for k in 0..self.wheelsets {
            let wheel = &reduced.wheel[k];
            let radius = self.radius_m[k];
            let more = (wheel.torque_nm + wheel.contact_slope * radius * change_m_s) / wheel.stiffness;
            self.contact_n[k] = wheel.contact_n + wheel.contact_slope * (radius * more - change_m_s);
            self.braked_nm[k] = wheel.brake_nm + wheel.brake_slope * more;
            self.turn_rad_s[k] = wheel.at + more - self.wheel_speed_rad_s[k];
            spin_nm[k] = self.inertia_kg_m2[k] * self.turn_rad_s[k] / step_s;
            self.wheel_speed_rad_s[k] = wheel.at + more;
        }
        self.acceleration_m_s2 = change_m_s / step_s;
        self.position_m += step_s * (self.v_m_s + 0.5 * change_m_s);
        self.v_m_s += change_m_s;
        let push = Push {
            contact_n: &self.contact_n,
            coupler_n,
            acceleration_m_s2: self.acceleration_m_s2,
            spin_nm: &spin_nm,
        };
        self.load_n = self.pitch.advance(&push, step_s);
    }
}

/// The coupler behind a wagon.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coupler {
    pub(crate) gear: DrawGear,
    /// Extension from mid slack, m.
    pub(crate) extension_m: f64,
    /// Force of the last step, tension positive, N.
    pub(crate) force_n: f64,
}

/// A train in motion; coupler `i` joins body `i` to body `i + 1`.
#[derive(Debug, Clone)]
pub(crate) struct Motion {
    pub(crate) bodies: Vec<Body>,
    pub(crate) couplers: Vec<Coupler>,
    reduced: Vec<Reduced>,
    pulls: Vec<Pull>,
    sweep: Vec<(f64, f64)>,
    change_m_s: Vec<f64>,
}

impl Motion {
    pub(crate) fn new(bodies: Vec<Body>, couplers: Vec<Coupler>) -> Self {
        let count = bodies.len();
        Self {
            bodies,
            couplers,
            reduced: vec![Reduced::default(); count],
            pulls: vec![Pull::default(); count.saturating_sub(1)],
            sweep: vec![(0.0, 0.0); count],
            change_m_s: vec![0.0; count],
        }
    }

    /// Advances by `step_s`.
    pub(crate) fn step(&mut self, step_s: f64) {
        for (body, reduced) in self.bodies.iter_mut().zip(&mut self.reduced) {
            *reduced = body.reduce(step_s);
        }
        for (i, pull) in self.pulls.iter_mut().enumerate() {
            let rate_m_s = self.bodies[i].v_m_s - self.bodies[i + 1].v_m_s;
            *pull = self.couplers[i].gear.pull(self.couplers[i].extension_m, rate_m_s);
            // At the middle of the step, before speeds change.
            pull.force_n += 0.5 * step_s * pull.stiffness * rate_m_s;
            pull.damping = 0.25 * step_s * pull.stiffness + 0.5 * pull.damping;
        }
        self.solve();
        let mut behind_n = 0.0;
        for i in 0..self.bodies.len() {
            let ahead_n = behind_n;
            behind_n = match self.couplers.get_mut(i) {
                None => 0.0,
                Some(coupler) => {
                    let relative = self.change_m_s[i] - self.change_m_s[i + 1];
                    coupler.force_n = self.pulls[i].force_n + self.pulls[i].damping * relative;
                    let rate_m_s = self.bodies[i].v_m_s - self.bodies[i + 1].v_m_s;
                    coupler.extension_m += step_s * (rate_m_s + 0.5 * relative);
                    coupler.force_n
                }
            };
            // The body behind still has its old speed here, as the line above needs.
            let change_m_s = self.change_m_s[i];
            self.bodies[i].complete(&self.reduced[i], change_m_s, ahead_n - behind_n, step_s);
        }
    }

    /// Solves for the change of speed of every wagon (Thomas' algorithm).
    fn solve(&mut self) {
        let count = self.bodies.len();
        let tie = |i: usize| self.pulls.get(i).map_or(0.0, |pull| pull.damping);
        let pull = |i: usize| self.pulls.get(i).map_or(0.0, |pull| pull.force_n);
        for i in 0..count {
            let (tie_ahead, pull_ahead) = if i == 0 { (0.0, 0.0) } else { (tie(i - 1), pull(i - 1)) };
            let (above, right_above) = if i == 0 { (0.0, 0.0) } else { self.sweep[i - 1] };
            let pivot = self.reduced[i].mass_over_step + tie_ahead * (1.0 - above) + tie(i);
            let right = self.reduced[i].force_n + pull_ahead - pull(i) + tie_ahead * right_above;
            self.sweep[i] = (tie(i) / pivot, right / pivot);
        }
        for i in (0..count).rev() {
            let next = if i + 1 < count { self.change_m_s[i + 1] } else { 0.0 };
            self.change_m_s[i] = self.sweep[i].1 + self.sweep[i].0 * next;
        }
    }
}
