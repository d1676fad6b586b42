//! The one table of faults: what each is called, what it acts on, how large it may be, when it shows, and what it does.
//! Drawing, labels, tests and documents loop over it.

use serde::{Deserialize, Serialize};

use crate::random::Stream;

/// What is wrong with one wheelset; all zero when nothing is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WheelsetDefects {
    /// Pad force that never leaves, over full pressing force; no transducer sees it.
    pub drag: f64,
    /// Share of the cylinder's pressure that is missing: cut off or vented before the transducer.
    pub pressure_lost: f64,
    /// Share of pad friction that is missing.
    pub friction_lost: f64,
    /// Loss of pad friction with temperature, a 100 K.
    pub fade: f64,
    /// Leak of the cylinder once it is full, 1/s.
    pub leak_per_s: f64,
    /// Whether the valve of the slide protection never vents.
    pub valve_dead: bool,
    /// Length of the flat, mm.
    pub flat_mm: f64,
    /// Relative error of the radius in the file.
    pub radius: f64,
    /// Once a turn, the speed reading is out by this share.
    pub eccentricity: f64,
    /// Delay of the speed reading, s.
    pub speed_delay_s: f64,
    /// Share of time without a speed reading.
    pub speed_missing: f64,
    /// Error of the pressure transducer, over full pressing force.
    pub pressure_offset: f64,
}

/// What is wrong with one wagon; all zero when nothing is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WagonDefects {
    /// Its wheelsets, front first.
    pub wheelset: [WheelsetDefects; 4],
    /// Delay of the distributor, s.
    pub distributor_s: f64,
    /// Factor on the time that the cylinders take, less one.
    pub slowness: f64,
    /// Share of cylinder pressure that the distributor keeps when it should release.
    pub residual: f64,
    /// Whether the distributor hears nothing any more: cock shut, here or ahead.
    pub cut_off: bool,
    /// Delay of the vehicle speed, s.
    pub v_delay_s: f64,
    /// Relative error of the vehicle speed.
    pub v_scale: f64,
    /// Whether the sander is empty.
    pub sander_empty: bool,
    /// True mass over the mass in the file, less one.
    pub payload: f64,
    /// Whether nothing is sent any more.
    pub silent: bool,
}

/// What a fault acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ActsOn {
    /// One wheelset of one wagon.
    Wheelset,
    /// One wagon.
    Wagon,
    /// One wagon that has sanders.
    Sander,
    /// A wagon and all behind it; the rear part of a train.
    RearPart,
    /// The rail.
    Line,
}

/// When a fault can be seen at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shows {
    /// In every brake application.
    Braking,
    /// While a wheelset concerned slides in braking; of a fault of the rail any wheelset.
    Sliding,
    /// While pads concerned press in braking and have faded by [`FADED`].
    Fading,
    /// Whenever the train rolls.
    Rolling,
}

/// When a fault may begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Begins {
    /// The train leaves the depot with it.
    AtDeparture,
    /// Any time during the first part of the day.
    OnTheWay,
    /// Where the train first meets it.
    AtPlace,
}

/// One row of the table.
#[derive(Debug, Clone, Copy)]
pub struct FaultKind {
    /// Stable name.
    pub id: &'static str,
    /// The cause that an alert should name.
    pub cause: &'static str,
    /// What it acts on.
    pub acts_on: ActsOn,
    /// Smallest and largest size.
    pub size: (f64, f64),
    /// What the size counts.
    pub unit: &'static str,
    /// From this size on a fault is gross: it must be found.
    pub gross: f64,
    /// Either sign occurs.
    pub signed: bool,
    /// When it shows.
    pub shows: Shows,
    /// When it begins.
    pub begins: Begins,
    /// Puts it on a wagon; `wheelset` is the one concerned.
    pub put: fn(f64, usize, &mut WagonDefects),
}

const fn kind(
    (id, cause): (&'static str, &'static str),
    (acts_on, shows, begins): (ActsOn, Shows, Begins),
    (smallest, largest, gross): (f64, f64, f64),
    unit: &'static str,
    put: fn(f64, usize, &mut WagonDefects),
) -> FaultKind {
    FaultKind {
        id,
        cause,
        acts_on,
        size: (smallest, largest),
        unit,
        gross,
        signed: false,
        shows,
        begins,
        put,
    }
}

const fn either_way(mut kind: FaultKind) -> FaultKind {
    kind.signed = true;
    kind
}

use ActsOn::{Line, RearPart, Sander, Wagon, Wheelset};
use Begins::{AtDeparture, AtPlace, OnTheWay};
use Shows::{Braking, Fading, Rolling, Sliding};

/// Share of friction that fade must take to count as seen: the smallest loss of the other faults of pads.
pub const FADED: f64 = 0.15;

