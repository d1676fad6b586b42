//! How far a run would set models apart.

use super::models::Model;
use super::runs::{PlannedRun, is_driven};
use crate::answer::schema::PosteriorSet;
use crate::data::case::{Case, Columns, Run};
use crate::decide::test_run::{TestRun, TestWeights, Tested, not_listed};
use crate::model::parameters::Built;
use crate::predict::open_loop::{self, Tally, sigmas};
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion, SampleInput};
use railgrip_vehicle::{GRAVITY_M_S2, MAX_WHEELSETS, PerWheelset};

/// Deceleration of full service braking, m/s²: general knowledge.
const FULL_BRAKING_M_S2: f64 = 1.1;
/// Share of the weight that full traction pulls with: general knowledge.
const FULL_TRACTION: f64 = 0.06;
/// Lag of brake and motor behind what is asked, s: general knowledge.
const LAG_S: f64 = 1.2;
/// Shortest sample period of a planned run, s: a test is chosen by what lasts.
const SHORTEST_PERIOD_S: f64 = 0.04;
/// Share of what a named effect does that something unknown in its place does otherwise; set by hand.
const IMITATED: f64 = 0.5;
/// Speed at which a run ends, m/s.
const END_M_S: f64 = 1.0;

/// What decides between models.
pub(super) struct Doubt<'d> {
    /// Models that may be true, the calibrated one first.
    pub(super) models: &'d [Model],
    /// Probability of each of them, beside something unknown and what no model was made of.
    pub(super) p: Vec<f64>,
    /// Sets of effects that may be at work.
    pub(super) sets: &'d [PosteriorSet],
    /// Gap that a right model leaves, sensor sigmas.
    pub(super) natural: f64,
    /// How far a test moves probabilities.
    pub(super) weights: &'d TestWeights,
}

impl Doubt<'_> {
    /// Entropy of the sets that is expected after a test, nats: over what may be true.
    pub(super) fn expected_entropy(&self, case: &Case, test: &PlannedRun) -> f64 {
        let sigma = sigmas(&case.vehicle.sensors);
        let (mut whole, mut sum) = (0.0, 0.0);
        let mut add = |p: f64, after: f64| {
            whole += p;
            sum += p * after;
        };
        let likeliest = (0..self.p.len()).max_by(|a, b| self.p[*a].total_cmp(&self.p[*b]));
        for (index, p) in self.p.iter().enumerate().filter(|(_, p)| **p > 0.0) {
            let truth = &self.models[index];
            let run = drive(case, &truth.built, test);
            let errors = |built: &Built| -> Vec<f64> {
                open_loop::tallies(built, &run, &sigma).iter().map(Tally::gap).collect()
            };
            let of_models: Vec<Vec<f64>> = self.models.iter().map(|model| errors(&model.built)).collect();
            add(*p, self.entropy_after(&of_models));
            // Something unknown in its place does in part something else than the effect.
            if likeliest == Some(index) && !truth.effects.is_empty() {
                let lacking: Vec<f64> = errors(&truth.bare).iter().map(|error| IMITATED * error).collect();
                add(self.unknown(), self.entropy_after(&vec![lacking; self.models.len()]));
            }
        }
        sum / whole
    }

    fn unknown(&self) -> f64 {
        self.sets.iter().filter(|set| set.unknown).map(|set| set.p).sum()
    }

    /// Entropy after a test in which models err so much, window by window, beside what even a right cause leaves, whose law may have
    /// another form.
    fn entropy_after(&self, errors: &[Vec<f64>]) -> f64 {
        let own = self.weights.allowance * self.natural;
        let tested = |(model, errors): (&Model, &Vec<f64>)| Tested {
            effects: model.effects.clone(),
            windows: errors.iter().map(|error| own.hypot(*error)).collect(),
        };
        let models: Vec<Tested> = self.models.iter().zip(errors).map(tested).collect();
        let natural = vec![self.natural; models.first().map_or(0, |model| model.windows.len())];
        entropy(&TestRun { models, natural }.reweigh(self.sets, self.weights))
    }
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

/// Entropy of sets, nats; those that are not listed count as one.
pub(super) fn entropy(sets: &[PosteriorSet]) -> f64 {
    let all = sets.iter().map(|set| set.p).chain([not_listed(sets)]);
    -all.filter(|p| *p > 0.0).map(|p| p * p.ln()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entropy_is_that_of_the_doubt() {
        let of = |p: f64| PosteriorSet { effects: Vec::new(), unknown: false, p };
        assert!((entropy(&[of(0.5), of(0.5)]) - 2.0_f64.ln()).abs() < 1e-12);
        assert_eq!(entropy(&[of(1.0), of(0.0)]), 0.0);
        assert!((entropy(&[of(0.5)]) - 2.0_f64.ln()).abs() < 1e-12, "what is not listed is a half");
    }
}
