//! Departures of masses, loads, wheels and shafts, and of the forces on the body.

use std::f64::consts::TAU;

use super::Drawn;
use crate::{
    departure::{Departure, Moment, Sensed},
    random::Stream,
    sheet::Sheet,
    wagon::TrueWagon,
};

/// The body leans more (or less) on the leading wheelset than its centre of mass says (payload height, pitching bogies).
pub(super) struct PitchingBody {
    pub factor: f64,
}

impl Departure for PitchingBody {
    fn load_transfer(&self, _now: &Moment) -> f64 {
        self.factor
    }
}

/// A load that the data sheet does not know.
pub(super) struct WrongMass {
    pub relative: f64,
}

impl Departure for WrongMass {
    fn adapt(&self, wagon: &mut TrueWagon) {
        wagon.mass_kg *= 1.0 + self.relative;
    }
}

/// More (or less) turning mass than the data sheet says.
pub(super) struct WrongInertia {
    pub relative: f64,
}

impl Departure for WrongInertia {
    fn adapt(&self, wagon: &mut TrueWagon) {
        wagon.inertia_kg_m2 = wagon.inertia_kg_m2.map(|inertia| inertia * (1.0 + self.relative));
    }
}

/// A wheelset turned down, or new.
pub(super) struct WornWheels {
    pub wheelset: usize,
    pub relative: f64,
}

impl Departure for WornWheels {
    fn adapt(&self, wagon: &mut TrueWagon) {
        wagon.radius_m[self.wheelset] *= 1.0 + self.relative;
    }
}

/// A soft shaft: disc, gear and encoder on one side, the wheel on the other.
pub(super) struct SoftShaft {
    pub disc_share: f64,
    pub disc_inertia_kg_m2: f64,
    pub frequency_rad_s: f64,
    pub damping_ratio: f64,
    /// Twist (rad) and disc speed less wheel speed (rad/s).
    pub twist: [[f64; 2]; 2],
    pub wheel_before: [f64; 2],
    pub started: bool,
}

impl SoftShaft {
    fn transmitted_nm(&self, wheelset: usize) -> f64 {
        let [twist, rate] = self.twist[wheelset];
        let stiffness = self.disc_inertia_kg_m2 * self.frequency_rad_s.powi(2);
        let damping = 2.0 * self.damping_ratio * self.disc_inertia_kg_m2 * self.frequency_rad_s;
        stiffness * twist + damping * rate
    }
}

impl Departure for SoftShaft {
    fn begin(&mut self) {
        self.twist = [[0.0; 2]; 2];
        self.started = false;
    }

    fn adapt(&self, wagon: &mut TrueWagon) {
        wagon.inertia_kg_m2 = wagon.inertia_kg_m2.map(|inertia| inertia * (1.0 - self.disc_share));
    }

    fn advance(&mut self, now: &Moment) {
        if !self.started {
            self.wheel_before = now.wheel_speed_rad_s;
            self.started = true;
        }
        for wheelset in 0..2 {
            let torque_nm = now.drive_torque_nm[wheelset] - now.brake_torque_nm[wheelset];
            let wheel_change = now.wheel_speed_rad_s[wheelset] - self.wheel_before[wheelset];
            let disc_change =
                now.step_s * (torque_nm - self.transmitted_nm(wheelset)) / self.disc_inertia_kg_m2;
            let [twist, rate] = self.twist[wheelset];
            let rate = rate + disc_change - wheel_change;
            self.twist[wheelset] = [twist + now.step_s * rate, rate];
        }
        self.wheel_before = now.wheel_speed_rad_s;
    }

    fn shaft_torque_nm(&self, wheelset: usize, _torque_nm: f64, _now: &Moment) -> f64 {
        self.transmitted_nm(wheelset)
    }

    fn sense(&mut self, _now: &Moment, shown: &mut Sensed) {
        for wheelset in 0..2 {
            shown.wheel_speed_rad_s[wheelset] += self.twist[wheelset][1];
        }
    }
}