/// All faults.
#[rustfmt::skip]
pub const FAULTS: [FaultKind; 27] = [
    kind(("dragging_pad", "dragging"), (Wheelset, Rolling, OnTheWay), (0.03, 0.35, 0.10), "of full pressing force, unmeasured",
        |size, k, wagon| wagon.wheelset[k].drag = size),
    kind(("dragging_distributor", "dragging"), (Wagon, Rolling, OnTheWay), (0.05, 0.35, 0.12), "of full cylinder pressure, measured",
        |size, _, wagon| wagon.residual = size),
    kind(("hand_brake", "dragging"), (Wagon, Rolling, OnTheWay), (0.05, 0.40, 0.12), "of full pressing force on half of the wheelsets, unmeasured",
        |size, _, wagon| { wagon.wheelset[0].drag = size; wagon.wheelset[1].drag = size; }),
    kind(("isolated_wheelset", "isolated"), (Wheelset, Braking, OnTheWay), (0.85, 1.0, 0.85), "of the pressure lost",
        |size, k, wagon| wagon.wheelset[k].pressure_lost = size),
    kind(("isolated_wagon", "isolated"), (Wagon, Braking, OnTheWay), (1.0, 1.0, 1.0), "shut",
        |_, _, wagon| wagon.cut_off = true),
    kind(("isolated_rear_part", "isolated"), (RearPart, Braking, OnTheWay), (1.0, 1.0, 1.0), "shut",
        |_, _, wagon| wagon.cut_off = true),
    kind(("glazed_pad", "pad_uneven"), (Wheelset, Braking, OnTheWay), (0.15, 0.50, 0.25), "of pad friction lost",
        |size, k, wagon| wagon.wheelset[k].friction_lost = size),
    kind(("worn_pads", "pad_low"), (Wagon, Braking, OnTheWay), (0.15, 0.45, 0.25), "of pad friction lost",
        |size, _, wagon| wagon.wheelset.iter_mut().for_each(|one| one.friction_lost = size)),
    kind(("brake_fade", "brake_fade"), (Wagon, Fading, OnTheWay), (0.10, 0.60, 0.30), "of pad friction lost a 100 K above 80 °C",
        |size, _, wagon| wagon.wheelset.iter_mut().for_each(|one| one.fade = size)),
    kind(("slow_cylinder", "slow_cylinder"), (Wagon, Braking, OnTheWay), (0.6, 5.0, 1.5), "times the usual time, more",
        |size, _, wagon| wagon.slowness = size),
    kind(("leaking_cylinder", "slow_cylinder"), (Wheelset, Braking, OnTheWay), (0.01, 0.12, 0.04), "1/s",
        |size, k, wagon| wagon.wheelset[k].leak_per_s = size),
    kind(("late_distributor", "late_distributor"), (Wagon, Braking, OnTheWay), (1.0, 8.0, 3.0), "s",
        |size, _, wagon| wagon.distributor_s = size),
    kind(("slide_valve_vents", "wsp_valve"), (Wheelset, Braking, OnTheWay), (0.25, 0.80, 0.40), "of the pressure lost",
        |size, k, wagon| wagon.wheelset[k].pressure_lost = size),
    kind(("slide_valve_dead", "wsp_valve"), (Wheelset, Sliding, OnTheWay), (1.0, 1.0, 1.0), "stuck",
        |_, k, wagon| wagon.wheelset[k].valve_dead = true),
    kind(("wheel_flat", "wheel_flat"), (Wheelset, Rolling, OnTheWay), (20.0, 80.0, 50.0), "mm",
        |size, k, wagon| wagon.wheelset[k].flat_mm = size),
    either_way(kind(("wheel_diameter", "wheel_diameter"), (Wheelset, Rolling, AtDeparture), (0.006, 0.04, 0.015), "of the radius in the file",
        |size, k, wagon| wagon.wheelset[k].radius = size)),
    kind(("tachometer_eccentric", "tachometer_eccentric"), (Wheelset, Rolling, OnTheWay), (0.003, 0.03, 0.01), "of wheel speed, once a turn",
        |size, k, wagon| wagon.wheelset[k].eccentricity = size),
    kind(("tachometer_late", "tachometer_late"), (Wheelset, Rolling, OnTheWay), (0.06, 0.60, 0.20), "s",
        |size, k, wagon| wagon.wheelset[k].speed_delay_s = size),
    kind(("tachometer_dropout", "tachometer_dropout"), (Wheelset, Rolling, OnTheWay), (0.02, 0.60, 0.10), "of time without reading",
        |size, k, wagon| wagon.wheelset[k].speed_missing = size),
    kind(("speed_late", "speed_sensor"), (Wagon, Rolling, OnTheWay), (0.10, 0.80, 0.30), "s",
        |size, _, wagon| wagon.v_delay_s = size),
    either_way(kind(("speed_scale", "speed_sensor"), (Wagon, Rolling, OnTheWay), (0.008, 0.05, 0.02), "of vehicle speed",
        |size, _, wagon| wagon.v_scale = size)),
    either_way(kind(("pressure_offset", "pressure_sensor"), (Wheelset, Braking, OnTheWay), (0.04, 0.40, 0.12), "of full pressing force",
        |size, k, wagon| wagon.wheelset[k].pressure_offset = size)),
    kind(("sander_empty", "sander"), (Sander, Sliding, OnTheWay), (1.0, 1.0, 1.0), "empty",
        |_, _, wagon| wagon.sander_empty = true),
    kind(("low_stretch", "low_adhesion"), (Line, Sliding, AtPlace), (0.60, 0.90, 0.75), "of dry friction lost",
        |_, _, _| {}),
    either_way(kind(("payload_entry", "payload"), (Wagon, Rolling, AtDeparture), (0.10, 0.45, 0.20), "of the mass in the file",
        |size, _, wagon| wagon.payload = size)),
    kind(("silent_wagon", "silent"), (Wagon, Rolling, OnTheWay), (1.0, 1.0, 1.0), "silent",
        |_, _, wagon| wagon.silent = true),
    kind(("silent_wheelset", "tachometer_dropout"), (Wheelset, Rolling, OnTheWay), (1.0, 1.0, 1.0), "of time without reading",
        |_, k, wagon| wagon.wheelset[k].speed_missing = 1.0),
];

