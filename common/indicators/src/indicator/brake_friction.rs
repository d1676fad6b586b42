//! Pad friction: as it was in the latest braking, and referred to standard conditions.

use super::judging::{known, unknown};
use crate::measure::mean::Mean;
use crate::nominal::Nominal;
use crate::observed::Observed;
use crate::settings::{BrakeFrictionSettings, IndicatorSettings};
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach, Unit};
use railgrip_messages::{Grade, Indicator};

/// Friction between pad and disc, mean over the latest braking.
pub static BRAKE_FRICTION: IndicatorSpec = IndicatorSpec {
    id: "brake_friction",
    unit: Unit::Ratio,
    form: Form::COEFFICIENT,
    judge: Judge {
        wagon: Some(|seen, _| {
            let friction = &seen.state.friction;
            judge(seen, friction.mean(), friction.seconds, NO_BRAKING)
        }),
        wheelset: Some(|seen, index| {
            let friction = &seen.state.wheelset[index].friction;
            judge(seen, friction.mean(), friction.seconds, NOT_OBSERVABLE)
        }),
        ..Judge::NONE
    },
    limit: Some(limit),
    alert: Some(AlertRule {
        of_free_wagon: true,
        inhibited_by: &["isolated", "sensors"],
        ..AlertRule::of(
            "brake_friction",
            Reach::Both,
            Advice {
                wagon: "Check pads, discs and rigging of this wagon: wear, glazing, water or oil.",
                train: "Most wagons at once: suspect water, ice or snow on the discs, or the loads that the train was given, before \
                        any single pad. Brake early until it has gone.",
            },
        )
    }),
    trend: Reach::Both,
    metric: Some(Metric {
        reach: Reach::Both,
        ..Metric::gauge("brake_friction_ratio", "Pad friction, mean over braking")
    }),
    meaning: Meaning {
        name: "Pad friction",
        block: "health assessment",
        definition: "Friction between pad and disc, mean over the latest braking, of the wagon and of each wheelset. Estimated from wheel speeds, train speed and brake-cylinder pressure; it is not measured directly.",
        unit: "none (a ratio of forces)",
        interval: "95 %, from the filter and the scatter between blocks of braking, widened for errors of mass and wheel radii",
        limits: |settings, _| {
            let friction = &settings.brake_friction;
            format!(
                "Of nominal: watch below {:.0} % or above {:.0} %, act below {:.0} % or above {:.0} %; needs {:.0} s of braking.",
                100.0 * friction.ratio_watch_low,
                100.0 * friction.ratio_watch_high,
                100.0 * friction.ratio_act_low,
                100.0 * friction.ratio_act_high,
                friction.min_braking_s
            )
        },
        cannot_see: "Anything while the brakes are released: the last figure is held. For a single wheelset only braking counts in which the filter can tell the wheelsets apart. A wrong mass shifts all figures alike.",
    },
    ..IndicatorSpec::PLAIN
};

/// What pad friction would be at a standard speed, pressing force and disc temperature.
pub static BRAKE_FRICTION_STANDARD: IndicatorSpec = IndicatorSpec {
    id: "brake_friction_standard",
    unit: Unit::Ratio,
    form: Form::COEFFICIENT,
    judge: Judge {
        wagon: Some(|seen, _| {
            let standard = &seen.state.standard;
            judge(seen, standard.mean(seen.nominal.brake_friction), standard.seconds, NO_BRAKING)
        }),
        wheelset: Some(|seen, index| {
            let mean = &seen.state.wheelset[index].standard.mean;
            judge(seen, mean.mean(), mean.seconds, NOT_OBSERVABLE)
        }),
        ..Judge::NONE
    },
    limit: Some(limit),
    trend: Reach::Both,
    metric: Some(Metric {
        reach: Reach::Both,
        ..Metric::gauge("brake_friction_standard_ratio", "Pad friction referred to standard conditions")
    }),
    meaning: Meaning {
        name: "Pad friction, standardised",
        block: "health assessment",
        definition: "Pad friction converted to a standard speed, pressing force and disc temperature by a fit over the braking, so that different days can be compared.",
        unit: "none",
        interval: "95 %, from the fit",
        limits: |settings, _| {
            let standard = &settings.standard;
            format!(
                "As pad friction. Standard is {:.0} km/h, {:.0} kN per wheelset and discs {:.0} K above ambient.",
                3.6 * standard.speed_m_s,
                1e-3 * standard.pressing_force_n,
                standard.disc_rise_k
            )
        },
        cannot_see: "The disc temperature is calculated, not measured. If all braking is alike, the influence of the conditions cannot be found and the interval stays wide.",
    },
    ..IndicatorSpec::PLAIN
};

const NO_BRAKING: &str = "no braking yet";
const NOT_OBSERVABLE: &str = "needs braking in which this wheelset can be told from the others";

