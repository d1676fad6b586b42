//! A train for each source: its config, and what it names.

use std::fmt::Write as _;
use std::net::{Ipv4Addr, TcpListener, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::Stdio;

use crate::CliError;

/// Wagons of the train.
pub(super) const WAGONS: usize = 16;
/// Samples a second of each.
pub(super) const RATE_HZ: u32 = 1000;
/// Speed of the train, and of its wheels of 0.44 m, in the steps in which CAN carries them.
pub(super) const V_M_S: f64 = 20.0;
pub(super) const OMEGA_RAD_S: f64 = 45.45;
const STEPS_A_UNIT: f64 = 100.0;
/// The first telegram, and the first frame.
pub(super) const FIRST_TELEGRAM: u32 = 2001;
const FIRST_FRAME: u32 = 0x101;
/// Frames that nobody wants follow the last sample of a log, so that the source has not ended while its counts are read.
const AFTERWARDS_S: [u32; 2] = [8, 16];
/// When the log was taken, s.
const LOG_BEGAN_S: u32 = 1_760_000_000;
/// Where Debian keeps services, beside the search path.
const SERVICES: &str = "/usr/sbin";

/// A live source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Stdin,
    Tcp,
    Udp,
    Mqtt,
    Can,
    Trdp,
    External,
}

/// One source, or all.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Kinds {
    All,
    One(Kind),
}

impl Kind {
    pub const ALL: [Self; 7] =
        [Self::Stdin, Self::Tcp, Self::Udp, Self::Mqtt, Self::Can, Self::Trdp, Self::External];

    /// As the config calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stdin => "stdin",
            Self::Tcp => "tcp",
            Self::Udp => "udp",
            Self::Mqtt => "mqtt",
            Self::Can => "can",
            Self::Trdp => "trdp",
            Self::External => "external",
        }
    }

    /// The source of that name, or all.
    pub fn named(text: &str) -> Result<Kinds, String> {
        let names = Self::ALL.map(Self::name).join(", ");
        match Self::ALL.into_iter().find(|kind| kind.name() == text) {
            Some(kind) => Ok(Kinds::One(kind)),
            None if text == "all" => Ok(Kinds::All),
            None => Err(format!("allowed are {names}, all")),
        }
    }

    /// What it needs and this machine lacks.
    pub fn missing(self) -> Option<&'static str> {
        (self == Self::Mqtt && broker().is_none()).then_some("there is no mosquitto here")
    }

    /// False where nothing goes on after a new ingest: a log begins anew.
    pub fn can_lose_ingest(self) -> bool {
        !matches!(self, Self::Can | Self::External)
    }

    /// Standard input of the train.
    pub fn input(self) -> Stdio {
        if self == Self::Stdin { Stdio::piped() } else { Stdio::null() }
    }
}

/// Where a source is reached.
pub(super) struct Place {
    pub port: u16,
}

impl Place {
    /// A free port.
    pub fn free(kind: Kind) -> Result<Self, CliError> {
        let any = (Ipv4Addr::LOCALHOST, 0);
        let address = match kind {
            Kind::Udp | Kind::Trdp => UdpSocket::bind(any).and_then(|socket| socket.local_addr()),
            _ => TcpListener::bind(any).and_then(|listener| listener.local_addr()),
        };
        Ok(Self { port: address.map_err(CliError::failed)?.port() })
    }
}

/// The broker's program.
pub(super) fn broker() -> Option<PathBuf> {
    let given = std::env::var_os("MOSQUITTO").map(PathBuf::from);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path).chain([PathBuf::from(SERVICES)]);
    given.into_iter().chain(folders.map(|folder| folder.join("mosquitto"))).find(|file| file.is_file())
}

/// Lays what the config names into the folder, and gives its text.
pub(super) fn prepare(kind: Kind, place: &Place, folder: &Path, ticks: u32) -> Result<String, CliError> {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).map_err(CliError::failed);
    let port = place.port;
    let source = match kind {
        Kind::Stdin | Kind::External => String::new(),
        Kind::Tcp | Kind::Udp => format!("listen = \"127.0.0.1:{port}\"\n"),
        Kind::Mqtt => format!("host = \"127.0.0.1\"\nport = {port}\ntopic = \"bench/samples\"\n"),
        Kind::Can => {
            write("train.dbc", &database())?;
            write("bus.log", &log(ticks))?;
            format!("database = \"train.dbc\"\nfile = \"bus.log\"\n{}", mapping("W{wagon}Axles", ""))
        }
        Kind::Trdp => {
            write("device.xml", &telegrams())?;
            let time = "t_s = { from = \"W{wagon}.t\" }\n";
            format!("listen = \"127.0.0.1:{port}\"\ndatabase = \"device.xml\"\n{}", mapping("W{wagon}", time))
        }
    };
    Ok(format!(
        "schema = 1\n[train]\nname = \"bench\"\nwagons = {WAGONS}\nvehicle = \"vehicle.toml\"\n\
         [samples]\nbatch_ms = 10.0\n[logging]\nlevel = \"error\"\n[source]\nkind = \"{}\"\n{source}",
        kind.name()
    ))
}

