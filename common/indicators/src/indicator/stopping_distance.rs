//! How far the train runs under full braking.

use super::judging::{known, unknown};
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach, Stored};
use crate::train::capability::{ACT_RATIO, Capability, WATCH_RATIO};
use railgrip_messages::{Grade, Indicator};

/// Limits of a stopping distance over the nominal one.
pub const STOPPING_RATIO: Limit = Limit { scale: (0.5, 2.3), ..Limit::above(2.3, WATCH_RATIO, ACT_RATIO) };

/// Stopping distance now over nominal, at the speed at which it is largest.
pub static STOPPING_DISTANCE: IndicatorSpec = IndicatorSpec {
    id: "stopping_distance",
    form: Form::PERCENT,
    judge: Judge { train: Some(judge), ..Judge::NONE },
    limit: Some(|_, _| STOPPING_RATIO),
    // What is known of the rail comes and goes with slides; pads and isolated brakes stay.
    alert: Some(AlertRule {
        of_train: true,
        patience: [10.0, 5.0],
        ..AlertRule::of(
            "stopping_distance",
            Reach::Nowhere,
            Advice::same("Reduce speed: the train needs more than its nominal stopping distance."),
        )
    }),
    stored: Stored::Nothing,
    metric: Some(Metric::gauge("stopping_distance_ratio", "Stopping distance now over the nominal one")),
    meaning: Meaning {
        name: "Stopping distance now",
        block: "advisory",
        definition: "Distance to stop from a speed under full braking. Each wagon brakes with the smaller of its pad force and its adhesion; forces and masses add up, rotating masses included where wheels roll; running resistance helps.",
        unit: "m; judged over the nominal distance",
        interval: "95 %: pad errors are independent between wagons, the rail is common to all; unknown pads count as 70 to 110 % of nominal",
        limits: |_, full| {
            format!(
                "At the lower end of the interval: watch above {:.0} %, act above {:.0} % of the nominal distance. Full braking is {:.2} m/s² after {:.1} s.",
                100.0 * WATCH_RATIO,
                100.0 * ACT_RATIO,
                full.deceleration_m_s2,
                full.response_s
            )
        },
        cannot_see: "Gradients ahead, magnetic track brakes, and losses in slide protection. It does not replace a brake test.",
    },
    ..IndicatorSpec::PLAIN
};

fn judge(train: &Capability) -> Indicator {
    let Some([value, low, high]) = train.ratio() else { return unknown("no speed is asked for") };
    let (grade, words) = match low {
        _ if train.known_wagons == 0 => {
            (Grade::Unknown, "too little is known of the brakes yet; the figure rests on assumptions")
        }
        _ if low > ACT_RATIO => (Grade::Act, "needs far longer than nominal"),
        _ if low > WATCH_RATIO => (Grade::Watch, "needs longer than nominal"),
        _ if value > WATCH_RATIO && low > 1.0 => (
            Grade::Ok,
            "needs longer than nominal; the interval does not tell whether far enough for a warning",
        ),
        _ if value > WATCH_RATIO => {
            (Grade::Ok, "may need longer than nominal, but the interval is too wide to tell")
        }
        _ => (Grade::Ok, "no sign that it needs longer than nominal"),
    };
    let reason = format!("{words}: about {:.0} % of the nominal distance", 100.0 * value);
    known(value, low, high, grade, &reason)
}
