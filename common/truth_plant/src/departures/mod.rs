//! The catalogue of departures: every id of the contract in this plant's own functional form, and a handful that no id
//! names. Each entry draws its parameters from a stream and scales its size by a strength.

mod actuation;
mod adhesion;
mod body;
mod brake;
mod nameless;
mod resistance;
mod sensors;

use crate::{departure::Departure, random::Stream, sheet::Sheet};

/// What a draw yields: the departure and its parameters by name, in this plant's own terms.
pub type Drawn = (Box<dyn Departure>, Vec<(&'static str, f64)>);

/// One entry of the catalogue.
#[derive(Clone, Copy)]
pub struct Kind {
    /// Id of the contract, or a name of its own for one that no id names.
    pub id: &'static str,
    /// Term of the equations.
    pub term: &'static str,
    /// Whether the contract has an id for it.
    pub named: bool,
    /// Whether it shows only on a vehicle with traction.
    pub needs_motor: bool,
    /// Whether it shows only on a vehicle with sanders.
    pub needs_sander: bool,
    /// Largest strength that is still plausible.
    pub strongest: f64,
    draw: fn(f64, &mut Stream, &Sheet) -> Drawn,
}

impl Kind {
    /// Draws the departure; the same stream and another strength give the same departure, larger or smaller.
    #[must_use]
    pub fn draw(&self, strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
        (self.draw)(strength, stream, sheet)
    }

    /// The entry of this id.
    #[must_use]
    pub fn of(id: &str) -> Option<Self> {
        CATALOGUE.iter().copied().find(|kind| kind.id == id)
    }
}

impl std::fmt::Debug for Kind {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.id)
    }
}

const fn named(
    id: &'static str,
    term: &'static str,
    strongest: f64,
    draw: fn(f64, &mut Stream, &Sheet) -> Drawn,
) -> Kind {
    Kind { id, term, named: true, needs_motor: false, needs_sander: false, strongest, draw }
}

const fn nameless(
    id: &'static str,
    term: &'static str,
    strongest: f64,
    draw: fn(f64, &mut Stream, &Sheet) -> Drawn,
) -> Kind {
    Kind { named: false, ..named(id, term, strongest, draw) }
}

/// Every departure this plant knows.
pub const CATALOGUE: [Kind; 36] = [
    named("brake_friction_speed", "brake_friction", 2.5, brake_friction_speed),
    named("brake_fade", "brake_friction", 2.0, brake_fade),
    named("brake_friction_pressure", "brake_friction", 2.5, brake_friction_pressure),
    named("brake_wet_delay", "brake_friction", 1.8, brake_wet_delay),
    named("brake_lag", "brake_actuation", 2.0, brake_lag),
    named("rigging_hysteresis", "brake_actuation", 2.5, rigging_hysteresis),
    named("pressing_force_offset", "brake_actuation", 3.0, pressing_force_offset),
    named("dragging_brake", "brake_actuation", 3.0, dragging_brake),
    named("falling_friction", "adhesion", 1.7, falling_friction),
    named("self_cleaning", "adhesion", 2.5, self_cleaning),
    named("low_adhesion_patch", "adhesion", 1.5, low_adhesion_patch),
    named("adhesion_speed", "adhesion", 3.0, adhesion_speed),
    Kind { needs_sander: true, ..named("sanding", "adhesion", 2.5, sanding) },
    named("load_transfer", "load_distribution", 3.0, load_transfer),
    Kind { needs_motor: true, ..named("mass_error", "inertia", 2.5, mass_error) },
    named("rotating_inertia", "inertia", 3.0, rotating_inertia),
    named("wheel_radius", "kinematics", 3.0, wheel_radius),
    named("grade", "resistance", 2.5, grade),
    named("running_resistance", "resistance", 3.0, running_resistance),
    named("headwind", "resistance", 2.0, headwind),
    named("coupler_force", "longitudinal_force", 2.5, coupler_force),
    named("wheel_encoder_eccentricity", "sensor_wheel_speed", 3.0, wheel_encoder_eccentricity),
    named("wheel_encoder_window", "sensor_wheel_speed", 3.0, wheel_encoder_window),
    named("clock_skew", "sensor_wheel_speed", 3.0, clock_skew),
    named("speed_latency", "sensor_speed", 2.5, speed_latency),
    named("speed_scale", "sensor_speed", 3.0, speed_scale),
    named("axle_torsion", "drivetrain", 2.0, axle_torsion),
    nameless("track_brake_at_full_braking", "longitudinal_force", 3.0, track_brake),
    nameless("initial_bite", "brake_friction", 2.5, initial_bite),
    nameless("pad_friction_periodic_with_wheel_angle", "brake_friction", 2.0, uneven_disc),
    nameless("cold_bearings", "resistance", 3.0, cold_bearings),
    nameless("contact_conditioning_by_sliding", "adhesion", 2.5, conditioning),
    nameless("speed_ripple_with_position", "sensor_speed", 3.0, sleeper_radar),
    nameless("tachometer_disturbed_by_braking", "sensor_wheel_speed", 3.0, disturbed_tachometer),
    Kind { needs_motor: true, ..nameless("drive_torque_short_of_command", "drivetrain", 3.0, weak_drive) },
    nameless("leaking_cylinder", "brake_actuation", 3.0, leaking_cylinder),
];

