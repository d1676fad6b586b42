//! Messages that no process should send, and how many of them must be refused.

use crate::sensors::sample;
use bytemuck::Pod;
use railgrip_bus::{Bus, BusError, MAX_AUDIO_BLOCK, Publisher, now};
use railgrip_messages::{
    AudioHeader, BogieSample, Checked, Estimate, Event, EventKind, Grade, Health, Heard, Heartbeat,
    Innovation, MAX_VERDICTS, MotorSample, Payload, ProcessKind, Sample, SourceState, Verdict, Verdicts,
};
use railgrip_tests::Random;
use std::collections::BTreeMap;
use std::time::Duration;

/// Nonsense on each channel.
const EACH: usize = 40;
/// Wagons 1 and 2 are wagons; where rigs run with them, 3 is a driven one and 4 a bogie.
pub const DRIVEN: u32 = 3;
pub const BOGIE: u32 = 4;
/// Wagons of either train.
pub const WAGONS: u32 = 4;
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
pub struct Sent {
    pub all: usize,
    pub refused: BTreeMap<&'static str, u64>,
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
    let (wagon, known) = (message.wagon(), |wagon: u32| (0..=WAGONS).contains(&wagon));
    let expected = channel.map_or_else(|| known(wagon), |channel| wagon == channel);
    message.validated(now()).is_err() || !expected
}

/// Sends nonsense on a channel of the table; false for one that this test does not know.
pub fn spoil(channel: &str, bus: &Bus, random: &mut Random, sent: &mut Sent) -> Result<bool, BusError> {
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
            verdicts,
            |one| one.validated(now()).is_err() || one.wagons != WAGONS,
            to,
        ),
        "events" => send(
            &bus.event_publisher()?,
            Event::NAME,
            || Event { stamp: now(), wagon: 1, kind: EventKind::ClockDrifts.code(), ..Event::default() },
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

/// As many faults of the train as there are places for.
fn verdicts() -> Verdicts {
    let mut all = Verdicts { stamp: now(), wagons: WAGONS, ..Verdicts::default() };
    let mut fault = Verdict { number: 1, cause: 1, probability: 0.9, ..Verdict::default() };
    (fault.grade, fault.reason) = (Grade::Watch.code(), "nonsense".into());
    fault.add_wagon(2);
    (all.count, all.verdict) = (all.verdict.len() as u32, [fault; MAX_VERDICTS]);
    all
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
