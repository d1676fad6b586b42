//! One sample of a wagon's speeds in one step: for whoever simulates the same runs thousands of times.
//!
//! Written in the slip velocity w = r ω − v each wheelset obeys a scalar equation, stiff in its own creep force alone:
//!
//! ```text
//! ẇ_i = r T_i / J_i − κ_i F_i(w_i) − (R + Σ_{j≠i} F_j) / m ,   κ_i = r² / J_i + 1/m
//! ```
//!
//! with T the torque of drive and brake and R what else acts on the body. Momentum m v + Σ J ω / r changes by outer forces
//! only, so that speeds follow from the slips without stiffness. The slips take one step of an exponential Rosenbrock
//! method (order two with one evaluation of the contact law, three with two). Where a wheelset breaks away, catches,
//! stops or starts, or a disturbance threw it off, each equation is followed in steps of its own, see [`super::guarded`]; a wagon
//! that its brakes hold at standstill needs none, see [`super::rest`].

use super::{Constants, Loading, WagonState};
use crate::adhesion::{creep_force_pair_at, initial_creep_slope_n};
use crate::resistance::{running_resistance, running_resistance_slope};
use crate::{CREEPAGE_SPEED_FLOOR_M_S, MAX_WHEELSETS, PerWheelset};
use wide::f64x2;

/// Bent creep that one step may neglect, m/s of slip.
const NEGLECTED_M_S: f64 = 2e-6;
/// Error that may stay behind the correction of bent creep, m/s of slip: about the correction's square over the change.
const UNCORRECTED_M_S: f64 = 1e-5;
/// The same for filters, whose sensors' noise is a hundred times as large.
const QUICK_UNCORRECTED_M_S: f64 = 1e-4;
/// Distance from rolling that may be left of a wheelset that has settled, m/s of slip.
pub(super) const UNSETTLED_M_S: f64 = 1e-5;
/// Speed from which nobody asks whether the wagon stands, m/s.
const STANDING_M_S: f64 = 0.1;
/// Newton steps towards the slip of rolling, and the last one's size, m/s.
const NEWTON_STEPS: usize = 6;
const CONVERGED_M_S: f64 = 1e-6;

/// The step of a wagon with up to `2 · PAIRS` wheelsets over one sample period.
#[derive(Clone, Debug)]
pub struct SampleStep<'a, const PAIRS: usize> {
    pub(super) constants: &'a Constants,
    pub(super) dt_s: f64,
    /// Mass of body and turning wheelsets, kg.
    pub(super) moving_kg: f64,
    pub(super) per_mass: f64,
    /// Bound of the second derivative of saturation over slip, by load and reference speed, N.
    bend_n: f64,
    pairs: [Pair; PAIRS],
    /// See [`SampleStep::quick`].
    pub(super) quick: bool,
}

/// Constants of two wheelsets; a place that no wheelset takes has zeros.
#[derive(Clone, Copy, Debug)]
struct Pair {
    radius: f64x2,
    per_radius: f64x2,
    /// r / J.
    by_torque: f64x2,
    /// r² / J.
    by_force: f64x2,
    /// κ and its reciprocal.
    kappa: f64x2,
    per_kappa: f64x2,
    /// J / r².
    turning_kg: f64x2,
}

/// Two wheelsets during a step.
#[derive(Clone, Copy, Debug, Default)]
struct Lanes {
    /// ω, rad/s, and w = r ω − v, m/s, at the start.
    omega: f64x2,
    slip: f64x2,
    /// Load, N, and adhesion available.
    load: f64x2,
    peak: f64x2,
    /// Contact force at the start, N, and its slope over slip, N s/m.
    force: f64x2,
    slope: f64x2,
    /// Torque of the brake, without sign, and of drive and brake, N m.
    brake: f64x2,
    torque: f64x2,
    /// ẇ at the start, m/s², its stiffness times the step, and φ₁ of that.
    rate: f64x2,
    stiff: f64x2,
    one: f64x2,
    /// Change of w over the step, m/s.
    change: f64x2,
}

fn of_pair(values: &[f64], pair: usize) -> f64x2 {
    f64x2::from([values[2 * pair], values[2 * pair + 1]])
}

