//! What the API says of trends, as types.

use crate::api::figure::rounded;
use railgrip_indicators::trend::Trend;
use serde::Serialize;
use utoipa::ToSchema;

pub(super) const DAY_S: i64 = 86_400;
/// What the past of an indicator shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It rises, with 97.5 % certainty.
    Rising,
    /// It falls, with 97.5 % certainty.
    Falling,
    /// Neither is certain.
    NoTrend,
    /// There are fewer than eight points, or less than an hour of them.
    TooLittleData,
}

/// Trend of one indicator.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct TrendView {
    /// The indicator, a field of the history.
    pub indicator: String,
    /// Its unit; empty for a ratio.
    pub unit: &'static str,
    /// What its past shows.
    pub verdict: Verdict,
    /// Change a day: slope, lower and upper end of its 95 % interval.
    pub per_day: Option<[f64; 3]>,
    /// Level now, on the line.
    pub level: Option<f64>,
    /// The limit beyond which it needs action, on the side to which it goes; `null` if there is none.
    pub limit: Option<f64>,
    /// Days until then; `null` without a trend towards it.
    pub remaining_days: Option<f64>,
    /// Not earlier than this, days; `null` if the data rule out that it comes.
    pub remaining_days_low: Option<f64>,
    /// Not later than this, days; `null` if it may never come.
    pub remaining_days_high: Option<f64>,
    /// Points behind it.
    pub points: u32,
    /// Days from the first to the last.
    pub span_days: f64,
}

/// Trends of a wagon.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct TrendList {
    /// The wagon.
    pub wagon: u32,
    /// The number of its vehicle; `null` where the config gives none.
    pub vehicle_number: Option<String>,
    /// One line an indicator.
    pub trends: Vec<TrendView>,
}
/// The trend of one indicator with the limits below and above which it needs action.
pub(super) fn view(
    indicator: &str,
    unit: &'static str,
    limits: Option<(Option<f64>, Option<f64>)>,
    trend: Option<Trend>,
) -> TrendView {
    let days = |seconds: Option<f64>| seconds.map(|seconds| rounded(seconds / DAY_S as f64));
    let (low, high) = limits.unwrap_or_default();
    let limit = match trend {
        Some(trend) if trend.slope_per_s[0] < 0.0 => low.or(high),
        _ => high.or(low),
    };
    let left = trend.zip(limit).map(|(trend, limit)| trend.remaining(limit));
    let verdict = match trend {
        None => Verdict::TooLittleData,
        Some(trend) if !trend.certain => Verdict::NoTrend,
        Some(trend) if trend.slope_per_s[0] > 0.0 => Verdict::Rising,
        Some(_) => Verdict::Falling,
    };
    TrendView {
        indicator: indicator.to_owned(),
        unit,
        verdict,
        per_day: trend.map(|trend| trend.slope_per_s.map(|slope| rounded(DAY_S as f64 * slope))),
        level: trend.map(|trend| rounded(trend.level[0])),
        limit: limit.map(rounded),
        remaining_days: days(left.and_then(|left| left.value_s)),
        remaining_days_low: days(left.and_then(|left| left.low_s)),
        remaining_days_high: days(left.and_then(|left| left.high_s)),
        points: trend.map_or(0, |trend| trend.points as u32),
        span_days: rounded(trend.map_or(0.0, |trend| trend.span_s / DAY_S as f64)),
    }
}
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_the_one_ahead() {
        let falling: Vec<(f64, f64)> = (0..240)
            .map(|hour| {
                (3600.0 * f64::from(hour), 0.35 - 1e-4 * f64::from(hour) + 1e-4 * f64::from(hour % 3))
            })
            .collect();
        let limits = Some((Some(0.245), Some(0.49)));
        let seen = view("brake_friction", "", limits, Trend::of(&falling));
        println!("{seen:?}");
        assert_eq!((seen.verdict, seen.limit), (Verdict::Falling, Some(0.245)));
        // From 0.326 by 0.0024 a day: 33.8 days.
        let (left, low, high) = (
            seen.remaining_days.unwrap(),
            seen.remaining_days_low.unwrap(),
            seen.remaining_days_high.unwrap(),
        );
        assert!(low <= left && left <= high && (left - 33.8).abs() < 1.0, "{left}");
        assert_eq!(view("x", "", None, Trend::of(&falling)).remaining_days, None);
        assert_eq!(view("x", "", limits, None).verdict, Verdict::TooLittleData);
    }
}
