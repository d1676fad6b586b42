//! Telegrams on the loopback: every one is a sample or counted under a name, whatever comes between them.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may end at what it does not expect, and says what it saw"
)]

use railgrip_fieldbus::trdp::{Telegram, write};
use railgrip_ingest::feed::{Arrival, Feed, open};
use railgrip_messages::SourceCount;
use railgrip_settings::{Overrides, TrainSettings};
use std::net::UdpSocket;
use std::time::{Duration, Instant};

const DESCRIPTION: &str = r#"<?xml version="1.0"?>
<device host-name="bcu" type="test">
  <bus-interface-list><bus-interface network-id="1" name="eth0">
    <telegram name="brakes" com-id="2001" data-set-id="2001"><pd-parameter cycle="10000"/></telegram>
  </bus-interface></bus-interface-list>
  <data-set-list>
    <data-set name="axle" id="2100"><element name="n" type="REAL32"/><element name="ok" type="BOOL8"/></data-set>
    <data-set name="brakes" id="2001">
      <element name="speed" type="UINT16" scale="0.01" unit="km/h"/>
      <element name="axle" type="2100" array-size="2"/>
      <element name="pressure" type="REAL64" unit="bar"/>
      <element name="cycle" type="UINT32"/>
    </data-set>
  </data-set-list>
</device>"#;

/// Wagons of the train, each with a sender of its own on the loopback.
const WAGONS: usize = 2;

fn free_port() -> u16 {
    UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

fn train(port: u16) -> (tempfile::TempDir, TrainSettings) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("device.xml"), DESCRIPTION).unwrap();
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/vehicle.toml");
    let text = format!(
        "schema = 1\n[train]\nname = \"net\"\nwagons = {WAGONS}\nvehicle = \"{vehicle}\"\n[source]\nkind = \"trdp\"\n\
         listen = \"127.0.0.1:{port}\"\ndatabase = \"device.xml\"\nsenders = [\"127.0.0.1\", \"127.0.0.2\"]\n[mapping]\n\
         v_m_s = {{ from = \"speed\", unit = \"km/h\" }}\nposition_m = {{ from = \"cycle\" }}\n\
         omega_f_rad_s = {{ from = \"axle[0].n\", flag = \"axle[0].ok\" }}\n\
         omega_r_rad_s = {{ from = \"axle[1].n\", flag = \"axle[1].ok\" }}\n\
         f_perp_f_n = {{ from = \"pressure\", unit = \"bar\", scale = 0.16 }}\n\
         f_perp_r_n = {{ from = \"pressure\", unit = \"bar\", scale = 0.16 }}\n"
    );
    let settings =
        TrainSettings::parse(&folder.path().join("train.toml"), &text, &Overrides::default()).unwrap();
    (folder, settings)
}

/// The data set of a cycle: 72 km/h, wheels of 0.44 m, no brake.
fn data(cycle: u32) -> Vec<u8> {
    let mut data = 7200_u16.to_be_bytes().to_vec();
    for wheelset in 0..2 {
        data.extend((20.0_f32 / 0.44).to_be_bytes());
        // The second wheelset's speed is bad in every tenth cycle.
        data.push(u8::from(wheelset == 0 || !cycle.is_multiple_of(10)));
    }
    data.extend(0.0_f64.to_be_bytes());
    data.extend(cycle.to_be_bytes());
    data
}

fn telegram(sequence: u32, com_id: u32) -> Vec<u8> {
    write(&Telegram { sequence, com_id, etb_topo_count: 0, op_train_topo_count: 0, data: &data(sequence) })
}

/// What is wrong with the telegram that follows one with this number, if one follows: the datagram, and its name.
fn hostile(number: u32) -> Option<(Vec<u8>, SourceCount)> {
    let mended = |mut datagram: Vec<u8>, at: usize, to: u8| {
        datagram[at] = to;
        // The checksum of a telegram without data, as the writer makes it, is over the first 36 bytes.
        let crc = crc_of(&datagram[..36]);
        datagram[36..40].copy_from_slice(&crc.to_le_bytes());
        datagram
    };
    let good = || telegram(number, 2001);
    Some(match number % 1000 {
        10 => (good(), SourceCount::Old),
        20 => (telegram(number, 2002), SourceCount::Unwanted),
        30 => (good()[..39].to_vec(), SourceCount::HeaderShort),
        40 => (vec![0; 1500], SourceCount::HeaderCrc),
        50 => (mended(good(), 4, 9), SourceCount::ProtocolVersion),
        60 => (mended(good(), 6, b'M'), SourceCount::TelegramKind),
        70 => (good()[..44].to_vec(), SourceCount::TelegramLength),
        80 => (mended(good(), 22, 0xff), SourceCount::TelegramLength),
        _ => return None,
    })
}