fn brake_friction_speed(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let (rise, width_m_s) = (strength * stream.uniform(0.15, 0.3), stream.uniform(2.0, 6.0));
    let departure = brake::Stribeck { rise, width_m_s, brake_radius_m: sheet.brake_radius_m };
    (Box::new(departure), vec![("rise", rise), ("width_m_s", width_m_s)])
}

fn brake_fade(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let depth = (strength * stream.uniform(0.3, 0.5)).min(0.9);
    let core_j_per_k = sheet.mass_kg * stream.uniform(0.8, 1.3);
    let departure = brake::Fade {
        depth,
        midpoint_k: stream.uniform(150.0, 230.0),
        width_k: stream.uniform(45.0, 80.0),
        layer_j_per_k: 0.25 * core_j_per_k,
        core_j_per_k,
        conduction_w_per_k: core_j_per_k / stream.uniform(15.0, 35.0),
        cooling_w_per_k: core_j_per_k / stream.uniform(250.0, 600.0),
        heat: [[0.0; 2]; 2],
    };
    let parameters =
        vec![("depth", depth), ("midpoint_k", departure.midpoint_k), ("width_k", departure.width_k)];
    (Box::new(departure), parameters)
}

fn brake_friction_pressure(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let fall = strength * stream.uniform(0.15, 0.35);
    let quoted_at_n = 0.6 * sheet.full_force_n();
    (
        Box::new(brake::PressureDependence { fall, quoted_at_n }),
        vec![("fall", fall), ("quoted_at_n", quoted_at_n)],
    )
}

fn brake_wet_delay(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let loss = (strength * stream.uniform(0.2, 0.4)).min(0.75);
    let energy_j = sheet.mass_kg / 40e3 * stream.uniform(0.5e6, 1.3e6);
    (
        Box::new(brake::WaterFilm { loss, energy_j, film: [1.0; 2] }),
        vec![("loss", loss), ("energy_j", energy_j)],
    )
}

fn brake_lag(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let dead_s = strength * stream.uniform(0.03, 0.12);
    let lag_s = strength * stream.uniform(0.12, 0.3);
    let departure = actuation::SlowRigging {
        dead_s,
        lag_s,
        waiting: std::collections::VecDeque::new(),
        first: [0.0; 2],
        second: [0.0; 2],
    };
    (Box::new(departure), vec![("dead_s", dead_s), ("lag_s", lag_s)])
}

fn rigging_hysteresis(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let relative = strength * stream.uniform(0.04, 0.09);
    let reversal_n = sheet.full_force_n() * stream.uniform(0.03, 0.08);
    let departure = actuation::DahlRigging { relative, reversal_n, side: [0.0; 2], before_n: [0.0; 2] };
    (Box::new(departure), vec![("relative", relative), ("reversal_n", reversal_n)])
}

