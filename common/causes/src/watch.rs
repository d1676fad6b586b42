//! The watch over a train: samples in, alerts out.

use crate::balance::balance;
use crate::book::{Alert, Book};
use crate::braking::{Braking, Turn};
use crate::cause::Cause;
use crate::creepage::{Belief, Braked, Change, Creep, Creepage};
use crate::grip::{self, Grip};
use crate::input::{MAX_WHEELSETS, Reading, WagonFile};
use crate::pressure::Pressure;
use crate::robust::{median, trimmed_mean};
use crate::second::{Buffer, SECOND_S, WagonSecond};
use crate::sensors::{SpeedSensor, Tachometer};
use crate::timing::{TRACE_S, Timing};
use crate::within::{self, Creeps};

/// Slower than this creepage tells nothing, m/s.
const LEAST_SPEED_M_S: f64 = 3.5;
/// Creepage of a drive torque up to which a wheel counts as coasting.
const COASTING: f64 = 4e-4;
/// Variance of a change of pad friction, over nominal, from which on it says nothing.
const LEAST_TELLING: f64 = 0.05;
/// Creepage of a drive torque up to which scale and lag of a tachometer show beside it.
const DRIVEN: f64 = 1.2e-3;
/// Common change of creepage in braking from which on it is another rail.
const OTHER_RAIL: f64 = 0.08;
/// Changes of so many applications, or rolls, are kept.
const KEPT: usize = 10;
/// From so many wheelsets on their median is what the rail and the speed do to all alike.
pub(crate) const MANY_WHEELSETS: usize = 8;
/// Of a wheelset that has not slid yet, s.
const SLID_LONG_AGO_S: f64 = 1e6;
/// So long after an application cylinders are empty, and their falls are judged, s.
const FALLS_S: f64 = 60.0;
/// Sensors are judged this often, s.
const LOOK_S: f64 = 10.0;

/// One wheelset under watch.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Wheel {
    pub creepage: Creepage,
    /// The same beside the other wheelsets of its wagon.
    pub beside: Creepage,
    /// Whether its tachometer could be trusted when sensors were judged last.
    pub trusted: bool,
    pub tachometer: Tachometer,
    pub rim: SpeedSensor,
    /// Changes of pad friction, the train's common change removed; latest last.
    pub braked: Vec<Braked>,
    /// Pad friction beside the other wheelsets of its wagon.
    pub grip: Grip,
    /// Changes of the creepage at rest beside the other wheelsets of its wagon.
    pub rolled: Vec<Change>,
    /// Creepage outside of braking in the latest seconds: what is no slide although it looks so.
    idle: f64,
    /// Seconds for which it has slid with full pressure.
    pub stuck_s: f64,
    /// Seconds since it last slid.
    pub slid_ago_s: f64,
    pub applications: u32,
}

/// One wagon under watch.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Wagon {
    pub file: WagonFile,
    pub wheel: Vec<Wheel>,
    pub pressure: Pressure,
    pub timing: Timing,
    pub speed: SpeedSensor,
    /// Pad friction, mean of its wheelsets, beside the train; of a wagon that runs alone by its balance.
    pub grip: Grip,
    /// Balance of forces, of a wagon that runs alone.
    pub balance: Option<Creepage>,
    pub balance_braked: Vec<Braked>,
    pub balance_rolled: Vec<Change>,
    pub load_kg: (f64, f64),
    pub silent_s: f64,
    #[serde(skip)]
    buffer: Buffer,
}

/// The watch over a train.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub struct TrainWatch {
    pub(crate) wagons: Vec<Wagon>,
    pub(crate) book: Book,
    pub(crate) braking: Braking,
    pub(crate) brakings: u32,
    pub(crate) time_s: f64,
    pub(crate) v_m_s: f64,
    pub(crate) most_order: f64,
    samples: usize,
    begun_s: Option<f64>,
    last_s: f64,
    traced_s: f64,
    looked_s: f64,
    /// When the falls after the latest application are judged, s.
    falls_due_s: f64,
    before_m_s: f64,
    doubted: u64,
}

