//! A stiff scalar equation `ẋ = f(x)` over a given time, in steps that follow its error.
//!
//! Exponential Rosenbrock method of order three (exprb32 of Hochbruck & Ostermann, Exponential integrators, Acta
//! Numerica 19 (2010)): the linear part is exact however stiff, and what the correction changes is the error of the
//! step. A step that is carried across a stable point by saturated creep force meets another slope there, so that its
//! correction is as large as the step itself and it is taken again, shorter: the equation's own flow never crosses,
//! and neither does this one by more than the tolerance.

/// Value and derivative of `f`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rate {
    pub(super) value: f64,
    pub(super) slope: f64,
}

/// Where a flow got to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    pub(super) x: f64,
    /// Less than the whole span where the flow met its end.
    pub(super) elapsed_s: f64,
}

/// Steps after which the tolerance grows, so that an equation of no sense ends as well.
const PATIENCE: i32 = 48;
/// Refinements of the time at which the flow meets its end.
const REFINEMENTS: usize = 4;

/// Follows the flow from `start` for `span_s`, or until `clear(x, t)` falls below zero; `first_s` is a guess of the
/// first step, `tolerance` bounds the error of one step.
pub(super) fn follow(
    start: f64,
    span_s: f64,
    first_s: f64,
    tolerance: f64,
    rate_at: impl Fn(f64) -> Rate,
    clear: impl Fn(f64, f64) -> f64,
) -> Reached {
    let (mut x, mut t, mut step, mut refined) = (start, 0.0, first_s, 0);
    let mut rate = rate_at(x);
    for count in 0..4 * PATIENCE {
        step = f64::min(step, span_s - t);
        let (one, three) = weights(-rate.slope * step);
        let change = step * one * rate.value;
        let ahead = rate_at(x + change);
        let correction = 2.0 * step * three * (ahead.value - rate.value - rate.slope * change);
        // What the correction leaves is about its square over the change.
        let allowed = tolerance * f64::from((count - PATIENCE).max(0)).exp2();
        let error = correction * correction / (allowed * change.abs().max(allowed));
        if error > 1.0 {
            step *= (0.9 * error.sqrt().sqrt().recip()).max(0.1);
            continue;
        }
        let next = x + change + correction;
        let room = clear(next, t + step);
        if room < 0.0 {
            let before = clear(x, t);
            let share = before / (before - room);
            if refined == REFINEMENTS || room > -tolerance {
                return Reached { x: x + share * (next - x), elapsed_s: t + share * step };
            }
            refined += 1;
            step *= share;
            continue;
        }
        (x, t) = (next, t + step);
        if t >= span_s || t.is_nan() {
            break;
        }
        rate = rate_at(x);
        step *= (0.9 * error.sqrt().sqrt().recip()).clamp(0.5, 8.0);
    }
    Reached { x, elapsed_s: span_s }
}

/// The functions φ₁ and φ₃ of exponential integrators at `−z`.
fn weights(z: f64) -> (f64, f64) {
    if z.abs() < 0.1 {
        let two = 0.5 - z * (1.0 / 6.0 - z * (1.0 / 24.0 - z * (1.0 / 120.0 - z / 720.0)));
        let three = 1.0 / 6.0 - z * (1.0 / 24.0 - z * (1.0 / 120.0 - z / 720.0));
        return (1.0 - z * two, three);
    }
    let z = z.max(-50.0);
    let one = (1.0 - (-z).exp()) / z;
    let two = (1.0 - one) / z;
    (one, (0.5 - two) / z)
}
