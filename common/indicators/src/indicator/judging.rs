//! From figures to grades.

use railgrip_messages::{Grade, Indicator, Text};

/// Nothing to judge, and why.
#[must_use]
pub fn unknown(reason: &str) -> Indicator {
    Indicator { reason: Text::new(reason), ..Indicator::default() }
}

/// A judged figure with the ends of its interval; both are the figure itself where it is counted.
#[must_use]
pub fn known(value: f64, low: f64, high: f64, grade: Grade, reason: &str) -> Indicator {
    Indicator { value, low, high, grade: grade.code(), known: 1, reason: Text::new(reason) }
}

/// Grade of a figure that is bad when large.
#[must_use]
pub fn large(value: f64, watch: f64, act: f64) -> Grade {
    if value > act {
        Grade::Act
    } else if value > watch {
        Grade::Watch
    } else {
        Grade::Ok
    }
}
