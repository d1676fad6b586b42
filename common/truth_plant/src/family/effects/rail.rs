//! Forms of adhesion: how much the rail holds, where, when and at which slip.

use crate::family::{
    forms::{
        Draw, Form,
        FormSet::{A, B, C, D},
    },
    law::{law, with_state},
    moment::{Departure, Moment},
};

pub(super) const FALLING: [Form; 5] = [
    Form::new("hyperbola", A, |d| {
        let (depth, half) = (d.size_below("depth", 0.3, 0.5, 0.8), d.shape("half_m_s", 0.6, 2.5));
        of_slip(move |w| 1.0 - depth * w / (w + half))
    }),
    Form::new("line_to_a_plateau", B, |d| {
        let (depth, until) = (d.size_below("depth", 0.2, 0.4, 0.8), d.shape("until_m_s", 1.0, 4.0));
        of_slip(move |w| 1.0 - depth * (w / until).min(1.0))
    }),
    Form::new("tail_rises_again", C, |d| {
        let (depth, lowest) = (d.size_below("depth", 0.25, 0.4, 0.75), d.shape("lowest_m_s", 0.6, 1.8));
        of_slip(move |w| {
            let x = w / lowest;
            1.0 - depth * 2.0 * x / (1.0 + x * x)
        })
    }),
    Form::new("bell", C, |d| {
        let (depth, width) = (d.size_below("depth", 0.25, 0.45, 0.8), d.shape("width_m_s", 0.5, 2.0));
        of_slip(move |w| 1.0 - depth * (1.0 - (-(w / width).powi(2)).exp()))
    }),
    // The contact warms with the root of the time that a point spends in it: the faster the run, the more it takes to fall.
    Form::new("of_flash_temperature", D, |d| {
        let (depth, half) = (d.size_below("depth", 0.3, 0.55, 0.85), d.shape("half_m_s", 0.5, 2.0));
        law()
            .rail_friction(move |(), k, now| {
                let warm = now.slip_m_s[k].abs() / (half * ((now.v_m_s + 2.0) / 12.0).sqrt());
                1.0 - depth * (1.0 - 1.0 / ((1.0 + warm) * (1.0 + warm)))
            })
            .boxed()
    }),
];

fn of_slip(curve: impl Fn(f64) -> f64 + Send + 'static) -> Box<dyn Departure> {
    law().rail_friction(move |(), k, now| curve(now.slip_m_s[k].abs())).boxed()
}

/// Gains of following wheelsets; a rail that is dry has little to clean.
fn cleaned(now: &Moment) -> f64 {
    if now.rail == crate::sheet::Rail::Dry { 0.3 } else { 1.0 }
}

pub(super) const CLEANING: [Form; 4] = [
    Form::new("work_of_those_before", A, |d| {
        let (gain, forget_s) = (d.size("gain", 0.3, 0.6), d.shape("forget_s", 0.5, 2.0));
        let half_j = d.sheet.mass_kg * d.shape("half_j_per_kg", 0.05, 0.25);
        with_state([0.0f64; 4])
            .advance(move |work_j, now| {
                for (k, work) in work_j.iter_mut().enumerate().take(now.wheelsets) {
                    *work += now.step_s * (now.sliding_power_w[k] - *work / forget_s);
                }
            })
            .rail_friction(move |work_j, k, now| {
                let before: f64 = work_j[..k].iter().sum();
                1.0 + cleaned(now)
                    * gain
                    * (0.35 * f64::from(u8::from(k > 0)) + 0.65 * before / (before + half_j))
            })
            .boxed()
    }),
    Form::new("by_number_of_wheelsets", B, |d| {
        let (gain, power) = (d.size("gain", 0.2, 0.4), d.shape("power", 0.4, 0.8));
        law().rail_friction(move |(), k, now| 1.0 + cleaned(now) * gain * (k as f64).powf(power)).boxed()
    }),
    Form::new("less_at_speed", C, |d| {
        let (gain, half) = (d.size("gain", 0.4, 0.8), d.shape("half_m_s", 6.0, 18.0));
        law()
            .rail_friction(move |(), k, now| {
                let follows = f64::from(u8::from(k > 0));
                1.0 + cleaned(now) * gain * follows * (1.0 + 0.15 * k as f64)
                    / (1.0 + (now.v_m_s / half).powi(2))
            })
            .boxed()
    }),
    Form::new("each_takes_a_share_of_the_film", D, |d| {
        let (gain, takes) = (d.size("gain", 0.3, 0.6), d.shape("takes", 0.5, 0.85));
        let half = d.shape("half_m_s", 0.03, 0.2);
        // Every wheelset leaves the next one what it did not take, and takes more where it slips.
        law()
            .rail_friction(move |(), k, now| {
                let left = |slip_m_s: &f64| {
                    let slip = slip_m_s.abs();
                    1.0 - takes * (0.5 + 0.5 * slip / (slip + half))
                };
                let film: f64 = now.slip_m_s[..k].iter().map(left).product();
                1.0 + cleaned(now) * gain * (1.0 - film)
            })
            .boxed()
    }),
];

