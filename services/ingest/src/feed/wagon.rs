//! What a live source knows of one wagon: from a row as it came to a sample with a stamp, or to the name under which it is counted.

use super::source_clock::{Reading, SourceClock};
use super::steps::{Step, Steps};
use super::{Account, Arrival, Tally, When};
use crate::validate;
use railgrip_diagnosis::data::unit_watch::UnitWatch;
use railgrip_filter::PlantKind;
use railgrip_messages::SourceCount;
use railgrip_recording::{Quantity, Row};
use railgrip_vehicle::VehicleParameters;

/// A clock that goes wrong by more than this is told, parts in a million: a quartz stays below 100.
const MOST_DRIFT_PPM: f64 = 500.0;

/// One wagon.
pub(super) struct Wagon {
    wheelsets: usize,
    units: Option<UnitWatch>,
    drift_told: bool,
    /// Its times are of a clock of the source's own, and not those of their arrival.
    pub own_clock: bool,
    /// Its times were said by somebody, be it a log: their steps say what is missing.
    pub own_times: bool,
    pub clock: SourceClock,
    pub steps: Steps,
    pub tally: Tally,
    /// A row that has jumped ahead, with its arrival, until the next one comes.
    ahead: Option<(Box<Row>, u64)>,
}

impl Wagon {
    /// Nothing has come yet.
    pub fn new(vehicle: &VehicleParameters, plant: PlantKind) -> Self {
        Self {
            wheelsets: vehicle.wheelsets(),
            units: (plant == PlantKind::Wagon).then(|| UnitWatch::new(vehicle.clone())),
            drift_told: false,
            own_clock: true,
            own_times: true,
            clock: SourceClock::default(),
            steps: Steps::default(),
            tally: Tally::default(),
            ahead: None,
        }
    }

