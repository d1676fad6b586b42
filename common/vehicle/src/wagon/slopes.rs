//! Derivatives of the speeds after one sample: what a filter needs of a step, and what carries a small change of the model
//! through a run beside one simulation.

use super::SampleStep;
use super::{Loading, WagonState};
use crate::adhesion::creep_force_pair_at;
use crate::{CREEPAGE_SPEED_FLOOR_M_S, PerWheelset};
use wide::f64x2;

/// Derivatives of the speeds at the end of a sample: of the vehicle, m/s, then of each wheelset, rad/s. `S` is `1 + W`; what
/// belongs to wheelsets that the wagon has not got is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slopes<const W: usize, const S: usize> {
    /// Over the same speeds at its start.
    pub by_speed: [[f64; S]; S],
    /// Over the torque on each wheelset, forward positive, per N m.
    pub by_torque: [[f64; W]; S],
    /// Over the adhesion available under each wheelset.
    pub by_adhesion: [[f64; W]; S],
    /// Over a force on the body, forward positive, per N.
    pub by_force: [f64; S],
}

impl<const W: usize, const S: usize> Default for Slopes<W, S> {
    fn default() -> Self {
        Self {
            by_speed: [[0.0; S]; S],
            by_torque: [[0.0; W]; S],
            by_adhesion: [[0.0; W]; S],
            by_force: [0.0; S],
        }
    }
}

/// Relative change of adhesion over which creep is differenced.
const CHANGE: f64 = 1e-4;

impl<const PAIRS: usize> SampleStep<'_, PAIRS> {
    /// Derivatives of [`SampleStep::advance`] over what enters it, with creep as steep throughout the sample as at its
    /// start (the linear part of the step, an exponential Euler step).
    pub fn slopes<const W: usize, const S: usize>(
        &self,
        state: &WagonState,
        load_n: &PerWheelset,
        loading: &Loading,
        acceleration_m_s2: f64,
    ) -> Slopes<W, S> {
        let (constants, h) = (self.constants, self.dt_s);
        let count = constants.wheelsets.min(W);
        let reference = (state.v_m_s + 0.5 * h * acceleration_m_s2).max(CREEPAGE_SPEED_FLOOR_M_S);
        // Slopes of the contact force over slip and over adhesion available.
        let (mut slope, mut by_peak) = ([0.0; W], [0.0; W]);
        for from in (0..count).step_by(2) {
            let two = |values: &PerWheelset| f64x2::from([values[from], values[from + 1]]);
            let (load, peak) = (two(load_n), two(&loading.adhesion_peak));
            let radius = two(&constants.wheel_radius_m);
            let slip = radius * two(&state.wheel_speed_rad_s) - state.v_m_s;
            let creep = |peak| creep_force_pair_at(&constants.contact, slip, reference, load, peak);
            let ((force, slopes), (more, _)) = (creep(peak), creep(peak * (1.0 + CHANGE)));
            let (slopes, by_peaks) = (slopes.to_array(), ((more - force) / (peak * CHANGE)).to_array());
            for lane in 0..(count - from).min(2) {
                (slope[from + lane], by_peak[from + lane]) = (slopes[lane], by_peaks[lane]);
            }
        }
        let drag = self.drag(state.v_m_s, loading);
        let per_mass = 1.0 / constants.mass_kg;
        // Change of each slip per unit of: v, ω, torque, adhesion, force.
        let mut slips = [Row::<W, S>::default(); W];
        let mut turning = [false; W];
        for i in 0..count {
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
            for j in (0..count).filter(|j| *j != i) {
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
        let mut body = Row::<W, S>::default();
        body.speed[0] = constants.mass_kg - h * drag;
        body.force = h;
        for i in 0..count {
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
        for i in (0..count).filter(|i| turning[*i]) {
            let mut row = slips[i];
            row.add(&body, 1.0);
            row.scale(1.0 / constants.wheel_radius_m[i]);
            all.set(1 + i, &row);
        }
        all
    }
}

/// Derivatives of one quantity.
#[derive(Clone, Copy, Debug)]
struct Row<const W: usize, const S: usize> {
    speed: [f64; S],
    torque: [f64; W],
    adhesion: [f64; W],
    force: f64,
}

impl<const W: usize, const S: usize> Default for Row<W, S> {
    fn default() -> Self {
        Self { speed: [0.0; S], torque: [0.0; W], adhesion: [0.0; W], force: 0.0 }
    }
}

impl<const W: usize, const S: usize> Row<W, S> {
    fn add(&mut self, other: &Self, factor: f64) {
        (0..S).for_each(|j| self.speed[j] += factor * other.speed[j]);
        (0..W).for_each(|j| self.torque[j] += factor * other.torque[j]);
        (0..W).for_each(|j| self.adhesion[j] += factor * other.adhesion[j]);
        self.force += factor * other.force;
    }

    fn scale(&mut self, factor: f64) {
        self.speed.iter_mut().for_each(|x| *x *= factor);
        self.torque.iter_mut().for_each(|x| *x *= factor);
        self.adhesion.iter_mut().for_each(|x| *x *= factor);
        self.force *= factor;
    }
}

impl<const W: usize, const S: usize> Slopes<W, S> {
    fn set(&mut self, row: usize, of: &Row<W, S>) {
        self.by_speed[row] = of.speed;
        self.by_torque[row] = of.torque;
        self.by_adhesion[row] = of.adhesion;
        self.by_force[row] = of.force;
    }
}
