//! Means of correlated estimates with honest intervals, and shares over a fading memory.

use bytemuck::{Pod, Zeroable};

/// Sample weight is 1 / (σ² + this²): estimates of equal certainty count by their duration.
const SIGMA_FLOOR: f64 = 0.01;
/// Correlation of neighbouring blocks is taken as at least this: filters and pads both remember.
const LEAST_CORRELATION: f64 = 0.3;
/// And at most this, so that an interval stays finite.
const MOST_CORRELATION: f64 = 0.95;

/// Mean of a slowly varying quantity whose estimates are correlated in time.
///
/// Estimates are first averaged over blocks as long as their correlation (inside a block nothing is gained by
/// averaging). The variance of the mean of the blocks is the larger of their scatter and their own declared variance,
/// times (1 + ρ)/(1 − ρ) for the correlation ρ of neighbouring blocks, over the effective number of blocks
/// (batch means; Kish's effective number for weights).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(crate) struct BlockMean {
    /// Seconds in all blocks and the open one, without fading.
    pub seconds: f64,
    open: Block,
    last: f64,
    weight: f64,
    weight_squared: f64,
    first: f64,
    second: f64,
    variance: f64,
    lagged: f64,
    lagged_weight: f64,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
struct Block {
    seconds: f64,
    weight: f64,
    value: f64,
    variance: f64,
}

impl Block {
    const fn mean(&self) -> f64 {
        self.value / self.weight
    }

    const fn mean_variance(&self) -> f64 {
        self.variance / self.weight
    }
}

/// A mean with its 1 σ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mean {
    pub value: f64,
    pub sigma: f64,
    /// Half the 95 % interval.
    pub half_width: f64,
}

impl BlockMean {
    /// Takes in an estimate that holds for `dt_s`.
    pub fn add(&mut self, dt_s: f64, value: f64, sigma: f64, block_s: f64, memory_s: f64) {
        let weight = dt_s / (sigma * sigma + SIGMA_FLOOR * SIGMA_FLOOR);
        if !(weight.is_finite() && value.is_finite()) || weight <= 0.0 {
            return;
        }
        self.seconds += dt_s;
        self.open.seconds += dt_s;
        self.open.weight += weight;
        self.open.value += weight * value;
        self.open.variance += weight * sigma * sigma;
        if self.open.seconds >= block_s {
            self.close(memory_s);
        }
    }

    fn close(&mut self, memory_s: f64) {
        let block = std::mem::take(&mut self.open);
        let keep = (-block.seconds / memory_s).exp();
        let (mean, variance) = (block.mean(), block.mean_variance());
        if self.weight > 0.0 {
            self.lagged = keep * self.lagged + block.weight * mean * self.last;
            self.lagged_weight = keep * self.lagged_weight + block.weight;
        }
        self.weight = keep * self.weight + block.weight;
        self.weight_squared = keep * keep * self.weight_squared + block.weight * block.weight;
        self.first = keep * self.first + block.weight * mean;
        self.second = keep * self.second + block.weight * mean * mean;
        self.variance = keep * self.variance + block.weight * variance;
        self.last = mean;
    }

    /// The mean; an open block counts by its weight. `None` before anything came.
    pub fn mean(&self) -> Option<Mean> {
        let weight = self.weight + self.open.weight;
        if weight <= 0.0 {
            return None;
        }
        let value = (self.first + self.open.value) / weight;
        let declared = (self.variance + self.open.variance) / weight;
        let open_second = if self.open.weight > 0.0 { self.open.value * self.open.mean() } else { 0.0 };
        let scatter = ((self.second + open_second) / weight - value * value).max(0.0);
        let number = weight * weight / (self.weight_squared + self.open.weight * self.open.weight);
        let correlation = self.correlation(value, scatter, number);
        let effective = (number * (1.0 - correlation) / (1.0 + correlation)).max(1.0);
        // The scatter of few blocks underestimates: n / (n − 1).
        let scatter = if number > 1.5 { scatter * number / (number - 1.0) } else { 0.0 };
        let sigma = (declared.max(scatter) / effective).sqrt();
        let quantile = if scatter > declared { student_975(number - 1.0) } else { 1.96 };
        Some(Mean { value, sigma, half_width: quantile * sigma })
    }

    fn correlation(&self, mean: f64, scatter: f64, number: f64) -> f64 {
        if number < 4.0 || scatter <= 0.0 || self.lagged_weight <= 0.0 {
            return 0.5;
        }
        let lagged = self.lagged / self.lagged_weight - mean * mean;
        (lagged / scatter).clamp(LEAST_CORRELATION, MOST_CORRELATION)
    }
}

