//! Pressing forces: who has none, who has too little, who has some left, who is late.

use super::limits::{BESIDE, LATE_RISE, LEAKS_PER_S, LEFT, NO_FORCE, NOT_PRESSED, SLOW_RISE, TELLING};
use crate::cause::{Cause, Grade};
use crate::pressure::{Beside, Rise};
use crate::robust::median;
use crate::watch::{TrainWatch, Wagon};

impl TrainWatch {
    /// What is left in cylinders that should be empty.
    pub(crate) fn judge_released(&mut self) {
        for index in 0..self.wagons.len() {
            let wagon = &self.wagons[index];
            let full_n = wagon.pressure.full_n;
            let Some(left_n) = wagon.pressure.released_n().filter(|_| full_n > 1000.0) else { continue };
            let wheelsets = wagon.wheel.len();
            let least_n = left_n[..wheelsets].iter().copied().fold(f64::INFINITY, f64::min);
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
            if !cut.contains(&index) {
                self.judge_beside(index);
            }
        }
        self.judge_rises();
        self.judge_pads();
    }

    /// Wagons that did not brake although it was ordered.
    fn without_brake(&mut self, lasted_s: f64) -> Vec<usize> {
        let ordered = if self.most_order > 0.0 { self.most_order >= TELLING.1 } else { self.others_press() };
        if lasted_s < TELLING.0 || !ordered {
            return Vec::new();
        }
        let order = if self.most_order > 0.0 { self.most_order } else { 1.0 };
        let free = |(index, wagon): (usize, &mut Wagon)| {
            let out = wagon.pressure.left_out(order, NOT_PRESSED);
            (out && wagon.silent_s == 0.0).then_some(index)
        };
        self.wagons.iter_mut().enumerate().filter_map(free).collect()
    }

    fn others_press(&self) -> bool {
        let pressed = |wagon: &Wagon| {
            wagon.pressure.full_n > 1000.0 && wagon.pressure.peak_n > 0.25 * wagon.pressure.full_n
        };
        self.wagons.iter().filter(|wagon| pressed(wagon)).count() * 4 >= self.wagons.len()
    }

