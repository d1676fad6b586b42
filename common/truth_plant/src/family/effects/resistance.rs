//! Forms of what holds the wagon back: slope, rolling, wind.

use std::f64::consts::{PI, TAU};

use crate::{
    family::{
        forms::{
            Draw, Form,
            FormSet::{A, B, C, D},
        },
        law::{law, with_state},
        moment::{Departure, Moment},
    },
    random::{Stream, Wander},
};

/// Slope (rad), from where and how long (m).
fn slope(d: &mut Draw) -> (f64, f64, f64) {
    (
        d.signed_size("slope_rad", 0.004, 0.009),
        d.shape("from_m", 40.0, 300.0),
        d.shape("length_m", 120.0, 400.0),
    )
}

pub(super) const GRADE: [Form; 5] = [
    Form::new("rounded_ends", A, |d| {
        let ((slope_rad, from_m, length_m), round_m) = (slope(d), d.shape("round_m", 20.0, 50.0));
        let ramp = move |x: f64| 0.5 * (1.0 - (PI * (x / round_m).clamp(0.0, 1.0)).cos());
        law()
            .grade_error(move |(), now| {
                slope_rad * (ramp(now.position_m - from_m) - ramp(now.position_m - from_m - length_m))
            })
            .boxed()
    }),
    Form::new("hump", B, |d| {
        let (slope_rad, from_m, length_m) = slope(d);
        law()
            .grade_error(move |(), now| {
                let x = ((now.position_m - from_m) / length_m).clamp(0.0, 1.0);
                1.4 * slope_rad * (PI * x).sin().powi(2)
            })
            .boxed()
    }),
    Form::new("map_is_shifted", C, |d| {
        let shift_m = d.signed_size("shift_m", 100.0, 250.0);
        law()
            .grade_error(move |(), now| {
                now.line.grade_rad(now.position_m + shift_m) - now.line.grade_rad(now.position_m)
            })
            .boxed()
    }),
    Form::new("up_and_down", C, |d| {
        let (slope_rad, from_m, length_m) = slope(d);
        law()
            .grade_error(move |(), now| match (now.position_m - from_m) / length_m {
                x if (0.0..0.5).contains(&x) => 1.3 * slope_rad,
                x if (0.5..1.0).contains(&x) => -0.8 * slope_rad,
                _ => 0.0,
            })
            .boxed()
    }),
    // Ground that has settled: waves that die away.
    Form::new("waves_that_die_away", D, |d| {
        let (slope_rad, from_m, length_m) = slope(d);
        law()
            .grade_error(move |(), now| {
                let x = ((now.position_m - from_m) / length_m).max(0.0);
                2.2 * slope_rad * (TAU * x).sin() * (-0.8 * x).exp()
            })
            .boxed()
    }),
];

/// Resistance over the sheet's, as a curve of speed scaled to about 1 at 15 m/s.
fn rolling(d: &mut Draw, curve: impl Fn(f64) -> f64 + Send + 'static) -> Box<dyn Departure> {
    let force_n = d.size("m_s2", 0.02, 0.04) * d.sheet.mass_kg;
    law().body_force(move |(), now| -force_n * curve(now.v_m_s) * now.moving()).boxed()
}

pub(super) const RUNNING: [Form; 4] = [
    Form::new("constant_and_broken_power", A, |d| {
        let share = d.shape("share", 0.2, 0.8);
        rolling(d, move |v| share + (1.0 - share) * (v / 15.0).powf(1.5))
    }),
    Form::new("greatest_when_slow", B, |d| {
        let (extra, decay) = (d.shape("extra", 0.8, 2.0), d.shape("decay_m_s", 3.0, 8.0));
        rolling(d, move |v| 0.8 + extra * (-v / decay).exp() + 0.01 * v)
    }),
    Form::new("saturates_with_speed", C, |d| {
        let half = d.shape("half_m_s", 3.0, 12.0);
        rolling(d, move |v| 1.5 * v / (v + half))
    }),
    Form::new("hunts_above_a_speed", D, |d| {
        let force_n = d.size("m_s2", 0.02, 0.04) * d.sheet.mass_kg;
        let (from, share) = (d.shape("from_m_s", 7.0, 14.0), d.shape("share", 0.3, 0.5));
        // A bogie that hunts goes on hunting below the speed at which it began.
        with_state((false, 0.0f64))
            .advance(move |(hunts, swing), now| {
                *hunts = now.v_m_s > if *hunts { 0.7 * from } else { from };
                *swing += now.step_s / 1.5 * (f64::from(u8::from(*hunts)) - *swing);
            })
            .body_force(move |(_, swing), now| -force_n * (share + 0.9 * swing) * now.moving())
            .boxed()
    }),
];

