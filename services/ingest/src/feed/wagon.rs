//! What a live source knows of one wagon: from a row as it came to a sample with a stamp, or to the name under which it is counted.

use super::source_clock::{Reading, SourceClock};
use super::steps::{Step, Steps};
use super::unit_watch::UnitWatch;
use super::{Account, Arrival, Tally, When};
use railgrip_filter::PlantKind;
use railgrip_messages::SourceCount;
use railgrip_recording::Row;
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
        }
    }

    /// Takes a row of this wagon (from 0) that arrived at an instant of our clock, ns.
    pub fn take(&mut self, wagon: usize, row: &Row, arrived_ns: u64, sink: &mut dyn FnMut(Arrival<'_>)) {
        if !row.t_s.is_finite() {
            sink(Arrival::Refused(format!("wagon {}: a sample without a time", wagon + 1)));
            return;
        }
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
