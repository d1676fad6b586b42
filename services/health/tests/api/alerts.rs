//! What becomes an alert, whose it is, and what is said of it until it is over.

use super::{NOW, get, get_json, health, indicator, later, serve, sound_train};
use railgrip_health::store::Store;
use railgrip_indicators::INDICATORS;
use railgrip_indicators::indicator::{BRAKE_FRICTION, RAIL};
use railgrip_messages::{Event, EventKind, Grade, Indicator, NO_WHEELSET, Stamp, Text};
use serde_json::Value;

/// Samples that the source withholds because of their units once were "no data: check the data connection", and a clock that
/// drifts reached nobody.
#[tokio::test]
async fn what_the_source_says_of_a_wagon_is_its_alert() {
    let mut store = sound_train();
    let event = |kind: EventKind, grade: Grade, wagon: u32, text: &str, now: Stamp| Event {
        stamp: now,
        kind: kind.code(),
        grade: grade.code(),
        wagon,
        wheelset: NO_WHEELSET,
        text: Text::new(text),
        ..Event::default()
    };
    let why = "samples withheld: column v_m_s cannot be in m/s";
    let drift = "the clock of the source drifts by 1000 parts in a million";
    let run = |store: &mut Store, from: f64, withheld: bool| {
        for tenth in 0..300 {
            let now = later(from + f64::from(tenth) * 0.1);
            for wagon in (1..=8).filter(|wagon| !withheld || *wagon != 2) {
                store.receive_health(wagon, &health(wagon, now), now).unwrap();
            }
            if tenth % 100 == 0 {
                let grade = if withheld { Grade::Act } else { Grade::Ok };
                store.receive_event(&event(EventKind::UnitsImplausible, grade, 2, why, now), now).unwrap();
                let grade = if withheld { Grade::Watch } else { Grade::Ok };
                store.receive_event(&event(EventKind::ClockDrifts, grade, 3, drift, now), now).unwrap();
            }
            let _ = store.snapshot(now);
        }
        later(from + 30.0)
    };
    let causes = |alerts: Value| -> Vec<(String, String)> {
        let text = |alert: &Value, key: &str| alert[key].as_str().unwrap_or_default().to_owned();
        let all = alerts["alerts"].as_array().unwrap().clone();
        all.iter()
            .filter(|alert| alert["active"] == true)
            .map(|a| (text(a, "cause"), text(a, "reason")))
            .collect()
    };
    let now = run(&mut store, 0.0, true);
    let (router, _) = serve(&mut store, now);
    let mut active = causes(get_json(&router, "/api/v1/alerts").await);
    active.sort();
    assert_eq!(active.len(), 2, "{active:?}");
    assert!(active[0].0 == "source_clock" && active[0].1.contains("1000 parts"), "{active:?}");
    assert!(active[1].0 == "units" && active[1].1.contains(why), "{active:?}");
    // A process that says what is none of its business is refused.
    let wrong =
        Event { values: [f64::NAN; 4], ..event(EventKind::UnitsImplausible, Grade::Act, 5, "x", now) };
    assert!(store.receive_event(&wrong, now).is_none());
    let wrong = event(EventKind::UnitsImplausible, Grade::Act, 99, "x", now);
    assert!(store.receive_event(&wrong, now).is_none());
    let wrong = Event { kind: 9999, ..wrong };
    assert!(store.receive_event(&wrong, now).is_none());
    let mut now = run(&mut store, 30.0, false);
    for minutes in 1..=4 {
        now = run(&mut store, 30.0 + 30.0 * f64::from(minutes), false);
    }
    let (router, _) = serve(&mut store, now);
    assert_eq!(causes(get_json(&router, "/api/v1/alerts").await), []);
}

