//! Forms of loads, masses, wheels and shafts, and of what the neighbours do.

use std::f64::consts::TAU;

use crate::family::{
    forms::{
        Draw, Form,
        FormSet::{A, B, C, D},
    },
    law::{law, with_state},
    moment::{Departure, Moment},
};

/// Relative change of the transfer of load: mostly more than the sheet says.
fn leaning(d: &mut Draw) -> f64 {
    let more = d.stream.chance(0.7);
    let size = d.size("size", 1.0, 2.0);
    if more { size } else { -size.min(1.9) }
}

pub(super) const TRANSFER: [Form; 4] = [
    Form::new("grows_with_retardation", A, |d| {
        let (size, from) = (leaning(d), d.shape("from_m_s2", 0.3, 0.9));
        law()
            .load_transfer(move |(), now| {
                1.0 + size * now.acceleration_m_s2.abs() / (now.acceleration_m_s2.abs() + from) * 1.6
            })
            .boxed()
    }),
    Form::new("builds_up_in_braking", B, |d| {
        let (size, settle_s) = (leaning(d), d.shape("settle_s", 0.4, 1.5));
        with_state(0.0f64)
            .advance(move |lean, now| {
                let target = f64::from(u8::from(now.acceleration_m_s2 < -0.1));
                *lean += now.step_s / settle_s * (target - *lean);
            })
            .load_transfer(move |lean, _| 1.0 + size * lean)
            .boxed()
    }),
    Form::new("less_at_speed", C, |d| {
        let (size, half) = (leaning(d), d.shape("half_m_s", 10.0, 25.0));
        law().load_transfer(move |(), now| 1.0 + 1.7 * size / (1.0 + (now.v_m_s / half).powi(2))).boxed()
    }),
    Form::new("body_that_pitches", D, |d| {
        let (size, omega) = (leaning(d), TAU * d.shape("frequency_hz", 0.7, 1.4));
        let damping = d.shape("damping", 0.1, 0.3);
        // The body on its springs follows the retardation and swings beyond it.
        with_state((0.0f64, 0.0f64))
            .advance(move |(pitch, rate), now| {
                let pull = omega * omega * (-now.acceleration_m_s2 - *pitch) - 2.0 * damping * omega * *rate;
                *rate += now.step_s * pull;
                *pitch += now.step_s * *rate;
            })
            .load_transfer(move |(pitch, _), now| {
                1.0 + size * (pitch / (-now.acceleration_m_s2).max(0.2)).clamp(-1.0, 2.0)
            })
            .boxed()
    }),
];

pub(super) const MASS: [Form; 4] = [
    Form::new("another_payload_each_run", A, |d| {
        let relative = d.signed_size("relative", 0.07, 0.12).max(-0.3);
        let (spread, mass) = (d.shape("spread", 0.15, 0.4), d.sheet.mass_kg);
        law()
            .extra_mass(move |(), now| {
                let of_run = 1.0 + spread * (2.4 * now.run as f64 + 1.0).sin();
                mass * relative * of_run
            })
            .boxed()
    }),
    Form::new("lost_on_the_way", B, |d| {
        let relative = d.signed_size("relative", 0.07, 0.12).max(-0.3);
        let (way_m, mass) = (d.shape("way_m", 800.0, 2500.0), d.sheet.mass_kg);
        law()
            .extra_mass(move |(), now| mass * relative * (1.0 - 0.5 * (now.position_m / way_m).min(1.0)))
            .boxed()
    }),
    Form::new("liquid_that_sloshes", C, |d| {
        let relative = d.size_below("relative", 0.07, 0.12, 0.4);
        let (frequency_hz, damping) = (d.shape("frequency_hz", 0.25, 0.6), d.shape("damping", 0.1, 0.3));
        let (mass, omega) = (d.sheet.mass_kg, TAU * frequency_hz);
        with_state((0.0f64, 0.0f64))
            .advance(move |(way_m, rate), now| {
                let pull = -omega * omega * *way_m - 2.0 * damping * omega * *rate;
                *rate += now.step_s * (pull - now.acceleration_m_s2);
                *way_m += now.step_s * *rate;
            })
            // Half of it is fixed, half hangs and pulls.
            .extra_mass(move |_, _| 0.5 * mass * relative)
            .body_force(move |(way_m, rate), _| {
                0.5 * mass * relative * (omega * omega * way_m + 2.0 * damping * omega * rate)
            })
            .boxed()
    }),
    Form::new("load_that_slips", D, |d| {
        let relative = d.size_below("relative", 0.07, 0.12, 0.4);
        let (holds, mass) = (d.shape("holds_m_s2", 0.3, 0.8), d.sheet.mass_kg);
        // The floor holds a part of the load up to its friction; what is beyond does not reach the wagon.
        law()
            .extra_mass(move |(), _| mass * relative)
            .body_force(move |(), now| {
                let beyond = now.acceleration_m_s2 - now.acceleration_m_s2.clamp(-holds, holds);
                0.6 * mass * relative * beyond
            })
            .boxed()
    }),
];

