//! Where the samples of a train come from.

use crate::SettingsError;
use crate::consist::RecordedTrain;
use crate::fieldbus::{self, CanKeys, CanSource, MessageKeys, Several, TrdpSource};
use crate::overrides::Overrides;
use crate::place::{ConfigText, folder};
use crate::plant::RigProgramme;
use crate::receivers::{BROKER_IN_THE_CLEAR, BrokerTls, is_this_machine};
use crate::runs::{self, ReplayRun};
use crate::topics::{self, TopicKeys, TopicTable, Topics};
use railgrip_recording::Mapping;
use railgrip_simulation::Scenario;
use serde::{Deserialize, Serialize};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

/// The scenario that the default config names.
const DEFAULT_SCENARIO: &str = include_str!("../../../config/scenarios/demo.toml");
/// Its name.
const DEFAULT_SCENARIO_NAME: &str = "demo";
/// Where scenarios with a name lie, seen from the config.
const SCENARIO_FOLDER: &str = "scenarios";
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SourceTable {
    /// Where samples come from; required.
    pub kind: SourceKind,
    /// simulate: name of a scenario in `scenarios/`, or a file; without it `demo`.
    pub scenario: Option<String>,
    /// rig: the published test, for example `schwarz-wsp` or `zhao-water-2`.
    pub programme: Option<String>,
    /// simulate, rig: seed of everything random; without it 1.
    pub seed: Option<u64>,
    /// simulate: samples a second, Hz; without it that of the vehicle's sensors.
    pub sample_rate_hz: Option<f64>,
    /// replay: recordings, folders of them or globs, one recording a wagon.
    pub runs: Option<Vec<String>>,
    /// simulate, rig, replay, can with `file`: simulated or recorded seconds in a second; without it 1.
    pub speed: Option<f64>,
    /// replay, rig, can with `file`: begin again at the end; without it true, of a log of frames false.
    #[serde(rename = "loop")]
    pub repeat: Option<bool>,
    /// tcp, udp, trdp: ADDRESS:PORT on which samples arrive.
    pub listen: Option<String>,
    /// mqtt: name or address of the broker.
    pub host: Option<String>,
    /// mqtt: port of the broker; without it 1883, by TLS 8883.
    pub port: Option<u16>,
    /// mqtt: filter of the topics with samples.
    pub topic: Option<String>,
    /// mqtt: topics that carry a value each, in place of `topic`.
    pub topics: Option<Vec<TopicTable>>,
    /// mqtt: name under which the broker knows us; without it `railgrip-ingest`.
    pub client_id: Option<String>,
    /// mqtt: user, where the broker asks for one.
    pub user: Option<String>,
    /// mqtt: file with the password, read at every connection.
    pub password_file: Option<String>,
    /// mqtt: the broker is reached by TLS; without it false.
    pub tls: Option<bool>,
    /// mqtt: who may have signed the broker's certificate (PEM); without it the public authorities.
    pub ca_file: Option<String>,
    /// mqtt: a password may travel without TLS beyond this machine; without it false.
    pub allow_insecure: Option<bool>,
    /// can: name of an interface, or a list with one a wagon.
    pub interface: Option<Several>,
    /// can: a log in the form of `candump -L` in place of the interfaces.
    pub file: Option<String>,
    /// can: the DBC file; trdp: the XML file of the device.
    pub database: Option<String>,
    /// trdp: addresses of the senders, one a wagon; without them names tell the wagons apart.
    pub senders: Option<Vec<String>>,
    /// trdp: multicast groups to join.
    pub groups: Option<Vec<String>>,
    /// can, trdp: the message that makes a row; mqtt with `topics`: the input; without it that of the first wheelset's speed.
    pub sample_on: Option<String>,
    /// can, trdp, mqtt with `topics`: a value counts for so long after its message, ms; without it 500.
    pub hold_ms: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum SourceKind {
    Simulate,
    Rig,
    Replay,
    Stdin,
    Tcp,
    Udp,
    Mqtt,
    Can,
    Trdp,
    External,
}

/// Where samples come from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// The simulated train.
    Simulate {
        /// What the train does.
        scenario: Box<Scenario>,
        /// Seed of everything random.
        seed: u64,
        /// Samples per second; that of each vehicle's sensors if absent.
        sample_rate_hz: Option<f64>,
        /// Simulated seconds in a second.
        speed: f64,
    },
    /// Simulated rigs under a published test, each with a seed of its own.
    Rig {
        /// Which test.
        programme: RigProgramme,
        /// Seed of everything random; that of wagon `n` is larger by `n − 1`.
        seed: u64,
        /// Simulated seconds in a second.
        speed: f64,
        /// Begin again at the end.
        repeat: bool,
    },
    /// Recordings, one a wagon.
    Replay {
        /// In the order of the wagons.
        runs: Vec<ReplayRun>,
        /// Recorded seconds in a second.
        speed: f64,
        /// Begin again at the end.
        repeat: bool,
    },
    /// One JSON object a line on the standard input.
    Stdin,
    /// The same from whoever connects to this address.
    Tcp(SocketAddr),
    /// The same in datagrams to this address.
    Udp(SocketAddr),
    /// The same in messages of an MQTT broker.
    Mqtt(MqttSource),
    /// Frames of CAN buses, or of a log of them.
    Can(CanSource),
    /// Process data of a train network (IEC 61375-2-3).
    Trdp(TrdpSource),
    /// Other programs publish on the channels of the samples themselves; there is no ingest.
    External,
}

