//! Values as messages bring them, and the rows that they make.

use crate::{Plan, Unread};
use railgrip_recording::Row;

/// What became of a message.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Taken {
    /// Somebody wants it.
    pub wanted: bool,
    /// Values that its data are too short for.
    pub short: u32,
    /// Values that are none, or outside of what they can be.
    pub out_of_range: u32,
}

/// The latest value of a slot.
#[derive(Debug, Clone, Copy)]
struct Held {
    value: f64,
    at_s: f64,
}

/// The latest values of all wagons.
#[derive(Debug, Clone)]
pub struct Gathering {
    plan: Plan,
    hold_s: f64,
    held: Vec<Vec<Held>>,
    inputs: Vec<f64>,
}

impl Gathering {
    /// Nothing is known yet; a value counts for `hold_s` after its message.
    #[must_use]
    pub fn new(plan: Plan, hold_s: f64) -> Self {
        let nothing = Held { value: f64::NAN, at_s: f64::NEG_INFINITY };
        let held = plan.wagons.iter().map(|wagon| vec![nothing; wagon.slots]).collect();
        Self { plan, hold_s, held, inputs: Vec::new() }
    }

    /// Whether somebody wants such a message of that lane.
    #[must_use]
    pub fn wants(&self, lane: usize, key: u32) -> bool {
        self.plan.wanted.contains_key(&(lane, key))
    }

    /// Takes a message that came on a lane at a time, s; hands over the rows that it makes, each with its wagon (from 0).
    pub fn take(
        &mut self,
        lane: usize,
        key: u32,
        data: &[u8],
        at_s: f64,
        sink: &mut dyn FnMut(usize, Row),
    ) -> Taken {
        let mut taken = Taken::default();
        let Some(wanted) = self.plan.wanted.get(&(lane, key)) else { return taken };
        taken.wanted = true;
        for take in &wanted.takes {
            let value = match take.cell.read(data) {
                Ok(value) => value,
                // What was there before goes on to count.
                Err(Unread::NotSelected) => continue,
                Err(Unread::Short) => {
                    taken.short += 1;
                    f64::NAN
                }
                Err(Unread::OutOfRange) => {
                    taken.out_of_range += 1;
                    f64::NAN
                }
            };
            self.held[take.wagon][take.slot] = Held { value, at_s };
        }
        for wagon in &wanted.samples {
            let held = &self.held[*wagon];
            let fresh = |slot: usize| {
                let Held { value, at_s: since_s } = held[slot];
                if at_s - since_s <= self.hold_s { value } else { f64::NAN }
            };
            sink(*wagon, self.plan.wagons[*wagon].row(at_s, &fresh, &mut self.inputs));
        }
        taken
    }
}