impl TrainWatch {
    /// Nothing has been seen yet of these wagons, front first.
    #[must_use]
    pub fn new(files: Vec<WagonFile>) -> Self {
        let alone = files.len() == 1;
        let wagon = |file: WagonFile| Wagon {
            wheel: vec![Wheel::new(); file.wheelsets.min(MAX_WHEELSETS)],
            pressure: Pressure::default(),
            timing: Timing::default(),
            speed: SpeedSensor::default(),
            grip: Grip::default(),
            balance: alone.then(|| Creepage::new(Belief::balance(file.mass_sigma.max(0.3)))),
            balance_braked: Vec::new(),
            balance_rolled: Vec::new(),
            load_kg: (0.0, 0.0),
            silent_s: 0.0,
            buffer: Buffer::default(),
            file,
        };
        Self {
            wagons: files.into_iter().map(wagon).collect(),
            book: Book::default(),
            braking: Braking::default(),
            brakings: 0,
            time_s: 0.0,
            v_m_s: f64::NAN,
            most_order: 0.0,
            samples: 0,
            begun_s: None,
            last_s: f64::NAN,
            traced_s: f64::NEG_INFINITY,
            looked_s: 0.0,
            falls_due_s: f64::INFINITY,
            before_m_s: f64::NAN,
            doubted: 0,
        }
    }

    /// Goes on from what a predecessor knew, if that was of these wagons, in this order; what ran when it was written, a second,
    /// a roll or an application, is dropped. `None` if it is of other wagons, or makes no sense. Its time goes on from
    /// [`Self::time_s`].
    #[must_use]
    pub fn go_on(mut self, files: &[WagonFile]) -> Option<Self> {
        let wheels = |wagon: &Wagon| wagon.wheel.len() == wagon.file.wheelsets.min(MAX_WHEELSETS);
        let learnt = |wagon: &Wagon| {
            wagon
                .wheel
                .iter()
                .flat_map(|wheel| [&wheel.creepage, &wheel.beside])
                .chain(&wagon.balance)
                .all(Creepage::is_sound)
                && wagon.grip.is_sound()
                && wagon.wheel.iter().all(|wheel| wheel.grip.is_sound())
        };
        let same = self.wagons.iter().map(|wagon| &wagon.file).eq(files);
        let sound = self.wagons.iter().all(|wagon| wheels(wagon) && learnt(wagon));
        if !same || !sound || !self.time_s.is_finite() || !self.book.is_sound(files.len()) {
            return None;
        }
        for wagon in &mut self.wagons {
            wagon.pressure.abandon();
            wagon.timing.abandon();
            wagon.balance.iter_mut().for_each(Creepage::abandon);
            wagon.silent_s = 0.0;
            for wheel in &mut wagon.wheel {
                wheel.creepage.abandon();
                wheel.beside.abandon();
                (wheel.stuck_s, wheel.slid_ago_s) = (0.0, SLID_LONG_AGO_S);
            }
        }
        self.braking = Braking::default();
        (self.most_order, self.samples, self.begun_s) = (0.0, 0, None);
        (self.v_m_s, self.before_m_s, self.last_s) = (f64::NAN, f64::NAN, f64::NAN);
        (self.traced_s, self.looked_s) = (f64::NEG_INFINITY, self.time_s);
        Some(self)
    }

    /// Time of the latest instant taken, s.
    #[must_use]
    pub const fn time_s(&self) -> f64 {
        self.time_s
    }

    /// All alerts so far, in the order in which they were raised.
    #[must_use]
    pub fn alerts(&self) -> &[Alert] {
        &self.book.alerts
    }

    /// Brake applications seen so far.
    #[must_use]
    pub const fn brakings(&self) -> u32 {
        self.brakings
    }