/// What the messages of a broker are.
#[derive(Debug, Clone, PartialEq)]
pub enum Subjects {
    /// Whole samples, under topics of this filter.
    Samples(String),
    /// Values, each under a topic of its own.
    Values(Topics),
}

/// A broker that hands out samples.
#[derive(Debug, Clone, PartialEq)]
pub struct MqttSource {
    /// Name or address of the broker.
    pub host: String,
    /// Its port.
    pub port: u16,
    /// What is asked of it.
    pub subjects: Subjects,
    /// Name under which we are known there.
    pub client_id: String,
    /// User, where the broker asks for one.
    pub user: Option<String>,
    /// File with the password, read at every connection.
    pub password_file: Option<PathBuf>,
    /// TLS, where the broker is reached by it.
    pub tls: Option<BrokerTls>,
}

/// Settles where samples come from.
pub(crate) fn source(
    at: &ConfigText<'_>,
    table: &SourceTable,
    overrides: &Overrides,
    recorded: Option<&RecordedTrain>,
) -> Result<Source, SettingsError> {
    let speed = match overrides.speed {
        Some(speed) if (0.01..=1000.0).contains(&speed) => speed,
        Some(speed) => {
            let problem = "allowed is 0.01 to 1000".to_owned();
            return Err(SettingsError::Option { option: "--speed", value: speed.to_string(), problem });
        }
        None => at.number("source.speed", table.speed.unwrap_or(1.0), 0.01..=1000.0),
    };
    if let Some(train) = recorded {
        return Ok(Source::Replay { runs: train.runs(), speed, repeat: false });
    }
    if !overrides.runs.is_empty() {
        let runs = runs::find(&overrides.runs, Path::new("")).map_err(|problem| SettingsError::Option {
            option: "--runs",
            value: overrides.runs.join(" "),
            problem,
        })?;
        return Ok(Source::Replay { runs, speed, repeat: table.repeat.unwrap_or(true) });
    }
    // Of a kind that cannot be read nobody knows what belongs to it.
    if at.is_blamed("source.kind") {
        return Ok(Source::External);
    }
    check_keys_of_kind(at, table);
    match table.kind {
        SourceKind::Stdin => Ok(Source::Stdin),
        SourceKind::Tcp => Ok(Source::Tcp(listen(at, table)?)),
        SourceKind::Udp => Ok(Source::Udp(listen(at, table)?)),
        SourceKind::Mqtt => Ok(Source::Mqtt(broker(at, table)?)),
        SourceKind::Can => {
            let (interface, file) = (table.interface.as_ref(), table.file.as_deref());
            let keys = CanKeys { interface, file, speed: table.speed, repeat: table.repeat };
            Ok(Source::Can(fieldbus::can(at, &keys, speed, &message_keys(table))?))
        }
        SourceKind::Trdp => {
            let given = table.listen.is_some().then(|| listen(at, table)).transpose();
            let listen = at.or(given, None);
            let (groups, senders) = (table.groups.as_deref(), table.senders.as_deref());
            let (groups, senders) = (groups.unwrap_or_default(), senders.unwrap_or_default());
            Ok(Source::Trdp(fieldbus::trdp(at, listen, groups, senders, &message_keys(table))?))
        }
        SourceKind::External => Ok(Source::External),
        SourceKind::Simulate => {
            if let Some(rate) = table.sample_rate_hz {
                at.number("source.sample_rate_hz", rate, 10.0..=2000.0);
            }
            Ok(Source::Simulate {
                scenario: Box::new(scenario(at, table.scenario.as_deref().unwrap_or(DEFAULT_SCENARIO_NAME))?),
                seed: table.seed.unwrap_or(1),
                sample_rate_hz: table.sample_rate_hz,
                speed,
            })
        }
        SourceKind::Rig => {
            let given = table.programme.as_deref().unwrap_or_default();
            let programme = RigProgramme::from_name(given)
                .ok_or_else(|| at.refuse("source.programme", format!("{given:?}"), RigProgramme::NAMES))?;
            let (seed, repeat) = (table.seed.unwrap_or(1), table.repeat.unwrap_or(true));
            Ok(Source::Rig { programme, seed, speed, repeat })
        }
        SourceKind::Replay => {
            let patterns = table.runs.clone().unwrap_or_default();
            if patterns.is_empty() {
                return Err(at.refuse("source.runs", "absent", "recordings, folders of them, or globs"));
            }
            let runs = runs::find(&patterns, &folder(at.file))
                .map_err(|problem| at.refuse("source.runs", problem, "what finds recordings"))?;
            Ok(Source::Replay { runs, speed, repeat: table.repeat.unwrap_or(true) })
        }
    }
}

