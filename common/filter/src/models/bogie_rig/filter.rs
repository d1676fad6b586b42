//! The rig's Kalman filter: a pure step from sample to estimate.

use super::model::{BogieModel, BogieNoise, STATES, index};
use super::sample::{BogieEstimate, BogieInputState, BogieSample, OUTPUTS};
use super::watch::{InputWatch, Motion};
use crate::core::Gaussian;
use railgrip_vehicle::bogie_rig::{BOGIE_WHEELSETS, BogieParameters};

/// Time after the first sample in which nothing is refused and nothing told, s: some windows of the rollers' counter.
const SETTLE_S: f64 = 0.5;

/// Innovation beyond which a force is refused, in sigma.
pub const GATE_SIGMA: f64 = 15.0;

/// So many refused in a row are believed after all.
const REFUSED_AT_MOST: u32 = 2;

/// Innovation that shows a change under way, in sigma, and how long it is expected to last, s.
const CHANGE: (f64, f64) = (3.5, 0.15);

/// One sigma of adhesion while nothing brakes: bearing drag of the wheelsets.
const RELEASED_ADHESION: f64 = 0.02;

/// Speed that creepage is referred to at least, m/s.
const SPEED_FLOOR_M_S: f64 = 0.05;

/// Periods between two samples beyond which some are missing in between.
const GAP_PERIODS: f64 = 1.5;

/// A time between samples beyond which the motion is measured anew, s.
const MAX_GAP_S: f64 = 1.0;

/// The filter.
#[derive(Clone, Debug)]
pub struct BogieFilter {
    /// Equations.
    pub model: BogieModel,
    /// Belief, once begun.
    pub belief: Option<Gaussian<STATES>>,
    watch: InputWatch,
    last: BogieEstimate,
    began_s: f64,
    last_s: f64,
    forces_change_until_s: f64,
    wheels_change_until_s: [f64; BOGIE_WHEELSETS],
    refused_in_row: [u32; OUTPUTS],
    /// Readings of the rollers' counter since the filter began. The first ends a window of unknown length; forces
    /// say something only once the second has told the speed, at which losses and creepage are known.
    roller_readings: u32,
    /// The rollers' present window may have begun in a gap: its count says nothing.
    torn_window: bool,
}

impl BogieFilter {
    /// A filter for a rig of these constants, which it takes for exact.
    pub fn new(parameters: BogieParameters, noise: BogieNoise) -> Self {
        Self {
            model: BogieModel { parameters, noise },
            belief: None,
            watch: InputWatch::NEW,
            last: BogieEstimate::silent(f64::NAN),
            began_s: f64::NAN,
            last_s: f64::NAN,
            forces_change_until_s: f64::NEG_INFINITY,
            wheels_change_until_s: [f64::NEG_INFINITY; BOGIE_WHEELSETS],
            refused_in_row: [0; OUTPUTS],
            roller_readings: 0,
            torn_window: false,
        }
    }

    /// Uses a sample; the estimate after it. A sample that is not later than the last repeats the last estimate.
    pub fn step(&mut self, sample: &BogieSample) -> BogieEstimate {
        let dt_s = sample.time_s - self.last_s;
        if self.belief.is_some() && dt_s.is_nan() || dt_s <= 0.0 || !sample.time_s.is_finite() {
            return self.last;
        }
        let mut estimate = BogieEstimate::silent(sample.time_s);
        match self.belief {
            Some(_) if dt_s <= MAX_GAP_S => {
                let period_s = self.model.parameters.sensors.sample_period_s;
                let missing_s = if dt_s > GAP_PERIODS * period_s { dt_s - period_s } else { 0.0 };
                if missing_s > 0.0 {
                    self.cross_gap(sample.time_s, missing_s);
                }
                self.go_on(sample, dt_s - missing_s, &mut estimate);
            }
            _ => self.start(sample.time_s),
        }
        self.last_s = sample.time_s;
        self.last = estimate;
        estimate
    }

    /// Time of the last sample, s; NaN before the first.
    pub(crate) const fn last_time_s(&self) -> f64 {
        self.last_s
    }

    /// The time base has been set back: the next sample begins the motion anew.
    pub(crate) const fn forget_time(&mut self) {
        self.last_s = f64::NEG_INFINITY;
    }

