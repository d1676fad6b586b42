//! Forms of what is shown from what is.

use std::{collections::VecDeque, f64::consts::TAU};

use crate::family::{
    forms::{
        Draw, Form,
        FormSet::{A, B, C, D},
    },
    law::{law, with_state},
    moment::{Departure, Moment, Sensed},
    units::PerWheelset,
};

/// The value this long ago in a newest-first history, between samples linearly, the oldest beyond its end.
fn ago<T>(newest_first: &VecDeque<T>, back: f64, value: impl Fn(&T) -> f64) -> f64 {
    let last = newest_first.len().saturating_sub(1);
    let index = (back.max(0.0).floor() as usize).min(last);
    let next = (index + 1).min(last);
    let share = (back - index as f64).clamp(0.0, 1.0);
    let (a, b) = (newest_first.get(index).map_or(0.0, &value), newest_first.get(next).map_or(0.0, &value));
    a + share * (b - a)
}

/// Changes the shown speed of one wheelset by a factor.
fn factor_of(wheelset: usize, factor: impl Fn(&Moment) -> f64 + Send + 'static) -> Box<dyn Departure> {
    law().sense(move |(), now, shown| shown.wheel_speed_rad_s[wheelset] *= factor(now)).boxed()
}

pub(super) const ECCENTRIC: [Form; 5] = [
    Form::new("wobbles", A, |d| {
        let (k, amplitude) = (d.wheelset(), d.size_below("amplitude", 0.005, 0.012, 0.2));
        let (phase, slow) = (d.shape("phase_rad", 0.0, TAU), d.shape("slow_turns", 20.0, 60.0));
        factor_of(k, move |now| {
            let angle = now.wheel_angle_rad[k];
            1.0 + amplitude * (1.0 + 0.35 * (angle / slow).sin()) * (angle + phase).sin()
        })
    }),
    Form::new("triangle", B, |d| {
        let (k, amplitude) = (d.wheelset(), d.size_below("amplitude", 0.006, 0.014, 0.2));
        let phase = d.shape("phase", 0.0, 1.0);
        factor_of(k, move |now| {
            let turn = (now.wheel_angle_rad[k] / TAU + phase).fract();
            1.0 + amplitude * (4.0 * (turn - 0.5).abs() - 1.0)
        })
    }),
    Form::new("one_bad_tooth", C, |d| {
        let (k, amplitude) = (d.wheelset(), d.size_below("amplitude", 0.012, 0.03, 0.3));
        let (phase, width) = (d.shape("phase", 0.0, 1.0), d.shape("width", 0.05, 0.12));
        factor_of(k, move |now| {
            let turn = ((now.wheel_angle_rad[k] / TAU + phase).fract() - 0.5) / width;
            1.0 - amplitude * (-turn * turn).exp()
        })
    }),
    Form::new("sharpened_sine", C, |d| {
        let (k, amplitude) = (d.wheelset(), d.size_below("amplitude", 0.006, 0.014, 0.2));
        let phase = d.shape("phase_rad", 0.0, TAU);
        factor_of(k, move |now| {
            let sine = (now.wheel_angle_rad[k] + phase).sin();
            1.0 + amplitude * sine.signum() * sine.abs().powf(0.4)
        })
    }),
    Form::new("bent_over_half_a_turn", D, |d| {
        let (k, amplitude) = (d.wheelset(), d.size_below("amplitude", 0.012, 0.026, 0.3));
        let phase = d.shape("phase_rad", 0.0, TAU);
        factor_of(k, move |now| {
            1.0 + amplitude * ((now.wheel_angle_rad[k] + phase).sin().max(0.0) - std::f64::consts::FRAC_1_PI)
        })
    }),
];

