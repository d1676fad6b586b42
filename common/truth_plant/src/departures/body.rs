//! Departures of masses, loads, wheels and shafts, and of the forces on the body.

use crate::{
    departure::{Departure, Moment, Sensed},
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
