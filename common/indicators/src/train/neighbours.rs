//! The wagons of a train beside each other: who does not brake while the others do, and who begins late.

use super::delay::Delays;
use super::pressed::Pressed;
use crate::settings::IndicatorSettings;
use railgrip_messages::Health;

/// What the wagons of a train show about each other.
#[derive(Debug, Default)]
pub struct Neighbours {
    pressed: Pressed,
    delays: Delays,
}

impl Neighbours {
    /// Takes in what the live wagons say at `now_ns` (monotonic), `dt_s` after the last time.
    pub fn take(&mut self, live: &[&Health], now_ns: u64, dt_s: f64, settings: &IndicatorSettings) {
        self.pressed.take(live, dt_s.clamp(0.0, 1.0), settings);
        self.delays.take(live, now_ns);
    }

    /// Share of the latest braking of the train during which a wagon had no pressing force; `None` while too little is
    /// known.
    #[must_use]
    pub fn without_brake(&self, wagon: u32) -> Option<f64> {
        self.pressed.without_brake(wagon)
    }

    /// How much later than its place in the train explains a wagon begins to brake, s: median, smallest and largest of its
    /// latest applications; `None` before the third.
    #[must_use]
    pub fn delay_s(&self, wagon: u32) -> Option<[f64; 3]> {
        self.delays.delay_s(wagon)
    }
}
