//! How far a run would set hypotheses apart.

use super::hypotheses::Hypothesis;
use super::runs::{PlannedRun, is_driven};
use crate::data::case::{Case, Columns, Run};
use crate::fit::objective::{Innovations, Whitening};
use crate::fit::solver::{self, Problem};
use crate::model::parameters::{Built, Parameter, Shape};
use crate::predict::disturbances::DisturbanceModel;
use nalgebra::DVector;
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion, SampleInput};
use railgrip_vehicle::{GRAVITY_M_S2, MAX_WHEELSETS, PerWheelset};

/// Deceleration of full service braking, m/s²: general knowledge.
const FULL_BRAKING_M_S2: f64 = 1.1;
/// Share of the weight that full traction pulls with: general knowledge.
const FULL_TRACTION: f64 = 0.06;
/// Lag of brake and motor behind what is asked, s: general knowledge.
const LAG_S: f64 = 1.2;
/// Shortest sample period of a planned run, s: a test is chosen by what lasts.
const SHORTEST_PERIOD_S: f64 = 0.02;
/// Speed at which a run ends, m/s.
const END_M_S: f64 = 1.0;

/// Log-likelihood that each hypothesis (column) is expected to lose against the true one (row), in nats.
pub(super) fn of(
    case: &Case,
    hypotheses: &[Hypothesis],
    test: &PlannedRun,
    tolerance: usize,
    widening: f64,
) -> Vec<Vec<f64>> {
    let shapes: Vec<Shape> = hypotheses.iter().map(|h| h.fitted.shape.on_recordings()).collect();
    let built: Vec<Built> =
        hypotheses.iter().zip(&shapes).map(|(h, s)| s.build(&h.fitted.fit.theta)).collect();
    let disturbances = DisturbanceModel::default().tolerant(tolerance);
    let of_truth = |truth: &Built| -> Vec<f64> {
        let fit = vec![drive(case, truth, test)];
        let (vehicle, noise) = (case.vehicle.clone(), case.noise);
        let run = Case { vehicle, fit, holdout: Vec::new(), noise, notes: Vec::new() };
        (0..hypotheses.len())
            .map(|b| lost(&run, &hypotheses[b], &shapes[b], &built[b], &disturbances) / widening.powi(2))
            .collect()
    };
    let mut apart: Vec<Vec<f64>> = built.iter().map(of_truth).collect();
    // What the true hypothesis itself loses (its filter starts anew) is no difference.
    for (truth, row) in apart.iter_mut().enumerate() {
        let own = row[truth];
        row.iter_mut().for_each(|loss| *loss = (*loss - own).max(0.0));
    }
    apart
}

/// Half the squared whitened innovations of a hypothesis on a run, after its parameters took up what they can beside what the
/// recordings say of them.
fn lost(run: &Case, own: &Hypothesis, shape: &Shape, built: &Built, disturbances: &DisturbanceModel) -> f64 {
    let whitening = Whitening::new(run, built, disturbances);
    let problem = Innovations { whitening: &whitening, shape };
    let theta = &own.fitted.fit.theta;
    let residuals = problem.residuals(theta);
    // The planned run is none of those that the parameters were fitted on.
    let anywhere = |parameter: &Parameter| Parameter { shows_in: None, ..parameter.clone() };
    let parameters: Vec<Parameter> = shape.parameters().iter().map(anywhere).collect();
    let columns = problem.columns(&parameters, theta, &residuals, 0..theta.len());
    let (_, mut curvature) = solver::assemble(shape.parameters(), theta, &own.fitted.fit.blocks);
    let gradient = DVector::from_iterator(columns.len(), columns.iter().map(|c| solver::dot(c, &residuals)));
    for (i, a) in columns.iter().enumerate() {
        for (j, b) in columns.iter().enumerate() {
            curvature[(i, j)] += solver::dot(a, b);
        }
    }
    let taken_up = curvature.cholesky().map_or(0.0, |factor| gradient.dot(&factor.solve(&gradient)));
    0.5 * (solver::dot(&residuals, &residuals) - taken_up).max(0.0)
}

