//! What stands for the acoustic classifier in the experiments: it hears the true condition with a stated accuracy.
//!
//! Every window of 1 s gives one probability of "dry". It is a logistic function of a normal number whose mean lies on
//! the true side, so far from zero that the stated share of windows falls on that side. [`super::ear`] hears the rig's
//! noise by the product's own network instead.

use railgrip_filter::models::bogie_rig::RailListener;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// Length of a window, s: the paper's.
pub const WINDOW_S: f64 = 1.0;

/// Spread of the logit. Chosen: most windows are heard with a probability beyond 0.9.
const LOGIT_SIGMA: f64 = 1.8;

/// How the rig rolls at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Speed of the rollers' rim, m/s.
    pub v_m_s: f64,
    /// Slip of the wheelset that slips most.
    pub slip: f64,
    /// 0 dry to 1 wet.
    pub wetness: f64,
}

/// A listener beside the rig.
pub trait RigListener: RailListener {
    /// What there is to be heard at an instant, 100 times a second.
    fn pass(&mut self, moment: &Moment);
}

impl RigListener for SimulatedListener {
    fn pass(&mut self, moment: &Moment) {
        self.pass_dryness(if moment.wetness < 0.5 { 1.0 } else { 0.0 });
    }
}

/// A classifier of stated accuracy.
#[derive(Clone, Debug)]
pub struct SimulatedListener {
    accuracy: f64,
    random: Pcg64Mcg,
    window_ends_s: f64,
    dryness_sum: f64,
    instants: f64,
}

impl SimulatedListener {
    /// A listener that is right in a share `accuracy` of its windows.
    pub fn new(accuracy: f64, seed: u64) -> Self {
        let random = Pcg64Mcg::seed_from_u64(seed ^ 0x6865_6172);
        Self { accuracy, random, window_ends_s: WINDOW_S, dryness_sum: 0.0, instants: 0.0 }
    }

    /// The rail at an instant of the window: 1 dry, 0 wet.
    pub fn pass_dryness(&mut self, dryness: f64) {
        self.dryness_sum += dryness;
        self.instants += 1.0;
    }
}

impl RailListener for SimulatedListener {
    fn dry_probability(&mut self, time_s: f64) -> Option<f64> {
        if time_s + 1e-9 < self.window_ends_s || self.instants == 0.0 {
            return None;
        }
        let dryness = self.dryness_sum / self.instants;
        self.window_ends_s += WINDOW_S;
        self.dryness_sum = 0.0;
        self.instants = 0.0;
        let normal: f64 = StandardNormal.sample(&mut self.random);
        // A window that is half wet is as hard as it gets.
        let side = (2.0 * dryness - 1.0) * normal_quantile(self.accuracy);
        let logit = LOGIT_SIGMA * (side + normal);
        Some(1.0 / (1.0 + (-logit).exp()))
    }
}

/// Quantile of the standard normal law, by bisection of its cumulative function.
fn normal_quantile(share: f64) -> f64 {
    let (mut low, mut high) = (-6.0, 6.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if cumulative(middle) < share { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Cumulative function of the standard normal law, by Simpson's rule over its density.
fn cumulative(x: f64) -> f64 {
    const INTERVALS: usize = 64;
    let h = x / INTERVALS as f64;
    let density = |x: f64| (-0.5 * x * x).exp();
    let inner: f64 = (1..INTERVALS).map(|k| density(k as f64 * h) * if k % 2 == 1 { 4.0 } else { 2.0 }).sum();
    0.5 + h / 3.0 * (density(0.0) + inner + density(x)) / (2.0 * std::f64::consts::PI).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hears_with_its_accuracy() {
        assert!((normal_quantile(0.95) - 1.644_85).abs() < 1e-3);
        for accuracy in [0.8, 0.95] {
            let mut listener = SimulatedListener::new(accuracy, 3);
            let mut right = 0.0;
            for window in 0..4000 {
                let dryness = f64::from(window % 2);
                listener.pass_dryness(dryness);
                let heard = listener.dry_probability(f64::from(window + 1)).unwrap();
                right += f64::from(u8::from((heard > 0.5) == (dryness > 0.5))) / 4000.0;
            }
            println!("accuracy {accuracy}: right in {right:.4}");
            assert!((right - accuracy).abs() < 0.02);
        }
    }
}
