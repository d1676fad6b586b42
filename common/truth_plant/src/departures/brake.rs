//! Departures of pad friction: speed, heat, pressure, water.

use super::Drawn;
use crate::{
    departure::{Departure, Moment},
    random::Stream,
    sheet::Sheet,
};

/// Friction that is higher at low sliding speed, with a Lorentzian Stribeck curve.
pub(super) struct Stribeck {
    pub rise: f64,
    pub width_m_s: f64,
    pub brake_radius_m: f64,
}

impl Stribeck {
    /// Sliding speed at which the level of the pad is quoted, m/s.
    const QUOTED_AT_M_S: f64 = 6.0;

    fn curve(&self, sliding_m_s: f64) -> f64 {
        1.0 + self.rise / (1.0 + (sliding_m_s / self.width_m_s).powi(2))
    }
}

impl Departure for Stribeck {
    fn pad_friction(&self, wheelset: usize, now: &Moment) -> f64 {
        self.curve(now.wheel_speed_rad_s[wheelset] * self.brake_radius_m) / self.curve(Self::QUOTED_AT_M_S)
    }
}

/// Fade: a thin hot layer on a thick disc, friction falling with the layer's temperature along a logistic (Arrhenius-like)
/// curve.
pub(super) struct Fade {
    pub depth: f64,
    pub midpoint_k: f64,
    pub width_k: f64,
    pub layer_j_per_k: f64,
    pub core_j_per_k: f64,
    pub conduction_w_per_k: f64,
    pub cooling_w_per_k: f64,
    /// Layer and core above ambient, K.
    pub heat: [[f64; 2]; 2],
}

impl Fade {
    fn curve(&self, above_ambient_k: f64) -> f64 {
        1.0 - self.depth / (1.0 + (-(above_ambient_k - self.midpoint_k) / self.width_k).exp())
    }
}

impl Departure for Fade {
    fn begin(&mut self) {
        self.heat = [[0.0; 2]; 2];
    }

    fn advance(&mut self, now: &Moment) {
        for wheelset in 0..2 {
            let [layer, core] = self.heat[wheelset];
            let power_w = now.brake_torque_nm[wheelset] * now.wheel_speed_rad_s[wheelset];
            let inward_w = self.conduction_w_per_k * (layer - core);
            let airflow = 0.3 + now.v_m_s / 30.0;
            self.heat[wheelset] = [
                layer + now.step_s * (power_w - inward_w) / self.layer_j_per_k,
                core + now.step_s * (inward_w - self.cooling_w_per_k * airflow * core) / self.core_j_per_k,
            ];
        }
    }

    fn pad_friction(&self, wheelset: usize, _now: &Moment) -> f64 {
        self.curve(self.heat[wheelset][0]) / self.curve(0.0)
    }
}

/// Friction that falls with pressing force as a hyperbola.
pub(super) struct PressureDependence {
    pub fall: f64,
    pub quoted_at_n: f64,
}

impl Departure for PressureDependence {
    fn pad_friction(&self, _wheelset: usize, now: &Moment) -> f64 {
        let force_n = now.cylinder_force_n.iter().sum::<f64>() / 2.0;
        (1.0 + self.fall) / (1.0 + self.fall * force_n / self.quoted_at_n)
    }
}

/// A water film on the disc that the first braking wears off, the slower the thinner it gets.
pub(super) struct WaterFilm {
    pub loss: f64,
    pub energy_j: f64,
    pub film: [f64; 2],
}

impl Departure for WaterFilm {
    fn begin(&mut self) {
        self.film = [1.0; 2];
    }

    fn advance(&mut self, now: &Moment) {
        for wheelset in 0..2 {
            let power_w = now.brake_torque_nm[wheelset] * now.wheel_speed_rad_s[wheelset];
            let film = self.film[wheelset];
            self.film[wheelset] = (film - now.step_s * power_w / self.energy_j * film.powf(1.25)).max(0.0);
        }
    }

    fn pad_friction(&self, wheelset: usize, _now: &Moment) -> f64 {
        1.0 - self.loss * self.film[wheelset]
    }
}

pub(super) fn brake_friction_speed(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let (rise, width_m_s) = (strength * stream.uniform(0.15, 0.3), stream.uniform(2.0, 6.0));
    let departure = Stribeck { rise, width_m_s, brake_radius_m: sheet.brake_radius_m };
    (Box::new(departure), vec![("rise", rise), ("width_m_s", width_m_s)])
}

pub(super) fn brake_fade(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let depth = (strength * stream.uniform(0.3, 0.5)).min(0.9);
    let core_j_per_k = sheet.mass_kg * stream.uniform(0.8, 1.3);
    let departure = Fade {
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

pub(super) fn brake_friction_pressure(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let fall = strength * stream.uniform(0.15, 0.35);
    let quoted_at_n = 0.6 * sheet.full_force_n();
    (Box::new(PressureDependence { fall, quoted_at_n }), vec![("fall", fall), ("quoted_at_n", quoted_at_n)])
}

pub(super) fn brake_wet_delay(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let loss = (strength * stream.uniform(0.2, 0.4)).min(0.75);
    let energy_j = sheet.mass_kg / 40e3 * stream.uniform(0.5e6, 1.3e6);
    (Box::new(WaterFilm { loss, energy_j, film: [1.0; 2] }), vec![("loss", loss), ("energy_j", energy_j)])
}