pub(super) const WINDOW: [Form; 4] = [
    Form::new("triangular_weights", A, |d| {
        let window_s = d.size_below("window_s", 0.15, 0.32, 1.2);
        with_state(VecDeque::<PerWheelset>::new())
            .sense(move |past, now, shown| {
                past.push_front(shown.wheel_speed_rad_s);
                let samples = (window_s / now.sample_s).max(1.0);
                past.truncate(samples.ceil() as usize);
                for k in 0..now.wheelsets {
                    let weights =
                        past.iter().enumerate().map(|(age, w)| ((samples - age as f64) / samples, w[k]));
                    let (sum, weight) =
                        weights.fold((0.0, 0.0), |(s, n), (weight, w)| (s + weight * w, n + weight));
                    shown.wheel_speed_rad_s[k] = sum / weight;
                }
            })
            .boxed()
    }),
    Form::new("first_order", B, |d| {
        let lag_s = d.size_below("lag_s", 0.06, 0.13, 0.6);
        with_state([f64::NAN; 4])
            .sense(move |smooth, now, shown| {
                let share = 1.0 - (-now.sample_s / lag_s).exp();
                for k in 0..now.wheelsets {
                    let w = shown.wheel_speed_rad_s[k];
                    smooth[k] = if smooth[k].is_nan() { w } else { smooth[k] + share * (w - smooth[k]) };
                    shown.wheel_speed_rad_s[k] = smooth[k];
                }
            })
            .boxed()
    }),
    Form::new("counted_in_blocks", C, |d| {
        let block_s = d.size_below("block_s", 0.10, 0.20, 1.0);
        // Sum and number in the block that runs, mean of the one before, when it ends.
        with_state(([0.0f64; 4], 0.0f64, [f64::NAN; 4], 0.0f64))
            .sense(move |(sum, count, mean, ends_s), now, shown| {
                if mean[0].is_nan() {
                    *mean = shown.wheel_speed_rad_s;
                    *ends_s = block_s;
                }
                for k in 0..now.wheelsets {
                    sum[k] += shown.wheel_speed_rad_s[k];
                }
                *count += 1.0;
                if now.time_s + 0.5 * now.sample_s >= *ends_s {
                    *mean = sum.map(|sum| sum / *count);
                    (*sum, *count) = ([0.0; 4], 0.0);
                    *ends_s += block_s.max(now.sample_s);
                }
                shown.wheel_speed_rad_s = *mean;
            })
            .boxed()
    }),
    Form::new("filter_that_overshoots", D, |d| {
        let (lag_s, damping) = (d.size_below("lag_s", 0.07, 0.15, 0.6), d.shape("damping", 0.4, 0.7));
        let omega = 2.0 * damping / lag_s.max(1e-3);
        with_state(([f64::NAN; 4], [0.0f64; 4]))
            .sense(move |(smooth, rate), now, shown| {
                let substeps = (now.sample_s * omega / 0.2).ceil().max(1.0);
                let sub_s = now.sample_s / substeps;
                for k in 0..now.wheelsets {
                    let w = shown.wheel_speed_rad_s[k];
                    smooth[k] = if smooth[k].is_nan() { w } else { smooth[k] };
                    for _ in 0..substeps as usize {
                        let pull = omega * omega * (w - smooth[k]) - 2.0 * damping * omega * rate[k];
                        rate[k] += sub_s * pull;
                        smooth[k] += sub_s * rate[k];
                    }
                    shown.wheel_speed_rad_s[k] = smooth[k];
                }
            })
            .boxed()
    }),
];

pub(super) const CLOCK: [Form; 4] = [
    Form::new("slower_as_it_warms", A, |d| {
        let (drift, warming) = (d.size_below("drift", 0.003, 0.007, 0.03), d.shape("per_s", 0.01, 0.03));
        shifted(move |time_s| drift * time_s * (1.0 + warming * time_s))
    }),
    Form::new("set_right_in_steps", B, |d| {
        let (drift, every_s) = (d.size_below("drift", 0.006, 0.014, 0.05), d.shape("every_s", 9.0, 25.0));
        shifted(move |time_s| drift * (time_s % every_s))
    }),
    Form::new("settles", C, |d| {
        let (offset_s, settle_s) =
            (d.size_below("offset_s", 0.15, 0.35, 1.2), d.shape("settle_s", 12.0, 40.0));
        shifted(move |time_s| offset_s * (1.0 - (-time_s / settle_s).exp()))
    }),
    Form::new("slewed_to_and_fro", D, |d| {
        let (most_s, period_s) = (d.size_below("most_s", 0.15, 0.35, 1.2), d.shape("period_s", 25.0, 60.0));
        shifted(move |time_s| 0.5 * most_s * (1.0 - (TAU * time_s / period_s).cos()))
    }),
];

