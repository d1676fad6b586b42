//! A train that needs far to stop says so: the indicator of the whole train, its alert and its metric.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use railgrip_health::alerts::model::{Alert, Scope};
use railgrip_health::api::grade::Grade;
use railgrip_health::api::metrics;
use railgrip_health::shared::Build;
use railgrip_health::store::{Snapshot, Store};
use railgrip_indicators::indicator::judging::known;
use railgrip_indicators::indicator::{ADHESION_AVAILABLE, BRAKE_FRICTION, STOPPING_DISTANCE};
use railgrip_messages::{Health, Stamp};
use railgrip_settings::{Overrides, TrainSettings};
use std::path::Path;

/// Two minutes of a train whose pads rub with this friction, on a good rail.
fn train(friction: f64) -> Snapshot {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml");
    let mut store = Store::new(&TrainSettings::load(Some(&file), &Overrides::default()).unwrap());
    let mut snapshot = None;
    for second in 0..120_u64 {
        let monotonic_ns = (1000 + second) * 1_000_000_000;
        let at = Stamp { unix_ns: 1_772_366_400_000_000_000 + monotonic_ns.cast_signed(), monotonic_ns };
        for wagon in 1..=8 {
            let mut health = Health { wagon, wheelsets: 2, acquired: at, v_m_s: 20.0, ..Health::default() };
            health.published_monotonic_ns = monotonic_ns;
            let ok = railgrip_messages::Grade::Ok;
            BRAKE_FRICTION.put(&mut health, known(friction, friction - 0.01, friction + 0.01, ok, "told"));
            ADHESION_AVAILABLE.put(&mut health, known(0.28, 0.25, 0.3, ok, "seen in a slide"));
            assert!(store.receive_health(wagon, &health, at).is_some());
        }
        snapshot = Some(store.snapshot(at));
    }
    snapshot.unwrap()
}

fn alert(snapshot: &Snapshot) -> Option<&Alert> {
    snapshot.alerts.alerts.iter().find(|alert| alert.cause == STOPPING_DISTANCE.id)
}

#[test]
fn a_long_stopping_distance_raises_one_alert_of_the_train() {
    let sound = train(0.35);
    assert_eq!((sound.whole.capability.grade, alert(&sound)), (Grade::Ok, None));
    let weak = train(0.20);
    println!("{}", weak.whole.capability.reason);
    let alert = alert(&weak).unwrap();
    assert_eq!((alert.scope, alert.grade, alert.wheelset), (Scope::Train, weak.whole.capability.grade, None));
    assert!(alert.grade >= Grade::Watch && alert.reason.contains("longer than nominal"), "{}", alert.reason);
    assert_eq!(alert.advice, STOPPING_DISTANCE.alert.unwrap().advice.train);
    assert!(alert.wagons.is_empty(), "it is no wagon's: {:?}", alert.wagons);
    let text = metrics::text(&weak, 0, None, Build::default());
    let line = text.lines().find(|line| line.starts_with("railgrip_stopping_distance_ratio ")).unwrap();
    let ratio: f64 = line.rsplit(' ').next().unwrap().parse().unwrap();
    let [_, low, _] = weak.whole.found.ratio().unwrap();
    assert!(ratio > low && low > 1.2, "{ratio} at least {low}");
}
