//! Sensors, judged first.

use super::limits::{
    A_LAG_EXPLAINS, LATE_CLOCK_S, LATE_SPEED_ALONE_S, LATE_SPEED_S, LATE_WHEEL_S, MISSING, NEVER_COASTED,
    ONCE_A_TURN, RADII_BEYOND, RADIUS, RINGS, SILENT_WAGON_S, SILENT_WHEEL_S, SPEED_SCALE, TWO_SPEEDS,
};
use crate::cause::{Cause, Grade};
use crate::robust::{median, spread};
use crate::watch::{MANY_WHEELSETS, TrainWatch, Wagon, Wheel};

impl TrainWatch {
    pub(crate) fn judge_sensors(&mut self) {
        let rolling = self.v_m_s > 4.0;
        let middle = |of: fn(&Wheel) -> f64| {
            let wheels = self.wagons.iter().flat_map(|wagon| &wagon.wheel);
            let told = wheels.filter(|wheel| wheel.tachometer.seconds > 20.0);
            let mut values: Vec<f64> = told.map(of).collect();
            if values.len() < 3 { 0.0 } else { median(&mut values) }
        };
        let once = middle(|wheel| wheel.tachometer.once_a_turn);
        let largest = middle(|wheel| wheel.tachometer.largest).max(2.0);
        for index in 0..self.wagons.len() {
            if self.wagons[index].silent_s >= SILENT_WAGON_S {
                let reason = "nothing comes from this wagon".to_owned();
                self.suspect(Cause::Silent, (index, vec![]), (Grade::Act, 0.99, 1), &[], reason);
                continue;
            }
            if self.wagons[index].silent_s > 0.0 {
                continue;
            }
            self.judge_tachometers(index, once, largest, rolling);
            self.judge_load(index);
        }
        if rolling {
            self.judge_speeds();
        }
    }

    fn judge_tachometers(&mut self, index: usize, once: f64, largest: f64, rolling: bool) {
        for k in 0..self.wagons[index].wheel.len() {
            let seen = self.wagons[index].wheel[k].tachometer;
            if seen.silent_s() > SILENT_WHEEL_S {
                let reason = format!("no wheel speed for {:.0} s", seen.silent_s());
                let how = (Grade::Watch, 0.98, 1);
                self.suspect(Cause::TachometerDropout, (index, vec![k]), how, &[], reason);
                continue;
            }
            if seen.stands_s > SILENT_WHEEL_S {
                let reason = format!(
                    "shows that the wheelset stands while the train runs, for {:.0} s: look whether it turns",
                    seen.stands_s
                );
                let instead = [(Cause::Dragging, 0.05)];
                self.suspect(
                    Cause::TachometerDropout,
                    (index, vec![k]),
                    (Grade::Act, 0.9, 1),
                    &instead,
                    reason,
                );
                continue;
            }
            if seen.missing > MISSING {
                let reason = format!("{:.1} % of the wheel speeds are missing", 100.0 * seen.missing);
                let how = (Grade::Watch, 0.97, 3);
                self.suspect(Cause::TachometerDropout, (index, vec![k]), how, &[], reason);
            }
            if !rolling || seen.seconds < 25.0 {
                continue;
            }
            let wobbles = seen.once_a_turn - once > ONCE_A_TURN;
            let rings = seen.largest - largest > RINGS;
            if wobbles && seen.once > 0.8 * seen.scatter {
                let reason = format!("wheel speed wobbles by {:.2} % once a turn", 100.0 * seen.once_a_turn);
                let how = (Grade::Watch, 0.93, 3);
                let instead = [(Cause::WheelFlat, 0.05)];
                self.suspect(Cause::TachometerEccentric, (index, vec![k]), how, &instead, reason);
            } else if rings {
                let reason =
                    format!("wheel speed rings: {:.1} times its noise, others {largest:.1}", seen.largest);
                let how = (Grade::Watch, 0.9, 3);
                let instead = [(Cause::TachometerEccentric, 0.08)];
                self.suspect(Cause::WheelFlat, (index, vec![k]), how, &instead, reason);
            }
        }
    }