    /// Values so far that no train shows, and that count as unknown.
    #[must_use]
    pub const fn doubted(&self) -> u64 {
        self.doubted
    }

    /// Takes what all wagons read at one instant, front first.
    pub fn take(&mut self, time_s: f64, readings: &[Reading]) {
        let begun_s = *self.begun_s.get_or_insert(time_s);
        if time_s - begun_s >= SECOND_S && self.samples > 1 {
            let dt_s = (self.last_s - begun_s) / (self.samples as f64 - 1.0);
            self.close(dt_s);
            self.begun_s = Some(time_s);
            self.samples = 0;
        }
        (self.last_s, self.time_s) = (time_s, time_s);
        self.samples += 1;
        let trace = time_s - self.traced_s >= TRACE_S - 1e-6;
        if trace {
            self.traced_s = time_s;
        }
        let braking = self.braking.since_s().is_some();
        for (wagon, reading) in self.wagons.iter_mut().zip(readings) {
            let mut reading = *reading;
            self.doubted += reading.doubt();
            wagon.buffer.push(&reading);
            if trace {
                let wheelsets = wagon.wheel.len();
                let force_n = median(&mut reading.pressing_force_n[..wheelsets].to_vec());
                let force_n = if force_n.is_finite() { force_n } else { 0.0 };
                let state = (wagon.pressure.full_n, wagon.pressure.electric_now);
                wagon.timing.trace(reading.brake_demand, force_n, braking, state);
            }
        }
    }

    fn close(&mut self, dt_s: f64) {
        let samples = self.samples as f64;
        let seconds: Vec<WagonSecond> =
            self.wagons.iter_mut().map(|wagon| wagon.buffer.close(wagon.wheel.len(), dt_s)).collect();
        self.follow_braking(&seconds);
        let (v_m_s, a_m_s2) = self.train_speed(&seconds);
        self.v_m_s = v_m_s;
        for (wagon, second) in self.wagons.iter_mut().zip(&seconds) {
            wagon.silent_s = if second.heard > 0.0 { 0.0 } else { wagon.silent_s + SECOND_S };
        }
        if v_m_s.is_finite() && a_m_s2.is_finite() {
            self.follow_wheels(&seconds, v_m_s, a_m_s2, samples);
        }
        if self.time_s >= self.falls_due_s {
            self.falls_due_s = f64::INFINITY;
            self.judge_falls();
        }
        if self.time_s - self.looked_s >= LOOK_S {
            self.looked_s = self.time_s;
            self.judge_sensors();
            self.trust_wheels();
            self.judge_released();
            self.book.settle(self.time_s);
        }
    }

    fn follow_braking(&mut self, seconds: &[WagonSecond]) {
        let orders: Vec<f64> = seconds.iter().map(|second| second.demand).collect();
        let pads = |(wagon, second): (&Wagon, &WagonSecond)| {
            let file = &wagon.file;
            let force_n: f64 = second.wheel[..wagon.wheel.len()].iter().map(|wheel| wheel.press_n).sum();
            file.pad_friction * force_n * file.pad_radius_m / (file.radius_m * file.mass_kg)
        };
        let mut pads_m_s2 = self.wagons.iter().zip(seconds).map(pads).collect();
        self.most_order =
            orders.iter().copied().filter(|order| order.is_finite()).fold(self.most_order, f64::max);
        match self.braking.take(self.time_s, SECOND_S, &orders, &mut pads_m_s2) {
            Turn::Began => {
                self.most_order = 0.0;
                self.falls_due_s = self.falls_due_s.min(self.time_s);
                self.end_rolls(true);
                self.end_rolls_beside(true);
            }
            Turn::Ended => self.end_application(),
            Turn::Same => {}
        }
    }

