//! SIGHUP: a running train reads its config again. What can be taken over is taken over, who must start again does so in its turn,
//! and a config that is wrong changes nothing.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::time::{Duration, Instant};

use rustix::process::Signal;
use serde_json::Value;

use railgrip_tests::{Process, TrainUnderTest, program, within};

const PATIENCE: Duration = Duration::from_secs(30);

fn config(name: &str) -> String {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml");
    format!(
        "schema = 1\n[train]\nname = \"{name}\"\nvehicle = \"{vehicle}\"\n[[wagon]]\n[[wagon]]\n[[wagon]]\n\
         [source]\nkind = \"simulate\"\nscenario = \"demo\"\nseed = 7\n[alerts]\nraise_after_s = 2.0\n\
         [logging]\nlevel = \"info\"\nformat = \"text\"\n"
    )
}

fn running(name: &str) -> TrainUnderTest {
    let mut train = TrainUnderTest::new(program!(), &config(name));
    train.start();
    train.wait_ready(PATIENCE);
    train
}

/// Replaces a part of the train's config file.
fn edit(train: &TrainUnderTest, from: &str, to: &str) {
    let file = train.folder().join("train.toml");
    let text = std::fs::read_to_string(&file).expect("the config");
    assert!(text.contains(from), "{from}");
    std::fs::write(&file, text.replacen(from, to, 1)).expect("written");
}

fn reload(train: &TrainUnderTest) {
    train.process("up").signal(Signal::HUP);
}

/// Waits until the log says something.
fn logged(train: &TrainUnderTest, words: &str) {
    let said = within(PATIENCE, || train.log().contains(words).then_some(()));
    assert!(said.is_some(), "{words}\n{}", train.log());
}

fn json(train: &TrainUnderTest, path: &str) -> Option<Value> {
    train.http()?.json(path)
}

/// The grade of the filter's indicator on a wagon.
fn filter_grade(train: &TrainUnderTest, wagon: u32) -> Option<String> {
    let view = json(train, &format!("/api/v1/wagons/{wagon}"))?;
    view["filter"]["grade"].as_str().map(str::to_owned)
}

/// States of the data of some wagons.
fn states(train: &TrainUnderTest, wagons: &[u64]) -> Option<Vec<String>> {
    let view = json(train, "/api/v1/wagons")?;
    let rows = view["wagons"].as_array()?;
    let of = |number: &u64| rows.iter().find(|row| row["id"].as_u64() == Some(*number));
    wagons.iter().map(|number| Some(of(number)?["state"].as_str()?.to_owned())).collect()
}

fn ended(train: &mut TrainUnderTest) {
    let status = train.stop();
    assert!(status.success(), "{status}\n{}", train.log());
    nothing_is_left(train);
}

fn nothing_is_left(train: &TrainUnderTest) {
    assert_eq!(train.processes(), [], "no orphans");
    assert_eq!(train.shared_memory(), Vec::<String>::new(), "no shared memory left");
    let files = std::fs::read_dir(train.instance()).expect("the folder").flatten();
    let names: Vec<String> = files.map(|file| file.file_name().to_string_lossy().into_owned()).collect();
    let living = ["notify-", "config.accepted", "http.address", "holder.new"];
    let left = |name: &&String| living.iter().any(|word| name.starts_with(word));
    assert_eq!(names.iter().find(left), None, "{names:?}");
}

#[test]
fn thresholds_are_in_effect_and_no_process_starts_again() {
    let mut train = running("taken-over");
    let ok = within(PATIENCE, || (filter_grade(&train, 1)? == "ok").then_some(()));
    assert!(ok.is_some(), "{:?}", json(&train, "/api/v1/wagons/1"));
    let before = train.processes();
    // A filter whose innovations are not exactly as expected is to be watched, at once.
    edit(
        &train,
        "raise_after_s = 2.0\n",
        "raise_after_s = 0.0\n[indicators.filter]\nnis_watch_low = 1.0\nnis_watch_high = 1.0\n",
    );
    edit(&train, "level = \"info\"", "level = \"debug\"");
    let asked = Instant::now();
    reload(&train);
    for wagon in 1..=3 {
        let watch = within(PATIENCE, || (filter_grade(&train, wagon)? == "watch").then_some(()));
        assert!(watch.is_some(), "{:?}\n{}", json(&train, &format!("/api/v1/wagons/{wagon}")), train.log());
    }
    println!("in effect on three wagons after {:.2} s", asked.elapsed().as_secs_f64());
    let settings = json(&train, "/api/v1/settings").expect("settings");
    let of = |key: &str| {
        let all = settings["settings"].as_array().expect("a list");
        all.iter().find(|one| one["key"] == key).and_then(|one| one["value"].as_f64())
    };
    assert_eq!((of("filter.nis_watch_low"), of("filter.nis_watch_high")), (Some(1.0), Some(1.0)));
    assert_eq!(settings["waits_for_start"], false, "what the file says holds");
    let alert = within(PATIENCE, || {
        let alerts = json(&train, "/api/v1/alerts")?;
        let all = alerts["alerts"].as_array()?.clone();
        all.into_iter().find(|one| one.to_string().contains("filter"))
    });
    assert!(alert.is_some(), "{:?}", json(&train, "/api/v1/alerts"));
    assert_eq!(train.processes(), before, "nobody starts again");
    // Nothing new is nothing at all.
    reload(&train);
    logged(&train, "says nothing new");
    assert_eq!(train.processes(), before);
    ended(&mut train);
}