fn mapping(message: &str, time: &str) -> String {
    format!(
        "[mapping]\n{time}v_m_s = {{ from = \"{message}.V\" }}\nomega_f_rad_s = {{ from = \"{message}.N1\" }}\n\
         omega_r_rad_s = {{ from = \"{message}.N2\" }}\nf_perp_f_n = {{ from = \"{message}.P\" }}\n\
         f_perp_r_n = {{ from = \"{message}.P\" }}\n"
    )
}

/// A frame a wagon.
fn database() -> String {
    let mut text = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: BCU\n".to_owned();
    for wagon in 1..=WAGONS as u32 {
        let frame = FIRST_FRAME + wagon - 1;
        let _ = writeln!(text, "\nBO_ {frame} W{wagon}Axles: 8 BCU");
        for (place, (name, unit)) in
            [("V", "m/s"), ("N1", "rad/s"), ("N2", "rad/s"), ("P", "N")].into_iter().enumerate()
        {
            let bit = 16 * place;
            let _ = writeln!(text, " SG_ {name} : {bit}|16@1+ (0.01,0) [0|600] \"{unit}\" BCU");
        }
    }
    text
}

/// A log in which every wagon has a frame in every tick.
fn log(ticks: u32) -> String {
    let steps = |value: f64| ((value * STEPS_A_UNIT).round() as u16).swap_bytes();
    let (v, omega) = (steps(V_M_S), steps(OMEGA_RAD_S));
    let mut text = String::new();
    let step_us = 1_000_000 / RATE_HZ;
    for tick in 0..ticks {
        let t_us = u64::from(tick) * u64::from(step_us);
        let (seconds, rest_us) = (u64::from(LOG_BEGAN_S) + t_us / 1_000_000, t_us % 1_000_000);
        for wagon in 0..WAGONS as u32 {
            let frame = FIRST_FRAME + wagon;
            let _ =
                writeln!(text, "({seconds}.{rest_us:06}) can0 {frame:03X}#{v:04X}{omega:04X}{omega:04X}0000");
        }
    }
    for after_s in AFTERWARDS_S {
        let _ = writeln!(text, "({}.000000) can0 7FF#00", LOG_BEGAN_S + ticks / RATE_HZ + after_s);
    }
    text
}

/// A telegram a wagon.
fn telegrams() -> String {
    let mut text = "<?xml version=\"1.0\"?>\n<device host-name=\"bcu\" type=\"bench\">\n<bus-interface-list>\
                    <bus-interface network-id=\"1\" name=\"eth0\">\n"
        .to_owned();
    for wagon in 1..=WAGONS as u32 {
        let com_id = FIRST_TELEGRAM + wagon - 1;
        let _ = writeln!(
            text,
            "<telegram name=\"W{wagon}\" com-id=\"{com_id}\" data-set-id=\"1001\"><pd-parameter cycle=\"1000\"/></telegram>"
        );
    }
    text.push_str(
        "</bus-interface></bus-interface-list>\n<data-set-list><data-set name=\"axles\" id=\"1001\">\
         <element name=\"t\" type=\"REAL64\"/><element name=\"V\" type=\"REAL32\"/><element name=\"N1\" type=\"REAL32\"/>\
         <element name=\"N2\" type=\"REAL32\"/><element name=\"P\" type=\"REAL32\"/></data-set></data-set-list>\n</device>\n",
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_settings::{Overrides, TrainSettings};

    #[test]
    fn every_source_has_a_config_that_is_accepted() {
        for kind in Kind::ALL {
            let folder = tempfile::tempdir().expect("a folder");
            let vehicle = include_str!("../../../../config/vehicle.toml");
            std::fs::write(folder.path().join("vehicle.toml"), vehicle).expect("written");
            let text = prepare(kind, &Place { port: 9 }, folder.path(), 3).expect("prepared");
            let settings =
                TrainSettings::parse(&folder.path().join("train.toml"), &text, &Overrides::default());
            assert_eq!(settings.expect("accepted").wagons.len(), WAGONS, "{}", kind.name());
            assert!(matches!(Kind::named(kind.name()), Ok(Kinds::One(named)) if named == kind));
        }
        assert_eq!(log(3).lines().count(), 3 * WAGONS + 2);
        assert!(Kind::named("carrier pigeon").is_err());
    }
}
