//! The worker on simulated samples: estimates as from the filter alone, snapshots that go on, refusals of bad ones.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use railgrip_bus::KeptError;
use railgrip_estimator::gap_record;
use railgrip_estimator::snapshot::{self, SnapshotError};
use railgrip_estimator::worker::Worker;
use railgrip_indicators::indicator::{BRAKE_FRICTION, FILTER, RAIL, SLIDES};
use railgrip_messages::{Checked, Condition, EventKind, Grade, Sample, Stamp, flags, sample_flags, valid};
use railgrip_recording::{Recording, Strictness};
use railgrip_settings::{Overrides, Source, TrainSettings, VehicleNumber};
use railgrip_simulation::Train;
use railgrip_vehicle::{EffectEntry, VehicleParameters};
use std::path::{Path, PathBuf};

fn settings() -> TrainSettings {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml");
    TrainSettings::load(Some(&file), &Overrides::default()).unwrap()
}

/// The first seconds of wagon 1 of the default train.
fn samples(settings: &TrainSettings, seconds: f64) -> Vec<Sample> {
    samples_with_truth(settings, seconds, 1).into_iter().map(|(sample, _)| sample).collect()
}

/// The same of any seed, each with the pad friction of its wheelsets.
fn samples_with_truth(settings: &TrainSettings, seconds: f64, seed: u64) -> Vec<(Sample, [f64; 2])> {
    samples_of(settings, settings.wagons[0].vehicle.clone(), seconds, seed)
}

/// The same of any vehicle.
fn samples_of(
    settings: &TrainSettings,
    vehicle: VehicleParameters,
    seconds: f64,
    seed: u64,
) -> Vec<(Sample, [f64; 2])> {
    let Source::Simulate { scenario, .. } = &settings.source else { panic!("{:?}", settings.source) };
    let mut train = Train::new(scenario, &[vehicle], seed, None).unwrap();
    (0..(seconds / train.sample_period_s()) as u64)
        .map(|sequence| {
            let simulated = train.step().wagons[0];
            let row = simulated.row;
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
            let truth = simulated.truth.row.mu_b;
            (sample, [truth[0], truth[1]])
        })
        .collect()
}

#[test]
fn the_default_train_is_understood_from_its_samples_alone() {
    let settings = settings();
    let mut worker = Worker::new(&settings, 1).unwrap();
    for (number, sample) in samples(&settings, 80.0).iter().enumerate() {
        worker.take(sample);
        if number % 20 == 0 {
            let health = worker.health();
            assert_eq!(health.check(sample.acquired), Ok(()), "its readers take every message: {health:?}");
        }
    }
    let health = worker.health();
    println!("brake friction: {}", BRAKE_FRICTION.of(&health).reason);
    println!("rail: {}", RAIL.of(&health).reason);
    println!("slides: {}", SLIDES.of(&health).reason);
    println!("filter: {}", FILTER.of(&health).reason);
    assert_eq!(worker.estimates.len(), 8000);
    assert_eq!(BRAKE_FRICTION.of(&health).grade(), Grade::Ok);
    assert!(SLIDES.of(&health).value >= 1.0, "the scenario slides on its low stretch within 80 s");
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
    assert_eq!(BRAKE_FRICTION.of(&one.health()), BRAKE_FRICTION.of(&two.health()));
}

#[test]
fn memory_goes_with_the_vehicle_number_and_without_one_only_within_a_start_of_the_train() {
    let mut settings = settings();
    let number = VehicleNumber::new("51 80 21-75 019-3");
    settings.wagons[0].vehicle_number.clone_from(&number);
    let (_folder, file) = snapshot_of(&settings, 1);
    let restore = |settings: &TrainSettings, wagon: u32, file: &Path| {
        let mut worker = Worker::new(settings, wagon).unwrap();
        let result = snapshot::restore(file, &mut worker).map_err(|error| error.to_string());
        (result.map(|stamp| stamp.is_some()), worker.health().wagon, worker.health().vehicle)
    };
    let mut moved = settings.clone();
    moved.wagons[0].vehicle_number = None;
    moved.wagons[1].vehicle_number.clone_from(&number);
    let (result, wagon, vehicle) = restore(&moved, 2, &file);
    assert_eq!((result, wagon, vehicle.as_str()), (Ok(true), 2, "51 80 21-75 019-3"));
    assert!(restore(&moved, 1, &file).0.unwrap_err().contains("another wagon"));
    moved.wagons[1].turned = true;
    assert!(restore(&moved, 2, &file).0.unwrap_err().contains("other end first"));

    let folder = tempfile::tempdir().unwrap();
    let mut nameless = self::settings();
    nameless.instance.dir = folder.path().to_owned();
    nameless.instance.begin_session().unwrap();
    let (_folder, file) = snapshot_of(&nameless, 1);
    assert_eq!(restore(&nameless, 1, &file).0, Ok(true), "a process that is started again goes on");
    nameless.instance.begin_session().unwrap();
    let said = restore(&nameless, 1, &file).0.unwrap_err();
    assert!(said.contains("without a vehicle number"), "{said}");
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
        assert!(
            matches!(error, SnapshotError::Kept(KeptError::Form { .. })) && error.to_string().contains(words),
            "{error}"
        );
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

/// Mean and weight while braking.
#[derive(Default)]
struct Average {
    sum: f64,
    count: f64,
}

impl Average {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1.0;
    }

    fn mean(&self) -> f64 {
        self.sum / self.count
    }
}

