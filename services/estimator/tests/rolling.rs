//! Sanders and wheels on a simulated train whose truth is known: what sand gains, and what comes again with every turn.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]
#![allow(clippy::print_stdout, reason = "tests print the figures they measure")]

use railgrip_estimator::worker::Worker;
use railgrip_indicators::indicator::{SANDING, WHEEL_FLAT};
use railgrip_messages::{Grade, Health, Sample, Stamp, valid};
use railgrip_settings::{Overrides, Source, TrainSettings};
use railgrip_simulation::Train;
use std::path::Path;

const STARTED: Stamp = Stamp { unix_ns: 1_772_366_400_000_000_000, monotonic_ns: 1 };

/// The demo with the hardest braking on its low stretch; there `sand` is a list of demands, and `track` is added to its track.
fn settings(sand: &str, track: &str) -> TrainSettings {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config").canonicalize().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let vehicle = config.join("vehicle.toml").display().to_string();
    let demo = std::fs::read_to_string(config.join("scenarios/demo.toml")).unwrap();
    let scenario = demo
        .replace("../vehicle.toml", &vehicle)
        .replace("brake = 0.85\n", &format!("brake = 1.0\n{sand}"))
        .replace("[track]\n", &format!("[track]\n{track}"));
    std::fs::write(folder.path().join("sand.toml"), scenario).unwrap();
    let text = format!(
        "schema = 1\n[train]\nname = \"t\"\nwagons = 1\nvehicle = \"{vehicle}\"\n[source]\nkind = \"simulate\"\nscenario = \"sand.toml\"\n"
    );
    TrainSettings::parse(&folder.path().join("train.toml"), &text, &Overrides::default()).unwrap()
}

/// What wagon 1 knows after so many seconds; `change` may spoil a sample of which it is given the seconds since the last one.
fn health(settings: &TrainSettings, seconds: f64, mut change: impl FnMut(&mut Sample, f64)) -> Health {
    let Source::Simulate { scenario, .. } = &settings.source else { panic!("{:?}", settings.source) };
    let mut train = Train::new(scenario, &[settings.wagons[0].vehicle.clone()], 1, None).unwrap();
    let mut worker = Worker::new(settings, 1).unwrap();
    let step_s = train.sample_period_s();
    for sequence in 0..(seconds / step_s) as u64 {
        let row = train.step().wagons[0].row;
        let mut sample = Sample { time_s: row.t_s, v_m_s: row.v_m_s, wheelsets: 2, ..Sample::default() };
        sample.valid = valid::SPEED | valid::SANDING;
        sample.sanding = row.sanding;
        for wheelset in 0..2 {
            sample.valid |= valid::wheel_speed(wheelset)
                | valid::pressing_force(wheelset)
                | valid::drive_torque(wheelset);
            sample.wheel_speed_rad_s[wheelset] = row.wheel_speed_rad_s[wheelset];
            sample.pressing_force_n[wheelset] = row.pressing_force_n[wheelset];
            sample.drive_torque_nm[wheelset] = row.drive_torque_nm[wheelset];
        }
        sample.sequence = sequence;
        let since_ns = (sequence as f64 * step_s * 1e9) as u64;
        sample.acquired = Stamp {
            unix_ns: STARTED.unix_ns + since_ns as i64,
            monotonic_ns: STARTED.monotonic_ns + since_ns,
        };
        change(&mut sample, step_s);
        worker.take(&sample);
        worker.clear();
    }
    worker.health()
}

#[test]
fn sanding_in_a_slide_is_a_test_that_finds_what_sand_gains() {
    // On full sand the simulated rail gives 1.8 times its adhesion.
    let truth = 1.8;
    let sand =
        "[[demand]]\nfrom_s = 65.0\nbrake = 1.0\nsanding = 1.0\n[[demand]]\nfrom_s = 74.0\nbrake = 1.0\n";
    let good = settings(sand, "");
    let tested = *SANDING.of(&health(&good, 95.0, |_, _| ()));
    println!("after the slide: {}", tested.reason);
    // The interval is that of the scatter alone: the filter's own error comes on top.
    assert!((tested.value - truth).abs() < 0.1 && tested.low > 1.5 && tested.grade() == Grade::Ok);
    let later = *SANDING.of(&health(&good, 1100.0, |sample, _| {
        // Behind the first round nothing is sanded any more.
        if sample.time_s > 240.0 {
            sample.sanding = 0.0;
        }
    }));
    println!("much later: {}", later.reason);
    assert!(later.reason.as_str().ends_with("; tested on 2026-03-01"), "{}", later.reason);
    // Sanders without effect: sand is told, the rail gives what it gave.
    let bad = settings(sand, "sanding_gain = 0.0\n");
    let broken = *SANDING.of(&health(&bad, 95.0, |_, _| ()));
    println!("without effect: {}", broken.reason);
    assert!((broken.value - 1.0).abs() < 0.1 && broken.grade() == Grade::Watch, "{}", broken.reason);
}

#[test]
fn a_wheel_that_is_not_round_is_found_on_a_train_that_drives_brakes_and_slides() {
    let settings = settings("", "");
    // The second wheelset's speed varies three times a turn; its angle is that through which it has turned.
    let (depth, mut angle) = (1.5e-3, 0.0);
    let seen = health(&settings, 230.0, |sample, step_s| {
        angle += sample.wheel_speed_rad_s[1] * step_s;
        sample.wheel_speed_rad_s[1] *= 1.0 + depth * f64::cos(3.0 * angle);
    });
    let [round, polygon] = [0, 1].map(|index| *WHEEL_FLAT.of_wheelset(&seen, index));
    println!("{}\n{}", round.reason, polygon.reason);
    let truth = depth / f64::sqrt(2.0);
    assert!(round.grade() == Grade::Ok && round.high < 0.1 * truth, "{}", round.reason);
    assert!(polygon.low <= truth && truth <= polygon.high, "{truth}: {}", polygon.reason);
    assert!(polygon.grade() >= Grade::Watch, "{}", polygon.reason);
}
