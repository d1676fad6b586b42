//! Whether the model explains the data for long.

use super::filter;
use super::judging::unknown;
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Meaning, Metric, Reach, Stored};

/// As [`super::FILTER`], over minutes; the estimator, which knows the terms of the equations, fills it in.
pub static MODEL: IndicatorSpec = IndicatorSpec {
    id: "model",
    label: "Model over time",
    form: Form::FACTOR,
    judge: Judge { wagon: Some(|_, _| unknown("watched over longer times by the estimator")), ..Judge::NONE },
    limit: Some(|settings, _| filter::limit(settings)),
    // What the filter shows within seconds, this shows over minutes with the term to suspect.
    alert: Some(AlertRule::of("filter", Reach::Wagon, Advice::LOOK)),
    stored: Stored::Value,
    metric: Some(Metric::gauge(
        "model_innovation_ratio",
        "Mean normalised innovation squared over its degrees of freedom, of minutes",
    )),
    meaning: Meaning {
        name: "Model over time",
        block: "health assessment",
        definition: "The same over minutes, watched by output and by what the wagon does; where it stays too large, the term of the equations to suspect is named and the latest minutes are kept as a recording for `railgrip gap diagnose`.",
        limits: |_, _| {
            "By a sequential test against chance; it speaks through the alert of the filter.".to_owned()
        },
        cannot_see: "As for the filter.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};