    /// Scale and lag of speeds and of wheels against them.
    fn judge_speeds(&mut self) {
        let many = self.wagons.len() >= 3;
        self.judge_clocks();
        if many {
            self.judge_speed_sensors();
        } else if self.wagons.len() == 2 && self.judge_two_speeds() {
            return;
        }
        let errors: Vec<Vec<(f64, Option<f64>)>> =
            self.wagons.iter().map(|wagon| wagon.wheel.iter().map(told).collect()).collect();
        let mut scales: Vec<f64> = errors.iter().flatten().map(|(scale, _)| *scale).collect();
        let mut lags: Vec<f64> = errors.iter().flatten().filter_map(|(_, lag_s)| *lag_s).collect();
        let few = scales.iter().filter(|scale| scale.is_finite()).count() < MANY_WHEELSETS;
        let (scale, lag_s) = (median(&mut scales), median(&mut lags));
        if few && !many {
            // Wheels that all differ alike from the only speed there is: it is the speed.
            let alike = errors.iter().flatten().all(|(one, _)| (one - scale).abs() < 0.5 * scale.abs());
            let alike_late = lags.len() >= 2 && lags.iter().all(|one| (one - lag_s).abs() < 0.04);
            // Wheels that drive seem early where the rail gives way by more than they should need, if it is known by how much.
            let free =
                self.wagons.iter().flat_map(|wagon| &wagon.wheel).filter_map(|wheel| told_by(wheel, true).1);
            let gives_way = median(&mut free.collect()) >= -0.5 * LATE_SPEED_ALONE_S;
            // And wheels that slip are behind by now more, now less.
            let wheels = self.wagons.iter().flat_map(|wagon| &wagon.wheel);
            let explained = median(&mut wheels.map(|wheel| wheel.rim.explained()).collect());
            let slips = explained < A_LAG_EXPLAINS;
            let late = alike_late && -lag_s > LATE_SPEED_ALONE_S && !gives_way && !slips;
            if (alike && scale.abs() > SPEED_SCALE) || late {
                let reason = match late {
                    true => format!("speed comes {:.2} s later than all wheels", -lag_s),
                    false => format!("speed is {:+.1} % off all wheels", -100.0 * scale),
                };
                let instead = [(Cause::WheelDiameter, 0.1)];
                self.suspect(Cause::SpeedSensor, (0, vec![]), (Grade::Watch, 0.85, 3), &instead, reason);
                return;
            }
        }
        self.judge_wheels(few);
    }

    /// Two speeds that differ: the one with which the wheels of both wagons disagree is wrong. Whether one was found.
    fn judge_two_speeds(&mut self) -> bool {
        let speeds = [self.wagons[0].speed, self.wagons[1].speed];
        if speeds.iter().any(|speed| speed.seconds < 60.0) {
            return false;
        }
        let wheels = || self.wagons.iter().flat_map(|wagon| &wagon.wheel).map(told);
        let scale = median(&mut wheels().map(|(scale, _)| scale).collect());
        let lag_s = median(&mut wheels().filter_map(|(_, lag_s)| lag_s).collect());
        let off = speeds.map(|speed| least(speed.errors(false).0, speed.plain()) - scale);
        let late_s = speeds.map(|speed| speed.errors(false).1.unwrap_or(f64::NAN) - lag_s);
        for (index, other) in [(0, 1), (1, 0)] {
            let wrong = off[index].abs() > TWO_SPEEDS * SPEED_SCALE.max(off[other].abs());
            let late = late_s[index] > TWO_SPEEDS * LATE_SPEED_S.max(late_s[other].abs());
            if wrong || late {
                let reason = match late {
                    true => format!("speed comes {:.2} s later than all wheels", late_s[index]),
                    false => format!("speed is {:+.1} % off all wheels", 100.0 * off[index]),
                };
                self.suspect(Cause::SpeedSensor, (index, vec![]), (Grade::Watch, 0.9, 3), &[], reason);
                return true;
            }
        }
        false
    }

    /// Speeds of wagons against that of the train.
    fn judge_speed_sensors(&mut self) {
        let wrong = |index: usize| -> Option<String> {
            let speed = self.wagons[index].speed;
            let late = speed.errors(false).1.filter(|lag_s| *lag_s > LATE_SPEED_S);
            // Along a long train speeds change one after another: it must be late beside its own wheels, too.
            let wheels_s = self.wheels_lag_s(index);
            let late = late.filter(|lag_s| wheels_s.is_some_and(|wheels_s| lag_s - wheels_s > LATE_SPEED_S));
            // And beside its neighbours.
            let beside_s = self.neighbours_lag_s(index);
            let late = late.filter(|lag_s| lag_s - beside_s > LATE_SPEED_S);
            let scale = self.scale_beside(index);
            let off = scale.abs() > SPEED_SCALE || late.is_some();
            (off && speed.seconds > 60.0).then(|| match late {
                Some(lag_s) => format!("speed comes {lag_s:.2} s later than the train's"),
                None => format!("speed is {:+.1} % off that of the train", 100.0 * scale),
            })
        };
        let reasons: Vec<Option<String>> = (0..self.wagons.len()).map(wrong).collect();
        for (index, reason) in reasons.iter().enumerate() {
            // Neighbours that differ from the train together are at another place of its slack.
            let beside = [index.wrapping_sub(1), index + 1];
            let together = beside.iter().any(|other| reasons.get(*other).is_some_and(Option::is_some));
            if let Some(reason) = reason.clone().filter(|_| !together) {
                self.suspect(Cause::SpeedSensor, (index, vec![]), (Grade::Watch, 0.96, 3), &[], reason);
            }
        }
    }

