//! Nonsense on every channel of a running train, from a program that may write there: nothing ends, what is refused is counted
//! under a name, sound messages are taken afterwards, and what is old does not look live.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use bytemuck::Pod;
use railgrip_bus::{Bus, BusConfig, BusError, CHANNELS, MAX_AUDIO_BLOCK, Publisher, now};
use railgrip_messages::{
    AudioHeader, BogieSample, Checked, Estimate, Event, Health, Heard, Heartbeat, Innovation, MotorSample,
    Payload, ProcessKind, Refusal, Sample, SourceState, Verdicts, valid,
};
use railgrip_settings::{Overrides, TrainSettings};
use railgrip_tests::{Random, TrainUnderTest, program, within};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Nonsense on each channel.
const EACH: usize = 40;
/// Wagons 1 and 2 are wagons, 3 a driven rig, 4 a bogie rig.
const DRIVEN: u32 = 3;
const BOGIE: u32 = 4;
const PATIENCE: Duration = Duration::from_secs(60);
/// What a word of eight bytes becomes: numbers that are none, the ends of what there is, codes and flags without a meaning, text
/// that is no UTF-8.
const HOSTILE: [u64; 12] = [
    0x7ff8_0000_0000_0000,
    0x7ff0_0000_0000_0000,
    0xfff0_0000_0000_0000,
    0x8000_0000_0000_0001,
    0,
    u64::MAX,
    u64::MAX >> 1,
    0x7fe0_0000_0000_0000,
    0xffe0_0000_0000_0000,
    0x0000_0063_0000_0063,
    0x0000_0001_0000_0001,
    0xff80_c0fe_ff80_c0fe,
];

/// What was sent, and how much of it must be refused, by the name of the payload.
#[derive(Default)]
struct Sent {
    all: usize,
    refused: BTreeMap<&'static str, u64>,
}

/// Writes one to three hostile words into a message.
fn spoiled<T: Pod>(good: T, random: &mut Random) -> T {
    let mut message = good;
    let bytes = bytemuck::bytes_of_mut(&mut message);
    for _ in 0..=random.below(3) {
        let from = random.below(bytes.len() / 8) * 8;
        bytes[from..from + 8].copy_from_slice(&HOSTILE[random.below(HOSTILE.len())].to_ne_bytes());
    }
    message
}