/// CRC-32 of IEEE 802.3, bit by bit: an implementation of its own, so that the receiver's is checked.
fn crc_of(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
        }
    }
    !crc
}

#[test]
fn a_hundred_thousand_telegrams_arrive_and_hostile_ones_are_counted_by_name() {
    const TELEGRAMS: u32 = 100_000;
    let port = free_port();
    let (_folder, settings) = train(port);
    let mut feed = open(&settings).unwrap();
    let senders = [UdpSocket::bind("127.0.0.1:0").unwrap(), UdpSocket::bind("127.0.0.2:0").unwrap()];
    let foreign = UdpSocket::bind("127.0.0.3:0").unwrap();
    let (mut sent, mut samples) = (0_u64, [0_u32; WAGONS]);
    let mut expected: Vec<(SourceCount, u64)> = Vec::new();
    let mut expect = |what: SourceCount| match expected.iter_mut().find(|(known, _)| *known == what) {
        Some((_, count)) => *count += 1,
        None => expected.push((what, 1)),
    };
    let until = Instant::now() + Duration::from_secs(300);
    let mut take = |feed: &mut dyn Feed, sent: u64| {
        loop {
            feed.take_due(0.0, &mut |arrival| match arrival {
                Arrival::Row { wagon, row, .. } => {
                    let cycle = row.position_m as u32;
                    // Two of every thousand never were sent.
                    samples[wagon] += 1;
                    assert!((row.v_m_s - 20.0).abs() < 1e-9, "{}", row.v_m_s);
                    assert_eq!(row.wheel_speed_rad_s[1].is_nan(), cycle.is_multiple_of(10), "{cycle}");
                    assert!((row.wheel_speed_rad_s[0] - 20.0 / 0.44).abs() < 1e-5);
                }
                other => panic!("{other:?}"),
            });
            let arrived = feed.accounts().unwrap().0.counts[SourceCount::Arrived.code() as usize];
            if arrived >= sent || Instant::now() > until {
                return;
            }
            std::thread::yield_now();
        }
    };
    for number in 0..TELEGRAMS {
        let wagon = number as usize % WAGONS;
        let sequence = number / WAGONS as u32;
        if sequence % 1000 >= 998 {
            expect(SourceCount::Lost);
            continue;
        }
        senders[wagon].send_to(&telegram(sequence, 2001), ("127.0.0.1", port)).unwrap();
        sent += 1;
        if let Some((datagram, what)) = hostile(sequence) {
            senders[wagon].send_to(&datagram, ("127.0.0.1", port)).unwrap();
            sent += 1;
            expect(what);
        }
        if number.is_multiple_of(5000) {
            foreign.send_to(&telegram(sequence, 2001), ("127.0.0.1", port)).unwrap();
            sent += 1;
            expect(SourceCount::ForeignSender);
        }
        // No more than the smallest queue of a socket holds.
        if number.is_multiple_of(50) {
            take(&mut *feed, sent);
        }
    }
    take(&mut *feed, sent);
    // Every queued row.
    std::thread::sleep(Duration::from_millis(200));
    take(&mut *feed, sent);
    let (whole, wagons) = feed.accounts().unwrap();
    println!("sent {sent}, samples {samples:?}, counted {:?}", whole.counts);
    assert_eq!(whole.counts[SourceCount::Arrived.code() as usize], sent);
    for (what, count) in expected {
        // The last two of a sender are missed by nobody.
        let unseen = if what == SourceCount::Lost { 2 * WAGONS as u64 } else { 0 };
        assert_eq!(whole.counts[what.code() as usize], count - unseen, "{what}");
    }
    let each = TELEGRAMS / WAGONS as u32 / 1000 * 998;
    assert_eq!(samples, [each; WAGONS]);
    let dropped =
        |what: SourceCount| wagons.iter().map(|wagon| wagon.counts[what.code() as usize]).sum::<u64>();
    assert_eq!((dropped(SourceCount::Late), dropped(SourceCount::Withheld)), (0, 0));
}