impl<'a, const PAIRS: usize> SampleStep<'a, PAIRS> {
    /// The step of a wagon with these constants over samples of `dt_s`.
    pub fn new(constants: &'a Constants, dt_s: f64) -> Self {
        let count = constants.wheelsets.min(2 * PAIRS);
        let lane = |value: &dyn Fn(usize) -> f64, pair: usize| {
            let one = |i: usize| if i < count { value(i) } else { 0.0 };
            f64x2::from([one(2 * pair), one(2 * pair + 1)])
        };
        let (radius, inertia) = (&constants.wheel_radius_m, &constants.inertia_kg_m2);
        let per_mass = 1.0 / constants.mass_kg;
        let kappa = |i: usize| radius[i].powi(2) / inertia[i] + per_mass;
        let turning = |i: usize| inertia[i] / radius[i].powi(2);
        let pairs = std::array::from_fn(|pair| Pair {
            radius: lane(&|i| radius[i], pair),
            per_radius: lane(&|i| 1.0 / radius[i], pair),
            by_torque: lane(&|i| radius[i] / inertia[i], pair),
            by_force: lane(&|i| radius[i].powi(2) / inertia[i], pair),
            kappa: lane(&kappa, pair),
            per_kappa: lane(&|i| 1.0 / kappa(i), pair),
            turning_kg: lane(&turning, pair),
        });
        let contact = &constants.contact;
        // Largest second derivatives of x / (1 + x²) and of atan.
        let bend = 1.4571 * contact.k_a.powi(2) + 0.6496 * contact.k_s.powi(2);
        Self {
            constants,
            dt_s,
            moving_kg: constants.mass_kg + (0..count).map(turning).sum::<f64>(),
            per_mass,
            bend_n: (std::f64::consts::FRAC_2_PI * bend).sqrt() * contact.stiffness_n,
            pairs,
            quick: false,
        }
    }

    /// The same step for filters, which throw wheelsets off rolling at every sample by what their sensors' noise is: such a
    /// wheelset comes back to rolling in one evaluation by the chord of its creep instead of in many. It never crosses the
    /// slip of rolling, and errs by less than the noise that threw it off.
    pub fn quick(mut self) -> Self {
        self.quick = true;
        self
    }

    /// Speeds after one sample under a constant loading, and the contact forces at its start, N.
    ///
    /// `load_n` are the wheelsets' normal loads, `acceleration_m_s2` the body's acceleration as last known: it refers
    /// creepage to the speed in the middle of the sample.
    pub fn advance(
        &self,
        state: &WagonState,
        load_n: &PerWheelset,
        loading: &Loading,
        acceleration_m_s2: f64,
    ) -> (WagonState, PerWheelset) {
        let reference = (state.v_m_s + 0.5 * self.dt_s * acceleration_m_s2).max(CREEPAGE_SPEED_FLOOR_M_S);
        let mut lanes = [Lanes::default(); PAIRS];
        let rest = loading.other_n - self.resistance(state.v_m_s, loading);
        self.start(&mut lanes, state, load_n, loading, reference);
        let mut force_n = [0.0; MAX_WHEELSETS];
        for (pair, lane) in lanes.iter().enumerate() {
            force_n[2 * pair..2 * pair + 2].copy_from_slice(&lane.force.to_array());
        }
        if state.v_m_s.abs() < STANDING_M_S
            && let Some(next) = self.rest(state, load_n, loading)
        {
            return (next, force_n);
        }
        let next = (self.slide(&mut lanes, rest, reference)
            || self.settle(&mut lanes, rest, reference)
            || (self.quick && self.slide_on(&mut lanes, rest, reference)))
        .then(|| self.speeds(&lanes, state, loading, rest))
        .flatten()
        .unwrap_or_else(|| self.guarded(state, load_n, loading, acceleration_m_s2));
        (next, force_n)
    }

    pub(super) fn resistance(&self, v_m_s: f64, loading: &Loading) -> f64 {
        running_resistance(&self.constants.resistance, v_m_s, loading.wind_m_s)
    }

    /// Derivative of the resistance with respect to speed, N/(m/s).
    pub(super) fn drag(&self, v_m_s: f64, loading: &Loading) -> f64 {
        running_resistance_slope(&self.constants.resistance, v_m_s, loading.wind_m_s)
    }

    /// Slips, contact forces and torques at the start of a step.
    #[inline]
    fn start(
        &self,
        lanes: &mut [Lanes; PAIRS],
        state: &WagonState,
        load_n: &PerWheelset,
        loading: &Loading,
        reference_m_s: f64,
    ) {
        for (i, (lane, pair)) in lanes.iter_mut().zip(&self.pairs).enumerate() {
            lane.omega = of_pair(&state.wheel_speed_rad_s, i);
            lane.slip = pair.radius * lane.omega - state.v_m_s;
            (lane.load, lane.peak) = (of_pair(load_n, i), of_pair(&loading.adhesion_peak, i));
            (lane.force, lane.slope) =
                creep_force_pair_at(&self.constants.contact, lane.slip, reference_m_s, lane.load, lane.peak);
            lane.brake = of_pair(&loading.brake_torque_nm, i);
            let sign = lane.omega & f64x2::splat(-0.0);
            lane.torque = of_pair(&loading.drive_torque_nm, i) - (lane.brake | sign);
        }
    }

