//! A train's config: the defaults, and what each mistake is answered with.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use railgrip_settings::{MqttSource, Overrides, SettingsError, Source, Subjects, TrainSettings};
use std::path::{Path, PathBuf};

/// The default config as it stands in the repository.
fn default_file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml")
}

fn parse(text: &str) -> Result<TrainSettings, SettingsError> {
    TrainSettings::parse(&default_file(), text, &Overrides::default())
}

const SMALL: &str = "schema = 1\n[train]\nname = \"demo\"\nwagons = 8\nvehicle = \"vehicle.toml\"\n[source]\nkind = \"simulate\"\n";

fn refused(from: &str, to: &str) -> String {
    assert!(SMALL.contains(from), "the test looks for {from}");
    parse(&SMALL.replace(from, to)).expect_err("must be refused").to_string()
}

#[test]
fn the_built_in_default_is_the_default_file() {
    let file = TrainSettings::load(Some(&default_file()), &Overrides::default()).unwrap();
    assert_eq!(file.wagons.len(), 8);
    let nowhere = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(default_file()).unwrap();
    let built_in =
        TrainSettings::parse(&nowhere.path().join("config/railgrip.toml"), &text, &Overrides::default())
            .expect("without any file beside it the built-in vehicle serves");
    assert_eq!(built_in.wagons[7].vehicle, file.wagons[7].vehicle);
}

#[test]
fn what_the_default_file_spells_out_is_what_absent_keys_mean() {
    let spelled = TrainSettings::load(Some(&default_file()), &Overrides::default()).unwrap();
    let absent = parse(SMALL).unwrap();
    assert_eq!(format!("{spelled:?}"), format!("{absent:?}"));
}

#[test]
fn mistakes_are_answered_with_file_line_key_and_what_is_allowed() {
    let said = refused("wagons = 8", "wagons = 0");
    assert!(said.contains("railgrip.toml:4: `train.wagons` is 0 wagons, allowed is 1 to 200 wagons"));
    let said = refused("wagons = 8", "wagon = 8");
    assert!(said.contains("railgrip.toml:4:1: unknown field `wagon`"));
    let said = refused("\"demo\"", "\"a/b\"");
    assert!(said.contains(":3: `train.name`"));
    let said = refused("\"simulate\"", "\"simulte\"");
    assert!(said.contains(":7:8:") && said.contains("simulate"));
    let said = refused("\"vehicle.toml\"", "\"nowhere.toml\"");
    assert!(said.contains(":5: `train.vehicle`") && said.contains("nowhere.toml"));
    let said = refused("\"simulate\"\n", "\"simulate\"\nspeed = 0\n");
    assert!(said.contains(":8: `source.speed` is 0, allowed is 0.01 to 1000"));
    let said = refused("\"simulate\"\n", "\"simulate\"\nloop = true\n");
    assert!(said.contains(":8: `source.loop`"));
    let said = refused("\"simulate\"\n", "\"simulate\"\n[http]\nlisten = \"8080\"\n");
    assert!(said.contains(":9: `http.listen` is 8080"));
    let said = refused("\"simulate\"\n", "\"simulate\"\n[indicators.wsp]\nshare_act = 7\n");
    assert!(said.contains(":9: `indicators.wsp.share_act` is 7, allowed is 0 to 1"));
    let said = refused("\"simulate\"\n", "\"simulate\"\nscenario = \"nowhere\"\n");
    assert!(said.contains(":8: `source.scenario` is \"nowhere\""));
    let said = refused("\"simulate\"\n", "\"simulate\"\n[estimator]\nfilter = \"kalman\"\n");
    assert!(said.contains(":9: `estimator.filter` is \"kalman\"") && said.contains("default"));
    let said = refused("\"simulate\"\n", "\"simulate\"\n[estimator.rates]\npad_forget_s = -1\n");
    assert!(said.contains(":9: `estimator.rates.pad_forget_s`"));
    let said = refused("schema = 1", "schema = 2");
    assert!(said.contains(":1: `schema` is 2"));
}

#[test]
fn wagons_can_be_listed_with_their_own_vehicles() {
    let dir = tempfile::tempdir().unwrap();
    let coach = std::fs::read_to_string(default_file().with_file_name("vehicle.toml")).unwrap();
    std::fs::write(dir.path().join("coach.toml"), &coach).unwrap();
    std::fs::write(dir.path().join("heavy.toml"), coach.replace("40000.0", "90000.0")).unwrap();
    let text = SMALL
        .replace("wagons = 8\n", "")
        .replace("vehicle.toml", "coach.toml")
        .replace("[source]", "[[wagon]]\nname = \"leader\"\nvehicle = \"heavy.toml\"\n[[wagon]]\n[source]");
    let read = |text: &str| {
        TrainSettings::parse(&dir.path().join("train.toml"), text, &Overrides::default())
            .map_err(|error| error.to_string())
    };
    let train = read(&text).unwrap();
    let masses: Vec<f64> = train.wagons.iter().map(|wagon| wagon.vehicle.body.mass_kg).collect();
    assert_eq!(masses, [90000.0, 40000.0]);
    assert_eq!(train.wagon(1).unwrap().name, "leader");
    assert_eq!(train.wagon(2).unwrap().name, "wagon-2");
    assert!(train.wagon(0).is_none() && train.wagon(3).is_none());
    let twice = text.replace("[[wagon]]\n[source]", "[[wagon]]\nname = \"leader\"\n[source]");
    let said = read(&twice).unwrap_err();
    assert!(said.contains("`wagon.2.name`") && said.contains(":9:"), "{said}");
    let broken = read(&text.replace("coach.toml", "broken.toml")).unwrap_err();
    assert!(broken.contains("`train.vehicle`"), "{broken}");
}

