//! The table is sound: names, rules and texts of all its entries.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use railgrip_indicators::train::capability::FullBraking;
use railgrip_indicators::{INDICATORS, IndicatorSettings, IndicatorSpec, Nominal, Stored, signals};
use railgrip_messages::{MAX_INDICATORS, MAX_WHEELSET_INDICATORS};
use std::collections::BTreeSet;

const NOMINAL: Nominal = Nominal {
    brake_friction: 0.35,
    rail: [0.30, 0.12, 0.06],
    wheelsets: 2,
    mass_kg: 40e3,
    inertia_kg_m2: 120.0,
    wheel_radius_m: 0.44,
    brake_radius_m: 0.25,
    resistance: [400.0, 8.0, 4.0],
    coupled: false,
};

fn judged_at(spec: &IndicatorSpec) -> usize {
    let judge = &spec.judge;
    [judge.wagon.is_some(), judge.wheelset.is_some(), judge.among.is_some(), judge.train.is_some()]
        .into_iter()
        .filter(|judged| *judged)
        .count()
}

#[test]
fn every_entry_is_judged_and_has_room_in_the_message() {
    for spec in INDICATORS.iter() {
        assert!(judged_at(spec) > 0, "{} is judged nowhere", spec.id);
        assert!(!spec.name().is_empty(), "{}", spec.id);
        assert!(!spec.meaning.definition.is_empty() && !spec.meaning.cannot_see.is_empty(), "{}", spec.id);
        let limits = (spec.meaning.limits)(&IndicatorSettings::default(), &FullBraking::default());
        assert!(limits.ends_with('.'), "{}: {limits}", spec.id);
    }
    assert!(INDICATORS.iter().filter(|spec| spec.judge.wagon.is_some()).count() <= MAX_INDICATORS);
    assert!(
        INDICATORS.iter().filter(|spec| spec.judge.wheelset.is_some()).count() <= MAX_WHEELSET_INDICATORS
    );
}

#[test]
fn names_are_unique_and_end_with_their_unit() {
    let (mut ids, mut metrics, mut fields) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    for spec in INDICATORS.iter() {
        assert!(ids.insert(spec.id), "{} stands twice", spec.id);
        let metric = spec.metric.map(|metric| metric.name);
        if let Some(name) = metric {
            assert!(metrics.insert(name), "{name} stands twice");
            assert!(name.ends_with(spec.unit.metric_suffix()), "{name}");
        }
        // The rail has a metric for each condition, which the service makes.
        assert!(metric.is_some() || spec.id == "rail", "{} has no metric", spec.id);
        if spec.stored != Stored::Nothing {
            assert!(fields.insert(spec.field()), "{} stands twice", spec.field());
            spec.formerly.iter().for_each(|name| assert!(fields.insert((*name).to_owned()), "{name}"));
        }
    }
    for signal in signals::OF_WAGON {
        assert!(fields.insert(signal.field.to_owned()), "{} stands twice", signal.field);
        signal.formerly.iter().for_each(|name| assert!(fields.insert((*name).to_owned()), "{name}"));
    }
}

#[test]
fn every_alert_has_a_cause_that_says_what_to_do() {
    for (spec, alert) in INDICATORS.iter().filter_map(|spec| Some((spec, spec.alert?))) {
        let cause = INDICATORS.find(alert.cause).unwrap();
        let advice = cause.alert.unwrap();
        assert_eq!(advice.cause, cause.id, "{} is grouped under an entry that is grouped elsewhere", spec.id);
        assert!(advice.advice.wagon.ends_with('.') && advice.advice.train.ends_with('.'), "{}", spec.id);
        for other in advice.inhibited_by {
            assert!(
                INDICATORS.find(other).is_some(),
                "{} is inhibited by {other}, which there is not",
                spec.id
            );
        }
    }
}

#[test]
fn limits_lie_in_order_on_their_scale() {
    for spec in INDICATORS.iter() {
        let Some(limit) = spec.limit.map(|limit| limit(&IndicatorSettings::default(), &NOMINAL)) else {
            continue;
        };
        let (low, high) = limit.scale;
        let ends = [Some(low), limit.act_low, limit.watch_low, limit.watch_high, limit.act_high, Some(high)];
        let ends: Vec<f64> = ends.into_iter().flatten().collect();
        assert!(ends.is_sorted(), "{}: {ends:?}", spec.id);
    }
}
