//! Forms between the cylinder pressure and the pad.

use std::collections::VecDeque;

use crate::family::{
    forms::{
        Draw, Form,
        FormSet::{A, B, C, D},
    },
    law::{law, with_state},
    moment::{Departure, Moment},
    units::PerWheelset,
};

/// Pads that follow the pressure late: waiting forces and two further states a wheelset.
type Late = (VecDeque<PerWheelset>, PerWheelset, PerWheelset);

/// The cylinder forces so long ago, N; the force at the start before the run.
fn delayed(waiting: &mut VecDeque<PerWheelset>, now: &Moment, dead_s: f64) -> PerWheelset {
    if waiting.is_empty() {
        waiting.extend(std::iter::repeat_n(now.cylinder_force_n, (dead_s / now.step_s).round() as usize));
    }
    waiting.push_back(now.cylinder_force_n);
    waiting.pop_front().unwrap_or(now.cylinder_force_n)
}

pub(super) const LAG: [Form; 5] = [
    Form::new("dead_time_and_two_lags", A, |d| {
        let (dead_s, lag_s) =
            (d.size_below("dead_s", 0.03, 0.12, 0.5), d.size_below("lag_s", 0.12, 0.3, 1.5));
        with_state::<Late>(Late::default())
            .advance(move |(waiting, first, second), now| {
                let late = delayed(waiting, now, dead_s);
                let share = 1.0 - (-2.0 * now.step_s / lag_s).exp();
                for k in 0..now.wheelsets {
                    first[k] += share * (late[k] - first[k]);
                    second[k] += share * (first[k] - second[k]);
                }
            })
            .pad_force(|(_, _, second), k, _, _| second[k])
            .boxed()
    }),
    Form::new("rate_limit_and_dead_time", B, |d| {
        let (dead_s, stroke_s) = (d.size_below("dead_s", 0.04, 0.15, 0.5), d.size("stroke_s", 0.6, 1.5));
        let full_n = d.sheet.full_force_n();
        with_state::<Late>(Late::default())
            .advance(move |(waiting, pad, _), now| {
                let late = delayed(waiting, now, dead_s);
                let most_n = full_n * now.step_s / stroke_s;
                for k in 0..now.wheelsets {
                    pad[k] += (late[k] - pad[k]).clamp(-most_n, most_n);
                }
            })
            .pad_force(|(_, pad, _), k, _, _| pad[k])
            .boxed()
    }),
    Form::new("fast_and_slow_part", C, |d| {
        let slow_share = d.size_below("slow_share", 0.15, 0.35, 0.8);
        let (fast_s, slow_s) = (d.size_below("fast_s", 0.03, 0.08, 0.3), d.shape("slow_s", 0.6, 1.8));
        with_state::<Late>(Late::default())
            .advance(move |(_, fast, slow), now| {
                for k in 0..now.wheelsets {
                    fast[k] += (1.0 - (-now.step_s / fast_s).exp()) * (now.cylinder_force_n[k] - fast[k]);
                    slow[k] += now.step_s / slow_s * (now.cylinder_force_n[k] - slow[k]);
                }
            })
            .pad_force(move |(_, fast, slow), k, _, _| (1.0 - slow_share) * fast[k] + slow_share * slow[k])
            .boxed()
    }),
    Form::new("slow_on_quick_off", C, |d| {
        let (on_s, off_s) = (d.size_below("on_s", 0.2, 0.5, 2.0), d.size_below("off_s", 0.02, 0.1, 0.5));
        with_state([0.0f64; 4])
            .advance(move |pad, now| {
                for (k, pad) in pad.iter_mut().enumerate().take(now.wheelsets) {
                    let missing_n = now.cylinder_force_n[k] - *pad;
                    let lag_s = if missing_n > 0.0 { on_s } else { off_s };
                    *pad += (1.0 - (-now.step_s / lag_s).exp()) * missing_n;
                }
            })
            .pad_force(|pad, k, _, _| pad[k])
            .boxed()
    }),
    // Air through an orifice: the flow falls as the root of what is missing.
    Form::new("through_an_orifice", D, |d| {
        let (fill_s, full_n) = (d.size("fill_s", 0.3, 0.7), d.sheet.full_force_n());
        with_state([0.0f64; 4])
            .advance(move |pad, now| {
                for (k, pad) in pad.iter_mut().enumerate().take(now.wheelsets) {
                    let missing_n = now.cylinder_force_n[k] - *pad;
                    let flown_n = now.step_s / fill_s * (missing_n.abs() * full_n).sqrt();
                    *pad += flown_n.min(missing_n.abs()).copysign(missing_n);
                }
            })
            .pad_force(|pad, k, _, _| pad[k])
            .boxed()
    }),
];

