//! Sources that speak in messages: CAN frames by a DBC file, process data of TRDP by its XML file, both by the one mapping.

use crate::SettingsError;
use crate::place::ConfigText;
use railgrip_fieldbus::{Catalogue, FieldbusError, Lanes, Plan, dbc, trdp};
use railgrip_recording::{Mapping, read_bytes};
use serde::{Deserialize, Serialize};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;

/// A value counts for so long after its message, unless the config says otherwise, ms.
const HOLD_MS: f64 = 500.0;

/// One text or several.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(untagged)]
pub(crate) enum Several {
    One(String),
    Several(Vec<String>),
}

/// The keys of both kinds of source.
pub(crate) struct MessageKeys<'a> {
    pub database: Option<&'a str>,
    pub sample_on: Option<&'a str>,
    pub hold_ms: Option<f64>,
}

/// The keys of a CAN source alone.
pub(crate) struct CanKeys<'a> {
    pub interface: Option<&'a Several>,
    pub file: Option<&'a str>,
    pub speed: Option<f64>,
    pub repeat: Option<bool>,
}

/// What the messages of a source mean, and what is wanted of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Messages {
    /// The file that describes them.
    pub database: PathBuf,
    /// What it describes.
    pub catalogue: Catalogue,
    /// A value counts for so long after its message, s.
    pub hold_s: f64,
    /// The message that makes the rows of a wagon, where the config names it.
    pub sample_on: Option<String>,
    /// What becomes of each message.
    pub plan: Plan,
}

/// Frames of CAN buses.
#[derive(Debug, Clone, PartialEq)]
pub struct CanSource {
    /// Interfaces: one for all wagons, or one a wagon.
    pub interfaces: Vec<String>,
    /// A log in the form of `candump -L` to play in place of the interfaces.
    pub log: Option<CanLog>,
    /// What the frames mean.
    pub messages: Messages,
}

/// A log of frames.
#[derive(Debug, Clone, PartialEq)]
pub struct CanLog {
    /// The file.
    pub file: PathBuf,
    /// Recorded seconds in a second, 1 or more.
    pub speed: f64,
    /// Begin again at the end.
    pub repeat: bool,
}

/// Process data of a train network.
#[derive(Debug, Clone, PartialEq)]
pub struct TrdpSource {
    /// Where telegrams arrive.
    pub listen: SocketAddr,
    /// Multicast groups to join.
    pub groups: Vec<Ipv4Addr>,
    /// Addresses of the senders, one a wagon; without them names tell the wagons apart, and any sender counts.
    pub senders: Vec<IpAddr>,
    /// What the telegrams mean.
    pub messages: Messages,
}

/// Settles a CAN source; its plan is made once the wagons are known.
pub(crate) fn can(
    at: &ConfigText<'_>,
    keys: &CanKeys<'_>,
    speed: f64,
    of_messages: &MessageKeys<'_>,
) -> Result<CanSource, SettingsError> {
    let interfaces = match keys.interface {
        None => Vec::new(),
        Some(Several::One(name)) => vec![name.clone()],
        Some(Several::Several(names)) => names.clone(),
    };
    let plain = |c: u8| c.is_ascii_graphic() && c != b'/';
    let sound = |name: &&String| (1..=15).contains(&name.len()) && name.bytes().all(plain);
    let allowed = "the name of an interface such as can0, or a list of them";
    if let Some(name) = interfaces.iter().find(|name| !sound(name)) {
        at.note(at.refuse("source.interface", format!("{name:?}"), allowed));
    }
    one_each(at, "source.interface", &interfaces);
    let log = match keys.file {
        Some(file) => {
            let speed = at.number("source.speed", speed, 1.0..=1000.0);
            Some(CanLog { file: at.beside(file), speed, repeat: keys.repeat.unwrap_or(false) })
        }
        None if interfaces.is_empty() => {
            let allowed = "the name of an interface such as can0, or `file`, a log of candump";
            if !at.is_blamed("source.file") {
                at.note(at.refuse("source.interface", "absent", allowed));
            }
            None
        }
        None => {
            let of_a_log = [("source.speed", keys.speed.is_some()), ("source.loop", keys.repeat.is_some())];
            for (key, _) in of_a_log.into_iter().filter(|(_, given)| *given && !at.is_blamed("source.file")) {
                at.note(at.refuse(key, "given", "nothing here without `file`"));
            }
            None
        }
    };
    let messages = messages(at, of_messages, "a DBC file, relative to this file", dbc::read)?;
    Ok(CanSource { interfaces, log, messages })
}