#[test]
fn recordings_on_the_command_line_replace_the_source() {
    let recordings = default_file().with_file_name("recordings");
    let folder = tempfile::tempdir().unwrap();
    for case in ["a", "b", "c"] {
        let (case, fit) = (folder.path().join(case), folder.path().join(case).join("fit"));
        std::fs::create_dir_all(&fit).unwrap();
        std::fs::copy(recordings.join("vehicle.toml"), case.join("vehicle.toml")).unwrap();
        for run in ["wagon01.dry.parquet", "wagon02.wet.parquet", "wagon03.low.parquet"] {
            std::fs::copy(recordings.join(run), fit.join(run)).unwrap();
        }
    }
    let overrides = Overrides {
        runs: vec![format!("{}/*/fit", folder.path().display())],
        speed: Some(4.0),
        ..Overrides::default()
    };
    let train = TrainSettings::load(Some(&default_file()), &overrides).unwrap();
    let Source::Replay { runs, speed, repeat } = &train.source else { panic!("{:?}", train.source) };
    assert_eq!((train.wagons.len(), runs.len(), *speed, *repeat), (9, 9, 4.0, true));
    assert!(runs.iter().all(|run| run.vehicle_file.is_some()));

    let overrides = Overrides { runs: vec!["nowhere/*.csv".to_owned()], ..Overrides::default() };
    let said = TrainSettings::load(Some(&default_file()), &overrides).unwrap_err().to_string();
    assert!(said.contains("--runs nowhere/*.csv"), "{said}");
}

#[test]
fn the_replay_config_plays_the_recordings_beside_it() {
    let file = default_file().with_file_name("replay.toml");
    let train = TrainSettings::load(Some(&file), &Overrides::default()).unwrap();
    let names: Vec<&str> = train.wagons.iter().map(|wagon| wagon.name.as_str()).collect();
    assert_eq!(names, ["wagon01.dry", "wagon02.wet", "wagon03.low"]);
}

/// A filter that knows no couplers would take what they do to a wagon for its own brakes.
#[test]
fn a_filter_for_free_wagons_is_refused_where_they_are_coupled() {
    let of = |filter: &str| format!("{SMALL}[estimator]\nfilter = \"{filter}\"\n");
    let coupled = |text: &str| text.replace("[source]", "coupled = true\n[source]");
    for filter in ["paper", "rig", "imm"] {
        parse(&of(filter)).expect("free wagons");
        let said = parse(&coupled(&of(filter))).expect_err("must be refused").to_string();
        assert!(said.contains(&format!("`estimator.filter` is \"{filter}\"")), "{said}");
        assert!(said.contains("those that know couplers are \"default\""), "{said}");
        let two = SMALL.replace("wagons = 8", "wagons = 2");
        let own = format!("{two}[[wagon]]\n[[wagon]]\nfilter = \"{filter}\"\n");
        let said = parse(&coupled(&own)).expect_err("must be refused").to_string();
        assert!(said.contains("`wagon.2.filter`"), "{said}");
    }
    parse(&coupled(&of("default"))).expect("it knows couplers");
}

#[test]
fn a_train_is_judged_together_where_it_is_coupled() {
    let coupled = "vehicle = \"vehicle.toml\"\ncoupled = true\n";
    let given = parse(&SMALL.replace("vehicle = \"vehicle.toml\"\n", coupled)).unwrap();
    assert!(given.judged_together && !parse(SMALL).unwrap().judged_together);
    // Without the key the vehicle files say it; a recorded train always is.
    let folder = tempfile::tempdir().unwrap();
    let vehicle = std::fs::read_to_string(default_file().with_file_name("vehicle.toml")).unwrap();
    let file = folder.path().join("config.toml");
    for (running, expected) in
        [("", false), ("\n[train]\nfree = true\n", false), ("\n[train]\nfree = false\n", true)]
    {
        std::fs::write(folder.path().join("vehicle.toml"), format!("{vehicle}{running}")).unwrap();
        let settings = TrainSettings::parse(&file, SMALL, &Overrides::default()).unwrap();
        assert_eq!(settings.judged_together, expected, "{running:?}");
    }
    let at = folder.path().join("recorded");
    std::fs::create_dir_all(at.join("w01")).unwrap();
    std::fs::write(at.join("train.toml"), "[[wagon]]\nnumber = \"50 80 1\"\nfolder = \"w01\"\n").unwrap();
    std::fs::write(at.join("w01/vehicle.toml"), &vehicle).unwrap();
    std::fs::write(at.join("w01/run.csv"), "").unwrap();
    let overrides = Overrides { train: Some(at), ..Overrides::default() };
    let settings = TrainSettings::parse(&default_file(), SMALL, &overrides).unwrap();
    assert!(settings.judged_together);
    let number = settings.wagons[0].vehicle_number.as_ref().map(|number| number.written().to_owned());
    assert_eq!(
        (settings.name.as_str(), settings.wagons.len(), number.as_deref()),
        ("recorded", 1, Some("50 80 1"))
    );
    assert!(matches!(settings.source, Source::Replay { repeat: false, .. }));
}