    /// Takes a row of this wagon (from 0) that arrived at an instant of our clock, ns. One whose time has jumped ahead of the clock of
    /// the source waits for the next: if that goes on behind it, the clock was set; if not, the one that jumped is wrong.
    pub fn take(&mut self, wagon: usize, row: &Row, arrived_ns: u64, sink: &mut dyn FnMut(Arrival<'_>)) {
        if row.t_s.is_nan() {
            self.tally.add(SourceCount::Unreadable, 1);
            return sink(Arrival::Refused(format!("wagon {}: a sample without a time", wagon + 1)));
        }
        // Such a time would move the base of all others.
        if !Quantity::Time.allowed().contains(&row.t_s) {
            self.tally.add(SourceCount::OutOfRange, 1);
            return sink(Arrival::Refused(format!("wagon {}: no clock says {:e} s", wagon + 1, row.t_s)));
        }
        if let Some((before, its_arrival_ns)) = self.ahead.take() {
            if row.t_s > before.t_s {
                self.settle(wagon, &before, its_arrival_ns, sink);
            } else {
                self.tally.add(SourceCount::Ahead, 1);
                let (number, t_s) = (wagon + 1, before.t_s);
                sink(Arrival::Refused(format!(
                    "wagon {number}: the time {t_s} s is ahead of the clock of its source"
                )));
            }
        }
        if self.own_clock && self.steps.jumps(row.t_s) && self.clock.is_ahead(row.t_s, arrived_ns) {
            self.ahead = Some((Box::new(*row), arrived_ns));
            return;
        }
        self.settle(wagon, row, arrived_ns, sink);
    }

    /// The source has ended: what waits is contradicted by nothing.
    pub fn end(&mut self, wagon: usize, sink: &mut dyn FnMut(Arrival<'_>)) {
        if let Some((row, arrived_ns)) = self.ahead.take() {
            self.settle(wagon, &row, arrived_ns, sink);
        }
    }

    /// Takes a row whose time may be right.
    fn settle(&mut self, wagon: usize, row: &Row, arrived_ns: u64, sink: &mut dyn FnMut(Arrival<'_>)) {
        let (at_ns, begins) = match self.clock.read(row.t_s, arrived_ns) {
            Reading::Late => {
                self.tally.add(SourceCount::Late, 1);
                return sink(Arrival::Late { wagon });
            }
            Reading::At(at_ns) => (at_ns, false),
            Reading::Begins(at_ns) => (at_ns, true),
        };
        self.step(row.t_s, begins);
        self.tell_drift(wagon, sink);
        let wheelsets = self.wheelsets;
        if let Some(units) = &mut self.units {
            if begins {
                units.begin();
            }
            if let Some(why) = units.take(row, wheelsets) {
                sink(Arrival::Implausible { wagon, why });
            }
            if units.implausible() {
                self.tally.add(SourceCount::Withheld, 1);
                return sink(Arrival::Withheld { wagon });
            }
        }
        self.tally.add(SourceCount::OutOfRange, validate::impossible(row, wheelsets));
        self.tally.add(SourceCount::Samples, 1);
        sink(Arrival::Row { wagon, row, wheelsets, when: When::At(at_ns), begins });
    }

    /// What the source has counted of it.
    pub fn account(&self) -> Account {
        Account { counts: self.tally.counts(), drift_ppm: self.drift_ppm() }
    }

    /// Counts what the time of a sample passes over.
    fn step(&mut self, t_s: f64, begins: bool) {
        if begins {
            return self.steps.begin(t_s);
        }
        match self.steps.take(t_s) {
            _ if !self.own_times => {}
            Step::Usual => {}
            Step::Skipped(count) => self.tally.add(SourceCount::Skipped, count),
            Step::Paused => self.tally.add(SourceCount::Pauses, 1),
        }
    }

    /// How much faster our clock runs than that of the source, parts in a million.
    fn drift_ppm(&self) -> Option<f64> {
        self.clock.drift_ppm().filter(|_| self.own_clock)
    }

    fn tell_drift(&mut self, wagon: usize, sink: &mut dyn FnMut(Arrival<'_>)) {
        let Some(drift_ppm) = self.drift_ppm() else { return };
        let wrong = drift_ppm.abs() > MOST_DRIFT_PPM;
        if wrong != self.drift_told {
            self.drift_told = wrong;
            sink(Arrival::Drifts { wagon, drift_ppm, wrong });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A source at 100 Hz whose sample `wrong` says a time that is `by_s` ahead; what became of its samples, by count, and how many
    /// were refused.
    fn sent(wrong: u32, by_s: f64, set_for_good: bool) -> (Wagon, u64) {
        let vehicle =
            toml::from_str(include_str!("../../../../config/vehicle.toml")).expect("the default vehicle");
        let mut wagon = Wagon::new(&vehicle, PlantKind::Wagon);
        let mut refused = 0;
        for k in 0..1000_u32 {
            let ahead = k == wrong || set_for_good && k > wrong;
            let t_s = 100.0 + f64::from(k) * 0.01 + if ahead { by_s } else { 0.0 };
            let arrived_ns = 5_000_000_000 + u64::from(k) * 10_000_000 + u64::from(k % 7) * 300_000;
            let row = Row { t_s, ..Row::default() };
            wagon.take(0, &row, arrived_ns, &mut |arrival| {
                refused += u64::from(matches!(arrival, Arrival::Refused(_)))
            });
        }
        (wagon, refused)
    }

    #[test]
    fn one_time_that_is_ahead_costs_its_own_sample_and_is_counted_once() {
        let names = [SourceCount::Ahead, SourceCount::Late, SourceCount::OutOfRange];
        // By how much, under which of these names, and whether it is told as refused.
        for (by_s, name, told) in [
            (0.3, 0, 1),
            (2.0, 0, 1),
            (30.0, 0, 1),
            (50.0, 0, 1),
            (86_400.0, 0, 1),
            (1e15, 2, 1),
            (-1.0, 1, 0),
        ] {
            let (wagon, refused) = sent(500, by_s, false);
            let of = |what| wagon.tally.count(what);
            let mut expected = [0; 3];
            expected[name] = 1;
            assert_eq!((names.map(of), refused), (expected, told), "{by_s} s ahead");
            assert_eq!(of(SourceCount::Samples), 999, "{by_s} s ahead");
            assert_eq!(of(SourceCount::Skipped), 1, "{by_s} s ahead: the sample itself");
            assert_eq!(of(SourceCount::Pauses), 0, "{by_s} s ahead");
        }
    }

    #[test]
    fn a_clock_that_is_set_ahead_is_followed_and_costs_nothing() {
        let (wagon, refused) = sent(500, 3.0, true);
        assert_eq!(
            (wagon.tally.count(SourceCount::Samples), wagon.tally.count(SourceCount::Ahead), refused),
            (1000, 0, 0)
        );
    }
}
