//! Samples of many wagons into instants of the train: what was taken at one time stands side by side.
//!
//! Wagons speak by channels of their own, in batches, and each counts time on the base of its own sensors. An instant is
//! complete when every wagon that speaks has a sample of it; a wagon that has been silent for [`SILENT_S`] is not waited for.
//!
//! Times on one base that begins anew (a replay in a loop, a source that was restarted) go on where they stood. Bases
//! further apart than [`SAME_BASE_S`] are taken for different ones and laid side by side by arrival.

use railgrip_causes::{MAX_WHEELSETS, Reading};
use railgrip_messages::{Sample, valid};
use std::collections::VecDeque;

/// A wagon of which nothing has come for so long is not waited for, s of the reader's clock.
const SILENT_S: f64 = 1.5;
/// Time bases that differ by less are one, s.
const SAME_BASE_S: f64 = 60.0;
/// Most samples of a wagon that wait for the others.
const MOST_WAITING: usize = 8192;
/// Sampling period until two samples have told it, s.
const USUAL_PERIOD_S: f64 = 0.01;

/// One wagon: what waits, and where its time base lies.
#[derive(Debug, Default)]
struct Lane {
    waiting: VecDeque<(f64, Reading)>,
    /// What is added to its own time, s.
    shift_s: f64,
    /// Time of its latest sample, shifted, s.
    latest_s: Option<f64>,
    /// Usual time between two samples, s.
    period_s: Option<f64>,
    heard_s: Option<f64>,
}

/// Lays samples side by side.
#[derive(Debug)]
pub struct Aligner {
    lanes: Vec<Lane>,
    emitted_s: f64,
    readings: Vec<Reading>,
    /// Samples that came after their instant had passed.
    pub late: u64,
}

impl Aligner {
    /// Nothing has come yet of so many wagons.
    #[must_use]
    pub fn new(wagons: usize) -> Self {
        Self {
            lanes: (0..wagons).map(|_| Lane::default()).collect(),
            emitted_s: f64::NEG_INFINITY,
            readings: Vec::with_capacity(wagons),
            late: 0,
        }
    }

    /// Takes a sample of a wagon (index, 0 at the front) that came at `now_s` of the reader's clock.
    pub fn push(&mut self, wagon: usize, sample: &Sample, now_s: f64) {
        let newest_s = self.lanes.iter().filter_map(|lane| lane.latest_s).fold(f64::NAN, f64::max);
        let Some(lane) = self.lanes.get_mut(wagon).filter(|_| sample.time_s.is_finite()) else { return };
        let mut time_s = sample.time_s + lane.shift_s;
        let period_s = lane.period_s.unwrap_or(USUAL_PERIOD_S);
        match lane.latest_s {
            None if (time_s - newest_s).abs() > SAME_BASE_S => {
                lane.shift_s = newest_s - sample.time_s;
            }
            Some(latest_s) if time_s <= latest_s => {
                let next_s = latest_s + period_s;
                let behind = newest_s - next_s > SAME_BASE_S;
                lane.shift_s = if behind { newest_s } else { next_s } - sample.time_s;
            }
            Some(latest_s) => {
                let step_s = time_s - latest_s;
                let usual_s = lane.period_s.unwrap_or(step_s);
                // Gaps and bursts say little of it.
                lane.period_s = Some(usual_s + 0.02 * (step_s.min(3.0 * usual_s) - usual_s));
            }
            None => {}
        }
        time_s = sample.time_s + lane.shift_s;
        lane.latest_s = Some(time_s);
        lane.heard_s = Some(now_s);
        if time_s <= self.emitted_s {
            self.late += 1;
            return;
        }
        if lane.waiting.len() == MOST_WAITING {
            lane.waiting.pop_front();
        }
        lane.waiting.push_back((time_s, reading(sample)));
    }

    /// Hands on every instant that is complete at `now_s`: its time, and what all wagons read, front first.
    pub fn drain(&mut self, now_s: f64, mut take: impl FnMut(f64, &[Reading])) {
        let period_s = self.lanes.iter().filter_map(|lane| lane.period_s).fold(f64::INFINITY, f64::min);
        let half_s = 0.5 * if period_s.is_finite() { period_s } else { USUAL_PERIOD_S };
        loop {
            let speaks = |lane: &Lane| lane.heard_s.is_some_and(|heard_s| now_s - heard_s < SILENT_S);
            let waits = self.lanes.iter().any(|lane| lane.waiting.is_empty() && speaks(lane));
            let first_s = self.lanes.iter().filter_map(|lane| lane.waiting.front());
            let Some(time_s) = first_s.map(|(time_s, _)| *time_s).min_by(f64::total_cmp) else { return };
            if waits {
                return;
            }
            self.readings.clear();
            for lane in &mut self.lanes {
                let now = lane.waiting.front().is_some_and(|(own_s, _)| *own_s < time_s + half_s);
                let own = if now { lane.waiting.pop_front() } else { None };
                self.readings.push(own.map_or_else(Reading::default, |(_, reading)| reading));
            }
            self.emitted_s = time_s + half_s;
            take(time_s, &self.readings);
        }
    }
}