pub(super) const INERTIA: [Form; 4] = [
    Form::new("front_half_alone", A, |d| {
        let relative = d.size("relative", 0.4, 0.9);
        let half = d.sheet.wheelsets / 2;
        law().inertia(move |(), k, _| if k < half { 1.0 + relative } else { 1.0 + 0.3 * relative }).boxed()
    }),
    Form::new("behind_a_slipping_clutch", B, |d| {
        let (relative, slip_s) = (d.size("relative", 0.35, 0.8), d.shape("slip_s", 0.05, 0.2));
        let inertia = d.sheet.inertia_kg_m2 * relative;
        with_state([f64::NAN; 4])
            .advance(move |disc, now| {
                for (k, disc) in disc.iter_mut().enumerate().take(now.wheelsets) {
                    if disc.is_nan() {
                        *disc = now.wheel_speed_rad_s[k];
                    }
                    *disc += (1.0 - (-now.step_s / slip_s).exp()) * (now.wheel_speed_rad_s[k] - *disc);
                }
            })
            .drag_torque(move |disc, k, now| {
                let behind = now.wheel_speed_rad_s[k] - disc[k];
                if behind.is_nan() { 0.0 } else { inertia / slip_s * behind }
            })
            .boxed()
    }),
    Form::new("more_at_speed", C, |d| {
        let (relative, half) = (d.size("relative", 0.5, 1.1), d.shape("half_rad_s", 10.0, 40.0));
        law()
            .inertia(move |(), k, now| {
                let speed = now.wheel_speed_rad_s[k];
                1.0 + relative * (0.3 + 0.7 * speed / (speed + half))
            })
            .boxed()
    }),
    Form::new("gear_behind_its_play", D, |d| {
        let (relative, play) = (d.size("relative", 0.3, 0.7), d.shape("play", 0.05, 0.2));
        let full_nm = d.sheet.full_force_n() * d.sheet.pad_friction * d.sheet.brake_radius_m;
        // Teeth that touch turn the gear with the wheel; without torque they part.
        law()
            .inertia(move |(), k, now| {
                let torque = (now.brake_torque_nm[k] + now.drive_torque_nm[k].abs()) / (play * full_nm);
                1.0 + relative * (0.2 + 0.8 * torque.tanh())
            })
            .boxed()
    }),
];

