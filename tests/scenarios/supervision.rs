//! `railgrip up` keeps a train alive: whoever is killed comes back, nobody else notices, and nothing is left behind.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::time::{Duration, Instant};

use rustix::process::Signal;

use railgrip_tests::{Process, TrainUnderTest, program, within};

fn config(name: &str, wagons: u32) -> String {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml");
    format!(
        "schema = 1\n[train]\nname = \"{name}\"\nwagons = {wagons}\nvehicle = \"{vehicle}\"\n\
         [source]\nkind = \"simulate\"\nscenario = \"demo\"\nseed = 7\n\
         [logging]\nlevel = \"debug\"\nformat = \"text\"\n"
    )
}

fn running(name: &str, wagons: u32) -> TrainUnderTest {
    let mut train = TrainUnderTest::new(program!(), &config(name, wagons));
    train.start();
    let took = train.wait_ready(Duration::from_secs(20));
    println!("{name}: {wagons} wagons ready after {:.2} s", took.as_secs_f64());
    train
}

fn others(train: &TrainUnderTest, killed: &Process) -> Vec<Process> {
    train.processes().into_iter().filter(|process| process.role != killed.role).collect()
}

/// Kills a process and checks that it comes back while every other process stays the same.
fn kill_one(train: &TrainUnderTest, role: &str) {
    let victim = train.process(role);
    let before = others(train, &victim);
    let killed = Instant::now();
    victim.kill();
    let _ = train.successor(&victim);
    let restarted = killed.elapsed();
    train.wait_ready(Duration::from_secs(15));
    println!(
        "{role}: new process after {:.0} ms, train ready after {:.0} ms",
        restarted.as_secs_f64() * 1e3,
        killed.elapsed().as_secs_f64() * 1e3
    );
    assert_eq!(others(train, &victim), before, "nobody else may be disturbed");
    assert_eq!(missed(train), 0, "no estimator that lives may miss a sample");
}

/// Samples that the estimators of the train missed.
fn missed(train: &TrainUnderTest) -> u64 {
    let view = train.http().and_then(|http| http.json("/api/v1/train")).expect("the train");
    let processes = view["processes"].as_array().expect("processes");
    processes.iter().filter_map(|process| process["missed"].as_u64()).sum()
}

#[test]
fn killed_children_come_back_and_nobody_else_notices() {
    let mut train = running("kill-one", 3);
    for role in ["estimator 2", "ingest", "health", "estimator 2"] {
        kill_one(&train, role);
    }
    let status = train.stop();
    assert!(status.success(), "{status}\n{}", train.log());
    assert_eq!(train.processes(), [], "no orphans");
    assert_eq!(train.shared_memory(), Vec::<String>::new(), "no shared memory left");
}

/// What `up` said of a process, in order: `died` with its pause, `started`.
fn said_of(train: &TrainUnderTest, role: &str) -> Vec<String> {
    let log = train.log();
    let name = format!("process=\"{}\"", if role == "hold" { "holder" } else { role });
    let of_role = log.lines().filter(|line| line.contains(&name));
    let words = of_role.filter_map(|line| match line {
        line if line.contains(" died; will be started again ") => {
            Some(format!("died, {}", line.split(' ').find(|word| word.starts_with("pause_s"))?))
        }
        line if line.contains(" started ") => Some("started".to_owned()),
        _ => None,
    });
    words.collect()
}

#[test]
fn the_first_death_is_answered_by_a_start_at_once() {
    let mut train = running("at-once", 2);
    let roles = ["estimator 1", "health", "ingest", "diagnoser", "hold"];
    for role in roles {
        let victim = train.process(role);
        victim.kill();
        let _ = train.successor(&victim);
        train.wait_ready(Duration::from_secs(15));
    }
    let said = said_of(&train, "hold");
    assert_eq!(said, ["started", "died, pause_s=0.0", "started"], "{}", train.log());
    for role in &roles[..4] {
        // Once more when the channels went with their holder.
        let expected = ["started", "died, pause_s=0.0", "started", "started"];
        let started = within(Duration::from_secs(10), || (said_of(&train, role) == expected).then_some(()));
        assert!(started.is_some(), "{role}: {:?}\n{}", said_of(&train, role), train.log());
    }
    assert!(train.stop().success(), "{}", train.log());
}

/// The heartbeat of an estimator as it is served.
fn estimator(train: &TrainUnderTest, wagon: u64) -> Option<serde_json::Value> {
    let view = train.http()?.json("/api/v1/train")?;
    let processes = view["processes"].as_array()?;
    let own = |one: &&serde_json::Value| one["process"] == "estimator" && one["wagon"] == wagon;
    processes.iter().find(own).cloned()
}

