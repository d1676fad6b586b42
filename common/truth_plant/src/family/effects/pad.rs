//! Forms of pad friction: speed, heat, pressure, water, cast iron.

use crate::family::{
    forms::{
        Draw, Form,
        FormSet::{A, B, C, D},
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

pub(super) const SPEED: [Form; 5] = [
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
    // Asperities that melt in a flash: above a speed only the share of contacts that are still cold holds on.
    Form::new("flash_heated_asperities", D, |d| {
        let (fall, from) = (d.size_below("fall", 0.14, 0.28, 0.65), d.shape("from_m_s", 3.0, 7.0));
        let r = d.sheet.radius_m;
        let curve = move |v: f64| 1.0 - fall * (1.0 - from / v.max(from));
        law().pad_friction(move |(), k, now| curve(rim_m_s(now, k, r)) / curve(12.0)).boxed()
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

pub(super) const FADE: [Form; 5] = [
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
    // A glaze that heat bakes the faster the hotter, and that stays on the cooling disc until braking scrubs it off.
    Form::new("glaze_that_outlasts_the_heat", D, |d| {
        let loss = d.size_below("loss", 0.15, 0.3, 0.7);
        let (at, bake_s) = (d.shape("at_k", 50.0, 110.0), d.shape("bake_s", 5.0, 12.0));
        let of_wheelset = d.sheet.mass_kg / d.sheet.wheelsets as f64;
        let capacity = of_wheelset * d.shape("j_per_k_kg", 2.0, 4.0);
        let scrub_j = of_wheelset * d.shape("scrub_j_per_kg", 300.0, 900.0);
        with_state(([0.0f64; 4], [0.0f64; 4]))
            .advance(move |(t, glaze), now| {
                warm(t, now, capacity, 250.0);
                for (k, glaze) in glaze.iter_mut().enumerate().take(now.wheelsets) {
                    let baked_per_s = ((t[k] - at) / 30.0).min(3.0).exp() / bake_s;
                    *glaze += now.step_s * (baked_per_s * (1.0 - *glaze) - heat_w(now, k) / scrub_j * *glaze);
                }
            })
            .pad_friction(move |(_, glaze), k, _| 1.0 - loss * glaze[k].clamp(0.0, 1.0))
            .boxed()
    }),
];

pub(super) const PRESSURE: [Form; 4] = [
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
    // The true area of contact comes to an end: what presses beyond it adds no friction.
    Form::new("true_contact_comes_to_an_end", D, |d| {
        let (used, full) = (d.size("used_at_full", 0.6, 1.3), d.sheet.full_force_n());
        let curve = move |x: f64| if x * used < 1e-3 { 1.0 } else { (1.0 - (-x * used).exp()) / (x * used) };
        law().pad_friction(move |(), k, now| curve(now.cylinder_force_n[k] / full) / curve(0.6)).boxed()
    }),
];

pub(super) const WET: [Form; 4] = [
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
    // A film that pressure squeezes out, ever more slowly; it carries the pad only while the disc runs.
    Form::new("film_squeezed_out", D, |d| {
        let (loss, half) = (d.size_below("loss", 0.17, 0.32, 0.7), d.shape("half_m_s", 1.5, 4.0));
        let (squeeze_s, r, full) = (d.shape("squeeze_s", 2.0, 6.0), d.sheet.radius_m, d.sheet.full_force_n());
        with_state([1.0f64; 4])
            .advance(move |film, now| {
                for (k, film) in film.iter_mut().enumerate().take(now.wheelsets) {
                    let pressed = now.cylinder_force_n[k].max(0.0) / full;
                    *film -= now.step_s / squeeze_s * pressed * film.powi(3);
                }
            })
            .pad_friction(move |film, k, now| {
                let v = rim_m_s(now, k, r).max(0.0);
                1.0 - loss * film[k] * v / (v + half)
            })
            .boxed()
    }),
];

pub(super) const CAST_IRON: [Form; 4] = [
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
    // Iron softens where it rubs: at once in the spots that touch, late in the band around them.
    Form::new("spots_and_band_of_heat", D, |d| {
        let (fall, band_s) = (d.size("fall", 0.5, 1.0), d.shape("band_s", 4.0, 12.0));
        let (full, r, top) = (d.sheet.full_force_n(), d.sheet.radius_m, d.sheet.top_speed_m_s);
        let curve = move |hot: f64| 1.0 / (1.0 + fall * hot);
        with_state([0.0f64; 4])
            .advance(move |band, now| {
                for (k, band) in band.iter_mut().enumerate().take(now.wheelsets) {
                    let power = now.cylinder_force_n[k] / full * rim_m_s(now, k, r) / top;
                    *band += now.step_s / band_s * (power - *band);
                }
            })
            .pad_friction(move |band, k, now| {
                let spots = (rim_m_s(now, k, r) / top).max(0.0).sqrt();
                let pressed = now.cylinder_force_n[k].max(0.0) / full;
                curve(spots * (0.5 + 0.5 * pressed) + 0.7 * band[k]) / curve(0.6)
            })
            .boxed()
    }),
];

pub(super) const BITE: [Form; 4] = [
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
    Form::new("rubbed_off_and_grown_again", D, |d| {
        let (extra, grow_s) = (d.size("extra", 0.12, 0.25), d.shape("grow_s", 8.0, 25.0));
        let work = d.sheet.mass_kg / d.sheet.wheelsets as f64 * d.shape("j_per_kg", 12.0, 40.0);
        let touch_n = touch(d);
        // What bites grows on the released disc and goes by work: soon after a stop there is less of it.
        with_state([1.0f64; 4])
            .advance(move |fresh, now| {
                for (k, fresh) in fresh.iter_mut().enumerate().take(now.wheelsets) {
                    *fresh += if now.cylinder_force_n[k] > touch_n {
                        -now.step_s * heat_w(now, k) / work * *fresh
                    } else {
                        now.step_s / grow_s * (1.0 - *fresh)
                    };
                }
            })
            .pad_friction(move |fresh, k, _| 1.0 + extra * fresh[k].max(0.0))
            .boxed()
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

pub(super) const UNEVEN_DISC: [Form; 4] = [
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
    Form::new("hot_spots_that_grow_in_braking", D, |d| {
        let (amplitude, turns) = (d.size_below("amplitude", 0.2, 0.35, 0.6), d.shape("turns", 7.0, 15.0));
        let (grow_s, full) = (d.shape("grow_s", 2.0, 6.0), d.sheet.full_force_n());
        with_state([0.0f64; 4])
            .advance(move |hot, now| {
                for (k, hot) in hot.iter_mut().enumerate().take(now.wheelsets) {
                    *hot += now.step_s / grow_s * (now.cylinder_force_n[k] / full - *hot);
                }
            })
            .pad_friction(move |hot, k, now| {
                let wave =
                    (now.wheel_angle_rad[k] / turns + k as f64).sin().abs() - std::f64::consts::FRAC_2_PI;
                1.0 + amplitude * (0.4 + hot[k]) * 1.5 * wave
            })
            .boxed()
    }),
];
