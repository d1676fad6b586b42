//! Microphones live: what is recorded is heard by a process each, bad audio has a name, and a killed listener comes back.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::path::Path;
use std::time::Duration;

use railgrip_acoustics::wav;
use railgrip_tests::{TrainUnderTest, program, within};
use serde_json::Value;

const SECOND: Duration = Duration::from_secs(1);

/// Ten seconds of rolling noise of the command line's own making.
fn recorded(folder: &Path, condition: &str) -> Vec<f32> {
    let file = folder.join(format!("{condition}.wav"));
    let output = std::process::Command::new(program!())
        .args(["acoustics", "synthesise", "--rig", "track", "--speed", "25", "--seconds", "10"])
        .args(["--condition", condition, "--out"])
        .arg(&file)
        .output()
        .expect("synthesise");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    wav::read(&file).expect("a recording").samples
}

/// A train whose wagons each hear one of `files`.
fn config(folder: &Path, files: &[&str]) -> String {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().expect("the repository");
    let mut text = format!(
        "schema = 1\n[train]\nname = \"ears\"\nwagons = {}\nvehicle = \"{}\"\n[source]\nkind = \"simulate\"\n\
         scenario = \"{}\"\n",
        files.len(),
        repository.join("config/vehicle.toml").display(),
        repository.join("config/scenarios/demo.toml").display()
    );
    for (number, file) in (1..).zip(files) {
        let file = folder.join(file);
        text.push_str(&format!("[[microphone]]\nwagon = {number}\nrecordings = [\"{}\"]\n", file.display()));
    }
    text
}

fn acoustic(train: &TrainUnderTest, wagon: usize) -> Option<Value> {
    let view = train.http()?.json(&format!("/api/v1/wagons/{wagon}"))?;
    Some(view["acoustic"].clone())
}

#[test]
fn every_microphone_is_heard_or_named() {
    let folder = tempfile::Builder::new().prefix("rgears").tempdir_in("/tmp").expect("folder");
    let path = folder.path();
    let dry = recorded(path, "dry");
    let wet = recorded(path, "wet");
    assert_ne!(dry, wet);
    let loud: Vec<f32> = dry.iter().map(|x| (60.0 * x).clamp(-1.0, 1.0)).collect();
    wav::write(&path.join("loud.wav"), 22_050, &loud).expect("written");
    wav::write(&path.join("silent.wav"), 22_050, &vec![0.0; 22_050]).expect("written");
    wav::write(&path.join("fast.wav"), 48_000, &dry).expect("written");
    let files = ["dry.wav", "wet.wav", "loud.wav", "silent.wav", "fast.wav"];
    let expected = ["heard", "heard", "clipped", "silent_microphone", "wrong_sample_rate"];

    let mut train = TrainUnderTest::new(program!(), &config(path, &files));
    train.start();
    for (number, state) in (1..).zip(expected) {
        let found = within(40 * SECOND, || acoustic(&train, number).filter(|view| view["state"] == state));
        let found = found
            .unwrap_or_else(|| panic!("wagon {number}: {:?}\n{}", acoustic(&train, number), train.log()));
        println!("{}: {found}", files[number - 1]);
        assert_eq!(found["wet_probability"].is_null(), state != "heard", "{found}");
        assert_eq!(found["condition"].is_null(), state != "heard", "{found}");
        if let Some(wet) = found["wet_probability"].as_f64() {
            assert!((0.0..=1.0).contains(&wet));
        }
    }
    let listener = train.process("listener 1");
    listener.kill();
    let successor = train.successor(&listener);
    println!("{listener:?} was killed, {successor:?} took over");
    let again = within(20 * SECOND, || {
        acoustic(&train, 1)
            .filter(|view| view["state"] == "heard" && view["age_s"].as_f64().unwrap_or(9.0) < 2.0)
    });
    assert!(again.is_some(), "{}", train.log());
}

#[test]
fn the_command_line_trains_classifies_and_refuses() {
    let folder = tempfile::Builder::new().prefix("rgears").tempdir_in("/tmp").expect("folder");
    let path = folder.path();
    let wet = recorded(path, "wet");
    assert_eq!(wet.len(), 10 * 22_050);
    let run = |words: &[&str]| {
        let output =
            std::process::Command::new(program!()).arg("acoustics").args(words).current_dir(path).output();
        let output = output.expect("started");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    for name in ["one", "two"] {
        let (code, said, complaint) = run(&[
            "train",
            "--out",
            name,
            "--clips",
            "120",
            "--epochs",
            "2",
            "--seed",
            "4",
            "--test-clips",
            "10",
        ]);
        println!("{said}{complaint}");
        assert_eq!(code, Some(0));
        assert!(
            said.contains("seed 4")
                && said.contains("a rig never heard")
                && complaint.contains("pass   2 of 2")
        );
    }
    let [one, two] = ["one", "two"].map(|name| std::fs::read(path.join(name)).expect("a model"));
    assert_eq!(one, two, "the same seed makes the same model");

    let (code, _, _) = run(&["classify", "wet.wav", "--model", "one", "--out", "heard.csv"]);
    assert_eq!(code, Some(0));
    let text = std::fs::read_to_string(path.join("heard.csv")).expect("CSV");
    assert!(text.starts_with("file,t_s,state,wet_probability,condition\nwet.wav,0,"), "{text}");
    assert_eq!(text.lines().count(), 11);

    let mut damaged = one;
    *damaged.last_mut().expect("bytes") ^= 1;
    std::fs::write(path.join("damaged"), &damaged).expect("written");
    for (words, expected) in [
        (vec!["classify", "wet.wav", "--model", "damaged"], "checksum"),
        (vec!["classify", "wet.wav", "--model", "nowhere"], "nowhere"),
        (vec!["classify", "heard.csv"], "WAV"),
        (vec!["classify", "wet.wav", "--hysteresis", "0.7"], "--hysteresis"),
        (vec!["train", "--out", "x", "--clips", "5"], "100"),
        (vec!["train", "--out", "x", "--recordings", "."], "dry"),
        (vec!["synthesise", "--out", "x.wav", "--rig", "tram"], "bogie, roller, track, traction"),
        (vec!["synthesise", "--out", "x.wav", "--condition", "icy"], "dry or wet"),
    ] {
        let (code, _, complaint) = run(&words);
        assert_eq!(code, Some(2), "{words:?}: {complaint}");
        assert!(complaint.contains(expected), "{words:?}: {complaint}");
    }
}
