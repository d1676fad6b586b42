//! All mistakes of a config at once: none hides another, and none is made up.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use railgrip_settings::{Overrides, mistakes};
use std::path::{Path, PathBuf};

/// A config with a key of every kind in it.
const SOUND: &str = r#"schema = 1

[train]
name = "t"
wagons = 2
vehicle = "vehicle.toml"

[[wagon]]
number = "51"
turned = true

[[wagon]]
name = "last"
filter = "default"

[[microphone]]
wagon = 2
noise_db = -20.0

[source]
kind = "simulate"
scenario = "demo"
seed = 1
speed = 1.0

[mapping]
v_m_s = { from = "v", unit = "km/h" }
omega_f_rad_s = { from = ["a", "b"], combine = "mean" }

[estimator]
filter = "default"

[estimator.rates]
pad_forget_s = 500.0

[estimator.priors]
pad_common = 0.1

[indicators.wsp]
share_watch = 0.2

[http]
listen = "127.0.0.1:8080"
refresh_ms = 150.0
hosts = ["depot"]

[http.limits]
burst = 200.0
proxies = ["10.0.0.1"]

[alerts]
group_least = 3

[[receiver]]
kind = "webhook"
url = "http://localhost/a"

[[receiver]]
kind = "mqtt"
host = "localhost"
port = 1883

[history]
enabled = true
flush_s = 30.0

[logging]
format = "auto"
"#;

fn config() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/own.toml")
}

fn said(text: &str) -> Vec<String> {
    mistakes(&config(), text, &Overrides::default()).iter().map(ToString::to_string).collect()
}

/// The lines that are blamed, counted from 1.
fn lines(text: &str) -> Vec<usize> {
    let found = mistakes(&config(), text, &Overrides::default());
    let of = |error: &railgrip_settings::SettingsError| error.line().unwrap_or(0);
    found.iter().map(of).collect()
}

/// Numbers of the lines with a key, counted from 0, and the text with other values in some of them.
fn keys() -> Vec<usize> {
    let with = |(number, line): (usize, &str)| line.contains(" = ").then_some(number);
    SOUND.lines().enumerate().filter_map(with).collect()
}

fn with(value: &str, at: &[usize]) -> String {
    let line = |(number, line): (usize, &str)| match line.split_once(" = ") {
        Some((key, _)) if at.contains(&number) => format!("{key} = {value}\n"),
        _ => format!("{line}\n"),
    };
    SOUND.lines().enumerate().map(line).collect()
}

#[test]
fn the_sound_config_has_no_mistake() {
    assert_eq!(said(SOUND), Vec::<String>::new());
}

#[test]
fn a_value_of_the_wrong_type_is_one_mistake_and_no_other() {
    for at in keys() {
        let text = with("[[1979-05-27]]", &[at]);
        assert_eq!(lines(&text), [at + 1], "line {}: {:#?}", at + 1, said(&text));
    }
}

#[test]
fn of_two_wrong_values_both_are_told_wherever_they_stand() {
    let keys = keys();
    for (index, one) in keys.iter().enumerate() {
        for other in &keys[index + 1..] {
            let text = with("[[1979-05-27]]", &[*one, *other]);
            assert_eq!(lines(&text), [*one + 1, *other + 1], "{:#?}", said(&text));
        }
    }
}

#[test]
fn all_values_wrong_are_all_told() {
    let keys = keys();
    let text = with("1979-05-27", &keys);
    let all: Vec<usize> = keys.iter().map(|at| at + 1).collect();
    assert_eq!(lines(&text), all, "{:#?}", said(&text));
}

#[test]
fn what_is_no_toml_is_one_mistake_a_line() {
    for at in keys() {
        let text = with("= ]", &[at]);
        assert_eq!(lines(&text), [at + 1], "line {}: {:#?}", at + 1, said(&text));
    }
}

#[test]
fn behind_a_missing_or_wrong_required_key_the_rest_is_told() {
    let wrong = SOUND
        .replace("name = \"t\"\n", "")
        .replace("kind = \"simulate\"", "kind = 7")
        .replace("refresh_ms = 150.0", "refresh_ms = 1.0")
        .replace("flush_s = 30.0", "flush_s = -1.0")
        .replace("url = \"http://localhost/a\"", "url = \"depot\"")
        .replace("host = \"localhost\"\n", "")
        .replace("pad_forget_s = 500.0", "pad_forget_s = -1.0")
        .replace("pad_common = 0.1", "pad_common = 7.0")
        .replace("share_watch = 0.2", "share_watch = 1.5")
        .replace("unit = \"km/h\"", "unit = \"furlong\", sign = 3.0")
        .replace("format = \"auto\"", "format = \"xml\"");
    let said = said(&wrong);
    for words in [
        "missing field `name`",
        "own.toml:20:",
        "`http.refresh_ms` is 1",
        "`history.flush_s` is -1",
        "`receiver.1.url`",
        "`receiver.2.host` is absent",
        "`estimator.rates.pad_forget_s` is -1",
        "`estimator.priors.pad_common` is 7",
        "`indicators.wsp.share_watch` is 1.5",
        "`mapping.v_m_s.unit` is \"furlong\"",
        "`mapping.v_m_s.sign` is 3",
        "unknown variant `xml`",
    ] {
        assert_eq!(said.iter().filter(|said| said.contains(words)).count(), 1, "{words}: {said:#?}");
    }
    assert_eq!(said.len(), 12, "{said:#?}");
}

#[test]
fn a_file_that_is_wrong_is_told_with_the_key_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.toml");
    std::fs::write(folder.path().join("v.toml"), "schema = 1\nname = 7\n").unwrap();
    std::fs::write(folder.path().join("s.toml"), "what = 7\n").unwrap();
    std::fs::write(folder.path().join("d.dbc"), "BO_ what").unwrap();
    let base = "schema = 1\n[train]\nname = \"t\"\nwagons = 1\nvehicle = \"v.toml\"\n[http]\nrefresh_ms = 1.0\n[source]\n";
    for (source, keys) in [
        ("kind = \"simulate\"\nscenario = \"s.toml\"\n", ["`source.scenario`", "s.toml"]),
        ("kind = \"can\"\ninterface = \"can0\"\ndatabase = \"d.dbc\"\n", ["`source.database`", "d.dbc"]),
        ("kind = \"trdp\"\ndatabase = \"gone.xml\"\n", ["`source.database`", "gone.xml"]),
        ("kind = \"replay\"\nruns = [\"gone/*\"]\n", ["`source.runs`", "gone"]),
    ] {
        let found = mistakes(&file, &format!("{base}{source}"), &Overrides::default());
        let said: Vec<String> = found.iter().map(ToString::to_string).collect();
        let all = said.join("\n");
        for words in keys.into_iter().chain(["`train.vehicle`", "v.toml", "`http.refresh_ms`"]) {
            assert!(all.contains(words), "{words}: {said:#?}");
        }
        assert_eq!(said.len(), 3, "{said:#?}");
    }
}
