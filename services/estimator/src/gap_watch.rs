//! Watches whether the model still explains the data, and where it does not.
//!
//! Normalised innovations squared should be 1 on average. When their mean stays high, something acts on the wagon that the
//! model lacks. Where the excess sits – in which measured output, while the wagon does what – names the term to suspect;
//! `railgrip gap diagnose` can then tell which effect it is. The latest minutes are kept in memory for that.
//!
//! The term is a first suspicion from one glance; the diagnosis refits everything and decides.
//! What the filter can absorb in a state (a changed level of pad friction, a wheel radius that looks like creepage) does
//! not show here.

use railgrip_messages::{Condition, Estimate, Innovation, Sample, flags, valid};
use railgrip_recording::Row;
use std::collections::VecDeque;

/// Mean normalised innovations are over about this time, s.
const MEMORY_S: f64 = 20.0;
/// A mismatch must last this long before it is told, s.
const PERSISTENT_S: f64 = 20.0;
/// One that was told is over when the mean has stayed below its limit for this long, s: an effect that only shows while the
/// train brakes is still there while it coasts.
const OVER_S: f64 = 90.0;
/// Slower than this, creepage is no longer a small number and the equations say little: nothing is judged, m/s.
const MOVES_FROM_M_S: f64 = 2.0;
/// After a change of pressing force the brake counts as changing for this long, s.
const CHANGING_S: f64 = 1.0;
/// Pressing force that changes faster than this is changing, share of its level per second.
const CHANGING_PER_S: f64 = 0.5;
/// A wheelset brakes from this pressing force on, N.
const BRAKES_FROM_N: f64 = 2000.0;
/// A wheelset drives from this torque on, N m.
const DRIVES_FROM_NM: f64 = 200.0;
/// One output alone is suspect when the others have less than this share of its excess.
const ALONE_SHARE: f64 = 0.3;
/// So much is kept for a recording, s.
pub const KEPT_S: f64 = 180.0;
/// Samples are kept at most this often, Hz: as often as a diagnosis looks at them.
const KEPT_HZ: f64 = 50.0;
/// Samples that are kept, at most.
const MOST_KEPT: usize = (KEPT_S * KEPT_HZ) as usize;

/// What the wagon does while a sample is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
enum Regime {
    Coasting,
    Driving,
    Braking,
    BrakeChanging,
    Sliding,
}

const REGIMES: usize = 5;
const OUTPUTS: usize = railgrip_messages::MAX_OUTPUTS;

/// A mismatch that lasts.
#[derive(Debug, Clone, PartialEq)]
pub struct Mismatch {
    /// The term of the model to suspect, as `railgrip gap effects` names it.
    pub term: &'static str,
    /// Where the excess sits, in words.
    pub place: String,
    /// Mean normalised innovation squared over its degrees of freedom.
    pub ratio: f64,
    /// How long it has lasted, s.
    pub seconds: f64,
}

/// The watch over one wagon.
#[derive(Debug)]
pub struct GapWatch {
    limit: f64,
    excess: [[f64; OUTPUTS]; REGIMES],
    mean: f64,
    weight: f64,
    mismatch_s: f64,
    calm_s: f64,
    found: Option<Mismatch>,
    last_time_s: f64,
    last_force_n: f64,
    changing_s: f64,
    kept: VecDeque<Kept>,
    /// The values of each of `kept`, see [`values_of`].
    values: VecDeque<f32>,
    wheelsets: usize,
    rail: Condition,
}

/// A sample in little room, but for its values.
#[derive(Debug, Clone, Copy)]
struct Kept {
    t_s: f64,
    position_m: f64,
    valid: u32,
    rail: Condition,
}

/// Values that are kept of a sample: speed; speeds, forces and torques of so many wheelsets; grade, sanding.
const fn values_of(wheelsets: usize) -> usize {
    3 * wheelsets + 3
}

/// A sample that was kept, and the rail as it was taken to be then.
#[derive(Debug, Clone, Copy)]
pub struct KeptRow {
    /// The sample; NaN = missing.
    pub row: Row,
    /// The most probable condition.
    pub rail: Condition,
}

