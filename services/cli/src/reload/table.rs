//! Which processes a setting touches, and how: the one table of what a reload does.

use std::fmt::Write as _;

use railgrip_settings::{MicrophoneSettings, Source, TrainSettings, WagonSettings};

use super::role::Who;

/// How a process follows a setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Way {
    /// It takes it over while it runs.
    Live,
    /// It is started again.
    Restart,
}

/// Where a setting stands, and how to tell that it has changed.
#[derive(Debug, Clone, Copy)]
pub(super) enum Differs {
    /// Once in the config.
    Train(fn(&TrainSettings, &TrainSettings) -> bool),
    /// Once a wagon.
    Wagon(fn(&WagonSettings, &WagonSettings) -> bool),
    /// Once a microphone.
    Microphone(fn(&MicrophoneSettings, &MicrophoneSettings) -> bool),
}

/// One row of the table.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    /// The key, or the table, in the config.
    pub key: &'static str,
    pub differs: Differs,
    /// Whom it touches; nobody where it cannot change while the train runs.
    pub touches: &'static [(Who, Way)],
}

const fn train(
    key: &'static str,
    touches: &'static [(Who, Way)],
    differs: fn(&TrainSettings, &TrainSettings) -> bool,
) -> Row {
    Row { key, differs: Differs::Train(differs), touches }
}

const fn wagon(
    key: &'static str,
    touches: &'static [(Who, Way)],
    differs: fn(&WagonSettings, &WagonSettings) -> bool,
) -> Row {
    Row { key, differs: Differs::Wagon(differs), touches }
}

const ESTIMATORS: &[(Who, Way)] = &[(Who::Estimators, Way::Restart)];
const ESTIMATORS_LIVE: &[(Who, Way)] = &[(Who::Estimators, Way::Live)];
const HEALTH: &[(Who, Way)] = &[(Who::Health, Way::Restart)];
const HEALTH_LIVE: &[(Who, Way)] = &[(Who::Health, Way::Live)];
const INGEST: &[(Who, Way)] = &[(Who::Ingest, Way::Restart)];
const NOBODY: &[(Who, Way)] = &[];

/// Every setting.
pub(super) const ROWS: &[Row] = &[
    // The channels and the processes of a train are made when it starts.
    train("train.name", NOBODY, |a, b| a.name != b.name),
    train("train.wagons", NOBODY, |a, b| a.wagons.len() != b.wagons.len()),
    train("train.coupled", NOBODY, |a, b| a.judged_together != b.judged_together),
    train("microphone.wagon", NOBODY, |a, b| microphones(a) != microphones(b)),
    train("instance.dir", NOBODY, |a, b| a.instance.dir != b.instance.dir),
    train("instance.prefix", NOBODY, |a, b| a.instance.prefix != b.instance.prefix),
    train("instance.snapshot_dir", NOBODY, |a, b| a.instance.snapshot_dir != b.instance.snapshot_dir),
    train("source.kind", NOBODY, |a, b| way_in(&a.source) != way_in(&b.source)),
    train("diagnosis.automatic", NOBODY, |a, b| a.diagnosis.automatic != b.diagnosis.automatic),
    train("logging.format", NOBODY, |a, b| a.logging.format != b.logging.format),
    train("logging.level", &[(Who::All, Way::Live)], |a, b| a.logging.level != b.logging.level),
    train("source", INGEST, |a, b| a.source != b.source),
    train("mapping", INGEST, |a, b| a.mapping != b.mapping),
    train("samples.batch_ms", INGEST, |a, b| a.batch_s != b.batch_s),
    train("estimator", ESTIMATORS, |a, b| a.estimator != b.estimator),
    train("reporting", ESTIMATORS_LIVE, |a, b| a.reporting != b.reporting),
    // The map of the track was begun with it.
    train("indicators.adhesion.prior_dry", HEALTH, |a, b| {
        a.indicators.adhesion.prior_dry != b.indicators.adhesion.prior_dry
    }),
    train("indicators", &[(Who::Estimators, Way::Live), (Who::Health, Way::Live)], |a, b| {
        a.indicators != b.indicators
    }),
    train("http.listen", HEALTH, |a, b| a.http.listen != b.http.listen),
    train("http.cors_origins", HEALTH, |a, b| a.http.cors_origins != b.http.cors_origins),
    train("http", HEALTH, |a, b| a.access != b.access),
    train("http.refresh_ms", HEALTH_LIVE, |a, b| a.http.refresh_s != b.http.refresh_s),
    train("http.stale_after_s", HEALTH_LIVE, |a, b| a.http.stale_after_s != b.http.stale_after_s),
    train("alerts", HEALTH_LIVE, |a, b| a.alerts != b.alerts),
    train("alerts.journal", HEALTH, |a, b| a.alert_journal != b.alert_journal),
    train("receiver", HEALTH_LIVE, |a, b| a.notify != b.notify),
    train("capability", HEALTH, |a, b| a.capability != b.capability),
    train("history", HEALTH, |a, b| a.history != b.history),
    train("acoustics", &[(Who::Listeners, Way::Restart)], |a, b| a.acoustics != b.acoustics),
    train("diagnosis", &[(Who::Diagnoser, Way::Restart)], |a, b| a.diagnosis != b.diagnosis),
    wagon(
        "number",
        &[
            (Who::Estimators, Way::Restart),
            (Who::Judge, Way::Restart),
            (Who::Health, Way::Restart),
            (Who::Ingest, Way::Restart),
        ],
        |a, b| a.vehicle_number != b.vehicle_number,
    ),
    wagon("name", HEALTH, |a, b| a.name != b.name),
    wagon("turned", &[(Who::Estimators, Way::Restart), (Who::Judge, Way::Restart)], |a, b| {
        a.turned != b.turned
    }),
    wagon(
        "vehicle",
        &[
            (Who::Estimators, Way::Restart),
            (Who::Listeners, Way::Restart),
            (Who::Judge, Way::Restart),
            (Who::Health, Way::Restart),
            (Who::Ingest, Way::Restart),
        ],
        |a, b| a.vehicle != b.vehicle || a.plant != b.plant,
    ),
    wagon("simulated", INGEST, |a, b| a.simulated != b.simulated),
    wagon("filter", ESTIMATORS, |a, b| a.filter != b.filter),
    Row {
        key: "microphone",
        differs: Differs::Microphone(|a, b| a != b),
        touches: &[(Who::Listeners, Way::Restart), (Who::Ingest, Way::Restart)],
    },
];

