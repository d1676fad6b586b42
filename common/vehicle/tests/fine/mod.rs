//! A fine implicit solution of the wagon's equations under frozen loads and loading: backward Euler in steps of some tens of
//! microseconds, each extrapolated from one step and two halves.

use railgrip_vehicle::adhesion::creep_force;
use railgrip_vehicle::resistance::running_resistance;
use railgrip_vehicle::{Constants, Loading, PerWheelset, WagonState};

/// Longest step, s.
const STEP_S: f64 = 4e-5;

/// The state after `span_s`.
pub fn advance(
    constants: &Constants,
    start: &WagonState,
    load_n: &PerWheelset,
    loading: &Loading,
    span_s: f64,
) -> WagonState {
    let steps = (span_s / STEP_S).ceil();
    let tau = span_s / steps;
    let mut state = *start;
    for _ in 0..steps as usize {
        let whole = euler(constants, &state, load_n, loading, tau);
        let half = euler(constants, &state, load_n, loading, 0.5 * tau);
        let halves = euler(constants, &half, load_n, loading, 0.5 * tau);
        state.v_m_s = 2.0 * halves.v_m_s - whole.v_m_s;
        for i in 0..constants.wheelsets {
            let (one, two) = (whole.wheel_speed_rad_s[i], halves.wheel_speed_rad_s[i]);
            let stands = one == 0.0 || two == 0.0;
            state.wheel_speed_rad_s[i] = if stands { two } else { 2.0 * two - one };
        }
    }
    state
}

fn euler(
    constants: &Constants,
    start: &WagonState,
    load_n: &PerWheelset,
    loading: &Loading,
    tau: f64,
) -> WagonState {
    let v = start.v_m_s;
    let mut force = loading.other_n - running_resistance(&constants.resistance, v, loading.wind_m_s);
    let mut next = *start;
    for i in 0..constants.wheelsets {
        let (radius, gain) = (constants.wheel_radius_m[i], tau / constants.inertia_kg_m2[i]);
        let contact_n = |omega: f64| {
            creep_force(&constants.contact, radius * omega, v, load_n[i], loading.adhesion_peak[i]).force_n
        };
        // What speed the wheelset would have but for its brake, less the speed itself: falls with speed.
        let unbraked = |omega: f64| {
            start.wheel_speed_rad_s[i] + gain * (loading.drive_torque_nm[i] - radius * contact_n(omega))
                - omega
        };
        let brake = gain * loading.brake_torque_nm[i];
        let at_rest = unbraked(0.0);
        let omega = if at_rest.abs() <= brake {
            0.0
        } else {
            let reach = gain * (loading.drive_torque_nm[i].abs() + radius * load_n[i]) + brake;
            let (from, to) = (start.wheel_speed_rad_s[i] - reach, start.wheel_speed_rad_s[i] + reach);
            bisect(|omega| unbraked(omega) - brake * at_rest.signum(), from, to)
        };
        next.wheel_speed_rad_s[i] = omega;
        force += contact_n(omega);
    }
    next.v_m_s = v + tau * force / constants.mass_kg;
    next
}

/// Root of a falling function by bisection and regula falsi in turns (Illinois).
fn bisect(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let (mut low, mut high) = (from, to);
    let (mut at_low, mut at_high) = (f(low), f(high));
    let mut middle = low;
    for turn in 0..200 {
        let before = middle;
        middle = if turn % 3 == 2 {
            0.5 * (low + high)
        } else {
            (low * at_high - high * at_low) / (at_high - at_low)
        };
        let value = f(middle);
        if value > 0.0 {
            (low, at_low) = (middle, value);
            at_high *= 0.5;
        } else {
            (high, at_high) = (middle, value);
            at_low *= 0.5;
        }
        if value == 0.0 || (middle - before).abs() < 1e-13 * (1.0 + middle.abs()) {
            break;
        }
    }
    middle
}