pub(super) const RADIUS: [Form; 4] = [
    Form::new("wanders_with_the_track", A, |d| {
        let (wheelset, relative) = (d.wheelset(), d.signed_size("relative", 0.004, 0.010).clamp(-0.05, 0.05));
        let (share, wave_m) = (d.shape("share", 0.1, 0.35), d.shape("wave_m", 60.0, 400.0));
        radius(relative, move |k, now| {
            f64::from(u8::from(k == wheelset)) * (1.0 + share * (TAU * now.position_m / wave_m).sin())
        })
    }),
    Form::new("grows_with_heat", B, |d| {
        let (wheelset, relative) = (d.wheelset(), d.signed_size("relative", 0.004, 0.010).clamp(-0.05, 0.05));
        let warm_s = d.shape("warm_s", 20.0, 80.0);
        radius(relative, move |k, now| {
            f64::from(u8::from(k == wheelset)) * (1.2 - 0.4 * (-now.time_s / warm_s).exp())
        })
    }),
    Form::new("hollow_tread", C, |d| {
        let (wheelset, relative) = (d.wheelset(), d.signed_size("relative", 0.004, 0.010).clamp(-0.05, 0.05));
        let step_m = d.shape("step_m", 80.0, 250.0);
        // Runs on one flank of the tread or on the other.
        radius(relative, move |k, now| {
            let flank = (now.position_m / step_m).sin().signum();
            f64::from(u8::from(k == wheelset)) * (1.0 + 0.2 * flank)
        })
    }),
    Form::new("out_of_round", D, |d| {
        let (wheelset, relative) = (d.wheelset(), d.signed_size("relative", 0.004, 0.010).clamp(-0.05, 0.05));
        let (round, phase) = (d.shape("round", 0.15, 0.4), d.shape("phase_rad", 0.0, TAU));
        radius(relative, move |k, now| {
            f64::from(u8::from(k == wheelset)) * (1.0 + round * (now.wheel_angle_rad[k] + phase).sin())
        })
    }),
];

/// Which share of a relative error each wheelset has.
fn radius(relative: f64, share: impl Fn(usize, &Moment) -> f64 + Send + 'static) -> Box<dyn Departure> {
    law().radius(move |(), k, now| 1.0 + relative * share(k, now)).boxed()
}

pub(super) const RADIUS_OF_ALL: [Form; 4] = [
    Form::new("unevenly_worn", A, |d| {
        let relative = d.signed_size("relative", 0.006, 0.015).clamp(-0.06, 0.06);
        let uneven = d.shape("uneven", 0.05, 0.25);
        radius(relative, move |k, _| 1.0 + uneven * (1.7 * k as f64 + 0.5).sin())
    }),
    Form::new("wanders_with_the_track", B, |d| {
        let relative = d.signed_size("relative", 0.006, 0.015).clamp(-0.06, 0.06);
        let (share, wave_m) = (d.shape("share", 0.1, 0.3), d.shape("wave_m", 80.0, 400.0));
        radius(relative, move |_, now| 1.0 + share * (TAU * now.position_m / wave_m).sin())
    }),
    Form::new("grows_with_heat", C, |d| {
        let relative = d.signed_size("relative", 0.006, 0.015).clamp(-0.06, 0.06);
        let warm_s = d.shape("warm_s", 15.0, 60.0);
        radius(relative, move |_, now| 1.15 - 0.3 * (-now.time_s / warm_s).exp())
    }),
    // The faster the run, the nearer to the flange the wheels roll.
    Form::new("rolls_elsewhere_at_speed", D, |d| {
        let relative = d.signed_size("relative", 0.006, 0.015).clamp(-0.06, 0.06);
        let (part, half) = (d.shape("part", 0.2, 0.5), d.shape("half_m_s", 8.0, 20.0));
        radius(relative, move |_, now| {
            let x = now.v_m_s / half;
            1.0 + part * (x * x / (1.0 + x * x) - 0.5)
        })
    }),
];

pub(super) const TORSION: [Form; 4] = [
    Form::new("linear_shaft", A, |d| shaft(d, |twist, _| twist)),
    Form::new("shaft_with_backlash", B, |d| {
        shaft(d, |twist, scale| twist - twist.clamp(-0.3 * scale, 0.3 * scale))
    }),
    Form::new("stiffening_shaft", C, |d| {
        shaft(d, |twist, scale| twist * (0.7 + 0.5 * (twist / scale).powi(2).min(1.5)))
    }),
    Form::new("rubber_that_softens", D, |d| {
        shaft(d, |twist, scale| 0.9 * scale * (1.3 * twist / scale).asinh())
    }),
];

