//! Load: by its sensors, by acceleration of a wagon that runs alone, and by brakes that press as the load asks.

use super::limits::{
    ALONE, BESIDE, BLENDED_S, LOAD, LOAD_ALONE, LOAD_PRESSED, LOAD_UNKNOWN, LOCOMOTIVES, PRESSED_APART,
};
use crate::cause::{Cause, Grade};
use crate::robust::{median, spread};
use crate::watch::{TrainWatch, Wagon};

impl TrainWatch {
    /// By load sensors, and by how a wagon that runs alone accelerates.
    pub(crate) fn judge_load(&mut self, index: usize) {
        let wagon = &self.wagons[index];
        let (mean_kg, count) = wagon.load_kg;
        let share = mean_kg / wagon.file.mass_kg - 1.0;
        if count > 60.0 && share.abs() > LOAD.max(3.0 * wagon.file.mass_sigma.hypot(0.02)) {
            let reason = format!("load sensors differ by {:+.0} % from what was entered", 100.0 * share);
            self.suspect(Cause::Payload, (index, vec![]), (Grade::Watch, 0.96, 2), &[], reason);
        }
        let Some(mass) = self.wagons[index].balance.as_ref().map(|balance| balance.mass()) else { return };
        let (off, sigma) = (mass.value, mass.variance.sqrt());
        let allowed = 3.0 * self.wagons[index].file.mass_sigma.hypot(0.02);
        if self.brakings >= 2 && off.abs() > allowed.max(LOAD_ALONE) && off.abs() > 5.0 * sigma {
            let reason = format!("it accelerates as if {:+.0} % heavier than entered", 100.0 * off);
            self.suspect(Cause::Payload, (index, vec![]), (Grade::Watch, 0.85, 3), &[], reason);
        }
    }

    /// By pressing forces. Brakes that weigh their wagon press in proportion to what it really weighs, so that force over the
    /// mass in the file is alike along the train; where it is not, as with brakes that do not weigh, nothing is said.
    pub(crate) fn judge_pressed(&mut self) {
        // A few that drive among many that do not are locomotives, whose brakes are of another kind.
        let driving = self.wagons.iter().filter(|wagon| wagon.drives).count();
        let locomotives = (driving as f64) < LOCOMOTIVES * self.wagons.len() as f64;
        let pressed: Vec<(usize, f64, f64)> = self
            .wagons
            .iter()
            .enumerate()
            .filter(|(_, wagon)| !((locomotives || self.blended_s > BLENDED_S) && wagon.drives))
            .filter_map(pressed)
            .collect();
        // A few wagons say little of what is usual.
        if pressed.len() < 4 {
            return;
        }
        let beside = |one: &(usize, f64, f64)| {
            let others = pressed.iter().filter(|other| other.0 != one.0);
            let (weight, sum) = others.fold((0.0, 0.0), |(weight, sum), (_, share, variance)| {
                (weight + 1.0 / variance, sum + share / variance)
            });
            let usual = sum / weight;
            (one.0, one.1 / usual - 1.0, (one.2 + 1.0 / weight).sqrt())
        };
        // A share of a share: where nobody knows the loads, a full wagon among empty ones is three times what is usual, and no more
        // improbable than an empty one among full ones.
        let sigmas = |off: f64, sigma: f64| off.ln_1p() / sigma;
        let apart: Vec<(usize, f64, f64)> = pressed.iter().map(beside).collect();
        // How far wagons lie from one another in sigmas of their entries: brakes that do not weigh show here.
        let beyond = spread(apart.iter().map(|(_, off, sigma)| sigmas(*off, *sigma)), 4).max(1.0);
        // Driven wagons may brake electrically for those that are not, so that a wagon must stand out among its own kind, too.
        let among_alike = |index: usize, share: f64| {
            let alike = pressed.iter().filter(|(other, ..)| {
                *other != index && self.wagons[*other].drives == self.wagons[index].drives
            });
            let mut shares: Vec<f64> = alike.map(|(_, share, _)| *share).collect();
            if shares.len() < 2 { 0.0 } else { share / median(&mut shares) - 1.0 }
        };
        let far = |&(index, off, sigma): &(usize, f64, f64)| {
            let share = pressed.iter().find(|(other, ..)| *other == index)?.1;
            let off = nearer(off, among_alike(index, share));
            let stands_out = sigmas(off, sigma).abs() > LOAD_PRESSED.1 * beyond;
            (off.abs() > LOAD_PRESSED.0 && stands_out).then_some((index, off, sigma))
        };
        let Some((index, off, sigma)) = apart
            .iter()
            .filter_map(far)
            .max_by(|a, b| sigmas(a.1, a.2).abs().total_cmp(&sigmas(b.1, b.2).abs()))
        else {
            return;
        };
        // Where nobody knows the loads, several that stand out are how the train is loaded.
        let rivals =
            apart.iter().any(|one| one.0 != index && sigmas(one.1, one.2) / sigmas(off, sigma) > ALONE);
        if rivals && self.wagons[index].file.mass_sigma > LOAD_UNKNOWN {
            return;
        }
        let reason =
            format!("its brakes press as if it weighed {:.0} % of what was entered", 100.0 * (1.0 + off));
        self.suspect(Cause::Payload, (index, vec![]), (Grade::Watch, 0.9, 2), &[], reason);
    }
}

