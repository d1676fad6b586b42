//! Derivatives of the speeds after one sample: what a filter needs of a step, and what carries a small change of the model
//! through a run beside one simulation.

use super::SampleStep;
use super::quantities::{SPEEDS, WHEELSETS};
use super::{Loading, WagonState};
use crate::adhesion::creep_force_pair_at;
use crate::{CREEPAGE_SPEED_FLOOR_M_S, PerWheelset};
use wide::f64x2;

/// Derivatives of the speeds at the end of a sample: of the vehicle, m/s, then of each wheelset, rad/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slopes {
    /// Over the same speeds at its start.
    pub by_speed: [[f64; SPEEDS]; SPEEDS],
    /// Over the torque on each wheelset, forward positive, per N m.
    pub by_torque: [[f64; WHEELSETS]; SPEEDS],
    /// Over the adhesion available under each wheelset.
    pub by_adhesion: [[f64; WHEELSETS]; SPEEDS],
    /// Over a force on the body, forward positive, per N.
    pub by_force: [f64; SPEEDS],
}

/// Relative change of adhesion over which creep is differenced.
const CHANGE: f64 = 1e-4;

impl SampleStep<'_, 1> {
    /// Derivatives of [`SampleStep::advance`] over what enters it, with creep as steep throughout the sample as at its
    /// start (the linear part of the step, an exponential Euler step).
    pub fn slopes(
        &self,
        state: &WagonState,
        load_n: &PerWheelset,
        loading: &Loading,
        acceleration_m_s2: f64,
    ) -> Slopes {
        let (constants, h) = (self.constants, self.dt_s);
        let reference = (state.v_m_s + 0.5 * h * acceleration_m_s2).max(CREEPAGE_SPEED_FLOOR_M_S);
        let two = |values: &PerWheelset| f64x2::from([values[0], values[1]]);
        let (load, peak) = (two(load_n), two(&loading.adhesion_peak));
        let radius = two(&constants.wheel_radius_m);
        let slip = radius * two(&state.wheel_speed_rad_s) - state.v_m_s;
        let creep = |peak| creep_force_pair_at(&constants.contact, slip, reference, load, peak);
        let ((force, slope), (more, _)) = (creep(peak), creep(peak * (1.0 + CHANGE)));
        let by_peak = ((more - force) / (peak * CHANGE)).to_array();
        let slope = slope.to_array();
        let drag = self.drag(state.v_m_s, loading);
        let per_mass = 1.0 / constants.mass_kg;
        // Change of each slip per unit of: v, ω, torque, adhesion, force.
        let mut slips = [Row::default(); WHEELSETS];
        let mut turning = [true; WHEELSETS];
        for i in 0..WHEELSETS {
            let (r, inertia) = (constants.wheel_radius_m[i], constants.inertia_kg_m2[i]);
            let held = loading.brake_torque_nm[i] > 0.0 && state.wheel_speed_rad_s[i] == 0.0;
            turning[i] = !held;
            let kappa = r * r / inertia + per_mass;
            let stiff = kappa * slope[i] * h;
            let one = if stiff.abs() < 1e-6 { 1.0 } else { -(-stiff).exp_m1() / stiff } * h;
            let row = &mut slips[i];
            // Own slip decays; the other wheelsets and the body's drag move the body under it. Creep is referred to v, too,
            // F ∝ 1/v where it is steep: next to nothing beside what slip itself does.
            let left = 1.0 - one * kappa * slope[i];
            row.speed[1 + i] += left * r;
            row.speed[0] += drag * per_mass * one - left;
            for j in (0..WHEELSETS).filter(|j| *j != i) {
                let pull = one * per_mass;
                row.speed[1 + j] -= pull * slope[j] * constants.wheel_radius_m[j];
                row.speed[0] += pull * slope[j];
                row.adhesion[j] -= pull * by_peak[j];
            }
            row.torque[i] += one * r / inertia;
            row.adhesion[i] -= one * kappa * by_peak[i];
            row.force -= one * per_mass;
        }
        // Momentum m v + Σ J ω / r changes by outer forces only; ω = (w + v) / r.
        let mut moving = constants.mass_kg;
        let mut body = Row::default();
        body.speed[0] = constants.mass_kg - h * drag;
        body.force = h;
        for i in 0..WHEELSETS {
            let (r, inertia) = (constants.wheel_radius_m[i], constants.inertia_kg_m2[i]);
            if !turning[i] {
                // A held wheelset hands its contact force to the body.
                body.speed[0] -= h * slope[i];
                body.adhesion[i] += h * by_peak[i];
                continue;
            }
            let turning_kg = inertia / (r * r);
            moving += turning_kg;
            body.speed[1 + i] += inertia / r;
            body.torque[i] += h / r;
            body.add(&slips[i], -turning_kg);
        }
        body.scale(1.0 / moving);
        let mut all = Slopes::default();
        all.set(0, &body);
        for i in (0..WHEELSETS).filter(|i| turning[*i]) {
            let mut row = slips[i];
            row.add(&body, 1.0);
            row.scale(1.0 / constants.wheel_radius_m[i]);
            all.set(1 + i, &row);
        }
        all
    }
}

/// Derivatives of one quantity.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    speed: [f64; SPEEDS],
    torque: [f64; WHEELSETS],
    adhesion: [f64; WHEELSETS],
    force: f64,
}

impl Row {
    fn add(&mut self, other: &Self, factor: f64) {
        (0..SPEEDS).for_each(|j| self.speed[j] += factor * other.speed[j]);
        (0..WHEELSETS).for_each(|j| self.torque[j] += factor * other.torque[j]);
        (0..WHEELSETS).for_each(|j| self.adhesion[j] += factor * other.adhesion[j]);
        self.force += factor * other.force;
    }

    fn scale(&mut self, factor: f64) {
        self.speed.iter_mut().for_each(|x| *x *= factor);
        self.torque.iter_mut().for_each(|x| *x *= factor);
        self.adhesion.iter_mut().for_each(|x| *x *= factor);
        self.force *= factor;
    }
}

impl Slopes {
    fn set(&mut self, row: usize, of: &Row) {
        self.by_speed[row] = of.speed;
        self.by_torque[row] = of.torque;
        self.by_adhesion[row] = of.adhesion;
        self.by_force[row] = of.force;
    }
}
