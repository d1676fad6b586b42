//! The speed of one wheelset over the angle through which it has turned: what comes again with every turn is of the wheel.
//!
//! A flat spot makes the rolling radius smaller for a small part of each turn, and the speed larger. Each sample gives its
//! deviation from the smoothed speed, `x = ω/ω̂ − 1`. The share of it that repeats is a Fourier series in the angle `φ = ∫ω dt`,
//! `x = Σ aₙ cos nφ + bₙ sin nφ`, whose coefficients are fading means of `2 x cos nφ` and `2 x sin nφ`. Orders from
//! [`FIRST_ORDER`] on count: the first is that of an encoder or wheel that is off its centre.

use bytemuck::{Pod, Zeroable};

/// The first order that counts.
const FIRST_ORDER: usize = 2;
/// How many orders count.
const ORDERS: usize = 5;
/// Slower than this the speed is too rough, and creepage has no meaning, m/s.
const SLOWEST_M_S: f64 = 5.0;
/// A turn needs so many samples for its highest order, rad a sample.
const LARGEST_STEP_RAD: f64 = 1.0;
/// Time constant of the smoothed speed, s; a constant acceleration leaves no error in it.
const SMOOTHING_S: f64 = 0.5;
/// After a slide, a gap or a start the smoothed speed needs so long, s.
const SETTLING_S: f64 = 4.0;
/// Larger deviations are no roundness, but a slide or a bad value.
const LARGEST_DEVIATION: f64 = 0.02;
/// Fewer turns than this say nothing.
const LEAST_TURNS: f64 = 300.0;
/// Samples for one that says something new: the smoothed speed ties neighbours together.
const SAMPLES_FOR_ONE: f64 = 2.0;

/// What is known of the roundness of a wheelset.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(crate) struct Roundness {
    /// Smoothed speed, rad/s, and its rate, rad/s².
    smooth_rad_s: f64,
    rate_rad_s2: f64,
    /// Angle since the start, rad, below one turn.
    angle_rad: f64,
    /// Rolling without a disturbance for so long, s.
    settled_s: f64,
    /// Fading numbers of samples and of turns.
    samples: f64,
    turns: f64,
    /// Fading sum of `x²`.
    square: f64,
    /// Fading sums of `x cos nφ` and `x sin nφ`.
    cosine: [f64; ORDERS],
    sine: [f64; ORDERS],
}

/// RMS variation of the speed over a turn, as a share of the speed, with the ends of its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Variation {
    pub value: f64,
    pub low: f64,
    pub high: f64,
    /// Turns behind it.
    pub turns: f64,
}

impl Roundness {
    /// Takes in the speed of the wheelset that holds for `dt_s`; `None` where it is missing. `rolls` says that it neither slides
    /// nor is protected from sliding.
    pub fn add(&mut self, dt_s: f64, wheel_speed_rad_s: Option<f64>, v_m_s: f64, rolls: bool, memory_s: f64) {
        let Some(speed_rad_s) = wheel_speed_rad_s.filter(|speed| speed.is_finite()) else {
            self.turn(self.smooth_rad_s * dt_s);
            self.settled_s = 0.0;
            return;
        };
        self.turn(speed_rad_s * dt_s);
        let expected_rad_s = self.smooth_rad_s + self.rate_rad_s2 * dt_s;
        if self.settled_s == 0.0 {
            (self.smooth_rad_s, self.rate_rad_s2) = (speed_rad_s, 0.0);
        } else {
            // An alpha-beta filter, critically damped: it follows a ramp without lag.
            let alpha = (2.0 * dt_s / SMOOTHING_S).min(1.0);
            let wrong_rad_s = speed_rad_s - expected_rad_s;
            self.smooth_rad_s = expected_rad_s + alpha * wrong_rad_s;
            self.rate_rad_s2 += 0.25 * alpha * alpha * wrong_rad_s / dt_s;
        }
        let step_rad = (speed_rad_s * dt_s).abs();
        self.settled_s = if rolls && v_m_s > SLOWEST_M_S && step_rad < LARGEST_STEP_RAD {
            self.settled_s + dt_s
        } else {
            0.0
        };
        let deviation = speed_rad_s / expected_rad_s - 1.0;
        if self.settled_s >= SETTLING_S && deviation.abs() < LARGEST_DEVIATION {
            self.learn(deviation, step_rad, 1.0 - (dt_s / memory_s).min(1.0));
        }
    }