/// Settles a TRDP source; its plan is made once the wagons are known.
pub(crate) fn trdp(
    at: &ConfigText<'_>,
    listen: Option<SocketAddr>,
    groups: &[String],
    senders: &[String],
    of_messages: &MessageKeys<'_>,
) -> Result<TrdpSource, SettingsError> {
    let groups = groups.iter().map(|given| {
        let group = given.parse::<Ipv4Addr>().ok().filter(Ipv4Addr::is_multicast);
        let allowed = "multicast groups such as \"239.192.0.1\"";
        group.ok_or_else(|| at.refuse("source.groups", format!("{given:?}"), allowed))
    });
    let senders = senders.iter().map(|given| {
        let allowed = "addresses such as \"10.0.1.5\", one a wagon";
        given.parse().map_err(|_| at.refuse("source.senders", format!("{given:?}"), allowed))
    });
    let senders = at.or(senders.collect(), Vec::new());
    one_each(at, "source.senders", &senders);
    Ok(TrdpSource {
        listen: listen.unwrap_or_else(|| SocketAddr::from((Ipv4Addr::UNSPECIFIED, trdp::PORT))),
        groups: at.or(groups.collect(), Vec::new()),
        senders,
        messages: messages(
            at,
            of_messages,
            "an XML file of a TRDP device, relative to this file",
            trdp::read,
        )?,
    })
}

/// Refuses a list, one a wagon, that names the same twice: two wagons would be one.
fn one_each<T: PartialEq + std::fmt::Display>(at: &ConfigText<'_>, key: &str, list: &[T]) {
    if let Some((_, twice)) = list.iter().enumerate().find(|(place, one)| list[..*place].contains(one)) {
        at.note(at.refuse(key, format!("{twice} twice"), "one of its own for each wagon"));
    }
}

fn messages(
    at: &ConfigText<'_>,
    keys: &MessageKeys<'_>,
    allowed: &str,
    read: fn(&str) -> Result<Catalogue, FieldbusError>,
) -> Result<Messages, SettingsError> {
    let key = "source.database";
    let hold_ms = at.number("source.hold_ms", keys.hold_ms.unwrap_or(HOLD_MS), 1.0..=60_000.0);
    let Some(given) = keys.database.filter(|given| !given.is_empty()) else {
        return Err(at.refuse(key, "absent", allowed));
    };
    let database = at.beside(given);
    let refuse = |problem: String| at.refuse(key, format!("{given:?} ({problem})"), allowed);
    let bytes = read_bytes(&database).map_err(|error| refuse(error.to_string()))?;
    // Comments in such files are often in Latin-1; nothing that counts here is.
    let catalogue = read(&String::from_utf8_lossy(&bytes)).map_err(|error| refuse(error.to_string()))?;
    let sample_on = keys.sample_on.map(str::to_owned);
    Ok(Messages { database, catalogue, hold_s: hold_ms * 1e-3, sample_on, plan: Plan::default() })
}

/// Makes the plan of a source of which so many buses or senders are named by a key.
pub(crate) fn resolve(
    at: &ConfigText<'_>,
    (key, lanes): (&str, usize),
    messages: &mut Messages,
    mapping: &Mapping,
    wheelsets: &[usize],
) -> Result<(), SettingsError> {
    // One bus serves all; one sender can only be the wagon's own.
    let lanes = match lanes {
        0 => Lanes::Shared,
        1 if key == "source.interface" => Lanes::Shared,
        count if count == wheelsets.len() => Lanes::OneEach,
        count => {
            let allowed = format!("one for each of the {} wagons", wheelsets.len());
            return Err(at.refuse(key, format!("a list of {count}"), allowed));
        }
    };
    let plan = Plan::new(&messages.catalogue, mapping, wheelsets, lanes, messages.sample_on.as_deref());
    messages.plan = plan.map_err(|error| {
        let key = match error {
            FieldbusError::Unknown { .. } if messages.sample_on.is_some() => "source.sample_on",
            _ => "mapping",
        };
        let value = format!("not what {} has ({error})", messages.database.display());
        at.refuse(key, value, "names of values in it")
    })?;
    Ok(())
}
