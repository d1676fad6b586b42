//! A case in memory: the nominal vehicle and the runs, with what a simulation needs at each sample prepared once.

use crate::data::noise::SensorNoise;
use railgrip_vehicle::fast::{self, Motion, SampleInput};
use railgrip_vehicle::{MAX_WHEELSETS, PerWheelset, RailClass, VehicleParameters};
use std::ops::Range;

/// Most measured outputs of a case: vehicle speed, then the speed of each wheelset. What a wagon has not got is never measured.
pub const OUTPUTS: usize = fast::SPEEDS;

/// Names of the outputs of a wagon, in the order of every array of outputs: two wheelsets are a front and a rear one, others are
/// numbered from the front.
pub fn output_names(wheelsets: usize) -> &'static [&'static str] {
    const NUMBERED: [&str; OUTPUTS] =
        ["v_m_s", "omega_1_rad_s", "omega_2_rad_s", "omega_3_rad_s", "omega_4_rad_s"];
    match wheelsets {
        2 => &["v_m_s", "omega_f_rad_s", "omega_r_rad_s"],
        _ => &NUMBERED[..(1 + wheelsets).min(OUTPUTS)],
    }
}

/// Outputs for which the filters of a wagon have room: they are compiled for two wheelsets and for four.
pub const fn room(wheelsets: usize) -> usize {
    if wheelsets <= 2 { 3 } else { OUTPUTS }
}

/// Columns of one run at a regular rate; optional columns are empty where absent. Outputs and positions that were not
/// measured are NaN, inputs are all there.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// Time, s.
    pub t_s: Vec<f64>,
    /// Vehicle speed, m/s.
    pub v_m_s: Vec<f64>,
    /// Speed of each wheelset, rad/s.
    pub wheel_speed_rad_s: Vec<Vec<f64>>,
    /// Pressing force of each, N.
    pub pressing_force_n: Vec<Vec<f64>>,
    /// Drive torque of each, N m.
    pub drive_torque_nm: Vec<Vec<f64>>,
    /// Grade, rad.
    pub grade_rad: Vec<f64>,
    /// Sanding, 0 to 1.
    pub sanding: Vec<f64>,
    /// Position by satellite, m.
    pub position_m: Vec<f64>,
}

/// One sample of a run: measured outputs, inputs, and what follows from them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample {
    /// Inputs and what else a simulation may know: the position is the integral of measured speed, moved to fit the
    /// satellite's positions on the whole.
    pub input: SampleInput,
    /// Measured outputs in the order of [`output_names`]; where one was not measured, a straight line between those that
    /// were.
    pub outputs: [f64; OUTPUTS],
    /// Which outputs were measured.
    pub measured: [bool; OUTPUTS],
    /// Slopes of the measured outputs over a quarter of a second around, 1/s of their units.
    pub slopes: [f64; OUTPUTS],
    /// Outputs smoothed over the same stretch.
    pub smooth: [f64; OUTPUTS],
}

impl Sample {
    /// Measured minus expected outputs; zero where nothing was measured.
    #[inline]
    pub fn innovation<const S: usize>(&self, expected: &[f64; S]) -> [f64; S] {
        std::array::from_fn(|j| if self.measured[j] { self.outputs[j] - expected[j] } else { 0.0 })
    }

    /// The outputs as they were measured, NaN where they were not.
    pub fn as_measured(&self, output: usize) -> f64 {
        if self.measured[output] { self.outputs[output] } else { f64::NAN }
    }

    /// The motion that was measured around this sample: smoothed speeds and their slopes.
    pub fn measured_motion(&self) -> Motion {
        Motion {
            state: self.smooth,
            acceleration_m_s2: self.slopes[0],
            wheel_acceleration_rad_s2: std::array::from_fn(|i| self.slopes[1 + i]),
        }
    }
}

/// A run ready to be simulated.
#[derive(Clone, Debug)]
pub struct Run {
    /// `NAME.RAIL`, or `NAME` where the name declares no rail. Parts of one recording have the same name.
    pub name: String,
    /// Class of the rail.
    pub rail: RailClass,
    /// Number of wheelsets.
    pub wheelsets: usize,
    /// Sample period, s.
    pub dt_s: f64,
    /// Time of the first sample as recorded, s.
    pub start_s: f64,
    /// The samples.
    pub samples: Vec<Sample>,
    /// Whether the recording has positions.
    pub has_position: bool,
    /// Recorded times, s.
    pub t_s: Vec<f64>,
    /// Ranges of samples in which no output is missing for long.
    pub unbroken: Vec<Range<usize>>,
}

