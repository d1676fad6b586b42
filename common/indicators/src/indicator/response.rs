//! How fast the brake builds up.

use super::judging::{known, large, unknown};
use crate::settings::ResponseSettings;
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach, Unit};
use railgrip_messages::{Grade, Indicator};

/// Time from the first pressing force to 90 % of its level.
pub static RESPONSE: IndicatorSpec = IndicatorSpec {
    id: "response",
    unit: Unit::Seconds,
    form: Form::SECONDS,
    judge: Judge {
        wagon: Some(|seen, _| judge(seen.state.applications.response_s(), &seen.settings.response)),
        ..Judge::NONE
    },
    limit: Some(|settings, _| {
        let response = &settings.response;
        Limit::above(1.3 * response.act_s, response.watch_s, response.act_s)
    }),
    alert: Some(AlertRule {
        of_free_wagon: true,
        inhibited_by: &["isolated"],
        ..AlertRule::of(
            "response",
            Reach::Wagon,
            Advice {
                wagon: "Check distributor, chokes and brake cylinder of this wagon, and its G/P changeover.",
                train: "The whole train brakes late: check brake pipe, driver's valve and settings (G/P).",
            },
        )
    }),
    trend: Reach::Wagon,
    metric: Some(Metric::gauge(
        "brake_response_seconds",
        "Time from the first pressing force to 90 % of its level",
    )),
    meaning: Meaning {
        name: "Brake builds up in",
        definition: "Time from the first pressing force to 90 % of its level, median of the latest brake applications in which the force became steady.",
        unit: "s",
        interval: "spread of the latest applications",
        limits: |settings, _| {
            format!(
                "Watch above {:.1} s, act above {:.1} s.",
                settings.response.watch_s, settings.response.act_s
            )
        },
        cannot_see: "The time from the driver's action to the first pressure here, and applications in which the force never becomes steady.",
        ..Meaning::PLAIN
    },
    formerly: &["response"],
    ..IndicatorSpec::PLAIN
};

/// Time from the first pressing force to 90 % of its level.
fn judge(time_s: Option<(f64, f64, f64)>, settings: &ResponseSettings) -> Indicator {
    let Some((median_s, low_s, high_s)) = time_s else {
        return unknown("needs three brake applications in which the force becomes steady");
    };
    let grade = large(low_s, settings.watch_s, settings.act_s);
    let words = if grade > Grade::Ok { "slow" } else { "as it should be" };
    let reason =
        format!("{words}: {median_s:.1} s to 90 % of the force, {low_s:.1} to {high_s:.1} s recently");
    known(median_s, low_s, high_s, grade, &reason)
}
