//! What is believed about the adhesion that the rail offers: probabilities on a grid of peak adhesion.
//!
//! A Bayes filter on a histogram. Two kinds of evidence exist, and neither needs the creep law:
//! * while a wheelset slides, the adhesion utilised *is* about the adhesion available:
//!   the likelihood is a normal density around the peak;
//! * while it rolls, the adhesion available is at least what is utilised: the likelihood is Φ((peak − utilised)/σ).
//!
//! Without news the belief fades to the prior. The classes dry, wet, low and very low are ranges of peak adhesion; their
//! borders lie between the levels that the vehicle file gives for the rail.

use bytemuck::{Pod, Zeroable};

/// Cells of the grid, evenly spaced in the logarithm of peak adhesion.
pub const CELLS: usize = 48;
/// Peak adhesion of the first cell.
const LOWEST: f64 = 0.008;
/// Peak adhesion of the last cell.
const HIGHEST: f64 = 0.60;
/// Utilised over peak adhesion in a slide: a little less than 1, because friction falls beyond the peak.
const SLIDE_SHARE: f64 = 0.97;
/// 1 σ of that share, with the scatter of rails.
const SLIDE_SHARE_SIGMA: f64 = 0.08;
/// Evidence closer than this says the same thing twice, s; each update counts by its share of it.
const INDEPENDENT_S: f64 = 0.5;
/// Classes: dry, wet, low, very low.
pub const CLASSES: usize = 4;

/// Probabilities of peak adhesion.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Belief {
    probability: [f64; CELLS],
}

/// What does not change: grid, classes and prior.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rail {
    peak: [f64; CELLS],
    class: [usize; CELLS],
    prior: [f64; CELLS],
    memory_s: f64,
}

/// What a moment says about the adhesion available.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Adhesion utilised, magnitude.
    pub utilised: f64,
    /// Its 1 σ.
    pub sigma: f64,
    /// True if the wheelset slides or spins.
    pub sliding: bool,
}

impl Rail {
    /// Classes around the levels `[dry, wet, low]` of a vehicle file, with the probability of dry rail before anything
    /// is known; wet, low and very low rail share the rest 25 : 12 : 3.
    #[must_use]
    pub fn new(levels: [f64; 3], prior_dry: f64, memory_s: f64) -> Self {
        let borders = [(levels[0] * levels[1]).sqrt(), (levels[1] * levels[2]).sqrt(), 0.5 * levels[2]];
        let share = |part: f64| (1.0 - prior_dry) * part / 40.0;
        let class_prior = [prior_dry, share(25.0), share(12.0), share(3.0)];
        let step = (HIGHEST / LOWEST).ln() / (CELLS - 1) as f64;
        let peak: [f64; CELLS] = std::array::from_fn(|cell| LOWEST * (step * cell as f64).exp());
        let class = peak.map(|peak| borders.iter().filter(|border| peak < **border).count());
        let mut prior = [0.0; CELLS];
        for cell in 0..CELLS {
            let cells = class.iter().filter(|other| **other == class[cell]).count();
            prior[cell] = class_prior[class[cell]] / cells as f64;
        }
        let total: f64 = prior.iter().sum();
        prior.iter_mut().for_each(|p| *p /= total);
        Self { peak, class, prior, memory_s }
    }
}

impl Belief {
    /// Nothing is known but the prior.
    #[must_use]
    pub const fn prior(rail: &Rail) -> Self {
        Self { probability: rail.prior }
    }

    /// Lets `elapsed_s` pass and takes in what it said.
    pub fn update(&mut self, rail: &Rail, elapsed_s: f64, evidence: Option<Evidence>) {
        let fade = 1.0 - (-elapsed_s / rail.memory_s).exp();
        let weight = (elapsed_s / INDEPENDENT_S).min(1.0);
        let mut total = 0.0;
        for cell in 0..CELLS {
            let faded = (1.0 - fade) * self.probability[cell] + fade * rail.prior[cell];
            let likelihood = evidence.map_or(1.0, |evidence| likelihood(rail.peak[cell], evidence));
            self.probability[cell] = faded * likelihood.powf(weight);
            total += self.probability[cell];
        }
        if total > 1e-300 {
            self.probability.iter_mut().for_each(|p| *p /= total);
        } else {
            *self = Self::prior(rail);
        }
    }

    /// Probability of dry, wet, low and very low rail.
    #[must_use]
    pub fn classes(&self, rail: &Rail) -> [f64; CLASSES] {
        let mut classes = [0.0; CLASSES];
        for (probability, class) in self.probability.iter().zip(rail.class) {
            classes[class] += probability;
        }
        classes
    }

    /// Peak adhesion below which it lies with probability `share`.
    #[must_use]
    pub fn quantile(&self, rail: &Rail, share: f64) -> f64 {
        let mut sum = 0.0;
        for (probability, peak) in self.probability.iter().zip(rail.peak) {
            sum += probability;
            if sum >= share {
                return peak;
            }
        }
        HIGHEST
    }