fn judge(seen: &Observed, mean: Option<Mean>, seconds: f64, nothing: &str) -> Indicator {
    brake_friction(mean, seconds, seen.nominal.brake_friction, &seen.settings.brake_friction, nothing)
}

fn limit(settings: &IndicatorSettings, nominal: &Nominal) -> Limit {
    let friction = &settings.brake_friction;
    let ratio = Limit {
        scale: (0.4 * friction.ratio_act_low, 1.15 * friction.ratio_act_high),
        act_low: Some(friction.ratio_act_low),
        watch_low: Some(friction.ratio_watch_low),
        watch_high: Some(friction.ratio_watch_high),
        act_high: Some(friction.ratio_act_high),
    };
    ratio.times(nominal.brake_friction)
}

/// Friction of the wagon (`None`) or of a wheelset and the upper end of its interval, over nominal; `None` while unknown.
pub(super) fn over_nominal(seen: &Observed, wheelset: Option<usize>) -> Option<(f64, f64)> {
    let friction = wheelset.map_or(&seen.state.friction, |index| &seen.state.wheelset[index].friction);
    let friction = judge(seen, friction.mean(), friction.seconds, NO_BRAKING);
    let nominal = seen.nominal.brake_friction;
    (friction.known != 0).then_some((friction.value / nominal, friction.high / nominal))
}

/// Pad friction against its nominal value. A limit counts as passed when the interval's nearer end has passed it, so
/// that an uncertain figure raises no alarm; an interval wider than the ok range gives no verdict.
fn brake_friction(
    mean: Option<Mean>,
    braking_s: f64,
    nominal: f64,
    settings: &BrakeFrictionSettings,
    nothing: &str,
) -> Indicator {
    let Some(mean) = mean.filter(|_| braking_s >= settings.min_braking_s) else { return unknown(nothing) };
    let half = mean.half_width.hypot(1.96 * settings.systematic_share * mean.value);
    let (low, high) = ((mean.value - half).max(0.0), mean.value + half);
    let ratio = mean.value / nominal;
    let (ratio_low, ratio_high) = (low / nominal, high / nominal);
    let figure = format!(
        "{:.3} ± {half:.3} over {braking_s:.0} s of braking, {:.0} % of nominal {nominal:.3}",
        mean.value,
        100.0 * ratio
    );
    let (grade, words) = if ratio_high < settings.ratio_act_low {
        (Grade::Act, "far too low")
    } else if ratio_low > settings.ratio_act_high {
        (Grade::Act, "far too high")
    } else if ratio_high < settings.ratio_watch_low {
        (Grade::Watch, "low")
    } else if ratio_low > settings.ratio_watch_high {
        (Grade::Watch, "high")
    } else if ratio_low < settings.ratio_act_low && ratio_high > settings.ratio_act_high {
        (Grade::Unknown, "too uncertain to judge")
    } else {
        (Grade::Ok, "as it should be")
    };
    known(mean.value, low, high, grade, &format!("{words}: {figure}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(value: f64, half_width: f64) -> Option<Mean> {
        Some(Mean { value, sigma: half_width / 1.96, half_width })
    }

    fn friction(value: f64, half_width: f64) -> Indicator {
        brake_friction(
            mean(value, half_width),
            42.0,
            0.35,
            &BrakeFrictionSettings::default(),
            "no braking yet",
        )
    }

    #[test]
    fn brake_friction_is_judged_by_the_sure_end_of_its_interval() {
        let cases = [
            (0.350, 0.005, Grade::Ok, "as it should be"),
            (0.280, 0.005, Grade::Watch, "low"),
            (0.290, 0.030, Grade::Ok, "as it should be"),
            (0.200, 0.005, Grade::Act, "far too low"),
            (0.450, 0.005, Grade::Watch, "high"),
            (0.600, 0.010, Grade::Act, "far too high"),
            (0.350, 0.300, Grade::Unknown, "too uncertain"),
        ];
        for (value, half_width, grade, words) in cases {
            let indicator = friction(value, half_width);
            println!("{}", indicator.reason);
            assert_eq!(indicator.grade(), grade, "{value} ± {half_width}");
            assert!(indicator.reason.as_str().starts_with(words), "{}", indicator.reason);
        }
        let reason = friction(0.280, 0.005).reason;
        assert_eq!(reason.as_str(), "low: 0.280 ± 0.007 over 42 s of braking, 80 % of nominal 0.350");
        let settings = BrakeFrictionSettings::default();
        let early = brake_friction(mean(0.2, 0.01), 1.0, 0.35, &settings, "no braking yet");
        assert_eq!(
            (early.grade(), early.figure(), early.reason.as_str()),
            (Grade::Unknown, None, "no braking yet")
        );
    }
}
