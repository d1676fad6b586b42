//! Alerts against the truth.

use std::collections::BTreeMap;

use railgrip_causes::{Alert, Cause, Grade};
use railgrip_truth_plant::train::label::FaultLabel;

use super::drive::Driven;

/// A runner-up counts as named from this probability on.
const NAMED_FROM: f64 = 0.2;
/// A fault must be found within so many applications after its onset; those that are dangerous at once within fewer.
const WITHIN: usize = 10;
const WITHIN_DANGEROUS: usize = 2;

/// What came of one fault.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub fault: FaultLabel,
    /// Applications from the onset to the first alert that names it.
    pub after_brakings: Option<usize>,
    /// The first alert after the onset that is no slide alarm on a rail that was low.
    pub first: Option<Alert>,
    /// The first that names wagon and cause.
    pub right: Option<Alert>,
    /// Alerts after the onset.
    pub alerts: usize,
}

/// The score of many trains.
#[derive(Debug, Clone, Default)]
pub(crate) struct Score {
    pub trains: usize,
    pub hours: f64,
    /// Train-hours of trains without fault or with one that never showed, and of others before their fault began.
    pub healthy_hours: f64,
    /// False alarms in them: watch, act.
    pub false_alarms: [usize; 2],
    /// False alarms by cause.
    pub false_causes: BTreeMap<&'static str, usize>,
    pub found: Vec<Found>,
    /// Probability that an alert stated and whether it was right.
    pub stated: Vec<(f64, bool)>,
    pub watch_s: f64,
    pub plant_s: f64,
    pub wagon_hours: f64,
}

impl Score {
    /// Takes the outcome of one train.
    pub(crate) fn take(&mut self, driven: &Driven) {
        let label = &driven.label;
        self.trains += 1;
        self.hours += label.hours;
        self.wagon_hours += label.hours * label.wagons.len() as f64;
        self.watch_s += driven.watch_s;
        self.plant_s += driven.plant_s;
        let onset_s = label.fault.as_ref().map_or(f64::INFINITY, |fault| fault.onset_s);
        // A fault that never showed leaves the train as good as healthy.
        let unseen = label.fault.as_ref().is_some_and(|fault| fault.brakings_showing == 0);
        self.healthy_hours += if unseen { label.hours } else { (onset_s / 3600.0).min(label.hours) };
        let is_right = |alert: &Alert| {
            label.fault.as_ref().is_some_and(|fault| at_place(alert, fault) && names(alert, fault))
        };
        let excused = |alert: &Alert| {
            alert.cause == Cause::LowAdhesion
                && driven.slides_s.iter().any(|(from, to)| (*from..*to).contains(&alert.raised_t_s))
        };
        let mut after = Vec::new();
        // Of a low stretch an alert of it is what must come; before the train gets there it is of another.
        let asked = |alert: &Alert| low(label.fault.as_ref()) && alert.raised_t_s >= onset_s;
        for alert in driven.alerts.iter().filter(|alert| !excused(alert) || asked(alert)) {
            if alert.raised_t_s >= onset_s && (!unseen || is_right(alert)) {
                after.push(alert.clone());
                continue;
            }
            self.false_alarms[usize::from(alert.grade == Grade::Act)] += 1;
            *self.false_causes.entry(alert.cause.word()).or_default() += 1;
            self.stated.push((alert.probability, false));
        }
        let Some(fault) = label.fault.clone() else { return };
        let right = after.iter().find(|alert| at_place(alert, &fault) && names(alert, &fault)).cloned();
        for alert in &after {
            self.stated
                .push((alert.probability, at_place(alert, &fault) && alert.cause.word() == fault.cause));
        }
        let brakings = |alert: &Alert| {
            driven.brakings_s.iter().filter(|at| (onset_s..alert.raised_t_s).contains(*at)).count()
        };
        self.found.push(Found {
            after_brakings: right.as_ref().map(brakings),
            first: after.first().cloned(),
            alerts: after.len(),
            right,
            fault,
        });
    }

    /// Share of stated probabilities against what came true, by tenths: the expected calibration error.
    pub(crate) fn calibration_error(&self) -> f64 {
        let mut bins = [(0.0, 0.0, 0.0); 10];
        for (probability, right) in &self.stated {
            let bin = &mut bins[((probability * 10.0) as usize).min(9)];
            *bin = (bin.0 + probability, bin.1 + f64::from(u8::from(*right)), bin.2 + 1.0);
        }
        let off: f64 = bins.iter().map(|(stated, right, _)| (stated - right).abs()).sum();
        off / self.stated.len().max(1) as f64
    }
}

fn low(fault: Option<&FaultLabel>) -> bool {
    fault.is_some_and(|fault| fault.cause == Cause::LowAdhesion.word())
}

/// Whether an alert is about the wagons of the fault.
pub(crate) fn at_place(alert: &Alert, fault: &FaultLabel) -> bool {
    if low(Some(fault)) {
        return alert.wagons.is_empty();
    }
    let inside = alert.wagons.iter().filter(|wagon| fault.places.contains(&(**wagon + 1))).count();
    // Of a part of a train most must be named, of one wagon that one alone.
    inside * 2 > fault.places.len().max(alert.wagons.len())
}