#[test]
fn a_password_travels_to_a_broker_by_tls_or_not_at_all() {
    let broker = |more: &str| {
        let text = format!("\"mqtt\"\ntopic = \"a\"\nuser = \"u\"\npassword_file = \"p\"\n{more}");
        parse(&SMALL.replace("\"simulate\"\n", &text)).map(|settings| settings.source)
    };
    let far = "host = \"broker\"\n";
    let said = broker(far).unwrap_err().to_string();
    assert!(said.contains(":10: `source.password_file` is given") && said.contains("tls = true"), "{said}");
    for allowed in ["host = \"localhost\"\n", "host = \"broker\"\nallow_insecure = true\n"] {
        let Ok(Source::Mqtt(plain)) = broker(allowed) else { panic!("{allowed}") };
        assert_eq!((plain.port, plain.tls), (1883, None));
    }
    let Ok(Source::Mqtt(by_tls)) = broker(&format!("{far}tls = true\n")) else { panic!("a broker") };
    assert_eq!((by_tls.port, by_tls.tls.map(|tls| tls.ca_file)), (8883, Some(None)));
    for (more, key) in [
        (
            "ca_file = \"train.pem\"\n",
            ":12: `source.ca_file` is given, allowed is nothing without tls = true",
        ),
        ("tls = true\nca_file = \"nowhere.pem\"\n", ":13: `source.ca_file` is "),
    ] {
        let said = broker(&format!("{far}{more}")).unwrap_err().to_string();
        assert!(said.contains(key), "{said}");
    }
    let said = refused("\"simulate\"\n", "\"simulate\"\ntls = true\n");
    assert!(said.contains(":8: `source.tls`"), "{said}");
}

const TOPICS: &str = "schema = 1\n[train]\nname = \"m\"\nwagons = 2\nvehicle = \"vehicle.toml\"\n[source]\nkind = \"mqtt\"\nhost = \"localhost\"\ntopics = [\n  { topic = \"train/{wagon}/bogie1/{name}\" },\n  { topic = \"loco/gps\", name = \"gps\" },\n]\n[mapping]\nomega_f_rad_s = { from = \"axle1\", unit = \"rpm\" }\nv_m_s = { from = \"gps.speed\", unit = \"km/h\" }\n";

/// Topics with a value each: what they mean is settled, and what cannot be is refused with its line, before anything runs.
#[test]
fn topics_of_single_values_are_checked() {
    let settings = parse(TOPICS).unwrap();
    let Source::Mqtt(MqttSource { subjects: Subjects::Values(topics), .. }) = &settings.source else {
        panic!("{:?}", settings.source)
    };
    assert_eq!((topics.wagons.len(), topics.hold_s), (2, 0.5));
    assert_eq!(topics.wagons[1].sample_on, "axle1");
    for (from, to, words) in [
        (
            "{wagon}/bogie1",
            "#",
            ":10: `source.topics.1.topic` is \"train/#/{name}\", allowed is a topic such as",
        ),
        ("name = \"gps\"", "wagon = 3", ":11: `source.topics.2.wagon` is 3, allowed is 1 to 2"),
        ("gps\", name", "{wagon}\", wagon = 1, name", ":11: `source.topics.2.wagon` is given"),
        (
            "{name}",
            "speed\", name = \"speed",
            ":14: `mapping.omega_f_rad_s.from` is \"axle1\", which no topic brings to wagon 1",
        ),
        ("topics = [", "sample_on = \"axle9\"\ntopics = [", ":9: `source.sample_on` is \"axle9\""),
        (
            "topics = [",
            "topic = \"a\"\ntopics = [",
            ":9: `source.topic` is given, allowed is nothing beside `topics`",
        ),
        ("name = \"gps\"", "nam = \"gps\"", "unknown field `nam`"),
    ] {
        assert!(TOPICS.contains(from), "{from}");
        let said = parse(&TOPICS.replacen(from, to, 1)).expect_err(to).to_string();
        assert!(said.contains(words), "{to}: {said}");
    }
}
