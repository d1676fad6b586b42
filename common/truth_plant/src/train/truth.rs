//! What no sensor sees, wagon by wagon.

use super::{car::Car, dynamics::Body, units::PerWheelset};

/// Below this the truth names no pad friction, N.
const LEAST_PAD_FORCE_N: f64 = 2e3;

/// What no sensor of a wagon sees.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Truth {
    /// Time, s.
    pub time_s: f64,
    /// Speed, m/s.
    pub v_m_s: f64,
    /// Acceleration, m/s².
    pub acceleration_m_s2: f64,
    /// Utilised adhesion of the wagon, signed like the force.
    pub mu_w: f64,
    /// Utilised adhesion of each wheelset.
    pub mu_w_wheelset: PerWheelset,
    /// Friction that the rail offers each wheelset at rest.
    pub rail: PerWheelset,
    /// Friction of the pads; NaN below 2 kN of pad force.
    pub pad_friction: PerWheelset,
    /// Share of pad friction that fade takes.
    pub faded: PerWheelset,
    /// Pad force from the cylinders, N.
    pub pad_force_n: PerWheelset,
    /// Torque of the pads against the rotation, N m.
    pub braked_nm: PerWheelset,
    /// True wheel speeds, rad/s.
    pub wheel_speed_rad_s: PerWheelset,
    /// Slip velocity `r ω − v`, m/s.
    pub slip_m_s: PerWheelset,
    /// Contact forces, forward positive, N.
    pub contact_n: PerWheelset,
    /// Wheel loads, N.
    pub load_n: PerWheelset,
    /// Force in the coupler behind the wagon, tension positive, N.
    pub coupler_n: f64,
    /// Pad temperature, °C.
    pub temperature_c: PerWheelset,
    /// Whether its slide protection is at work.
    pub sliding: bool,
    /// Place of the head of the train, m.
    pub head_m: f64,
}

impl Truth {
    /// The truth of one wagon now.
    pub(crate) fn of(time_s: f64, head_m: f64, coupler_n: f64, body: &Body, car: &Car) -> Self {
        let wheelsets = 0..body.wheelsets;
        let mut truth = Self {
            time_s,
            head_m,
            coupler_n,
            v_m_s: body.v_m_s,
            acceleration_m_s2: body.acceleration_m_s2,
            mu_w: body.contact_n.iter().sum::<f64>() / body.load_n.iter().sum::<f64>(),
            wheel_speed_rad_s: body.wheel_speed_rad_s,
            contact_n: body.contact_n,
            braked_nm: body.braked_nm,
            load_n: body.load_n,
            rail: body.friction,
            pad_force_n: car.gear.pad_force_n,
            temperature_c: car.gear.temperature_c,
            faded: car.gear.faded,
            sliding: car.protection.active(),
            ..Self::default()
        };
        for k in wheelsets {
            truth.mu_w_wheelset[k] = body.contact_n[k] / body.load_n[k];
            truth.slip_m_s[k] = body.slip_m_s(k);
            let pressed = car.gear.pad_force_n[k] > LEAST_PAD_FORCE_N;
            truth.pad_friction[k] = if pressed { car.gear.friction[k] } else { f64::NAN };
        }
        truth
    }
}