/// A case: what the simulator believes, runs to fit on and runs to predict.
#[derive(Clone, Debug)]
pub struct Case {
    /// The nominal vehicle.
    pub vehicle: VehicleParameters,
    /// Runs to fit on, by name.
    pub fit: Vec<Run>,
    /// Runs only to predict, by name.
    pub holdout: Vec<Run>,
    /// Noise of each output.
    pub noise: [SensorNoise; OUTPUTS],
    /// What was mended in the recordings and assumed about them, in sentences.
    pub notes: Vec<String>,
}

impl Case {
    /// Whether couplers pull and push the wagon (`[train] free = false`).
    pub fn is_coupled(&self) -> bool {
        self.vehicle.train.is_some_and(|running| !running.free)
    }

    /// Number of wheelsets.
    pub fn wheelsets(&self) -> usize {
        self.vehicle.wheelsets()
    }

    /// Number of outputs: vehicle speed and wheelset speeds.
    pub fn outputs(&self) -> usize {
        1 + self.wheelsets()
    }

    /// Names of the outputs, see [`output_names`].
    pub fn output_names(&self) -> &'static [&'static str] {
        output_names(self.wheelsets())
    }

    /// The case with every second (third, …) sample of the runs to fit on that were sampled at twice (thrice, …) this rate
    /// or more; `None` where there is no such run. What acts on a wagon changes over tenths of a second: above some rate
    /// samples tell of the sensors' noise and cost time.
    pub fn thinned(&self, rate_hz: f64) -> Option<Self> {
        let factor = |run: &Run| ((1.0 / (run.dt_s * rate_hz) + 0.05) as usize).max(1);
        let dense = self.fit.iter().any(|run| factor(run) > 1);
        dense.then(|| Self {
            fit: self.fit.iter().map(|run| run.thinned(factor(run))).collect(),
            ..self.clone()
        })
    }
}

/// Half width of the stretch over which slopes are taken, s.
const SLOPE_HALF_WIDTH_S: f64 = 0.12;
/// An output that is missing for longer breaks a run: no window reaches over it, s.
const LONGEST_GAP_S: f64 = 0.5;

impl Run {
    /// Prepares a recorded run.
    pub fn new(name: String, rail: RailClass, columns: &Columns) -> Self {
        let n = columns.t_s.len();
        let dt_s = if n > 1 { (columns.t_s[n - 1] - columns.t_s[0]) / (n - 1) as f64 } else { 0.01 };
        let wheelsets = columns.wheel_speed_rad_s.len().min(MAX_WHEELSETS);
        let measured: Vec<&Vec<f64>> =
            std::iter::once(&columns.v_m_s).chain(&columns.wheel_speed_rad_s[..wheelsets]).collect();
        let unbroken = unbroken(&measured, dt_s);
        let outputs: Vec<Vec<f64>> = measured.iter().map(|column| filled(column)).collect();
        let positions = positions(&outputs[0], &columns.position_m, dt_s);
        let mut samples = vec![Sample::default(); n];
        let mut angle = [0.0; MAX_WHEELSETS];
        for (k, sample) in samples.iter_mut().enumerate() {
            let next = (k + 1).min(n - 1);
            sample.input.time_s = columns.t_s[k] - columns.t_s[0];
            for (j, (filled, as_measured)) in outputs.iter().zip(&measured).enumerate() {
                sample.outputs[j] = filled[k];
                sample.measured[j] = as_measured[k].is_finite();
            }
            for i in 0..wheelsets {
                let force = &columns.pressing_force_n[i];
                let torque = &columns.drive_torque_nm[i];
                let speed = &outputs[1 + i];
                sample.input.pressing_force_n[i] = force[k];
                sample.input.mid_pressing_force_n[i] = 0.5 * (force[k] + force[next]);
                sample.input.mid_drive_torque_nm[i] = 0.5 * (torque[k] + torque[next]);
                sample.input.wheel_angle_rad[i] = angle[i];
                angle[i] += 0.5 * (speed[k] + speed[next]) * dt_s;
            }
            sample.input.grade_rad = columns.grade_rad.get(k).copied().unwrap_or(0.0);
            sample.input.sanding = columns.sanding.get(k).copied().unwrap_or(0.0);
            sample.input.position_m = positions[k];
        }
        smooth(&mut samples, dt_s);
        Self {
            name,
            rail,
            wheelsets,
            dt_s,
            start_s: columns.t_s[0],
            samples,
            has_position: columns.position_m.iter().any(|position| position.is_finite()),
            t_s: columns.t_s.clone(),
            unbroken,
        }
    }