    /// The linear part of a step, one evaluation of the contact law: exact where creep does not bend on the way. For whoever
    /// compares two models along the same path; where a brake stops a wheelset nothing changes.
    pub fn coarse(
        &self,
        state: &WagonState,
        load_n: &PerWheelset,
        loading: &Loading,
        acceleration_m_s2: f64,
    ) -> WagonState {
        let reference = (state.v_m_s + 0.5 * self.dt_s * acceleration_m_s2).max(CREEPAGE_SPEED_FLOOR_M_S);
        let mut lanes = [Lanes::default(); PAIRS];
        let rest = loading.other_n - self.resistance(state.v_m_s, loading);
        self.start(&mut lanes, state, load_n, loading, reference);
        self.slip_on(&mut lanes, rest);
        self.speeds(&lanes, state, loading, rest).unwrap_or(*state)
    }

    /// Changes of the slips over one step; false where creep bends too much for one step.
    #[inline]
    fn slide(&self, lanes: &mut [Lanes; PAIRS], rest_n: f64, reference_m_s: f64) -> bool {
        self.slip_on(lanes, rest_n);
        let h = self.dt_s;
        let contact = &self.constants.contact;
        let sharp = self.bend_n / reference_m_s;
        let mut smooth = true;
        for (lane, pair) in lanes.iter_mut().zip(&self.pairs) {
            let limit = lane.load * lane.peak;
            let bend = (sharp + contact.friction_decay_s_per_m * limit) * lane.change;
            let neglected = 0.5 * h * pair.kappa * lane.one * bend * bend;
            smooth &= neglected.simd_le(limit * NEGLECTED_M_S).all();
        }
        smooth || (!self.quick && self.correct(lanes, reference_m_s))
    }

    /// Corrected changes of the slips of wheelsets that do not come to rest in rolling; false where creep bends too much.
    #[inline]
    fn slide_on(&self, lanes: &mut [Lanes; PAIRS], rest_n: f64, reference_m_s: f64) -> bool {
        self.slip_on(lanes, rest_n);
        self.correct(lanes, reference_m_s)
    }

    /// Changes of the slips over one step with creep as steep as at its start.
    #[inline]
    fn slip_on(&self, lanes: &mut [Lanes; PAIRS], rest_n: f64) {
        let h = self.dt_s;
        let force: f64 = lanes.iter().map(|lane| lane.force.reduce_add()).sum();
        let total = (force + rest_n) * self.per_mass;
        // What the contact forces fall short of their start, on average over the step.
        let mut short = 0.0;
        for (lane, pair) in lanes.iter_mut().zip(&self.pairs) {
            lane.rate = pair.by_torque * lane.torque - pair.by_force * lane.force - total;
            lane.stiff = pair.kappa * lane.slope * h;
            lane.one = first_weight(lane.stiff);
            lane.change = lane.rate * (f64x2::ONE - lane.one) * pair.per_kappa;
            short += lane.change.reduce_add();
        }
        for lane in lanes.iter_mut() {
            let others = (short - lane.change) * self.per_mass;
            lane.change = lane.one * h * (lane.rate - others);
        }
    }

    /// The correction of order three; false where it does not suffice.
    fn correct(&self, lanes: &mut [Lanes; PAIRS], reference_m_s: f64) -> bool {
        let h = self.dt_s;
        let uncorrected = if self.quick { QUICK_UNCORRECTED_M_S } else { UNCORRECTED_M_S };
        let mut small = true;
        for (lane, pair) in lanes.iter_mut().zip(&self.pairs) {
            let slip = lane.slip + lane.change;
            let contact = &self.constants.contact;
            let (ahead, _) = creep_force_pair_at(contact, slip, reference_m_s, lane.load, lane.peak);
            let bent = ahead - lane.force - lane.slope * lane.change;
            let correction = third_weight(lane.stiff, lane.one) * (-2.0 * h) * pair.kappa * bent;
            let allowed = lane.change.abs().max(f64x2::splat(uncorrected)) * uncorrected;
            small &= (correction * correction).simd_le(allowed).all();
            lane.change += correction;
        }
        small
    }