    /// Goes on from a belief that a predecessor had at a time: its zero errors and speeds, with windows of counters that
    /// began nobody knows when.
    pub(crate) fn resume(&mut self, belief: Gaussian<STATES>, time_s: f64) {
        (self.began_s, self.last_s) = (time_s, time_s);
        self.refused_in_row = [0; OUTPUTS];
        self.watch = InputWatch::NEW;
        self.roller_readings = 0;
        self.belief = Some(belief);
    }

    /// Predicts over samples that never came. A counter of a wheelset has been read with each of them, that of the
    /// rollers perhaps: what it counts next belongs to a window of unknown length.
    fn cross_gap(&mut self, time_s: f64, missing_s: f64) {
        let changing = self.wheels_change_until_s.map(|until| time_s < until);
        let q = self.model.process_variance(missing_s, time_s < self.forces_change_until_s, changing);
        if let Some(belief) = &mut self.belief {
            let f = BogieModel::transition(missing_s);
            belief.predict_leading(f * belief.mean, &f, index::ADHESION, &q);
        }
        for counter in 1..=BOGIE_WHEELSETS {
            self.model.forget_angle(&mut self.belief, counter);
        }
        self.torn_window = true;
    }

    /// Begins, or begins the motion anew with the zero errors that are known.
    fn start(&mut self, time_s: f64) {
        let mut prior = self.model.prior();
        if let Some(before) = &self.belief {
            for state in [index::TORQUE_OFFSET, index::LOAD_CELL_OFFSET] {
                prior.mean[state] = before.mean[state];
                prior.covariance[(state, state)] = before.covariance[(state, state)];
            }
        }
        self.belief = Some(prior);
        self.began_s = time_s;
        self.refused_in_row = [0; OUTPUTS];
        self.roller_readings = 0;
        self.torn_window = false;
        self.watch = InputWatch::NEW;
    }

    fn go_on(&mut self, sample: &BogieSample, dt_s: f64, estimate: &mut BogieEstimate) {
        self.watch.look(&self.model.parameters, sample, dt_s, self.torn_window);
        let changing = self.wheels_change_until_s.map(|until| sample.time_s < until);
        let q = self.model.process_variance(dt_s, sample.time_s < self.forces_change_until_s, changing);
        if let Some(belief) = &mut self.belief {
            let f = BogieModel::transition(dt_s);
            let leading = index::ADHESION;
            belief.predict_leading(f * belief.mean, &f, leading, &q);
        }
        if self.roller_readings > 1 && InputWatch::loaded(&self.model.parameters, sample) {
            if self.watch.load_cell_usable(&self.model.parameters, sample) {
                self.measure_force(1, sample, dt_s, estimate);
            }
            if self.watch.torque_usable(&self.model.parameters, sample) {
                self.measure_force(0, sample, dt_s, estimate);
            }
        }
        for (counter, pulses) in
            [sample.roller_pulses, sample.wheel_pulses[0], sample.wheel_pulses[1]].into_iter().enumerate()
        {
            if !pulses.is_finite() {
                continue;
            }
            if counter == 0 {
                self.roller_readings = self.roller_readings.saturating_add(1);
            }
            if counter == 0 && (std::mem::take(&mut self.torn_window) || self.roller_readings == 1) {
                self.model.forget_angle(&mut self.belief, counter);
            } else {
                self.measure_count(counter, pulses, sample.time_s, dt_s, estimate);
            }
        }
        if self.watch.released()
            && let Some(belief) = &mut self.belief
        {
            let r = RELEASED_ADHESION * RELEASED_ADHESION;
            let update = belief.expect_component(index::ADHESION, 0.0, r);
            belief.update_component(index::ADHESION, &update, r);
        }
        self.read(sample, dt_s, estimate);
    }

    /// Torque (0) or link force (1).
    fn measure_force(
        &mut self,
        output: usize,
        sample: &BogieSample,
        dt_s: f64,
        estimate: &mut BogieEstimate,
    ) {
        let settled = sample.time_s - self.began_s > SETTLE_S;
        let Some(belief) = &mut self.belief else { return };
        let expect = |belief: &Gaussian<STATES>| {
            if output == 0 {
                self.model.expect_torque(belief, sample.shaft_torque_nm, sample.load_n)
            } else {
                self.model.expect_load_cell(belief, sample.load_cell_n, sample.load_n)
            }
        };
        let (mut update, mut h, mut r) = expect(belief);
        estimate.innovation[output] = update.innovation;
        estimate.innovation_variance[output] = update.innovation_variance;
        estimate.nis += update.nis();
        estimate.nis_dof += 1;
        if settled && update.nis() > GATE_SIGMA * GATE_SIGMA && self.refused_in_row[output] < REFUSED_AT_MOST
        {
            self.refused_in_row[output] += 1;
            estimate.rejected |= 1 << output;
            return;
        }
        self.refused_in_row[output] = 0;
        if settled && update.nis() > CHANGE.0 * CHANGE.0 {
            if sample.time_s >= self.forces_change_until_s {
                let calm = self.model.process_variance(dt_s, false, [false; 2]);
                let more = self.model.process_variance(dt_s, true, [false; 2]) - calm;
                for i in 0..STATES {
                    belief.covariance[(i, i)] += more[i];
                }
                (update, h, r) = expect(belief);
            }
            self.forces_change_until_s = sample.time_s + CHANGE.1;
        }
        belief.update_row(&h, &update, r);
    }

