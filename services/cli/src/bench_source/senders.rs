//! Who sends the samples of each source.

use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr, TcpStream, UdpSocket};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::{Duration, Instant};

use railgrip_bus::{Bus, BusConfig, SamplePublisher, now};
use railgrip_fieldbus::trdp::{Telegram, write};
use railgrip_messages::{ProcessKind, Sample, sample_flags, valid};
use railgrip_settings::{Overrides, TrainSettings};
use rumqttc::{Client, MqttOptions, QoS};

use super::config::{FIRST_TELEGRAM, Kind, OMEGA_RAD_S, Place, RATE_HZ, V_M_S, WAGONS, broker};
use crate::CliError;
use crate::bench_up::Up;

/// How long a sender waits for whoever listens.
const PATIENCE: Duration = Duration::from_secs(10);
const PAUSE: Duration = Duration::from_millis(10);
/// Messages to a broker that may wait.
const WAITING: usize = 10_000;

/// Sends a sample of every wagon.
pub(super) trait Sender {
    /// Those of one tick; says how many were sent.
    fn send(&mut self, tick: u32) -> Result<u64, CliError>;
}

/// The sender of a source, once somebody listens.
pub(super) fn open(kind: Kind, place: &Place, up: &mut Up) -> Result<Box<dyn Sender>, CliError> {
    let to = SocketAddr::from((Ipv4Addr::LOCALHOST, place.port));
    Ok(match kind {
        Kind::Stdin => {
            let input = up.input().ok_or_else(|| CliError::failed("the train has no standard input"))?;
            Box::new(Piped(input))
        }
        Kind::Tcp => Box::new(Connected { to, stream: connect(to)? }),
        Kind::Udp => Box::new(Datagrams { socket: bound()?, to }),
        Kind::Mqtt => Box::new(Brokered::start(to)?),
        Kind::Can => Box::new(Logged),
        Kind::Trdp => Box::new(Telegrams { socket: bound()?, to }),
        Kind::External => Box::new(Published::open(up)?),
    })
}

fn time_s(tick: u32) -> f64 {
    f64::from(tick) / f64::from(RATE_HZ)
}

/// A line of every wagon.
fn lines(tick: u32) -> String {
    let t_s = time_s(tick);
    let line = |wagon: usize| {
        format!(
            "{{\"wagon\":{wagon},\"t_s\":{t_s:.4},\"v_m_s\":{V_M_S},\"omega_f_rad_s\":{OMEGA_RAD_S},\
             \"omega_r_rad_s\":{OMEGA_RAD_S},\"f_perp_f_n\":0,\"f_perp_r_n\":0}}\n"
        )
    };
    (1..=WAGONS).map(line).collect()
}

fn bound() -> Result<UdpSocket, CliError> {
    UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).map_err(CliError::failed)
}

fn connect(to: SocketAddr) -> Result<TcpStream, CliError> {
    let began = Instant::now();
    loop {
        match TcpStream::connect(to) {
            Ok(stream) => {
                stream.set_nodelay(true).map_err(CliError::failed)?;
                return Ok(stream);
            }
            Err(error) if began.elapsed() > PATIENCE => return Err(CliError::failed(error)),
            Err(_) => std::thread::sleep(PAUSE),
        }
    }
}

struct Piped(ChildStdin);

impl Sender for Piped {
    fn send(&mut self, tick: u32) -> Result<u64, CliError> {
        self.0.write_all(lines(tick).as_bytes()).map_err(CliError::failed)?;
        Ok(WAGONS as u64)
    }
}

/// Connects again where whoever listens has died; what was on its way is lost.
struct Connected {
    to: SocketAddr,
    stream: TcpStream,
}

impl Sender for Connected {
    fn send(&mut self, tick: u32) -> Result<u64, CliError> {
        if self.stream.write_all(lines(tick).as_bytes()).is_err() {
            self.stream = connect(self.to)?;
        }
        Ok(WAGONS as u64)
    }
}

struct Datagrams {
    socket: UdpSocket,
    to: SocketAddr,
}

impl Sender for Datagrams {
    fn send(&mut self, tick: u32) -> Result<u64, CliError> {
        // Refused while nobody listens: lost like any other.
        let _ = self.socket.send_to(lines(tick).as_bytes(), self.to);
        Ok(WAGONS as u64)
    }
}

/// A broker of our own, and a client that is confirmed each message.
struct Brokered {
    broker: Child,
    client: Client,
}

