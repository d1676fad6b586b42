//! Recordings put right for sensors that read late: each output moved to the time at which it was true.
//!
//! A filter that believes a late reading to be of now corrects what it has long corrected, and its loop becomes unsettled:
//! no fit through it can judge what makes the reading late. Moving the reading costs nothing of what the recordings say,
//! and all other effects can then be seen. Values are moved by whole samples, so that their noise stays as white as it was.

use crate::data::case::{Case, OUTPUTS, Run, Sample, smooth};
use railgrip_vehicle::effects::Lateness;
use railgrip_vehicle::fast::SampleInput;
use std::sync::OnceLock;

/// Alignments of one case that a selection may keep.
const SLOTS: usize = 24;

/// The aligned copies of a case, kept as long as the fits that look at them.
#[derive(Debug, Default)]
pub struct Alignments([OnceLock<Case>; SLOTS]);

impl Alignments {
    /// Keeps a case; `None` if there are too many.
    pub fn keep(&self, case: Case) -> Option<&Case> {
        let mut case = Some(case);
        let slot = self.0.iter().find(|slot| {
            let mut taken = false;
            if let Some(whole) = case.take() {
                case = slot.set(whole).err();
                taken = case.is_none();
            }
            taken
        });
        slot.and_then(OnceLock::get)
    }
}

impl Case {
    /// This case with the outputs of its runs moved to the times at which they were true.
    pub fn aligned(&self, lateness: &dyn Fn(f64) -> Lateness) -> Self {
        let align = |runs: &[Run]| runs.iter().map(|run| run.aligned(lateness)).collect();
        Self { fit: align(&self.fit), holdout: align(&self.holdout), ..self.clone() }
    }
}

impl Run {
    /// See [`Case::aligned`]. What was read after the end of the recording is unknown; so is what was read before its
    /// beginning.
    fn aligned(&self, lateness: &dyn Fn(f64) -> Lateness) -> Self {
        let mut run = self.clone();
        let last = self.len().saturating_sub(1);
        let late = |time_s: f64| {
            let Lateness { v_s, wheel_speed_s, .. } = lateness(time_s);
            let mut late = [wheel_speed_s; OUTPUTS];
            late[0] = v_s;
            late
        };
        for (k, sample) in run.samples.iter_mut().enumerate() {
            let time_s = sample.input.time_s;
            for j in 0..self.outputs() {
                // What was true now is read when its own lateness has passed.
                let read_s = time_s + late(time_s + late(time_s)[j])[j];
                let at = k as f64 + ((read_s - time_s) / self.dt_s).round();
                let from: &Sample = &self.samples[at.clamp(0.0, last as f64) as usize];
                sample.outputs[j] = from.outputs[j];
                sample.measured[j] = from.measured[j] && at >= 0.0 && at <= last as f64;
                if j > 0 {
                    sample.input.wheel_angle_rad[j - 1] = from.input.wheel_angle_rad[j - 1];
                }
            }
        }
        let mean_s = lateness(0.0).wheel_speed_mean_s;
        if mean_s > self.dt_s {
            average_inputs(&mut run.samples, self.wheelsets, 0.5 * mean_s / self.dt_s);
        }
        smooth(&mut run.samples, self.dt_s);
        run
    }
}

/// Means of forces and torques over so many samples to both sides: as far as a wheelset answers in proportion, the mean of its
/// speed is the answer to the mean of what acts on it. Speed of the vehicle changes too slowly to need it.
fn average_inputs(samples: &mut [Sample], wheelsets: usize, half: f64) {
    let n = samples.len();
    let average = |values: Vec<f64>| {
        let mut sums = vec![0.0; n + 1];
        for (k, value) in values.iter().enumerate() {
            sums[k + 1] = sums[k] + value;
        }
        // The sum up to a place between two samples; each sample reaches from half before it to half after it.
        let up_to = |place: f64| {
            let place = (place + 0.5).clamp(0.0, n as f64);
            let whole = (place as usize).min(n - 1);
            sums[whole] + (place - whole as f64) * values[whole]
        };
        let mean = |k: usize| {
            let (from, to) = ((k as f64 - half).max(-0.5), (k as f64 + half).min(n as f64 - 0.5));
            (up_to(to) - up_to(from)) / (to - from)
        };
        (0..n).map(mean).collect::<Vec<f64>>()
    };
    for i in 0..wheelsets {
        let fields: [fn(&mut SampleInput, usize) -> &mut f64; 3] = [
            |input, i| &mut input.pressing_force_n[i],
            |input, i| &mut input.mid_pressing_force_n[i],
            |input, i| &mut input.mid_drive_torque_nm[i],
        ];
        for field in fields {
            let means = average(samples.iter_mut().map(|sample| *field(&mut sample.input, i)).collect());
            samples.iter_mut().zip(means).for_each(|(sample, mean)| *field(&mut sample.input, i) = mean);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::case::Columns;
    use railgrip_vehicle::RailClass;

    /// 20 s at 50 Hz; the wheelsets are read 0.2 s late, and their pressing force is a step.
    fn late_run() -> Run {
        let t_s: Vec<f64> = (0..1000).map(|k| 0.02 * f64::from(k)).collect();
        let speed = |t: f64| 20.0 - 0.5 * t;
        let of = |f: &dyn Fn(f64) -> f64| t_s.iter().map(|t| f(*t)).collect::<Vec<f64>>();
        let columns = Columns {
            v_m_s: of(&speed),
            wheel_speed_rad_s: vec![of(&|t| 2.0 * speed(t - 0.2)), of(&|t| 2.0 * speed(t - 0.2))],
            pressing_force_n: vec![of(&|t| if t < 10.0 { 0.0 } else { 1e4 }), of(&|_| 0.0)],
            drive_torque_nm: vec![of(&|_| 0.0), of(&|_| 0.0)],
            t_s,
            ..Columns::default()
        };
        Run::new("late.dry".into(), RailClass::Dry, &columns)
    }

    #[test]
    fn late_readings_stand_where_they_were_true() {
        let run = late_run();
        let aligned = run.aligned(&|_| Lateness { wheel_speed_s: 0.2, ..Lateness::default() });
        for (k, sample) in aligned.samples.iter().enumerate() {
            assert_eq!(sample.measured[1], k + 10 < run.len(), "sample {k}");
            if sample.measured[1] {
                assert!((sample.outputs[1] - 2.0 * sample.outputs[0]).abs() < 1e-9, "sample {k}");
            }
        }
        assert_eq!(aligned.samples[7].outputs[0], run.samples[7].outputs[0], "vehicle speed is not late");
    }

    #[test]
    fn a_mean_of_the_wheel_speed_is_answered_by_a_mean_of_the_force() {
        let late = Lateness { wheel_speed_s: 0.2, wheel_speed_mean_s: 0.4, v_s: 0.0 };
        let aligned = late_run().aligned(&|_| late);
        let force = |k: usize| aligned.samples[k].input.pressing_force_n[0];
        // The step at sample 500 becomes a ramp of 0.4 s around it.
        assert_eq!((force(480), force(520)), (0.0, 1e4));
        assert!((force(500) - 5.25e3).abs() < 1.0, "{}", force(500));
        assert!((490..510).all(|k| force(k + 1) > force(k)));
    }
}
