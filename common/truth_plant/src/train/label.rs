//! What was true of a train: the fault, and how often it could be seen.

use serde::{Deserialize, Serialize};

use super::{
    faults::{ActsOn, FADED, Fault, Shows},
    journey::Journey,
    truth::Truth,
};

/// An application counts when brakes are ordered for so long, s, above this speed, m/s.
const COUNTS_FROM_S: f64 = 3.0;
const COUNTS_ABOVE_M_S: f64 = 3.0;
/// Order above which an application begins, and below which it ends.
const BEGINS_ABOVE: f64 = 0.08;
const ENDS_BELOW: f64 = 0.05;
/// Slip velocity that counts as a slide, m/s, and share of speed.
const SLIDE_M_S: f64 = 0.4;
const SLIDE_SHARE: f64 = 0.03;

/// The answer to one train.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Label {
    /// Folder of the train.
    pub train: String,
    /// Family it was drawn from.
    pub family: String,
    /// Seed it follows from.
    pub seed: u64,
    /// Whether its wagons are coupled.
    pub coupled: bool,
    /// Vehicle numbers, front first.
    pub wagons: Vec<String>,
    /// Length, h.
    pub hours: f64,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Way of the head of the train, km.
    pub way_km: f64,
    /// Brake applications of the whole day.
    pub brakings: usize,
    /// Those with a slide anywhere in the train.
    pub brakings_with_slide: usize,
    /// The fault, if there is one that began.
    pub fault: Option<FaultLabel>,
}

/// A fault as it was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FaultLabel {
    /// Row of the table.
    pub id: String,
    /// Cause that an alert should name.
    pub cause: String,
    /// What it acts on.
    pub acts_on: ActsOn,
    /// Size with its unit.
    pub size: f64,
    /// Unit.
    pub unit: String,
    /// Whether it is so large that it must be found.
    pub gross: bool,
    /// When it began, s.
    pub onset_s: f64,
    /// Wagons concerned, by number.
    pub wagons: Vec<String>,
    /// Their places, 1 for the first of the train.
    pub places: Vec<usize>,
    /// Wheelsets concerned in each, 1 for the first.
    pub wheelsets: Vec<usize>,
    /// When it can be seen at all.
    pub shows: Shows,
    /// Brake applications that began after the onset.
    pub brakings_after_onset: usize,
    /// Those of them in which it could be seen.
    pub brakings_showing: usize,
    /// Time for which the train rolled after the onset, s.
    pub rolling_after_onset_s: f64,
}

/// Watches a journey sample by sample and makes its label.
#[derive(Debug, Clone, Default)]
pub struct Witness {
    since_s: Option<f64>,
    counted: bool,
    counted_slide: bool,
    counted_showing: bool,
    began_after_onset: bool,
    brakings: usize,
    with_slide: usize,
    after_onset: usize,
    showing: usize,
    rolling_s: f64,
    from_m: Option<f64>,
    to_m: f64,
}

impl Witness {
    /// Looks at the sample that the journey has just made.
    pub fn observe(&mut self, journey: &Journey) {
        let truths = journey.truths();
        let Some(head) = truths.first() else { return };
        self.from_m.get_or_insert(head.head_m);
        self.to_m = head.head_m;
        if journey.onset_s().is_some() && head.v_m_s > 0.5 {
            self.rolling_s += 1.0 / journey.spec().rate_hz;
        }
        self.follow_braking(journey, head);
        if self.counted {
            self.look_for_slides(journey, truths);
            self.look_for_fade(journey, truths);
        }
    }

    fn follow_braking(&mut self, journey: &Journey, head: &Truth) {
        let order = journey.brake_ordered();
        match self.since_s {
            None if order > BEGINS_ABOVE && head.v_m_s > COUNTS_ABOVE_M_S => {
                *self = Self { since_s: Some(head.time_s), ..self.clone() };
                (self.counted, self.counted_slide, self.counted_showing) = (false, false, false);
                let begins_there =
                    journey.spec().fault.is_some_and(|fault| fault.kind.acts_on == ActsOn::Line);
                self.began_after_onset = journey.onset_s().is_some() || begins_there;
            }
            Some(since_s) if order >= ENDS_BELOW && head.v_m_s > 0.5 => {
                if !self.counted && head.time_s - since_s > COUNTS_FROM_S {
                    self.counted = true;
                    self.brakings += 1;
                    if self.began_after_onset && journey.onset_s().is_some() {
                        self.after_onset += 1;
                        self.show(journey, Shows::Braking);
                        self.show(journey, Shows::Rolling);
                    }
                }
            }
            _ => {
                self.since_s = None;
                self.counted = false;
            }
        }
    }