/// 97.5 % quantile of Student's t, linear in 1/dof between the entries of the usual table.
fn student_975(dof: f64) -> f64 {
    const TABLE: [(f64, f64); 8] = [
        (1.0, 12.706),
        (2.0, 4.303),
        (3.0, 3.182),
        (4.0, 2.776),
        (6.0, 2.447),
        (10.0, 2.228),
        (30.0, 2.042),
        (f64::INFINITY, 1.96),
    ];
    let dof = dof.max(1.0);
    let above = TABLE.iter().position(|(entry, _)| *entry >= dof).unwrap_or(TABLE.len() - 1).max(1);
    let ((dof_low, t_low), (dof_high, t_high)) = (TABLE[above - 1], TABLE[above]);
    let share = (1.0 / dof_low - 1.0 / dof) / (1.0 / dof_low - 1.0 / dof_high);
    t_low + share * (t_high - t_low)
}

/// Mean of a quantity over a fading memory, weighted by time.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(crate) struct FadingMean {
    sum: f64,
    seconds: f64,
}

impl FadingMean {
    pub fn add(&mut self, dt_s: f64, value: f64, memory_s: f64) {
        let keep = 1.0 - (dt_s / memory_s).min(1.0);
        self.sum = keep * self.sum + dt_s * value;
        self.seconds = keep * self.seconds + dt_s;
    }

    /// The mean, if it stands on at least so many seconds.
    pub fn mean(&self, least_s: f64) -> Option<f64> {
        (self.seconds >= least_s && self.seconds > 0.0).then(|| self.sum / self.seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform noise of variance 1/12, seeded (xorshift).
    struct Noise(u64);

    impl Noise {
        fn next(&mut self) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        }

        fn normal(&mut self) -> f64 {
            (0..12).map(|_| self.next()).sum()
        }
    }

    #[test]
    fn quantiles_of_student_are_right() {
        for (dof, expected) in
            [(1.0, 12.706), (2.0, 4.303), (3.0, 3.182), (5.0, 2.571), (10.0, 2.228), (30.0, 2.042)]
        {
            let found = student_975(dof);
            assert!((found / expected - 1.0).abs() < 0.03, "{dof}: {found} against {expected}");
        }
    }

    /// Estimates whose error has a correlation time of 5 s, as a filter makes them: the interval must hold the truth
    /// about 95 % of the time, and must not be hopelessly wide.
    #[test]
    fn intervals_of_correlated_estimates_hold_the_truth() {
        let (truth, sigma, dt, tau): (f64, f64, f64, f64) = (0.33, 0.01, 0.01, 5.0);
        let decay = (-dt / tau).exp();
        let (runs, mut held, mut width) = (400, 0, 0.0);
        let mut noise = Noise(0x9e37_79b9_7f4a_7c15);
        for _ in 0..runs {
            let mut statistic = BlockMean::default();
            let mut error = sigma * noise.normal();
            for _ in 0..6000 {
                error = decay * error + sigma * (1.0 - decay * decay).sqrt() * noise.normal();
                statistic.add(dt, truth + error, sigma, 5.0, 120.0);
            }
            let mean = statistic.mean().unwrap();
            held += usize::from((mean.value - truth).abs() <= mean.half_width);
            width += mean.half_width / f64::from(runs);
        }
        let share = held as f64 / f64::from(runs);
        println!(
            "60 s of braking: interval held the truth {share:.3}, half width {width:.4} (one estimate: {:.4})",
            1.96 * sigma
        );
        assert!((0.90..=0.999).contains(&share), "{share}");
        assert!(width < 1.0 * 1.96 * sigma, "{width}");
    }

    #[test]
    fn one_block_is_as_uncertain_as_its_estimates() {
        let mut statistic = BlockMean::default();
        for _ in 0..300 {
            statistic.add(0.01, 0.3, 0.02, 5.0, 120.0);
        }
        let mean = statistic.mean().unwrap();
        assert!((mean.value - 0.3).abs() < 1e-12 && (mean.sigma - 0.02).abs() < 1e-9, "{mean:?}");
        assert!((statistic.seconds - 3.0).abs() < 1e-9);
    }

    #[test]
    fn uncertain_estimates_and_nonsense_do_not_disturb() {
        let mut statistic = BlockMean::default();
        for _ in 0..1000 {
            statistic.add(0.01, 0.3, 0.005, 5.0, 120.0);
            statistic.add(0.01, 0.5, 0.3, 5.0, 120.0);
            statistic.add(0.01, f64::NAN, 0.005, 5.0, 120.0);
        }
        let mean = statistic.mean().unwrap();
        assert!((mean.value - 0.3).abs() < 0.001, "{mean:?}");
    }

    #[test]
    fn a_fading_mean_forgets() {
        let mut share = FadingMean::default();
        assert_eq!(share.mean(1.0), None);
        for _ in 0..1000 {
            share.add(0.1, 1.0, 10.0);
        }
        assert!((share.mean(1.0).unwrap() - 1.0).abs() < 1e-12);
        for _ in 0..1000 {
            share.add(0.1, 0.0, 10.0);
        }
        assert!(share.mean(1.0).unwrap() < 1e-4);
    }
}