    /// Speed and acceleration of the train: means of what agrees among the wagons.
    fn train_speed(&mut self, seconds: &[WagonSecond]) -> (f64, f64) {
        let sound = |wagon: &usize| self.book.open(*wagon) != Some(Cause::SpeedSensor);
        let all = seconds.len();
        let usable: Vec<usize> = (0..all).filter(|wagon| all < 3 || sound(wagon)).collect();
        let mut speeds = usable.iter().map(|wagon| seconds[*wagon].v.mean).collect();
        let middle = median(&mut speeds);
        let v_m_s = trimmed_mean(&mut speeds, 0.12 + 0.004 * middle.abs());
        let mut slopes = usable.iter().map(|wagon| seconds[*wagon].v.slope).collect();
        (v_m_s, median(&mut slopes))
    }

    fn follow_wheels(&mut self, seconds: &[WagonSecond], v_m_s: f64, a_m_s2: f64, samples: f64) {
        let since_s = self.braking.since_s().map(|since_s| self.time_s - since_s);
        let quiet = self.braking.released_s > 4.0;
        let rolls = v_m_s > LEAST_SPEED_M_S;
        // Jerks: a second that begins at another acceleration than it ends is no straight line.
        let steady = (v_m_s - self.before_m_s - a_m_s2).abs() < 0.35;
        self.before_m_s = v_m_s;
        let many = self.wagons.len() as f64;
        for (wagon, second) in self.wagons.iter_mut().zip(seconds) {
            let wheelsets = wagon.wheel.len();
            let (mut slides, mut driven) = (false, false);
            let mut creeps: Creeps = [None; MAX_WHEELSETS];
            for k in 0..wheelsets {
                let seen = &second.wheel[k];
                let wheel = &mut wagon.wheel[k];
                let drive = seen.drive_nm / wagon.file.radius_m * wagon.file.compliance_per_n;
                let sigma = wagon.file.wheel_speed_sigma_rad_s;
                // What pads and slides do to a wheel is no fault of its tread.
                let coasts = drive.abs() < COASTING && since_s.is_none() && wheel.slid_ago_s > 20.0;
                wheel.tachometer.take(seen, wagon.file.radius_m, v_m_s, sigma, coasts);
                wheel.slid_ago_s += SECOND_S;
                let creepage = seen.omega.mean * wagon.file.radius_m / v_m_s - 1.0;
                if !rolls || !creepage.is_finite() {
                    continue;
                }
                let slid = (creepage - wheel.idle) * v_m_s < -(0.4 + 0.03 * v_m_s);
                slides |= slid;
                if slid && since_s.is_some() {
                    wheel.slid_ago_s = 0.0;
                    let pressed = seen.press_n > 0.75 * wagon.pressure.full_n.max(1.0);
                    let deep = (creepage - wheel.idle) < -0.25;
                    wheel.stuck_s = if pressed && deep { wheel.stuck_s + SECOND_S } else { wheel.stuck_s };
                    continue;
                }
                if since_s.is_none() && quiet {
                    wheel.idle += 0.1 * (creepage - wheel.idle);
                }
                if !steady {
                    continue;
                }
                let force = |newton: f64| newton * wagon.file.compliance_per_n;
                let file = &wagon.file;
                let turning_nm = file.inertia_kg_m2 * a_m_s2 / file.radius_m;
                let press_n = if seen.press_n.is_finite() { seen.press_n } else { continue };
                let brake = force(file.pad_friction * press_n * file.pad_radius_m / file.radius_m);
                let variance = Creepage::of_mean(file.wheel_speed_sigma_rad_s / seen.omega.mean, samples)
                    + Creepage::of_mean(file.speed_sigma_m_s / v_m_s, samples * many);
                let creep = Creep {
                    creepage,
                    brake,
                    drive: force((seen.drive_nm - turning_nm) / file.radius_m),
                    rate: a_m_s2 / v_m_s,
                    variance,
                };
                driven |= creep.drive.abs() >= DRIVEN;
                if creep.drive.abs() < DRIVEN && wheel.slid_ago_s > 10.0 {
                    let forced = creep.drive - creep.brake;
                    wheel.rim.take(creepage - forced, creep.rate, forced);
                }
                // Beyond the straight part of the curve the equation does not hold; a driven wheel is there first.
                let straight = creep.drive.abs() < COASTING && brake < 0.003;
                if creepage.abs() < 0.012 + wheel.idle.abs() && straight {
                    wheel.creepage.take(&creep, since_s.unwrap_or(0.0));
                    creeps[k] = Some(creep);
                }
            }
            let is_trusted: Vec<bool> = wagon.wheel.iter().map(|wheel| wheel.trusted).collect();
            for (wheel, creep) in wagon.wheel.iter_mut().zip(within::beside(&creeps, &is_trusted)) {
                if let Some(creep) = creep {
                    wheel.beside.take(&creep, since_s.unwrap_or(0.0));
                }
            }
            let slid = slides || wagon.wheel.iter().any(|wheel| wheel.slid_ago_s < 4.0);
            let grip_m = wagon.file.pad_friction * wagon.file.pad_radius_m;
            wagon.pressure.take(second, wheelsets, since_s, quiet, slid, grip_m);
            if rolls {
                // Its wheels tell of its speed only while nothing drives them; both are asked of the same seconds.
                if second.v.mean.is_finite() && !driven {
                    wagon.speed.take(second.v.mean / v_m_s - 1.0, a_m_s2 / v_m_s, 0.0);
                }
                if second.load_kg.is_finite() {
                    let (mean, count) = &mut wagon.load_kg;
                    *count += 1.0;
                    *mean += (second.load_kg - *mean) / *count;
                }
                if let Some(balance_of) = wagon.balance.as_mut().filter(|_| steady && !slid)
                    && let Some(creep) = balance(&wagon.file, second, v_m_s, a_m_s2, samples)
                {
                    balance_of.take(&creep, since_s.unwrap_or(0.0));
                }
            }
        }
        if rolls {
            if since_s.is_none() {
                self.end_rolls(false);
                self.end_rolls_beside(false);
            }
            self.judge_slides();
        }
    }

