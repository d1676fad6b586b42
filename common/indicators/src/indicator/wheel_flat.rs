//! Wheels that are not round, told by what their speed repeats with every turn, and by how hard they slid.

use super::judging::{known, unknown};
use crate::measure::roundness::Variation;
use crate::measure::slides::Slides;
use crate::settings::{IndicatorSettings, WheelFlatSettings};
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach};
use railgrip_messages::{Grade, Indicator};

/// Variation of a wheelset's speed over a turn, as a share of its speed.
pub static WHEEL_FLAT: IndicatorSpec = IndicatorSpec {
    id: "wheel_flat",
    form: Form::PER_MILLE,
    judge: Judge {
        wheelset: Some(|seen, index| {
            let wheelset = &seen.state.wheelset[index];
            match wheelset.roundness.variation() {
                Some(variation) => {
                    judge(variation, slid_hard(&wheelset.slides, &seen.settings), &seen.settings.wheel_flat)
                }
                None => unknown("needs more turns of free rolling"),
            }
        }),
        ..Judge::NONE
    },
    limit: Some(|settings, _| {
        let flat = &settings.wheel_flat;
        Limit::above(2.0 * flat.variation_act, flat.variation_watch, flat.variation_act)
    }),
    alert: Some(AlertRule {
        inhibited_by: &["sensors"],
        ..AlertRule::of(
            "wheel_flat",
            Reach::Wheelsets,
            Advice {
                wagon: "Inspect the tread of this wheelset for flats, and listen for knocks at every turn.",
                train: "Inspect the treads of the listed wheelsets for flats; if none is found, look at the speed sensors.",
            },
        )
    }),
    trend: Reach::Wheelsets,
    metric: Some(Metric {
        reach: Reach::Wheelsets,
        ..Metric::gauge("wheel_speed_variation_ratio", "Variation of wheel speed over a turn, over the speed")
    }),
    meaning: Meaning {
        name: "Wheel flat",
        definition: "Variation of a wheelset's speed that repeats with every turn, RMS over its speed. A flat spot or a wheel that is out of round shows there; together with hard slides it means a wheel flat.",
        unit: "‰ of the speed",
        interval: "95 %, from the scatter of the speed about what repeats",
        limits: |settings, _| {
            let flat = &settings.wheel_flat;
            format!(
                "Watch when the lower end of the interval is above {:.2} ‰, act above {:.2} ‰, or above watch after hard slides.",
                1e3 * flat.variation_watch,
                1e3 * flat.variation_act
            )
        },
        cannot_see: "Flats shorter than about 100 mm, flats of trains whose speeds come fewer than six times a turn, and what an encoder makes of its own: one with a pattern of several marks a turn looks like a wheel that is out of round.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};

/// Whether a wheelset slid so hard lately that its slides are worth a look of their own.
fn slid_hard(slides: &Slides, settings: &IndicatorSettings) -> bool {
    slides.recent_energy_j > settings.slides.energy_watch_j
        || slides.recent_locked_s > settings.slides.locked_watch_s
}

/// What the variation means. Slides alone are judged elsewhere; here they make a wheel that is not round worse.
fn judge(found: Variation, slid_hard: bool, settings: &WheelFlatSettings) -> Indicator {
    let (grade, words) = if found.low > settings.variation_act {
        (Grade::Act, "far from round")
    } else if found.low > settings.variation_watch && slid_hard {
        (Grade::Act, "likely a wheel flat: not round after hard slides")
    } else if found.low > settings.variation_watch {
        (Grade::Watch, "not round")
    } else if found.high <= settings.variation_watch {
        (Grade::Ok, "round as far as its speed shows")
    } else {
        (Grade::Unknown, "too uncertain to judge")
    };
    let reason = format!(
        "{words}: speed varies by {:.2} ‰ a turn, {:.2} to {:.2} ‰, over {:.0} turns",
        1e3 * found.value,
        1e3 * found.low,
        1e3 * found.high,
        found.turns
    );
    known(found.value, found.low, found.high, grade, &reason)
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_messages::Text;

    #[test]
    fn a_wheel_that_is_not_round_is_worse_after_hard_slides() {
        let settings = WheelFlatSettings::default();
        let found = |low: f64, high: f64| Variation { value: 0.5 * (low + high), low, high, turns: 1400.0 };
        for (low, high, slid_hard, grade) in [
            (0.0, 1e-4, false, Grade::Ok),
            (0.0, 1e-4, true, Grade::Ok),
            (0.0, 9e-4, true, Grade::Unknown),
            (5e-4, 7e-4, false, Grade::Watch),
            (5e-4, 7e-4, true, Grade::Act),
            (1.5e-3, 1.7e-3, false, Grade::Act),
        ] {
            let judged = judge(found(low, high), slid_hard, &settings);
            assert_eq!(judged.grade(), grade, "{}", judged.reason);
            assert!(judged.reason.as_str().len() < Text::CAPACITY && !judged.reason.as_str().ends_with('…'));
        }
    }
}