#[test]
fn what_is_sent_while_an_estimator_is_away_is_counted_under_a_name() {
    let mut train = running("unseen", 2);
    let taken = |wagon| estimator(&train, wagon)?["received"].as_u64();
    let up = train.process("up");
    let victim = train.process("estimator 2");
    // Nobody starts it again as long as `up` sleeps.
    up.signal(Signal::STOP);
    victim.kill();
    let before = within(Duration::from_secs(10), || taken(1)).expect("figures of wagon 1");
    let later = within(Duration::from_secs(10), || taken(1).filter(|later| *later > before + 250));
    up.signal(Signal::CONT);
    assert!(later.is_some(), "{:?}", estimator(&train, 1));
    let successor = train.successor(&victim);
    let unseen = within(Duration::from_secs(10), || {
        let heard = estimator(&train, 2).filter(|view| view["pid"] == successor.pid)?;
        heard["received"].as_u64().filter(|received| *received > 0)?;
        heard["unseen"].as_u64()
    });
    println!("unseen: {unseen:?}");
    assert!(unseen.is_some_and(|unseen| unseen >= 50), "{unseen:?}\n{}", train.log());
    assert_eq!(estimator(&train, 1).expect("wagon 1")["unseen"], 0);
    let (_, metrics) = train.http().and_then(|http| http.get("/metrics")).expect("metrics");
    let of_two = |line: &&str| {
        line.starts_with("railgrip_process_unseen_total") && line.contains("estimator\",wagon=\"2\"")
    };
    let line = metrics.lines().find(of_two);
    let shown = line.and_then(|line| line.rsplit(' ').next()?.parse::<f64>().ok());
    assert!(shown.is_some_and(|shown| shown >= 50.0), "{line:?}");
    assert!(train.stop().success(), "{}", train.log());
}

/// True if what is served of wagon 2 was measured well after that instant.
fn acquired_since(train: &TrainUnderTest, instant: Instant) -> Option<()> {
    let elapsed_s = instant.elapsed().as_secs_f64();
    let age_s = train.http()?.json("/api/v1/wagons/2")?["age_s"].as_f64()?;
    (age_s < elapsed_s - 0.05).then_some(())
}

#[test]
fn who_is_killed_at_work_again_and_again_is_back_soon() {
    let mut train = running("killed-at-work", 3);
    let mut slowest: Vec<(Duration, &str)> = Vec::new();
    for round in 0..7 {
        for role in ["ingest", "estimator 2", "health"] {
            // Long enough at work to be trusted, too short for the deaths before to be forgotten.
            std::thread::sleep(Duration::from_millis(1200));
            let victim = train.process(role);
            let killed = Instant::now();
            victim.kill();
            let _ = train.successor(&victim);
            let started = killed.elapsed();
            let fresh = within(Duration::from_secs(15), || acquired_since(&train, killed));
            assert!(fresh.is_some(), "{role}: {:?}\n{}", train.processes(), train.log());
            slowest.push((killed.elapsed(), role));
            println!(
                "round {round}, {role}: new process after {:.0} ms, fresh figures after {:.0} ms",
                started.as_secs_f64() * 1e3,
                killed.elapsed().as_secs_f64() * 1e3
            );
        }
    }
    // A pause that grew with each death would be 3.2 s by now.
    let (slowest, role) = slowest.into_iter().max().expect("some");
    println!("slowest: {role}, {:.0} ms", slowest.as_secs_f64() * 1e3);
    assert!(slowest < Duration::from_secs(3), "{role} was away for {slowest:?}\n{}", train.log());
    let status = train.stop();
    assert!(!status.success() && train.log().contains("died 7 times in a row"), "{status}\n{}", train.log());
    assert_eq!(train.processes(), [], "no orphans");
}

#[test]
fn a_process_that_hangs_is_noticed_and_restarted_and_nobody_else_is() {
    let mut train = running("hang", 3);
    for role in ["estimator 2", "health"] {
        let victim = train.process(role);
        let before = others(&train, &victim);
        let stopped = Instant::now();
        victim.signal(Signal::STOP);
        std::thread::sleep(Duration::from_secs(5));
        assert!(train.processes().contains(&victim), "a pause of some seconds is no hang");
        let successor = within(Duration::from_secs(15), || {
            train.processes().into_iter().find(|process| process.role == role && process.pid != victim.pid)
        });
        assert!(successor.is_some(), "{role} still hangs: {:?}\n{}", train.processes(), train.log());
        println!("{role}: stopped, and restarted after {:.1} s", stopped.elapsed().as_secs_f64());
        assert!(stopped.elapsed() < Duration::from_secs(20));
        train.wait_ready(Duration::from_secs(15));
        assert_eq!(others(&train, &victim), before, "nobody else may be disturbed");
    }
    assert!(train.log().contains("hangs; killed"), "{}", train.log());
    assert!(train.stop().success());
    assert_eq!(train.shared_memory(), Vec::<String>::new(), "no shared memory left");
}