/// A stretch of a low rail: how much of the adhesion is lost, from where and over which length (m).
fn stretch(d: &mut Draw) -> (f64, f64, f64) {
    let loss = d.size_below("loss", 0.35, 0.65, 0.9);
    (loss, d.shape("from_m", 60.0, 260.0), d.shape("length_m", 40.0, 140.0))
}

fn at_place(share: impl Fn(f64) -> f64 + Send + 'static) -> Box<dyn Departure> {
    law().rail_friction(move |(), k, now| 1.0 - share(now.contact_m[k])).boxed()
}

pub(super) const PATCH: [Form; 5] = [
    Form::new("gaussian", A, |d| {
        let (loss, from, length) = stretch(d);
        at_place(move |x| loss * (-((x - from - 0.5 * length) / (0.35 * length)).powi(2)).exp())
    }),
    Form::new("sharp_edges", B, |d| {
        let (loss, from, length) = stretch(d);
        at_place(move |x| if (from..from + length).contains(&x) { loss } else { 0.0 })
    }),
    Form::new("cosine_ramps", B, |d| {
        let (loss, from, length) = stretch(d);
        let ramp = 0.4 * length;
        let rise = move |x: f64| 0.5 * (1.0 - (std::f64::consts::PI * (x / ramp).clamp(0.0, 1.0)).cos());
        at_place(move |x| loss * (rise(x - from) - rise(x - from - length + ramp)))
    }),
    Form::new("two_patches", C, |d| {
        let (loss, from, length) = stretch(d);
        let (apart, second) = (d.shape("apart_m", 20.0, 120.0), d.shape("second_share", 0.5, 1.0));
        let patch = move |x: f64| (1.0 - (x / (0.5 * length)).powi(4)).max(0.0);
        at_place(move |x| loss * patch(x - from) + second * loss * patch(x - from - length - apart))
    }),
    Form::new("carried_on_by_the_wheels", D, |d| {
        let (loss, from, length) = stretch(d);
        let carried = d.shape("carried_m", 20.0, 60.0);
        at_place(move |x| match x - from {
            before if before < 0.0 => 0.0,
            on if on < 0.6 * length => loss,
            behind => loss * (-(behind - 0.6 * length) / carried).exp(),
        })
    }),
];

pub(super) const SPEED: [Form; 4] = [
    Form::new("exponential", A, |d| {
        let rate = d.size("per_m_s", 1.0 / 60.0, 1.0 / 30.0);
        law().rail_friction(move |(), _, now| (-rate * (now.v_m_s - 12.0)).exp()).boxed()
    }),
    Form::new("line", B, |d| {
        let rate = d.size_below("per_m_s", 0.012, 0.025, 0.06);
        law().rail_friction(move |(), _, now| (1.0 - rate * (now.v_m_s - 12.0)).max(0.15)).boxed()
    }),
    Form::new("falls_late", C, |d| {
        let rate = d.size("per_m_s", 1.0 / 45.0, 1.0 / 28.0);
        let curve = move |v: f64| 1.0 / (1.0 + (rate * v).powi(2));
        law().rail_friction(move |(), _, now| curve(now.v_m_s) / curve(12.0)).boxed()
    }),
    // Water lifts the wheel about a speed: it holds below it and has fallen above it.
    Form::new("film_lifts_the_wheel", D, |d| {
        let depth = d.size_below("depth", 0.25, 0.45, 0.8);
        let (middle, width) = (d.shape("middle_m_s", 9.0, 16.0), d.shape("width_m_s", 6.0, 12.0));
        let curve = move |v: f64| 1.0 - depth * ((v - middle) / width).tanh();
        law().rail_friction(move |(), _, now| curve(now.v_m_s) / curve(12.0)).boxed()
    }),
];

