//! The height profile of a line.

use std::f64::consts::TAU;

use crate::random::Stream;

/// A mean slope, two waves and one ramp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    mean_rad: f64,
    waves: [(f64, f64, f64); 2],
    ramp: (f64, f64),
}

impl Line {
    /// Draws a line.
    #[must_use]
    pub fn draw(stream: &mut Stream) -> Self {
        let mut wave = |amplitude_rad: f64, low_m: f64, high_m: f64| {
            (amplitude_rad, TAU / stream.uniform(low_m, high_m), stream.uniform(0.0, TAU))
        };
        let waves = [wave(0.0015, 500.0, 1300.0), wave(0.0005, 150.0, 350.0)];
        let ramp = (stream.sign() * stream.uniform(0.0, 0.003), stream.uniform(100.0, 900.0));
        Self { mean_rad: stream.uniform(-0.005, 0.004), waves, ramp }
    }

    /// Slope at a place, rad, uphill positive.
    #[must_use]
    pub fn grade_rad(&self, position_m: f64) -> f64 {
        let wave =
            |(amplitude, number, phase): &(f64, f64, f64)| amplitude * (number * position_m + phase).sin();
        let (ramp_rad, from_m) = self.ramp;
        let climbed = ((position_m - from_m) / 60.0).clamp(0.0, 1.0);
        self.mean_rad + self.waves.iter().map(wave).sum::<f64>() + ramp_rad * climbed
    }
}