#[test]
fn intervals_of_brake_friction_hold_the_truth() {
    let settings = settings();
    let (mut held, mut claims) = (0, 0);
    let (mut wheelset_held, mut wheelset_claims) = (0, 0);
    for seed in 1..=40 {
        let mut worker = Worker::new(&settings, 1).unwrap();
        let (mut wagon, mut wheelsets) = (Average::default(), [Average::default(), Average::default()]);
        for (sample, truth) in samples_with_truth(&settings, 80.0, seed) {
            worker.take(&sample);
            let estimate = worker.estimates.pop().unwrap();
            let force_n = sample.pressing_force_n;
            if truth.iter().any(|mu_b| mu_b.is_nan()) {
                continue;
            }
            wagon.add((truth[0] * force_n[0] + truth[1] * force_n[1]) / (force_n[0] + force_n[1]));
            for wheelset in (0..2).filter(|wheelset| estimate.observable & (1 << wheelset) != 0) {
                wheelsets[wheelset].add(truth[wheelset]);
            }
        }
        let health = worker.health();
        let holds = |indicator: &railgrip_messages::Indicator, truth: f64| {
            (indicator.low..=indicator.high).contains(&truth)
        };
        claims += 1;
        held += usize::from(holds(BRAKE_FRICTION.of(&health), wagon.mean()));
        if seed <= 3 {
            println!("seed {seed}: {:.4} true {:.4}", BRAKE_FRICTION.of(&health).value, wagon.mean());
        }
        for (index, truth) in wheelsets.iter().enumerate() {
            let friction = BRAKE_FRICTION.of_wheelset(&health, index);
            wheelset_claims += usize::from(friction.known != 0);
            wheelset_held += usize::from(friction.known != 0 && holds(friction, truth.mean()));
        }
    }
    println!(
        "interval held the truth: wagon {held} of {claims}, wheelset {wheelset_held} of {wheelset_claims}"
    );
    assert!(held * 10 >= claims * 9, "wagon: {held} of {claims}");
    assert!(wheelset_held * 10 >= wheelset_claims * 9, "wheelset: {wheelset_held} of {wheelset_claims}");
}

#[test]
fn a_lagging_brake_that_the_model_lacks_is_noticed_and_kept_for_diagnosis() {
    let settings = settings();
    let run = |vehicle: VehicleParameters, seed| {
        let mut worker = Worker::new(&settings, 1).unwrap();
        let mut told = Vec::new();
        for (index, (sample, _)) in samples_of(&settings, vehicle, 240.0, seed).into_iter().enumerate() {
            worker.take(&sample);
            if index % 20 == 0 {
                worker.health();
            }
            told.extend(
                worker.events.iter().filter(|event| event.kind() == Some(EventKind::ModelMismatch)).copied(),
            );
            worker.clear();
        }
        (worker, told)
    };
    for seed in 1..=3 {
        let (_, told) = run(settings.wagons[0].vehicle.clone(), seed);
        assert!(told.is_empty(), "a model that is right is not suspected: {}", told[0].text);
    }
    let mut lagging = settings.wagons[0].vehicle.clone();
    let parameters = [("time_constant_s".to_owned(), 0.8), ("dead_time_s".to_owned(), 0.5)].into();
    lagging.effects.push(EffectEntry { id: "brake_lag".to_owned(), parameters });
    let (worker, told) = run(lagging, 1);
    told.iter().for_each(|event| println!("at {:.0} s: {}", event.time_s, event.text));
    assert!(told.iter().any(|event| event.text.as_str().ends_with("suspect brake actuation")));
    // A filter that a wrong model throws off starts again; what was sampled before stays part of the recording.
    let times: Vec<f64> = worker.gap.rows().map(|kept| kept.row.t_s).collect();
    let span_s = times.last().unwrap() - times.first().unwrap();
    println!("{span_s:.0} s are kept");
    assert!(span_s > 170.0, "{span_s} s");
    let folder = tempfile::tempdir().unwrap();
    let case = folder.path().join("wagon-1");
    assert!(gap_record::write(&case, &worker.gap, &settings.wagons[0].vehicle, true).unwrap());
    assert!(case.join(gap_record::GROWING).is_file());
    gap_record::settle(&case).unwrap();
    gap_record::settle(&case).unwrap();
    assert!(!case.join(gap_record::GROWING).exists(), "nobody waits for it any more");
    // Of what was kept, two windows to fit on and one to hold out are the least that a diagnosis can say anything from.
    for (part, least_s) in [("fit", 20.0), ("holdout", 10.0)] {
        let mut seconds = 0.0;
        for run in railgrip_recording::runs_in(&case.join(part)).unwrap() {
            run.require_rail().unwrap();
            let recording = Recording::read(&run.path, Strictness::Strict).unwrap();
            println!("{part}/{}: {:.1} s", run.name, recording.duration_s());
            seconds += recording.duration_s();
        }
        assert!(seconds > least_s, "{part}: {seconds} s");
    }
    let vehicle = railgrip_settings::vehicle::load(&case.join("vehicle.toml")).unwrap();
    let mut expected = settings.wagons[0].vehicle.clone();
    // As often as a diagnosis looks at them.
    expected.sensors.sample_rate_hz = 50.0;
    assert_eq!(vehicle, expected);
}

#[test]
fn a_new_sample_with_an_old_stamp_is_counted_and_one_sent_again_is_not() {
    let mut worker = Worker::new(&settings(), 1).unwrap();
    let batch = samples(&settings(), 0.1);
    batch.iter().for_each(|sample| worker.take(sample));
    // A late joiner gets the last few once more.
    batch.iter().for_each(|sample| worker.take(sample));
    assert_eq!((worker.taken, worker.not_newer), (10, 0));
    let (last, sequence) = (batch[9], batch[9].sequence + 1);
    worker.take(&Sample { sequence, ..last });
    assert_eq!((worker.taken, worker.not_newer), (10, 1));
}
