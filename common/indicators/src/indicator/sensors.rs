//! Whether the sensors deliver.

use super::judging::{known, large, unknown};
use crate::measure::sensors::Faulty;
use crate::settings::SensorSettings;
use crate::spec::{Advice, AlertRule, Form, IndicatorSpec, Judge, Limit, Meaning, Metric, Reach, Stored};
use railgrip_messages::{Grade, Indicator};

/// Share of sensor values that are missing, refused, frozen or dead.
pub static SENSORS: IndicatorSpec = IndicatorSpec {
    id: "sensors",
    form: Form::PERCENT,
    judge: Judge {
        wagon: Some(|seen, _| {
            let state = &seen.state;
            judge(
                state.missing.mean(0.5),
                state.refused.mean(0.5),
                state.dead.mean(0.5),
                named(state.sensors.faulty(seen.last.wheelset_count())),
                &seen.settings.sensors,
            )
        }),
        ..Judge::NONE
    },
    limit: Some(|settings, _| {
        let sensors = &settings.sensors;
        let scale_high = (1.5 * sensors.faulty_share_act).min(1.0);
        Limit::above(scale_high, sensors.faulty_share_watch, sensors.faulty_share_act)
    }),
    // A share of refused values comes with every slide and goes with it; a sensor that is dead does not.
    alert: Some(AlertRule {
        patience: [15.0, 1.0],
        ..AlertRule::of(
            "sensors",
            Reach::Wagon,
            Advice {
                wagon: "Check the named sensors and their wiring on this wagon.",
                train: "Many sensors at once: check their common supply and data bus first.",
            },
        )
    }),
    stored: Stored::Value,
    trend: Reach::Wagon,
    metric: Some(Metric::gauge("sensor_faulty_ratio", "Share of sensor values missing or refused")),
    meaning: Meaning {
        name: "Faulty sensor values",
        block: "acquisition",
        definition: "Share of sensor values that are missing, refused by the filter, frozen or dead; the sensors are named.",
        unit: "% of the values",
        interval: "none: they are counted",
        limits: |settings, _| {
            format!(
                "Watch above {:.0} %, act above {:.0} % or when a sensor is dead.",
                100.0 * settings.sensors.faulty_share_watch,
                100.0 * settings.sensors.faulty_share_act
            )
        },
        cannot_see: "A sensor with a small error, and an error common to all sensors.",
    },
    ..IndicatorSpec::PLAIN
};

/// Share of sensor values missing, refused or dead, with the faulty ones by name (true: dead ones among them).
fn judge(
    missing: Option<f64>,
    refused: Option<f64>,
    dead: Option<f64>,
    faulty: Option<(bool, String)>,
    settings: &SensorSettings,
) -> Indicator {
    let Some((missing, refused)) = missing.zip(refused) else { return unknown("no samples yet") };
    let dead = dead.unwrap_or_default();
    let share = (missing + refused + dead).min(1.0);
    let mut grade = large(share, settings.faulty_share_watch, settings.faulty_share_act);
    if faulty.as_ref().is_some_and(|(any_dead, _)| *any_dead) {
        grade = Grade::Act;
    }
    let named = faulty.map_or_else(String::new, |(_, words)| format!("{words}: "));
    known(share, share, share, grade, &format!("{named}{}", shares(missing, refused, dead)))
}

/// What is wrong with the values, without what nothing is wrong with.
fn shares(missing: f64, refused: f64, dead: f64) -> String {
    let all = [
        (missing, "of the values missing"),
        (refused, "of the values refused"),
        (dead, "of the values dead"),
    ];
    let seen: Vec<String> = all
        .iter()
        .map(|(share, what)| (format!("{:.1}", 100.0 * share), what))
        .filter(|(percent, _)| percent != "0.0")
        .map(|(percent, what)| format!("{percent} % {what}"))
        .collect();
    if seen.is_empty() { "no value missing, refused or dead".to_owned() } else { seen.join(", ") }
}

/// The faulty sensors in words, for example `wheel speed 2 dead`; `None` if there are none.
fn named(faulty: impl Iterator<Item = Faulty>) -> Option<(bool, String)> {
    let (mut words, mut any_dead): (Vec<String>, bool) = (Vec::new(), false);
    for sensor in faulty {
        let place = sensor.wheelset.map_or_else(String::new, |wheelset| format!(" {}", wheelset + 1));
        words.push(format!("{}{place} {}", sensor.what, if sensor.dead { "dead" } else { "bad" }));
        any_dead |= sensor.dead;
    }
    (!words.is_empty()).then(|| (any_dead, words.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_messages::Text;

    #[test]
    fn what_nothing_is_wrong_with_is_not_listed() {
        assert_eq!(shares(0.2, 0.0, 0.0004), "20.0 % of the values missing");
        assert_eq!(shares(0.0, 0.5, 0.25), "50.0 % of the values refused, 25.0 % of the values dead");
        assert_eq!(shares(0.0, 0.0, 0.0), "no value missing, refused or dead");
    }

    #[test]
    fn every_reason_fits_into_its_field() {
        let dead = Some((true, "pressing force 2 dead".to_owned()));
        let judged = judge(Some(0.5), Some(0.5), None, dead, &SensorSettings::default());
        assert_eq!(judged.grade(), Grade::Act);
        assert!(judged.reason.as_str().len() < Text::CAPACITY, "{}", judged.reason);
    }
}