/// Disc, gear and encoder on one side of a soft shaft, the wheel on the other; `bend` shapes the twist (rad) at the scale
/// (rad) that full braking reaches.
fn shaft(d: &mut Draw, bend: fn(f64, f64) -> f64) -> Box<dyn Departure> {
    let scale = d.size("twist_at_full_brake_rad", 0.06, 0.14).max(0.004);
    let (disc_share, damping_ratio) = (d.shape("disc_share", 0.2, 0.4), d.shape("damping_ratio", 0.01, 0.04));
    let sheet = d.sheet;
    let inertia = disc_share * sheet.inertia_kg_m2;
    let stiffness = sheet.full_force_n() * sheet.pad_friction * sheet.brake_radius_m / scale;
    let omega = (stiffness / inertia).sqrt();
    // Stiff shafts are damped more: their twist is followed in steps.
    let damping = 2.0 * (damping_ratio + 1.2e-3 * omega) * inertia * omega;
    let transmitted = move |[twist, rate]: [f64; 2]| stiffness * bend(twist, scale) + damping * rate;
    // Twist and its rate, and wheel speeds of the step before.
    with_state(([[0.0f64; 2]; 4], [f64::NAN; 4]))
        .adapt(move |wagon| wagon.inertia_kg_m2.iter_mut().for_each(|wheel| *wheel *= 1.0 - disc_share))
        .advance(move |(twists, before), now| {
            let substeps = (now.step_s * omega / 0.1).ceil();
            let sub_s = now.step_s / substeps;
            for k in 0..now.wheelsets {
                let wheel_rad_s = now.wheel_speed_rad_s[k];
                let change = if before[k].is_nan() { 0.0 } else { (wheel_rad_s - before[k]) / substeps };
                before[k] = wheel_rad_s;
                for _ in 0..substeps as usize {
                    let [twist, rate] = twists[k];
                    let brake_nm = now.brake_torque_nm[k] * ((wheel_rad_s + rate) / 0.2).tanh();
                    let torque_nm = now.drive_torque_nm[k] - brake_nm - transmitted([twist, rate]);
                    let rate = rate + sub_s * torque_nm / inertia - change;
                    twists[k] = [twist + sub_s * rate, rate];
                }
            }
        })
        .shaft_torque(move |(twists, _), k, _, _| transmitted(twists[k]))
        .sense(|(twists, _), now, shown| {
            for k in 0..now.wheelsets {
                shown.wheel_speed_rad_s[k] += twists[k][1];
            }
        })
        .boxed()
}

/// Force of a neighbour that brakes differently, in retardation of the wagon (m/s²) times its mass (N).
fn push_n(d: &mut Draw) -> f64 {
    d.signed_size("m_s2", 0.08, 0.18) * d.sheet.mass_kg
}

