//! Frames of a bus become samples by a DBC file and the mapping, and each frame that does not is counted under a name. A log in the
//! form of candump stands for the bus: it takes the same way.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may end at what it does not expect, and says what it saw"
)]

use railgrip_ingest::feed::{Account, Arrival, Next, open};
use railgrip_messages::SourceCount;
use railgrip_settings::{Overrides, TrainSettings, mistakes};
use std::fmt::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

const DATABASE: &str = r#"VERSION ""

NS_ :

BS_:

BU_: BCU

BO_ 256 W1Axles: 8 BCU
 SG_ N1 : 0|16@1+ (0.01,0) [0|600] "rad/s" BCU
 SG_ N2 : 16|16@1+ (0.01,0) [0|600] "rad/s" BCU
 SG_ Cycle : 32|16@1+ (1,0) [0|0] "" BCU

BO_ 257 W2Axles: 8 BCU
 SG_ N1 : 0|16@1+ (0.01,0) [0|600] "rad/s" BCU
 SG_ N2 : 16|16@1+ (0.01,0) [0|600] "rad/s" BCU

BO_ 2566845950 Train: 8 BCU
 SG_ V : 7|16@0+ (0.01,0) [0|600] "km/h" BCU
 SG_ P : 23|16@0+ (0.001,0) [0|12] "bar" BCU
"#;

fn config(source: &str, wagons: u32) -> String {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/vehicle.toml");
    format!(
        "schema = 1\n[train]\nname = \"bus\"\nwagons = {wagons}\nvehicle = \"{vehicle}\"\n[source]\nkind = \"can\"\n\
         database = \"train.dbc\"\n{source}\n[mapping]\nv_m_s = {{ from = \"Train.V\", unit = \"km/h\" }}\n\
         omega_f_rad_s = {{ from = \"W{{wagon}}Axles.N1\" }}\nomega_r_rad_s = {{ from = \"W{{wagon}}Axles.N2\" }}\n\
         f_perp_f_n = {{ from = \"P\", unit = \"bar\", scale = 0.16 }}\nf_perp_r_n = {{ from = \"P\", unit = \"bar\", scale = 0.16 }}\n"
    )
}

fn settings(folder: &Path, source: &str, wagons: u32) -> TrainSettings {
    std::fs::write(folder.join("train.dbc"), DATABASE).unwrap();
    TrainSettings::parse(&folder.join("train.toml"), &config(source, wagons), &Overrides::default()).unwrap()
}

/// Wagon, time, speed and speed of the first wheelset of a sample.
type Seen = (usize, f64, f64, f64);

/// All samples, what was counted, and what was refused.
fn played(settings: &TrainSettings) -> (Vec<Seen>, Account, Vec<String>) {
    let mut feed = open(settings).unwrap();
    let (mut samples, mut refused) = (Vec::new(), Vec::new());
    let until = Instant::now() + Duration::from_secs(60);
    let mut next = Next::More;
    while next == Next::More {
        assert!(Instant::now() < until, "the log does not end");
        next = feed.take_due(0.0, &mut |arrival| match arrival {
            Arrival::Row { wagon, row, .. } => {
                assert!(row.pressing_force_n[0] >= 0.0 || row.v_m_s.is_nan());
                samples.push((wagon, row.t_s, row.v_m_s, row.wheel_speed_rad_s[0]));
            }
            Arrival::Refused(problem) => refused.push(problem),
            other => panic!("{other:?}"),
        });
        std::thread::sleep(Duration::from_millis(1));
    }
    let (whole, _) = feed.accounts().unwrap();
    (samples, whole, refused)
}

fn count(account: &Account, what: SourceCount) -> u64 {
    account.counts[what.code() as usize]
}