    fn turn(&mut self, step_rad: f64) {
        self.angle_rad = (self.angle_rad + step_rad).rem_euclid(std::f64::consts::TAU);
    }

    fn learn(&mut self, deviation: f64, step_rad: f64, keep: f64) {
        self.samples = keep * self.samples + 1.0;
        self.turns = keep * self.turns + step_rad / std::f64::consts::TAU;
        self.square = keep * self.square + deviation * deviation;
        for index in 0..ORDERS {
            let (sine, cosine) = ((FIRST_ORDER + index) as f64 * self.angle_rad).sin_cos();
            self.cosine[index] = keep * self.cosine[index] + deviation * cosine;
            self.sine[index] = keep * self.sine[index] + deviation * sine;
        }
    }

    /// Forgets the pattern: how far the wheelset has turned meanwhile is not known.
    pub fn lose(&mut self) {
        *self = Self::default();
    }

    /// The variation; `None` after too few turns.
    pub fn variation(&self) -> Option<Variation> {
        if self.turns < LEAST_TURNS {
            return None;
        }
        let power: f64 =
            self.cosine.iter().chain(&self.sine).map(|sum| (2.0 * sum / self.samples).powi(2)).sum();
        // Variance of one coefficient, from the scatter of all samples; it is part of the sum of their squares.
        let noise = 2.0 * self.square / self.samples * SAMPLES_FOR_ONE / self.samples;
        let count = 2.0 * ORDERS as f64;
        let repeated = power - count * noise;
        // Of a sum of squares of normal numbers: 2 s⁴ for each, and 4 s² times the sum of the squares of their means.
        let sigma = (2.0 * count * noise * noise + 4.0 * noise * repeated.max(0.0)).sqrt();
        let rms = |power: f64| (0.5 * power.max(0.0)).sqrt();
        let (low, high) = (rms(repeated - 1.96 * sigma), rms(repeated + 1.96 * sigma));
        Some(Variation { value: rms(repeated), low, high, turns: self.turns })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const DT_S: f64 = 0.01;
    const RADIUS_M: f64 = 0.44;
    /// Steps by which the wheel turns within a sample.
    const FINE: usize = 20;

    /// A wheel on its rail: its rolling radius by angle is the truth, the sensor adds white noise.
    struct Wheel {
        /// Length of a flat spot, m.
        flat_m: f64,
        /// Amplitude of the first order of the sensor, as an encoder has that is off its centre.
        eccentric: f64,
        angle_rad: f64,
        seed: u64,
    }

    impl Wheel {
        fn new(flat_m: f64, eccentric: f64) -> Self {
            Self { flat_m, eccentric, angle_rad: 0.0, seed: 7 }
        }

        /// Distance from the axle to the rail: over a chord the wheel is lower than over an arc.
        fn radius_m(&self) -> f64 {
            let half_rad = (0.5 * self.flat_m / RADIUS_M).asin();
            let from_middle = (self.angle_rad.rem_euclid(TAU) - 3.0).abs();
            if from_middle < half_rad { RADIUS_M * half_rad.cos() / from_middle.cos() } else { RADIUS_M }
        }

        fn noise(&mut self) -> f64 {
            // Twelve uniform numbers of a linear congruential generator make a normal one.
            let mut sum = -6.0;
            for _ in 0..12 {
                self.seed =
                    self.seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum += (self.seed >> 11) as f64 / (1u64 << 53) as f64;
            }
            sum
        }

        /// What the sensor says of the next sample at that speed.
        fn sample(&mut self, v_m_s: f64, sigma_rad_s: f64) -> f64 {
            let before = self.angle_rad;
            for _ in 0..FINE {
                self.angle_rad += v_m_s / self.radius_m() * DT_S / FINE as f64;
            }
            let speed_rad_s = (self.angle_rad - before) / DT_S;
            speed_rad_s * (1.0 + self.eccentric * self.angle_rad.sin()) + sigma_rad_s * self.noise()
        }
    }

    /// Rolls for so long, speeding up and slowing down between 15 and 25 m/s.
    fn roll(wheel: &mut Wheel, seconds: f64, sigma_rad_s: f64) -> Roundness {
        let mut round = Roundness::default();
        for step in 0..(seconds / DT_S) as usize {
            let v_m_s = 20.0 + 5.0 * (0.05 * step as f64 * DT_S).sin();
            let speed = wheel.sample(v_m_s, sigma_rad_s);
            round.add(DT_S, Some(speed), v_m_s, true, 300.0);
        }
        round
    }

    #[test]
    fn a_flat_shows_and_a_round_wheel_does_not() {
        let mut seen = Vec::new();
        for (flat_mm, eccentric) in
            [(0.0, 0.0), (0.0, 3e-3), (40.0, 0.0), (80.0, 0.0), (120.0, 0.0), (160.0, 3e-3)]
        {
            let found = roll(&mut Wheel::new(1e-3 * flat_mm, eccentric), 300.0, 0.05).variation().unwrap();
            println!(
                "flat of {flat_mm:3} mm, encoder {eccentric}: {:.2} per mille ({:.2} to {:.2}) over {:.0} turns",
                1e3 * found.value,
                1e3 * found.low,
                1e3 * found.high,
                found.turns
            );
            seen.push(found);
        }
        for round in &seen[..2] {
            assert!(round.low == 0.0 && round.high < 2e-4, "a round wheel: {round:?}");
        }
        assert!(seen[3].low > 0.0 && seen[4].low > seen[3].value, "larger flats show more: {seen:?}");
        assert!(seen[5].low > 4e-4, "an eccentric encoder hides no flat: {:?}", seen[5]);
    }

    #[test]
    fn the_interval_holds_the_truth_without_noise() {
        for flat_mm in [80.0, 120.0] {
            let truth = roll(&mut Wheel::new(1e-3 * flat_mm, 0.0), 300.0, 0.0).variation().unwrap().value;
            let held = (0..20).filter(|seed| {
                let mut wheel = Wheel { seed: 1000 + seed, ..Wheel::new(1e-3 * flat_mm, 0.0) };
                let found = roll(&mut wheel, 300.0, 0.05).variation().unwrap();
                (found.low..=found.high).contains(&truth)
            });
            let held = held.count();
            println!("flat of {flat_mm} mm: truth {:.3} per mille, in {held} of 20 intervals", 1e3 * truth);
            assert!(held >= 17);
        }
    }

    #[test]
    fn slides_and_gaps_teach_nothing() {
        let mut round = Roundness::default();
        for step in 0..30_000 {
            let slides = step % 300 < 50;
            let speed = if slides { 30.0 } else { 45.0 };
            round.add(DT_S, Some(speed), 20.0, !slides, 300.0);
        }
        assert_eq!(round.variation(), None, "it never rolls for {SETTLING_S} s");
        let mut wheel = Wheel::new(0.12, 0.0);
        let mut round = roll(&mut wheel, 300.0, 0.05);
        assert!(round.variation().is_some());
        round.lose();
        assert_eq!(round.variation(), None);
        (0..100).for_each(|_| round.add(DT_S, None, 20.0, true, 300.0));
        assert_eq!(round, Roundness::default());
    }
}
