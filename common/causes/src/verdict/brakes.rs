//! Pressing forces: who has none, who has too little, who has some left, who is late.

use super::limits::{
    BESIDE, LATE, LEAKS, LEFT, MOST_ODDS, NO_FORCE, NOT_PRESSED, OFFSET_N, OWED_RUNNING_S, OWED_S, SEVERAL,
    SLOW_FALL, SLOW_RISE, TELLING, TOLD_LATER,
};
use crate::cause::{Cause, Grade};
use crate::pressure::{Beside, Looks};
use crate::robust::median;
use crate::timing::{End, Stroke};
use crate::watch::{TrainWatch, Wagon};

impl TrainWatch {
    /// What is left in cylinders that should be empty.
    pub(crate) fn judge_released(&mut self) {
        for index in 0..self.wagons.len() {
            let wagon = &self.wagons[index];
            let full_n = wagon.pressure.full_n;
            let Some(left_n) = wagon.pressure.released_n().filter(|_| full_n > 1000.0) else { continue };
            let wheelsets = wagon.wheel.len();
            // Cylinders do not pull: one that reads less than nothing has a transducer that does.
            let below_n = -(LEFT * full_n).max(250.0);
            let sound = || left_n[..wheelsets].iter().copied().filter(|one_n| *one_n > below_n);
            let least_n = sound().fold(f64::INFINITY, f64::min);
            for k in (0..wheelsets).filter(|k| left_n[*k] <= below_n) {
                let percent = -100.0 * left_n[k] / full_n;
                let reason = format!("pressure transducer shows {percent:.0} % of full force less than none");
                self.suspect(Cause::PressureSensor, (index, vec![k]), (Grade::Watch, 0.9, 3), &[], reason);
            }
            if !least_n.is_finite() {
                continue;
            }
            let share = least_n / full_n;
            if share > LEFT {
                let rolls = self.v_m_s > 3.0;
                let grade = if share > 0.08 { Grade::Act } else { Grade::Watch };
                if rolls {
                    let reason = format!("{:.0} % of full pressing force stays after release", 100.0 * share);
                    let all = (0..wheelsets).collect();
                    self.suspect(Cause::Dragging, (index, all), (grade, 0.95, 2), &[], reason);
                }
                continue;
            }
            for k in 0..wheelsets {
                let share = (left_n[k] - least_n) / full_n;
                if share > LEFT && left_n[k] - least_n > 250.0 {
                    let reason = format!(
                        "pressure transducer shows {:.0} % of full force while the others show none",
                        100.0 * share
                    );
                    let how = (Grade::Watch, 0.9, 3);
                    let instead = [(Cause::Dragging, 0.08)];
                    self.suspect(Cause::PressureSensor, (index, vec![k]), how, &instead, reason);
                }
            }
        }
    }

    /// Pressing forces of the application that has just ended.
    pub(crate) fn judge_application(&mut self) {
        let cut = self.without_brake(self.braking.lasted_s);
        self.tell_cut(&cut);
        for index in 0..self.wagons.len() {
            if !cut.iter().any(|(wagon, _)| *wagon == index) {
                self.judge_beside(index);
            }
        }
        self.judge_rises();
        self.judge_pads();
        self.judge_pressed();
    }

    /// Wagons that owe force while the application runs: one that never ends is judged all the same.
    pub(crate) fn judge_running(&mut self) {
        if self.braking.since_s().is_none() {
            return;
        }
        let owing = |(index, wagon): (usize, &Wagon)| {
            let owed_s = wagon.pressure.left_out_s(NOT_PRESSED).filter(|_| wagon.silent_s == 0.0);
            owed_s.map(|owed_s| (index, owed_s))
        };
        let owing: Vec<(usize, f64)> = self.wagons.iter().enumerate().filter_map(owing).collect();
        // What is cut off behind a cock is one fault, and where it ends is known once all who owe have owed for long.
        if owing.iter().all(|(_, owed_s)| *owed_s >= OWED_RUNNING_S) {
            self.tell_cut(&owing);
        }
    }

