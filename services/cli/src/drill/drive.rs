//! A train of the truth plant under the watch, and what came of it.

use super::reading::reading;
use railgrip_causes::{Alert, Reading, TrainWatch, WagonFile};
use railgrip_truth_plant::train::{
    Journey, TrainSpec, Truth,
    label::{Label, Witness},
};

/// An application counts when it lasts so long, s, and begins above this speed, m/s; as in the labels.
const COUNTS_FROM_S: f64 = 3.0;
const COUNTS_ABOVE_M_S: f64 = 3.0;
/// Slip velocity that counts as a slide, m/s, and share of speed; as in the labels.
const SLIDES: (f64, f64) = (0.4, 0.03);
/// An alert of low adhesion is right so long after a wheelset has truly slid, s.
const RECENT_S: f64 = 30.0;

/// A train that was watched.
#[derive(Debug, Clone)]
pub(crate) struct Driven {
    /// What was true.
    pub label: Label,
    /// What was said.
    pub alerts: Vec<Alert>,
    /// When brake applications that count began, s.
    pub brakings_s: Vec<f64>,
    /// Time until which an alert of low adhesion is right, from when on: slides, s.
    pub slides_s: Vec<(f64, f64)>,
    /// Time that the watch took, s.
    pub watch_s: f64,
    /// Time that the train itself took, s.
    pub plant_s: f64,
}

/// Runs a train under a watch that knows the files of its wagons.
pub(crate) fn drive(name: &str, spec: TrainSpec, files: Vec<WagonFile>) -> Driven {
    let mut watch = TrainWatch::new(files);
    let mut journey = Journey::new(spec);
    let mut witness = Witness::default();
    let mut readings: Vec<Reading> = Vec::new();
    let (mut brakings_s, mut slides_s): (Vec<f64>, Vec<(f64, f64)>) = (Vec::new(), Vec::new());
    let mut since_s: Option<(f64, bool)> = None;
    let (mut watch_s, begun) = (0.0, std::time::Instant::now());
    while journey.advance() {
        witness.observe(&journey);
        let head = &journey.truths()[0];
        let order = journey.brake_ordered();
        since_s = match since_s {
            None if order > 0.08 && head.v_m_s > COUNTS_ABOVE_M_S => Some((head.time_s, false)),
            Some((from_s, false)) if order >= 0.05 && head.time_s - from_s > COUNTS_FROM_S => {
                brakings_s.push(from_s);
                Some((from_s, true))
            }
            Some(running) if order >= 0.05 => Some(running),
            _ => None,
        };
        let slides = |k: usize, truth: &Truth| truth.slip_m_s[k] < -(SLIDES.0 + SLIDES.1 * truth.v_m_s);
        if journey.truths().iter().any(|truth| (0..4).any(|k| slides(k, truth))) {
            match slides_s.last_mut().filter(|(_, to_s)| head.time_s < *to_s) {
                Some((_, to_s)) => *to_s = head.time_s + RECENT_S,
                None => slides_s.push((head.time_s, head.time_s + RECENT_S)),
            }
        }
        readings.clear();
        readings.extend(journey.readings().iter().map(|row| reading!(row)));
        let before = std::time::Instant::now();
        watch.take(head.time_s, &readings);
        watch_s += before.elapsed().as_secs_f64();
    }
    Driven {
        label: witness.label(name, &journey),
        alerts: watch.alerts().to_vec(),
        brakings_s,
        slides_s,
        watch_s,
        plant_s: begun.elapsed().as_secs_f64() - watch_s,
    }
}
