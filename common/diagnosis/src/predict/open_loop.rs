//! The gap in one number, by the contract: windows of ten seconds, driven open loop, errors over sensor sigma.

use crate::data::case::{OUTPUTS, Run};
use crate::model::parameters::Built;
use crate::predict::passes::{Pass, counted};
use railgrip_vehicle::Sensors;
use railgrip_vehicle::fast::{Disturbance, FastWagon, Motion};

/// Length of a window, s.
pub const WINDOW_S: f64 = 10.0;
/// Shortest last window, s.
pub const SHORTEST_WINDOW_S: f64 = 1.0;
/// Time over which the measured outputs that start a window are averaged, s.
const START_S: f64 = 0.05;

/// Sensor sigma of each output.
pub fn sigmas(sensors: &Sensors) -> [f64; OUTPUTS] {
    let mut sigmas = [sensors.wheel_speed_sigma_rad_s; OUTPUTS];
    sigmas[0] = sensors.speed_sigma_m_s;
    sigmas
}

/// Windows of a run as ranges of samples; none reaches over a long gap. A rest shorter than a second belongs to no window.
pub fn windows(run: &Run) -> Vec<std::ops::Range<usize>> {
    let length = (WINDOW_S / run.dt_s).round() as usize;
    let shortest = ((SHORTEST_WINDOW_S / run.dt_s).round() as usize).max(start_samples(run.dt_s));
    let mut windows = Vec::new();
    for unbroken in &run.unbroken {
        let (mut from, end) = (unbroken.start, unbroken.end.min(run.len()));
        while from + shortest <= end {
            let to = (from + length).min(end);
            windows.push(from..to);
            from = to;
        }
    }
    windows
}

/// Samples whose mean starts a window: those of its first 0.05 s, at least one.
pub(crate) fn start_samples(dt_s: f64) -> usize {
    ((START_S / dt_s - 0.01).ceil() as usize).max(1)
}

/// The outputs from which a window starts: the mean of what was measured in its first 0.05 s.
fn start(run: &Run, range: &std::ops::Range<usize>) -> [f64; OUTPUTS] {
    let count = start_samples(run.dt_s).min(range.len());
    let first = &run.samples[range.start..range.start + count];
    std::array::from_fn(|j| {
        let measured = || first.iter().filter(|sample| sample.measured[j]);
        match measured().count() {
            0 => first[0].outputs[j],
            n => measured().map(|sample| sample.outputs[j]).sum::<f64>() / n as f64,
        }
    })
}

/// Predicted outputs of one window.
#[derive(Clone, Debug)]
pub struct Prediction {
    /// The window's samples.
    pub range: std::ops::Range<usize>,
    /// Predicted outputs, one row a sample.
    pub outputs: Vec<[f64; OUTPUTS]>,
}

/// Drives the model open loop through every window of a run.
pub fn predict(built: &Built, run: &Run) -> Vec<Prediction> {
    let wagon = FastWagon::new(&built.model, built.adhesion(run.rail), run.dt_s);
    counted(Pass::Windows, run.len(), || {
        let mut windows = Vec::new();
        each_window(&wagon, run, |range, past| {
            windows.push(Prediction { range: range.clone(), outputs: drive(&wagon, run, range, past) });
        });
        windows
    })
}

/// Asks for each window of a run, with the hidden states that it starts from.
pub(crate) fn each_window(
    wagon: &FastWagon,
    run: &Run,
    mut ask: impl FnMut(&std::ops::Range<usize>, &[f64]),
) {
    let mut past = wagon.start_hidden(&run.samples[0].outputs, &run.samples[0].input);
    let mut at = 0;
    for range in windows(run) {
        while at < range.start {
            let sample = &run.samples[at];
            wagon.follow(&sample.measured_motion(), &sample.input, &mut past);
            at += 1;
        }
        ask(&range, &past);
    }
}

/// The motion with which a window starts.
pub(crate) fn start_motion(
    wagon: &FastWagon,
    run: &Run,
    range: &std::ops::Range<usize>,
    past: &[f64],
) -> Motion {
    let first = &run.samples[range.start];
    let measured = Motion { state: start(run, range), ..first.measured_motion() };
    wagon.start_motion(&measured, &first.input, past)
}

fn drive(wagon: &FastWagon, run: &Run, range: &std::ops::Range<usize>, past: &[f64]) -> Vec<[f64; OUTPUTS]> {
    let mut hidden = past.to_vec();
    let mut motion = start_motion(wagon, run, range, past);
    let mut outputs = Vec::with_capacity(range.len());
    for k in range.clone() {
        let sample = &run.samples[k];
        outputs.push(wagon.read(&motion, &sample.input, &hidden));
        if k + 1 < range.end {
            wagon.step(&mut motion, &sample.input, &Disturbance::default(), &mut hidden);
        }
    }
    outputs
}

/// Sums of squared normalised errors of each output, and the number of samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Number of outputs of the wagon; those beyond them are zero.
    pub outputs: usize,
    /// Sums of squares.
    pub squares: [f64; OUTPUTS],
    /// Samples.
    pub count: usize,
    /// Samples at which each output was not measured.
    pub missing: [usize; OUTPUTS],
}

impl Tally {
    /// Adds another tally.
    pub fn add(&mut self, other: &Self) {
        (0..OUTPUTS).for_each(|j| self.squares[j] += other.squares[j]);
        (0..OUTPUTS).for_each(|j| self.missing[j] += other.missing[j]);
        self.count += other.count;
        self.outputs = self.outputs.max(other.outputs);
    }

    /// Gap of one signal: RMS over the samples at which it was measured.
    pub fn signal(&self, output: usize) -> f64 {
        self.mean_square(output).sqrt()
    }

    fn mean_square(&self, output: usize) -> f64 {
        self.squares[output] / self.count.saturating_sub(self.missing[output]).max(1) as f64
    }

    /// The gap: RMS over the signals.
    pub fn gap(&self) -> f64 {
        let squares: f64 = (0..self.outputs).map(|j| self.mean_square(j)).sum();
        (squares / self.outputs.max(1) as f64).sqrt()
    }

    /// Sum over tallies.
    pub fn total<'a>(tallies: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut total = Self::default();
        tallies.into_iter().for_each(|tally| total.add(tally));
        total
    }
}

/// The tally of each window of a run.
pub fn tallies(built: &Built, run: &Run, sigma: &[f64; OUTPUTS]) -> Vec<Tally> {
    predict(built, run).iter().map(|window| tally(window, run, sigma)).collect()
}

/// The square of an error in sigmas, held finite where a model diverged.
pub(crate) fn squared(error: f64) -> f64 {
    if error.is_finite() { (error * error).min(1e12) } else { 1e12 }
}

/// The tally of one predicted window.
pub fn tally(window: &Prediction, run: &Run, sigma: &[f64; OUTPUTS]) -> Tally {
    let outputs = run.outputs();
    let mut tally = Tally { outputs, count: window.range.len(), ..Tally::default() };
    for (k, predicted) in window.range.clone().zip(&window.outputs) {
        let sample = &run.samples[k];
        for j in 0..outputs {
            if !sample.measured[j] {
                tally.missing[j] += 1;
                continue;
            }
            tally.squares[j] += squared((predicted[j] - sample.outputs[j]) / sigma[j]);
        }
    }
    tally
}