pub(super) const DRAG: [Form; 4] = [
    Form::new("power_of_2_3", A, |d| {
        let force_n = drag_n(d);
        law().body_force(move |(), now| -force_n * (now.v_m_s / 25.0).powf(2.3)).boxed()
    }),
    Form::new("with_tunnel", B, |d| {
        let (force_n, from_m, length_m) =
            (drag_n(d), d.shape("from_m", 50.0, 250.0), d.shape("length_m", 200.0, 500.0));
        law()
            .body_force(move |(), now| {
                let inside = f64::from(u8::from((from_m..from_m + length_m).contains(&now.position_m)));
                -force_n * (now.v_m_s / 25.0).powi(2) * (0.7 + 0.8 * inside)
            })
            .boxed()
    }),
    Form::new("in_cross_wind", C, |d| {
        let (force_n, cross) = (drag_n(d), d.shape("cross_m_s", 2.0, 6.0));
        law()
            .body_force(move |(), now| {
                -force_n * now.v_m_s * now.v_m_s.hypot(cross) / 625.0 * (1.0 - 0.1 * (now.v_m_s / 25.0))
            })
            .boxed()
    }),
    // The flow closes behind the wagon above a speed, and drags less.
    Form::new("flow_that_closes", D, |d| {
        let (force_n, from, less) = (drag_n(d), d.shape("from_m_s", 11.0, 20.0), d.shape("less", 0.3, 0.6));
        law()
            .body_force(move |(), now| {
                let closed = 0.5 * (1.0 + ((now.v_m_s - from) / 2.0).tanh());
                -1.25 * force_n * (now.v_m_s / 25.0).powi(2) * (1.0 - less * closed)
            })
            .boxed()
    }),
];

/// Force of extra drag at 25 m/s, N.
fn drag_n(d: &mut Draw) -> f64 {
    d.size("over_the_sheets", 0.6, 1.5) * d.sheet.resistance[2] * 625.0
}

pub(super) const WIND: [Form; 4] = [
    Form::new("breathes", A, |d| {
        let mean = d.signed_size("mean_m_s", 6.0, 11.0).clamp(-25.0, 25.0);
        let stream = Stream::new(d.stream.below(1 << 30) as u64, "breath", 0);
        with_state((Wander::new(stream, 0.12 * mean.abs(), 12.0, 0.05), 0.0f64, 0.0f64))
            .advance(move |(breath, next_s, gust), now| {
                if now.time_s >= *next_s {
                    *next_s += 0.05;
                    *gust = breath.advance();
                }
            })
            .headwind(move |(_, _, gust), _| mean + gust)
            .boxed()
    }),
    Form::new("sheltered_in_places", B, |d| {
        let mean = d.signed_size("mean_m_s", 7.0, 12.0).clamp(-25.0, 25.0);
        let (wave_m, depth) = (d.shape("wave_m", 250.0, 700.0), d.shape("depth", 0.2, 0.5));
        law()
            .headwind(move |(), now| {
                mean * (1.0 - depth * (0.5 - 0.5 * (TAU * now.position_m / wave_m).cos()))
            })
            .boxed()
    }),
    Form::new("freshens", C, |d| {
        let mean = d.signed_size("mean_m_s", 7.0, 12.0).clamp(-25.0, 25.0);
        let (from_s, rise_s) = (d.shape("from_s", 0.0, 10.0), d.shape("rise_s", 5.0, 20.0));
        law()
            .headwind(move |(), now| mean * (0.7 + 0.5 / (1.0 + (-(now.time_s - from_s) / rise_s).exp())))
            .boxed()
    }),
    Form::new("comes_with_a_squall", D, |d| {
        let mean = d.signed_size("mean_m_s", 7.0, 12.0).clamp(-25.0, 25.0);
        let (at_s, lasts_s) = (d.shape("at_s", 4.0, 20.0), d.shape("lasts_s", 4.0, 10.0));
        law()
            .headwind(move |(), now| mean * (0.6 + 0.8 * (-((now.time_s - at_s) / lasts_s).powi(2)).exp()))
            .boxed()
    }),
];

pub(super) const COLD_BEARINGS: [Form; 4] = [
    Form::new("free_after_some_way", A, |d| {
        let way_m = d.shape("way_m", 90.0, 250.0);
        stiff(d, move |now| (-now.position_m / way_m).exp())
    }),
    Form::new("free_with_time", B, |d| {
        let time_s = d.shape("time_s", 4.0, 12.0);
        stiff(d, move |now| 1.0 / (1.0 + (now.time_s / time_s).powi(2)))
    }),
    Form::new("free_when_warm", C, |d| {
        let warm = d.sheet.mass_kg * d.shape("j_per_kg", 3.0, 10.0);
        let force_n = d.size("m_s2", 0.06, 0.12) * d.sheet.mass_kg;
        // The bearings warm with what they burn themselves.
        with_state(0.0f64)
            .advance(move |burnt_j, now| {
                *burnt_j += now.step_s * force_n * (1.0 - *burnt_j / warm).max(0.0) * now.v_m_s;
            })
            .body_force(move |burnt_j, now| -force_n * (1.0 - burnt_j / warm).max(0.0) * now.moving())
            .boxed()
    }),
    Form::new("grease_that_thins", D, |d| {
        let (force_n, way_m) = (d.size("m_s2", 0.07, 0.14) * d.sheet.mass_kg, d.shape("way_m", 60.0, 160.0));
        let viscous = |warm: f64, v: f64| (-warm).exp() * (0.3 + 0.7 * (v / 12.0).max(0.0).sqrt());
        // Thick grease warms with what it burns, and the thinner it is the less it burns.
        with_state(0.0f64)
            .advance(move |warm, now| *warm += now.step_s * now.v_m_s / way_m * viscous(*warm, now.v_m_s))
            .body_force(move |warm, now| -force_n * viscous(*warm, now.v_m_s) * now.moving())
            .boxed()
    }),
];

fn stiff(d: &mut Draw, share: impl Fn(&Moment) -> f64 + Send + 'static) -> Box<dyn Departure> {
    let force_n = d.size("m_s2", 0.06, 0.12) * d.sheet.mass_kg;
    law().body_force(move |(), now| -force_n * share(now) * now.moving()).boxed()
}