    /// The probabilities, for whoever keeps them.
    #[must_use]
    pub const fn probabilities(&self) -> &[f64; CELLS] {
        &self.probability
    }

    /// Probabilities that were kept, up to rounding; `None` if they are none.
    #[must_use]
    pub fn of(mut probability: [f64; CELLS]) -> Option<Self> {
        let sum: f64 = probability.iter().sum();
        if !(0.99..1.01).contains(&sum) {
            return None;
        }
        probability.iter_mut().for_each(|p| *p /= sum);
        Some(Self { probability }).filter(Self::is_valid)
    }

    /// True if these are probabilities; what a snapshot brings may be anything.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let sum: f64 = self.probability.iter().sum();
        self.probability.iter().all(|p| (0.0..=1.0).contains(p)) && (sum - 1.0).abs() < 1e-6
    }
}

fn likelihood(peak: f64, evidence: Evidence) -> f64 {
    if evidence.sliding {
        let sigma = evidence.sigma.hypot(SLIDE_SHARE_SIGMA * peak);
        let z = (evidence.utilised - SLIDE_SHARE * peak) / sigma;
        // The floor keeps one surprising moment from ruling everything out.
        (-0.5 * z * z).exp() / sigma + 1e-6
    } else {
        let sigma = evidence.sigma.hypot(0.02 * peak);
        normal_cdf((peak - evidence.utilised) / sigma) + 1e-6
    }
}

/// Φ, to 1e-5 (Abramowitz & Stegun 26.2.17).
fn normal_cdf(z: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * z.abs());
    let series = [0.319_381_530, -0.356_563_782, 1.781_477_937, -1.821_255_978, 1.330_274_429]
        .iter()
        .rev()
        .fold(0.0, |sum, c| t * (c + sum));
    let upper = (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt() * series;
    if z >= 0.0 { 1.0 - upper } else { upper }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rail() -> Rail {
        Rail::new([0.30, 0.12, 0.06], 0.6, 60.0)
    }

    fn after(seconds: f64, utilised: f64, sliding: bool) -> Belief {
        let rail = rail();
        let mut belief = Belief::prior(&rail);
        for _ in 0..(seconds * 10.0) as usize {
            belief.update(&rail, 0.1, Some(Evidence { utilised, sigma: 0.003, sliding }));
        }
        assert!(belief.is_valid());
        belief
    }

    #[test]
    fn the_normal_integral_is_right() {
        for (z, expected) in [(0.0, 0.5), (1.0, 0.841_344_7), (-1.959_964, 0.025), (3.0, 0.998_650_1)] {
            assert!((normal_cdf(z) - expected).abs() < 1e-5, "{z}");
        }
    }

    #[test]
    fn a_slide_names_the_class_within_two_seconds() {
        for (utilised, class) in [(0.29, 0), (0.115, 1), (0.055, 2), (0.02, 3)] {
            let classes = after(2.0, utilised, true).classes(&rail());
            println!("sliding at {utilised}: {classes:.3?}");
            assert!(classes[class] > 0.9, "sliding at {utilised}: {classes:?}");
        }
    }

    #[test]
    fn rolling_only_bounds_from_below() {
        let classes = after(5.0, 0.10, false).classes(&rail());
        println!("rolling at 0.10: {classes:.3?}");
        assert!(classes[2] + classes[3] < 0.02 && classes[0] > 0.5 && classes[1] > 0.1, "{classes:?}");
        let classes = after(5.0, 0.01, false).classes(&rail());
        assert!((classes[0] - 0.6).abs() < 0.05, "rolling gently says little: {classes:?}");
    }

    #[test]
    fn the_belief_fades_to_the_prior_and_follows_a_change() {
        let rail = rail();
        let mut belief = after(10.0, 0.055, true);
        for _ in 0..100 {
            belief.update(&rail, 0.1, Some(Evidence { utilised: 0.25, sigma: 0.003, sliding: false }));
        }
        assert!(belief.classes(&rail)[0] > 0.95, "{:?}", belief.classes(&rail));
        let mut belief = after(10.0, 0.055, true);
        for _ in 0..5000 {
            belief.update(&rail, 0.1, None);
        }
        assert!((belief.classes(&rail)[0] - 0.6).abs() < 0.01);
    }

    #[test]
    fn quantiles_hold_the_level_of_a_slide() {
        let belief = after(3.0, 0.055, true);
        let (low, high) = (belief.quantile(&rail(), 0.025), belief.quantile(&rail(), 0.975));
        println!("sliding at 0.055: {low:.4} to {high:.4}");
        assert!(low < 0.0575 && high > 0.055 && high < 0.08);
    }
}