impl Brokered {
    fn start(at: SocketAddr) -> Result<Self, CliError> {
        let program = broker().ok_or_else(|| CliError::failed("there is no mosquitto here"))?;
        let mut command = Command::new(program);
        command.args(["-p", &at.port().to_string()]).stdout(Stdio::null()).stderr(Stdio::null());
        let mut broker = command.spawn().map_err(CliError::failed)?;
        if let Err(error) = connect(at) {
            let _ = broker.kill();
            return Err(error);
        }
        let mut options = MqttOptions::new("bench", at.ip().to_string(), at.port());
        options.set_inflight(1000);
        let (client, mut connection) = Client::new(options, WAITING);
        std::thread::spawn(move || {
            // A broker that is stopped ends it.
            for event in connection.iter() {
                if event.is_err() {
                    return;
                }
            }
        });
        Ok(Self { broker, client })
    }
}

impl Sender for Brokered {
    fn send(&mut self, tick: u32) -> Result<u64, CliError> {
        let publish = self.client.publish("bench/samples", QoS::AtLeastOnce, false, lines(tick));
        publish.map_err(CliError::failed)?;
        Ok(WAGONS as u64)
    }
}

impl Drop for Brokered {
    fn drop(&mut self) {
        let _ = self.broker.kill();
        let _ = self.broker.wait();
    }
}

/// A log plays itself.
struct Logged;

impl Sender for Logged {
    fn send(&mut self, _tick: u32) -> Result<u64, CliError> {
        Ok(WAGONS as u64)
    }
}

struct Telegrams {
    socket: UdpSocket,
    to: SocketAddr,
}

impl Sender for Telegrams {
    fn send(&mut self, tick: u32) -> Result<u64, CliError> {
        let mut data = time_s(tick).to_be_bytes().to_vec();
        for value in [V_M_S, OMEGA_RAD_S, OMEGA_RAD_S, 0.0] {
            data.extend((value as f32).to_be_bytes());
        }
        for wagon in 0..WAGONS as u32 {
            let com_id = FIRST_TELEGRAM + wagon;
            let telegram =
                Telegram { sequence: tick, com_id, etb_topo_count: 0, op_train_topo_count: 0, data: &data };
            let _ = self.socket.send_to(&write(&telegram), self.to);
        }
        Ok(WAGONS as u64)
    }
}

/// Publishes on the channels itself, in batches as an ingest does.
struct Published {
    publishers: Vec<SamplePublisher>,
    batches: Vec<Vec<Sample>>,
    _bus: Bus,
}

/// Ticks of a batch.
const BATCH: u32 = 10;

impl Published {
    fn open(up: &Up) -> Result<Self, CliError> {
        let overrides = Overrides { instance_dir: Some(up.folder().join("i")), ..Overrides::default() };
        let settings = TrainSettings::load(Some(&up.folder().join("train.toml")), &overrides)?;
        let began = Instant::now();
        let bus = loop {
            match Bus::open(BusConfig::of(&settings), ProcessKind::Ingest, 0) {
                Ok(bus) => break bus,
                Err(error) if began.elapsed() > PATIENCE => return Err(error.into()),
                Err(_) => std::thread::sleep(PAUSE),
            }
        };
        let publishers =
            (1..=WAGONS as u32).map(|wagon| bus.sample_publisher(wagon)).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { publishers, batches: vec![Vec::new(); WAGONS], _bus: bus })
    }
}

impl Sender for Published {
    fn send(&mut self, tick: u32) -> Result<u64, CliError> {
        let mut sample = Sample {
            time_s: time_s(tick),
            sequence: u64::from(tick),
            acquired: now(),
            wheelsets: 2,
            v_m_s: V_M_S,
            flags: if tick == 0 { sample_flags::TIME_BASE_RESTARTED } else { 0 },
            valid: valid::SPEED
                | valid::wheel_speed(0)
                | valid::wheel_speed(1)
                | valid::pressing_force(0)
                | valid::pressing_force(1),
            ..Sample::default()
        };
        sample.wheel_speed_rad_s[..2].fill(OMEGA_RAD_S);
        for (batch, publisher) in self.batches.iter_mut().zip(&self.publishers) {
            batch.push(sample);
            if (tick + 1).is_multiple_of(BATCH) {
                publisher.publish(batch)?;
                batch.clear();
            }
        }
        Ok(WAGONS as u64)
    }
}