pub(super) const HYSTERESIS: [Form; 5] = [
    Form::new("dahl", A, |d| {
        let (relative, reversal) = (
            d.size_below("relative", 0.05, 0.1, 0.4),
            d.sheet.full_force_n() * d.shape("reversal", 0.03, 0.08),
        );
        side_of_motion(relative, move |side, change| {
            (side + change / reversal - change.abs() / reversal * side).clamp(-1.0, 1.0)
        })
    }),
    Form::new("coulomb_of_rate", A, |d| {
        let (relative, rate) = (
            d.size_below("relative", 0.05, 0.1, 0.4),
            d.sheet.full_force_n() * d.shape("rate_per_s", 0.05, 0.2),
        );
        with_state(([0.0f64; 4], [0.0f64; 4]))
            .advance(move |(before, side), now| {
                for (k, side) in side.iter_mut().enumerate().take(now.wheelsets) {
                    let rate_n_s = (now.cylinder_force_n[k] - before[k]) / now.step_s;
                    *side += now.step_s / 0.05 * ((rate_n_s / rate).tanh() - *side);
                }
                *before = now.cylinder_force_n;
            })
            .pad_force(move |(_, side), k, force_n, _| force_n * (1.0 - relative * side[k]))
            .boxed()
    }),
    Form::new("three_plays", B, |d| {
        let widest = d.sheet.full_force_n() * d.size_below("widest", 0.08, 0.2, 0.5);
        let weights = [0.45, 0.35, 0.2];
        let widths = [0.2 * widest, 0.55 * widest, widest];
        with_state([[0.0f64; 3]; 4])
            .advance(move |plays, now| {
                for (k, plays) in plays.iter_mut().enumerate().take(now.wheelsets) {
                    let force_n = now.cylinder_force_n[k];
                    for (play, half) in plays.iter_mut().zip(widths) {
                        *play = play.clamp((force_n - half).max(0.0), force_n + half);
                    }
                }
            })
            .pad_force(move |plays, k, _, _| {
                plays[k].iter().zip(weights).map(|(play, weight)| play * weight).sum()
            })
            .boxed()
    }),
    Form::new("bouc_wen_of_constant_size", C, |d| {
        let full = d.sheet.full_force_n();
        let (lost, reversal) =
            (full * d.size_below("lost", 0.03, 0.07, 0.3), full * d.shape("reversal", 0.2, 0.5));
        // Exponent 3, and a loop that is narrower on the way back; the same in newtons at any force.
        with_state(([0.0f64; 4], [0.0f64; 4]))
            .advance(move |(before, side), now| {
                for (k, side) in side.iter_mut().enumerate().take(now.wheelsets) {
                    let change = now.cylinder_force_n[k] - before[k];
                    let shape = side.abs().powi(3) * (0.65 * (change * *side).signum() + 0.35);
                    *side = (*side + change / reversal * (1.0 - shape)).clamp(-1.0, 1.0);
                }
                *before = now.cylinder_force_n;
            })
            .pad_force(move |(_, side), k, force_n, _| force_n - (lost * side[k]).min(0.5 * force_n))
            .boxed()
    }),
    Form::new("sticks_and_slips", D, |d| {
        let (relative, rest) = (d.size_below("relative", 0.1, 0.22, 0.6), d.shape("rest", 0.1, 0.4));
        // Force at the pad, and whether the rigging slips: it lets go at one difference and holds again at a smaller one.
        with_state(([0.0f64; 4], [false; 4]))
            .advance(move |(pad, slips), now| {
                for k in 0..now.wheelsets {
                    let missing_n = now.cylinder_force_n[k] - pad[k];
                    let band_n = relative * pad[k].max(now.cylinder_force_n[k]);
                    slips[k] = missing_n.abs() > if slips[k] { rest * band_n } else { band_n };
                    if slips[k] {
                        pad[k] += (1.0 - (-now.step_s / 0.03).exp()) * missing_n;
                    }
                }
            })
            .pad_force(|(pad, _), k, _, _| pad[k])
            .boxed()
    }),
];

