//! The alerts: one a fault. A suspicion that is confirmed often enough is raised; while it is open, what else the same
//! wagons show is taken as its consequence.

use crate::cause::{Cause, Grade};

/// An unconfirmed suspicion is dropped after this time, s.
const FORGOTTEN_S: f64 = 1500.0;
/// What comes back within this time after it was cleared is the same alert again, s.
const SAME_AGAIN_S: f64 = 3600.0;

/// Another cause that would explain the same.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Runner {
    /// The cause.
    pub cause: Cause,
    /// Its probability.
    pub probability: f64,
}

/// An alert.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Alert {
    /// When it was raised, s.
    pub raised_t_s: f64,
    /// When it was cleared, s.
    pub cleared_t_s: Option<f64>,
    /// How bad it is.
    pub grade: Grade,
    /// What explains all that is seen.
    pub cause: Cause,
    /// Wagons concerned, from 0, front first; empty: the whole train.
    pub wagons: Vec<usize>,
    /// Wheelsets that it may be, from 0; empty: of the wagon as a whole.
    pub wheelsets: Vec<usize>,
    /// Probability of the cause.
    pub probability: f64,
    /// What it may be instead.
    pub instead: Vec<Runner>,
    /// Brake applications seen until it was raised.
    pub brakings_seen: u32,
    /// Why, in words.
    pub reason: String,
}

/// What one look at the data suggests.
#[derive(Debug, Clone)]
pub(crate) struct Suspicion {
    pub cause: Cause,
    pub wagons: Vec<usize>,
    pub wheelsets: Vec<usize>,
    pub grade: Grade,
    pub probability: f64,
    pub instead: Vec<Runner>,
    pub reason: String,
    /// Looks that must agree.
    pub needed: u32,
}

#[derive(Debug, serde::Serialize, serde::Deserialize)]
struct Pending {
    cause: Cause,
    wagons: Vec<usize>,
    wheelsets: Vec<usize>,
    hits: u32,
    last_s: f64,
}

/// All alerts of a train, and what may become one.
#[derive(Debug, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Book {
    pending: Vec<Pending>,
    confirmed_s: Vec<f64>,
    pub alerts: Vec<Alert>,
}

impl Book {
    /// Whether it can be the book of so many wagons.
    pub(crate) fn is_sound(&self, wagons: usize) -> bool {
        let within = |all: &[usize]| all.iter().all(|wagon| *wagon < wagons);
        self.alerts.len() == self.confirmed_s.len()
            && self.alerts.iter().all(|alert| within(&alert.wagons))
            && self.pending.iter().all(|pending| within(&pending.wagons))
    }

    /// Takes a suspicion of now.
    pub(crate) fn suspect(&mut self, suspicion: Suspicion, time_s: f64, brakings: u32) {
        for (alert, confirmed_s) in self.alerts.iter_mut().zip(&mut self.confirmed_s) {
            if alert.cleared_t_s.is_none() && concerns(&alert.wagons, &suspicion.wagons) {
                if alert.cause == suspicion.cause {
                    *confirmed_s = time_s;
                    alert.grade = alert.grade.max(suspicion.grade);
                }
                let stands = suspicion.cause.outranks(alert.cause) || !alert.cause.explains(suspicion.cause);
                if alert.cause == suspicion.cause || !stands {
                    return;
                }
            }
        }
        self.pending.retain(|pending| time_s - pending.last_s < FORGOTTEN_S);
        let same = |pending: &&mut Pending| {
            pending.cause == suspicion.cause
                && pending.wagons == suspicion.wagons
                && pending.wheelsets == suspicion.wheelsets
        };
        let hits = match self.pending.iter_mut().find(same) {
            Some(pending) => {
                (pending.hits, pending.last_s) = (pending.hits + 1, time_s);
                pending.hits
            }
            None => {
                self.pending.push(Pending {
                    cause: suspicion.cause,
                    wagons: suspicion.wagons.clone(),
                    wheelsets: suspicion.wheelsets.clone(),
                    hits: 1,
                    last_s: time_s,
                });
                1
            }
        };
        if hits >= suspicion.needed {
            for alert in self.alerts.iter_mut().filter(|alert| alert.cleared_t_s.is_none()) {
                if concerns(&alert.wagons, &suspicion.wagons) && suspicion.cause.outranks(alert.cause) {
                    alert.cleared_t_s = Some(time_s);
                }
            }
            if self.reopen(&suspicion, time_s) {
                return;
            }
            self.confirmed_s.push(time_s);
            self.alerts.push(Alert {
                raised_t_s: time_s,
                cleared_t_s: None,
                grade: suspicion.grade,
                cause: suspicion.cause,
                wagons: suspicion.wagons,
                wheelsets: suspicion.wheelsets,
                probability: suspicion.probability,
                instead: suspicion.instead,
                brakings_seen: brakings,
                reason: suspicion.reason,
            });
        }
    }

