//! Front against rear.

use super::judging::{known, large, unknown};
use crate::measure::mean::Mean;
use crate::settings::AsymmetrySettings;
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach};
use railgrip_messages::{Grade, Indicator};

/// Pad friction of the front wheelsets minus that of the rear ones, over their mean.
pub static ASYMMETRY: IndicatorSpec = IndicatorSpec {
    id: "asymmetry",
    form: Form::PERCENT,
    judge: Judge {
        wagon: Some(|seen, _| {
            let (state, settings) = (&seen.state, &seen.settings);
            judge(
                state.difference.mean(),
                state.difference.seconds,
                state.friction.mean(),
                &settings.asymmetry,
                settings.brake_friction.min_braking_s,
            )
        }),
        ..Judge::NONE
    },
    limit: Some(|settings, _| {
        let (watch, act) = (settings.asymmetry.watch, settings.asymmetry.act);
        Limit {
            scale: (-1.4 * act, 1.4 * act),
            act_low: Some(-act),
            watch_low: Some(-watch),
            watch_high: Some(watch),
            act_high: Some(act),
        }
    }),
    alert: Some(AlertRule {
        of_free_wagon: true,
        ..AlertRule::of("brake_friction", Reach::Wagon, Advice::LOOK)
    }),
    trend: Reach::Wagon,
    metric: Some(Metric::gauge("brake_asymmetry_ratio", "Pad friction front minus rear over their mean")),
    meaning: Meaning {
        name: "Front minus rear",
        block: "health assessment",
        definition: "Pad friction of the front wheelsets minus that of the rear ones, over their mean.",
        unit: "% of the mean",
        interval: "95 %",
        limits: |settings, _| {
            format!(
                "Watch beyond ±{:.0} %, act beyond ±{:.0} %, at the end of the interval nearer to zero.",
                100.0 * settings.asymmetry.watch,
                100.0 * settings.asymmetry.act
            )
        },
        cannot_see: "While both wheelsets roll, only the sum of their torques is visible. The difference shows in slides, and in creepage if the wheel radii are known well.",
    },
    ..IndicatorSpec::PLAIN
};

/// Front minus rear over their mean.
fn judge(
    difference: Option<Mean>,
    seconds: f64,
    friction: Option<Mean>,
    settings: &AsymmetrySettings,
    min_braking_s: f64,
) -> Indicator {
    let both =
        difference.zip(friction).filter(|(_, friction)| seconds >= min_braking_s && friction.value > 0.0);
    let Some((difference, friction)) = both else {
        return unknown("needs braking in which the wheelsets can be told apart");
    };
    let (value, half) = (difference.value / friction.value, difference.half_width / friction.value);
    let (low, high) = (value - half, value + half);
    // The end of the interval nearer to zero decides; an interval around zero is no asymmetry.
    let sure = if low > 0.0 {
        low
    } else if high < 0.0 {
        -high
    } else {
        0.0
    };
    let weaker = if value > 0.0 { "rear" } else { "front" };
    let percent = format!("{:+.0} ± {:.0} %", 100.0 * value, 100.0 * half);
    match large(sure, settings.watch, settings.act) {
        Grade::Ok if half > settings.act => known(
            value,
            low,
            high,
            Grade::Unknown,
            &format!("too uncertain to judge: front minus rear {percent}"),
        ),
        Grade::Ok => {
            known(value, low, high, Grade::Ok, &format!("even: front minus rear {percent} of their mean"))
        }
        grade => known(
            value,
            low,
            high,
            grade,
            &format!("{weaker} brakes less: front minus rear {percent} of their mean"),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(value: f64, half_width: f64) -> Option<Mean> {
        Some(Mean { value, sigma: half_width / 1.96, half_width })
    }

    #[test]
    fn asymmetry_names_the_weaker_end() {
        let judge = |difference, half| {
            judge(mean(difference, half), 10.0, mean(0.35, 0.01), &AsymmetrySettings::default(), 3.0)
        };
        assert_eq!(judge(0.01, 0.02).grade(), Grade::Ok);
        let front = judge(-0.08, 0.01);
        assert_eq!(front.grade(), Grade::Watch);
        assert!(front.reason.as_str().starts_with("front brakes less"), "{}", front.reason);
        assert_eq!(judge(0.20, 0.02).grade(), Grade::Act);
        assert_eq!(judge(0.05, 0.2).grade(), Grade::Unknown);
    }
}
