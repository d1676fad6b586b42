//! Forms of pad friction: speed, heat, pressure, water, cast iron.

use crate::family::{
    forms::{
        Draw, Form,
        FormSet::{A, B, C},
    },
    law::{law, with_state},
    moment::{Departure, Moment},
    units::PerWheelset,
};

/// Speed at the rim, m/s.
fn rim_m_s(now: &Moment, k: usize, radius_m: f64) -> f64 {
    now.wheel_speed_rad_s[k] * radius_m
}

/// Heat into the brake of a wheelset, W.
fn heat_w(now: &Moment, k: usize) -> f64 {
    now.brake_torque_nm[k].max(0.0) * now.wheel_speed_rad_s[k]
}

pub(super) const SPEED: [Form; 4] = [
    Form::new("lorentzian", A, |d| {
        let (rise, width, r) =
            (d.size("rise", 0.15, 0.35), d.shape("width_m_s", 4.0, 12.0), d.sheet.radius_m);
        let curve = move |v: f64| 1.0 + rise / (1.0 + (v / width).powi(2));
        law().pad_friction(move |(), k, now| curve(rim_m_s(now, k, r)) / curve(12.0)).boxed()
    }),
    Form::new("linear_then_level", B, |d| {
        let (fall, knee, r) =
            (d.size_below("fall", 0.15, 0.3, 0.7), d.shape("knee_m_s", 14.0, 32.0), d.sheet.radius_m);
        law()
            .pad_friction(move |(), k, now| 1.0 + fall * (0.5 - (rim_m_s(now, k, r) / knee).min(1.0)))
            .boxed()
    }),
    Form::new("logarithm", C, |d| {
        let (fall, r) = (d.size_below("fall", 0.06, 0.12, 0.3), d.sheet.radius_m);
        let from = d.shape("from_m_s", 0.5, 2.0);
        law()
            .pad_friction(move |(), k, now| 1.0 - fall * ((rim_m_s(now, k, r) + from) / (10.0 + from)).ln())
            .boxed()
    }),
    Form::new("hump", B, |d| {
        let (rise, peak, r) = (d.size("rise", 0.12, 0.3), d.shape("peak_m_s", 5.0, 14.0), d.sheet.radius_m);
        law()
            .pad_friction(move |(), k, now| {
                let x = rim_m_s(now, k, r) / peak;
                1.0 + rise * (x * (1.0 - x).exp() - 0.5)
            })
            .boxed()
    }),
];

/// Temperatures above ambient of one lumped disc per wheelset, K; heat capacity in J/K a kilogram of the vehicle.
fn warm(temperature_k: &mut PerWheelset, now: &Moment, capacity_j_per_k: f64, cooling_s: f64) {
    for k in 0..now.wheelsets {
        let airflow = 0.4 + now.v_m_s / 25.0;
        temperature_k[k] +=
            now.step_s * (heat_w(now, k) / capacity_j_per_k - airflow * temperature_k[k] / cooling_s);
    }
}

pub(super) const FADE: [Form; 4] = [
    Form::new("logistic_of_a_thin_layer", A, |d| {
        let depth = d.size_below("depth", 0.3, 0.5, 0.9);
        let (middle, width) = (d.shape("middle_k", 130.0, 220.0), d.shape("width_k", 40.0, 80.0));
        let core = d.sheet.mass_kg / d.sheet.wheelsets as f64 * d.shape("core_j_per_k_kg", 2.0, 3.5);
        let (inward_s, cooling_s) = (d.shape("inward_s", 15.0, 35.0), d.shape("cooling_s", 250.0, 600.0));
        let curve = move |t: f64| 1.0 - depth / (1.0 + (-(t - middle) / width).exp());
        with_state([[0.0; 2]; 4])
            .advance(move |heat, now| {
                for (k, [layer, core_k]) in heat.iter_mut().enumerate().take(now.wheelsets) {
                    let inward_w = core / inward_s * (*layer - *core_k);
                    *layer += now.step_s * (heat_w(now, k) - inward_w) / (0.25 * core);
                    *core_k += now.step_s * (inward_w / core - *core_k / cooling_s);
                }
            })
            .pad_friction(move |heat, k, _| curve(heat[k][0]) / curve(0.0))
            .boxed()
    }),
    Form::new("power_above_threshold", B, |d| {
        let (loss, from) = (d.size("loss_at_100_k_more", 0.15, 0.3), d.shape("from_k", 40.0, 110.0));
        let (power, cooling_s) = (d.shape("power", 1.5, 2.2), d.shape("cooling_s", 150.0, 500.0));
        let capacity = d.sheet.mass_kg / d.sheet.wheelsets as f64 * d.shape("j_per_k_kg", 2.0, 4.0);
        with_state([0.0; 4])
            .advance(move |t, now| warm(t, now, capacity, cooling_s))
            .pad_friction(move |t, k, _| {
                (1.0 - loss * ((t[k] - from).max(0.0) / 100.0).powf(power)).max(0.15)
            })
            .boxed()
    }),
    Form::new("saturating", C, |d| {
        let (loss, half) = (d.size_below("loss", 0.3, 0.55, 0.85), d.shape("half_k", 60.0, 160.0));
        let cooling_s = d.shape("cooling_s", 60.0, 400.0);
        let capacity = d.sheet.mass_kg / d.sheet.wheelsets as f64 * d.shape("j_per_k_kg", 2.0, 4.0);
        with_state([0.0; 4])
            .advance(move |t, now| warm(t, now, capacity, cooling_s))
            .pad_friction(move |t, k, _| 1.0 - loss * t[k] * t[k] / (t[k] * t[k] + half * half))
            .boxed()
    }),
    Form::new("rises_then_fades", C, |d| {
        let (size, peak) = (d.size_below("size", 0.12, 0.25, 0.55), d.shape("peak_k", 40.0, 90.0));
        let capacity = d.sheet.mass_kg / d.sheet.wheelsets as f64 * d.shape("j_per_k_kg", 2.0, 4.0);
        with_state([0.0; 4])
            .advance(move |t, now| warm(t, now, capacity, 300.0))
            .pad_friction(move |t, k, _| {
                let x = t[k] / peak;
                1.0 + size * (1.5 * x * (1.0 - x).exp() - 1.5 * x * x / (4.0 + x * x))
            })
            .boxed()
    }),
];

