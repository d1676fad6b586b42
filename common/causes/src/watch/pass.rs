//! The pass over the seconds of a train: whether it brakes, how fast it is, and what each second says of every wheelset.

use super::{TrainWatch, Wagon, Wheel};
use crate::balance::balance;
use crate::braking::Turn;
use crate::cause::Cause;
use crate::creepage::{Creep, Creepage};
use crate::input::{MAX_WHEELSETS, WagonFile};
use crate::robust::{median, trimmed_mean};
use crate::second::{SECOND_S, WagonSecond, WheelSecond};
use crate::within::{self, Creeps};

/// Slower than this creepage tells nothing, m/s.
const LEAST_SPEED_M_S: f64 = 3.5;
/// Creepage of a drive torque up to which a wheel counts as coasting.
const COASTING: f64 = 4e-4;
/// No wheel is so much smaller or larger than its file says: what turns so differently slips.
const SLIPS: f64 = 0.1;
/// Creepage of a drive torque up to which scale and lag of a tachometer show beside it.
const DRIVEN: f64 = 1.2e-3;
/// Creepage of an electric brake up to which wheelsets are compared within their wagon, and the share of it in which they differ for
/// their loads, one sigma; both hand-set.
const ELECTRIC: f64 = 2.5e-3;
const BENDS: f64 = 0.03;
/// Farther from the speed of the train than this a wheel tells neither its size nor a lag: it spins, or is not measured.
const NO_MEASURE: f64 = 0.5;
/// So long after a slide the rail is still taken for the same, s; and so many wheelsets must have slid, as for a low rail.
const SLID_LATELY_S: f64 = 10.0;
const SLID_WHEELSETS: usize = 2;
/// Order from which on pads should do something.
const ORDERED: f64 = 0.15;
/// Torque of an electric brake that works, N m, and share of the largest force from which on pads press.
const ELECTRIC_NM: f64 = 150.0;
const PRESSES: f64 = 0.1;
/// Torque of a wheelset that drives the train, N m.
const DRIVES_NM: f64 = 500.0;

impl TrainWatch {
    pub(super) fn follow_braking(&mut self, seconds: &[WagonSecond]) {
        let orders: Vec<f64> = seconds.iter().map(|second| second.demand).collect();
        let held = |(wagon, second): (&Wagon, &WagonSecond)| {
            let file = &wagon.file;
            let wheels = &second.wheel[..wagon.wheel.len()];
            let force_n: f64 = wheels.iter().map(|wheel| wheel.press_n).sum();
            // Where no order is known, a train whose driven wagons brake electrically has not released the pads of the others.
            let electric_nm: f64 = wheels.iter().map(|wheel| (-wheel.drive_nm).max(0.0)).sum();
            let pads_nm = file.pad_friction * force_n * file.pad_radius_m;
            (pads_nm + electric_nm) / (file.radius_m * file.mass_kg)
        };
        let mut held_m_s2 = self.wagons.iter().zip(seconds).map(held).collect();
        self.most_order =
            orders.iter().copied().filter(|order| order.is_finite()).fold(self.most_order, f64::max);
        match self.braking.take(self.time_s, SECOND_S, &orders, &mut held_m_s2) {
            Turn::Began => {
                self.most_order = 0.0;
                self.falls_due_s = self.falls_due_s.min(self.time_s);
                self.end_all_rolls(true);
            }
            Turn::Ended => self.end_application(),
            Turn::Same => {}
        }
    }

    /// Speed and acceleration of the train: means of what agrees among the wagons.
    pub(super) fn train_speed(&mut self, seconds: &[WagonSecond]) -> (f64, f64) {
        let sound = |wagon: &usize| self.book.open(*wagon).all(|cause| cause != Cause::SpeedSensor);
        let all = seconds.len();
        let usable: Vec<usize> = (0..all).filter(|wagon| all < 3 || sound(wagon)).collect();
        let mut speeds = usable.iter().map(|wagon| seconds[*wagon].v.mean).collect();
        let middle = median(&mut speeds);
        let v_m_s = trimmed_mean(&mut speeds, 0.12 + 0.004 * middle.abs());
        let mut slopes = usable.iter().map(|wagon| seconds[*wagon].v.slope).collect();
        (v_m_s, median(&mut slopes))
    }

