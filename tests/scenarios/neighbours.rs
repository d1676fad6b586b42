//! What shares a machine with a train: other trains, second processes of one kind, files of other people, a taken port, little
//! memory. None is harmed, and whoever cannot run says why at once.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use railgrip_requirements::PRIVATE_MOUNT;
use railgrip_tests::{TrainUnderTest, program, within};

railgrip_requirements::tests! {
    a_prefix_belongs_to_one_train: [],
    a_short_prefix_deletes_nothing_of_others: [],
    a_second_process_of_a_role_is_refused: [],
    a_recording_is_not_written_over: [],
    a_taken_port_ends_up_at_once: [],
    a_misspelt_log_level_is_refused: [],
    too_little_shared_memory_is_said_before_anything_starts: [PRIVATE_MOUNT],
}

const PATIENCE: Duration = Duration::from_secs(20);

fn config(name: &str, more: &str) -> String {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml");
    format!(
        "schema = 1\n[train]\nname = \"{name}\"\nwagons = 2\nvehicle = \"{vehicle}\"\n[source]\nkind = \"simulate\"\n\
         scenario = \"demo\"\n[logging]\nformat = \"text\"\n{more}"
    )
}

/// What a command said on its standard error, and its exit code.
fn said(output: &Output) -> (Option<i32>, String) {
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    println!("{words}");
    (output.status.code(), words)
}

fn a_prefix_belongs_to_one_train() {
    let prefix = format!("[instance]\nprefix = \"n{}_\"\n", std::process::id());
    let mut first = TrainUnderTest::new(program!(), &config("first", &prefix));
    first.start();
    first.wait_ready(PATIENCE);
    let before = first.shared_memory();
    let second = TrainUnderTest::new(program!(), &config("second", &prefix));
    let (code, words) = said(&second.run(&["up", "--for", "30"]));
    assert_eq!(code, Some(2), "{words}");
    assert!(words.contains("belongs to another running train"), "{words}");
    let lost: Vec<&String> =
        before.iter().filter(|name| !Path::new("/dev/shm").join(name).exists()).collect();
    assert!(!before.is_empty() && lost.is_empty(), "{lost:?}");
    first.wait_ready(Duration::from_secs(1));
    assert!(first.stop().success());
}

fn a_short_prefix_deletes_nothing_of_others() {
    // The first letter of what the short prefix would sweep away, were it only a beginning.
    let foreign = Path::new("/dev/shm").join(format!("q-of-somebody-else-{}", std::process::id()));
    std::fs::write(&foreign, "mine").expect("write");
    let mut train = TrainUnderTest::new(program!(), &config("short", "[instance]\nprefix = \"q\"\n"));
    train.start_with(&["--for", "2"]);
    let status = train.wait();
    let kept = std::fs::read_to_string(&foreign);
    let _ = std::fs::remove_file(&foreign);
    assert!(status.success(), "{}", train.log());
    assert_eq!(kept.ok().as_deref(), Some("mine"));
}

fn a_second_process_of_a_role_is_refused() {
    let mut train = TrainUnderTest::new(program!(), &config("roles", ""));
    train.start();
    train.wait_ready(PATIENCE);
    for words in [&["estimator", "--wagon", "1"][..], &["ingest"]] {
        let (code, said) = said(&train.run(words));
        assert_eq!(code, Some(1), "{said}");
        assert!(said.contains("already (it keeps") && said.contains(words[0]), "{said}");
    }
    train.wait_ready(Duration::from_secs(1));
    assert!(train.stop().success());
}

fn a_recording_is_not_written_over() {
    let mut train = TrainUnderTest::new(program!(), &config("kept", ""));
    train.start();
    train.wait_ready(PATIENCE);
    let out = train.folder().join("out");
    let out_words = out.display().to_string();
    let record = ["record", "--out", out_words.as_str(), "--for", "1"];
    let (code, words) = said(&train.run(&record));
    assert_eq!(code, Some(0), "{words}");
    let before = std::fs::read(out.join("wagon-1.csv")).expect("a recording");
    let (code, words) = said(&train.run(&record));
    assert_eq!(code, Some(2), "{words}");
    assert!(words.contains("exists; recordings are not written over"), "{words}");
    assert_eq!(std::fs::read(out.join("wagon-1.csv")).ok(), Some(before));
    assert!(train.stop().success());
}

fn a_taken_port_ends_up_at_once() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = taken.local_addr().expect("its address").to_string();
    let folder = tempfile::Builder::new().prefix("rg").tempdir_in("/tmp").expect("folder");
    let file = folder.path().join("train.toml");
    std::fs::write(&file, config("port", "")).expect("write");
    let mut up = Command::new(program!());
    up.arg("up").arg("--config").arg(&file).arg("--instance").arg(folder.path().join("i"));
    let started = Instant::now();
    let (code, words) = said(&up.args(["--listen", &address]).output().expect("start"));
    assert_eq!(code, Some(1), "{words}");
    assert!(words.contains(&address) && words.contains("--listen"), "{words}");
    assert!(started.elapsed() < Duration::from_secs(5), "{:?}", started.elapsed());
}

fn a_misspelt_log_level_is_refused() {
    let text = config("log", "").replace("[logging]\n", "[logging]\nlevel = \"inof\"\n");
    let train = TrainUnderTest::new(program!(), &text);
    let (code, words) = said(&train.run(&["up", "--for", "1"]));
    assert_eq!(code, Some(2), "{words}");
    assert!(words.contains("\"inof\" is no level"), "{words}");
}

fn too_little_shared_memory_is_said_before_anything_starts() {
    let train = TrainUnderTest::new(program!(), &config("small", ""));
    let up = train.command(&["up", "--for", "20"]);
    let words: Vec<String> = std::iter::once(up.get_program())
        .chain(up.get_args())
        .map(|word| format!("'{}'", word.to_string_lossy()))
        .collect();
    let script = format!("mount -t tmpfs -o size=4m none /dev/shm && exec {}", words.join(" "));
    let flags = ["-rm", "-m"];
    let output = flags.iter().find_map(|flags| {
        let output = Command::new(PRIVATE_MOUNT.path()).args([*flags, "sh", "-c", &script]).output().ok()?;
        let refused = String::from_utf8_lossy(&output.stderr).contains("unshare failed");
        (!refused).then_some(output)
    });
    let (code, words) = said(&output.expect("a namespace"));
    assert_eq!(code, Some(2), "{words}");
    assert!(words.contains("/dev/shm has 4 MB left") && words.contains("--shm-size"), "{words}");
    let gone = within(Duration::from_secs(5), || train.processes().is_empty().then_some(()));
    assert!(gone.is_some(), "{:?}", train.processes());
}