    /// Pulses of a counter: 0 the rollers, 1 and 2 the wheelsets.
    fn measure_count(
        &mut self,
        counter: usize,
        pulses: f64,
        time_s: f64,
        dt_s: f64,
        estimate: &mut BogieEstimate,
    ) {
        let settled = time_s - self.began_s > SETTLE_S;
        let Some(belief) = &mut self.belief else { return };
        let output = 2 + counter;
        let (mut update, mut r) = self.model.expect_count(belief, counter, pulses);
        estimate.innovation[output] = update.innovation;
        estimate.innovation_variance[output] = update.innovation_variance;
        estimate.nis += update.nis();
        estimate.nis_dof += 1;
        if settled && counter > 0 && update.nis() > CHANGE.0 * CHANGE.0 {
            let wheel = counter - 1;
            if time_s >= self.wheels_change_until_s[wheel] {
                let mut changing = [false; 2];
                changing[wheel] = true;
                let calm = self.model.process_variance(dt_s, false, [false; 2]);
                let more = self.model.process_variance(dt_s, false, changing) - calm;
                for i in 0..STATES {
                    belief.covariance[(i, i)] += more[i];
                }
                (update, r) = self.model.expect_count(belief, counter, pulses);
            }
            self.wheels_change_until_s[wheel] = time_s + CHANGE.1;
        }
        belief.update_component(BogieModel::angle_of(counter), &update, r);
        self.model.begin_anew(belief, counter, pulses);
    }

    fn read(&mut self, sample: &BogieSample, dt_s: f64, estimate: &mut BogieEstimate) {
        let Some(belief) = &self.belief else { return };
        let p = &self.model.parameters;
        let x = &belief.mean;
        let v = p.roller_radius_m * x[index::ROLLER_SPEED];
        let reference = v.max(SPEED_FLOOR_M_S);
        let mut creepage = [0.0; BOGIE_WHEELSETS];
        let mut creepage_sigma = [0.0; BOGIE_WHEELSETS];
        for i in 0..BOGIE_WHEELSETS {
            let rim = p.wheel_radius_m * x[index::WHEEL_SPEED[i]];
            creepage[i] = (rim - v) / reference;
            let mut weights = super::BogieVector::zeros();
            weights[index::WHEEL_SPEED[i]] = p.wheel_radius_m / reference;
            weights[index::ROLLER_SPEED] = -p.roller_radius_m * rim / (reference * reference);
            creepage_sigma[i] = belief.sigma_along(&weights);
        }
        let motion = Motion {
            v_m_s: v,
            slip: creepage.map(|value| -value),
            offsets: (x[index::TORQUE_OFFSET], x[index::LOAD_CELL_OFFSET]),
        };
        if sample.time_s - self.began_s < SETTLE_S {
            return;
        }
        self.watch.compare(p, sample, &motion, dt_s);
        let state = self.watch.judge(p, sample, &motion);
        estimate.state = state;
        if state.tells_slip() {
            estimate.creepage = creepage;
            estimate.creepage_sigma = creepage_sigma;
        }
        if state.tells_adhesion() {
            estimate.mu_w = x[index::ADHESION];
            estimate.mu_w_sigma = belief.sigma(index::ADHESION);
        }
        if !matches!(state, BogieInputState::RollerCounterDead | BogieInputState::CountersSwapped) {
            estimate.v_m_s = v;
            estimate.v_sigma_m_s = p.roller_radius_m * belief.sigma(index::ROLLER_SPEED);
            estimate.roller_acceleration_rad_s2 = x[index::ROLLER_ACCELERATION];
        }
        estimate.torque_offset_nm = x[index::TORQUE_OFFSET];
        estimate.load_cell_offset_n = x[index::LOAD_CELL_OFFSET];
    }
}
