//! What sand does.

use super::judging::{known, unknown};
use crate::settings::SandingSettings;
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach};
use railgrip_messages::{Grade, Indicator};

/// Adhesion in slides with sand over adhesion in slides without.
pub static SANDING: IndicatorSpec = IndicatorSpec {
    id: "sanding",
    form: Form::FACTOR,
    judge: Judge {
        wagon: Some(|seen, _| judge(seen.state.sanding.ratio(), &seen.settings.sanding)),
        ..Judge::NONE
    },
    limit: Some(|settings, _| {
        let watch = settings.sanding.factor_watch;
        Limit { watch_low: Some(watch), ..Limit::free(0.0, 3.0 * watch) }
    }),
    alert: Some(AlertRule::of(
        "sanding",
        Reach::Wagon,
        Advice::same("Check sand level, nozzles and heating: sand does not raise adhesion."),
    )),
    metric: Some(Metric::gauge(
        "sanding_gain_ratio",
        "Adhesion in slides with sand over adhesion in slides without",
    )),
    meaning: Meaning {
        name: "Sand: gain of grip",
        definition: "Adhesion in slides with sand over adhesion in slides without, within a short time.",
        unit: "a factor",
        interval: "95 %, from the scatter of both",
        limits: |settings, _| {
            format!("Watch when the upper end of the interval is below {:.1}.", settings.sanding.factor_watch)
        },
        cannot_see: "Sand that falls where no wheelset slides, or a rail that changes between the slides compared.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};

/// What sand does.
fn judge(ratio: Option<(f64, f64, f64)>, settings: &SandingSettings) -> Indicator {
    let Some((ratio, low, high)) = ratio else {
        return unknown("needs slides with and without sand within a short time");
    };
    let (grade, words) = if high < settings.factor_watch {
        (Grade::Watch, "sand has no effect")
    } else if low > 1.0 {
        (Grade::Ok, "sand helps")
    } else {
        (Grade::Unknown, "too uncertain to judge")
    };
    known(
        ratio,
        low,
        high,
        grade,
        &format!("{words}: with sand {ratio:.2} times the adhesion without, {low:.2} to {high:.2}"),
    )
}
