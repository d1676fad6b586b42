//! The condition of the rail.

use super::judging::known;
use crate::belief::CLASSES;
use crate::settings::AdhesionSettings;
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Meaning, Reach, Stored};
use railgrip_messages::{Condition, Grade, Indicator};

/// Probability of the most probable condition; the probability of each is a signal of its own.
pub static RAIL: IndicatorSpec = IndicatorSpec {
    id: "rail",
    form: Form::PERCENT,
    judge: Judge {
        wagon: Some(|seen, _| judge(seen.rail_classes(), &seen.settings.adhesion)),
        ..Judge::NONE
    },
    alert: Some(AlertRule {
        of_free_wagon: true,
        of_train: true,
        ..AlertRule::of(
            "rail",
            Reach::Wagon,
            Advice::same(
                "Expect long braking distances here. Sand or reduce speed, and warn following trains.",
            ),
        )
    }),
    stored: Stored::Nothing,
    meaning: Meaning {
        name: "Rail",
        definition: "Probability that the rail is dry, wet, low or very low, from slides and from rolling without a slide (Bayes' rule). Without new evidence it returns to the usual values.",
        unit: "% probability",
        interval: "none: the probabilities express the uncertainty",
        limits: |settings, _| {
            format!(
                "Watch from {:.0} % probability of low or very low, act from {:.0} % of very low, ok up to {:.0} %; unknown in between.",
                100.0 * settings.adhesion.low_probability_watch,
                100.0 * settings.adhesion.very_low_probability_act,
                100.0 * settings.adhesion.low_probability_ok
            )
        },
        cannot_see: "Why the rail is low: leaves, water, oil or ice. A rail of which little adhesion is asked looks like a better one.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};

/// The rail's condition from the probabilities of dry, wet, low and very low.
fn judge(classes: [f64; CLASSES], settings: &AdhesionSettings) -> Indicator {
    let best = classes.iter().copied().fold(0.0, f64::max);
    let poor = classes[2] + classes[3];
    let (grade, words) = if classes[3] >= settings.very_low_probability_act {
        (Grade::Act, "adhesion is very low")
    } else if poor >= settings.low_probability_watch {
        (Grade::Watch, "adhesion is low")
    } else if poor <= settings.low_probability_ok {
        (Grade::Ok, "adhesion is not low")
    } else {
        (Grade::Unknown, "no evidence yet: no slide, and little adhesion used")
    };
    let mut order = [0, 1, 2, 3];
    order.sort_by(|a, b| classes[*b].total_cmp(&classes[*a]));
    let said = order.into_iter().filter(|class| classes[*class] >= 0.005);
    let said: Vec<String> =
        said.map(|class| format!("{} {:.0} %", Condition::ALL[class], 100.0 * classes[class])).collect();
    let reason = format!("{words}: {}", said.join(", "));
    known(best, best, best, grade, &reason)
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_messages::Text;

    #[test]
    fn every_reason_fits_into_its_field() {
        let settings = AdhesionSettings::default();
        let doubtful = AdhesionSettings { low_probability_watch: 0.9, ..settings };
        for judged in [judge([0.05, 0.05, 0.45, 0.45], &settings), judge([0.25; 4], &doubtful)] {
            assert!(judged.reason.as_str().len() < Text::CAPACITY, "{}", judged.reason);
        }
    }
}