    /// Wagons that did not brake although it was ordered, and for how long they owed it, s.
    fn without_brake(&mut self, lasted_s: f64) -> Vec<(usize, f64)> {
        let ordered = self.most_order > 0.0;
        if !ordered && (lasted_s < TELLING.0 || !self.others_press()) {
            return Vec::new();
        }
        let free = |(index, wagon): (usize, &Wagon)| {
            let pressure = &wagon.pressure;
            let unordered = || {
                let none = pressure.full_n > 1000.0 && pressure.peak_n < NOT_PRESSED * pressure.full_n;
                (none && !pressure.electric).then_some(0.0)
            };
            let owed_s = if ordered { pressure.left_out_s(NOT_PRESSED) } else { unordered() };
            Some((index, owed_s.filter(|owed_s| !ordered || *owed_s >= OWED_S)?))
                .filter(|_| wagon.silent_s == 0.0)
        };
        self.wagons.iter().enumerate().filter_map(free).collect()
    }

    fn others_press(&self) -> bool {
        let pressed = |wagon: &Wagon| {
            wagon.pressure.full_n > 1000.0 && wagon.pressure.peak_n > 0.25 * wagon.pressure.full_n
        };
        self.wagons.iter().filter(|wagon| pressed(wagon)).count() * 4 >= self.wagons.len()
    }

    /// One alert for each run of wagons in a row: what is cut off behind a cock is one fault.
    fn tell_cut(&mut self, cut: &[(usize, f64)]) {
        // Where the order is told and stood for long, one application says enough.
        let sure = |wagon: usize| cut.iter().any(|(one, owed_s)| *one == wagon && *owed_s >= 1.5 * OWED_S);
        let cut: Vec<usize> = cut.iter().map(|(wagon, _)| *wagon).collect();
        let mut from = 0;
        while from < cut.len() {
            let mut to = from + 1;
            while to < cut.len() && cut[to] == cut[to - 1] + 1 {
                to += 1;
            }
            let run = cut[from..to].to_vec();
            let reason = match run.len() {
                1 => "no pressing force while braking was ordered".to_owned(),
                count => format!("no pressing force on {count} wagons in a row while braking was ordered"),
            };
            let how = (Grade::Act, 0.97, if run.len() > 1 || sure(run[0]) { 1 } else { 2 });
            self.suspect_wagons(Cause::Isolated, (run, vec![]), how, &[], reason);
            from = to;
        }
    }

    fn judge_beside(&mut self, index: usize) {
        let wheelsets = self.wagons[index].wheel.len();
        let full_n = self.wagons[index].pressure.full_n;
        let besides: Vec<Option<Beside>> =
            (0..wheelsets).map(|k| self.wagons[index].pressure.beside(k)).collect();
        for (k, beside) in besides.iter().enumerate() {
            // What a transducer may be off by in good health is not much of a light application.
            let Some(beside) = beside.filter(|beside| beside.offset_n.abs() > OFFSET_N) else { continue };
            let at = (index, vec![k]);
            let percent = 100.0 * beside.ratio;
            let constant = beside.looks == Looks::Constant;
            let offset = beside.offset_n / full_n.max(1.0);
            let leaks = beside
                .over_time
                .is_some_and(|(fresh, aged)| fresh - aged > LEAKS.0 && fresh - aged > LEAKS.1 * (1.0 - aged));
            if beside.ratio < BESIDE.0 && leaks {
                let (fresh, aged) = beside.over_time.unwrap_or_default();
                let reason = format!(
                    "pressing force sinks from {:.0} to {:.0} % of that of the other wheelsets while the brake is held",
                    100.0 * fresh,
                    100.0 * aged
                );
                let instead = [(Cause::WspValve, 0.2)];
                self.suspect(Cause::SlowCylinder, at, (Grade::Watch, 0.75, 2), &instead, reason);
            } else if beside.ratio < NO_FORCE && !constant {
                let reason = format!("pressing force is {percent:.0} % of that of the other wheelsets");
                let instead = [(Cause::WspValve, 0.08)];
                let needed = if beside.seconds >= OWED_S { 1 } else { 2 };
                self.suspect(Cause::Isolated, at, (Grade::Act, 0.9, needed), &instead, reason);
            } else if beside.ratio < BESIDE.0 && constant && offset < -LEFT {
                let reason =
                    format!("pressing force reads {:.0} % of full force too low throughout", -100.0 * offset);
                let instead = [(Cause::WspValve, 0.2)];
                self.suspect(Cause::PressureSensor, at, (Grade::Watch, 0.75, 2), &instead, reason);
            } else if beside.ratio < BESIDE.0 && !(wheelsets == 2 && self.reads_high(index, 1 - k)) {
                let reason = format!("pressing force is {percent:.0} % of that of the other wheelsets");
                if beside.looks == Looks::Share {
                    let instead = [(Cause::PressureSensor, 0.2), (Cause::SlowCylinder, 0.2)];
                    self.suspect(Cause::WspValve, at, (Grade::Watch, 0.6, 2), &instead, reason);
                } else {
                    self.suspect_either(Cause::WspValve, Cause::PressureSensor, at, reason);
                }
            } else if beside.ratio > BESIDE.1 && wheelsets > 2 && offset > LEFT {
                let reason = format!("pressing force reads {:.0} % of full force too high", 100.0 * offset);
                self.suspect(Cause::PressureSensor, at, (Grade::Watch, 0.8, 2), &[], reason);
            }
        }
    }

