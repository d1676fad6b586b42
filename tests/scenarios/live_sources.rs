//! Samples that others send: each arrives as one estimate or is counted under a name, whatever the packets look like.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::io::Write;
use std::process::{Child, ChildStdin, Stdio};
use std::time::{Duration, Instant};

use railgrip_tests::{TrainUnderTest, program, within};
use serde_json::Value;

const PATIENCE: Duration = Duration::from_secs(20);

fn config(name: &str, source: &str) -> String {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml");
    format!(
        "schema = 1\n[train]\nname = \"{name}\"\nwagons = 1\nvehicle = \"{vehicle}\"\n[source]\n{source}\n\
         [logging]\nlevel = \"info\"\nformat = \"text\"\n"
    )
}

/// A line of a coach that rolls at 20 m/s.
fn line(t_s: f64) -> String {
    let omega = 20.0 / 0.44;
    format!(
        "{{\"wagon\":1,\"t_s\":{t_s:.4},\"v_m_s\":20,\"omega_f_rad_s\":{omega},\"omega_r_rad_s\":{omega},\
         \"f_perp_f_n\":0,\"f_perp_r_n\":0}}\n"
    )
}

/// A train that reads our lines.
struct Fed {
    train: TrainUnderTest,
    up: Child,
}

impl Fed {
    fn start(name: &str) -> (Self, ChildStdin) {
        let train = TrainUnderTest::new(program!(), &config(name, "kind = \"stdin\""));
        let log = std::fs::File::create(train.folder().join("log")).expect("log");
        let mut command = train.command(&["up"]);
        let mut up =
            command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(log).spawn().expect("start `up`");
        let input = up.stdin.take().expect("piped");
        let fed = Self { train, up };
        let there = within(PATIENCE, || fed.process("estimator").and(fed.process("ingest")));
        assert!(
            there.is_some(),
            "{}",
            std::fs::read_to_string(fed.train.folder().join("log")).unwrap_or_default()
        );
        (fed, input)
    }

    /// A process by its last heartbeat.
    fn process(&self, kind: &str) -> Option<Value> {
        let view = self.train.http()?.json("/api/v1/train")?;
        view["processes"].as_array()?.iter().find(|process| process["process"] == kind).cloned()
    }

    /// Waits until a process has counted so many.
    fn counts(&self, kind: &str, name: &str, count: u64) {
        let seen = || self.process(kind).filter(|process| process[name].as_u64() == Some(count));
        assert!(within(PATIENCE, seen).is_some(), "{kind} {name}: {:?}", self.process(kind));
    }
}

impl Drop for Fed {
    fn drop(&mut self) {
        let _ = self.up.kill();
        let _ = self.up.wait();
    }
}

#[test]
fn two_hundred_a_second_and_packets_of_ten_arrive_without_loss_and_repeats_are_counted() {
    let (fed, mut input) = Fed::start("lines");
    let begin = Instant::now();
    for k in 0..600_u32 {
        let due = begin + Duration::from_millis(5) * k;
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        input.write_all(line(f64::from(k) * 0.005).as_bytes()).expect("written");
    }
    for packet in 0..30_u32 {
        let lines: String = (0..10).map(|k| line(3.0 + f64::from(packet * 10 + k) * 0.005)).collect();
        input.write_all(lines.as_bytes()).expect("written");
        std::thread::sleep(Duration::from_millis(50));
    }
    // The last packet once more, and a line that is wrong.
    let again: String = (290..300).map(|k| line(3.0 + f64::from(k) * 0.005)).collect();
    input.write_all(again.as_bytes()).expect("written");
    input.write_all(b"nonsense\n").expect("written");
    input.flush().expect("flushed");
    fed.counts("ingest", "received", 911);
    fed.counts("ingest", "published", 900);
    fed.counts("ingest", "late", 10);
    fed.counts("ingest", "rejected", 1);
    fed.counts("estimator", "received", 900);
    for name in ["late", "missed", "rejected"] {
        fed.counts("estimator", name, 0);
    }
    println!("{:?}", fed.process("estimator"));
}