/// Pads get less while a state says that the pressure rises, more while it says that it falls.
fn side_of_motion(relative: f64, next: impl Fn(f64, f64) -> f64 + Send + 'static) -> Box<dyn Departure> {
    with_state(([0.0f64; 4], [0.0f64; 4]))
        .advance(move |(before, side), now| {
            for k in 0..now.wheelsets {
                side[k] = next(side[k], now.cylinder_force_n[k] - before[k]);
                before[k] = now.cylinder_force_n[k];
            }
        })
        .pad_force(move |(_, side), k, force_n, _| force_n * (1.0 - relative * side[k]))
        .boxed()
}

pub(super) const OFFSET: [Form; 4] = [
    Form::new("soft_threshold", A, |d| {
        let threshold = d.sheet.full_force_n() * d.size_below("threshold", 0.04, 0.09, 0.4);
        law()
            .pad_force(move |(), _, force_n, _| {
                let soft_n = 0.15 * threshold;
                let excess = (force_n - threshold) / soft_n;
                if excess > 30.0 { excess * soft_n } else { soft_n * excess.exp().ln_1p() }
            })
            .boxed()
    }),
    Form::new("gradual", B, |d| {
        let full = d.sheet.full_force_n();
        let (lost, over) = (full * d.size_below("lost", 0.05, 0.1, 0.4), full * d.shape("over", 0.1, 0.25));
        law()
            .pad_force(move |(), _, force_n, _| (force_n - lost * (1.0 - (-force_n / over).exp())).max(0.0))
            .boxed()
    }),
    Form::new("clearance_that_is_taken_up", C, |d| {
        let lost = d.sheet.full_force_n() * d.size_below("lost", 0.06, 0.12, 0.4);
        let (take_up_s, rest) = (d.shape("take_up_s", 2.0, 5.0), d.shape("rest", 0.1, 0.3));
        let touch_n = 0.02 * d.sheet.full_force_n();
        with_state([0.0f64; 4])
            .advance(move |held_s, now| {
                for (k, held_s) in held_s.iter_mut().enumerate().take(now.wheelsets) {
                    *held_s = if now.cylinder_force_n[k] > touch_n { *held_s + now.step_s } else { 0.0 };
                }
            })
            .pad_force(move |held_s, k, force_n, _| {
                (force_n - lost * (rest + (1.0 - rest) * (-held_s[k] / take_up_s).exp())).max(0.0)
            })
            .boxed()
    }),
    // Pins and guides hold the return spring's force back the less, the more the run shakes them.
    Form::new("less_where_the_run_shakes_it", D, |d| {
        let lost = d.sheet.full_force_n() * d.size_below("lost", 0.06, 0.12, 0.4);
        let half = d.shape("half_m_s", 4.0, 12.0);
        law()
            .pad_force(move |(), _, force_n, now| {
                let lost_n = lost * (0.5 + 1.0 / (1.0 + now.v_m_s / half));
                // All of it only where the cylinder gives much more.
                force_n * force_n / (force_n + lost_n)
            })
            .boxed()
    }),
];

/// Usual torque of a brake that does not let go, N m.
fn drag_nm(d: &mut Draw) -> f64 {
    let per_kg = d.size("m_s2_of_the_wagon", 0.02, 0.05);
    per_kg * d.sheet.mass_kg * d.sheet.radius_m
}