    /// Rolls that are over become changes; what is common to all wheelsets is the speed's, not theirs.
    fn end_rolls(&mut self, interrupted: bool) {
        let mut ended: Vec<(usize, usize, Change)> = Vec::new();
        for (index, wagon) in self.wagons.iter_mut().enumerate() {
            for (k, wheel) in wagon.wheel.iter_mut().enumerate() {
                ended.extend(wheel.creepage.end_of_roll(interrupted).map(|change| (index, k, change)));
            }
            if let Some(change) = wagon.balance.as_mut().and_then(|of| of.end_of_roll(interrupted)) {
                keep(&mut wagon.balance_rolled, change);
                let small = change.value.abs() < 3.0 * change.variance.sqrt();
                wagon.balance.iter_mut().for_each(|of| of.settle(small));
            }
        }
        if ended.is_empty() {
            return;
        }
        let common = common(
            ended.iter().filter(|(.., change)| change.variance <= 1e-6).map(|(.., change)| change.value),
        );
        for (index, k, _) in ended.iter().filter(|(.., change)| change.variance > 1e-6) {
            self.wagons[*index].wheel[*k].creepage.settle(true);
        }
        ended.retain(|(.., change)| change.variance <= 1e-6);
        ended.iter_mut().for_each(|(.., change)| change.value -= common);
        // A tachometer that is late or rings says nothing of the others of its wagon either.
        let (sound, doubtful): (Vec<_>, Vec<_>) =
            ended.into_iter().partition(|(i, k, _)| self.trusts(*i, *k));
        for (index, k, _) in doubtful {
            self.wagons[index].wheel[k].creepage.settle(true);
        }
        for (index, k, own) in &sound {
            let wheel = &mut self.wagons[*index].wheel[*k];
            let small = own.value.abs() < 4.0 * own.variance.sqrt() || wheel.applications < 1;
            wheel.creepage.settle(small);
        }
    }

