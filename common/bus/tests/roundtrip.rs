//! Holder and ports in one process: what is sent arrives, what is lost is counted, what does not fit is refused.
//! One test, because iceoryx2 knows one instance a process.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::time::{Duration, Instant};

use railgrip_bus::{Bus, BusConfig, BusError, Holder, Lifecycle, Limits, MAX_AUDIO_BLOCK, Wake, now};
use railgrip_messages::{AudioHeader, Event, EventKind, Health, ProcessKind, Sample, Text};

const WAGONS: u32 = 3;

fn samples(from: u64, count: u64) -> Vec<Sample> {
    (from..from + count)
        .map(|sequence| Sample { sequence, acquired: now(), wheelsets: 2, ..Sample::default() })
        .collect()
}

#[test]
fn everything_a_channel_promises() {
    let folder = tempfile::Builder::new().prefix("rg").tempdir_in("/tmp").expect("folder");
    let config = BusConfig {
        train: "bench".into(),
        dir: folder.path().into(),
        prefix: format!("rgb{}_", std::process::id()),
        wagons: (1..=WAGONS).collect(),
        microphones: vec![2],
        limits: Limits { max_batch: 8, buffer: 16, ..Limits::default() },
    };

    refuses_without_holder(&config);
    let started = Instant::now();
    let holder = Holder::start(config.clone(), Duration::ZERO).expect("holder");
    println!("{} channels created in {:.1} ms", holder.channels(), started.elapsed().as_secs_f64() * 1e3);
    refuses_second_holder(&config);

    let bus = Bus::open(config.clone(), ProcessKind::Record, 0).expect("bus");
    bus.check_holder().expect("holder is there");
    refuses_unknown_wagon(&bus);
    batches_arrive_in_order(&bus);
    slow_reader_misses_and_counts(&bus);
    late_joiner_gets_history(&bus);
    small_channels_work(&bus);
    audio_of_any_length_arrives(&bus);
    a_crowd_of_restarts_finds_its_place(&bus);

    let prefix = config.prefix.clone();
    drop(bus);
    drop(holder);
    assert_eq!(leftovers(&prefix), Vec::<String>::new(), "shared memory must be clean");
    refuses_without_holder(&config);
    a_port_without_its_bus_keeps_the_next_holder_waiting(&config);
    a_holder_notices_that_a_channel_is_gone(&config);
}

/// A process whose bus ended before its ports once took a channel of the next holder with it, and the wagon was dead for ever.
fn a_port_without_its_bus_keeps_the_next_holder_waiting(config: &BusConfig) {
    let (tell, hear) = std::sync::mpsc::channel();
    let (leave, left) = std::sync::mpsc::channel();
    std::thread::scope(|scope| {
        let holders = scope.spawn(move || {
            let first = Holder::start(config.clone(), Duration::ZERO).expect("holder");
            tell.send(()).expect("somebody waits");
            left.recv().expect("the bus ended");
            drop(first);
            let second = Holder::start(config.clone(), Duration::ZERO).expect("holder");
            left.recv().expect("the port ended");
            second.check_channels()
        });
        hear.recv().expect("a holder");
        let bus = Bus::open(config.clone(), ProcessKind::Health, 0).expect("bus");
        let port = bus.health_subscriber(2).expect("port");
        drop(bus);
        leave.send(()).expect("the holder waits");
        std::thread::sleep(Duration::from_millis(300));
        drop(port);
        leave.send(()).expect("the holder waits");
        holders.join().expect("no panic").expect("all channels are there");
    });
}

fn a_holder_notices_that_a_channel_is_gone(config: &BusConfig) {
    let holder = Holder::start(config.clone(), Duration::ZERO).expect("holder");
    holder.check_channels().expect("all are there");
    let services = std::path::PathBuf::from(format!("/dev/shm/{}ipc/services", config.prefix));
    let one = services.read_dir().expect("services").flatten().next().expect("one").path();
    std::fs::remove_file(one).expect("removed");
    let error = holder.run(&Lifecycle::new()).expect_err("it must leave").to_string();
    println!("{error}");
    assert!(error.starts_with("1 of the "), "{error}");
}

fn refuses_without_holder(config: &BusConfig) {
    let error = Bus::open(config.clone(), ProcessKind::Ingest, 0).err().expect("must fail");
    assert!(matches!(error, BusError::NoHolder { .. }), "{error}");
    assert!(error.to_string().contains("railgrip hold"), "{error}");
}

fn refuses_second_holder(config: &BusConfig) {
    let error = Holder::start(config.clone(), Duration::from_millis(20)).err().expect("must fail");
    assert!(
        matches!(&error, BusError::AlreadyHeld { pid, .. } if *pid == std::process::id().to_string()),
        "{error}"
    );
}

fn refuses_unknown_wagon(bus: &Bus) {
    let error = bus.sample_publisher(WAGONS + 1).err().expect("must fail");
    assert_eq!(error.to_string(), "channel samples/4 does not exist in train \"bench\"");
}