    /// Whether a wheelset shows force while released.
    fn reads_high(&self, index: usize, k: usize) -> bool {
        let pressure = &self.wagons[index].pressure;
        let beside = pressure.beside(k).is_some_and(|beside| beside.looks == Looks::Constant);
        beside && pressure.released_n().is_some_and(|left_n| left_n[k] > 0.5 * LEFT * pressure.full_n)
    }

    /// When the forces rose. Where an electric brake takes part, pads and electric brake together begin when the distributor hears.
    fn judge_rises(&mut self) {
        let stand_in: Option<Vec<f64>> = (self.most_order <= 0.0).then(|| self.middle_shape());
        let rise = |wagon: &Wagon| {
            let (electric, full_n) = (wagon.pressure.electric, wagon.pressure.full_n);
            match electric {
                true => wagon.timing.blended_rise(full_n).map(|rise| (End::Blended, rise)),
                false => wagon.timing.rise(stand_in.as_deref(), full_n).map(|rise| (End::Rise, rise)),
            }
        };
        let rises: Vec<Option<(End, Stroke)>> = self.wagons.iter().map(rise).collect();
        self.judge_strokes(&rises);
    }

    /// When the forces fell after the latest release.
    pub(crate) fn judge_falls(&mut self) {
        let fall = |wagon: &mut Wagon| wagon.timing.fallen().map(|fall| (End::Fall, fall));
        let falls: Vec<Option<(End, Stroke)>> = self.wagons.iter_mut().map(fall).collect();
        self.judge_strokes(&falls);
    }

    /// Rises, or falls, of all wagons, each against its own past with what is common removed.
    fn judge_strokes(&mut self, strokes: &[Option<(End, Stroke)>]) {
        let told = strokes.iter().flatten().count();
        // Beside too few others it is not known what is common.
        if told < 4 && self.wagons.len() >= 4 {
            return;
        }
        let middle = |of: fn(&Stroke) -> f64, tells: fn(&End) -> bool| {
            let strokes = strokes.iter().flatten().filter(|(end, _)| tells(end));
            let mut values: Vec<f64> = strokes.map(|(_, stroke)| of(stroke)).collect();
            if values.len() < 4 { 0.0 } else { median(&mut values) }
        };
        let start_s = middle(|stroke| stroke.start_s, |_| true);
        let slow = middle(|stroke| stroke.slow, |end| *end != End::Blended);
        let mut looks: Vec<(usize, End, Stroke, Option<Later>)> = Vec::new();
        for (index, stroke) in strokes.iter().enumerate() {
            let Some((end, stroke)) = stroke else { continue };
            let own = Stroke { start_s: stroke.start_s - start_s, slow: stroke.slow - slow };
            let usual = self.wagons[index].timing.usual(*end).told();
            let later = usual.map(|usual| match end {
                End::Fall => fell(&own, &usual),
                End::Rise => rose(&own, &usual, slow),
                End::Blended => began(&own, &usual),
            });
            looks.push((index, *end, own, later));
        }
        // Several at once: the order came otherwise, or the electric brake did. That is nobody's distributor.
        let accuses = |later: &Later| later.late.max(later.slow) > 1.0;
        let accused = looks.iter().filter(|(.., later)| later.as_ref().is_some_and(accuses)).count();
        let several = accused as f64 > 1.0_f64.max(SEVERAL * told as f64);
        for (index, end, own, later) in looks {
            let timing = &mut self.wagons[index].timing;
            let alone = later.filter(|_| !several);
            if let Some(later) = alone {
                let late = if end == End::Blended { &mut timing.late_together } else { &mut timing.late };
                *late = (*late + later.late).max(0.0);
                timing.slow = (timing.slow + later.slow).max(0.0);
            }
            if !later.as_ref().is_some_and(accuses) || (several && timing.evidence().0.max(timing.slow) < 1.0)
            {
                timing.usual(end).remember(own);
            }
            if let Some(later) = alone {
                self.tell_later(index, &later, end == End::Fall);
            }
        }
    }