#[test]
fn another_filter_of_one_wagon_restarts_its_estimator_and_nobody_else_is_blind() {
    let mut train = running("one-wagon");
    let before = train.processes();
    let old = train.process("estimator 2");
    edit(
        &train,
        "[[wagon]]\n[[wagon]]\n[[wagon]]\n",
        "[[wagon]]\n[[wagon]]\nfilter = \"paper\"\n[[wagon]]\n",
    );
    reload(&train);
    let mut looks = 0;
    let new = within(PATIENCE, || {
        assert_eq!(states(&train, &[1, 3]).expect("answers"), ["live", "live"], "the others stay live");
        looks += 1;
        train.processes().into_iter().find(|process| process.role == old.role && process.pid != old.pid)
    });
    assert!(new.is_some(), "{}", train.log());
    logged(&train, "works by the new config");
    train.wait_ready(PATIENCE);
    let others = |processes: Vec<Process>| -> Vec<Process> {
        processes.into_iter().filter(|process| process.role != old.role).collect()
    };
    assert_eq!(others(train.processes()), others(before));
    assert!(
        train.log().contains("filter=\"paper\"") || train.log().contains("filter=paper"),
        "{}",
        train.log()
    );
    println!("looked {looks} times meanwhile");
    ended(&mut train);
}

#[test]
fn a_config_that_is_wrong_changes_nothing_and_says_where() {
    let mut train = running("mistaken");
    let before = train.processes();
    let file = train.folder().join("train.toml");
    let sound = std::fs::read_to_string(&file).expect("the config");
    edit(&train, "raise_after_s = 2.0", "raise_after_s = \"two\"\nclear_afer_s = 4.0");
    reload(&train);
    let text = std::fs::read_to_string(&file).expect("the config");
    for key in ["raise_after_s", "clear_afer_s"] {
        let line = 1 + text.lines().position(|line| line.starts_with(key)).expect("just written");
        logged(&train, &format!("train.toml:{line}:"));
        assert!(train.log().contains(key), "{}", train.log());
    }
    // Keys that cannot change are named, and what could have changed with them does not.
    for (from, to, key) in [
        ("name = \"mistaken\"", "name = \"renamed\"", "`train.name`"),
        ("[[wagon]]\n[[wagon]]\n", "[[wagon]]\n", "`train.wagons`"),
        ("kind = \"simulate\"\nscenario = \"demo\"\nseed = 7", "kind = \"external\"", "`source.kind`"),
        ("[alerts]", "[instance]\nprefix = \"rgother_\"\n[alerts]", "`instance.prefix`"),
    ] {
        std::fs::write(&file, sound.replace("raise_after_s = 2.0", "raise_after_s = 3.0")).expect("written");
        edit(&train, from, to);
        reload(&train);
        logged(&train, key);
        assert!(train.log().contains("cannot change while the train runs"), "{}", train.log());
    }
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(train.processes(), before);
    // Who dies meanwhile comes back as it was, whatever the file says now.
    std::fs::write(&file, "nonsense").expect("written");
    let victim = train.process("estimator 1");
    victim.kill();
    let _ = train.successor(&victim);
    train.wait_ready(PATIENCE);
    assert!(train.is_up(), "{}", train.log());
    std::fs::write(&file, &sound).expect("written");
    reload(&train);
    logged(&train, "says nothing new");
    ended(&mut train);
}

/// Roles of the estimators that run now.
fn estimators(train: &TrainUnderTest) -> Vec<Process> {
    train.processes().into_iter().filter(|process| process.role.starts_with("estimator")).collect()
}

