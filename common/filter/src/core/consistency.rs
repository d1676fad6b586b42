//! Is a filter as accurate as it says? Bands for the mean of normalised innovations squared.

/// Where the mean of many χ² values lies with a stated probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiSquareBand {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl ChiSquareBand {
    /// True if `mean` lies in the band.
    pub fn holds(&self, mean: f64) -> bool {
        (self.low..=self.high).contains(&mean)
    }
}

/// Two-sided band of the mean of `count` independent χ² values of `dof` degrees of freedom each, `z` normal
/// standard deviations wide on each side (1.96 for 95 %). Wilson & Hilferty's cube law, accurate to a percent of
/// the width from ten degrees of freedom in total.
pub fn chi_square_mean_band(dof: f64, count: f64, z: f64) -> ChiSquareBand {
    let total = (dof * count).max(1.0);
    let spread = 2.0 / (9.0 * total);
    let at = |z: f64| dof * (1.0 - spread + z * spread.sqrt()).max(0.0).powi(3);
    ChiSquareBand { low: at(-z), high: at(z) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn band_agrees_with_tabulated_quantiles() {
        // χ² of 30 degrees of freedom: 2.5 % at 16.791, 97.5 % at 46.979.
        let band = chi_square_mean_band(3.0, 10.0, 1.959_96);
        assert!((band.low * 10.0 - 16.791).abs() < 0.05, "{band:?}");
        assert!((band.high * 10.0 - 46.979).abs() < 0.05, "{band:?}");
        assert!(band.holds(3.0) && !band.holds(1.0));
    }
}