/// The table for people, as Markdown.
pub(crate) fn explained() -> String {
    let mut text = "\n## While the train runs\n\nOn SIGHUP (`systemctl reload`, or `kill -HUP` of `railgrip up`) the config is read \
                    again. What is wrong with it, or cannot change, is named, and then nothing changes.\n\n\
                    | key or table | a change |\n| --- | --- |\n"
        .to_owned();
    for row in ROWS {
        let key = match row.differs {
            Differs::Wagon(_) => format!("wagon.{}", row.key),
            Differs::Train(_) | Differs::Microphone(_) => row.key.to_owned(),
        };
        let of = |wanted: Way| -> Vec<&str> {
            row.touches.iter().filter(|(_, way)| *way == wanted).map(|(who, _)| who.word()).collect()
        };
        let (live, restart) = (of(Way::Live).join(", "), of(Way::Restart).join(", "));
        let what = match (live.as_str(), restart.as_str()) {
            ("", "") => "is refused: it needs a new start of the train".to_owned(),
            (live, "") => format!("is taken over by {live}"),
            (_, restart) => format!("starts again, one after another: {restart}"),
        };
        // Writing into a string cannot fail.
        let _ = writeln!(text, "| `{key}` | {what} |");
    }
    text
}

/// Wagons with a microphone.
fn microphones(settings: &TrainSettings) -> Vec<u32> {
    settings.microphones.iter().map(|microphone| microphone.wagon).collect()
}

/// By which way samples come in: no process of ours, our standard input, or whatever ingest opens itself.
fn way_in(source: &Source) -> u8 {
    match source {
        Source::External => 0,
        Source::Stdin => 1,
        _ => 2,
    }
}

/// A setting that is new does not compile until it is named here; it then needs a row above.
const _: fn(TrainSettings) = |settings| {
    let TrainSettings {
        file: _,
        name: _,
        wagons: _,
        judged_together: _,
        microphones: _,
        acoustics: _,
        instance: _,
        source: _,
        mapping: _,
        batch_s: _,
        estimator: _,
        reporting: _,
        indicators: _,
        http: _,
        access: _,
        alerts: _,
        alert_journal: _,
        notify: _,
        capability: _,
        diagnosis: _,
        history: _,
        logging: _,
    } = settings;
};
const _: fn(WagonSettings) = |wagon| {
    let WagonSettings {
        number: _,
        name: _,
        vehicle_number: _,
        turned: _,
        vehicle: _,
        plant: _,
        simulated: _,
        filter: _,
    } = wagon;
};
