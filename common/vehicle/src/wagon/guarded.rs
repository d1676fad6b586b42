//! The part of a sample step that takes no risk: for wheelsets that break away, catch, stop or start.
//!
//! Every wheelset's slip follows its own equation in steps of its own, with the mean force of the others; where brakes
//! hold wheelsets still, the body's speed does so too (it is stiff in their creep near standstill). A stretch ends where
//! a brake stops a wheelset.

use super::flow::{self, Rate, Reached};
use super::sample_step::SampleStep;
use super::{Loading, WagonState};
use crate::adhesion::{ContactForce, creep_force_at};
use crate::{CREEPAGE_SPEED_FLOOR_M_S, MAX_WHEELSETS, PerWheelset};

/// Error of one step of one equation, m/s.
const TOLERANCE_M_S: f64 = 2e-5;
/// The same for filters, whose sensors' noise is a hundred times as large.
const QUICK_TOLERANCE_M_S: f64 = 2e-4;
/// What the mean forces may change of the body's speed from one sweep over the wheelsets to the next, m/s.
const DISAGREEMENT_M_S: f64 = 1e-4;
/// Sweeps over the wheelsets until their mean forces agree.
const SWEEPS: usize = 4;

/// Longest stretch, s: the mean forces of the others stand for their course.
const LONGEST_S: f64 = 0.01;
/// The same for filters, s.
const QUICK_LONGEST_S: f64 = 0.02;
/// A wheelset that its brake stops within this share of a stretch counts as standing from its start.
const AT_ONCE: f64 = 0.02;

/// A stretch of a sample over which no wheelset stops or starts.
struct Stretch<'a> {
    from: &'a WagonState,
    load_n: &'a PerWheelset,
    loading: &'a Loading,
    span_s: f64,
    /// Speed that creepage is referred to, m/s.
    reference_m_s: f64,
    /// Force on the body beside contact at its start, N.
    rest_n: f64,
    wheels: [Wheel; MAX_WHEELSETS],
}

/// One wheelset over a stretch.
#[derive(Clone, Copy, Debug, Default)]
struct Wheel {
    /// The brake holds it still.
    held: bool,
    /// Sense in which it turns or starts to turn.
    sense: f64,
    /// Torque of drive and brake, N m.
    torque_nm: f64,
    /// r ω − v at the start, m/s, and its change.
    slip_m_s: f64,
    change_m_s: f64,
    /// Rate of the slip at the start, m/s².
    rate_m_s2: f64,
    /// Mean contact force, N: a guess, until the wheelset has been followed.
    mean_n: f64,
}

/// A brake stops a wheelset.
struct Stop {
    wheelset: usize,
    after_s: f64,
}