impl FaultKind {
    /// The kind of an id.
    #[must_use]
    pub fn of(id: &str) -> Option<&'static Self> {
        FAULTS.iter().find(|kind| kind.id == id)
    }
}

/// A fault in a train.
#[derive(Debug, Clone, Copy)]
pub struct Fault {
    /// Its row of the table.
    pub kind: &'static FaultKind,
    /// Its size, in the unit of its kind, with sign.
    pub size: f64,
    /// When it begins, s; not a number where the train has to find its place first.
    pub onset_s: f64,
    /// First wagon concerned, from 0.
    pub wagon: usize,
    /// Wheelset concerned, from 0.
    pub wheelset: usize,
}

impl Fault {
    /// Draws size, onset and wagon; `wheelsets` of each wagon, `sanders` the wagons that have one.
    pub(crate) fn draw(
        kind: &'static FaultKind,
        stream: &mut Stream,
        wheelsets: &[usize],
        sanders: &[usize],
        duration_s: f64,
    ) -> Self {
        let (smallest, largest) = kind.size;
        // Small faults are as frequent as large ones on a logarithmic scale.
        let size = smallest * (largest / smallest).powf(stream.uniform(0.0, 1.0));
        let size = if kind.signed { size * stream.sign() } else { size };
        let onset_s = match kind.begins {
            AtDeparture => 0.0,
            OnTheWay => duration_s * stream.uniform(0.15, 0.5),
            AtPlace => f64::NAN,
        };
        let count = wheelsets.len();
        let wagon = match kind.acts_on {
            RearPart if count > 1 => 1 + stream.below(count - 1),
            Sander => sanders.get(stream.below(sanders.len())).copied().unwrap_or(0),
            _ => stream.below(count),
        };
        Self { kind, size, onset_s, wagon, wheelset: stream.below(wheelsets[wagon]) }
    }

    /// Wagons concerned.
    #[must_use]
    pub fn wagons(&self, count: usize) -> std::ops::Range<usize> {
        match self.kind.acts_on {
            RearPart => self.wagon..count,
            Line => 0..count,
            Wheelset | Wagon | Sander => self.wagon..self.wagon + 1,
        }
    }

    /// Wheelsets concerned in a wagon that has `wheelsets` of them.
    #[must_use]
    pub fn wheelsets(&self, wheelsets: usize) -> std::ops::Range<usize> {
        match (self.kind.acts_on, self.kind.id) {
            (Wheelset, _) => self.wheelset..self.wheelset + 1,
            (_, "hand_brake") => 0..wheelsets.min(2),
            _ => 0..wheelsets,
        }
    }

    /// Whether it is large enough that it must be found.
    #[must_use]
    pub fn is_gross(&self) -> bool {
        self.size.abs() >= self.kind.gross
    }

    /// Puts the fault on the wagons that it concerns.
    pub(crate) fn put(&self, defects: &mut [WagonDefects]) {
        for wagon in self.wagons(defects.len()) {
            (self.kind.put)(self.size, self.wheelset, &mut defects[wagon]);
        }
    }
}