pub(super) const DRAGGING: [Form; 5] = [
    Form::new("wears_free", A, |d| {
        let (wheelset, torque_nm) = (d.wheelset(), drag_nm(d));
        let (way_m, rest) = (d.shape("way_m", 150.0, 500.0), d.shape("rest", 0.3, 0.7));
        law()
            .drag_torque(move |(), k, now| {
                let share = rest + (1.0 - rest) * (-now.position_m / way_m).exp();
                if k == wheelset { torque_nm * share * now.moving() } else { 0.0 }
            })
            .boxed()
    }),
    Form::new("once_a_turn", B, |d| {
        let (wheelset, torque_nm) = (d.wheelset(), drag_nm(d));
        let depth = d.shape("depth", 0.5, 1.0);
        law()
            .drag_torque(move |(), k, now| {
                let share = 1.0 + depth * now.wheel_angle_rad[k].sin();
                if k == wheelset { torque_nm * share * now.moving() } else { 0.0 }
            })
            .boxed()
    }),
    Form::new("lets_go_slowly", C, |d| {
        let (wheelset, release_s) = (d.wheelset(), d.shape("release_s", 15.0, 50.0));
        let share = d.size_below("share_of_force", 0.12, 0.25, 0.7);
        with_state(0.0f64)
            .advance(move |held, now| {
                let force_n = now.cylinder_force_n[wheelset];
                *held = if force_n > *held {
                    force_n
                } else {
                    *held + now.step_s / release_s * (force_n - *held)
                };
            })
            .pad_force(
                move |held, k, force_n, _| if k == wheelset { force_n.max(share * held) } else { force_n },
            )
            .boxed()
    }),
    Form::new("grips_less_at_speed", C, |d| {
        let (wheelset, torque_nm) = (d.wheelset(), drag_nm(d));
        let half = d.shape("half_m_s", 5.0, 20.0);
        law()
            .drag_torque(move |(), k, now| {
                if k == wheelset { 1.6 * torque_nm * half / (half + now.v_m_s) * now.moving() } else { 0.0 }
            })
            .boxed()
    }),
    Form::new("tightens_as_it_warms", D, |d| {
        let (wheelset, torque_nm) = (d.wheelset(), drag_nm(d));
        let (warm_m, cool_s) = (d.shape("warm_m", 150.0, 500.0), d.shape("cool_s", 60.0, 200.0));
        // The disc grows with the heat of its own dragging.
        with_state(0.0f64)
            .advance(move |warm, now| {
                *warm += now.step_s * ((1.0 - *warm) * now.v_m_s / warm_m - *warm / cool_s);
            })
            .drag_torque(
                move |warm, k, now| {
                    if k == wheelset { torque_nm * (0.4 + 0.9 * warm) * now.moving() } else { 0.0 }
                },
            )
            .boxed()
    }),
];

/// How far a wheelset slides (share of speed).
fn slide(now: &Moment, k: usize) -> f64 {
    -now.slip_m_s[k] / now.v_m_s.max(2.0)
}