    /// Every `factor`-th sample, driven by the means of what acted in between.
    fn thinned(&self, factor: usize) -> Self {
        let mean = |steps: &[Sample], of: fn(&SampleInput) -> &PerWheelset| -> PerWheelset {
            let sum = |i: usize| steps.iter().map(|step| of(&step.input)[i]).sum::<f64>();
            std::array::from_fn(|i| sum(i) / steps.len() as f64)
        };
        let thin = |steps: &[Sample]| {
            let mut sample = steps[0];
            sample.input.mid_pressing_force_n = mean(steps, |input| &input.mid_pressing_force_n);
            sample.input.mid_drive_torque_nm = mean(steps, |input| &input.mid_drive_torque_nm);
            sample
        };
        Self {
            dt_s: self.dt_s * factor as f64,
            samples: self.samples.chunks(factor).map(thin).collect(),
            t_s: self.t_s.iter().step_by(factor).copied().collect(),
            unbroken: self
                .unbroken
                .iter()
                .map(|r| r.start.div_ceil(factor)..r.end.div_ceil(factor))
                .collect(),
            ..self.clone()
        }
    }

    /// Number of outputs: vehicle speed and wheelset speeds.
    pub fn outputs(&self) -> usize {
        1 + self.wheelsets
    }

    /// Outputs for which its filters have room, see [`room`].
    pub fn room(&self) -> usize {
        room(self.wheelsets)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }
}

/// The integral of measured speed, moved so that it fits the satellite's positions in the mean.
fn positions(v_m_s: &[f64], satellite_m: &[f64], dt_s: f64) -> Vec<f64> {
    let mut x = 0.0;
    let mut integral = Vec::with_capacity(v_m_s.len());
    for pair in v_m_s.windows(2) {
        integral.push(x);
        x += 0.5 * (pair[0] + pair[1]) * dt_s;
    }
    integral.push(x);
    let known = || satellite_m.iter().zip(&integral).filter(|(position, _)| position.is_finite());
    let count = known().count();
    if count > 0 {
        let shift = known().map(|(position, x)| position - x).sum::<f64>() / count as f64;
        integral.iter_mut().for_each(|x| *x += shift);
    }
    integral
}

/// A column with straight lines over what was not measured, and the nearest value at its ends.
fn filled(column: &[f64]) -> Vec<f64> {
    let mut filled = column.to_vec();
    let known: Vec<usize> = (0..column.len()).filter(|k| column[*k].is_finite()).collect();
    let (Some(first), Some(last)) = (known.first(), known.last()) else { return vec![0.0; column.len()] };
    filled[..*first].fill(column[*first]);
    filled[*last..].fill(column[*last]);
    for pair in known.windows(2).filter(|pair| pair[1] > pair[0] + 1) {
        let (from, to) = (pair[0], pair[1]);
        let slope = (column[to] - column[from]) / (to - from) as f64;
        (from + 1..to).for_each(|k| filled[k] = column[from] + slope * (k - from) as f64);
    }
    filled
}

/// Ranges between stretches in which an output is missing for long.
fn unbroken(outputs: &[&Vec<f64>], dt_s: f64) -> Vec<Range<usize>> {
    let n = outputs[0].len();
    let mut broken = vec![false; n];
    for column in outputs {
        let mut from = 0;
        for k in 0..=n {
            if k == n || column[k].is_finite() {
                // From one measured value to the next; one is missing where that is two samples.
                if k > from && (k + 1 - from) as f64 * dt_s > LONGEST_GAP_S + 1e-9 {
                    broken[from..k].fill(true);
                }
                from = k + 1;
            }
        }
    }
    let mut ranges = Vec::new();
    let mut from = 0;
    while let Some(begin) = (from..n).find(|k| !broken[*k]) {
        let end = (begin..n).find(|k| broken[*k]).unwrap_or(n);
        ranges.push(begin..end);
        from = end;
    }
    ranges
}

/// Fills in slopes and smoothed values by straight lines over a sliding stretch.
pub(super) fn smooth(samples: &mut [Sample], dt_s: f64) {
    let n = samples.len();
    let half = ((SLOPE_HALF_WIDTH_S / dt_s).round() as usize).max(1);
    for k in 0..n {
        let (from, to) = (k.saturating_sub(half), (k + half).min(n - 1));
        let count = (to - from + 1) as f64;
        let centre = 0.5 * (from + to) as f64;
        let (mut spread, mut sum, mut moment) = (0.0, [0.0; OUTPUTS], [0.0; OUTPUTS]);
        for (j, sample) in samples.iter().enumerate().take(to + 1).skip(from) {
            let lever = j as f64 - centre;
            spread += lever * lever;
            for i in 0..OUTPUTS {
                sum[i] += sample.outputs[i];
                moment[i] += lever * sample.outputs[i];
            }
        }
        for i in 0..OUTPUTS {
            let slope = if spread > 0.0 { moment[i] / spread } else { 0.0 };
            samples[k].slopes[i] = slope / dt_s;
            samples[k].smooth[i] = sum[i] / count + slope * (k as f64 - centre);
        }
    }
}
