//! Isolated brakes: a wheelset without pressing force while others of the wagon have it.

use crate::measure::mean::FadingMean;
use bytemuck::{Pod, Zeroable};
use railgrip_messages::MAX_WHEELSETS;

/// An application must have lasted so long, s: cylinders do not fill at the same instant.
const AFTER_S: f64 = 2.0;
/// After slide protection acted on a wheelset it needs so long to fill again, s.
const REFILL_S: f64 = 3.0;
/// Less than this share of the largest force is none.
const NONE_SHARE: f64 = 0.2;

/// What is known about isolation, by wheelset.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(crate) struct Isolation {
    without: [FadingMean; MAX_WHEELSETS],
    since_wsp_s: [f64; MAX_WHEELSETS],
    applied_s: f64,
}

impl Isolation {
    /// Takes in the pressing forces (NaN = missing) of an instant that holds for `dt_s`.
    pub fn add(&mut self, dt_s: f64, force_n: &[f64], wsp_active: u32, least_n: f64, memory_s: f64) {
        let largest_n = force_n.iter().copied().fold(0.0, f64::max);
        self.applied_s = if largest_n >= 2.0 * least_n { self.applied_s + dt_s } else { 0.0 };
        for (index, own_n) in force_n.iter().enumerate() {
            let active = wsp_active & (1 << index) != 0;
            self.since_wsp_s[index] = if active { 0.0 } else { self.since_wsp_s[index] + dt_s };
            if self.applied_s >= AFTER_S && self.since_wsp_s[index] >= REFILL_S && own_n.is_finite() {
                let without = *own_n < (NONE_SHARE * largest_n).max(0.5 * least_n);
                self.without[index].add(dt_s, f64::from(u8::from(without)), memory_s);
            }
        }
    }

    /// Share of the latest braking during which a wheelset had no pressing force.
    pub fn share(&self, wheelset: usize) -> Option<f64> {
        self.without[wheelset].mean(5.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wheelset_without_pressure_is_told_from_one_that_is_vented() {
        let mut isolation = Isolation::default();
        (0..2000).for_each(|_| isolation.add(0.01, &[40e3, 0.0], 0, 2e3, 120.0));
        assert_eq!((isolation.share(0), isolation.share(1)), (Some(0.0), Some(1.0)));
        let mut isolation = Isolation::default();
        (0..2000).for_each(|_| isolation.add(0.01, &[40e3, 0.0], 0b10, 2e3, 120.0));
        assert_eq!(isolation.share(1), None, "slide protection vents it");
        (0..2000).for_each(|_| isolation.add(0.01, &[0.0, 0.0], 0, 2e3, 120.0));
        assert_eq!(isolation.share(1), None, "nobody brakes");
    }
}
