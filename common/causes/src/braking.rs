//! When the train brakes: one application from the order to its end.

use crate::robust::median;

/// An application begins above this order and ends below that.
const BEGINS_ABOVE: f64 = 0.05;
const ENDS_BELOW: f64 = 0.03;
/// Nominal retardation of pads and electric brake that counts as braking where no order is known, m/s².
const HELD_M_S2: f64 = 0.04;

/// Whether the train brakes, and since when.
#[derive(Debug, Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Braking {
    since_s: Option<f64>,
    /// How long the latest application lasted, s.
    pub lasted_s: f64,
    /// Time since the last application ended, s.
    pub released_s: f64,
}

/// What a second did to the application.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Turn {
    /// It began.
    Began,
    /// It ended.
    Ended,
    /// Nothing.
    Same,
}

impl Braking {
    /// Takes a second: orders that the wagons heard (NaN where unknown) and nominal retardations of their
    /// pads and electric brakes, m/s².
    pub(crate) fn take(&mut self, time_s: f64, dt_s: f64, orders: &[f64], held_m_s2: &mut Vec<f64>) -> Turn {
        let order = orders.iter().copied().filter(|order| order.is_finite()).fold(f64::NAN, f64::max);
        let held = median(held_m_s2);
        let (on, off) = if order.is_finite() {
            (order > BEGINS_ABOVE, order < ENDS_BELOW)
        } else {
            (held > HELD_M_S2, held.is_nan() || held < 0.5 * HELD_M_S2)
        };
        self.released_s += dt_s;
        match self.since_s {
            None if on => {
                self.since_s = Some(time_s);
                Turn::Began
            }
            Some(since_s) if off => {
                self.lasted_s = time_s - since_s;
                (self.since_s, self.released_s) = (None, 0.0);
                Turn::Ended
            }
            _ => Turn::Same,
        }
    }

    /// When the application began; `None` while the brakes are released.
    pub(crate) const fn since_s(&self) -> Option<f64> {
        self.since_s
    }
}
