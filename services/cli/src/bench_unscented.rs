//! The filters of the traction rig on the bench: 13 states, seven measured values.

use std::hint::black_box;

use nalgebra::{DMatrix, DVector};
use railgrip_experiments::bench::{StepTime, traction_filters};
use railgrip_experiments::traction::run::{Case, SENSOR_SIGMA, simulate};
use railgrip_filter::models::traction_rig::{STATES, State, TractionModel, TractionNoise, index};
use railgrip_vehicle::traction_rig::Surface;

/// Samples that the filters are timed on.
const SAMPLES: usize = 2000;

/// Times of the unscented and of the extended filter.
pub(crate) fn filters() -> Vec<StepTime> {
    traction_filters(SAMPLES)
}

/// A textbook unscented step (27 sigma points through the same model, covariances summed up) with matrices of dynamic
/// size, for `time` to call: what a filter without fixed sizes and without square roots costs.
pub(crate) fn dense_step() -> impl FnMut() {
    let case = Case { surface: Surface::Base, number: 4 };
    let (model, noise) = (TractionModel::new(case.rig()), TractionNoise::default());
    let (start, dt_s) = (state(case, &model), 1e-3);
    let q = noise.over(dt_s);
    let sigma = DVector::from_iterator(STATES, q.iter().map(|q| 10.0 * q));
    let begin = DMatrix::from_diagonal(&sigma.component_mul(&sigma));
    let spread = 3.0_f64;
    let weight = move |point: usize| if point == 0 { 1.0 - STATES as f64 / spread } else { 0.5 / spread };
    move || {
        let Some(factor) = begin.clone().cholesky() else { return };
        let root = factor.l() * spread.sqrt();
        let points: Vec<DVector<f64>> = (0..=2 * STATES)
            .map(|point| {
                let mut x = start;
                if point > 0 {
                    let side = if point <= STATES { 1.0 } else { -1.0 };
                    let column = root.column((point - 1) % STATES);
                    (0..STATES).for_each(|row| x[row] += side * column[row]);
                }
                DVector::from_column_slice(model.step(black_box(&x), dt_s).as_slice())
            })
            .collect();
        let mut mean = DVector::<f64>::zeros(STATES);
        points.iter().enumerate().for_each(|(point, x)| mean += x * weight(point));
        let mut p =
            DMatrix::<f64>::from_fn(
                STATES,
                STATES,
                |row, column| {
                    if row == column { q[row] * q[row] } else { 0.0 }
                },
            );
        for (point, x) in points.iter().enumerate() {
            let apart = x - &mean;
            p += &apart * apart.transpose() * weight(point);
        }
        for measured in [0, 1, index::MOTOR_SPEED, 5, 6, index::ROLLER_SPEED, index::GENERATOR_CURRENT] {
            let s = p[(measured, measured)] + SENSOR_SIGMA * SENSOR_SIGMA;
            let gain = p.column(measured) / s;
            mean += &gain * 1e-3;
            p -= &gain * gain.transpose() * s;
        }
        black_box((&mean, &p));
    }
}

/// The rig in motion.
fn state(case: Case, model: &TractionModel) -> State {
    let mut x = State::zeros();
    if let Some(last) = simulate(case, 1, 1.0, SENSOR_SIGMA).last() {
        let motor = last.state.motor;
        x.as_mut_slice()[..4].copy_from_slice(&[
            motor.current_a[0],
            motor.current_a[1],
            motor.flux_wb[0],
            motor.flux_wb[1],
        ]);
        x[index::MOTOR_SPEED] = last.state.motor_speed_rad_s;
        x[index::VOLTAGE] = last.sample.voltage_v[0];
        x[index::VOLTAGE + 1] = last.sample.voltage_v[1];
        x[index::ROLLER_SPEED] = last.state.roller_speed_rad_s;
        x[index::LN_ADHESION_PEAK] = last.adhesion_peak.ln();
        model.follow(&mut x);
    }
    x
}