/// Wheel speeds that are so late, s.
fn shifted(late_s: impl Fn(f64) -> f64 + Send + 'static) -> Box<dyn Departure> {
    with_state(VecDeque::<PerWheelset>::new())
        .sense(move |past, now, shown| {
            past.push_front(shown.wheel_speed_rad_s);
            past.truncate((4.0 / now.sample_s) as usize);
            let back = late_s(now.time_s) / now.sample_s;
            for k in 0..now.wheelsets {
                shown.wheel_speed_rad_s[k] = ago(past, back, |w| w[k]);
            }
        })
        .boxed()
}

pub(super) const LATENCY: [Form; 4] = [
    Form::new("delay_and_smoothing", A, |d| {
        let (latency_s, share) = (d.size_below("latency_s", 0.18, 0.35, 1.2), d.shape("share", 0.3, 0.7));
        late_speed(move |past, now, smooth| {
            let late = ago(past, share * latency_s / now.sample_s, |v| *v);
            let keep = (-now.sample_s / ((1.0 - share) * latency_s).max(1e-3)).exp();
            let value = if smooth[0].is_nan() { late } else { late + keep * (smooth[0] - late) };
            smooth[0] = value;
            value
        })
    }),
    Form::new("two_lags", B, |d| {
        let latency_s = d.size_below("latency_s", 0.18, 0.35, 1.2);
        late_speed(move |past, now, smooth| {
            let v = past.front().copied().unwrap_or(0.0);
            if smooth[0].is_nan() {
                *smooth = [v; 2];
            }
            let share = 1.0 - (-2.0 * now.sample_s / latency_s.max(1e-3)).exp();
            smooth[0] += share * (v - smooth[0]);
            smooth[1] += share * (smooth[0] - smooth[1]);
            smooth[1]
        })
    }),
    Form::new("seldom_and_late", C, |d| {
        let latency_s = d.size_below("latency_s", 0.18, 0.35, 1.2);
        let (share, next_of) = (d.shape("held_share", 0.5, 1.2), 0.0);
        late_speed(move |past, now, held| {
            // A value that is held between readings: half of the hold is latency.
            if held[0].is_nan() || now.time_s >= held[1] {
                let hold_s = (share * latency_s).max(now.sample_s);
                held[1] = if held[1].is_nan() { next_of } else { held[1] } + hold_s;
                held[0] = ago(past, (latency_s - 0.5 * hold_s).max(0.0) / now.sample_s, |v| *v);
            }
            held[0]
        })
    }),
    // A speed that is measured over a way is the later the slower the run.
    Form::new("over_a_way", D, |d| {
        let latency_s = d.size_below("latency_s", 0.15, 0.3, 1.0);
        let from = d.shape("from_m_s", 2.0, 5.0);
        late_speed(move |past, now, _| {
            let late_s = latency_s * ((10.0 + from) / (now.v_m_s + from)).min(3.0);
            ago(past, late_s / now.sample_s, |v| *v)
        })
    }),
];

fn late_speed(
    shown_of: impl Fn(&VecDeque<f64>, &Moment, &mut [f64; 2]) -> f64 + Send + 'static,
) -> Box<dyn Departure> {
    with_state((VecDeque::<f64>::new(), [f64::NAN; 2]))
        .sense(move |(past, memory), now, shown| {
            past.push_front(shown.v_m_s);
            past.truncate((2.0 / now.sample_s) as usize);
            shown.v_m_s = shown_of(past, now, memory);
        })
        .boxed()
}