pub(super) const PRESSURE: [Form; 3] = [
    Form::new("linear", A, |d| {
        let (fall, full) = (d.size_below("fall", 0.2, 0.4, 1.1), d.sheet.full_force_n());
        law().pad_friction(move |(), k, now| 1.0 - fall * (now.cylinder_force_n[k] / full - 0.6)).boxed()
    }),
    Form::new("exponential", B, |d| {
        let (extra, decay) = (d.size("extra", 0.4, 0.9), d.shape("decay", 0.2, 0.5));
        let full = d.sheet.full_force_n();
        let curve = move |x: f64| 1.0 + extra * (-x / decay).exp();
        law().pad_friction(move |(), k, now| curve(now.cylinder_force_n[k] / full) / curve(0.6)).boxed()
    }),
    Form::new("logistic_step", C, |d| {
        let (fall, middle) = (d.size_below("fall", 0.15, 0.3, 0.7), d.shape("middle", 0.35, 0.65));
        let (width, full) = (d.shape("width", 0.04, 0.12), d.sheet.full_force_n());
        law()
            .pad_friction(move |(), k, now| {
                let x = (now.cylinder_force_n[k] / full - middle) / width;
                1.0 + fall * (0.5 - 1.0 / (1.0 + (-x).exp()))
            })
            .boxed()
    }),
];

pub(super) const WET: [Form; 3] = [
    Form::new("film_worn_the_slower_the_thinner", A, |d| {
        let loss = d.size_below("loss", 0.25, 0.45, 0.8);
        let energy = d.sheet.mass_kg / d.sheet.wheelsets as f64 * d.shape("j_per_kg", 25.0, 70.0);
        with_state([1.0f64; 4])
            .advance(move |film, now| {
                for (k, film) in film.iter_mut().enumerate().take(now.wheelsets) {
                    *film = (*film - now.step_s * heat_w(now, k) / energy * film.powf(1.25)).max(0.0);
                }
            })
            .pad_friction(move |film, k, _| 1.0 - loss * film[k])
            .boxed()
    }),
    Form::new("wiped_by_turns", B, |d| {
        let (loss, turns) = (d.size_below("loss", 0.25, 0.45, 0.8), d.shape("turns", 15.0, 50.0));
        let touch = 0.05 * d.sheet.full_force_n();
        with_state([0.0f64; 4])
            .advance(move |wiped, now| {
                for (k, wiped) in wiped.iter_mut().enumerate().take(now.wheelsets) {
                    let pressed = (now.cylinder_force_n[k] / touch).min(1.0);
                    *wiped += pressed * now.step_s * now.wheel_speed_rad_s[k] / std::f64::consts::TAU;
                }
            })
            .pad_friction(move |wiped, k, _| 1.0 - loss * (1.0 - wiped[k] / turns).max(0.0))
            .boxed()
    }),
    Form::new("dries_late", C, |d| {
        let loss = d.size_below("loss", 0.25, 0.45, 0.8);
        let energy = d.sheet.mass_kg / d.sheet.wheelsets as f64 * d.shape("j_per_kg", 40.0, 110.0);
        with_state([0.0f64; 4])
            .advance(move |spent, now| {
                for (k, spent) in spent.iter_mut().enumerate().take(now.wheelsets) {
                    *spent += now.step_s * heat_w(now, k) / energy;
                }
            })
            .pad_friction(move |spent, k, _| 1.0 - loss * (-spent[k] * spent[k]).exp())
            .boxed()
    }),
];