    fn look_for_slides(&mut self, journey: &Journey, truths: &[Truth]) {
        if !self.counted_slide && truths.iter().any(|truth| (0..4).any(|k| slides(truth, k))) {
            self.counted_slide = true;
            self.with_slide += 1;
        }
        let Some(fault) = journey.spec().fault.filter(|_| journey.onset_s().is_some()) else { return };
        let slides_here = |wagon: usize| {
            let wheelsets = fault.wheelsets(journey.spec().wagons[wagon].wheelsets());
            wheelsets.clone().any(|k| slides(&truths[wagon], k))
        };
        if self.began_after_onset && fault.wagons(truths.len()).any(slides_here) {
            self.show(journey, Shows::Sliding);
        }
    }

    fn look_for_fade(&mut self, journey: &Journey, truths: &[Truth]) {
        let Some(fault) = journey.spec().fault.filter(|_| journey.onset_s().is_some()) else { return };
        let fades_here = |wagon: usize| {
            let truth = &truths[wagon];
            let mut wheelsets = fault.wheelsets(journey.spec().wagons[wagon].wheelsets());
            wheelsets.any(|k| truth.faded[k] >= FADED && truth.pad_friction[k].is_finite())
        };
        if self.began_after_onset && fault.wagons(truths.len()).any(fades_here) {
            self.show(journey, Shows::Fading);
        }
    }

    fn show(&mut self, journey: &Journey, what: Shows) {
        let shows = journey.spec().fault.is_some_and(|fault| fault.kind.shows == what);
        if shows && !self.counted_showing {
            self.counted_showing = true;
            self.showing += 1;
        }
    }

    /// The label of the journey, once it is over.
    #[must_use]
    pub fn label(&self, train: &str, journey: &Journey) -> Label {
        let spec = journey.spec();
        let numbers: Vec<String> = spec.wagons.iter().map(|wagon| wagon.number.clone()).collect();
        let fault = spec.fault.zip(journey.onset_s());
        Label {
            train: train.to_owned(),
            family: spec.family.to_owned(),
            seed: spec.seed,
            coupled: spec.coupled,
            hours: spec.duration_s / 3600.0,
            rate_hz: spec.rate_hz,
            way_km: (self.to_m - self.from_m.unwrap_or(self.to_m)) / 1000.0,
            brakings: self.brakings,
            brakings_with_slide: self.with_slide,
            fault: fault.map(|(fault, onset_s)| self.fault(&fault, onset_s, journey, &numbers)),
            wagons: numbers,
        }
    }

    fn fault(&self, fault: &Fault, onset_s: f64, journey: &Journey, numbers: &[String]) -> FaultLabel {
        let wagons = fault.wagons(numbers.len());
        let wheelsets = fault.wheelsets(journey.spec().wagons[fault.wagon].wheelsets());
        FaultLabel {
            id: fault.kind.id.to_owned(),
            cause: fault.kind.cause.to_owned(),
            acts_on: fault.kind.acts_on,
            size: fault.size,
            unit: fault.kind.unit.to_owned(),
            gross: fault.is_gross(),
            onset_s,
            wagons: numbers[wagons.clone()].to_vec(),
            places: wagons.map(|wagon| wagon + 1).collect(),
            wheelsets: wheelsets.map(|k| k + 1).collect(),
            shows: fault.kind.shows,
            brakings_after_onset: self.after_onset,
            brakings_showing: self.showing,
            rolling_after_onset_s: self.rolling_s,
        }
    }
}

/// Whether a wheelset slides in braking.
fn slides(truth: &Truth, wheelset: usize) -> bool {
    truth.slip_m_s[wheelset] < -(SLIDE_M_S + SLIDE_SHARE * truth.v_m_s)
}
