//! Whether the model explains the data for long.

use super::filter;
use super::judging::unknown;
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Meaning, Metric, Reach, Stored};

/// As [`super::FILTER`], over minutes; the estimator, which knows the terms of the equations, fills it in.
pub static MODEL: IndicatorSpec = IndicatorSpec {
    id: "model",
    form: Form::FACTOR,
    judge: Judge { wagon: Some(|_, _| unknown("watched over longer times by the estimator")), ..Judge::NONE },
    limit: Some(|settings, _| filter::limit(settings)),
    // What the filter shows within seconds, this shows over minutes with the term to suspect.
    alert: Some(AlertRule { of_free_wagon: true, ..AlertRule::of("filter", Reach::Wagon, Advice::LOOK) }),
    stored: Stored::Value,
    metric: Some(Metric::gauge(
        "model_innovation_ratio",
        "Mean normalised innovation squared over its degrees of freedom, of minutes",
    )),
    meaning: Meaning {
        name: "Model over time",
        block: "health assessment",
        definition: "The filter's figure over minutes, by output and by driving situation. If it stays too large, the suspected term of the equations is named and the last minutes are saved as a recording for `railgrip gap diagnose`.",
        limits: |_, _| "By a sequential test against chance. It raises the alert of the filter.".to_owned(),
        cannot_see: "As for the filter.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};