pub(super) const COUPLER: [Form; 4] = [
    Form::new("push_that_relaxes", A, |d| {
        let (force_n, relax_s) = (push_n(d), d.shape("relax_s", 4.0, 14.0));
        let (rest, full_n) = (d.shape("rest", 0.2, 0.6), d.sheet.full_force_n());
        with_state((0.0f64, 0.0f64))
            .advance(move |(push, slow), now| {
                let demand = now.mean_force_n() / full_n;
                *push += now.step_s / 0.3 * (demand - *push);
                *slow += now.step_s / relax_s * (demand - *slow);
            })
            .body_force(move |(push, slow), now| force_n * (push - (1.0 - rest) * slow) * now.moving())
            .boxed()
    }),
    Form::new("wedge_friction", B, |d| {
        let force_n = push_n(d);
        let (wedge, full_n) = (d.shape("wedge", 0.15, 0.4), d.sheet.full_force_n());
        // The draw gear holds its force until the push has changed by the friction of its wedges.
        with_state(0.0f64)
            .advance(move |held, now| {
                let demand = now.mean_force_n() / full_n;
                let target = held.clamp(demand - wedge, demand + wedge);
                *held += now.step_s / 0.5 * (target - *held);
            })
            .body_force(move |held, now| force_n * held * (1.0 + 0.6 * held.abs()) * now.moving())
            .boxed()
    }),
    Form::new("surge", C, |d| {
        let (force_n, frequency_hz) = (push_n(d), d.shape("frequency_hz", 0.3, 1.2));
        let (damping, late_s) = (d.shape("damping", 0.05, 0.2), d.shape("late_s", 0.5, 2.0));
        let (omega, full_n) = (TAU * frequency_hz, d.sheet.full_force_n());
        // The train runs in: a lagged demand rings against the wagon's own.
        with_state((0.0f64, 0.0f64, 0.0f64))
            .advance(move |(late, x, rate), now| {
                let demand = now.mean_force_n() / full_n;
                *late += now.step_s / late_s * (demand - *late);
                let pull =
                    omega * omega * (demand - *late + 0.3 * demand - *x) - 2.0 * damping * omega * *rate;
                *rate += now.step_s * pull;
                *x += now.step_s * *rate;
            })
            .body_force(move |(_, x, _), now| 1.5 * force_n * x * now.moving())
            .boxed()
    }),
    Form::new("neighbour_that_bites_when_slow", D, |d| {
        let (force_n, late_s) = (push_n(d), d.shape("late_s", 0.8, 3.0));
        let (slow, full_n) = (d.shape("slow_m_s", 4.0, 10.0), d.sheet.full_force_n());
        // Cast iron beside discs: it pushes at speed and holds back before it stands.
        with_state(0.0f64)
            .advance(move |late, now| {
                *late += now.step_s / late_s * (now.mean_force_n() / full_n - *late);
            })
            .body_force(move |late, now| {
                force_n * late * (1.0 - 2.2 / (1.0 + (now.v_m_s / slow).powi(2))) * now.moving()
            })
            .boxed()
    }),
];

pub(super) const TRACK_BRAKE: [Form; 4] = [
    Form::new("logistic_of_demand", A, |d| {
        let (force_n, full_n) = (track_n(d), d.sheet.full_force_n());
        law()
            .body_force(move |(), now| {
                let engaged = 1.0 / (1.0 + (-(now.mean_force_n() / full_n - 0.65) / 0.03).exp());
                -force_n * engaged * now.moving()
            })
            .boxed()
    }),
    Form::new("on_and_off_apart", B, |d| {
        let (force_n, full_n, from) = (track_n(d), d.sheet.full_force_n(), d.shape("from", 0.5, 0.75));
        with_state(false)
            .advance(move |on, now| {
                let demand = now.mean_force_n() / full_n;
                *on = demand > if *on { 0.5 * from } else { from } && now.v_m_s > 4.0;
            })
            .body_force(move |on, now| if *on { -force_n * now.moving() } else { 0.0 })
            .boxed()
    }),
    Form::new("eddy_current", C, |d| {
        let (force_n, full_n, best) = (track_n(d), d.sheet.full_force_n(), d.shape("best_m_s", 8.0, 20.0));
        law()
            .body_force(move |(), now| {
                let x = now.v_m_s / best;
                let demand = (now.mean_force_n() / full_n - 0.4).max(0.0) / 0.6;
                -1.3 * force_n * demand * 2.0 * x / (1.0 + x * x)
            })
            .boxed()
    }),
    Form::new("magnets_that_grip_when_slow", D, |d| {
        let (force_n, full_n, from) = (track_n(d), d.sheet.full_force_n(), d.shape("from", 0.5, 0.75));
        let (lower_s, half) = (d.shape("lower_s", 0.3, 0.8), d.shape("half_m_s", 5.0, 15.0));
        // They come down one after the other and grip like iron on iron.
        with_state(0.0f64)
            .advance(move |down, now| {
                let wanted = f64::from(u8::from(now.mean_force_n() > from * full_n));
                *down += (wanted - *down).clamp(-now.step_s / lower_s, now.step_s / lower_s);
            })
            .body_force(move |down, now| {
                -force_n * down * (0.5 + 1.2 * half / (half + now.v_m_s)) * now.moving()
            })
            .boxed()
    }),
];