pub(super) const SCALE: [Form; 4] = [
    Form::new("bends_with_speed", A, |d| {
        let (relative, bend) =
            (d.signed_size("relative", 0.006, 0.015), d.shape("bend_per_m_s", 0.005, 0.02));
        scaled(move |v, _| relative.clamp(-0.09, 0.09) * (1.0 + bend * (v - 15.0)))
    }),
    Form::new("sets_in_above_a_speed", B, |d| {
        let (relative, from) = (d.signed_size("relative", 0.008, 0.018), d.shape("from_m_s", 4.0, 10.0));
        scaled(move |v, _| relative.clamp(-0.09, 0.09) * v * v / (v * v + from * from))
    }),
    Form::new("drifts_with_time", C, |d| {
        let (relative, warm_s) = (d.signed_size("relative", 0.008, 0.018), d.shape("warm_s", 10.0, 40.0));
        scaled(move |_, now| relative.clamp(-0.09, 0.09) * (1.0 - 0.5 * (-now.time_s / warm_s).exp()))
    }),
    Form::new("tilts_in_braking", D, |d| {
        let (relative, tilt) = (d.signed_size("relative", 0.007, 0.016), d.shape("tilt_per_m_s2", 0.3, 0.7));
        let settle_s = d.shape("settle_s", 0.3, 1.0);
        // A radar that nods with the body looks at the rail under another angle.
        with_state(0.0f64)
            .sense(move |nod, now, shown| {
                *nod += (1.0 - (-now.sample_s / settle_s).exp()) * (-now.acceleration_m_s2 - *nod);
                shown.v_m_s *= 1.0 + relative.clamp(-0.09, 0.09) * (0.8 + tilt * nod.clamp(-1.5, 1.5));
            })
            .boxed()
    }),
];

fn scaled(error: impl Fn(f64, &Moment) -> f64 + Send + 'static) -> Box<dyn Departure> {
    law().sense(move |(), now, shown: &mut Sensed| shown.v_m_s *= 1.0 + error(shown.v_m_s, now)).boxed()
}

pub(super) const RADAR: [Form; 4] = [
    Form::new("sine", A, |d| ripple(d, |x| (TAU * x).sin())),
    Form::new("sawtooth", B, |d| ripple(d, |x| 1.6 * (x.fract() - 0.5))),
    Form::new("bursts", C, |d| {
        ripple(d, |x| if (x / 6.0).fract() < 0.5 { 1.3 * (TAU * x).sin() } else { 0.0 })
    }),
    Form::new("peaks", D, |d| {
        ripple(d, |x| {
            let off = (x.fract() - 0.5) / 0.16;
            2.0 * ((-off * off).exp() - 0.28)
        })
    }),
];

/// A radar that looks at sleepers: its reading swings with the place.
fn ripple(d: &mut Draw, wave: fn(f64) -> f64) -> Box<dyn Departure> {
    let (amplitude, wave_m) = (d.size_below("amplitude", 0.010, 0.020, 0.2), d.shape("wave_m", 12.0, 60.0));
    law().sense(move |(), now, shown| shown.v_m_s *= 1.0 + amplitude * wave(now.position_m / wave_m)).boxed()
}

pub(super) const DISTURBED: [Form; 4] = [
    Form::new("with_force", A, |d| {
        let full_n = d.sheet.full_force_n();
        disturbed(d, move |now, k| now.cylinder_force_n[k] / full_n)
    }),
    Form::new("with_power", B, |d| {
        let sheet = d.sheet;
        let full_w = sheet.full_force_n() * sheet.pad_friction * sheet.brake_radius_m * 15.0 / sheet.radius_m;
        disturbed(d, move |now, k| now.brake_torque_nm[k] * now.wheel_speed_rad_s[k] / full_w)
    }),
    Form::new("above_a_force", C, |d| {
        let threshold_n = d.sheet.full_force_n() * d.shape("threshold", 0.3, 0.6);
        disturbed(d, move |now, k| 0.8 * f64::from(u8::from(now.cylinder_force_n[k] > threshold_n)))
    }),
    Form::new("where_the_brake_squeals", D, |d| {
        let full_n = d.sheet.full_force_n();
        let (at, width) = (d.shape("at_m_s", 6.0, 14.0), d.shape("width_m_s", 4.0, 9.0));
        disturbed(d, move |now, k| {
            let off = (now.v_m_s - at) / width;
            2.5 * (now.cylinder_force_n[k] / full_n).max(0.0).sqrt() / (1.0 + off * off)
        })
    }),
];

/// A tachometer on one wheelset that reads low while its brake is on.
fn disturbed(d: &mut Draw, share: impl Fn(&Moment, usize) -> f64 + Send + 'static) -> Box<dyn Departure> {
    let (k, relative) = (d.wheelset(), d.size_below("relative", 0.01, 0.02, 0.3));
    factor_of(k, move |now| (1.0 - relative * share(now, k)).max(0.2))
}