pub(super) const SAND: [Form; 4] = [
    Form::new("root_of_cover", A, |d| {
        let (gain, fall_s, stay_s) =
            (d.size("gain", 0.3, 0.6), d.shape("fall_s", 0.4, 1.0), d.shape("stay_s", 0.8, 2.0));
        with_state(0.0f64)
            .advance(move |cover, now| {
                let (target, time_s) = if now.sanding { (1.0, fall_s) } else { (0.0, stay_s) };
                *cover += now.step_s / time_s * (target - *cover);
            })
            .rail_friction(move |cover, _, _| 1.0 + gain * cover.max(0.0).sqrt())
            .boxed()
    }),
    Form::new("waits_then_climbs_straight", B, |d| {
        let (gain, wait_s, climb_s) =
            (d.size("gain", 0.3, 0.6), d.shape("wait_s", 0.3, 1.2), d.shape("climb_s", 0.6, 2.0));
        with_state(0.0f64)
            .advance(move |age_s, now| {
                *age_s = if now.sanding { *age_s + now.step_s } else { (*age_s - 3.0 * now.step_s).max(0.0) };
                *age_s = age_s.min(wait_s + climb_s);
            })
            .rail_friction(move |age_s, _, _| 1.0 + gain * ((age_s - wait_s) / climb_s).clamp(0.0, 1.0))
            .boxed()
    }),
    Form::new("blown_away_at_speed", C, |d| {
        let (gain, half) = (d.size("gain", 0.5, 0.9), d.shape("half_m_s", 8.0, 20.0));
        let way_m = d.shape("way_m", 8.0, 25.0);
        with_state(0.0f64)
            .advance(move |cover, now| {
                let target = f64::from(u8::from(now.sanding));
                *cover += (1.0 - (-now.step_s * now.v_m_s / way_m).exp()) * (target - *cover);
            })
            .rail_friction(move |cover, _, now| 1.0 + gain * cover * half / (half + now.v_m_s))
            .boxed()
    }),
    Form::new("crushed_by_those_before", D, |d| {
        let (gain, strew_s) = (d.size("gain", 0.4, 0.75), d.shape("strew_s", 0.3, 0.9));
        let (way_m, crushed) = (d.shape("way_m", 10.0, 40.0), d.shape("crushed", 0.7, 0.9));
        // Strewn with time, lost with way; the first wheelset has whole grains, the others what it left of them.
        with_state(0.0f64)
            .advance(move |cover, now| {
                *cover += if now.sanding {
                    now.step_s / strew_s * (1.0 - *cover)
                } else {
                    -now.step_s * now.v_m_s / way_m * *cover
                };
            })
            .rail_friction(move |cover, k, _| {
                1.0 + gain * crushed.powi(k as i32) * (1.0 - (-2.0 * cover.max(0.0)).exp())
            })
            .boxed()
    }),
];

pub(super) const CONDITIONING: [Form; 4] = [
    Form::new("hyperbola_of_work", A, |d| conditioning(d, false, |x| x / (1.0 + x))),
    Form::new("straight_with_way", B, |d| conditioning(d, true, |x| x.min(1.0))),
    Form::new("square_of_work", C, |d| conditioning(d, false, |x| 1.0 - (-x * x).exp())),
    Form::new("film_breaks_and_heals", D, |d| {
        let (gain, forget_s) = (d.size("gain", 0.16, 0.33), d.shape("forget_s", 2.0, 6.0));
        let breaks_j = d.sheet.mass_kg * d.shape("j_per_kg", 0.1, 0.5);
        // Work of late, whether the film is broken, and what that has changed by now.
        with_state([(0.0f64, false, 0.0f64); 4])
            .advance(move |films, now| {
                for (k, (work_j, broken, more)) in films.iter_mut().enumerate().take(now.wheelsets) {
                    *work_j += now.step_s * (now.sliding_power_w[k] - *work_j / forget_s);
                    *broken = *work_j > if *broken { 0.3 * breaks_j } else { breaks_j };
                    *more += now.step_s / 0.2 * (f64::from(u8::from(*broken)) - *more);
                }
            })
            .rail_friction(move |films, k, _| 1.0 + gain * films[k].2)
            .boxed()
    }),
];

/// A wheel that conditions its own contact by sliding, and forgets in rolling.
fn conditioning(d: &mut Draw, by_way: bool, curve: fn(f64) -> f64) -> Box<dyn Departure> {
    let (gain, forget_s) = (d.size("gain", 0.3, 0.6), d.shape("forget_s", 3.0, 8.0));
    let scale =
        if by_way { d.shape("way_m", 1.0, 4.0) } else { d.sheet.mass_kg * d.shape("j_per_kg", 0.3, 1.2) };
    with_state([0.0f64; 4])
        .advance(move |burnt, now| {
            for (k, burnt) in burnt.iter_mut().enumerate().take(now.wheelsets) {
                let source = if by_way { now.slip_m_s[k].abs() } else { now.sliding_power_w[k] };
                *burnt += now.step_s * (source / scale - *burnt / forget_s);
            }
        })
        .rail_friction(move |burnt, k, _| 1.0 + gain * curve(burnt[k]))
        .boxed()
}