fn batches_arrive_in_order(bus: &Bus) {
    let mut subscriber = bus.sample_subscriber(1).expect("subscriber");
    let publisher = bus.sample_publisher(1).expect("publisher");
    assert_eq!(subscriber.wait(Duration::from_millis(5)).expect("wait"), Wake::Timeout);
    publisher.publish(&samples(0, 20)).expect("publish");
    assert_eq!(subscriber.wait(Duration::from_secs(5)).expect("wait"), Wake::Data);
    let mut batches = Vec::new();
    let count = subscriber
        .receive(|batch| batches.push(batch.iter().map(|sample| sample.sequence).collect::<Vec<_>>()))
        .expect("receive");
    assert_eq!(count, 20);
    assert_eq!(batches.iter().map(Vec::len).collect::<Vec<_>>(), [8, 8, 4]);
    assert_eq!(batches.concat(), (0..20).collect::<Vec<_>>());
    assert_eq!(subscriber.wait(Duration::from_millis(5)).expect("wait"), Wake::Timeout);
    // What is sent wakes nobody until it is said so: the sender writes down what it sent before a reader takes the processor.
    publisher.send(&samples(20, 8)).expect("send");
    assert_eq!(subscriber.wait(Duration::from_millis(50)).expect("wait"), Wake::Timeout);
    publisher.wake().expect("wake");
    assert_eq!(subscriber.wait(Duration::from_secs(5)).expect("wait"), Wake::Data);
    assert_eq!(subscriber.receive(|_| {}).expect("receive"), 8);
}

fn slow_reader_misses_and_counts(bus: &Bus) {
    let mut slow = bus.sample_subscriber(2).expect("slow");
    let mut quick = bus.sample_subscriber(2).expect("quick");
    let publisher = bus.sample_publisher(2).expect("publisher");
    let mut seen_by_quick = 0;
    for batch in 0..100 {
        publisher.publish(&samples(batch * 8, 8)).expect("a slow reader must not stop the publisher");
        seen_by_quick += quick.receive(|_| {}).expect("receive");
    }
    assert_eq!((seen_by_quick, quick.missed()), (800, 0));
    let first = slow.receive(|_| {}).expect("receive");
    publisher.publish(&samples(800, 8)).expect("publish");
    let second = slow.receive(|_| {}).expect("receive");
    println!("slow reader: {first} + {second} of 808 received");
    assert_eq!((first, second), (16 * 8, 8), "overflow must keep the newest batches");
    // What was lost before the first item it ever saw is not known to it.
    assert_eq!(slow.missed(), 0);
    for batch in 0..20 {
        publisher.publish(&samples(808 + batch * 8, 8)).expect("publish");
    }
    slow.receive(|_| {}).expect("receive");
    assert_eq!(slow.missed(), 4 * 8);
}

fn late_joiner_gets_history(bus: &Bus) {
    let publisher = bus.health_publisher(3).expect("publisher");
    for sequence in 1..=5 {
        publisher.publish(&[Health { sequence, wagon: 3, ..Health::default() }]).expect("publish");
    }
    let mut late = bus.health_subscriber(3).expect("subscriber");
    publisher.refresh().expect("refresh");
    let mut seen = Vec::new();
    late.receive(|batch| seen.extend(batch.iter().map(|health| health.sequence))).expect("receive");
    assert_eq!(seen, [5], "exactly the last value");
}

fn audio_of_any_length_arrives(bus: &Bus) {
    let mut listener = bus.audio_subscriber(2).expect("subscriber");
    let microphone = bus.audio_publisher(2).expect("publisher");
    let header =
        |sequence| AudioHeader { sequence, wagon: 2, sample_rate_hz: 22_050, ..AudioHeader::default() };
    for (sequence, length) in [2205, 1, MAX_AUDIO_BLOCK].into_iter().enumerate() {
        let samples: Vec<f32> = (0..length).map(|n| n as f32).collect();
        microphone.publish(header(sequence as u64), &samples).expect("publish");
    }
    microphone.publish(header(9), &[0.5; MAX_AUDIO_BLOCK + 1]).expect_err("too long");
    microphone.publish(header(4), &[0.5]).expect("publish");
    assert_eq!(listener.wait(Duration::from_secs(5)).expect("wait"), Wake::Data);
    let mut seen = Vec::new();
    let take = |header: &AudioHeader, samples: &[f32]| {
        seen.push((header.sequence, samples.len(), samples.last().copied()));
    };
    listener.receive(take).expect("receive");
    let last = MAX_AUDIO_BLOCK as f32 - 1.0;
    assert_eq!(
        seen,
        [(0, 2205, Some(2204.0)), (1, 1, Some(0.0)), (2, MAX_AUDIO_BLOCK, Some(last)), (4, 1, Some(0.5))]
    );
    assert_eq!(listener.missed(), 1);
    let error = bus.audio_subscriber(1).err().expect("wagon 1 has no microphone");
    assert!(error.to_string().contains("audio/1"), "{error}");
}

fn small_channels_work(bus: &Bus) {
    let mut subscriber = bus.event_subscriber().expect("subscriber");
    let publishers = [bus.event_publisher().expect("first"), bus.event_publisher().expect("second")];
    for (wagon, publisher) in (1..).zip(&publishers) {
        let event = Event {
            kind: EventKind::SlideBegan.code(),
            wagon,
            text: Text::new("wheelset 1 slides"),
            ..Event::default()
        };
        publisher.publish(&[event]).expect("publish");
    }
    let mut wagons = Vec::new();
    subscriber.receive(|batch| wagons.extend(batch.iter().map(|event| event.wagon))).expect("receive");
    wagons.sort_unstable();
    assert_eq!(wagons, [1, 2]);
}

fn a_crowd_of_restarts_finds_its_place(bus: &Bus) {
    for _ in 0..50 {
        let publisher = bus.sample_publisher(3).expect("publisher");
        let _subscriber = bus.sample_subscriber(3).expect("subscriber");
        publisher.publish(&samples(0, 1)).expect("publish");
    }
}

fn leftovers(prefix: &str) -> Vec<String> {
    std::fs::read_dir("/dev/shm")
        .expect("shared memory")
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| name.starts_with(prefix))
        .collect()
}