    /// Wheels against the train: what is an error of one is so whether or not creepage may differ from what forces should cause.
    fn judge_wheels(&mut self, few: bool) {
        let plain = self.wheel_errors(false, few);
        let free = self.wheel_errors(true, few);
        let radii: Vec<Vec<f64>> =
            self.wagons.iter().map(|wagon| wagon.wheel.iter().map(at_rest).collect()).collect();
        let radius = if few { 0.0 } else { median(&mut radii.iter().flatten().copied().collect()) };
        let differ = spread(radii.iter().flatten().copied(), MANY_WHEELSETS);
        let largest = RADIUS.max(RADII_BEYOND * differ);
        let plainly = |wheel: &Wheel| if told(wheel).0.is_finite() { wheel.rim.plain() } else { f64::NAN };
        let means = self.wagons.iter().flat_map(|wagon| &wagon.wheel).map(plainly);
        let mean = if few { 0.0 } else { median(&mut means.collect()) };
        for index in 0..self.wagons.len() {
            for k in 0..self.wagons[index].wheel.len() {
                let ((off, late_s), (free_off, free_late_s)) = (plain[index][k], free[index][k]);
                let late_s = late_s.min(free_late_s);
                // And while it coasts.
                let coasts = radii[index][k] - radius;
                // And by the plain mean of what was seen, however that changed with speed.
                let seen = plainly(&self.wagons[index].wheel[k]) - mean;
                let stays = |other: f64| off * other > 0.0 && other.abs() > 0.7 * largest;
                let least = match self.wagons[index].wheel[k].at_rest {
                    Some(_) => largest,
                    None => largest + NEVER_COASTED,
                };
                let beyond = off.abs().min(free_off.abs()) > least && stays(coasts) && stays(seen);
                if late_s > LATE_WHEEL_S {
                    let reason = format!("wheel speed comes {late_s:.2} s late");
                    let how = (Grade::Watch, 0.94, 3);
                    self.suspect(Cause::TachometerLate, (index, vec![k]), how, &[], reason);
                } else if beyond && off * free_off > 0.0 {
                    let percent = 100.0 * off.abs();
                    let reason = match off < 0.0 {
                        true => format!("the wheel is {percent:.2} % larger than its file says"),
                        false => format!("the wheel is {percent:.2} % smaller than its file says"),
                    };
                    let how = (Grade::Watch, 0.95, 3);
                    self.suspect(Cause::WheelDiameter, (index, vec![k]), how, &[], reason);
                }
            }
        }
    }

    /// Scale and lag (s) of every wheel beyond what is common; of a wheel that tells no lag it is none.
    fn wheel_errors(&self, creeps: bool, few: bool) -> Vec<Vec<(f64, f64)>> {
        let errors: Vec<Vec<(f64, Option<f64>)>> = self
            .wagons
            .iter()
            .map(|wagon| wagon.wheel.iter().map(|wheel| told_by(wheel, creeps)).collect())
            .collect();
        let common = |values: Vec<f64>| if few { 0.0 } else { median(&mut values.clone()) };
        let scale = common(errors.iter().flatten().map(|(scale, _)| *scale).collect());
        let lag_s = common(errors.iter().flatten().filter_map(|(_, lag_s)| *lag_s).collect());
        let beyond = |wheels: &Vec<(f64, Option<f64>)>| {
            let one = |(k, (own, own_s)): (usize, &(f64, Option<f64>))| {
                // Along a long train speeds change one after another: what is late must be so beside its own wagon, too.
                let others = wheels.iter().enumerate().filter(|(other, _)| *other != k);
                let mut others_s: Vec<f64> = others.filter_map(|(_, (_, lag_s))| *lag_s).collect();
                let beside_s = if others_s.is_empty() { lag_s } else { median(&mut others_s) };
                // And where a wagon as a whole is faster than the train, that is no error of its wheels.
                let others = wheels.iter().enumerate().filter(|(other, _)| *other != k);
                let beside = median(&mut others.map(|(_, (scale, _))| *scale).collect());
                let off = own - scale;
                let off = if off * (own - beside) > 0.0 { least(off, own - beside) } else { 0.0 };
                let off = if beside.is_finite() && !few { off } else { own - scale };
                (off, own_s.map_or(0.0, |own_s| (own_s - lag_s).min(own_s - beside_s)))
            };
            wheels.iter().enumerate().map(one).collect()
        };
        errors.iter().map(beyond).collect()
    }
}

