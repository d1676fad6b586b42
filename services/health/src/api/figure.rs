//! A judged figure, and what the age of the data behind it means. Stale data lose everything that would pass for the
//! present.

use crate::api::grade::{DataState, Grade};
use railgrip_messages::{Health, Indicator};
use serde::Serialize;
use utoipa::ToSchema;

/// One judged figure.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Figure {
    /// The figure; `null` if unknown.
    pub value: Option<f64>,
    /// Lower end of its 95 % interval.
    pub low: Option<f64>,
    /// Upper end of its 95 % interval.
    pub high: Option<f64>,
    /// How it is judged.
    pub grade: Grade,
    /// Why, in words.
    pub reason: String,
}

/// Below this nothing that is measured differs from zero.
const TINY: f64 = 1e-280;

/// Rounds to five significant digits: sensors know no more, and JSON is shorter.
pub(crate) fn rounded(value: f64) -> f64 {
    if !value.is_finite() || value.abs() < TINY {
        return 0.0;
    }
    let scale = 10_f64.powi(4 - value.abs().log10().floor() as i32);
    (value * scale).round() / scale
}

/// A plain figure of a message, rounded; NaN means that it is unknown there.
pub(crate) fn known(value: f64) -> Option<f64> {
    value.is_finite().then(|| rounded(value))
}

/// Rounds a time to milliseconds.
pub(crate) fn milliseconds(seconds: f64) -> f64 {
    (seconds * 1e3).round() / 1e3
}
/// What the age of a wagon's data means.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Freshness {
    pub state: DataState,
    pub age_s: Option<f64>,
}

impl Freshness {
    /// By the monotonic clock.
    pub fn of(health: Option<&Health>, now_ns: u64, stale_after_s: f64) -> Self {
        match health {
            None => Self { state: DataState::Silent, age_s: None },
            Some(health) => {
                let age_s = health.acquired.age_s(now_ns);
                let state = if age_s > stale_after_s { DataState::Stale } else { DataState::Live };
                Self { state, age_s: Some(milliseconds(age_s)) }
            }
        }
    }

    /// True if news arrive.
    pub const fn is_live(self) -> bool {
        matches!(self.state, DataState::Live)
    }

    /// Why nothing can be judged.
    pub fn reason(self) -> String {
        match self.age_s {
            Some(age_s) => format!("stale: no new data for {age_s:.0} s"),
            None => "silent: no data have arrived yet".to_owned(),
        }
    }
}
/// An indicator as the API says it.
pub(crate) fn figure(indicator: &Indicator, fresh: Freshness) -> Figure {
    let known = |value: f64| (indicator.known != 0).then(|| rounded(value));
    Figure {
        value: known(indicator.value),
        low: known(indicator.low),
        high: known(indicator.high),
        grade: if fresh.is_live() { indicator.grade().into() } else { Grade::Unknown },
        reason: match indicator.reason.as_str() {
            reason if fresh.is_live() => reason.to_owned(),
            "" => fresh.reason(),
            before => format!("{}; before: {before}", fresh.reason()),
        },
    }
}
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_digits_are_kept() {
        for (value, expected) in [
            (0.123_456_7, 0.12346),
            (-123_456.7, -123_460.0),
            (0.0, 0.0),
            (f64::NAN, 0.0),
            (5e-324, 0.0),
            (f64::MIN_POSITIVE, 0.0),
            (1e-9, 1e-9),
            (20.0, 20.0),
        ] {
            assert_eq!(rounded(value), expected);
        }
    }
}