fn pressing_force_offset(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let threshold_n = strength * sheet.full_force_n() * stream.uniform(0.04, 0.09);
    (Box::new(actuation::ReturnSpring { threshold_n }), vec![("threshold_n", threshold_n)])
}

fn dragging_brake(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let wheelset = stream.below(2);
    let torque_nm = strength * sheet.mass_kg * sheet.radius_m * stream.uniform(0.012, 0.03);
    let parameters = vec![("wheelset", wheelset as f64), ("torque_nm", torque_nm)];
    (Box::new(actuation::StuckBrake { wheelset, torque_nm }), parameters)
}

fn falling_friction(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let depth = (strength * stream.uniform(0.3, 0.5)).min(0.8);
    let half_m_s = stream.uniform(0.6, 2.5);
    (Box::new(adhesion::FallingFriction { depth, half_m_s }), vec![("depth", depth), ("half_m_s", half_m_s)])
}

fn self_cleaning(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let gain = strength * stream.uniform(0.15, 0.35);
    let share = stream.uniform(0.4, 0.8);
    let departure = adhesion::CleanedRail {
        rolling: gain * share,
        sliding: gain * (1.0 - share),
        power_w: sheet.mass_kg * stream.uniform(0.1, 0.4),
        smooth_s: 0.4,
        recent_w: 0.0,
    };
    let parameters = vec![("rolling", departure.rolling), ("sliding", departure.sliding)];
    (Box::new(departure), parameters)
}

fn low_adhesion_patch(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let loss = (strength * stream.uniform(0.4, 0.65)).min(0.85);
    let from_m = stream.uniform(120.0, 230.0);
    let to_m = from_m + stream.uniform(50.0, 130.0);
    let departure = adhesion::SlipperyStretch { loss, from_m, to_m, edge_m: stream.uniform(1.5, 5.0) };
    (Box::new(departure), vec![("loss", loss), ("from_m", from_m), ("to_m", to_m)])
}

fn adhesion_speed(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let speed_m_s = stream.uniform(30.0, 60.0) / strength;
    (Box::new(adhesion::SpeedDecay { speed_m_s }), vec![("speed_m_s", speed_m_s)])
}

fn sanding(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let gain = strength * stream.uniform(0.3, 0.6);
    let departure = adhesion::Sand {
        gain,
        fall_s: stream.uniform(0.4, 1.0),
        stay_s: stream.uniform(0.8, 2.0),
        cover: 0.0,
    };
    (Box::new(departure), vec![("gain", gain)])
}

fn load_transfer(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let factor = if stream.chance(0.4) {
        1.0 - (strength * stream.uniform(0.6, 1.0)).min(1.5)
    } else {
        1.0 + strength * stream.uniform(0.6, 1.2)
    };
    (Box::new(body::PitchingBody { factor }), vec![("factor", factor)])
}

fn mass_error(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let relative = (strength * stream.sign() * stream.uniform(0.07, 0.12)).max(-0.3);
    (Box::new(body::WrongMass { relative }), vec![("relative", relative)])
}

fn rotating_inertia(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let relative = strength * stream.uniform(0.15, 0.4);
    (Box::new(body::WrongInertia { relative }), vec![("relative", relative)])
}

fn wheel_radius(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let wheelset = stream.below(2);
    let relative = strength * stream.sign() * stream.uniform(0.004, 0.012);
    let parameters = vec![("wheelset", wheelset as f64), ("relative", relative)];
    (Box::new(body::WornWheels { wheelset, relative }), parameters)
}

fn grade(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let slope_rad = strength * stream.sign() * stream.uniform(0.003, 0.006);
    let from_m = stream.uniform(60.0, 260.0);
    let to_m = from_m + stream.uniform(120.0, 350.0);
    let departure =
        resistance::UnmappedSlope { slope_rad, from_m, to_m, round_m: stream.uniform(10.0, 30.0) };
    (Box::new(departure), vec![("slope_rad", slope_rad), ("from_m", from_m), ("to_m", to_m)])
}