/// The one that is nearer to nothing, and nothing where they differ in sign.
fn nearer(a: f64, b: f64) -> f64 {
    if a * b <= 0.0 {
        0.0
    } else if a.abs() < b.abs() {
        a
    } else {
        b
    }
}

/// Nominal braking force at a full order over the mass in the file, with its variance: by that of the mass, relative, and of
/// distributors.
fn pressed((index, wagon): (usize, &Wagon)) -> Option<(usize, f64, f64)> {
    let file = &wagon.file;
    // What one wheelset alone lacks is its cylinder's, and the mean of two lacks half of it.
    let wheels = 0..wagon.wheel.len();
    if wheels.filter_map(|k| wagon.pressure.beside(k)).any(|it| it.ratio < BESIDE.0 || it.ratio > BESIDE.1) {
        return None;
    }
    let force_n = wagon.pressure.per_order_n()? * wagon.wheel.len() as f64;
    let share = force_n * file.pad_friction * file.pad_radius_m / (file.radius_m * file.mass_kg);
    Some((index, share, file.mass_sigma.powi(2) + PRESSED_APART * PRESSED_APART))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::{Reading, WagonFile};

    /// Of two wheelsets one loses a third of its pressure, which makes a sixth of what the wagon presses: that is its cylinder, and no
    /// load.
    #[test]
    fn a_wheelset_that_lost_pressure_says_nothing_of_the_load() {
        let file = WagonFile {
            wheelsets: 2,
            mass_kg: 20e3,
            mass_sigma: 0.015,
            radius_m: 0.45,
            inertia_kg_m2: 100.0,
            pad_radius_m: 0.25,
            pad_friction: 0.35,
            compliance_per_n: 1.7e-7,
            resistance: [500.0, 5.0, 2.0],
            speed_sigma_m_s: 0.03,
            wheel_speed_sigma_rad_s: 0.03,
        };
        let share = |ratio: f64| {
            let mut watch = TrainWatch::new(vec![file.clone()]);
            for step in 0..300 {
                let mut reading =
                    Reading { v_m_s: 10.0, brake_demand: 0.6, grade_rad: 0.0, ..Reading::default() };
                reading.pressing_force_n[..2].copy_from_slice(&[18e3, ratio * 18e3]);
                reading.wheel_speed_rad_s[..2].fill(10.0 / 0.45);
                watch.take(0.2 * f64::from(step), &[reading]);
            }
            pressed((0, &watch.wagons[0])).map(|(_, share, _)| share)
        };
        let whole = 2.0 * 30e3 * 0.35 * 0.25 / (0.45 * 20e3);
        assert!(share(1.0).is_some_and(|share| (share / whole - 1.0).abs() < 0.02), "{:?}", share(1.0));
        assert_eq!(share(0.66), None);
    }
}
