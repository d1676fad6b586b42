//! What a load sensor (pressure of the air springs, axle load) says about the mass.
//!
//! Its error stays as long as the load does: a thousand readings of one load know no more about it than one that is free of noise.
//! So their mean counts once, and again from the prior when the load has changed.

/// Readings are averaged over this time before they count, s.
const WINDOW_S: f64 = 5.0;
/// Mass over that of the vehicle file which a reading may have: beyond, it is no mass of this wagon.
const POSSIBLE: std::ops::RangeInclusive<f64> = 0.2..=5.0;

/// Readings of the present load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LoadSensor {
    /// Mean over what the vehicle file says.
    mean: f64,
    /// Time over which it was taken, s.
    seen_s: f64,
    /// The mean that counted; 0: none has.
    told: f64,
}

impl LoadSensor {
    /// Numbers that [`Self::save`] gives.
    pub(super) const SAVED: usize = 3;

    pub(super) const fn save(&self) -> [f64; Self::SAVED] {
        [self.mean, self.seen_s, self.told]
    }

    pub(super) fn load(saved: &[f64]) -> Self {
        Self { mean: saved[0], seen_s: saved[1], told: saved[2] }
    }

    /// Takes a reading over the mass of the file; gives the mean when it counts. A reading that no mass of this wagon gives says
    /// nothing. `apart`: means that differ by more are of another load.
    pub(super) fn take(&mut self, reading: f64, apart: f64, dt_s: f64) -> Option<f64> {
        if !POSSIBLE.contains(&reading) {
            return None;
        }
        let share = dt_s / (dt_s + self.seen_s.min(WINDOW_S));
        self.mean += share * (reading - self.mean);
        self.seen_s += dt_s;
        if self.seen_s < WINDOW_S {
            return None;
        }
        if self.told == 0.0 {
            self.told = self.mean;
            return Some(self.mean);
        }
        if (self.mean - self.told).abs() > apart {
            *self = Self::default();
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_counts_once_and_another_one_again() {
        let mut sensor = LoadSensor::default();
        let mut told = Vec::new();
        for step in 0..4000 {
            let load = if step < 2000 { 1.2 } else { 0.9 };
            let noise = if step % 2 == 0 { 0.03 } else { -0.03 };
            told.extend(sensor.take(load + noise, 0.03, 0.01));
        }
        assert_eq!(told.len(), 2, "{told:?}");
        assert!((told[0] - 1.2).abs() < 0.001 && (told[1] - 0.9).abs() < 0.001, "{told:?}");
        assert_eq!(LoadSensor::load(&sensor.save()), sensor);
    }

    #[test]
    fn what_is_no_load_says_nothing() {
        let mut sensor = LoadSensor::default();
        for reading in [f64::NAN, f64::INFINITY, -1.0, 0.0, 6.0] {
            assert_eq!(sensor.take(reading, 0.03, 2.0 * WINDOW_S), None);
        }
        assert_eq!(sensor, LoadSensor::default());
    }
}