fn running_resistance(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let extra_n = strength * sheet.mass_kg * stream.uniform(0.02, 0.04);
    let share = stream.uniform(0.2, 0.8);
    let (constant_n, at_20_m_s_n) = (extra_n * share, extra_n * (1.0 - share));
    let departure = resistance::StiffRunning { constant_n, at_20_m_s_n };
    (Box::new(departure), vec![("constant_n", constant_n), ("at_20_m_s_n", at_20_m_s_n)])
}

fn headwind(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let mean_m_s = strength * stream.uniform(6.0, 11.0);
    let departure = resistance::Wind {
        mean_m_s,
        stream: Stream::new(stream.below(1 << 30) as u64, "breath", 0),
        breath: None,
        now_m_s: mean_m_s,
        until_next: 0,
    };
    (Box::new(departure), vec![("mean_m_s", mean_m_s)])
}

fn coupler_force(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let mass_kg = sheet.mass_kg * stream.uniform(0.7, 1.3);
    let stiffness_n_per_m = mass_kg * stream.uniform(4.0, 7.0).powi(2);
    let ratio = 1.0 + strength * stream.sign() * stream.uniform(0.10, 0.2);
    let departure = body::Neighbour {
        mass_kg,
        stiffness_n_per_m,
        damping_n_s_per_m: stream.uniform(0.15, 0.3) * (stiffness_n_per_m * mass_kg).sqrt(),
        slack_m: stream.uniform(0.003, 0.012),
        late_s: strength.sqrt() * stream.uniform(0.3, 0.8),
        ratio,
        own_mass_kg: sheet.mass_kg,
        brake_n_per_n: sheet.pad_friction * sheet.brake_radius_m / sheet.radius_m,
        stretch_m: 0.0,
        rate_m_s: 0.0,
        braking_n: 0.0,
    };
    let parameters = vec![
        ("ratio", ratio),
        ("late_s", departure.late_s),
        ("stiffness_n_per_m", stiffness_n_per_m),
        ("slack_m", departure.slack_m),
    ];
    (Box::new(departure), parameters)
}

fn wheel_encoder_eccentricity(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let departure = sensors::OffCentreEncoder {
        wheelset: stream.below(2),
        amplitude: strength * stream.uniform(0.005, 0.010),
        phase_rad: stream.uniform(0.0, std::f64::consts::TAU),
        second_order: stream.uniform(0.05, 0.15),
    };
    let parameters = vec![
        ("wheelset", departure.wheelset as f64),
        ("amplitude", departure.amplitude),
        ("phase_rad", departure.phase_rad),
    ];
    (Box::new(departure), parameters)
}

fn wheel_encoder_window(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let window_s = strength * stream.uniform(0.08, 0.16);
    (
        Box::new(sensors::CountingWindow { window_s, past: std::collections::VecDeque::new() }),
        vec![("window_s", window_s)],
    )
}

fn clock_skew(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let drift = strength * stream.uniform(0.003, 0.007);
    let departure = sensors::SlowClock {
        drift,
        warming_per_s: stream.uniform(0.0, 0.004),
        past: std::collections::VecDeque::new(),
    };
    (Box::new(departure), vec![("drift", drift)])
}

fn speed_latency(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let latency_s = strength * stream.uniform(0.18, 0.35);
    let share = stream.uniform(0.5, 0.9);
    let departure = sensors::LateSpeed {
        delay_s: share * latency_s,
        smooth_s: (1.0 - share) * latency_s,
        past: std::collections::VecDeque::new(),
        smoothed: None,
    };
    (Box::new(departure), vec![("latency_s", latency_s)])
}

fn speed_scale(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let relative = strength * stream.sign() * stream.uniform(0.006, 0.015);
    let bend_per_m_s = stream.uniform(-0.004, 0.004);
    (Box::new(sensors::WrongScale { relative, bend_per_m_s }), vec![("relative", relative)])
}

