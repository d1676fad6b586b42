//! Brakes that do not brake.

use super::brake_friction::over_nominal;
use super::judging::{known, large, unknown};
use crate::observed::Observed;
use crate::settings::{IndicatorSettings, IsolatedSettings};
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach, Stored};
use crate::train::neighbours::Neighbours;
use railgrip_messages::{Grade, Indicator, Text};
use std::cmp::Ordering::Equal;

/// Share of the latest braking without a brake: of a wheelset against its wagon, of a wagon against its train.
pub static ISOLATED: IndicatorSpec = IndicatorSpec {
    id: "isolated",
    form: Form::PERCENT,
    judge: Judge {
        wagon: Some(|seen, _| wagon(seen)),
        wheelset: Some(wheelset),
        among: Some(among),
        ..Judge::NONE
    },
    limit: Some(|settings, _| Limit::above(1.0, settings.isolated.watch, settings.isolated.act)),
    alert: Some(AlertRule {
        of_free_wagon: true,
        formerly: &["no_pressure"],
        ..AlertRule::of(
            "isolated",
            Reach::Wheelsets,
            Advice::same(
                "Check the isolating cock, the brake cylinder and the rigging here. Count this brake as missing until then.",
            ),
        )
    }),
    stored: Stored::Value,
    metric: Some(Metric {
        reach: Reach::Both,
        ..Metric::gauge("brake_isolated_ratio", "Share of the latest braking without a brake")
    }),
    meaning: Meaning {
        name: "Without a brake",
        definition: "Share of the latest braking during which a wheelset had no pressing force while others of the wagon had, or the whole wagon while other wagons had. Also pads that press without effect.",
        unit: "% of the braking time",
        interval: "none: it is counted",
        limits: |settings, _| {
            let isolated = &settings.isolated;
            format!(
                "Watch above {:.0} %, act above {:.0} %; act also when friction is certainly below {:.0} % of nominal.",
                100.0 * isolated.watch,
                100.0 * isolated.act,
                100.0 * isolated.effect_ratio
            )
        },
        cannot_see: "A whole wagon without a brake in a train of fewer than three wagons, or when half of the wagons are.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};

fn wheelset(seen: &Observed, index: usize) -> Indicator {
    judge(seen.state.isolation.share(index), over_nominal(seen, Some(index)), &seen.settings.isolated)
}

/// The wagon: its worst wheelset, or all of them when the wagon does not brake although it is pressed.
fn wagon(seen: &Observed) -> Indicator {
    let whole = judge(None, over_nominal(seen, None), &seen.settings.isolated);
    if whole.grade() == Grade::Act {
        return whole;
    }
    let all = (0..seen.last.wheelset_count()).map(|index| (index, wheelset(seen, index)));
    let worst =
        all.max_by(|(_, a), (_, b)| (a.grade, a.value).partial_cmp(&(b.grade, b.value)).unwrap_or(Equal));
    let Some((index, mut worst)) = worst else { return whole };
    if worst.grade() > Grade::Ok {
        worst.reason = Text::new(&format!("wheelset {}: {}", index + 1, worst.reason));
    }
    worst
}

/// The whole wagon among the others of its train.
fn among(train: &Neighbours, wagon: u32, settings: &IndicatorSettings) -> Option<Indicator> {
    let share = train.without_brake(wagon)?;
    let grade = large(share, settings.isolated.watch, settings.isolated.act);
    let words = match grade {
        Grade::Act => "the whole wagon is without pressing force while the train brakes",
        Grade::Watch => "the whole wagon is often without pressing force while the train brakes",
        _ => "pressed like the other wagons",
    };
    let reason = format!("{words}: {:.0} % of the latest braking without pressing force", 100.0 * share);
    Some(known(share, share, share, grade, &reason))
}

/// One wheelset that does not brake: no pressing force, or none that has an effect (friction and its upper end, over
/// nominal).
fn judge(share: Option<f64>, friction_ratio: Option<(f64, f64)>, settings: &IsolatedSettings) -> Indicator {
    let limits = settings;
    if let Some((ratio, high)) = friction_ratio.filter(|(_, high)| *high < limits.effect_ratio) {
        let said = format!(
            "pressed without effect: pads at {:.0} % of nominal, {:.0} % at most",
            100.0 * ratio,
            100.0 * high
        );
        return known(1.0, 1.0, 1.0, Grade::Act, &said);
    }
    let Some(share) = share else { return unknown("no braking yet") };
    let grade = large(share, limits.watch, limits.act);
    let words = if grade > Grade::Ok {
        "no pressing force here while others press"
    } else {
        "pressed like the others"
    };
    known(
        share,
        share,
        share,
        grade,
        &format!("{words}: {:.0} % of the latest braking without pressing force", 100.0 * share),
    )
}