#[tokio::test]
async fn a_bad_brake_becomes_one_alert_with_advice() {
    let mut store = sound_train();
    let mut news = Vec::new();
    for tenth in 0..40 {
        let now = later(f64::from(tenth) * 0.1);
        for wagon in 1..=8 {
            let mut health = health(wagon, now);
            if wagon == 5 {
                BRAKE_FRICTION.put_wheelset(&mut health, 1, indicator(0.2, Grade::Act, "far too low: 0.200"));
                health.grade = Grade::Act.code();
            }
            assert!(store.receive_health(wagon, &health, now).is_some());
        }
        news.extend(store.snapshot(now).news);
    }
    assert_eq!(news.len(), 1);
    let (router, _) = serve(&mut store, later(4.0));
    let alerts = get_json(&router, "/api/v1/alerts").await["alerts"].clone();
    println!("{alerts}");
    assert_eq!(alerts.as_array().unwrap().len(), 1);
    let alert = &alerts[0];
    assert_eq!(
        (&alert["wagon"], &alert["wheelset"], &alert["cause"]),
        (&5.into(), &2.into(), &"brake_friction".into())
    );
    assert_eq!((&alert["active"], &alert["grade"]), (&true.into(), &"act".into()));
    assert_eq!(alert["raised_at"], "2026-03-01T12:00:02.000Z");
    let train = get_json(&router, "/api/v1/train").await;
    assert_eq!((&train["grade"], &train["worst"][0]["id"]), (&"act".into(), &5.into()));
    assert_eq!(train["reason"], "wagon 5: Pad friction of wheelset 2: far too low: 0.200");
    assert_eq!(train["alerts"]["act"], 1);
    let (_, _, page) = get(&router, "/").await;
    assert!(page.contains("Wheelset 2: far too low: 0.200"), "{page}");
}

/// Eight wagons slide over one slippery stretch: that is no fault of theirs.
#[tokio::test]
async fn a_low_rail_is_one_alert_of_the_line_and_leaves_the_wagons_as_they_are() {
    let mut store = sound_train();
    let mut play = |from: u32, until: u32, rail: Indicator| {
        for tenth in from..until {
            let now = later(f64::from(tenth) * 0.1);
            for wagon in 1..=8 {
                let mut health = health(wagon, now);
                RAIL.put(&mut health, rail);
                health.grade = INDICATORS.worst(&health).code();
                assert!(store.receive_health(wagon, &health, now).is_some());
            }
            store.snapshot(now);
        }
        serve(&mut store, later(f64::from(until) * 0.1)).0
    };
    let router = play(0, 40, indicator(0.9, Grade::Watch, "adhesion is low: low 90 %, wet 10 %"));
    let alerts = get_json(&router, "/api/v1/alerts").await["alerts"].clone();
    assert_eq!(alerts.as_array().unwrap().len(), 1, "{alerts}");
    assert_eq!((&alerts[0]["scope"], &alerts[0]["grade"]), (&"train".into(), &"watch".into()));
    let train = get_json(&router, "/api/v1/train").await;
    assert_eq!((&train["grade"], train["worst"].as_array().unwrap().len()), (&"watch".into(), 0));
    let wagons = get_json(&router, "/api/v1/wagons").await["wagons"].clone();
    assert!(wagons.as_array().unwrap().iter().all(|wagon| wagon["grade"] == "ok"), "{wagons}");
    let (_, _, page) = get(&router, "/").await;
    assert!(page.contains("The train needs a look") && page.contains("<small> alert</small>"), "{page}");
    // Dry again: the alert lasts a little, and does not say what is no longer so.
    let router = play(40, 60, indicator(0.9, Grade::Ok, "adhesion is not low: dry 90 %"));
    let reason = get_json(&router, "/api/v1/alerts").await["alerts"][0]["reason"].clone();
    let reason = reason.as_str().unwrap().to_owned();
    assert!(reason.contains("well since 2026-03-01T12:00:04.000Z; before: adhesion is low"), "{reason}");
}

#[tokio::test]
async fn what_is_well_again_is_worth_a_look_until_its_alert_is_over() {
    let mut store = sound_train();
    for tenth in 0..60 {
        let now = later(f64::from(tenth) * 0.1);
        for wagon in 1..=8 {
            let mut health = health(wagon, now);
            if wagon == 5 && tenth < 40 {
                BRAKE_FRICTION.put_wheelset(&mut health, 1, indicator(0.2, Grade::Act, "far too low: 0.200"));
                health.grade = Grade::Act.code();
            }
            assert!(store.receive_health(wagon, &health, now).is_some());
        }
        store.snapshot(now);
    }
    let (router, _) = serve(&mut store, later(6.0));
    let train = get_json(&router, "/api/v1/train").await;
    let since = "2026-03-01T12:00:04.000Z";
    assert_eq!(train["grade"], "watch", "the figures are well again, and the alert is there still");
    assert_eq!((&train["worst"][0]["id"], &train["worst"][0]["grade"]), (&5.into(), &"watch".into()));
    assert_eq!(train["alerts"], serde_json::json!({"watch": 1, "act": 0}));
    let alert = get_json(&router, "/api/v1/alerts").await["alerts"][0].clone();
    assert_eq!(
        (&alert["active"], &alert["grade"], &alert["grade_now"]),
        (&true.into(), &"act".into(), &"watch".into())
    );
    assert_eq!(
        (&alert["places"][0]["grade"], &alert["places"][0]["well_since"]),
        (&"watch".into(), &since.into())
    );
    let wagon = get_json(&router, "/api/v1/wagons/5").await;
    assert_eq!((&wagon["grade"], &wagon["wheelsets"][1]["grade"]), (&"watch".into(), &"watch".into()));
    // Banner, tile, wheel marker, table and alerts of all pages: where it says that it is well, nothing is red.
    for path in ["/", "/wagons/5", "/alerts"] {
        let (_, _, page) = get(&router, path).await;
        assert!(page.contains("ell since") && !page.contains("All wagons are well"), "{path}: {page}");
        let legend = page.matches("chip g-act").count() + page.matches("class=\"axle g-act\"").count();
        let shown = page.matches("g-act").count();
        let explained = if path == "/" { 3 } else { 1 };
        assert_eq!((legend, shown), (explained, explained), "only the legend and the foot of {path}: {page}");
    }
    let (_, _, page) = get(&router, "/").await;
    assert!(page.contains("1 wagon needs a look") && page.contains("verdict g-watch"), "{page}");
    let (_, _, well) = get(&serve(&mut sound_train(), NOW).0, "/").await;
    assert!(well.contains("All wagons are well"));
}