impl TrainWatch {
    /// Wagons of which everything comes late: their clock does, or the way of their data is long.
    fn judge_clocks(&mut self) {
        let speeds: Vec<Option<f64>> = self.wagons.iter().map(|wagon| wagon.speed.errors(false).1).collect();
        let differ_s = spread(speeds.iter().copied().flatten(), 3);
        if speeds.iter().flatten().count() < 3 || differ_s > LATE_CLOCK_S.1 {
            return;
        }
        for (index, speed_s) in speeds.iter().enumerate() {
            // An end of the train is held on one side only: slack moves it by itself.
            let is_end = index == 0 || index + 1 == speeds.len();
            let least_s = if is_end { 2.0 * LATE_CLOCK_S.0 } else { LATE_CLOCK_S.0 };
            let Some(lag_s) = speed_s.filter(|lag_s| *lag_s > least_s) else { continue };
            let alike =
                |wheel: &Wheel| told(wheel).1.is_some_and(|own_s| (own_s - lag_s).abs() < 0.4 * lag_s);
            let beside_s = self.neighbours_lag_s(index);
            if self.wagons[index].wheel.iter().all(alike) && lag_s - beside_s > least_s {
                let reason = format!("everything of this wagon comes {lag_s:.2} s later than the train's");
                let instead = [(Cause::SpeedSensor, 0.1)];
                self.suspect(Cause::Clock, (index, vec![]), (Grade::Watch, 0.85, 3), &instead, reason);
            }
        }
    }

    /// Scale error of a speed against the train's, less what a neighbour has of it: what is at one place of a train's slack is alike.
    fn scale_beside(&self, index: usize) -> f64 {
        // What is wrong with its scale is so whether or not a lag is allowed for: where a wagon mostly brakes while nothing drives
        // it, as a locomotive, the line through its lag is drawn far beyond what was seen.
        let scale = |wagon: &Wagon| {
            let (scale, plain) = (wagon.speed.errors(false).0, wagon.speed.plain());
            if scale * plain > 0.0 { least(scale, plain) } else { 0.0 }
        };
        let own = scale(&self.wagons[index]);
        let beside = [index.wrapping_sub(1), index + 1];
        let seen =
            beside.iter().filter_map(|other| self.wagons.get(*other).filter(|it| it.speed.seconds > 60.0));
        let alike = seen.map(|other| scale(other) * own.signum());
        own.signum() * (own.abs() - alike.fold(0.0, f64::max)).max(0.0)
    }

    /// The larger lag of the speeds of the wagons next to one, s, if they have any: along a long train speeds change one after another,
    /// from neighbour to neighbour.
    fn neighbours_lag_s(&self, index: usize) -> f64 {
        let beside = [index.wrapping_sub(1), index + 1];
        let lags = beside.iter().filter_map(|other| self.wagons.get(*other)?.speed.errors(false).1);
        lags.fold(0.0, f64::max)
    }

    /// Lag of the wheels of a wagon behind the train, s.
    fn wheels_lag_s(&self, index: usize) -> Option<f64> {
        let mut lags: Vec<f64> = self.wagons[index].wheel.iter().filter_map(|wheel| told(wheel).1).collect();
        (!lags.is_empty()).then(|| median(&mut lags))
    }
}

/// Creepage at rest: by the latest roll, since what has changed by much is not learnt.
fn at_rest(wheel: &Wheel) -> f64 {
    wheel.at_rest.unwrap_or_else(|| wheel.creepage.radius())
}

/// The one that is nearer to nothing.
fn least(a: f64, b: f64) -> f64 {
    if a.abs() < b.abs() { a } else { b }
}

/// Scale and lag of a wheel against the train; NaN while too little has been seen.
fn told(wheel: &Wheel) -> (f64, Option<f64>) {
    told_by(wheel, false)
}

/// The same, with a term for creepage or without.
fn told_by(wheel: &Wheel, creeps: bool) -> (f64, Option<f64>) {
    if wheel.rim.seconds < 60.0 || wheel.tachometer.silent_s() > 0.0 {
        return (f64::NAN, None);
    }
    wheel.rim.errors(creeps)
}