    pub(super) fn follow_wheels(&mut self, seconds: &[WagonSecond], v_m_s: f64, a_m_s2: f64, samples: f64) {
        let pass = Pass {
            since_s: self.braking.since_s().map(|since_s| self.time_s - since_s),
            quiet: self.braking.released_s > 4.0,
            // Jerks: a second that begins at another acceleration than it ends is no straight line.
            steady: (v_m_s - self.before_m_s - a_m_s2).abs() < 0.35,
            v_m_s,
            a_m_s2,
            samples,
            wagons: self.wagons.len() as f64,
            slippery: self.slid_lately() >= SLID_WHEELSETS,
        };
        self.before_m_s = v_m_s;
        let excused = self.excused(seconds);
        let stays_off = |(index, second): (usize, &WagonSecond)| {
            excused[index] && !self.wagons[index].drives && second.demand > ORDERED
        };
        if pass.since_s.is_some() && seconds.iter().enumerate().any(stays_off) {
            self.blended_s += SECOND_S;
        }
        for ((wagon, second), excused) in self.wagons.iter_mut().zip(seconds).zip(excused) {
            wagon.pressure.excused = excused;
            wagon.follow(second, &pass);
        }
        if pass.rolls() {
            if pass.since_s.is_none() {
                self.end_all_rolls(false);
            }
            self.judge_slides();
        }
    }
}

impl TrainWatch {
    /// Whose pads owe nothing, wagon by wagon: an electric brake works somewhere, and no pads press of others of the same kind, driven
    /// or not. It may brake for the whole train, with the pads of trailers before those of motor cars, as one that is blended train-wide
    /// does. A wagon that runs alone has nobody who could.
    fn excused(&self, seconds: &[WagonSecond]) -> Vec<bool> {
        let wheels = |index: usize| &seconds[index].wheel[..self.wagons[index].wheel.len()];
        let electric = |index: usize| wheels(index).iter().any(|wheel| wheel.drive_nm < -ELECTRIC_NM);
        let presses = |index: &usize| {
            let least_n = PRESSES * self.wagons[*index].pressure.full_n.max(1000.0);
            wheels(*index).iter().any(|wheel| wheel.press_n > least_n)
        };
        let all = 0..seconds.len();
        if all.len() < 2 || !all.clone().any(electric) {
            return vec![false; all.len()];
        }
        let presses: Vec<usize> = all.clone().filter(presses).collect();
        let drives = |index: usize| self.wagons[index].drives;
        let peer = |own: usize, other: usize| other != own && drives(other) == drives(own);
        all.map(|own| !presses.iter().any(|other| peer(own, *other))).collect()
    }

    /// Wheelsets that slid lately, those left out whose tachometer only seems to.
    fn slid_lately(&self) -> usize {
        let wheels = self.wagons.iter().flat_map(|wagon| &wagon.wheel);
        wheels.filter(|wheel| wheel.trusted && wheel.slid_ago_s < SLID_LATELY_S).count()
    }
}

/// A second of the train, as all wheelsets need it.
#[derive(Debug, Clone, Copy)]
struct Pass {
    /// Since when it brakes, s.
    since_s: Option<f64>,
    /// The brakes have been released for some seconds.
    quiet: bool,
    /// Speed runs along a straight line.
    steady: bool,
    v_m_s: f64,
    a_m_s2: f64,
    samples: f64,
    wagons: f64,
    /// Wheelsets slid lately: on such a rail those that do not slide creep by far more than forces should cause.
    slippery: bool,
}

impl Pass {
    fn rolls(&self) -> bool {
        self.v_m_s > LEAST_SPEED_M_S
    }
}

/// What a wheelset did in a second.
#[derive(Debug, Clone, Copy, Default)]
struct Turned {
    slides: bool,
    driven: bool,
    /// Creepage, where it tells of pads and drag.
    creep: Option<Creep>,
}

impl Wagon {
    /// Takes a second of all that this wagon measures.
    fn follow(&mut self, second: &WagonSecond, pass: &Pass) {
        let wheelsets = self.wheel.len();
        self.drives |= second.wheel[..wheelsets].iter().any(|wheel| wheel.drive_nm > DRIVES_NM);
        let (mut slides, mut driven) = (false, false);
        let mut creeps: Creeps = [None; MAX_WHEELSETS];
        let full_n = self.pressure.full_n.max(1.0);
        for (k, wheel) in self.wheel.iter_mut().enumerate() {
            let turned = wheel.follow(&second.wheel[k], &self.file, pass, full_n);
            slides |= turned.slides;
            driven |= turned.driven;
            creeps[k] = turned.creep;
        }
        let is_trusted: Vec<bool> = self.wheel.iter().map(|wheel| wheel.trusted).collect();
        for (wheel, creep) in self.wheel.iter_mut().zip(within::beside(&creeps, &is_trusted)) {
            if let Some(creep) = creep {
                wheel.beside.take(&creep, pass.since_s.unwrap_or(0.0));
            }
        }
        let slid = slides || self.wheel.iter().any(|wheel| wheel.slid_ago_s < 4.0);
        let grip_m = self.file.pad_friction * self.file.pad_radius_m;
        self.pressure.take(second, wheelsets, pass.since_s, pass.quiet, slid, grip_m);
        if pass.rolls() {
            self.follow_speed(second, pass, driven);
            if let Some(balance_of) = self.balance.as_mut().filter(|_| pass.steady && !slid)
                && let Some(creep) = balance(&self.file, second, pass.v_m_s, pass.a_m_s2, pass.samples)
            {
                balance_of.take(&creep, pass.since_s.unwrap_or(0.0));
            }
        }
    }