impl GapWatch {
    /// A mean above `limit` is a mismatch.
    #[must_use]
    pub fn new(limit: f64) -> Self {
        Self {
            limit,
            excess: [[0.0; OUTPUTS]; REGIMES],
            mean: 0.0,
            weight: 0.0,
            mismatch_s: 0.0,
            calm_s: 0.0,
            found: None,
            last_time_s: f64::NAN,
            last_force_n: 0.0,
            changing_s: f64::INFINITY,
            kept: VecDeque::new(),
            values: VecDeque::new(),
            wheelsets: 0,
            rail: Condition::Dry,
        }
    }

    /// A mean above `limit` is a mismatch from now on.
    pub const fn judge_by(&mut self, limit: f64) {
        self.limit = limit;
    }

    /// What the rail is taken to be from now on.
    pub const fn on_rail(&mut self, rail: Condition) {
        self.rail = rail;
    }

    /// Takes one sample with what the filter made of it.
    pub fn take(&mut self, sample: &Sample, estimate: &Estimate, innovation: &Innovation) {
        let dt_s = sample.time_s - self.last_time_s;
        let begins = estimate.flags & flags::RESTARTED != 0 || !(0.0..0.5).contains(&dt_s);
        self.last_time_s = sample.time_s;
        if self.wheelsets != sample.wheelset_count() {
            self.wheelsets = sample.wheelset_count();
            self.forget_kept();
        }
        // Holes are cut out when a recording is written; only where time begins anew what was kept is of another day. A filter
        // that starts again says nothing about the samples: where the model is wrong it does so often.
        let goes_on = dt_s >= 0.0;
        if !goes_on {
            self.forget_kept();
        }
        if begins {
            self.last_force_n = sample.pressing_force_n.iter().sum();
        }
        self.keep(sample);
        if begins || dt_s <= 0.0 || estimate.flags & flags::CONVERGING != 0 {
            return;
        }
        if estimate.v_m_s.abs() < MOVES_FROM_M_S {
            return;
        }
        let regime = self.regime(sample, estimate, dt_s) as usize;
        let share = (dt_s / MEMORY_S).min(1.0);
        self.excess.iter_mut().flatten().for_each(|excess| *excess *= 1.0 - share);
        for output in 0..=self.wheelsets {
            let variance = innovation.innovation_variance[output];
            if variance > 0.0 {
                let z = innovation.innovation[output];
                // A single spike is a matter of the gate, not of the model.
                self.excess[regime][output] += share * ((z * z / variance).min(25.0) - 1.0);
            }
        }
        if estimate.nis_dof > 0 {
            let dof = f64::from(estimate.nis_dof);
            self.mean += share * ((estimate.nis / dof).min(25.0) - self.mean);
            self.weight += share * (1.0 - self.weight);
        }
        let high = self.weight > 0.3 && self.mean / self.weight > self.limit;
        self.last(high, dt_s);
    }

    /// Counts how long it has been high or calm.
    fn last(&mut self, high: bool, dt_s: f64) {
        if !high {
            self.calm_s += dt_s;
            if self.found.is_none() || self.calm_s >= OVER_S {
                (self.mismatch_s, self.found) = (0.0, None);
            }
            return;
        }
        self.calm_s = 0.0;
        self.mismatch_s += dt_s;
        let ratio = self.mean / self.weight;
        let worse = self.found.as_ref().is_none_or(|found| ratio > 1.1 * found.ratio);
        if self.mismatch_s >= PERSISTENT_S && worse {
            let (term, place) = self.suspect();
            self.found = Some(Mismatch { term, place, ratio, seconds: self.mismatch_s });
        }
    }

    fn regime(&mut self, sample: &Sample, estimate: &Estimate, dt_s: f64) -> Regime {
        let force_n: f64 = sample.pressing_force_n.iter().sum();
        let per_s = (force_n - self.last_force_n).abs() / dt_s;
        // A slow mean of the force, so that sensor noise does not look like a change.
        self.last_force_n += (dt_s / 0.2).min(1.0) * (force_n - self.last_force_n);
        let changing = per_s * (dt_s / 0.2).min(1.0) > CHANGING_PER_S * force_n.max(BRAKES_FROM_N);
        self.changing_s = if changing { 0.0 } else { self.changing_s + dt_s };
        // A brake that changes comes first: under slide protection a late brake looks like changing adhesion.
        if self.changing_s < CHANGING_S {
            Regime::BrakeChanging
        } else if estimate.sliding != 0 {
            Regime::Sliding
        } else if force_n >= BRAKES_FROM_N {
            Regime::Braking
        } else if sample.drive_torque_nm.iter().any(|torque| torque.abs() >= DRIVES_FROM_NM) {
            Regime::Driving
        } else {
            Regime::Coasting
        }
    }