impl<const PAIRS: usize> SampleStep<'_, PAIRS> {
    /// Speeds after one sample, see [`SampleStep::advance`].
    #[cold]
    pub(super) fn guarded(
        &self,
        state: &WagonState,
        load_n: &PerWheelset,
        loading: &Loading,
        acceleration_m_s2: f64,
    ) -> WagonState {
        let (mut now, mut left_s) = (*state, self.dt_s);
        // Each wheelset may stop once; more stretches would be chatter.
        let mut stops = MAX_WHEELSETS;
        let longest_s = if self.quick { QUICK_LONGEST_S } else { LONGEST_S };
        while left_s > 1e-9 * self.dt_s {
            let span_s = left_s / (left_s / longest_s - 1e-9).ceil().max(1.0);
            self.stop_at_once(&mut now, load_n, loading, span_s);
            let stretch = self.stretch(&now, load_n, loading, span_s, acceleration_m_s2);
            let used_s = match self.pass(stretch, None) {
                Ok(next) => {
                    now = next;
                    span_s
                }
                Err(stop) => {
                    let used_s = if stops > 0 { stop.after_s } else { span_s };
                    let part = self.stretch(&now, load_n, loading, used_s, acceleration_m_s2);
                    now = self.pass(part, Some(stop.wheelset)).unwrap_or(now);
                    stops = stops.saturating_sub(1);
                    used_s
                }
            };
            left_s -= used_s;
        }
        now
    }

    /// Stops wheelsets that their brakes stop in next to no time and then hold.
    fn stop_at_once(&self, now: &mut WagonState, load_n: &PerWheelset, loading: &Loading, span_s: f64) {
        let reference_m_s = now.v_m_s.max(CREEPAGE_SPEED_FLOOR_M_S);
        for i in 0..self.constants.wheelsets {
            let omega = now.wheel_speed_rad_s[i];
            let needed_nm = self.constants.inertia_kg_m2[i] * omega.abs() / (AT_ONCE * span_s);
            let mut spare_nm = loading.brake_torque_nm[i] - loading.drive_torque_nm[i].abs();
            if omega != 0.0 && spare_nm > needed_nm {
                let (contact, peak) = (&self.constants.contact, loading.adhesion_peak[i]);
                let standing = creep_force_at(contact, -now.v_m_s, reference_m_s, load_n[i], peak);
                spare_nm -= self.constants.wheel_radius_m[i] * standing.force_n.abs();
                if spare_nm > needed_nm {
                    now.wheel_speed_rad_s[i] = 0.0;
                }
            }
        }
    }

    /// A stretch, with guesses of the mean forces.
    fn stretch<'a>(
        &self,
        from: &'a WagonState,
        load_n: &'a PerWheelset,
        loading: &'a Loading,
        span_s: f64,
        acceleration_m_s2: f64,
    ) -> Stretch<'a> {
        let reference_m_s = (from.v_m_s + 0.5 * span_s * acceleration_m_s2).max(CREEPAGE_SPEED_FLOOR_M_S);
        let rest_n = loading.other_n - self.resistance(from.v_m_s, loading);
        let mut wheels = [Wheel::default(); MAX_WHEELSETS];
        for (i, wheel) in wheels.iter_mut().enumerate().take(self.constants.wheelsets) {
            let (radius, inertia) = (self.constants.wheel_radius_m[i], self.constants.inertia_kg_m2[i]);
            let (omega, brake) = (from.wheel_speed_rad_s[i], loading.brake_torque_nm[i]);
            let slip = radius * omega - from.v_m_s;
            let peak = loading.adhesion_peak[i];
            let limit = (load_n[i] * peak).max(0.0);
            let contact = creep_force_at(&self.constants.contact, slip, reference_m_s, load_n[i], peak);
            let free = loading.drive_torque_nm[i] - radius * contact.force_n;
            wheel.sense = if omega == 0.0 { free.signum() } else { omega.signum() };
            wheel.held = omega == 0.0 && free.abs() <= brake;
            wheel.torque_nm = loading.drive_torque_nm[i] - brake * wheel.sense;
            wheel.slip_m_s = slip;
            wheel.rate_m_s2 = (wheel.torque_nm - radius * contact.force_n) * radius / inertia;
            let rolling = (wheel.torque_nm / radius).clamp(-limit, limit);
            let stiff = radius * radius / inertia * contact.slope_n_s_per_m * span_s;
            wheel.mean_n = if wheel.held {
                contact.force_n
            } else if stiff > 1.0 {
                (rolling + inertia / (radius * radius) * slip / span_s).clamp(-limit, limit)
            } else {
                // A slide that ends gives way to rolling after the time to lose it.
                let until_rolling = -slip / (wheel.rate_m_s2 * span_s);
                let sliding = if until_rolling > 0.0 { until_rolling.min(1.0) } else { 1.0 };
                sliding * contact.force_n + (1.0 - sliding) * rolling
            };
        }
        Stretch { from, load_n, loading, span_s, reference_m_s, rest_n, wheels }
    }

    /// Speeds after a stretch, at whose end `stopping` comes to rest.
    ///
    /// # Errors
    /// Another brake stops its wheelset before.
    fn pass(&self, mut stretch: Stretch, stopping: Option<usize>) -> Result<WagonState, Stop> {
        let (count, span) = (self.constants.wheelsets, stretch.span_s);
        let any_held = stretch.wheels[..count].iter().any(|wheel| wheel.held);
        let mut used = stretch.wheels;
        let (mut body_change, mut stop) = (0.0, None);
        for _ in 0..SWEEPS {
            used = stretch.wheels;
            body_change = self.body(&stretch, any_held);
            stop = self.sweep(&mut stretch, stopping, any_held, body_change);
            let moved: f64 = (0..count).map(|i| (stretch.wheels[i].mean_n - used[i].mean_n).abs()).sum();
            if moved * span * self.per_mass < DISAGREEMENT_M_S {
                break;
            }
        }
        match stop {
            Some(stop) if stopping.is_none() => Err(stop),
            _ => Ok(self.end(&stretch, stopping, any_held, body_change, &used.map(|wheel| wheel.mean_n))),
        }
    }

    /// Follows all wheelsets once, each with the mean forces of the others as last known; tells the first that stops.
    fn sweep(
        &self,
        stretch: &mut Stretch,
        stopping: Option<usize>,
        any_held: bool,
        body_change: f64,
    ) -> Option<Stop> {
        let span = stretch.span_s;
        let mut stop: Option<Stop> = None;
        for i in (0..self.constants.wheelsets).filter(|i| Some(*i) != stopping) {
            if stretch.wheels[i].held {
                continue;
            }
            let Reached { x, elapsed_s } = self.wheelset(i, stretch, any_held, body_change / span);
            if elapsed_s < stop.as_ref().map_or(span, |stop| stop.after_s) {
                stop = Some(Stop { wheelset: i, after_s: elapsed_s.max(1e-6 * span) });
            }
            let (radius, inertia) = (self.constants.wheel_radius_m[i], self.constants.inertia_kg_m2[i]);
            let wheel = &mut stretch.wheels[i];
            wheel.change_m_s = x - wheel.slip_m_s;
            let rim_change = wheel.change_m_s + body_change * elapsed_s / span;
            wheel.mean_n =
                (wheel.torque_nm - inertia / radius * rim_change / elapsed_s.max(1e-3 * span)) / radius;
        }
        stop
    }

    /// Change of the body's speed under the guessed mean forces, m/s.
    fn body(&self, stretch: &Stretch, any_held: bool) -> f64 {
        let wheels = &stretch.wheels[..self.constants.wheelsets];
        let start = stretch.from.v_m_s;
        let mean_n = |held: bool| -> f64 { wheels.iter().filter(|w| w.held == held).map(|w| w.mean_n).sum() };
        if !any_held {
            return stretch.span_s * (stretch.rest_n + mean_n(false)) * self.per_mass;
        }
        let pull = stretch.loading.other_n + mean_n(false);
        let rate_at = |v: f64| {
            let mut force = pull - self.resistance(v, stretch.loading);
            let mut slope = self.drag(v, stretch.loading);
            for i in (0..wheels.len()).filter(|i| wheels[*i].held) {
                let contact = self.contact(stretch, i, -v, v.max(CREEPAGE_SPEED_FLOOR_M_S));
                force += contact.force_n;
                slope += contact.slope_n_s_per_m;
            }
            Rate { value: force * self.per_mass, slope: -slope * self.per_mass }
        };
        flow::follow(start, stretch.span_s, stretch.span_s, self.tolerance_m_s(), rate_at, |_, _| 1.0).x
            - start
    }

    /// Error that one step of one equation may make, m/s.
    fn tolerance_m_s(&self) -> f64 {
        if self.quick { QUICK_TOLERANCE_M_S } else { TOLERANCE_M_S }
    }

    fn contact(&self, stretch: &Stretch, i: usize, slip_m_s: f64, reference_m_s: f64) -> ContactForce {
        let (load_n, peak) = (stretch.load_n[i], stretch.loading.adhesion_peak[i]);
        creep_force_at(&self.constants.contact, slip_m_s, reference_m_s, load_n, peak)
    }

    /// Follows the slip of one wheelset.
    fn wheelset(&self, i: usize, stretch: &Stretch, any_held: bool, acceleration_m_s2: f64) -> Reached {
        let (radius, inertia) = (self.constants.wheel_radius_m[i], self.constants.inertia_kg_m2[i]);
        let wheel = &stretch.wheels[i];
        let by_force = radius * radius / inertia;
        // The body yields to this wheelset's own force too, unless other wheelsets are held.
        let (kappa, drift) = if any_held {
            (by_force, acceleration_m_s2)
        } else {
            let all: f64 = stretch.wheels.iter().map(|w| w.mean_n).sum();
            (by_force + self.per_mass, (stretch.rest_n + all - wheel.mean_n) * self.per_mass)
        };
        let pull = radius * wheel.torque_nm / inertia - drift;
        let rate_at = |slip: f64| {
            let contact = self.contact(stretch, i, slip, stretch.reference_m_s);
            Rate { value: pull - kappa * contact.force_n, slope: -kappa * contact.slope_n_s_per_m }
        };
        let stops = stretch.from.wheel_speed_rad_s[i] != 0.0 && stretch.loading.brake_torque_nm[i] > 0.0;
        let clear = |slip: f64, t: f64| {
            if stops { wheel.sense * (slip + stretch.from.v_m_s + acceleration_m_s2 * t) } else { 1.0 }
        };
        // A slide that ends is steep at its end.
        let until_rolling = -wheel.slip_m_s / wheel.rate_m_s2;
        let first = if until_rolling > 0.0 { until_rolling.min(stretch.span_s) } else { stretch.span_s };
        flow::follow(wheel.slip_m_s, stretch.span_s, first, self.tolerance_m_s(), rate_at, clear)
    }

    /// Speeds from slips by the balance of momentum.
    fn end(
        &self,
        stretch: &Stretch,
        stopping: Option<usize>,
        any_held: bool,
        body_change: f64,
        guessed_n: &PerWheelset,
    ) -> WagonState {
        let (constants, span) = (&self.constants, stretch.span_s);
        let drag = if any_held { 0.0 } else { 0.5 * span * self.drag(stretch.from.v_m_s, stretch.loading) };
        let (mut moving_kg, mut momentum) = (constants.mass_kg + drag, constants.mass_kg * body_change);
        for i in (0..constants.wheelsets).filter(|i| !stretch.wheels[*i].held) {
            let (wheel, radius) = (&stretch.wheels[i], constants.wheel_radius_m[i]);
            let turning_kg = constants.inertia_kg_m2[i] / (radius * radius);
            momentum += span * (wheel.torque_nm / radius - guessed_n[i]);
            if Some(i) == stopping {
                momentum += turning_kg * radius * stretch.from.wheel_speed_rad_s[i];
            } else {
                momentum -= turning_kg * wheel.change_m_s;
                moving_kg += turning_kg;
            }
        }
        let mut next = WagonState { v_m_s: stretch.from.v_m_s + momentum / moving_kg, ..*stretch.from };
        for i in (0..constants.wheelsets).filter(|i| !stretch.wheels[*i].held) {
            let wheel = &stretch.wheels[i];
            let omega = (wheel.slip_m_s + wheel.change_m_s + next.v_m_s) / constants.wheel_radius_m[i];
            let turned = omega * wheel.sense < 0.0 && stretch.loading.brake_torque_nm[i] > 0.0;
            next.wheel_speed_rad_s[i] = if Some(i) == stopping || turned { 0.0 } else { omega };
        }
        next
    }
}
