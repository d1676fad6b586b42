//! Trend of an indicator, and the time that remains to a limit. "No trend" is an answer.
//!
//! The slope is the median of the slopes of all pairs of points (Theil 1950; Sen 1968, JASA 63), its interval comes from
//! Kendall's statistic. Neighbouring points resemble each other; the variance of the statistic is therefore widened by
//! `(1 + ρ)/(1 − ρ)`, ρ the correlation of neighbouring residuals (after Hamed and Rao 1998, J. Hydrology 204).

/// More points are first merged into so many medians.
const MOST_POINTS: usize = 240;
/// Fewer points show no trend.
const LEAST_POINTS: usize = 8;
/// Quantile of the 95 % interval.
const Z: f64 = 1.96;

/// What a series shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trend {
    /// Slope with the ends of its 95 % interval, per second.
    pub slope_per_s: [f64; 3],
    /// Level at the last point on the line with each of these slopes.
    pub level: [f64; 3],
    /// Points behind it.
    pub points: usize,
    /// From the first to the last, s.
    pub span_s: f64,
    /// True if the interval of the slope does not hold zero.
    pub certain: bool,
}

/// The time to a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remaining {
    /// The best guess, s; `None` without a certain trend towards the limit.
    pub value_s: Option<f64>,
    /// Not earlier than this, s, with 97.5 %; `None` if even the steepest slope leads away from the limit.
    pub low_s: Option<f64>,
    /// Not later than this, s, with 97.5 %; `None` if it may never come.
    pub high_s: Option<f64>,
}

impl Trend {
    /// The trend of points (time in s, value), in the order of time; `None` if there are too few.
    #[must_use]
    pub fn of(points: &[(f64, f64)]) -> Option<Self> {
        let points = thinned(points);
        let count = points.len();
        let (first, last) = (points.first()?, points.last()?);
        if count < LEAST_POINTS || last.0 <= first.0 {
            return None;
        }
        let mut slopes = Vec::with_capacity(count * (count - 1) / 2);
        for (index, (t, y)) in points.iter().enumerate() {
            slopes.extend(points[..index].iter().filter(|(u, _)| u < t).map(|(u, x)| (y - x) / (t - u)));
        }
        slopes.sort_by(f64::total_cmp);
        let slope = median(&slopes)?;
        let offsets = |slope: f64| points.iter().map(|(t, y)| y - slope * (t - last.0)).collect::<Vec<f64>>();
        let middle = |mut offsets: Vec<f64>| {
            offsets.sort_by(f64::total_cmp);
            median(&offsets)
        };
        let level = middle(offsets(slope))?;
        let residuals = offsets(slope);
        let n = count as f64;
        let widening = widening(&residuals, level);
        let sigma = (n * (n - 1.0) * (2.0 * n + 5.0) / 18.0 * widening).sqrt();
        let (all, reach) = (slopes.len() as f64, Z * sigma);
        // The ranks (N ∓ C)/2; beyond the ends the outermost slopes are all there is.
        let low = ((all - reach) / 2.0).floor().max(0.0) as usize;
        let high = (((all + reach) / 2.0).ceil() as usize).min(slopes.len() - 1);
        let interval = [slope, slopes[low], slopes[high]];
        let bounded = (all - reach) / 2.0 >= 0.0;
        let certain = bounded && (interval[1] > 0.0 || interval[2] < 0.0);
        // The line turns about the middle of the points: a steeper one ends elsewhere.
        let level = [level, middle(offsets(interval[1]))?, middle(offsets(interval[2]))?];
        Some(Self { slope_per_s: interval, level, points: count, span_s: last.0 - first.0, certain })
    }

    /// The time from the last point until the line meets a limit.
    #[must_use]
    pub fn remaining(&self, limit: f64) -> Remaining {
        let time = |of: usize| {
            let (slope, distance) = (self.slope_per_s[of], limit - self.level[of]);
            (slope * distance > 0.0).then(|| distance / slope)
        };
        let (steep, flat) = if limit > self.level[0] { (2, 1) } else { (1, 2) };
        Remaining {
            value_s: time(0).filter(|_| self.certain),
            low_s: time(steep),
            high_s: time(flat).filter(|_| self.certain),
        }
    }
}

/// At most so many points: medians of neighbours.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let sound: Vec<(f64, f64)> =
        points.iter().copied().filter(|(t, y)| t.is_finite() && y.is_finite()).collect();
    let width = sound.len().div_ceil(MOST_POINTS).max(1);
    let merge = |part: &[(f64, f64)]| {
        let mut values: Vec<f64> = part.iter().map(|(_, y)| *y).collect();
        values.sort_by(f64::total_cmp);
        let time = part.iter().map(|(t, _)| t).sum::<f64>() / part.len() as f64;
        median(&values).map(|value| (time, value))
    };
    sound.chunks(width).filter_map(merge).collect()
}

