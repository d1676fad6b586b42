//! What a bench found, put onto a vehicle: fitted constants into its own keys, effects in the forms that vehicles know.
//!
//! A bench picks among more forms than the catalogue of wagon effects has; the catalogue's law is fitted to the form that was
//! found, over the range that was measured. What no law of a vehicle can say is named and left out.

use crate::law_bench::data::case::{Kind, Nominal};
use crate::law_bench::model::candidates::{Form, Place, REFERENCE_SPEED_M_S, REFERENCE_TEMPERATURE_C};
use crate::law_bench::model::law::Model;
use railgrip_vehicle::adhesion::share_of_standstill;
use railgrip_vehicle::effects::{EffectSpec, find};
use railgrip_vehicle::{EffectEntry, VehicleParameters};

/// Points of the measured range at which laws are compared.
const POINTS: usize = 40;
/// Values tried for each parameter in a round, and rounds, each two thirds as wide.
const TRIED: usize = 11;
const ROUNDS: usize = 18;

/// Parameters and the bench's variable to a factor.
type Law = fn(&[f64], f64) -> f64;

/// What a bench says about a vehicle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Applied {
    /// Pad friction, from a brake bench.
    pub friction_coefficient: Option<f64>,
    /// Adhesion on dry rail, creep stiffness (N), k_A and k_S, from a creep bench.
    pub contact: Option<[f64; 4]>,
    /// Effects in the catalogue's forms.
    pub effects: Vec<EffectEntry>,
    /// Ids that no law of a vehicle can take, and why.
    pub left_out: Vec<String>,
}

impl Applied {
    /// From a fitted model.
    pub fn of(model: &Model, nominal: Nominal, values: &[f64]) -> Self {
        let mut applied = Self::default();
        let mut level = 1.0;
        let mut shape = None;
        for (index, form) in model.forms().iter().enumerate() {
            let own = model.values_of(index, values);
            if form.spec.place == Place::CreepShape {
                shape = Some([own[0], own[1]]);
                continue;
            }
            match law(form, own) {
                Ok((factor, entry)) => {
                    level *= factor;
                    applied.effects.push(entry);
                }
                Err(why) => applied.left_out.push(format!("{}: {why}", form.spec.id)),
            }
        }
        match (model.kind(), nominal) {
            (Kind::Brake, _) => applied.friction_coefficient = Some(values[0] * level),
            (Kind::Creep, Nominal::Creep { k_a, k_s, .. }) => {
                let [k_a, k_s] = shape.unwrap_or([k_a, k_s]);
                applied.contact = Some([values[0] * level, values[1], k_a, k_s]);
            }
            (Kind::Creep, Nominal::Brake { .. }) => {}
        }
        applied
    }

    /// The vehicle with it; an effect that it had already is replaced.
    pub fn onto(&self, vehicle: &VehicleParameters) -> VehicleParameters {
        let mut vehicle = vehicle.clone();
        if let Some(friction) = self.friction_coefficient {
            vehicle.brake.friction_coefficient = friction;
            vehicle.brake.friction_by_wheelset = None;
        }
        if let Some([mu0, stiffness_n, k_a, k_s]) = self.contact {
            vehicle.rail.dry = mu0;
            // The force knows K k_A and K k_S alone; a vehicle's k are at most 1.
            let largest = k_a.max(k_s).max(1.0);
            vehicle.contact.stiffness_n = stiffness_n * largest;
            (vehicle.contact.k_a, vehicle.contact.k_s) = (k_a / largest, k_s / largest);
        }
        let found = |id: &str| self.effects.iter().any(|entry| entry.id == id);
        vehicle.effects.retain(|entry| !found(&entry.id));
        vehicle.effects.extend(self.effects.iter().cloned());
        vehicle
    }
}

/// The catalogue's law of that id over the bench's variable.
fn law_of(id: &str) -> Option<Law> {
    let law: Law = match id {
        "brake_friction_speed" => |p: &[f64], v: f64| 1.0 + p[0] * (-v / p[1]).exp(),
        "brake_fade" => {
            |p: &[f64], celsius: f64| 1.0 - p[0] * (celsius - REFERENCE_TEMPERATURE_C - p[1]).max(0.0)
        }
        "brake_friction_pressure" => |p: &[f64], force_n: f64| (force_n.max(1.0) / 5e4).powf(-p[0]),
        "falling_friction" => |p: &[f64], slip_m_s: f64| (1.0 - p[0]) * (-p[1] * slip_m_s).exp() + p[0],
        "adhesion_speed" => |p: &[f64], v: f64| {
            let share = |v: f64| share_of_standstill(v, p[0], p[1]);
            share(v) / share(REFERENCE_SPEED_M_S)
        },
        _ => return None,
    };
    Some(law)
}