/// Whether an alert names the cause, as such or as a likely other.
fn names(alert: &Alert, fault: &FaultLabel) -> bool {
    let likely = alert.instead.iter().filter(|runner| runner.probability >= NAMED_FROM);
    alert.cause.word() == fault.cause || likely.into_iter().any(|runner| runner.cause.word() == fault.cause)
}

impl Found {
    /// Applications within which it must be found.
    pub(crate) fn within(&self) -> usize {
        let dangerous = [Cause::Dragging.word(), Cause::Isolated.word()];
        if dangerous.contains(&self.fault.cause.as_str()) { WITHIN_DANGEROUS } else { WITHIN }
    }

    /// Found in time.
    pub(crate) fn in_time(&self) -> bool {
        self.after_brakings.is_some_and(|count| count <= self.within())
    }

    /// Whether it could be found: it showed in an application at all.
    pub(crate) fn could_show(&self) -> bool {
        self.fault.brakings_showing > 0
    }

    /// The same, or it was there in an application although nothing faded or slid.
    pub(crate) fn was_there(&self) -> bool {
        let quiet = [Cause::BrakeFade.word(), Cause::LowAdhesion.word()];
        let there = quiet.contains(&self.fault.cause.as_str()) && self.fault.brakings_after_onset > 0;
        there || self.could_show()
    }

    /// Of a fault of one wheelset that was found: whether that is among at most two that are named.
    pub(crate) fn right_wheelset(&self) -> Option<bool> {
        let alert = self.right.as_ref()?;
        (self.fault.wheelsets.len() == 1).then(|| {
            alert.wheelsets.len() <= 2
                && alert.wheelsets.iter().any(|k| self.fault.wheelsets.contains(&(k + 1)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_truth_plant::train::{
        faults::{ActsOn, Shows},
        label::Label,
    };

    /// Two hours with a fault of wagon 2 from half an hour on, and one alert after it.
    fn driven(brakings_showing: usize, alert_wagon: usize) -> Driven {
        let fault = FaultLabel {
            id: "brake_fade".to_owned(),
            cause: "brake_fade".to_owned(),
            acts_on: ActsOn::Wagon,
            size: 0.4,
            unit: String::new(),
            gross: true,
            onset_s: 1800.0,
            wagons: vec!["2".to_owned()],
            places: vec![2],
            wheelsets: vec![1, 2],
            shows: Shows::Fading,
            brakings_after_onset: 12,
            brakings_showing,
            rolling_after_onset_s: 4000.0,
        };
        let label = Label {
            train: "train0000".to_owned(),
            family: "coaches".to_owned(),
            seed: 1,
            coupled: true,
            wagons: ["1", "2", "3"].map(str::to_owned).to_vec(),
            hours: 2.0,
            rate_hz: 20.0,
            way_km: 60.0,
            brakings: 20,
            brakings_with_slide: 0,
            fault: Some(fault),
        };
        let alert = Alert {
            raised_t_s: 3000.0,
            cleared_t_s: None,
            grade: Grade::Watch,
            cause: Cause::BrakeFade,
            wagons: vec![alert_wagon],
            wheelsets: vec![],
            probability: 0.8,
            instead: vec![],
            brakings_seen: 5,
            reason: String::new(),
        };
        Driven {
            label,
            alerts: vec![alert],
            brakings_s: vec![2000.0, 2500.0],
            slides_s: vec![],
            watch_s: 1.0,
            plant_s: 1.0,
        }
    }

    fn scored(brakings_showing: usize, alert_wagon: usize) -> Score {
        let mut score = Score::default();
        score.take(&driven(brakings_showing, alert_wagon));
        score
    }

    #[test]
    fn where_a_fault_never_showed_an_alert_elsewhere_is_false() {
        let score = scored(0, 0);
        assert_eq!((score.false_alarms, score.healthy_hours), ([1, 0], 2.0));
        assert!(score.found[0].first.is_none() && !score.found[0].could_show() && score.found[0].was_there());
        let right = scored(0, 1);
        assert_eq!((right.false_alarms, right.found[0].after_brakings), ([0, 0], Some(2)));
    }

    /// A wheelset slides before the train comes to the low stretch, and is told: that is no false alarm, and not the stretch either.
    #[test]
    fn a_true_slide_before_a_low_stretch_is_no_false_alarm() {
        let mut driven = driven(3, 0);
        let fault = driven.label.fault.as_mut().expect("a fault");
        (fault.id, fault.cause) = ("low_stretch".to_owned(), "low_adhesion".to_owned());
        (fault.acts_on, fault.places) = (ActsOn::Line, vec![1, 2, 3]);
        let alert = Alert { cause: Cause::LowAdhesion, wagons: vec![], ..driven.alerts.remove(0) };
        driven.slides_s = vec![(900.0, 940.0), (2990.0, 3030.0)];
        driven.alerts = vec![Alert { raised_t_s: 910.0, ..alert.clone() }, alert];
        let mut score = Score::default();
        score.take(&driven);
        assert_eq!((score.false_alarms, score.found[0].alerts), ([0, 0], 1));
        driven.slides_s.remove(0);
        score.take(&driven);
        assert_eq!(score.false_alarms, [1, 0]);
    }

    #[test]
    fn where_it_showed_an_alert_elsewhere_names_the_wrong_place() {
        let score = scored(4, 0);
        assert_eq!((score.false_alarms, score.healthy_hours), ([0, 0], 0.5));
        assert!(score.found[0].first.is_some() && score.found[0].right.is_none());
    }
}
