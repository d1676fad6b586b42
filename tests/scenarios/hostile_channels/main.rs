//! Nonsense on every channel of a running train, from a program that may write there: nothing ends, what is refused is counted
//! once under a name, sound messages are taken afterwards, and what is old does not look live.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

mod nonsense;
mod sensors;
mod watched;

use nonsense::{BOGIE, DRIVEN, Sent, spoil};
use railgrip_bus::CHANNELS;
use railgrip_messages::{
    BogieSample, Checked, Event, Health, Heard, Heartbeat, MotorSample, Refusal, Sample, SourceState,
};
use railgrip_tests::{Random, TrainUnderTest, program, within};
use sensors::Sensors;
use watched::{PATIENCE, assert_counted, assert_stale, bus, rejected, states, wait_serving};

#[test]
fn nonsense_on_every_channel_does_no_harm() {
    let vehicles = concat!(env!("CARGO_MANIFEST_DIR"), "/../config");
    let config = format!(
        "schema = 1\n[train]\nname = \"hostile\"\nvehicle = \"{vehicles}/vehicle.toml\"\n[[wagon]]\n[[wagon]]\n\
         [[wagon]]\nvehicle = \"{vehicles}/rigs/zhao.toml\"\nfilter = \"zhao\"\n[[wagon]]\nvehicle = \"{vehicles}/rigs/shrestha.toml\"\nfilter = \"shrestha\"\n\
         [source]\nkind = \"external\"\n[[microphone]]\nwagon = 1\nrecordings = [\"nothing.wav\"]\n[diagnosis]\nautomatic = false\n"
    );
    let mut train = TrainUnderTest::new(program!(), &config);
    std::fs::write(train.folder().join("nothing.wav"), "").expect("written");
    train.start();
    // Nobody has sent anything yet: all serve, and no wagon is live.
    wait_serving(&train, 6);
    let bus = bus(&train);
    let mut sensors = Sensors::open(&bus, 2, true).expect("ports");
    sensors.run(1.0);
    let before = train.processes();
    let (mut random, mut sent) = (Random::new(29), Sent::default());
    for channel in CHANNELS {
        assert!(
            spoil(channel.name, &bus, &mut random, &mut sent).expect(channel.name),
            "{} is new",
            channel.name
        );
        sensors.run(0.1);
    }
    println!("{} messages; to be refused: {:?}", sent.all, sent.refused);
    assert!(sent.all >= 200 && Refusal::ALL.len() > 1);

    let live = within(PATIENCE, || {
        sensors.run(0.2);
        states(&train).filter(|states| states[..2] == ["live", "live"])
    });
    assert!(live.is_some(), "sound samples are taken again: {:?}\n{}", states(&train), train.log());
    let pids =
        |processes: &[railgrip_tests::Process]| processes.iter().map(|one| one.pid).collect::<Vec<_>>();
    assert_eq!(pids(&before), pids(&train.processes()), "nothing has ended: {}", train.log());

    // Services count under names of their own; estimators and the listener in their heartbeats and logs.
    assert_counted(
        &train,
        &sent,
        &[Health::NAME, Heard::NAME, Event::NAME, SourceState::NAME, Heartbeat::NAME],
    );
    for (process, wagon, expected) in [
        ("estimator", 1, sent.refused[Sample::NAME]),
        ("estimator", DRIVEN, sent.refused[MotorSample::NAME]),
        ("estimator", BOGIE, sent.refused[BogieSample::NAME]),
        ("listener", 1, sent.refused["audio"]),
    ] {
        let enough = within(PATIENCE, || {
            sensors.run(0.1);
            rejected(&train, process, wagon).filter(|told| *told >= expected)
        });
        assert!(
            expected > 0 && enough.is_some(),
            "{process} {wagon}: {:?} of {expected}",
            rejected(&train, process, wagon)
        );
    }
    assert!(!train.log().contains("panicked"), "{}", train.log());

    assert_stale(&train);
    assert!(train.stop().success());
}