fn axle_torsion(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let disc_share = (0.25 * strength).clamp(0.15, 0.45);
    let frequency_hz = stream.uniform(4.0, 8.0) / strength.sqrt();
    let departure = body::SoftShaft {
        disc_share,
        disc_inertia_kg_m2: sheet.inertia_kg_m2 * disc_share,
        frequency_rad_s: std::f64::consts::TAU * frequency_hz,
        damping_ratio: stream.uniform(0.02, 0.06),
        twist: [[0.0; 2]; 2],
        wheel_before: [0.0; 2],
        started: false,
    };
    (Box::new(departure), vec![("disc_share", disc_share), ("frequency_hz", frequency_hz)])
}

fn track_brake(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let force_n = strength * sheet.mass_kg * stream.uniform(0.06, 0.12);
    (Box::new(nameless::TrackBrake { force_n, full_n: sheet.full_force_n() }), vec![("force_n", force_n)])
}

fn initial_bite(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let (extra, ease_s) = (strength * stream.uniform(0.12, 0.25), stream.uniform(1.0, 2.5));
    let touch_n = 0.03 * sheet.full_force_n();
    let departure = nameless::InitialBite { extra, ease_s, touch_n, contact_s: [0.0; 2] };
    (Box::new(departure), vec![("extra", extra), ("ease_s", ease_s)])
}

fn uneven_disc(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let departure = nameless::UnevenDisc {
        amplitude: (strength * stream.uniform(0.12, 0.2)).min(0.6),
        turns: stream.uniform(14.0, 30.0),
        phase_rad: stream.uniform(0.0, std::f64::consts::TAU),
    };
    let parameters = vec![("amplitude", departure.amplitude), ("turns", departure.turns)];
    (Box::new(departure), parameters)
}

fn cold_bearings(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let force_n = strength * sheet.mass_kg * stream.uniform(0.06, 0.12);
    let way_m = stream.uniform(90.0, 250.0);
    (Box::new(nameless::ColdBearings { force_n, way_m }), vec![("force_n", force_n), ("way_m", way_m)])
}

fn conditioning(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let departure = nameless::Conditioning {
        gain: strength * stream.uniform(0.3, 0.6),
        work_j: sheet.mass_kg * stream.uniform(0.6, 2.0),
        forget_s: stream.uniform(3.0, 8.0),
        burnt_j: [0.0; 2],
    };
    let parameters = vec![("gain", departure.gain), ("work_j", departure.work_j)];
    (Box::new(departure), parameters)
}

fn sleeper_radar(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let departure = nameless::SleeperRadar {
        amplitude: strength * stream.uniform(0.012, 0.022),
        wavelength_m: stream.uniform(12.0, 60.0),
    };
    let parameters = vec![("amplitude", departure.amplitude), ("wavelength_m", departure.wavelength_m)];
    (Box::new(departure), parameters)
}

fn disturbed_tachometer(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let departure = nameless::DisturbedTachometer {
        wheelset: stream.below(2),
        relative: strength * stream.uniform(0.01, 0.02),
        full_n: sheet.full_force_n(),
    };
    let parameters = vec![("wheelset", departure.wheelset as f64), ("relative", departure.relative)];
    (Box::new(departure), parameters)
}

fn weak_drive(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let loss = (strength * stream.uniform(0.1, 0.2)).min(0.6);
    (Box::new(nameless::WeakDrive { loss }), vec![("loss", loss)])
}

fn leaking_cylinder(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let departure = nameless::LeakingCylinder {
        wheelset: stream.below(2),
        leak_s: stream.uniform(35.0, 60.0) / strength,
        held_s: 0.0,
        touch_n: 0.03 * sheet.full_force_n(),
    };
    let parameters = vec![("wheelset", departure.wheelset as f64), ("leak_s", departure.leak_s)];
    (Box::new(departure), parameters)
}