/// Sends nonsense; `refused` says whether a reader must refuse it.
fn send<T: Payload + Pod>(
    publisher: &Publisher<T>,
    name: &'static str,
    good: impl Fn() -> T,
    refused: impl Fn(&T) -> bool,
    (random, sent): (&mut Random, &mut Sent),
) {
    for _ in 0..EACH {
        let message = spoiled(good(), random);
        sent.all += 1;
        *sent.refused.entry(name).or_default() += u64::from(refused(&message));
        publisher.publish(&[message]).expect("published");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn is_refused<T: Checked>(message: &T, channel: Option<u32>) -> bool {
    let (wagon, known) = (message.wagon(), |wagon: u32| (0..=BOGIE).contains(&wagon));
    let expected = channel.map_or_else(|| known(wagon), |channel| wagon == channel);
    message.validated(now()).is_err() || !expected
}

fn sample(k: u64) -> Sample {
    let mut sample =
        Sample { sequence: k, acquired: now(), time_s: k as f64 * 0.01, wheelsets: 2, ..Sample::default() };
    sample.v_m_s = 20.0;
    sample.wheel_speed_rad_s[..2].fill(20.0 / 0.44);
    sample.valid = valid::SPEED
        | valid::wheel_speed(0)
        | valid::wheel_speed(1)
        | valid::pressing_force(0)
        | valid::pressing_force(1);
    sample
}

/// A hundredth of a second of everything that sensors send.
struct Sensors {
    wagons: Vec<Publisher<Sample>>,
    motors: Publisher<MotorSample>,
    bogies: Publisher<BogieSample>,
    k: u64,
}

impl Sensors {
    fn open(bus: &Bus) -> Result<Self, BusError> {
        let wagons = [1, 2].map(|wagon| bus.sample_publisher(wagon)).into_iter().collect::<Result<_, _>>()?;
        Ok(Self { wagons, motors: bus.motor_publisher(DRIVEN)?, bogies: bus.bogie_publisher(BOGIE)?, k: 0 })
    }

    fn run(&mut self, seconds: f64) {
        let until = Instant::now() + Duration::from_secs_f64(seconds);
        while Instant::now() < until {
            self.k += 1;
            let (sequence, time_s, acquired) = (self.k, self.k as f64 * 0.01, now());
            self.wagons.iter().for_each(|wagon| wagon.publish(&[sample(sequence)]).expect("published"));
            self.motors
                .publish(&[MotorSample { sequence, time_s, acquired, ..MotorSample::default() }])
                .expect("published");
            self.bogies
                .publish(&[BogieSample { sequence, time_s, acquired, ..BogieSample::default() }])
                .expect("published");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

/// Sends nonsense on a channel of the table; false for one that this test does not know.
fn spoil(channel: &str, bus: &Bus, random: &mut Random, sent: &mut Sent) -> Result<bool, BusError> {
    let to = (random, sent);
    let at = |wagon: u32| move || (wagon, now());
    let on = at(1);
    match channel {
        "samples" => {
            send(&bus.sample_publisher(1)?, Sample::NAME, || sample(7), |one| is_refused(one, Some(0)), to)
        }
        "motors" => send(
            &bus.motor_publisher(DRIVEN)?,
            MotorSample::NAME,
            || MotorSample { acquired: now(), time_s: 1.0, ..MotorSample::default() },
            |one| is_refused(one, Some(0)),
            to,
        ),
        "bogies" => send(
            &bus.bogie_publisher(BOGIE)?,
            BogieSample::NAME,
            || BogieSample { acquired: now(), time_s: 1.0, ..BogieSample::default() },
            |one| is_refused(one, Some(0)),
            to,
        ),
        "estimates" => send(
            &bus.estimate_publisher(1)?,
            Estimate::NAME,
            || Estimate { acquired: now(), wheelsets: 2, v_m_s: 20.0, ..Estimate::default() },
            |one| is_refused(one, Some(0)),
            to,
        ),
        // Nobody reads them: they are for whoever looks on.
        "innovations" => {
            send(&bus.innovation_publisher(1)?, "innovation", Innovation::default, |_| false, to)
        }
        "health" => send(
            &bus.health_publisher(1)?,
            Health::NAME,
            || Health {
                wagon: on().0,
                acquired: on().1,
                published_monotonic_ns: on().1.monotonic_ns,
                wheelsets: 2,
                ..Health::default()
            },
            |one| is_refused(one, Some(1)),
            to,
        ),
        "heard" => send(
            &bus.heard_publisher(1)?,
            Heard::NAME,
            || Heard { wagon: 1, acquired: now(), condition: u32::MAX, ..Heard::default() },
            |one| is_refused(one, Some(1)),
            to,
        ),
        "verdicts" => send(
            &bus.verdict_publisher()?,
            Verdicts::NAME,
            || Verdicts { stamp: now(), wagons: BOGIE, ..Verdicts::default() },
            |_| false,
            to,
        ),
        "events" => send(
            &bus.event_publisher()?,
            Event::NAME,
            || Event { stamp: now(), wagon: 1, ..Event::default() },
            |one| is_refused(one, None),
            to,
        ),
        "sources" => send(
            &bus.source_publisher()?,
            SourceState::NAME,
            || SourceState { stamp: now(), wagon: 1, ..SourceState::default() },
            |one| is_refused(one, None),
            to,
        ),
        "heartbeats" => send(
            &bus.heartbeat_publisher()?,
            Heartbeat::NAME,
            || Heartbeat {
                stamp: now(),
                process: ProcessKind::Record.code(),
                wagon: 1,
                ..Heartbeat::default()
            },
            |one| is_refused(one, None),
            to,
        ),
        "audio" => blocks(bus, to)?,
        _ => return Ok(false),
    }
    Ok(true)
}

/// Blocks of audio with hostile headers and samples, of all lengths.
fn blocks(bus: &Bus, (random, sent): (&mut Random, &mut Sent)) -> Result<(), BusError> {
    let microphone = bus.audio_publisher(1)?;
    for k in 0..EACH {
        let good = AudioHeader {
            sequence: k as u64,
            acquired: now(),
            wagon: 1,
            sample_rate_hz: 22_050,
            ..AudioHeader::default()
        };
        let header = spoiled(good, random);
        let value = [f32::NAN, f32::INFINITY, 0.0, -1e38][random.below(4)];
        sent.all += 1;
        *sent.refused.entry("audio").or_default() += u64::from(header.check(1, now()).is_err());
        microphone.publish(header, &vec![value; random.below(MAX_AUDIO_BLOCK)])?;
        std::thread::sleep(Duration::from_millis(2));
    }
    Ok(())
}

/// The sum of the counts of a payload that metrics tell.
fn counted(metrics: &str, payload: &str) -> u64 {
    let line = format!("railgrip_payloads_refused_total{{payload=\"{payload}\"");
    let of_payload = metrics.lines().filter(|text| text.starts_with(&line));
    of_payload.filter_map(|text| text.rsplit(' ').next()?.parse::<f64>().ok()).sum::<f64>() as u64
}

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
    let file = train.folder().join("train.toml");
    let overrides = Overrides { instance_dir: Some(train.instance()), ..Overrides::default() };
    let settings = TrainSettings::load(Some(&file), &overrides).expect("sound");
    train.start();
    // Nobody has sent anything yet: all serve, and no wagon is live.
    let serves = || train.http()?.json("/api/v1/train")?["processes"].as_array().map(Vec::len);
    let all = within(PATIENCE, || serves().filter(|processes| *processes >= 6));
    assert!(all.is_some(), "{:?}\n{}", serves(), train.log());
    let bus = Bus::open(BusConfig::of(&settings), ProcessKind::Record, 99).expect("a bus");
    let mut sensors = Sensors::open(&bus).expect("ports");
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

    let states = || -> Option<Vec<String>> {
        let wagons = train.http()?.json("/api/v1/wagons")?;
        Some(
            wagons["wagons"]
                .as_array()?
                .iter()
                .map(|row| row["state"].as_str().unwrap_or("").to_owned())
                .collect(),
        )
    };
    let live = within(PATIENCE, || {
        sensors.run(0.2);
        states().filter(|states| states[..2] == ["live", "live"])
    });
    assert!(live.is_some(), "sound samples are taken again: {:?}\n{}", states(), train.log());
    let pids =
        |processes: &[railgrip_tests::Process]| processes.iter().map(|one| one.pid).collect::<Vec<_>>();
    assert_eq!(pids(&before), pids(&train.processes()), "nothing has ended: {}", train.log());

    // Services count under names of their own; estimators and the listener in their heartbeats and logs.
    let metrics = train.http().expect("it serves").get("/metrics").expect("metrics").1;
    for payload in [Health::NAME, Heard::NAME, Event::NAME, SourceState::NAME, Heartbeat::NAME] {
        let (told, expected) = (counted(&metrics, payload), sent.refused[payload]);
        assert!(expected > 0 && told >= expected, "{payload}: {told} counted, {expected} refused");
    }
    let rejected = |process: &str, wagon: u32| {
        let view = train.http()?.json("/api/v1/train")?;
        let mut all = view["processes"].as_array()?.clone().into_iter();
        all.find(|one| one["process"] == process && one["wagon"] == wagon)?["rejected"].as_u64()
    };
    for (process, wagon, expected) in [
        ("estimator", 1, sent.refused[Sample::NAME]),
        ("estimator", DRIVEN, sent.refused[MotorSample::NAME]),
        ("estimator", BOGIE, sent.refused[BogieSample::NAME]),
        ("listener", 1, sent.refused["audio"]),
    ] {
        let enough = within(PATIENCE, || {
            sensors.run(0.1);
            rejected(process, wagon).filter(|told| *told >= expected)
        });
        assert!(
            expected > 0 && enough.is_some(),
            "{process} {wagon}: {:?} of {expected}",
            rejected(process, wagon)
        );
    }
    assert!(!train.log().contains("panicked"), "{}", train.log());

    // Silence: nothing of all that was sent looks live.
    let stale = within(PATIENCE, || states().filter(|states| states.iter().all(|state| state != "live")));
    assert!(stale.is_some(), "{:?}", states());
    let wagons = train.http().and_then(|http| http.json("/api/v1/wagons")).expect("wagons");
    let old = wagons["wagons"].as_array().expect("rows").iter();
    assert!(old.clone().all(|row| row["v_m_s"].is_null()), "{wagons}");
    assert!(train.stop().success());
}