/// The run as a model would make it, without noise.
fn drive(case: &Case, built: &Built, test: &PlannedRun) -> Run {
    let vehicle = &case.vehicle;
    let wheelsets = case.wheelsets();
    let dt_s = case.fit.first().map_or(SHORTEST_PERIOD_S, |run| run.dt_s.max(SHORTEST_PERIOD_S));
    let mass_kg = vehicle.body.mass_kg / wheelsets as f64;
    let full_n = mass_kg * FULL_BRAKING_M_S2 * vehicle.wheelset.radius_m
        / (vehicle.brake.friction_coefficient * vehicle.brake.radius_m);
    let motor_nm = if is_driven(case) {
        FULL_TRACTION * GRAVITY_M_S2 * mass_kg * vehicle.wheelset.radius_m
    } else {
        0.0
    };
    let wagon = FastWagon::new(&built.model, built.adhesion(test.class), dt_s);
    let each = |value: f64| -> PerWheelset {
        let mut all = [0.0; MAX_WHEELSETS];
        all[..wheelsets].fill(value);
        all
    };
    let mut motion = Motion::default();
    let rolling = wagon.constants().wheel_radius_m.map(|radius_m| test.v0_m_s / radius_m);
    motion.state[0] = test.v0_m_s;
    motion.state[1..=wheelsets].copy_from_slice(&rolling[..wheelsets]);
    let mut input = SampleInput::default();
    let mut hidden = wagon.start_hidden(&motion.state, &input);
    let (mut force_n, mut torque_nm) = (0.0, 0.0);
    let mut columns = Columns {
        wheel_speed_rad_s: vec![Vec::new(); wheelsets],
        pressing_force_n: vec![Vec::new(); wheelsets],
        drive_torque_nm: vec![Vec::new(); wheelsets],
        ..Columns::default()
    };
    let end_s = test.phases.last().map_or(0.0, |phase| phase.until_s);
    for k in 0..(end_s / dt_s) as usize {
        let time_s = k as f64 * dt_s;
        let phase = test.phases.iter().find(|phase| time_s < phase.until_s).copied();
        let (brake, drive) = phase.map_or((0.0, 0.0), |phase| (phase.brake_demand, phase.drive_demand));
        let follow = 1.0 - (-dt_s / LAG_S).exp();
        let (force_before_n, torque_before_nm) = (force_n, torque_nm);
        force_n += follow * (brake * full_n - force_n);
        torque_nm += follow * (drive * motor_nm - torque_nm);
        input.time_s = time_s;
        input.pressing_force_n = each(force_before_n);
        input.mid_pressing_force_n = each(0.5 * (force_before_n + force_n));
        input.mid_drive_torque_nm = each(0.5 * (torque_before_nm + torque_nm));
        let reading = wagon.read(&motion, &input, &hidden);
        columns.t_s.push(time_s);
        columns.v_m_s.push(reading[0]);
        columns.position_m.push(input.position_m);
        for i in 0..wheelsets {
            columns.wheel_speed_rad_s[i].push(reading[1 + i]);
            columns.pressing_force_n[i].push(force_before_n);
            columns.drive_torque_nm[i].push(torque_before_nm);
            input.wheel_angle_rad[i] += motion.state[1 + i] * dt_s;
        }
        input.position_m += motion.state[0] * dt_s;
        wagon.step(&mut motion, &input, &Disturbance::default(), &mut hidden);
        if motion.state[0] < END_M_S && k > 20 {
            break;
        }
    }
    Run::new(format!("planned.{}", test.rail), test.class, &columns)
}

/// Entropy of probabilities, nats.
pub(super) fn entropy(p: &[f64]) -> f64 {
    -p.iter().filter(|p| **p > 0.0).map(|p| p * p.ln()).sum::<f64>()
}

/// Entropy of the posterior that is expected after a run that sets the hypotheses so far apart.
pub(super) fn expected_entropy(hypotheses: &[Hypothesis], apart: &[Vec<f64>]) -> f64 {
    let prior = |b: usize| hypotheses[b].p;
    let after = |row: &Vec<f64>| {
        let least = row.iter().copied().fold(f64::INFINITY, f64::min);
        let weights: Vec<f64> =
            row.iter().enumerate().map(|(b, loss)| prior(b) * (least - loss).exp()).collect();
        let total: f64 = weights.iter().sum();
        entropy(&weights.iter().map(|weight| weight / total).collect::<Vec<f64>>())
    };
    apart.iter().enumerate().map(|(truth, row)| prior(truth) * after(row)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entropy_is_that_of_the_doubt() {
        assert!((entropy(&[0.5, 0.5]) - 2.0_f64.ln()).abs() < 1e-12);
        assert_eq!(entropy(&[1.0, 0.0]), 0.0);
    }
}