    /// The same of each wheelset beside the others of its wagon.
    fn end_rolls_beside(&mut self, interrupted: bool) {
        let mut any = false;
        for wheel in self.wagons.iter_mut().flat_map(|wagon| &mut wagon.wheel) {
            let Some(change) = wheel.beside.end_of_roll(interrupted) else { continue };
            let small = change.value.abs() < 4.0 * change.variance.sqrt() || wheel.applications < 1;
            // Before the first application there is no past.
            if change.variance <= 1e-6 && wheel.trusted {
                any = true;
                keep(&mut wheel.rolled, change);
            }
            wheel.beside.settle(small);
        }
        if any {
            self.judge_rolls();
        }
    }

    fn trust_wheels(&mut self) {
        for index in 0..self.wagons.len() {
            let trusts: Vec<bool> =
                (0..self.wagons[index].wheel.len()).map(|k| self.trusts(index, k)).collect();
            let wheels = &mut self.wagons[index].wheel;
            // Beside other wheels a difference is another one.
            if wheels.iter().map(|wheel| wheel.trusted).ne(trusts.iter().copied()) {
                for (wheel, trusted) in wheels.iter_mut().zip(trusts) {
                    wheel.trusted = trusted;
                    wheel.beside = Creepage::new(Belief::BESIDE);
                    wheel.rolled.clear();
                }
            }
        }
    }

    /// What the application that has just ended says of pads, beside those next to them.
    fn take_grip(&mut self, ended: &[(usize, usize, Braked)]) {
        let tells = |(index, k, braked): &&(usize, usize, Braked)| {
            braked.alone.variance < LEAST_TELLING && self.trusts(*index, *k)
        };
        let known: Vec<_> =
            ended.iter().filter(tells).map(|(index, k, one)| (*index, *k, one.alone)).collect();
        // On a wet rail all creep more, the first wheelsets most: what differs then says little of pads.
        let wet = 0.7 * common(ended.iter().map(|(.., braked)| braked.level.value)).abs();
        let wagons = grip::beside_train(&known);
        let mut wheels = Vec::new();
        for (index, wagon) in self.wagons.iter_mut().enumerate() {
            for (k, wheel) in wagon.wheel.iter_mut().enumerate() {
                let Some(braked) = wheel.beside.end_of_braking() else { continue };
                wheel.beside.settle(true);
                if wheel.trusted && braked.alone.variance < LEAST_TELLING {
                    // Of what the pads of the train do.
                    let usual = wheel.creepage.friction().value.max(0.5);
                    let Change { value, variance } = braked.alone;
                    wheels.push((
                        index,
                        k,
                        Change { value: value / usual, variance: variance / (usual * usual) },
                    ));
                }
            }
        }
        let past = |index: usize, k: usize| self.wagons[index].wheel[k].grip.mean();
        let within = grip::scatter(wheels.iter().map(|(index, k, look)| (look.value, past(*index, *k))), 8);
        let past = |index: usize| self.wagons[index].grip.mean();
        let between = grip::scatter(wagons.iter().map(|(index, look)| (look.value, past(*index))), 4);
        for (index, k, look) in wheels {
            let variance = look.variance.max(within * within) + wet * wet;
            self.wagons[index].wheel[k].grip.take(Change { variance, ..look });
        }
        if wagons.len() < 3 {
            return;
        }
        for (index, look) in wagons {
            let variance = look.variance.max(between * between) + wet * wet;
            self.wagons[index].grip.take(Change { variance, ..look });
        }
    }

