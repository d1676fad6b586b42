//! The watch over a train: samples in, alerts out.
//!
//! Here stands what is known of a train, and what is done with a sample; `pass` says what a second teaches, `ended` what a roll or
//! an application that is over does. Verdicts stand in `crate::verdict`.

mod ended;
mod pass;

use crate::book::{Alert, Book};
use crate::braking::Braking;
use crate::creepage::{Belief, Braked, Change, Creepage};
use crate::grip::{Grip, Rails};
use crate::input::{MAX_WHEELSETS, Reading, WagonFile};
use crate::pressure::Pressure;
use crate::robust::median;
use crate::second::{Buffer, SECOND_S, WagonSecond};
use crate::sensors::{SpeedSensor, Tachometer};
use crate::timing::{TRACE_S, Timing};

/// From so many wheelsets on their median is what the rail and the speed do to all alike.
pub(crate) const MANY_WHEELSETS: usize = 8;
/// Of a wheelset that has not slid yet, s.
const SLID_LONG_AGO_S: f64 = 1e6;
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
    /// Creepage at rest beside them, roll by roll, each by itself.
    pub rest: Grip,
    /// Creepage at rest by the latest roll alone.
    pub at_rest: Option<f64>,
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
    /// Whether it has ever driven the train.
    pub drives: bool,
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
    /// For how long pads of wagons that are not driven have stayed off while others braked electrically, s.
    pub(crate) blended_s: f64,
    rails: Rails,
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
            drives: false,
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
            blended_s: 0.0,
            rails: Rails::default(),
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
                && wagon.wheel.iter().all(|wheel| wheel.grip.is_sound() && wheel.rest.is_sound())
        };
        let same = self.wagons.iter().map(|wagon| &wagon.file).eq(files);
        let sound = self.wagons.iter().all(|wagon| wheels(wagon) && learnt(wagon));
        if !same
            || !sound
            || !self.rails.is_sound()
            || !self.time_s.is_finite()
            || !self.book.is_sound(files.len())
        {
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
                wagon.trace(&reading, braking);
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
            self.judge_running();
            self.book.settle(self.time_s);
        }
    }
}

impl Wagon {
    /// Takes a value of the traces of its pressing forces.
    fn trace(&mut self, reading: &Reading, braking: bool) {
        let wheelsets = self.wheel.len();
        let forces_n = &reading.pressing_force_n[..wheelsets];
        let known = |value: f64| if value.is_finite() { value } else { 0.0 };
        let force_n = known(median(&mut forces_n.to_vec()));
        let drive_nm = known(median(&mut reading.drive_torque_nm[..wheelsets].to_vec()));
        let electric_n = (-drive_nm).max(0.0) / (self.file.pad_friction * self.file.pad_radius_m);
        let state = (self.pressure.full_n, self.pressure.electric_now);
        self.timing.trace(reading.brake_demand, (force_n, electric_n), braking, state);
        self.pressure.trace(forces_n);
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
            rest: Grip::default(),
            at_rest: None,
            idle: 0.0,
            stuck_s: 0.0,
            slid_ago_s: SLID_LONG_AGO_S,
            applications: 0,
        }
    }
}
