//! Sensor faults of one wagon, as a scenario orders them.

use crate::scenario::{FaultKind, FaultTable, signal_of};
use railgrip_recording::{Quantity, Row};

/// Samples from one spike to the next.
const SPIKE_EVERY: u64 = 10;

/// One ordered fault.
#[derive(Clone, Debug)]
struct Fault {
    table: FaultTable,
    signal: Option<(Quantity, usize)>,
    last: f64,
    samples: u64,
}

/// The faults of one wagon.
#[derive(Clone, Debug)]
pub(crate) struct Faults(Vec<Fault>);

impl Faults {
    /// Those of `tables` that concern wagon `number` (from 1).
    pub fn new(tables: &[FaultTable], number: usize) -> Self {
        let own = tables.iter().filter(|table| table.wagon == number);
        Self(
            own.map(|table| {
                let signal = table.signal.as_deref().and_then(signal_of);
                Fault { table: table.clone(), signal, last: f64::NAN, samples: 0 }
            })
            .collect(),
        )
    }

    /// Applies the faults to a row at the programme's time; returns whether the wagon sends it at all.
    pub fn apply(&mut self, time_s: f64, row: &mut Row) -> bool {
        let mut present = true;
        for fault in &mut self.0 {
            present &= fault.apply(time_s, row);
        }
        present
    }
}

impl Fault {
    fn apply(&mut self, time_s: f64, row: &mut Row) -> bool {
        let active = (self.table.from_s..self.table.until_s).contains(&time_s);
        let Some((quantity, wheelset)) = self.signal else { return !active };
        let cell = row.get_mut(quantity, wheelset);
        if !active {
            self.last = *cell;
            self.samples = 0;
            return true;
        }
        match self.table.kind {
            FaultKind::Stuck => *cell = self.last,
            FaultKind::Missing => *cell = f64::NAN,
            FaultKind::Offset => *cell += self.table.value,
            FaultKind::Spike if self.samples.is_multiple_of(SPIKE_EVERY) => *cell += self.table.value,
            FaultKind::Spike | FaultKind::Silent => {}
        }
        self.samples += 1;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(kind: FaultKind, signal: Option<&str>) -> Faults {
        let table = FaultTable {
            wagon: 2,
            signal: signal.map(str::to_owned),
            kind,
            from_s: 1.0,
            until_s: 2.0,
            value: 7.0,
        };
        Faults::new(&[table.clone(), FaultTable { wagon: 1, ..table }], 2)
    }

    fn apply(faults: &mut Faults, time_s: f64, value: f64) -> (bool, f64) {
        let mut row = Row::default();
        row.wheel_speed_rad_s[1] = value;
        let present = faults.apply(time_s, &mut row);
        (present, row.wheel_speed_rad_s[1])
    }

    #[test]
    fn every_kind_does_what_it_says() {
        let mut stuck = faults(FaultKind::Stuck, Some("omega_r_rad_s"));
        assert_eq!(apply(&mut stuck, 0.9, 5.0), (true, 5.0));
        assert_eq!(apply(&mut stuck, 1.5, 6.0), (true, 5.0));
        assert_eq!(apply(&mut stuck, 2.0, 6.5), (true, 6.5));
        assert!(apply(&mut faults(FaultKind::Missing, Some("omega_r_rad_s")), 1.0, 5.0).1.is_nan());
        assert_eq!(apply(&mut faults(FaultKind::Offset, Some("omega_r_rad_s")), 1.0, 5.0), (true, 12.0));
        let mut spike = faults(FaultKind::Spike, Some("omega_r_rad_s"));
        let spikes: Vec<f64> = (0..12).map(|_| apply(&mut spike, 1.0, 0.0).1).collect();
        assert_eq!(spikes.iter().filter(|value| **value == 7.0).count(), 2);
        let mut silent = faults(FaultKind::Silent, None);
        assert!(apply(&mut silent, 0.5, 1.0).0 && !apply(&mut silent, 1.5, 1.0).0);
        assert_eq!(apply(&mut faults(FaultKind::Offset, Some("v_m_s")), 1.5, 5.0), (true, 5.0));
    }
}
