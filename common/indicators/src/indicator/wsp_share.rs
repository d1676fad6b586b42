//! Wheel-slide protection.

use super::judging::{known, large, unknown};
use crate::settings::WspSettings;
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach, Stored};
use railgrip_messages::{Grade, Indicator};

/// Share of the latest braking during which slide protection acts.
pub static WSP_SHARE: IndicatorSpec = IndicatorSpec {
    id: "wsp_share",
    form: Form::PERCENT,
    judge: Judge {
        wagon: Some(|seen, _| {
            judge(seen.state.wsp.mean(1.0), seen.state.wsp_elsewhere.mean(1.0), &seen.settings.wsp)
        }),
        wheelset: Some(|seen, index| {
            let wheelset = &seen.state.wheelset[index];
            judge(wheelset.wsp.mean(1.0), wheelset.wsp_elsewhere.mean(1.0), &seen.settings.wsp)
        }),
        ..Judge::NONE
    },
    limit: Some(|settings, _| Limit::above(1.0, settings.wsp.share_watch, settings.wsp.share_act)),
    alert: Some(AlertRule {
        inhibited_by: &["sensors"],
        ..AlertRule::of(
            "wsp_share",
            Reach::Wagon,
            Advice::same(
                "If other wagons do not slide here, check slide protection and pad friction of this wagon.",
            ),
        )
    }),
    stored: Stored::Value,
    trend: Reach::Wagon,
    metric: Some(Metric {
        reach: Reach::Both,
        ..Metric::gauge("wsp_active_ratio", "Share of the latest braking with slide protection")
    }),
    meaning: Meaning {
        name: "Braking with slide protection",
        definition: "Share of the latest braking during which slide protection acts. On low rail it is expected to act, so only good rail is judged.",
        unit: "% of the braking time",
        interval: "none: it is counted",
        limits: |settings, _| {
            format!(
                "On good rail: watch above {:.0} %, act above {:.0} %.",
                100.0 * settings.wsp.share_watch,
                100.0 * settings.wsp.share_act
            )
        },
        cannot_see: "Whether slide protection used the rail as well as possible.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};

/// Share of the braking time with slide protection. On low rail it does its work; only what it does elsewhere is judged.
fn judge(share: Option<f64>, elsewhere: Option<f64>, settings: &WspSettings) -> Indicator {
    let Some(share) = share else { return unknown("no braking yet") };
    let percent = 100.0 * share;
    let Some(elsewhere) = elsewhere else {
        let reason = format!("active in {percent:.0} % of the latest braking, all of it on low rail");
        return known(share, share, share, Grade::Ok, &reason);
    };
    let grade = large(elsewhere, settings.share_watch, settings.share_act);
    let reason = format!(
        "active in {percent:.0} % of the latest braking, in {:.0} % of the braking on good rail",
        100.0 * elsewhere
    );
    known(share, share, share, grade, &reason)
}