/// The level that goes with the catalogue's law, and the law with its parameters.
fn law(form: &Form, values: &[f64]) -> Result<(f64, EffectEntry), String> {
    let id = form.spec.id;
    let (Some(law), Some((spec, _))) = (law_of(id), find(id)) else {
        return Err("vehicles have no law for it".to_owned());
    };
    if id == "falling_friction" && !form.has_speed {
        return Err("the bench has no speed, so that creepage is no slip velocity".to_owned());
    }
    let spread = &form.scale.spread;
    let at = |k: usize| spread.low + (spread.high - spread.low) * k as f64 / (POINTS - 1) as f64;
    let wanted: Vec<(f64, f64)> =
        (0..POINTS).map(at).map(|x| (x, form.shape().factor(x, values, &form.scale))).collect();
    let (parameters, level) = fit(spec, law, &wanted);
    let named = spec.parameters.iter().zip(parameters).map(|(p, value)| (p.name.to_owned(), value));
    Ok((level, EffectEntry { id: id.to_owned(), parameters: named.collect() }))
}

/// Parameters of the law (those beyond the second keep their defaults) and the level, by least squares over ever finer grids.
fn fit(spec: &EffectSpec, law: Law, wanted: &[(f64, f64)]) -> (Vec<f64>, f64) {
    let limits: Vec<(f64, f64)> = spec.parameters.iter().take(2).map(|p| (p.lower, p.upper)).collect();
    let defaults: Vec<f64> = spec.parameters.iter().skip(2).map(|p| p.default).collect();
    let mut best = (f64::INFINITY, spec.parameters.iter().map(|p| p.default).collect::<Vec<f64>>(), 1.0);
    let mut boxes = limits.clone();
    for _ in 0..ROUNDS {
        let value = |(low, high): (f64, f64), k: usize| low + (high - low) * k as f64 / (TRIED - 1) as f64;
        for k in 0..TRIED.pow(limits.len() as u32) {
            let tried =
                boxes.iter().enumerate().map(|(i, limits)| value(*limits, k / TRIED.pow(i as u32) % TRIED));
            let parameters: Vec<f64> = tried.chain(defaults.iter().copied()).collect();
            let (error, level) = error(law, &parameters, wanted);
            if error < best.0 {
                best = (error, parameters, level);
            }
        }
        for ((limits, narrow), centre) in limits.iter().zip(&mut boxes).zip(&best.1) {
            let half = (narrow.1 - narrow.0) / 3.0;
            *narrow = ((centre - half).max(limits.0), (centre + half).min(limits.1));
        }
    }
    (best.1, best.2)
}

/// Squared error of the law at its best level, and that level.
fn error(law: Law, parameters: &[f64], wanted: &[(f64, f64)]) -> (f64, f64) {
    let (mut cross, mut square) = (0.0, 1e-12);
    for (x, y) in wanted {
        let f = law(parameters, *x);
        cross += f * y;
        square += f * f;
    }
    let level = cross / square;
    let errors = wanted.iter().map(|(x, y)| (y - level * law(parameters, *x)).powi(2));
    (errors.sum(), level)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_of_the_catalogue_is_found_again() {
        for (id, truth) in [
            ("brake_friction_speed", vec![0.4, 9.0]),
            ("brake_fade", vec![1.2e-3, 60.0]),
            ("brake_friction_pressure", vec![0.15]),
            ("falling_friction", vec![0.5, 0.4]),
            ("adhesion_speed", vec![0.03, 0.486]),
        ] {
            let (spec, _) = find(id).expect("in the catalogue");
            let law = law_of(id).expect("a law");
            let (low, high) = match id {
                "brake_fade" => (20.0, 400.0),
                "brake_friction_pressure" => (1e4, 6e4),
                _ => (0.0, 30.0),
            };
            let at = |k: usize| low + (high - low) * k as f64 / (POINTS - 1) as f64;
            let wanted: Vec<(f64, f64)> = (0..POINTS).map(at).map(|x| (x, 0.9 * law(&truth, x))).collect();
            let (found, level) = fit(spec, law, &wanted);
            println!("{id}: {found:?} at level {level:.4}, true {truth:?} at 0.9");
            let worst =
                wanted.iter().map(|(x, y)| (level * law(&found, *x) / y - 1.0).abs()).fold(0.0, f64::max);
            assert!(worst < 0.01, "{id}: {worst}");
        }
    }
}