fn message_keys(table: &SourceTable) -> MessageKeys<'_> {
    let (database, sample_on) = (table.database.as_deref(), table.sample_on.as_deref());
    MessageKeys { database, sample_on, hold_ms: table.hold_ms }
}

/// Makes the plan of a source that speaks in messages, once it is known how many wheelsets each wagon has.
pub(crate) fn resolve(
    at: &ConfigText<'_>,
    source: &mut Source,
    mapping: &Mapping,
    wheelsets: &[usize],
) -> Result<(), SettingsError> {
    let (lanes, messages) = match source {
        Source::Can(can) => (("source.interface", can.interfaces.len()), &mut can.messages),
        Source::Trdp(trdp) => (("source.senders", trdp.senders.len()), &mut trdp.messages),
        Source::Mqtt(MqttSource { subjects: Subjects::Values(values), .. }) => {
            return topics::resolve(at, values, mapping, wheelsets);
        }
        _ => return Ok(()),
    };
    fieldbus::resolve(at, lanes, messages, mapping, wheelsets)
}

/// The address that others send to.
fn listen(at: &ConfigText<'_>, table: &SourceTable) -> Result<SocketAddr, SettingsError> {
    let given = table.listen.as_deref().unwrap_or_default();
    let allowed = "ADDRESS:PORT, for example 127.0.0.1:9009";
    given.parse().map_err(|_| at.refuse("source.listen", format!("{given:?}"), allowed))
}

fn broker(at: &ConfigText<'_>, table: &SourceTable) -> Result<MqttSource, SettingsError> {
    let given = |key: &str, value: &Option<String>, allowed: &str| match value.as_deref() {
        Some(text) if !text.is_empty() && text.len() <= 256 => Ok(text.to_owned()),
        Some(text) => Err(at.refuse(key, format!("{text:?}"), allowed)),
        None => Err(at.refuse(key, "absent", allowed)),
    };
    let given =
        |key: &str, value: &Option<String>, allowed: &str| at.or(given(key, value, allowed), String::new());
    let host = given("source.host", &table.host, "name or address of the broker");
    let given_tls = BrokerTls::of(at, "source", table.tls.unwrap_or(false), table.ca_file.as_deref());
    let tls = at.or(given_tls, Some(BrokerTls::default()));
    let clear = tls.is_none() && !is_this_machine(&host);
    let unsure = ["host", "tls", "allow_insecure"].iter().any(|key| at.is_blamed(&format!("source.{key}")));
    if table.password_file.is_some() && clear && !unsure && !table.allow_insecure.unwrap_or(false) {
        at.note(at.refuse("source.password_file", "given", BROKER_IN_THE_CLEAR));
    }
    let subjects = match &table.topics {
        Some(_) if table.topic.is_some() => {
            return Err(at.refuse("source.topic", "given", "nothing beside `topics`"));
        }
        Some(topics) => {
            let (sample_on, hold_ms) = (table.sample_on.as_deref(), table.hold_ms);
            Subjects::Values(topics::topics(at, &TopicKeys { topics, sample_on, hold_ms })?)
        }
        None => {
            let of_values = [
                ("source.sample_on", table.sample_on.is_some()),
                ("source.hold_ms", table.hold_ms.is_some()),
            ];
            for (key, _) in of_values.into_iter().filter(|(_, given)| *given) {
                at.note(at.refuse(key, "given", "nothing here without `topics`"));
            }
            let allowed = "a topic or a filter, for example train/+/samples; or `topics` of single values";
            let topic = given("source.topic", &table.topic, allowed);
            if !is_filter(&topic) && !at.is_blamed("source.topic") {
                let allowed =
                    "a filter as brokers take it: + in place of one whole level, # in place of all after it";
                at.note(at.refuse("source.topic", format!("{topic:?}"), allowed));
            }
            Subjects::Samples(topic)
        }
    };
    Ok(MqttSource {
        host,
        port: match table.port {
            Some(0) => {
                at.note(at.refuse("source.port", 0, "the port of a broker, 1 to 65535"));
                1883
            }
            Some(port) => port,
            None => BrokerTls::port(tls.as_ref()),
        },
        subjects,
        client_id: table.client_id.clone().unwrap_or_else(|| "railgrip-ingest".to_owned()),
        user: table.user.clone(),
        password_file: table.password_file.as_deref().map(|file| at.beside(file)),
        tls,
    })
}