    /// Lets every wheelset roll at the end of the step; false where one may not have settled by then.
    ///
    /// Creep force rises ever more slowly with slip, so that Newton's method from zero slip comes to the slip of rolling
    /// from below and never crosses it, and so that on the way there a slip decays at least as fast as its first rate
    /// or the slope of creep at its end says.
    fn settle(&self, lanes: &mut [Lanes; PAIRS], rest_n: f64, reference_m_s: f64) -> bool {
        let contact = &self.constants.contact;
        let pull: f64 = lanes
            .iter()
            .zip(&self.pairs)
            .map(|(lane, pair)| (lane.torque * pair.per_radius).reduce_add())
            .sum();
        let acceleration = (pull + rest_n) / self.moving_kg;
        let initial = initial_creep_slope_n(contact) / reference_m_s;
        let mut settled = true;
        for (lane, pair) in lanes.iter_mut().zip(&self.pairs) {
            let target = lane.torque * pair.per_radius - pair.turning_kg * acceleration;
            let mut slip = target / initial;
            let (mut last, mut slope) = (f64x2::ZERO, f64x2::ZERO);
            for _ in 0..NEWTON_STEPS {
                let force;
                (force, slope) = creep_force_pair_at(contact, slip, reference_m_s, lane.load, lane.peak);
                last = (target - force) / slope;
                slip += last;
                if last.abs().simd_lt(f64x2::splat(CONVERGED_M_S)).all() {
                    break;
                }
            }
            let distance = slip - lane.slip;
            let rate = pair.by_force * (target - lane.force);
            // A place without a wheelset has no force and settles at once.
            let decay = (rate / distance).min(pair.by_force * slope) * self.dt_s;
            let left = distance.abs() * (-decay.min(f64x2::splat(500.0))).exp();
            let found = last.abs().simd_lt(f64x2::splat(CONVERGED_M_S));
            let fine = if self.quick { found } else { found & left.simd_lt(f64x2::splat(UNSETTLED_M_S)) };
            let none = pair.radius.simd_eq(f64x2::ZERO);
            settled &= (fine | none).all();
            let back = if self.quick {
                let chord = (rate / distance * self.dt_s).fast_max(f64x2::ZERO).fast_min(f64x2::splat(500.0));
                let near = distance.abs().simd_lt(f64x2::splat(CONVERGED_M_S));
                near.bitselect(distance, distance * (f64x2::ONE - (-chord).exp()))
            } else {
                distance
            };
            lane.change = none.bitselect(f64x2::ZERO, back);
        }
        settled
    }

    /// Speeds after the slips have changed; `None` where a brake stops its wheelset or held it from the start.
    #[inline]
    fn speeds(
        &self,
        lanes: &[Lanes; PAIRS],
        state: &WagonState,
        loading: &Loading,
        rest_n: f64,
    ) -> Option<WagonState> {
        let h = self.dt_s;
        let (mut pull, mut lag) = (f64x2::ZERO, f64x2::ZERO);
        for (lane, pair) in lanes.iter().zip(&self.pairs) {
            pull += lane.torque * pair.per_radius;
            lag += pair.turning_kg * lane.change;
        }
        let moving = self.moving_kg + 0.5 * h * self.drag(state.v_m_s, loading);
        let change = (h * (pull.reduce_add() + rest_n) - lag.reduce_add()) / moving;
        let mut next = WagonState { v_m_s: state.v_m_s + change, ..WagonState::default() };
        let mut turning = true;
        for (i, (lane, pair)) in lanes.iter().zip(&self.pairs).enumerate() {
            let omega = lane.omega + (lane.change + change) * pair.per_radius;
            turning &= ((omega * lane.omega).simd_gt(f64x2::ZERO) | lane.brake.simd_eq(f64x2::ZERO)).all();
            next.wheel_speed_rad_s[2 * i..2 * i + 2].copy_from_slice(&omega.to_array());
        }
        turning.then_some(next)
    }
}

/// φ₁(−z) = (1 − e^−z) / z.
#[inline]
fn first_weight(z: f64x2) -> f64x2 {
    let exact = (f64x2::ONE - (-z.fast_min(f64x2::splat(500.0))).exp()) / z;
    let near = f64x2::ONE - z * (0.5 - z * (1.0 / 6.0));
    z.abs().simd_lt(f64x2::splat(1e-4)).bitselect(near, exact)
}

/// φ₃(−z), where `one` is φ₁(−z).
#[inline]
fn third_weight(z: f64x2, one: f64x2) -> f64x2 {
    let exact = (0.5 - (f64x2::ONE - one) / z) / z;
    let near = f64x2::splat(1.0 / 6.0) - z * (1.0 / 24.0 - z * (1.0 / 120.0 - z * (1.0 / 720.0)));
    z.abs().simd_lt(f64x2::splat(0.1)).bitselect(near, exact)
}