    /// Mean normalised innovation squared over its degrees of freedom over the memory; `None` before it means something.
    #[must_use]
    pub fn ratio(&self) -> Option<f64> {
        (self.weight > 0.3).then(|| self.mean / self.weight)
    }

    /// The mismatch, if there is one that lasts, as it was at its worst.
    #[must_use]
    pub const fn mismatch(&self) -> Option<&Mismatch> {
        self.found.as_ref()
    }

    fn suspect(&self) -> (&'static str, String) {
        const ALL: [Regime; REGIMES] =
            [Regime::Coasting, Regime::Driving, Regime::Braking, Regime::BrakeChanging, Regime::Sliding];
        let total = |regime: &Regime| self.excess[*regime as usize].iter().sum::<f64>();
        let regime = ALL.into_iter().max_by(|a, b| total(a).total_cmp(&total(b))).unwrap_or(Regime::Coasting);
        let excess = &self.excess[regime as usize];
        let (speed, wheels) = (excess[0], &excess[1..=self.wheelsets.max(1)]);
        let worst = (0..wheels.len()).max_by(|a, b| wheels[*a].total_cmp(&wheels[*b])).unwrap_or(0);
        let alone = wheels.len() > 1
            && wheels
                .iter()
                .enumerate()
                .all(|(index, other)| index == worst || *other < ALONE_SHARE * wheels[worst]);
        let by_speed = speed > wheels[worst];
        let term = match (regime, by_speed, alone) {
            (Regime::Coasting | Regime::Driving, true, _) => "resistance",
            (Regime::Braking, true, _) => "sensor_speed",
            (Regime::Coasting, false, _) => "sensor_wheel_speed",
            (Regime::Driving, false, _) => "drivetrain",
            (Regime::Braking, false, true) => "sensor_wheel_speed",
            (Regime::Braking, false, false) => "brake_friction",
            (Regime::BrakeChanging, _, _) => "brake_actuation",
            (Regime::Sliding, _, _) => "adhesion",
        };
        let doing = match regime {
            Regime::Coasting => "coasting",
            Regime::Driving => "driving",
            Regime::Braking => "braking steadily",
            Regime::BrakeChanging => "the brake is applied or released",
            Regime::Sliding => "sliding",
        };
        let output = match (by_speed, alone) {
            (true, _) => "the speed".to_owned(),
            (false, true) => format!("wheelset {}", worst + 1),
            (false, false) => "all wheelsets".to_owned(),
        };
        (term, format!("{output} while {doing}"))
    }

    fn keep(&mut self, sample: &Sample) {
        let due = self.kept.back().is_none_or(|last| sample.time_s - last.t_s > 0.97 / KEPT_HZ);
        if !due {
            return;
        }
        if self.kept.capacity() == 0 {
            // A ring that grows by doubling comes to take nearly twice what it holds, for each of many wagons.
            self.kept.reserve_exact(MOST_KEPT);
            self.values.reserve_exact(MOST_KEPT * values_of(self.wheelsets));
        }
        if self.kept.len() >= MOST_KEPT {
            self.kept.pop_front();
            self.values.drain(..values_of(self.wheelsets));
        }
        let each = [sample.wheel_speed_rad_s, sample.pressing_force_n, sample.drive_torque_nm];
        let of_wheelsets = each.iter().flat_map(|values| &values[..self.wheelsets]);
        let ends = [&sample.grade_rad, &sample.sanding];
        let values = std::iter::once(&sample.v_m_s).chain(of_wheelsets).chain(ends);
        self.values.extend(values.map(|value| *value as f32));
        let (t_s, position_m, valid) = (sample.time_s, sample.position_m, sample.valid);
        self.kept.push_back(Kept { t_s, position_m, valid, rail: self.rail });
    }

    fn forget_kept(&mut self) {
        (self.kept, self.values) = Default::default();
    }