#[test]
fn signals_during_a_reload_do_no_harm_and_never_two_estimators_are_away_for_it() {
    let mut train = running("twice");
    let before = train.processes();
    edit(&train, "[alerts]", "[estimator]\nfilter = \"paper\"\n[alerts]");
    reload(&train);
    logged(&train, "starts again, by the new config");
    // While it is under way: the same once more, then another change.
    reload(&train);
    edit(&train, "filter = \"paper\"", "filter = \"imm\"");
    reload(&train);
    let mut fewest = usize::MAX;
    let done = within(PATIENCE, || {
        let now = estimators(&train);
        fewest = fewest.min(now.len());
        let renewed = now.len() == 3 && now.iter().all(|process| !before.contains(process));
        let filters = train.log().matches("imm").count();
        (renewed && filters >= 3).then_some(())
    });
    assert!(done.is_some(), "{:?}\n{}", train.processes(), train.log());
    assert!(fewest >= 2, "{fewest} estimators ran at the worst moment");
    train.wait_ready(PATIENCE);
    let others = |processes: Vec<Process>| -> Vec<Process> {
        processes.into_iter().filter(|process| !process.role.starts_with("estimator")).collect()
    };
    assert_eq!(others(train.processes()), others(before));
    // And an end in the middle of another reload is an end.
    edit(&train, "filter = \"imm\"", "filter = \"default\"");
    reload(&train);
    std::thread::sleep(Duration::from_millis(50));
    ended(&mut train);
}

#[test]
fn whoever_is_asked_twice_to_end_leaves_nothing_behind() {
    let mut train = running("impatient");
    // One that does not end by itself: in order, that takes five seconds.
    train.process("estimator 2").signal(Signal::STOP);
    let up = train.process("up");
    let asked = Instant::now();
    up.signal(Signal::TERM);
    std::thread::sleep(Duration::from_millis(300));
    assert!(train.is_up(), "it waits for the one that does not end");
    up.signal(Signal::TERM);
    let status = train.wait();
    println!("ended {:.2} s after the first signal: {status}", asked.elapsed().as_secs_f64());
    assert!(!status.success(), "a process had to be killed");
    assert!(asked.elapsed() < Duration::from_secs(5), "the second signal makes it quick");
    nothing_is_left(&train);
    // Where all of them end by themselves, twice is as once.
    train.start();
    train.wait_ready(PATIENCE);
    let up = train.process("up");
    up.signal(Signal::TERM);
    up.signal(Signal::TERM);
    let _ = train.wait();
    nothing_is_left(&train);
    assert!(!train.log().contains("panicked"), "{}", train.log());
}

#[test]
fn under_systemd_processes_follow_by_themselves_one_after_another() {
    let train = TrainUnderTest::new(program!(), &config("units"));
    let notify = train.folder().join("notify");
    let _socket = std::os::unix::net::UnixDatagram::bind(&notify).expect("a socket");
    let start = |words: &[&str]| {
        let log = std::fs::OpenOptions::new().create(true).append(true).open(train.folder().join("log"));
        let mut command = train.command(words);
        command.env("NOTIFY_SOCKET", &notify).stdout(std::process::Stdio::null()).stderr(log.expect("log"));
        command.spawn().expect("started")
    };
    let mut holder = start(&["hold"]);
    logged(&train, "channels exist");
    let mut estimators = [start(&["estimator", "--wagon", "1"]), start(&["estimator", "--wagon", "2"])];
    let started = |count: usize| {
        let seen = || (train.log().matches("estimator has started").count() >= count).then_some(());
        assert!(within(PATIENCE, seen).is_some(), "{}", train.log());
    };
    started(2);
    std::thread::sleep(Duration::from_millis(300));
    let hang_up = |child: &std::process::Child| {
        Process { pid: child.id().cast_signed(), role: String::new() }.signal(Signal::HUP);
    };
    // A threshold: nobody ends.
    edit(&train, "[alerts]", "[indicators.filter]\nnis_watch_high = 2.0\n[alerts]");
    estimators.iter().chain([&holder]).for_each(hang_up);
    let taken = within(PATIENCE, || (train.log().matches("is taken over").count() == 2).then_some(()));
    assert!(taken.is_some(), "{}", train.log());
    // A filter: both end, the second when the first is back.
    edit(&train, "[alerts]", "[estimator]\nfilter = \"paper\"\n[alerts]");
    estimators.iter().for_each(hang_up);
    let ended = |child: &mut std::process::Child| child.try_wait().ok().flatten();
    let first = within(PATIENCE, || estimators.iter_mut().position(|child| ended(child).is_some()));
    let first = first.unwrap_or_else(|| panic!("{}", train.log()));
    std::thread::sleep(Duration::from_millis(700));
    assert!(ended(&mut estimators[1 - first]).is_none(), "one at a time\n{}", train.log());
    let wagon = (first + 1).to_string();
    estimators[first] = start(&["estimator", "--wagon", &wagon]);
    let second = within(PATIENCE, || ended(&mut estimators[1 - first]));
    assert!(second.is_some_and(|status| status.success()), "{second:?}\n{}", train.log());
    assert!(ended(&mut estimators[first]).is_none(), "the first is back and stays");
    for child in estimators.iter_mut().chain([&mut holder]) {
        let pid = child.id().cast_signed();
        Process { pid, role: String::new() }.signal(Signal::TERM);
        assert!(within(PATIENCE, || child.try_wait().ok().flatten()).is_some());
    }
}