fn median(sorted: &[f64]) -> Option<f64> {
    let middle = sorted.len() / 2;
    let upper = *sorted.get(middle)?;
    Some(if sorted.len().is_multiple_of(2) { 0.5 * (upper + sorted[middle - 1]) } else { upper })
}

/// How much more the statistic scatters because neighbours resemble each other. Outliers are cut to three robust sigmas
/// first: they would hide the resemblance.
fn widening(residuals: &[f64], level: f64) -> f64 {
    let n = residuals.len() as f64;
    let mut sizes: Vec<f64> = residuals.iter().map(|r| (r - level).abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let cut = 3.0 * 1.4826 * median(&sizes).unwrap_or_default();
    let cut: Vec<f64> = residuals.iter().map(|r| (r - level).clamp(-cut, cut)).collect();
    let mean = cut.iter().sum::<f64>() / n;
    let total: f64 = cut.iter().map(|r| (r - mean) * (r - mean)).sum();
    let lagged: f64 = cut.windows(2).map(|pair| (pair[0] - mean) * (pair[1] - mean)).sum();
    if total <= 0.0 {
        return 1.0;
    }
    // Detrending and small numbers pull the estimate down by about (1 + 4ρ)/n (Marriott and Pope 1954).
    let raw = lagged / total;
    let correlation = ((n * raw + 2.0) / (n - 4.0)).clamp(0.0, 0.95);
    (1.0 + correlation) / (1.0 - correlation)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seeded noise (xorshift), about normal.
    struct Noise(u64);

    impl Noise {
        fn normal(&mut self) -> f64 {
            let mut uniform = || {
                self.0 ^= self.0 << 13;
                self.0 ^= self.0 >> 7;
                self.0 ^= self.0 << 17;
                (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5
            };
            (0..12).map(|_| uniform()).sum()
        }
    }

    /// Days of hourly values with a slope a day, noise with memory, and outliers.
    fn series(noise: &mut Noise, days: usize, per_day: f64, memory: f64) -> Vec<(f64, f64)> {
        let mut error = noise.normal();
        (0..days * 24)
            .map(|hour| {
                error = memory * error + (1.0 - memory * memory).sqrt() * noise.normal();
                let outlier = if hour % 37 == 5 { 0.05 } else { 0.0 };
                let t_s = 3600.0 * hour as f64;
                (t_s, 0.35 + per_day * t_s / 86_400.0 + 0.008 * error + outlier)
            })
            .collect()
    }

    #[test]
    fn the_interval_of_the_slope_holds_the_truth() {
        let mut noise = Noise(0x9e37_79b9_7f4a_7c15);
        for (memory, per_day, least, power) in
            [(0.0, 0.0, 0.93, 0), (0.0, -0.001, 0.93, 190), (0.6, 0.0, 0.88, 0), (0.6, -0.001, 0.88, 150)]
        {
            let (mut held, mut called, runs) = (0, 0, 200);
            for _ in 0..runs {
                let trend = Trend::of(&series(&mut noise, 10, per_day, memory)).unwrap();
                let truth = per_day / 86_400.0;
                held += usize::from(trend.slope_per_s[1] <= truth && truth <= trend.slope_per_s[2]);
                called += usize::from(trend.certain);
            }
            let share = f64::from(held as u32) / f64::from(runs);
            println!(
                "memory {memory}, {per_day} a day: interval held the truth {share:.3}, trend called in {called} of {runs}"
            );
            assert!(share >= least, "{share}");
            assert!(called >= power, "{called}");
            assert!(per_day != 0.0 || called <= 25, "called {called} times where there is none");
        }
    }

    #[test]
    fn the_remaining_time_holds_the_truth_and_no_trend_gives_none() {
        let mut noise = Noise(77);
        // From 0.35 by 0.002 a day: 0.2975 is reached after 26.25 days, 16.25 after the tenth.
        let (mut held, mut width_days) = (0, 0.0);
        for _ in 0..200 {
            let trend = Trend::of(&series(&mut noise, 10, -0.002, 0.3)).unwrap();
            let left = trend.remaining(0.2975);
            let (low, high) = (left.low_s.unwrap() / 86_400.0, left.high_s.unwrap() / 86_400.0);
            width_days += (high - low) / 200.0;
            held += usize::from(low <= 16.25 && 16.25 <= high);
        }
        println!("remaining 16.25 days: held {held} of 200, width {width_days:.1} days");
        assert!(held >= 176 && width_days < 14.0);
        let flat = Trend::of(&series(&mut Noise(5), 10, 0.0, 0.0)).unwrap();
        assert_eq!((flat.certain, flat.remaining(0.2975).value_s), (false, None));
        let away = Trend::of(&series(&mut noise, 10, 0.01, 0.0)).unwrap().remaining(0.2975);
        assert_eq!(away, Remaining { value_s: None, low_s: None, high_s: None });
        assert_eq!(Trend::of(&[(0.0, 1.0); 5]), None);
    }
}