pub(super) const DUMP: [Form; 4] = [
    Form::new("vents_in_slides", A, |d| {
        let (share, vent_s) = (d.size_below("share", 0.35, 0.6, 0.95), d.shape("vent_s", 0.1, 0.3));
        let above = d.shape("above", 0.04, 0.1);
        dump(move |open, now, k| {
            let target = if slide(now, k) > above { share } else { 0.0 };
            open + now.step_s / vent_s * (target - open)
        })
    }),
    Form::new("pulses_in_slides", B, |d| {
        let (share, period_s) = (d.size_below("share", 0.5, 0.8, 1.0), d.shape("period_s", 0.25, 0.6));
        dump(move |_, now, k| {
            let pulse = (now.time_s / period_s).fract() < 0.5;
            if pulse && slide(now, k) > 0.05 { share } else { 0.0 }
        })
    }),
    Form::new("quick_out_slow_back", C, |d| {
        let (share, refill_s) = (d.size_below("share", 0.35, 0.6, 0.95), d.shape("refill_s", 1.0, 3.0));
        let above = d.shape("above_m_s", 0.4, 1.2);
        dump(
            move |open, now, k| {
                if -now.slip_m_s[k] > above { open.max(share) } else { open - now.step_s / refill_s * open }
            },
        )
    }),
    Form::new("vents_when_a_wheel_outfalls_the_wagon", D, |d| {
        let (share, limit) = (d.size_below("share", 0.35, 0.6, 0.95), d.shape("limit_m_s2", 0.6, 1.5));
        let r = d.sheet.radius_m;
        // Wheel speed a little ago, and how far the valve is open: it shuts when the wheel runs with the wagon again.
        with_state(([f64::NAN; 4], [0.0f64; 4]))
            .advance(move |(ago, open), now| {
                for k in 0..now.wheelsets {
                    let wheel = now.wheel_speed_rad_s[k];
                    ago[k] = if ago[k].is_nan() { wheel } else { ago[k] };
                    let falls_m_s2 = r * (ago[k] - wheel) / 0.08 + now.acceleration_m_s2;
                    ago[k] += (1.0 - (-now.step_s / 0.08).exp()) * (wheel - ago[k]);
                    if falls_m_s2 > limit && slide(now, k) > 0.02 {
                        open[k] = share;
                    } else if slide(now, k) < 0.02 {
                        open[k] -= now.step_s / 0.4 * open[k];
                    }
                }
            })
            .pad_force(|(_, open), k, force_n, _| force_n * (1.0 - open[k]))
            .boxed()
    }),
];

/// A valve behind the pressure sensor that takes a share of the force away.
fn dump(next: impl Fn(f64, &Moment, usize) -> f64 + Send + 'static) -> Box<dyn Departure> {
    with_state([0.0f64; 4])
        .advance(move |open, now| {
            for (k, open) in open.iter_mut().enumerate().take(now.wheelsets) {
                *open = next(*open, now, k);
            }
        })
        .pad_force(|open, k, force_n, _| force_n * (1.0 - open[k]))
        .boxed()
}

pub(super) const LEAK: [Form; 4] = [
    Form::new("exponential", A, |d| leak(d, |x| (-x).exp())),
    Form::new("straight_to_a_floor", B, |d| leak(d, |x| (1.0 - 0.8 * x).max(0.35))),
    Form::new("late", C, |d| leak(d, |x| 1.0 / (1.0 + 2.0 * x * x))),
    // A distributor that feeds what leaks out: the more pressure, the more is lost, and some of it comes back.
    Form::new("against_a_feed", D, |d| {
        let (wheelset, rate) = (d.wheelset(), d.size("rate_per_s", 1.0 / 30.0, 1.0 / 15.0));
        let (feed_s, full_n) = (d.shape("feed_s", 25.0, 70.0), d.sheet.full_force_n());
        let touch_n = 0.03 * full_n;
        with_state(0.0f64)
            .advance(move |lost, now| {
                let cylinder_n = now.cylinder_force_n[wheelset];
                let pressed = cylinder_n / full_n * (1.0 - *lost).max(0.0);
                // A new application fills it anew.
                *lost = if cylinder_n > touch_n {
                    *lost + now.step_s * (rate * pressed - *lost / feed_s)
                } else {
                    0.0
                };
            })
            .pad_force(
                move |lost, k, force_n, _| {
                    if k == wheelset { force_n * (1.0 - lost.clamp(0.0, 1.0)) } else { force_n }
                },
            )
            .boxed()
    }),
];

/// A cylinder that leaks behind its sensor: the longer it is held, the less its pads press.
fn leak(d: &mut Draw, curve: fn(f64) -> f64) -> Box<dyn Departure> {
    let (wheelset, rate) = (d.wheelset(), d.size("rate_per_s", 1.0 / 60.0, 1.0 / 30.0));
    let touch_n = 0.03 * d.sheet.full_force_n();
    with_state(0.0f64)
        .advance(move |held_s, now| {
            *held_s = if now.cylinder_force_n[wheelset] > touch_n { *held_s + now.step_s } else { 0.0 };
        })
        .pad_force(
            move |held_s, k, force_n, _| if k == wheelset { force_n * curve(rate * held_s) } else { force_n },
        )
        .boxed()
}