#[test]
fn every_frame_of_a_log_is_a_sample_or_counted_under_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let mut log = String::new();
    let steps = 3000_u64;
    for step in 0..steps {
        let t_us = 1_760_000_000_000_000 + step * 10_000;
        let mut frame = |offset: u64, text: &str| {
            let t_us = t_us + offset;
            writeln!(log, "({}.{:06}) can0 {text}", t_us / 1_000_000, t_us % 1_000_000).unwrap();
        };
        // 72 km/h and no brake; wheels of 0.44 m.
        frame(0, "18FEF5FE#1C20000000000000");
        let wheels = 4545 + step % 3;
        frame(100, &format!("100#{:02X}{:02X}C1110000", wheels & 0xff, wheels >> 8));
        frame(200, "101#C111C111");
        match step {
            700 => frame(300, "20000004#0004000000000000"),
            701 => frame(300, "100#R8"),
            702 => frame(300, "7FF#0102"),
            703 => frame(300, "nonsense"),
            // Only the first wheelset has arrived; then a mark instead of a speed.
            704 => frame(300, "101#C1"),
            705 => frame(300, "18FEF5FE#FFFF000000000000"),
            // A frame of CAN FD with the same identifier.
            706 => frame(300, "101##1C111C111"),
            _ => {}
        }
    }
    log.push_str("(1.0) can0 100#00\n\u{fffd}\n");
    std::fs::write(folder.path().join("bus.log"), log).unwrap();
    let settings = settings(folder.path(), "file = \"bus.log\"\nspeed = 1000", 2);
    let (samples, whole, refused) = played(&settings);
    // Two wagons, each step; one short frame and one of CAN FD more.
    assert_eq!(samples.len() as u64, 2 * steps + 2);
    let first = samples.iter().filter(|(wagon, ..)| *wagon == 0);
    for (step, (_, t_s, v_m_s, omega)) in first.enumerate() {
        let expected_t_s = 1_760_000_000.000_1 + step as f64 * 0.01;
        assert!((t_s - expected_t_s).abs() < 2e-6 && (v_m_s - 20.0).abs() < 1e-9, "{step}: {t_s} {v_m_s}");
        assert!((omega - (45.45 + (step % 3) as f64 * 0.01)).abs() < 1e-9, "{step}: {omega}");
    }
    let counted = |what| count(&whole, what);
    println!("{:?} {refused:?}", whole.counts);
    assert_eq!(counted(SourceCount::Arrived), 3 * steps + 6 + 3, "frames and lines that are none");
    assert_eq!((counted(SourceCount::ErrorFrame), counted(SourceCount::RemoteFrame)), (1, 1));
    assert_eq!((counted(SourceCount::Unwanted), counted(SourceCount::Unreadable)), (1, 3));
    // One byte holds neither wheelset; the mark is missing to both wagons.
    assert_eq!((counted(SourceCount::Short), counted(SourceCount::OutOfRange)), (2, 2));
    assert!(
        refused[0].contains("bus.log, line 2") && refused[0].contains("Invalid CAN frame"),
        "{refused:?}"
    );
}

#[test]
fn of_several_buses_each_feeds_its_wagon() {
    let folder = tempfile::tempdir().unwrap();
    let mut log = String::new();
    for step in 0..100 {
        for bus in ["can0", "can1", "can7"] {
            let wheels = if bus == "can1" { "1027" } else { "C111" };
            writeln!(log, "(10.{step:02}0000) {bus} 18FEF5FE#1C20000000000000").unwrap();
            writeln!(log, "(10.{step:02}0001) {bus} 100#{wheels}{wheels}0000").unwrap();
        }
    }
    std::fs::write(folder.path().join("bus.log"), log).unwrap();
    std::fs::write(folder.path().join("train.dbc"), DATABASE).unwrap();
    let text = config("file = \"bus.log\"\nspeed = 1000\ninterface = [\"can0\", \"can1\"]", 2)
        .replace("W{wagon}", "W1");
    let settings =
        TrainSettings::parse(&folder.path().join("train.toml"), &text, &Overrides::default()).unwrap();
    let (samples, whole, refused) = played(&settings);
    let of = |wanted: usize| samples.iter().filter(move |(wagon, ..)| *wagon == wanted);
    assert_eq!((of(0).count(), of(1).count(), refused.len()), (100, 100, 0));
    assert!(of(0).all(|(.., omega)| *omega == 45.45) && of(1).all(|(.., omega)| *omega == 100.0));
    assert_eq!(count(&whole, SourceCount::Unwanted), 200, "frames of a bus that no wagon has");
}

#[test]
fn what_is_wrong_in_a_config_is_named_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("train.dbc"), DATABASE).unwrap();
    let file = folder.path().join("train.toml");
    let said = |source: &str, from: &str, to: &str| {
        let found = mistakes(&file, &config(source, 2).replace(from, to), &Overrides::default());
        found.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    };
    assert_eq!(said("interface = \"can0\"", "", ""), "");
    let unknown = said("interface = \"can0\"", "Train.V", "Train.Speed");
    assert!(unknown.contains("no message has \"Train.Speed\""), "{unknown}");
    let shared = said("interface = \"can0\"", "W{wagon}", "W1");
    assert!(shared.contains("wagons 1 and 2 both take W1Axles.N1"), "{shared}");
    let few = said("interface = [\"can0\", \"can1\", \"can2\"]", "W{wagon}", "W1");
    assert!(few.contains("one for each of the 2 wagons"), "{few}");
    assert!(said("", "", "").contains("source.interface"), "neither bus nor log");
    assert!(said("interface = \"can0\"\nspeed = 2", "", "").contains("nothing here without `file`"));
    let absent = said("interface = \"can0\"", "train.dbc", "other.dbc");
    assert!(absent.contains("train.toml:8: `source.database` is \"other.dbc\" (No such file"), "{absent}");
    let foreign = said("interface = \"can0\"\nsenders = [\"10.0.0.1\"]", "", "");
    assert!(foreign.contains("nothing here for kind = \"can\""), "{foreign}");
}
