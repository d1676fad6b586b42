//! Departures that no id of the contract names: a diagnosis should say `unknown` and still find the term.

use std::f64::consts::TAU;

use super::Drawn;
use crate::{
    departure::{Departure, Moment, Sensed},
    random::Stream,
    sheet::Sheet,
};

/// A track brake that helps at full braking only.
pub(super) struct TrackBrake {
    pub force_n: f64,
    pub full_n: f64,
}

impl Departure for TrackBrake {
    fn body_force_n(&self, now: &Moment) -> f64 {
        let demand = now.cylinder_force_n.iter().sum::<f64>() / (2.0 * self.full_n);
        let engaged = 1.0 / (1.0 + (-(demand - 0.72) / 0.025).exp());
        -self.force_n * engaged * (now.v_m_s / 1.0).tanh()
    }
}

/// Pads that bite when they are fresh on the disc and ease within seconds, at every application anew.
pub(super) struct InitialBite {
    pub extra: f64,
    pub ease_s: f64,
    pub touch_n: f64,
    pub contact_s: [f64; 2],
}

impl Departure for InitialBite {
    fn begin(&mut self) {
        self.contact_s = [0.0; 2];
    }

    fn advance(&mut self, now: &Moment) {
        for wheelset in 0..2 {
            let touching = now.cylinder_force_n[wheelset] > self.touch_n;
            self.contact_s[wheelset] = if touching { self.contact_s[wheelset] + now.step_s } else { 0.0 };
        }
    }

    fn pad_friction(&self, wheelset: usize, _now: &Moment) -> f64 {
        1.0 + self.extra * (-self.contact_s[wheelset] / self.ease_s).exp()
    }
}

/// A disc whose friction varies around it, beating slowly against the pad carrier.
pub(super) struct UnevenDisc {
    pub amplitude: f64,
    pub turns: f64,
    pub phase_rad: f64,
}

impl Departure for UnevenDisc {
    fn pad_friction(&self, wheelset: usize, now: &Moment) -> f64 {
        1.0 + self.amplitude * (now.wheel_angle_rad[wheelset] / self.turns + self.phase_rad).sin()
    }
}

/// Cold bearings: stiff when the run begins, free after some way.
pub(super) struct ColdBearings {
    pub force_n: f64,
    pub way_m: f64,
}

impl Departure for ColdBearings {
    fn body_force_n(&self, now: &Moment) -> f64 {
        -self.force_n * (-now.position_m / self.way_m).exp() * (now.v_m_s / 0.5).tanh()
    }
}

/// A wheel that conditions its own contact: adhesion rises with the work it has burnt, and is forgotten in rolling.
pub(super) struct Conditioning {
    pub gain: f64,
    pub work_j: f64,
    pub forget_s: f64,
    pub burnt_j: [f64; 2],
}

impl Departure for Conditioning {
    fn begin(&mut self) {
        self.burnt_j = [0.0; 2];
    }

    fn advance(&mut self, now: &Moment) {
        for wheelset in 0..2 {
            let burnt = self.burnt_j[wheelset];
            self.burnt_j[wheelset] += now.step_s * (now.sliding_power_w[wheelset] - burnt / self.forget_s);
        }
    }

    fn rail_friction(&self, wheelset: usize, _slip_velocity_m_s: f64, _now: &Moment) -> f64 {
        let burnt = self.burnt_j[wheelset];
        1.0 + self.gain * burnt / (burnt + self.work_j)
    }
}

/// A radar that looks at sleepers: its reading swings with the place.
pub(super) struct SleeperRadar {
    pub amplitude: f64,
    pub wavelength_m: f64,
}

impl Departure for SleeperRadar {
    fn sense(&mut self, now: &Moment, shown: &mut Sensed) {
        shown.v_m_s *= 1.0 + self.amplitude * (TAU * now.position_m / self.wavelength_m).sin();
    }
}

/// A tachometer on one wheelset that reads low while its brake is on.
pub(super) struct DisturbedTachometer {
    pub wheelset: usize,
    pub relative: f64,
    pub full_n: f64,
}

impl Departure for DisturbedTachometer {
    fn sense(&mut self, now: &Moment, shown: &mut Sensed) {
        let demand = now.cylinder_force_n[self.wheelset] / self.full_n;
        shown.wheel_speed_rad_s[self.wheelset] *= 1.0 - self.relative * demand;
    }
}