pub(super) const CAST_IRON: [Form; 3] = [
    Form::new("powers", A, |d| {
        let (of_speed, of_force) =
            (d.size_below("of_speed", 0.15, 0.3, 0.8), d.size_below("of_force", 0.06, 0.15, 0.5));
        let (full, r) = (d.sheet.full_force_n(), d.sheet.radius_m);
        law()
            .pad_friction(move |(), k, now| {
                let (v, x) = (rim_m_s(now, k, r), now.cylinder_force_n[k] / full);
                ((v + 2.5) / 12.5).powf(-of_speed) * ((x + 0.1) / 0.7).powf(-of_force)
            })
            .boxed()
    }),
    Form::new("exponential_and_line", B, |d| {
        let (rise, decay) = (d.size("rise", 0.35, 0.6), d.shape("decay_m_s", 4.0, 9.0));
        let (fall, full, r) =
            (d.size_below("fall", 0.1, 0.25, 0.7), d.sheet.full_force_n(), d.sheet.radius_m);
        law()
            .pad_friction(move |(), k, now| {
                let (v, x) = (rim_m_s(now, k, r), now.cylinder_force_n[k] / full);
                (1.0 + rise * ((-v / decay).exp() - 0.2)) * (1.0 - fall * (x - 0.6))
            })
            .boxed()
    }),
    Form::new("of_power_density", C, |d| {
        let (fall, half) = (d.size_below("fall", 0.35, 0.6, 0.85), d.shape("half", 0.2, 0.5));
        let (full, r, top) = (d.sheet.full_force_n(), d.sheet.radius_m, d.sheet.top_speed_m_s);
        let curve = move |p: f64| 1.0 - fall * p / (p + half);
        law()
            .pad_friction(move |(), k, now| {
                let density =
                    (rim_m_s(now, k, r) / top).max(0.0) * (now.cylinder_force_n[k] / full).max(0.0).sqrt();
                curve(density) / curve(0.3)
            })
            .boxed()
    }),
];

pub(super) const BITE: [Form; 3] = [
    Form::new("eases_with_time", A, |d| {
        bite(d.size("extra", 0.12, 0.25), d.shape("ease_s", 1.0, 2.5), |x| (-x).exp(), false, touch(d))
    }),
    Form::new("eases_with_turns", B, |d| {
        bite(
            d.size("extra", 0.12, 0.25),
            d.shape("ease_turns", 6.0, 20.0),
            |x| (1.0 - x).max(0.0),
            true,
            touch(d),
        )
    }),
    Form::new("comes_late_and_eases", C, |d| {
        bite(
            d.size("extra", 0.15, 0.3),
            d.shape("peak_s", 0.8, 2.0),
            |x| x * x * (2.0 - 2.0 * x).exp(),
            false,
            touch(d),
        )
    }),
];

fn touch(d: &Draw) -> f64 {
    0.03 * d.sheet.full_force_n()
}

/// Pads that grip differently when they are fresh on the disc, at every application anew.
fn bite(extra: f64, ease: f64, curve: fn(f64) -> f64, by_turns: bool, touch_n: f64) -> Box<dyn Departure> {
    with_state([0.0f64; 4])
        .advance(move |contact, now| {
            for (k, contact) in contact.iter_mut().enumerate().take(now.wheelsets) {
                let rate = if by_turns { now.wheel_speed_rad_s[k] / std::f64::consts::TAU } else { 1.0 };
                let touching = now.cylinder_force_n[k] > touch_n;
                *contact = if touching { *contact + now.step_s * rate } else { 0.0 };
            }
        })
        .pad_friction(move |contact, k, _| 1.0 + extra * curve(contact[k] / ease))
        .boxed()
}

pub(super) const UNEVEN_DISC: [Form; 3] = [
    Form::new("sine", A, |d| {
        let (amplitude, turns) = (d.size_below("amplitude", 0.12, 0.2, 0.6), d.shape("turns", 14.0, 30.0));
        law()
            .pad_friction(move |(), k, now| {
                1.0 + amplitude * (now.wheel_angle_rad[k] / turns + k as f64).sin()
            })
            .boxed()
    }),
    Form::new("steps", B, |d| {
        let (amplitude, turns) = (d.size_below("amplitude", 0.1, 0.18, 0.6), d.shape("turns", 12.0, 30.0));
        law()
            .pad_friction(move |(), k, now| 1.0 + amplitude * (now.wheel_angle_rad[k] / turns).sin().signum())
            .boxed()
    }),
    Form::new("beat", C, |d| {
        let (amplitude, turns) = (d.size_below("amplitude", 0.14, 0.24, 0.6), d.shape("turns", 6.0, 12.0));
        law()
            .pad_friction(move |(), k, now| {
                let angle = now.wheel_angle_rad[k] / turns;
                1.0 + amplitude * (angle.sin() * (angle / 4.3).sin())
            })
            .boxed()
    }),
];
