//! The worker on simulated samples: estimates as from the filter alone, snapshots that go on, refusals of bad ones.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use railgrip_estimator::snapshot::{self, SnapshotError};
use railgrip_estimator::worker::Worker;
use railgrip_messages::{Condition, EventKind, Grade, Sample, Stamp, flags, sample_flags, valid};
use railgrip_settings::{Overrides, Source, TrainSettings};
use railgrip_simulation::Train;
use std::path::{Path, PathBuf};

fn settings() -> TrainSettings {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml");
    TrainSettings::load(Some(&file), &Overrides::default()).unwrap()
}

/// The first seconds of wagon 1 of the default train.
fn samples(settings: &TrainSettings, seconds: f64) -> Vec<Sample> {
    let Source::Simulate { scenario, .. } = &settings.source else { panic!("{:?}", settings.source) };
    let mut train = Train::new(scenario, &[settings.wagons[0].vehicle.clone()], 1, None).unwrap();
    (0..(seconds / train.sample_period_s()) as u64)
        .map(|sequence| {
            let row = train.step().wagons[0].row;
            let mut sample = Sample { time_s: row.t_s, v_m_s: row.v_m_s, wheelsets: 2, ..Sample::default() };
            sample.valid = valid::SPEED | valid::GRADE;
            sample.grade_rad = if row.grade_rad.is_nan() { 0.0 } else { row.grade_rad };
            for wheelset in 0..2 {
                sample.valid |= valid::wheel_speed(wheelset)
                    | valid::pressing_force(wheelset)
                    | valid::drive_torque(wheelset);
                sample.wheel_speed_rad_s[wheelset] = row.wheel_speed_rad_s[wheelset];
                sample.pressing_force_n[wheelset] = row.pressing_force_n[wheelset];
                sample.drive_torque_nm[wheelset] = row.drive_torque_nm[wheelset];
            }
            sample.sequence = sequence;
            sample.acquired = Stamp { unix_ns: 1, monotonic_ns: 1 + sequence * 10_000_000 };
            sample
        })
        .collect()
}

#[test]
fn the_default_train_is_understood_from_its_samples_alone() {
    let settings = settings();
    let mut worker = Worker::new(&settings, 1).unwrap();
    samples(&settings, 80.0).iter().for_each(|sample| worker.take(sample));
    let health = worker.health();
    println!("brake friction: {}", health.brake_friction.reason);
    println!("rail: {}", health.rail.reason);
    println!("slides: {}", health.slides.reason);
    println!("filter: {}", health.filter.reason);
    assert_eq!(worker.estimates.len(), 8000);
    assert_eq!(health.brake_friction.grade(), Grade::Ok);
    assert!(health.slides.value >= 1.0, "the scenario slides on its low stretch within 80 s");
    let low = [Condition::Low.code(), Condition::VeryLow.code()];
    let told = worker.events.iter().any(|event| {
        event.kind() == Some(EventKind::ConditionChanged) && low.contains(&(event.values[1] as u32))
    });
    assert!(told, "the low stretch is told as an event");
}

#[test]
fn a_successor_goes_on_bit_for_bit_from_the_snapshot() {
    let settings = settings();
    let all = samples(&settings, 20.0);
    let (first, second) = all.split_at(900);
    let file = tempfile::tempdir().unwrap();
    let file = file.path().join("wagon-1.snapshot");
    let mut one = Worker::new(&settings, 1).unwrap();
    first.iter().for_each(|sample| one.take(sample));
    snapshot::save(&file, &one).unwrap();
    println!("{} bytes", std::fs::metadata(&file).unwrap().len());
    let mut two = Worker::new(&settings, 1).unwrap();
    let stamp = snapshot::restore(&file, &mut two).unwrap().unwrap();
    assert_eq!(stamp, first[899].acquired);
    one.clear();
    // A late joiner gets the last samples once more; those that are in the snapshot change nothing.
    first[880..].iter().chain(second).for_each(|sample| two.take(sample));
    second.iter().for_each(|sample| one.take(sample));
    assert_eq!(two.estimates.len(), one.estimates.len());
    assert!(two.estimates[0].flags & flags::RESUMED != 0, "{:b}", two.estimates[0].flags);
    for (resumed, straight) in two.estimates.iter().zip(&one.estimates) {
        assert_eq!(resumed.mu_b_mean.to_bits(), straight.mu_b_mean.to_bits(), "at {} s", straight.time_s);
        assert_eq!(resumed.mu_w.to_bits(), straight.mu_w.to_bits(), "at {} s", straight.time_s);
    }
    assert_eq!(one.health().brake_friction, two.health().brake_friction);
}

fn snapshot_of(settings: &TrainSettings, wagon: u32) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.snapshot");
    let mut worker = Worker::new(settings, wagon).unwrap();
    samples(settings, 2.0).iter().for_each(|sample| worker.take(sample));
    snapshot::save(&file, &worker).unwrap();
    (folder, file)
}

#[test]
fn damaged_cut_foreign_and_empty_snapshots_are_refused() {
    let settings = settings();
    let (_folder, file) = snapshot_of(&settings, 1);
    let good = std::fs::read(&file).unwrap();
    let mut flipped = good.clone();
    *flipped.last_mut().unwrap() ^= 1;
    let cases: [(&[u8], &str); 5] = [
        (&flipped, "checksum"),
        (&good[..good.len() / 2], "checksum"),
        (&good[..22], "cut short"),
        (b"", "not a snapshot"),
        (b"railgrip snapshot 0\nsomething", "not a snapshot"),
    ];
    for (bytes, words) in cases {
        std::fs::write(&file, bytes).unwrap();
        let mut worker = Worker::new(&settings, 1).unwrap();
        let error = snapshot::restore(&file, &mut worker).unwrap_err();
        assert!(matches!(error, SnapshotError::Form { .. }) && error.to_string().contains(words), "{error}");
    }
    std::fs::write(&file, &good).unwrap();
    let mut other = Worker::new(&settings, 2).unwrap();
    let said = snapshot::restore(&file, &mut other).unwrap_err().to_string();
    assert!(said.contains("another wagon"), "{said}");
    let mut heavier = settings.clone();
    heavier.wagons[0].vehicle.body.mass_kg *= 2.0;
    let mut other = Worker::new(&heavier, 1).unwrap();
    let said = snapshot::restore(&file, &mut other).unwrap_err().to_string();
    println!("{said}");
    assert!(matches!(snapshot::restore(&file.with_extension("none"), &mut other), Ok(None)));
}

#[test]
fn a_time_base_that_begins_anew_makes_the_filter_begin_anew() {
    let settings = settings();
    let mut all = samples(&settings, 10.0);
    all[0].flags = sample_flags::TIME_BASE_RESTARTED;
    let mut worker = Worker::new(&settings, 1).unwrap();
    all.iter().for_each(|sample| worker.take(sample));
    let first_round: Vec<u64> =
        worker.estimates.iter().map(|estimate| estimate.mu_b_mean.to_bits()).collect();
    worker.clear();
    for sample in &mut all {
        sample.sequence += 1000;
        sample.acquired.monotonic_ns += 20_000_000_000;
        worker.take(sample);
    }
    let second_round: Vec<u64> =
        worker.estimates.iter().map(|estimate| estimate.mu_b_mean.to_bits()).collect();
    assert_eq!(first_round, second_round);
    assert!(worker.estimates[0].flags & flags::RESTARTED != 0);
    let restarts = worker.events.iter().filter(|event| event.kind() == Some(EventKind::FilterRestarted));
    assert_eq!(restarts.count(), 1);
}
