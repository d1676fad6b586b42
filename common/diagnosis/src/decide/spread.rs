//! How far fitted values lie from the true ones beyond what noise explains, because a law of the plant has another form.

use crate::answer::schema::{Interval, ParameterEstimate};
use railgrip_vehicle::effects::ParameterSpec;
use serde::{Deserialize, Serialize};

/// Normal quantiles of two-sided 95 % and 90 % intervals.
const NORMAL_95: f64 = 1.96;
const NORMAL_90: f64 = 1.645;
/// Share of the true values that their 90 % intervals hold.
const HELD: f64 = 0.9;

/// Standard error of values that is not noise: of the logarithm of the distance between a value and that at which its parameter does
/// nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Which cases that was learnt from.
    pub provenance: String,
    /// Of sizes: forces, angles, shares, speeds.
    pub sizes: Share,
    /// Of times: smoothing of another form does as much with quite another time.
    pub times: Share,
}

/// A standard error, and the number of true values from which it was learnt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Share {
    /// Standard error of the logarithm of the value.
    pub of_value: f64,
    /// Number of true values.
    pub values: usize,
}

/// A fitted value whose true one is known.
#[derive(Clone, Copy, Debug)]
pub struct Judged {
    /// Fitted value, with its interval by noise.
    pub estimate: ParameterEstimate,
    /// Its parameter.
    pub spec: &'static ParameterSpec,
    /// True value.
    pub truth: f64,
}

impl Judged {
    /// Whether the 90 % interval holds the truth.
    pub fn is_held(&self) -> bool {
        let ParameterEstimate { value, ci95, .. } = self.estimate;
        let [low, high] = ci95.map(|end| value + NORMAL_90 / NORMAL_95 * (end - value));
        (low..=high).contains(&self.truth)
    }

    /// The least standard error with which the 90 % interval holds the truth; not a number of a value at which nothing is done.
    fn share_needed(&self) -> f64 {
        let ParameterEstimate { value, ci95, by_noise } = self.estimate;
        let [low, high] = by_noise.unwrap_or(ci95);
        let off = self.truth - value;
        let half = if off < 0.0 { value - low } else { high - value };
        // Of the 95 % interval, which a 90 % interval is a fixed part of.
        let beyond = ((NORMAL_95 / NORMAL_90 * off).powi(2) - half.powi(2)).max(0.0).sqrt();
        let size = size(value, self.spec);
        if size == 0.0 {
            return f64::NAN;
        }
        let is_farther = off * (value - neutral(self.spec)) > 0.0;
        let factor = if is_farther { 1.0 + beyond / size } else { (1.0 - beyond / size).max(0.0) };
        factor.ln().abs() / NORMAL_95
    }
}

impl Share {
    /// The least one with which intervals hold nine of ten true values, one more than these among them (split conformal
    /// prediction; Lei et al. 2018, algorithm 2). Of fewer than nine the widest stands.
    fn fit(judged: &[&Judged]) -> Self {
        let needed = judged.iter().map(|one| one.share_needed());
        let mut needed: Vec<f64> = needed.filter(|share| !share.is_nan()).collect();
        needed.sort_by(f64::total_cmp);
        let rank = ((needed.len() + 1) as f64 * HELD).ceil() as usize;
        let of_value = needed.get(rank - 1).or(needed.last()).copied().unwrap_or(0.0);
        Self { of_value, values: needed.len() }
    }
}

impl Spread {
    /// Learns from values whose true ones are known.
    pub fn fit(judged: &[Judged], provenance: String) -> Self {
        let (times, sizes): (Vec<&Judged>, Vec<&Judged>) = judged.iter().partition(|one| is_time(one.spec));
        Self { provenance, sizes: Share::fit(&sizes), times: Share::fit(&times) }
    }

    /// Gives an estimate the interval that noise and this spread make together. One without an interval by noise was chosen or is known
    /// otherwise, and stays.
    pub fn widen(&self, estimate: &mut ParameterEstimate, spec: &ParameterSpec) {
        let Some(by_noise) = estimate.by_noise else { return };
        estimate.ci95 = self.around(estimate.value, by_noise, spec);
    }