/// Whether wildcards stand for whole levels, and `#` for the last one alone (MQTT 3.1.1, 4.7.1); the rest is the broker's.
fn is_filter(topic: &str) -> bool {
    let mut levels = topic.split('/').rev();
    let last = levels.next().unwrap_or_default();
    let plain = |level: &str| level == "+" || !level.contains(['+', '#']);
    (last == "#" || plain(last)) && levels.all(plain)
}

/// A scenario by its file, or by its name: `scenarios/NAME.toml` beside the config.
fn scenario(at: &ConfigText<'_>, given: &str) -> Result<Scenario, SettingsError> {
    let named = folder(at.file).join(SCENARIO_FOLDER).join(format!("{given}.toml"));
    let file = folder(at.file).join(given);
    let found = [named.clone(), file].into_iter().find(|path| path.is_file());
    match found {
        Some(path) => Scenario::read(&path).map_err(|error| at.refuse_file("source.scenario", error)),
        None if given == DEFAULT_SCENARIO_NAME => Scenario::parse(&named, DEFAULT_SCENARIO)
            .map_err(|error| at.refuse_file("source.scenario", error)),
        None => {
            let allowed = format!("a scenario file, or the name of one in {SCENARIO_FOLDER}/");
            Err(at.refuse("source.scenario", format!("{given:?}"), allowed))
        }
    }
}

/// A key that another kind of source understands is as wrong as an unknown one.
fn check_keys_of_kind(at: &ConfigText<'_>, table: &SourceTable) {
    use SourceKind as Kind;
    let kind = table.kind;
    let keys: [(&str, bool, &[Kind]); 25] = [
        ("scenario", table.scenario.is_some(), &[Kind::Simulate]),
        ("programme", table.programme.is_some(), &[Kind::Rig]),
        ("seed", table.seed.is_some(), &[Kind::Simulate, Kind::Rig]),
        ("sample_rate_hz", table.sample_rate_hz.is_some(), &[Kind::Simulate]),
        ("runs", table.runs.is_some(), &[Kind::Replay]),
        ("loop", table.repeat.is_some(), &[Kind::Replay, Kind::Rig, Kind::Can]),
        ("speed", table.speed.is_some(), &[Kind::Simulate, Kind::Replay, Kind::Rig, Kind::Can]),
        ("listen", table.listen.is_some(), &[Kind::Tcp, Kind::Udp, Kind::Trdp]),
        ("host", table.host.is_some(), &[Kind::Mqtt]),
        ("port", table.port.is_some(), &[Kind::Mqtt]),
        ("topic", table.topic.is_some(), &[Kind::Mqtt]),
        ("topics", table.topics.is_some(), &[Kind::Mqtt]),
        ("client_id", table.client_id.is_some(), &[Kind::Mqtt]),
        ("user", table.user.is_some(), &[Kind::Mqtt]),
        ("allow_insecure", table.allow_insecure.is_some(), &[Kind::Mqtt]),
        ("password_file", table.password_file.is_some(), &[Kind::Mqtt]),
        ("tls", table.tls.is_some(), &[Kind::Mqtt]),
        ("ca_file", table.ca_file.is_some(), &[Kind::Mqtt]),
        ("interface", table.interface.is_some(), &[Kind::Can]),
        ("file", table.file.is_some(), &[Kind::Can]),
        ("database", table.database.is_some(), &[Kind::Can, Kind::Trdp]),
        ("senders", table.senders.is_some(), &[Kind::Trdp]),
        ("groups", table.groups.is_some(), &[Kind::Trdp]),
        ("sample_on", table.sample_on.is_some(), &[Kind::Can, Kind::Trdp, Kind::Mqtt]),
        ("hold_ms", table.hold_ms.is_some(), &[Kind::Can, Kind::Trdp, Kind::Mqtt]),
    ];
    for (key, ..) in keys.into_iter().filter(|(_, given, kinds)| *given && !kinds.contains(&kind)) {
        let kind = format!("{kind:?}").to_lowercase();
        let allowed = format!("nothing here for kind = \"{kind}\"");
        at.note(at.refuse(&format!("source.{key}"), "given", allowed));
    }
}
