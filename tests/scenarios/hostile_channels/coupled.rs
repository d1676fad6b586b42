//! Nonsense on the channels of a coupled train, whose judge reads the samples of all wagons and alone tells what is wrong with
//! them. A program of its own beside the other, because a process knows the channels of one train only.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

mod nonsense;
mod sensors;
mod watched;

use nonsense::{Sent, WAGONS, spoil};
use railgrip_messages::{Checked, Event, Health, Heartbeat, Sample, SourceState, Verdicts};
use railgrip_tests::{Process, Random, TrainUnderTest, program, within};
use sensors::Sensors;
use watched::{PATIENCE, assert_counted, assert_stale, bus, rejected, states, wait_serving};

/// What a program of the same user can write to while the train runs; it has no rigs and no microphone.
const CHANNELS: [&str; 8] =
    ["samples", "estimates", "innovations", "health", "verdicts", "events", "sources", "heartbeats"];

fn config() -> String {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml");
    let wagons = "[[wagon]]\n".repeat(WAGONS as usize);
    format!(
        "schema = 1\n[train]\nname = \"coupled\"\ncoupled = true\nvehicle = \"{vehicle}\"\n{wagons}\
         [source]\nkind = \"external\"\n[diagnosis]\nautomatic = false\n"
    )
}

/// Wagons that alerts name.
fn accused(train: &TrainUnderTest) -> Vec<u64> {
    let list = train.http().and_then(|http| http.json("/api/v1/alerts")).expect("alerts");
    let alerts = list["alerts"].as_array().expect("a list").iter();
    alerts
        .flat_map(|alert| alert["wagons"].as_array().cloned().unwrap_or_default())
        .filter_map(|one| one.as_u64())
        .collect()
}

#[test]
fn nonsense_on_every_channel_of_a_coupled_train_does_no_harm() {
    let mut train = TrainUnderTest::new(program!(), &config());
    train.start();
    // Estimators, judge and service.
    wait_serving(&train, WAGONS as usize + 2);
    let bus = bus(&train);
    let mut sensors = Sensors::open(&bus, WAGONS, false).expect("ports");
    sensors.run(1.0);
    let before = train.processes();
    let (mut random, mut sent) = (Random::new(31), Sent::default());
    for channel in CHANNELS {
        assert!(spoil(channel, &bus, &mut random, &mut sent).expect(channel), "{channel} is new");
        sensors.run(0.1);
    }
    let refused = within(PATIENCE, || {
        sensors.run(0.1);
        let both = [rejected(&train, "judge", 0)?, rejected(&train, "estimator", 1)?];
        both.iter().all(|told| *told >= sent.refused[Sample::NAME]).then_some(both)
    });
    let expected = sent.refused[Sample::NAME];
    println!("{} messages; to be refused: {:?}; samples: {refused:?}", sent.all, sent.refused);
    assert!(expected > 0 && refused.is_some_and(|[judge, _]| judge == expected), "{refused:?} of {expected}");

    let live = within(PATIENCE, || {
        sensors.run(0.2);
        states(&train).filter(|states| states.iter().all(|state| state == "live"))
    });
    assert!(live.is_some(), "{:?}\n{}", states(&train), train.log());
    let pids = |processes: Vec<Process>| processes.into_iter().map(|one| one.pid).collect::<Vec<_>>();
    assert_eq!(pids(before), pids(train.processes()), "nothing has ended: {}", train.log());
    assert_counted(
        &train,
        &sent,
        &[Health::NAME, Event::NAME, SourceState::NAME, Heartbeat::NAME, Verdicts::NAME],
    );
    assert!(accused(&train).iter().all(|wagon| *wagon <= u64::from(WAGONS)), "{:?}", accused(&train));
    assert!(!train.log().contains("panicked"), "{}", train.log());
    assert_stale(&train);
    assert!(train.stop().success());
}