    /// Speed and load of a wagon that rolls.
    fn follow_speed(&mut self, second: &WagonSecond, pass: &Pass, driven: bool) {
        // Its wheels tell of its speed only while nothing drives them; both are asked of the same seconds.
        if second.v.mean.is_finite() && !driven {
            self.speed.take(second.v.mean / pass.v_m_s - 1.0, pass.a_m_s2 / pass.v_m_s, 0.0);
        }
        if second.load_kg.is_finite() {
            let (mean, count) = &mut self.load_kg;
            *count += 1.0;
            *mean += (second.load_kg - *mean) / *count;
        }
    }
}

impl Wheel {
    /// Takes a second of this wheelset; `full_n` is the largest force that its wagon ever pressed with.
    fn follow(&mut self, seen: &WheelSecond, file: &WagonFile, pass: &Pass, full_n: f64) -> Turned {
        let Pass { v_m_s, since_s, .. } = *pass;
        let mut turned = Turned::default();
        let drive = seen.drive_nm / file.radius_m * file.compliance_per_n;
        // What pads and slides do to a wheel is no fault of its tread.
        let coasts = drive.abs() < COASTING && since_s.is_none() && self.slid_ago_s > 20.0;
        self.tachometer.take(seen, file.radius_m, v_m_s, file.wheel_speed_sigma_rad_s, coasts);
        self.slid_ago_s += SECOND_S;
        let creepage = seen.omega.mean * file.radius_m / v_m_s - 1.0;
        let released = since_s.is_none() && pass.quiet;
        self.tachometer.follow_standing(seen.omega.mean * file.radius_m, v_m_s, released);
        if !pass.rolls() || !creepage.is_finite() || self.tachometer.stands_s > 0.0 {
            return turned;
        }
        turned.slides = (creepage - self.idle) * v_m_s < -(0.4 + 0.03 * v_m_s);
        if turned.slides && since_s.is_some() {
            self.slid_ago_s = 0.0;
            let stuck = seen.press_n > 0.75 * full_n && (creepage - self.idle) < -0.25;
            self.stuck_s = if stuck { self.stuck_s + SECOND_S } else { self.stuck_s };
            return turned;
        }
        if since_s.is_none() && pass.quiet && drive.abs() < COASTING && creepage.abs() < SLIPS {
            self.idle += 0.1 * (creepage - self.idle);
        }
        if !pass.steady || !seen.press_n.is_finite() {
            return turned;
        }
        let creep = creep(seen, file, pass, creepage);
        turned.driven = creep.drive.abs() >= DRIVEN;
        let measured = creepage.abs() < NO_MEASURE;
        if !turned.driven && self.slid_ago_s > SLID_LATELY_S && !pass.slippery && measured {
            let forced = creep.drive - creep.brake;
            self.rim.take(creepage - forced, creep.rate, forced);
        }
        // Beyond the straight part of the curve the equation does not hold; a driven wheel is there first.
        let straight = creep.drive.abs() < COASTING && creep.brake < 0.003;
        if creepage.abs() < 0.012 + self.idle.abs() && straight {
            self.creepage.take(&creep, since_s.unwrap_or(0.0));
            turned.creep = Some(creep);
        } else if creepage.abs() < 0.012 + self.idle.abs() && creep.brake < 0.003 {
            turned.creep = braked_electrically(creep, since_s.is_some());
        }
        turned
    }
}

/// What a second under the electric brake says beside the other wheelsets of the wagon: all of them brake so alike, so that what the
/// curve bends for is common to them but for their loads.
fn braked_electrically(creep: Creep, brakes: bool) -> Option<Creep> {
    let bends = BENDS * creep.drive;
    let electric = brakes && creep.drive <= 0.0 && creep.drive > -ELECTRIC;
    electric.then_some(Creep { variance: creep.variance + bends * bends, ..creep })
}

/// Creepage of a wheelset in a second, beside what should cause it.
fn creep(seen: &WheelSecond, file: &WagonFile, pass: &Pass, creepage: f64) -> Creep {
    let Pass { v_m_s, a_m_s2, samples, wagons, .. } = *pass;
    let force = |newton: f64| newton * file.compliance_per_n;
    let turning_nm = file.inertia_kg_m2 * a_m_s2 / file.radius_m;
    Creep {
        creepage,
        brake: force(file.pad_friction * seen.press_n * file.pad_radius_m / file.radius_m),
        drive: force((seen.drive_nm - turning_nm) / file.radius_m),
        rate: a_m_s2 / v_m_s,
        variance: Creepage::of_mean(file.wheel_speed_sigma_rad_s / seen.omega.mean, samples)
            + Creepage::of_mean(file.speed_sigma_m_s / v_m_s, samples * wagons),
    }
}