/// What a sample says; NaN where it says nothing.
fn reading(sample: &Sample) -> Reading {
    let value = |bit: u32, value: f64| if sample.has(bit) { value } else { f64::NAN };
    let mut reading = Reading {
        v_m_s: value(valid::SPEED, sample.v_m_s),
        grade_rad: value(valid::GRADE, sample.grade_rad),
        load_kg: value(valid::LOAD, sample.load_kg),
        brake_demand: value(valid::BRAKE_DEMAND, sample.brake_demand),
        ..Reading::default()
    };
    for k in 0..sample.wheelset_count().min(MAX_WHEELSETS) {
        reading.wheel_speed_rad_s[k] = value(valid::wheel_speed(k), sample.wheel_speed_rad_s[k]);
        reading.pressing_force_n[k] = value(valid::pressing_force(k), sample.pressing_force_n[k]);
        reading.drive_torque_nm[k] = value(valid::drive_torque(k), sample.drive_torque_nm[k]);
    }
    reading
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(time_s: f64, v_m_s: f64) -> Sample {
        Sample { time_s, v_m_s, valid: valid::SPEED, wheelsets: 2, ..Sample::default() }
    }

    fn speeds(aligner: &mut Aligner, now_s: f64) -> Vec<(f64, Vec<f64>)> {
        let mut all = Vec::new();
        aligner.drain(now_s, |time_s, readings| {
            all.push((time_s, readings.iter().map(|reading| reading.v_m_s).collect()));
        });
        all
    }

    #[test]
    fn batches_of_wagons_become_instants() {
        let mut aligner = Aligner::new(2);
        for step in 0..5 {
            aligner.push(0, &sample(0.02 * f64::from(step), f64::from(step)), 0.0);
        }
        assert!(
            speeds(&mut aligner, 0.1).len() == 5,
            "wagon 2 has never spoken, so that nobody waits for it"
        );
        let mut aligner = Aligner::new(2);
        for step in 0..5 {
            aligner.push(0, &sample(0.02 * f64::from(step), f64::from(step)), 0.0);
        }
        for step in 0..3 {
            aligner.push(1, &sample(0.02 * f64::from(step) + 1e-4, 10.0), 0.0);
        }
        let found = speeds(&mut aligner, 0.1);
        assert_eq!(found.len(), 3);
        assert_eq!(found[2].1, [2.0, 10.0]);
        // Wagon 2 falls silent: the rest goes on without it, and what comes too late is counted.
        let found = speeds(&mut aligner, 2.0);
        assert!(found.len() == 2 && found.iter().all(|(_, v)| v[0] >= 3.0 && v[1].is_nan()), "{found:?}");
        aligner.push(1, &sample(0.0801, 10.0), 2.1);
        assert_eq!(aligner.late, 1);
    }

    #[test]
    fn a_time_base_that_begins_anew_goes_on() {
        let mut aligner = Aligner::new(2);
        let mut times = Vec::new();
        for round in 0..3 {
            for step in 0..50 {
                for wagon in 0..2 {
                    let at = sample(100.0 + 0.02 * f64::from(step), f64::from(round * 50 + step));
                    aligner.push(wagon, &at, 0.0);
                }
            }
            times.extend(speeds(&mut aligner, 0.1));
        }
        assert_eq!(times.len(), 150);
        assert!(times.iter().all(|(_, v)| v[0] == v[1]), "wagons stay side by side");
        assert!(times.windows(2).all(|pair| (pair[1].0 - pair[0].0 - 0.02).abs() < 1e-9));
    }

    #[test]
    fn another_time_base_is_laid_beside() {
        let mut aligner = Aligner::new(2);
        for step in 0..10 {
            aligner.push(0, &sample(0.1 * f64::from(step), 1.0), 0.0);
            aligner.push(1, &sample(1.7e9 + 0.1 * f64::from(step), 2.0), 0.0);
        }
        let found = speeds(&mut aligner, 0.0);
        assert!(found.len() >= 9 && found.iter().skip(1).all(|(_, v)| v == &[1.0, 2.0]), "{found:?}");
    }
}