    fn around(&self, value: f64, [low, high]: Interval, spec: &ParameterSpec) -> Interval {
        let share = if is_time(spec) { self.times } else { self.sizes };
        // A factor either way: what is certainly at work is never nothing.
        let [nearer, farther] = [-1.0, 1.0]
            .map(|sign: f64| size(value, spec) * ((sign * NORMAL_95 * share.of_value).exp() - 1.0).abs());
        let [below, above] = if value < neutral(spec) { [farther, nearer] } else { [nearer, farther] };
        // What noise alone already carries beyond the range stays.
        let within = |end: f64| end.clamp(spec.lower.min(low), spec.upper.max(high));
        [within(value - (low - value).hypot(below)), within(value + (high - value).hypot(above))]
    }
}

/// Distance from where a parameter does nothing.
fn size(value: f64, spec: &ParameterSpec) -> f64 {
    (value - neutral(spec)).abs()
}

fn neutral(spec: &ParameterSpec) -> f64 {
    spec.neutral.unwrap_or(0.0)
}

fn is_time(spec: &ParameterSpec) -> bool {
    spec.unit == "s"
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    const SIZE: ParameterSpec = ParameterSpec { lower: 0.0, upper: 10.0, ..ParameterSpec::PLAIN };
    const TIME: ParameterSpec = ParameterSpec { unit: "s", ..SIZE };

    fn judged(spec: &'static ParameterSpec, truth: f64, value: f64, half: f64) -> Judged {
        let by_noise = [value - half, value + half];
        let estimate = ParameterEstimate { value, ci95: by_noise, by_noise: Some(by_noise) };
        Judged { estimate, spec, truth }
    }

    /// Sizes that lie off by up to a fifth and times by up to a half, far beyond their noise: what is learnt from some holds nine
    /// of ten others of either kind.
    #[test]
    fn intervals_hold_nine_of_ten_values_of_laws_of_another_form() {
        let mut random = Pcg64Mcg::seed_from_u64(5);
        let mut some = |number: usize, spec: &'static ParameterSpec, off: f64| -> Vec<Judged> {
            let one = |_| {
                let truth = 1.0 + 3.0 * random.random::<f64>();
                judged(spec, truth, truth * (1.0 + off * (2.0 * random.random::<f64>() - 1.0)), 0.01)
            };
            (0..number).map(one).collect()
        };
        let spread = Spread::fit(&[some(60, &SIZE, 0.2), some(60, &TIME, 0.5)].concat(), String::new());
        for others in [some(2000, &SIZE, 0.2), some(2000, &TIME, 0.5)] {
            let held = others.into_iter().filter(|judged| {
                let mut widened = *judged;
                spread.widen(&mut widened.estimate, widened.spec);
                widened.is_held()
            });
            let share = held.count() as f64 / 2000.0;
            println!("{spread:?}: {share:.3} of 2000 others held");
            assert!((0.84..0.96).contains(&share), "{share}");
        }
        assert_eq!((spread.sizes.values, spread.times.values), (60, 60));
    }

    #[test]
    fn noise_that_explains_all_needs_no_spread_and_of_few_values_the_widest_stands() {
        let of = |judged: &[Judged]| Spread::fit(judged, String::new()).sizes;
        assert_eq!(of(&[judged(&SIZE, 1.0, 1.1, 1.0); 20]).of_value, 0.0);
        assert_eq!(of(&[]), Share::default());
        let few = of(&[judged(&SIZE, 1.0, 2.0, 0.0), judged(&SIZE, 1.0, 1.1, 0.0)]);
        let factor: f64 = 1.0 - 0.5 * NORMAL_95 / NORMAL_90;
        assert!((few.of_value - factor.ln().abs() / NORMAL_95).abs() < 1e-12, "{few:?}");
        // A value at which the parameter does nothing has no share.
        assert_eq!(of(&[judged(&SIZE, 1.0, 0.0, 0.0); 9]).values, 0);
    }

    #[test]
    fn intervals_end_at_the_range_and_what_was_chosen_has_none() {
        let spread = Spread { sizes: Share { of_value: 0.5, values: 9 }, ..Spread::default() };
        let mut wide = judged(&SIZE, 8.0, 8.0, 0.1).estimate;
        spread.widen(&mut wide, &SIZE);
        assert_eq!(wide.ci95[1], 10.0);
        let nearer = 8.0 * (1.0 - (-0.5 * NORMAL_95).exp());
        assert!(
            (wide.ci95[0] - (8.0 - 0.1_f64.hypot(nearer))).abs() < 1e-12 && wide.ci95[0] > 0.0,
            "{wide:?}"
        );
        let mut chosen = ParameterEstimate { value: 2.0, ci95: [2.0, 2.0], by_noise: None };
        spread.widen(&mut chosen, &SIZE);
        assert_eq!(chosen.ci95, [2.0, 2.0]);
    }
}
