//! When a wagon begins to brake.

use super::judging::{known, large, unknown};
use crate::settings::IndicatorSettings;
use crate::spec::{
    Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach, Stored, Unit,
};
use crate::train::neighbours::Neighbours;
use railgrip_messages::{Grade, Indicator};

/// How much later than its place in the train explains a wagon begins to brake.
pub static BRAKE_DELAY: IndicatorSpec = IndicatorSpec {
    id: "brake_delay",
    unit: Unit::Seconds,
    form: Form::SECONDS,
    judge: Judge { among: Some(among), ..Judge::NONE },
    limit: Some(|settings, _| {
        let (watch, act) = (settings.response.late_watch_s, settings.response.late_act_s);
        Limit { scale: (-0.5 * act, 1.3 * act), ..Limit::above(1.0, watch, act) }
    }),
    alert: Some(AlertRule {
        of_free_wagon: true,
        formerly: &["late"],
        ..AlertRule::of("response", Reach::Nowhere, Advice::LOOK)
    }),
    stored: Stored::Nothing,
    metric: Some(Metric::gauge(
        "brake_delay_seconds",
        "How much later than its place in the train explains a wagon begins to brake",
    )),
    meaning: Meaning {
        name: "Begins late by",
        definition: "How much later the first pressing force comes on this wagon than a line through all wagons predicts. The signal travels along the brake pipe; what remains is the delay of this wagon. Median of its latest applications.",
        unit: "s",
        interval: "spread of the latest applications",
        limits: |settings, _| {
            format!(
                "Watch above {:.1} s, act above {:.1} s, at the middle between median and lowest; needs three applications.",
                settings.response.late_watch_s, settings.response.late_act_s
            )
        },
        cannot_see: "A delay of the whole train, or one that changes smoothly along it.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};

fn among(train: &Neighbours, wagon: u32, settings: &IndicatorSettings) -> Option<Indicator> {
    let Some([value, low, high]) = train.delay_s(wagon) else {
        return Some(unknown("needs three brake applications of at least three wagons"));
    };
    // Half of the way to the lowest: one early beginning does not excuse the others.
    let sure = 0.5 * (low + value);
    let grade = large(sure, settings.response.late_watch_s, settings.response.late_act_s);
    let words = match grade {
        Grade::Act => "begins to brake far too late",
        Grade::Watch => "begins to brake late",
        _ => "begins in its turn",
    };
    let reason =
        format!("{words}: {value:+.2} s against its place in the train, {low:+.2} to {high:+.2} s recently");
    Some(known(value, low, high, grade, &reason))
}