    fn tell_later(&mut self, index: usize, later: &Later, falls: bool) {
        let (late, slow) = self.wagons[index].timing.evidence();
        if late.max(slow) < TOLD_LATER || later.late.max(later.slow) <= 0.0 {
            return;
        }
        let (cause, other, reason) = match slow > late {
            true if falls => {
                let times = later.more.exp();
                (
                    Cause::SlowCylinder,
                    Cause::LateDistributor,
                    format!("pressing force takes {times:.1} times as long to fall as it used to"),
                )
            }
            true => {
                let more = later.more;
                (
                    Cause::SlowCylinder,
                    Cause::LateDistributor,
                    format!("pressing force takes {more:.1} s longer to rise than it used to"),
                )
            }
            false => {
                let by_s = later.by_s;
                let reason = match falls {
                    true => format!("pressing force begins to fall {by_s:.1} s later than it used to"),
                    false => format!("pressing force begins to rise {by_s:.1} s later than it used to"),
                };
                (Cause::LateDistributor, Cause::SlowCylinder, reason)
            }
        };
        self.suspect(cause, (index, vec![]), (Grade::Watch, 0.78, 1), &[(other, 0.2)], reason);
    }

    /// The middle of the forces of all wagons over time, where no order is told.
    fn middle_shape(&self) -> Vec<f64> {
        let shapes: Vec<Vec<f64>> = self.wagons.iter().map(|wagon| wagon.timing.shape()).collect();
        let length = shapes.iter().map(Vec::len).min().unwrap_or(0);
        (0..length).map(|index| median(&mut shapes.iter().map(|shape| shape[index]).collect())).collect()
    }
}

/// What one rise or fall says of its beginning and its duration.
#[derive(Debug, Clone, Copy)]
struct Later {
    /// It begins later than usual, s.
    by_s: f64,
    /// It takes longer: a rise by so much area between order and force, s; a fall by so much of its logarithm.
    more: f64,
    /// What either adds to the evidence.
    late: f64,
    slow: f64,
}

/// A rise against what is usual; `common_s` is the area of the whole train.
fn rose(own: &Stroke, (usual, scatter): &(Stroke, Stroke), common_s: f64) -> Later {
    let by_s = own.start_s - usual.start_s;
    // The area grows with the delay, too.
    let more = own.slow - usual.slow - by_s.max(0.0);
    let usual_s = (usual.slow + common_s).max(0.3);
    let slow = odds(more, SLOW_RISE.0.max(SLOW_RISE.1 * usual_s), scatter.slow.max(SLOW_RISE.2 * usual_s));
    let late = odds(by_s - 0.3 * more.max(0.0), LATE.0, scatter.start_s.max(LATE.1));
    // The shape of the order does more to a rise than its scatter so far may say.
    Later { by_s, more, late, slow: slow.min(0.5 * MOST_ODDS) }
}

/// The beginning of pads and electric brake together: how fast they grow is no cylinder's.
fn began(own: &Stroke, (usual, scatter): &(Stroke, Stroke)) -> Later {
    let by_s = own.start_s - usual.start_s;
    Later { by_s, more: 0.0, late: odds(by_s, LATE.0, scatter.start_s.max(LATE.1)), slow: 0.0 }
}

/// A fall against what is usual.
fn fell(own: &Stroke, (usual, scatter): &(Stroke, Stroke)) -> Later {
    let (by_s, more) = (own.start_s - usual.start_s, own.slow - usual.slow);
    let late = odds(by_s, LATE.0, scatter.start_s.max(LATE.1));
    Later { by_s, more, late, slow: odds(more, SLOW_FALL.0, scatter.slow.max(SLOW_FALL.1)) }
}

/// Logarithm of the odds that a normal deviate makes of "larger by `least`" against "as usual"; limited, as tails are longer.
fn odds(value: f64, least: f64, sigma: f64) -> f64 {
    (least * (value - 0.5 * least) / (sigma * sigma)).clamp(-MOST_ODDS, MOST_ODDS)
}