#[test]
fn a_killed_holder_leads_to_an_orderly_restart_of_all() {
    let mut train = running("kill-holder", 2);
    for _ in 0..3 {
        let before = train.processes();
        let holder = train.process("hold");
        let killed = Instant::now();
        holder.kill();
        let _ = train.successor(&holder);
        let renewed = within(Duration::from_secs(15), || {
            let now = train.processes();
            let all_new = now.iter().all(|process| process.role == "up" || !before.contains(process));
            (all_new && now.len() == before.len()).then_some(())
        });
        assert!(renewed.is_some(), "{before:?}\n{:?}\n{}", train.processes(), train.log());
        train.wait_ready(Duration::from_secs(15));
        println!("holder: train ready again after {:.0} ms", killed.elapsed().as_secs_f64() * 1e3);
    }
    assert!(train.stop().success());
    assert_eq!(train.shared_memory(), Vec::<String>::new());
}

#[test]
fn a_killed_supervisor_leaves_no_orphans_and_no_obstacle() {
    let mut train = running("kill-up", 2);
    train.kill_up();
    let gone = within(Duration::from_secs(10), || train.processes().is_empty().then_some(()));
    assert!(gone.is_some(), "orphans: {:?}\n{}", train.processes(), train.log());
    assert_eq!(train.shared_memory(), Vec::<String>::new(), "the holder cleans up even then");
    train.start();
    train.wait_ready(Duration::from_secs(20));
    let old = train.processes();
    train.kill_up();
    // At once: the old holder may still be leaving.
    train.start();
    train.wait_gone(&old);
    train.wait_ready(Duration::from_secs(20));
    let status = train.stop();
    assert!(status.success(), "{status}\n{}", train.log());
}

#[test]
fn a_second_up_of_the_same_train_is_refused_in_words() {
    let train = running("twice", 1);
    let second = train.run(&["up"]);
    let words = String::from_utf8_lossy(&second.stderr);
    println!("{words}");
    assert_eq!(second.status.code(), Some(1));
    assert!(words.contains("train \"twice\" is already up (process "), "{words}");
    let hold = train.run(&["hold", "--patience", "0.1"]);
    let words = String::from_utf8_lossy(&hold.stderr);
    assert!(words.contains("already running on this machine"), "{words}");
    train.wait_ready(Duration::from_secs(1));
}

#[test]
fn status_shows_every_wagon_as_table_and_as_json() {
    let train = running("status", 2);
    let table = train.run(&["status"]);
    let words = String::from_utf8_lossy(&table.stdout);
    println!("{words}");
    assert!(table.status.success() && words.lines().count() == 4, "{words}");
    assert!(words.contains("wagon-1") && words.contains("wagon-2") && words.contains("live"), "{words}");
    let json = train.run(&["status", "--json"]);
    let both: serde_json::Value = serde_json::from_slice(&json.stdout).expect("JSON");
    assert_eq!(both["wagons"].as_array().map(Vec::len), Some(2));
    assert_eq!(both["train"]["ready"], true);
    drop(train);
    let train = TrainUnderTest::new(program!(), &config("nobody", 1));
    let nobody = train.run(&["status"]);
    let words = String::from_utf8_lossy(&nobody.stderr);
    assert_eq!(nobody.status.code(), Some(1));
    assert!(words.contains("serves no HTTP on this machine"), "{words}");
}

#[test]
fn a_child_without_a_holder_says_what_is_missing() {
    let train = TrainUnderTest::new(program!(), &config("alone", 2));
    let lone = train.run(&["estimator", "--wagon", "1"]);
    let words = String::from_utf8_lossy(&lone.stderr);
    assert_eq!(lone.status.code(), Some(1), "{words}");
    assert!(words.contains("has no holder") && words.contains("railgrip hold"), "{words}");
    let wrong = train.run(&["estimator", "--wagon", "3"]);
    let words = String::from_utf8_lossy(&wrong.stderr);
    assert_eq!(wrong.status.code(), Some(2), "{words}");
    assert!(words.contains("allowed is 1 to 2"), "{words}");
}

#[test]
fn up_for_a_while_ends_by_itself() {
    let mut train = TrainUnderTest::new(program!(), &config("for", 2));
    let started = Instant::now();
    train.start_with(&["--for", "1.5"]);
    let status = train.wait();
    println!("ended after {:.2} s", started.elapsed().as_secs_f64());
    assert!(status.success(), "{status}\n{}", train.log());
    assert!(started.elapsed() >= Duration::from_millis(1500));
    assert_eq!(train.processes(), []);
    assert_eq!(train.shared_memory(), Vec::<String>::new());
}