/// The next wagon of the train, on a spring with slack, braking late and by another ratio.
pub(super) struct Neighbour {
    pub mass_kg: f64,
    pub stiffness_n_per_m: f64,
    pub damping_n_s_per_m: f64,
    pub slack_m: f64,
    pub late_s: f64,
    pub ratio: f64,
    pub own_mass_kg: f64,
    pub brake_n_per_n: f64,
    /// Stretch of the coupling (m), its rate (m/s) and the neighbour's brake build-up (N).
    pub stretch_m: f64,
    pub rate_m_s: f64,
    pub braking_n: f64,
}

impl Departure for Neighbour {
    fn begin(&mut self) {
        self.stretch_m = 0.0;
        self.rate_m_s = 0.0;
        self.braking_n = 0.0;
    }

    fn advance(&mut self, now: &Moment) {
        let wanted_n: f64 = now.cylinder_force_n.iter().sum::<f64>() * self.brake_n_per_n * self.ratio;
        self.braking_n += now.step_s / self.late_s * (wanted_n - self.braking_n);
        let force_n = self.body_force_n(now);
        let neighbour_m_s2 = (-self.braking_n * self.mass_kg / self.own_mass_kg - force_n) / self.mass_kg;
        self.rate_m_s += now.step_s * (neighbour_m_s2 - now.acceleration_m_s2);
        self.stretch_m += now.step_s * self.rate_m_s;
    }

    fn body_force_n(&self, _now: &Moment) -> f64 {
        let beyond_m = self.stretch_m.abs() - self.slack_m;
        if beyond_m <= 0.0 {
            return 0.0;
        }
        self.stiffness_n_per_m * beyond_m * self.stretch_m.signum() + self.damping_n_s_per_m * self.rate_m_s
    }
}

pub(super) fn load_transfer(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let high = stream.chance(0.7);
    let size = strength * stream.uniform(0.7, 1.1);
    let factor = if high { 1.0 + size } else { (1.0 - size).max(-1.0) };
    (Box::new(PitchingBody { factor }), vec![("factor", factor)])
}

pub(super) fn mass_error(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let relative = (strength * stream.sign() * stream.uniform(0.07, 0.12)).max(-0.3);
    (Box::new(WrongMass { relative }), vec![("relative", relative)])
}

pub(super) fn rotating_inertia(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let relative = strength * stream.uniform(0.15, 0.4);
    (Box::new(WrongInertia { relative }), vec![("relative", relative)])
}

pub(super) fn wheel_radius(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let wheelset = stream.below(2);
    let relative = strength * stream.sign() * stream.uniform(0.004, 0.012);
    let parameters = vec![("wheelset", wheelset as f64), ("relative", relative)];
    (Box::new(WornWheels { wheelset, relative }), parameters)
}

pub(super) fn coupler_force(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let mass_kg = sheet.mass_kg * stream.uniform(0.7, 1.3);
    let stiffness_n_per_m = mass_kg * stream.uniform(4.0, 7.0).powi(2);
    let ratio = 1.0 + strength * stream.sign() * stream.uniform(0.10, 0.2);
    let departure = Neighbour {
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

pub(super) fn axle_torsion(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let disc_share = (0.25 * strength).clamp(0.15, 0.45);
    let frequency_hz = stream.uniform(4.0, 8.0) / strength.sqrt();
    let departure = SoftShaft {
        disc_share,
        disc_inertia_kg_m2: sheet.inertia_kg_m2 * disc_share,
        frequency_rad_s: TAU * frequency_hz,
        damping_ratio: stream.uniform(0.02, 0.06),
        twist: [[0.0; 2]; 2],
        wheel_before: [0.0; 2],
        started: false,
    };
    (Box::new(departure), vec![("disc_share", disc_share), ("frequency_hz", frequency_hz)])
}