fn track_n(d: &mut Draw) -> f64 {
    d.size("m_s2", 0.06, 0.12) * d.sheet.mass_kg
}

pub(super) const UNEVEN_LOAD: [Form; 4] = [
    Form::new("from_the_front", A, |d| {
        let size = d.signed_size("size", 0.06, 0.15).clamp(-0.6, 0.6);
        uneven(move |k, last| size * (1.0 - 2.0 * k as f64 / last))
    }),
    Form::new("one_wheelset", B, |d| {
        let (wheelset, size) = (d.wheelset(), d.signed_size("size", 0.08, 0.2).clamp(-0.6, 0.6));
        uneven(move |k, last| if k == wheelset { size } else { -size / last })
    }),
    Form::new("outer_against_inner", C, |d| {
        let size = d.signed_size("size", 0.08, 0.2).clamp(-0.6, 0.6);
        uneven(move |k, last| {
            let outer = k == 0 || k as f64 == last;
            match (last > 1.5, outer) {
                (false, _) => size * (0.5 - k as f64),
                (true, true) => size,
                (true, false) => -size,
            }
        })
    }),
    // Springs of unlike height: every second wheelset carries more.
    Form::new("every_second", D, |d| {
        let size = d.signed_size("size", 0.08, 0.2).clamp(-0.6, 0.6);
        uneven(move |k, _| if k % 2 == 0 { size } else { -size })
    }),
];

/// Weight that does not rest evenly on the wheelsets; the changes of all sum to zero.
fn uneven(change: impl Fn(usize, f64) -> f64 + Send + 'static) -> Box<dyn Departure> {
    law()
        .adapt(move |wagon| {
            let last = wagon.wheelsets as f64 - 1.0;
            for k in 0..wagon.wheelsets {
                wagon.load_share[k] *= 1.0 + change(k, last);
            }
        })
        .boxed()
}

pub(super) const WEAK_DRIVE: [Form; 4] = [
    Form::new("constant_share", A, |d| {
        let loss = d.size_below("loss", 0.1, 0.2, 0.6);
        law().drive(move |(), _, _| 1.0 - loss).boxed()
    }),
    Form::new("weaker_at_speed", B, |d| {
        let (loss, from) = (d.size_below("loss", 0.15, 0.3, 0.8), d.shape("from_m_s", 3.0, 8.0));
        law().drive(move |(), _, now| 1.0 - loss * (1.0 - from / now.v_m_s.max(from))).boxed()
    }),
    Form::new("tires_with_use", C, |d| {
        let (loss, tire_s) = (d.size_below("loss", 0.15, 0.3, 0.8), d.shape("tire_s", 5.0, 15.0));
        let full_nm = d.sheet.drive_nm.max(1.0);
        with_state(0.0f64)
            .advance(move |used, now| {
                *used += now.step_s / tire_s * (now.drive_torque_nm[0] / full_nm - *used)
            })
            .drive(move |used, _, _| 1.0 - loss * used)
            .boxed()
    }),
    Form::new("saturates", D, |d| {
        let (loss, full_nm) = (d.size_below("loss", 0.2, 0.4, 0.8), d.sheet.drive_nm.max(1.0));
        law()
            .drive(move |(), k, now| {
                let asked = (now.drive_torque_nm[k] / full_nm).abs();
                1.0 - loss * asked * asked / (0.2 + asked * asked)
            })
            .boxed()
    }),
];