    /// One alert for each run of wagons in a row: what is cut off behind a cock is one fault.
    fn tell_cut(&mut self, cut: &[usize]) {
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
            let how = (Grade::Act, 0.97, if run.len() > 1 { 1 } else { 2 });
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
            let Some(beside) = beside else { continue };
            let at = (index, vec![k]);
            let percent = 100.0 * beside.ratio;
            let constant = beside.left_n.1 < 0.6 * beside.left_n.0;
            let offset = beside.offset_n / full_n.max(1.0);
            if beside.ratio < NO_FORCE {
                let reason = format!("pressing force is {percent:.0} % of that of the other wheelsets");
                let instead = [(Cause::WspValve, 0.08)];
                self.suspect(Cause::Isolated, at, (Grade::Act, 0.9, 2), &instead, reason);
            } else if beside.ratio < BESIDE.0 && beside.trend_per_s < -LEAKS_PER_S {
                let reason =
                    format!("pressing force falls by {:.1} %/s in braking", -100.0 * beside.trend_per_s);
                let instead = [(Cause::WspValve, 0.2)];
                self.suspect(Cause::SlowCylinder, at, (Grade::Watch, 0.75, 2), &instead, reason);
            } else if beside.ratio < BESIDE.0 && constant && offset < -LEFT {
                let reason =
                    format!("pressing force reads {:.0} % of full force too low throughout", -100.0 * offset);
                let instead = [(Cause::WspValve, 0.2)];
                self.suspect(Cause::PressureSensor, at, (Grade::Watch, 0.75, 2), &instead, reason);
            } else if beside.ratio < BESIDE.0 && !(wheelsets == 2 && self.reads_high(index, 1 - k)) {
                let reason = format!("pressing force is {percent:.0} % of that of the other wheelsets");
                let instead = [(Cause::PressureSensor, 0.2), (Cause::SlowCylinder, 0.2)];
                self.suspect(Cause::WspValve, at, (Grade::Watch, 0.6, 2), &instead, reason);
            } else if beside.ratio > BESIDE.1 && wheelsets > 2 && offset > LEFT {
                let reason = format!("pressing force reads {:.0} % of full force too high", 100.0 * offset);
                self.suspect(Cause::PressureSensor, at, (Grade::Watch, 0.8, 2), &[], reason);
            }
        }
    }

    /// Whether a wheelset shows force while released.
    fn reads_high(&self, index: usize, k: usize) -> bool {
        let pressure = &self.wagons[index].pressure;
        let beside = pressure.beside(k).is_some_and(|beside| beside.left_n.1 < 0.6 * beside.left_n.0);
        beside && pressure.released_n().is_some_and(|left_n| left_n[k] > 0.5 * LEFT * pressure.full_n)
    }

    /// When the forces rose.
    fn judge_rises(&mut self) {
        let stand_in: Option<Vec<f64>> = (self.most_order <= 0.0).then(|| self.middle_shape());
        let rises: Vec<Option<(f64, f64)>> =
            self.wagons.iter().map(|wagon| wagon.pressure.rise(stand_in.as_deref())).collect();
        let told = rises.iter().flatten().count();
        let middle = |of: fn(&(f64, f64)) -> f64| {
            if told < 4 { 0.0 } else { median(&mut rises.iter().flatten().map(of).collect()) }
        };
        let (start_s, area_s) = (middle(|rise| rise.0), middle(|rise| rise.1));
        let mut accused = Vec::new();
        for (index, rise) in rises.iter().enumerate() {
            let Some(own) = rise.map(|(own_s, own_area_s)| (own_s - start_s, own_area_s - area_s)) else {
                continue;
            };
            let judged = self.wagons[index].pressure.against_past(own.0, own.1);
            match judged.and_then(|rise| slower(&rise, area_s)) {
                Some(found) => accused.push((index, own, found)),
                None => self.wagons[index].pressure.remember(own.0, own.1),
            }
        }
        // Several at once: the order came otherwise, or the electric brake did. That is nobody's distributor.
        if accused.len() > 1 {
            for (index, own, _) in accused {
                self.wagons[index].pressure.remember(own.0, own.1);
            }
            return;
        }
        for (index, _, (cause, other, reason)) in accused {
            self.suspect(cause, (index, vec![]), (Grade::Watch, 0.78, 3), &[(other, 0.2)], reason);
        }
    }

    /// The middle of the forces of all wagons over time, where no order is told.
    fn middle_shape(&self) -> Vec<f64> {
        let shapes: Vec<Vec<f64>> = self.wagons.iter().map(|wagon| wagon.pressure.shape()).collect();
        let length = shapes.iter().map(Vec::len).min().unwrap_or(0);
        (0..length).map(|index| median(&mut shapes.iter().map(|shape| shape[index]).collect())).collect()
    }
}

/// Whether a rise is later or slower than it used to be: cause, runner-up and why. `common_s` is the area of the whole train.
fn slower(rise: &Rise, common_s: f64) -> Option<(Cause, Cause, String)> {
    let (later, scatter) = rise.start_s;
    let (more, more_scatter) = rise.area_s;
    let late = later > LATE_RISE.0.max(LATE_RISE.1 * scatter);
    let usual_s = (rise.usual_s + common_s).max(0.3);
    let slow = more > SLOW_RISE.0.max(SLOW_RISE.1 * more_scatter).max(SLOW_RISE.2 * usual_s);
    if late && later > 0.6 * more {
        let reason = format!("pressing force begins to rise {later:.1} s later than it used to");
        return Some((Cause::LateDistributor, Cause::SlowCylinder, reason));
    }
    slow.then(|| {
        let reason = format!("pressing force takes {more:.1} s longer to rise than it used to");
        (Cause::SlowCylinder, Cause::LateDistributor, reason)
    })
}
