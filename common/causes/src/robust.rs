//! Small statistics that one wrong value does not spoil.

/// Median of what is a number; NaN of nothing. The order of `values` changes.
pub(crate) fn median(values: &mut Vec<f64>) -> f64 {
    values.retain(|value| value.is_finite());
    let count = values.len();
    if count == 0 {
        return f64::NAN;
    }
    values.sort_unstable_by(f64::total_cmp);
    0.5 * (values[(count - 1) / 2] + values[count / 2])
}

/// Mean of what lies within `reach` of the median; NaN of nothing.
pub(crate) fn trimmed_mean(values: &mut Vec<f64>, reach: f64) -> f64 {
    let middle = median(values);
    let near = values.iter().filter(|value| (*value - middle).abs() <= reach);
    let (sum, count) = near.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Median of absolute deviations of a normal distribution, times this, is its sigma.
const MAD_TO_SIGMA: f64 = 1.4826;

/// Robust sigma of values about their median; 0 where there are too few.
pub(crate) fn spread(values: impl Iterator<Item = f64>, least: usize) -> f64 {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    if values.len() < least {
        return 0.0;
    }
    let middle = median(&mut values);
    MAD_TO_SIGMA * median(&mut values.iter().map(|value| (value - middle).abs()).collect())
}

/// Mean and scatter of a quantity over its own past: exact at first, fading later.
#[derive(Debug, Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Past {
    mean: f64,
    variance: f64,
    count: f64,
}

impl Past {
    /// After so many values older ones fade.
    const MEMORY: f64 = 25.0;

    pub(crate) fn take(&mut self, value: f64) {
        self.count = (self.count + 1.0).min(Self::MEMORY);
        let step = value - self.mean;
        self.mean += step / self.count;
        self.variance += (step * step * (1.0 - 1.0 / self.count) - self.variance) / self.count;
    }

    pub(crate) const fn count(&self) -> f64 {
        self.count
    }

    pub(crate) const fn mean(&self) -> f64 {
        self.mean
    }

    pub(crate) fn sigma(&self) -> f64 {
        // With few values the scatter itself is uncertain: widened as Student's t is.
        let few = (self.count / (self.count - 1.5).max(0.5)).sqrt();
        self.variance.max(0.0).sqrt() * few
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_wrong_value_does_not_move_the_middle() {
        assert_eq!(median(&mut vec![3.0, f64::NAN, 1.0, 900.0, 2.0]), 2.5);
        assert_eq!(trimmed_mean(&mut vec![10.0, 10.2, 10.1, 14.0], 0.5), 10.1);
        assert!(median(&mut Vec::new()).is_nan());
    }

    #[test]
    fn the_past_has_mean_and_scatter() {
        let mut past = Past::default();
        [1.0, 3.0].iter().cycle().take(20).for_each(|value| past.take(*value));
        assert!((past.mean() - 2.0).abs() < 1e-9 && (1.0..1.1).contains(&past.sigma()));
    }
}
