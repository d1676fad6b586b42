//! Two hundred `kill -9` at random moments of start-up; after each the train must still come up.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::time::{Duration, Instant};

use railgrip_tests::{Random, TrainUnderTest, program, within};

/// Trains that are tormented side by side.
const TRAINS: u64 = 4;
/// Kills on each of them.
const KILLS: u64 = 50;
/// Supervisor, holder, ingest, health, diagnoser and two estimators.
const PROCESSES: usize = 7;
/// Kills come within so many milliseconds of the start.
const START_UP_MS: usize = 120;

fn config() -> String {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml");
    format!(
        "schema = 1\n[train]\nname = \"tormented\"\nwagons = 2\nvehicle = \"{vehicle}\"\n\
         [source]\nkind = \"simulate\"\nscenario = \"demo\"\nseed = 3\n\
         [logging]\nlevel = \"info\"\nformat = \"text\"\n"
    )
}

/// Kills one process, or the supervisor, or all, at a random moment of start-up. What is left is killed as well (as a
/// power cut would) or left to its supervisor.
fn torment(train: &mut TrainUnderTest, random: &mut Random) -> String {
    train.start();
    std::thread::sleep(Duration::from_millis(random.below(START_UP_MS) as u64));
    let processes = train.processes();
    let victim = processes.get(random.below(processes.len())).cloned();
    let words = victim.as_ref().map_or("nobody".to_owned(), |victim| victim.role.clone());
    match victim {
        Some(victim) if victim.role != "up" => victim.kill(),
        _ => train.kill_up(),
    }
    if random.below(2) == 0 {
        train.kill_up();
    }
    words
}

#[test]
fn two_hundred_kills_leave_no_train_that_will_not_start() {
    let started = Instant::now();
    let slowest = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..TRAINS)
            .map(|seed| {
                scope.spawn(move || {
                    let mut random = Random::new(seed);
                    let mut train = TrainUnderTest::new(program!(), &config());
                    let mut slowest = (Duration::ZERO, String::new());
                    for kill in 0..KILLS {
                        let victim = torment(&mut train, &mut random);
                        if !train.is_up() {
                            let old = train.processes();
                            train.start();
                            train.wait_gone(&old);
                        }
                        let took = train.wait_ready(Duration::from_secs(30));
                        slowest = slowest.max((took, format!("train {seed}, kill {kill}: {victim}")));
                        let complete = within(Duration::from_secs(10), || {
                            (train.processes().len() == PROCESSES).then_some(())
                        });
                        assert!(complete.is_some(), "{victim}: {:?}\n{}", train.processes(), train.log());
                        // The next round begins from nothing, in order or not.
                        if random.below(2) == 0 {
                            train.kill_up();
                        } else {
                            let _ = train.stop();
                        }
                    }
                    slowest
                })
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().expect("a train did not start")).max()
    });
    println!(
        "{} kills in {:.0} s, slowest start: {slowest:?}",
        TRAINS * KILLS,
        started.elapsed().as_secs_f64()
    );
}