    /// The latest minutes, oldest first.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = KeptRow> + '_ {
        let wheelsets = self.wheelsets;
        self.kept.iter().enumerate().map(move |(index, kept)| {
            let first = index * values_of(wheelsets);
            let value = |place: usize, bit: u32| {
                if kept.valid & bit == 0 { f64::NAN } else { rounded(f64::from(self.values[first + place])) }
            };
            let mut row = Row { t_s: kept.t_s, v_m_s: value(0, valid::SPEED), ..Row::default() };
            for wheelset in 0..wheelsets {
                let place = |quantity: usize| 1 + quantity * wheelsets + wheelset;
                row.wheel_speed_rad_s[wheelset] = value(place(0), valid::wheel_speed(wheelset));
                row.pressing_force_n[wheelset] = value(place(1), valid::pressing_force(wheelset));
                row.drive_torque_nm[wheelset] = value(place(2), valid::drive_torque(wheelset));
            }
            row.grade_rad = value(1 + 3 * wheelsets, valid::GRADE);
            row.sanding = value(2 + 3 * wheelsets, valid::SANDING);
            row.position_m = if kept.valid & valid::POSITION == 0 { f64::NAN } else { kept.position_m };
            KeptRow { row, rail: kept.rail }
        })
    }

    /// Time of the newest sample, s.
    #[must_use]
    pub fn newest_s(&self) -> f64 {
        self.kept.back().map_or(f64::NAN, |kept| kept.t_s)
    }

    /// Wheelsets of the rows.
    #[must_use]
    pub const fn wheelsets(&self) -> usize {
        self.wheelsets
    }
}

/// What single precision knows, without its tail of digits.
fn rounded(value: f64) -> f64 {
    (value * 1e5).round() / 1e5
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_messages::Stamp;

    /// Keeps so many seconds at 1 kHz of a wagon whose every value tells its place and its time.
    fn kept(wheelsets: usize, seconds: f64) -> GapWatch {
        let mut watch = GapWatch::new(2.0);
        for step in 0..(seconds * 1000.0) as usize {
            let time_s = step as f64 * 1e-3;
            let of = |place: f64| std::array::from_fn(|wheelset| place + 10.0 * wheelset as f64 + time_s);
            let sample = Sample {
                acquired: Stamp::default(),
                time_s,
                v_m_s: time_s,
                wheelsets: wheelsets as u32,
                wheel_speed_rad_s: of(1e2),
                pressing_force_n: of(1e3),
                drive_torque_nm: of(1e4),
                grade_rad: 0.01,
                sanding: 0.5,
                position_m: 20.0 * time_s,
                valid: u32::MAX,
                ..Sample::default()
            };
            watch.take(&sample, &Estimate::default(), &Innovation::default());
        }
        watch
    }

    #[test]
    fn the_latest_minutes_are_kept_in_the_room_that_they_need() {
        for wheelsets in [2, 4] {
            let watch = kept(wheelsets, KEPT_S + 20.0);
            let rows: Vec<KeptRow> = watch.rows().collect();
            assert_eq!(rows.len(), MOST_KEPT);
            assert!((watch.newest_s() - rows[0].row.t_s - KEPT_S).abs() < 0.1);
            for KeptRow { row, .. } in rows.iter().step_by(997) {
                assert!((row.v_m_s - row.t_s).abs() < 1e-4 && (row.position_m - 20.0 * row.t_s).abs() < 1e-9);
                for wheelset in 0..wheelsets {
                    let expected = |place: f64| place + 10.0 * wheelset as f64 + row.t_s;
                    assert!((row.wheel_speed_rad_s[wheelset] - expected(1e2)).abs() < 1e-3);
                    assert!((row.pressing_force_n[wheelset] - expected(1e3)).abs() < 1e-3);
                    assert!((row.drive_torque_nm[wheelset] - expected(1e4)).abs() < 1e-2);
                }
                assert!((row.grade_rad - 0.01).abs() < 1e-6 && (row.sanding - 0.5).abs() < 1e-6);
            }
            assert!(watch.kept.capacity() <= MOST_KEPT + 8);
            assert!(watch.values.capacity() <= MOST_KEPT * values_of(wheelsets) + 8);
        }
    }
}