    /// Opens again what was cleared lately, if it is the same at the same place.
    fn reopen(&mut self, suspicion: &Suspicion, time_s: f64) -> bool {
        let same = |alert: &Alert| {
            alert.cause == suspicion.cause
                && alert.wagons == suspicion.wagons
                && alert.cleared_t_s.is_some_and(|cleared_s| time_s - cleared_s < SAME_AGAIN_S)
        };
        let Some(index) = self.alerts.iter().rposition(same) else { return false };
        self.alerts[index].cleared_t_s = None;
        self.confirmed_s[index] = time_s;
        true
    }

    /// Clears what nothing has confirmed for long.
    pub(crate) fn settle(&mut self, time_s: f64) {
        for (alert, confirmed_s) in self.alerts.iter_mut().zip(&self.confirmed_s) {
            if alert.cleared_t_s.is_none() && time_s - confirmed_s > alert.cause.lasts_s() {
                alert.cleared_t_s = Some(time_s);
            }
        }
    }

    /// Causes of the open alerts that name that wagon.
    pub(crate) fn open(&self, wagon: usize) -> impl Iterator<Item = Cause> {
        let open = move |alert: &&Alert| alert.cleared_t_s.is_none() && alert.wagons.contains(&wagon);
        self.alerts.iter().filter(open).map(|alert| alert.cause)
    }
}

/// Whether two alerts are about the same wagons; the whole train is a place of its own.
fn concerns(open: &[usize], new: &[usize]) -> bool {
    (open.is_empty() && new.is_empty()) || new.iter().any(|wagon| open.contains(wagon))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn suspicion(cause: Cause, wagon: usize, needed: u32) -> Suspicion {
        Suspicion {
            cause,
            wagons: vec![wagon],
            wheelsets: vec![0],
            grade: Grade::Watch,
            probability: 0.9,
            instead: Vec::new(),
            reason: String::new(),
            needed,
        }
    }

    #[test]
    fn one_fault_is_one_alert() {
        let mut book = Book::default();
        book.suspect(suspicion(Cause::TachometerLate, 3, 2), 10.0, 0);
        assert!(book.alerts.is_empty());
        book.suspect(suspicion(Cause::TachometerLate, 3, 2), 20.0, 1);
        book.suspect(suspicion(Cause::PadUneven, 3, 1), 30.0, 2);
        book.suspect(suspicion(Cause::PadUneven, 4, 1), 30.0, 2);
        let causes: Vec<Cause> = book.alerts.iter().map(|alert| alert.cause).collect();
        assert_eq!(causes, [Cause::TachometerLate, Cause::PadUneven]);
        let open = |book: &Book, wagon: usize| book.open(wagon).collect::<Vec<Cause>>();
        assert_eq!((open(&book, 3), open(&book, 5)), (vec![Cause::TachometerLate], vec![]));
        book.suspect(suspicion(Cause::WheelFlat, 4, 1), 31.0, 2);
        assert_eq!(open(&book, 4), [Cause::WheelFlat], "a wrong sensor explains what it showed of pads");
        let over_s = 20.0 + Cause::TachometerLate.lasts_s() + 1.0;
        book.settle(over_s);
        assert_eq!(open(&book, 3), []);
        book.suspect(suspicion(Cause::TachometerLate, 3, 1), over_s + 60.0, 9);
        assert_eq!((open(&book, 3), book.alerts.len()), (vec![Cause::TachometerLate], 3), "the same again");
    }

    /// A wheel that is smaller than its file says is so until somebody corrects the file; it once hid a wheelset without a brake.
    #[test]
    fn a_wrong_wheel_speed_hides_nothing_that_pressing_forces_show() {
        let mut book = Book::default();
        for cause in [Cause::WheelDiameter, Cause::Isolated, Cause::PadUneven] {
            book.suspect(suspicion(cause, 2, 1), 10.0, 1);
        }
        assert_eq!(book.open(2).collect::<Vec<Cause>>(), [Cause::WheelDiameter, Cause::Isolated]);
        for cause in [Cause::Clock, Cause::LateDistributor] {
            book.suspect(suspicion(cause, 3, 1), 10.0, 1);
        }
        assert_eq!(book.open(3).collect::<Vec<Cause>>(), [Cause::Clock], "all of it comes late");
    }

    /// A payload that was entered wrongly is so all day; it once hid every other fault of its wagon.
    #[test]
    fn a_wrong_payload_hides_what_weight_does_and_no_other_fault() {
        let mut book = Book::default();
        for cause in [Cause::Payload, Cause::PadLow, Cause::Dragging, Cause::TachometerLate, Cause::WheelFlat]
        {
            book.suspect(suspicion(cause, 2, 1), 10.0, 1);
        }
        assert_eq!(book.open(2).collect::<Vec<Cause>>(), [Cause::Payload, Cause::TachometerLate]);
        book.suspect(suspicion(Cause::Payload, 2, 1), 20.0, 2);
        let raised: Vec<Cause> = book.alerts.iter().map(|alert| alert.cause).collect();
        assert_eq!(raised, [Cause::Payload, Cause::Dragging, Cause::TachometerLate]);
    }
}