/// A drive that gives less torque than it reports.
pub(super) struct WeakDrive {
    pub loss: f64,
}

impl Departure for WeakDrive {
    fn drive(&self, _wheelset: usize, _now: &Moment) -> f64 {
        1.0 - self.loss
    }
}

/// A leaking cylinder behind its pressure sensor: the longer a wheelset brakes, the less its pads press.
pub(super) struct LeakingCylinder {
    pub wheelset: usize,
    pub leak_s: f64,
    pub held_s: f64,
    pub touch_n: f64,
}

impl Departure for LeakingCylinder {
    fn begin(&mut self) {
        self.held_s = 0.0;
    }

    fn advance(&mut self, now: &Moment) {
        let held = now.cylinder_force_n[self.wheelset] > self.touch_n;
        self.held_s = if held { self.held_s + now.step_s } else { 0.0 };
    }

    fn pad_force_n(&self, wheelset: usize, cylinder_n: f64, _now: &Moment) -> f64 {
        if wheelset == self.wheelset { cylinder_n * (-self.held_s / self.leak_s).exp() } else { cylinder_n }
    }
}

pub(super) fn track_brake(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let force_n = strength * sheet.mass_kg * stream.uniform(0.06, 0.12);
    (Box::new(TrackBrake { force_n, full_n: sheet.full_force_n() }), vec![("force_n", force_n)])
}

pub(super) fn initial_bite(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let (extra, ease_s) = (strength * stream.uniform(0.12, 0.25), stream.uniform(1.0, 2.5));
    let touch_n = 0.03 * sheet.full_force_n();
    let departure = InitialBite { extra, ease_s, touch_n, contact_s: [0.0; 2] };
    (Box::new(departure), vec![("extra", extra), ("ease_s", ease_s)])
}

pub(super) fn uneven_disc(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let departure = UnevenDisc {
        amplitude: (strength * stream.uniform(0.12, 0.2)).min(0.6),
        turns: stream.uniform(14.0, 30.0),
        phase_rad: stream.uniform(0.0, TAU),
    };
    let parameters = vec![("amplitude", departure.amplitude), ("turns", departure.turns)];
    (Box::new(departure), parameters)
}

pub(super) fn cold_bearings(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let force_n = strength * sheet.mass_kg * stream.uniform(0.06, 0.12);
    let way_m = stream.uniform(90.0, 250.0);
    (Box::new(ColdBearings { force_n, way_m }), vec![("force_n", force_n), ("way_m", way_m)])
}

pub(super) fn conditioning(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let departure = Conditioning {
        gain: strength * stream.uniform(0.3, 0.6),
        work_j: sheet.mass_kg * stream.uniform(0.6, 2.0),
        forget_s: stream.uniform(3.0, 8.0),
        burnt_j: [0.0; 2],
    };
    let parameters = vec![("gain", departure.gain), ("work_j", departure.work_j)];
    (Box::new(departure), parameters)
}

pub(super) fn sleeper_radar(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let departure = SleeperRadar {
        amplitude: strength * stream.uniform(0.012, 0.022),
        wavelength_m: stream.uniform(12.0, 60.0),
    };
    let parameters = vec![("amplitude", departure.amplitude), ("wavelength_m", departure.wavelength_m)];
    (Box::new(departure), parameters)
}

pub(super) fn disturbed_tachometer(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let departure = DisturbedTachometer {
        wheelset: stream.below(2),
        relative: strength * stream.uniform(0.01, 0.02),
        full_n: sheet.full_force_n(),
    };
    let parameters = vec![("wheelset", departure.wheelset as f64), ("relative", departure.relative)];
    (Box::new(departure), parameters)
}

pub(super) fn weak_drive(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let loss = (strength * stream.uniform(0.1, 0.2)).min(0.6);
    (Box::new(WeakDrive { loss }), vec![("loss", loss)])
}

pub(super) fn leaking_cylinder(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let departure = LeakingCylinder {
        wheelset: stream.below(2),
        leak_s: stream.uniform(35.0, 60.0) / strength,
        held_s: 0.0,
        touch_n: 0.03 * sheet.full_force_n(),
    };
    let parameters = vec![("wheelset", departure.wheelset as f64), ("leak_s", departure.leak_s)];
    (Box::new(departure), parameters)
}