    fn end_application(&mut self) {
        self.brakings += 1;
        let mut ended: Vec<(usize, usize, Braked)> = Vec::new();
        for (index, wagon) in self.wagons.iter_mut().enumerate() {
            for (k, wheel) in wagon.wheel.iter_mut().enumerate() {
                ended.extend(wheel.creepage.end_of_braking().map(|braked| (index, k, braked)));
            }
            if let Some(braked) = wagon.balance.as_mut().and_then(Creepage::end_of_braking) {
                keep(&mut wagon.balance_braked, braked);
                let level = braked.level;
                if braked.alone.variance < LEAST_TELLING {
                    wagon.grip.take(Change { value: braked.alone.value - 1.0, ..braked.alone });
                }
                if level.variance > LEAST_TELLING {
                    wagon.balance_braked.pop();
                }
                let small = level.value.abs() < (4.0 * level.variance.sqrt()).max(0.09);
                wagon.balance.iter_mut().for_each(|of| of.settle(small));
            }
        }
        self.take_grip(&ended);
        // The first applications say nothing: there is no past yet.
        let tells = |braked: &Braked| braked.level.variance < LEAST_TELLING;
        for (index, k, _) in ended.iter().filter(|(.., braked)| !tells(braked)) {
            self.wagons[*index].wheel[*k].creepage.settle(true);
        }
        ended.retain(|(.., braked)| tells(braked));
        // Where few of many wheelsets tell, what is common to all is not known, and no single one can be judged.
        let all: usize = self.wagons.iter().map(|wagon| wagon.wheel.len()).sum();
        if all >= MANY_WHEELSETS && ended.len() < MANY_WHEELSETS {
            for (index, k, _) in std::mem::take(&mut ended) {
                self.wagons[index].wheel[k].creepage.settle(true);
            }
        }
        let level = common(ended.iter().map(|(.., braked)| braked.level.value));
        let trend = common(ended.iter().map(|(.., braked)| braked.trend.value));
        // On a wet rail all creep more, the first wheelsets most: what differs then says little of pads.
        let wet = level.abs() * 0.7;
        for (.., braked) in &mut ended {
            braked.level.value -= level;
            braked.level.variance += wet * wet;
            braked.trend.value -= trend;
        }
        let (ended, doubtful): (Vec<_>, Vec<_>) =
            ended.into_iter().partition(|(i, k, _)| self.trusts(*i, *k));
        for (index, k, _) in doubtful {
            self.wagons[index].wheel[k].creepage.settle(true);
        }
        for (index, k, own) in &ended {
            let wheel = &mut self.wagons[*index].wheel[*k];
            keep(&mut wheel.braked, *own);
            wheel.applications += 1;
            let small = own.level.value.abs() < (3.5 * own.level.variance.sqrt()).max(0.08);
            wheel.creepage.settle((small && level < OTHER_RAIL) || wheel.applications < 2);
            if level < -OTHER_RAIL {
                wheel.creepage.shift_friction(level);
            }
        }
        self.judge_application();
        self.falls_due_s = self.time_s + FALLS_S;
        for wagon in &mut self.wagons {
            wagon.pressure.end();
            wagon.timing.forget_trace();
        }
    }
}

impl Wheel {
    pub(crate) fn new() -> Self {
        Self {
            creepage: Creepage::new(Belief::CREEPAGE),
            beside: Creepage::new(Belief::BESIDE),
            trusted: true,
            tachometer: Tachometer::default(),
            rim: SpeedSensor::default(),
            braked: Vec::new(),
            grip: Grip::default(),
            rolled: Vec::new(),
            idle: 0.0,
            stuck_s: 0.0,
            slid_ago_s: SLID_LONG_AGO_S,
            applications: 0,
        }
    }
}

/// What all wheelsets do alike; nothing where there are too few to tell.
fn common(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    if values.len() < MANY_WHEELSETS { 0.0 } else { median(&mut values) }
}

fn keep<T>(list: &mut Vec<T>, item: T) {
    if list.len() == KEPT {
        list.remove(0);
    }
    list.push(item);
}