/// "Wagon 8: wagon 8: well since" once stood above the train.
#[tokio::test]
async fn a_wagon_that_speaks_again_is_named_once() {
    let mut store = sound_train();
    let mut play = |from_s: u32, until_s: u32, wagons: std::ops::Range<u32>| {
        for tenth in 10 * from_s..10 * until_s {
            let now = later(f64::from(tenth) * 0.1);
            for wagon in wagons.clone() {
                store.receive_health(wagon, &health(wagon, now), now).unwrap();
            }
            let _ = store.snapshot(now);
        }
    };
    play(0, 20, 1..9);
    play(20, 40, 1..8);
    play(40, 41, 1..9);
    let (router, _) = serve(&mut store, later(41.0));
    let alert = get_json(&router, "/api/v1/alerts").await["alerts"][0].clone();
    assert_eq!((&alert["cause"], &alert["grade_now"]), (&"silent".into(), &"watch".into()));
    let row = get_json(&router, "/api/v1/train").await["worst"][0].clone();
    let reason = row["reason"].as_str().unwrap();
    assert!(reason.starts_with("well since 2026-03-01T12:00:40.000Z; before: no data since"), "{reason}");
    let train = get_json(&router, "/api/v1/train").await;
    assert_eq!(train["reason"], format!("wagon 8: {reason}"));
}

/// A recording that was played to its end once raised "no data, act" for every wagon.
#[tokio::test]
async fn a_recording_that_has_ended_is_not_missing() {
    let silent = |ended: Option<f64>| async move {
        let mut store = sound_train();
        let play = |store: &mut Store, from: f64, until: f64, wagons: std::ops::Range<u32>| {
            for tenth in (from * 10.0) as u32..(until * 10.0) as u32 {
                let now = later(f64::from(tenth) * 0.1);
                for wagon in wagons.clone() {
                    store.receive_health(wagon, &health(wagon, now), now).unwrap();
                }
                let _ = store.snapshot(now);
            }
        };
        play(&mut store, 0.0, 20.0, 1..9);
        // One wagon stays away before the others.
        play(&mut store, 20.0, 40.0, 1..8);
        if let Some(at_s) = ended {
            let event = Event {
                stamp: later(at_s),
                kind: EventKind::SourceChanged.code(),
                grade: Grade::Unknown.code(),
                wagon: railgrip_messages::NO_WAGON,
                wheelset: NO_WHEELSET,
                text: Text::new("the recording has ended"),
                ..Event::default()
            };
            assert!(store.receive_event(&event, later(at_s)).is_some());
        }
        play(&mut store, 40.0, 60.0, 0..0);
        let (router, _) = serve(&mut store, later(60.0));
        let alerts = get_json(&router, "/api/v1/alerts?state=active").await["alerts"].clone();
        let of = alerts.as_array().unwrap().iter().filter(|alert| alert["cause"] == "silent");
        of.flat_map(|alert| alert["wagons"].as_array().unwrap().clone())
            .map(|w| w.to_string())
            .collect::<Vec<_>>()
    };
    assert_eq!(silent(Some(40.2)).await, ["8"], "only what was missing before the end");
    assert_eq!(silent(None).await.len(), 8, "a source that stops without a word is missing");
}
