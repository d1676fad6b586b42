//! Whether the filter's expectation and the data agree now.

use super::judging::{known, unknown};
use crate::settings::{FilterSettings, IndicatorSettings};
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach, Stored};
use railgrip_messages::{Grade, Indicator};

/// Mean normalised innovation squared over its degrees of freedom, of the latest seconds.
pub static FILTER: IndicatorSpec = IndicatorSpec {
    id: "filter",
    form: Form::FACTOR,
    judge: Judge {
        wagon: Some(|seen, _| judge(seen.state.nis.mean(0.5), &seen.settings.filter)),
        ..Judge::NONE
    },
    limit: Some(|settings, _| limit(settings)),
    // A filter that disagrees comes with every slide and goes with it.
    alert: Some(AlertRule {
        of_free_wagon: true,
        patience: [60.0, 15.0],
        inhibited_by: &["sensors"],
        recorded: true,
        ..AlertRule::of(
            "filter",
            Reach::Wagon,
            Advice {
                wagon: "The model does not fit this wagon: run `railgrip gap diagnose` on the saved recording.",
                train: "The model fits none of these wagons: check vehicle file, loads and gradient, then run `railgrip gap diagnose`.",
            },
        )
    }),
    stored: Stored::Value,
    trend: Reach::Wagon,
    metric: Some(Metric::gauge(
        "filter_innovation_ratio",
        "Mean normalised innovation squared over its degrees of freedom",
    )),
    meaning: Meaning {
        name: "Filter",
        block: "manipulation",
        definition: "Mean normalised innovation squared over its degrees of freedom, over the last seconds. It compares the data with what the filter expects; 1 is ideal.",
        limits: |settings, _| {
            let filter = &settings.filter;
            format!(
                "Watch above {} or below {}, act above {}. Nothing is judged below {:.0} km/h.",
                filter.nis_watch_high,
                filter.nis_watch_low,
                filter.nis_act_high,
                3.6 * filter.min_speed_m_s
            )
        },
        cannot_see: "A mismatch that the filter absorbs into another state: the figures are then wrong without any sign of it.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};

/// Limits of a mean normalised innovation squared.
pub(super) fn limit(settings: &IndicatorSettings) -> Limit {
    let filter = &settings.filter;
    Limit {
        watch_low: Some(filter.nis_watch_low),
        ..Limit::above(1.2 * filter.nis_act_high, filter.nis_watch_high, filter.nis_act_high)
    }
}

/// Mean normalised innovation squared over its degrees of freedom.
fn judge(ratio: Option<f64>, settings: &FilterSettings) -> Indicator {
    let Some(ratio) = ratio else { return unknown("no innovations yet") };
    let limits = settings;
    let (grade, words) = if ratio > limits.nis_act_high {
        (Grade::Act, "model and data disagree")
    } else if ratio > limits.nis_watch_high {
        (Grade::Watch, "model and data differ more than the sensors explain")
    } else if ratio < limits.nis_watch_low {
        (Grade::Watch, "data vary less than the declared sensor noise")
    } else {
        (Grade::Ok, "model and data agree")
    };
    known(ratio, ratio, ratio, grade, &format!("{words}: innovation ratio {ratio:.2}, ideal 1"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_messages::Text;

    #[test]
    fn every_reason_fits_into_its_field() {
        for ratio in [1e9, 0.1] {
            let judged = judge(Some(ratio), &FilterSettings::default());
            assert!(judged.reason.as_str().len() < Text::CAPACITY, "{}", judged.reason);
        }
    }
}
