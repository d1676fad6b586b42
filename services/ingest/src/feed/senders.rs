//! Who sends lines: the standard input, TCP connections, UDP datagrams, an MQTT broker. Each is read on a thread of its own.

use super::overrun::{self, Overruns};
use super::topics::Values;
use super::{Inlet, InputError};
use super::{cbor, lines};
use railgrip_messages::SourceCount;
use railgrip_mqtt::{Authorities, Broker, Connection, MqttError, News, Publish};
use railgrip_settings::{MqttSource, Source, Subjects, TopicPattern};
use rustix::net::sockopt::{
    set_socket_keepalive, set_socket_recv_buffer_size, set_tcp_keepcnt, set_tcp_keepidle, set_tcp_keepintvl,
};
use std::collections::BTreeSet;
use std::io::{BufReader, Read, stdin};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::thread::spawn;
use std::time::{Duration, Instant};

/// TCP connections at a time. A further one takes the place of the longest silent, if that has been silent for [`MAY_BE_SILENT`].
const MOST_CONNECTIONS: usize = 64;
const MAY_BE_SILENT: Duration = Duration::from_secs(10);
/// A sender whose computer has lost its power says so to nobody: it is asked after so many seconds of silence, so often and at such
/// intervals, s.
const ASKED_AFTER: Duration = Duration::from_secs(10);
const ASKED_EVERY: Duration = Duration::from_secs(5);
const ASKED_TIMES: u32 = 3;
/// Largest datagram.
const LARGEST_DATAGRAM: usize = 64 * 1024;
/// Time between two signs of life of an idle connection to a broker.
const KEEP_ALIVE: Duration = Duration::from_secs(10);
/// Longest wait for a broker to let us in.
const LOGIN: Duration = Duration::from_secs(10);
/// Pause before a broker is tried again.
const PAUSE: Duration = Duration::from_secs(1);

/// Starts to read what the source sends.
///
/// # Errors
/// An address that cannot be listened on.
pub(super) fn start(source: &Source, inlet: Inlet) -> Result<(), InputError> {
    let failed = |address: SocketAddr| move |source| InputError::Listen { address, source };
    match source {
        Source::Tcp(address) => {
            let listener = TcpListener::bind(address).map_err(failed(*address))?;
            spawn(move || accept(&listener, &inlet));
        }
        Source::Udp(address) => {
            let socket = UdpSocket::bind(address).map_err(failed(*address))?;
            socket.set_read_timeout(Some(overrun::PERIOD)).map_err(failed(*address))?;
            if let Err(error) = set_socket_recv_buffer_size(&socket, overrun::ROOM) {
                tracing::warn!(%error, "the queue of the socket stays as it is");
            }
            spawn(move || datagrams(&socket, &inlet));
        }
        Source::Mqtt(broker) => {
            let broker = broker.clone();
            spawn(move || messages(&broker, &inlet));
        }
        _ => {
            spawn(move || lines::read(BufReader::new(stdin()), "standard input", &inlet));
        }
    }
    Ok(())
}

fn accept(listener: &TcpListener, inlet: &Inlet) {
    let mut open: Vec<Weak<Sender>> = Vec::new();
    for connection in listener.incoming() {
        let Ok(connection) = connection else {
            std::thread::sleep(PAUSE);
            continue;
        };
        let name = connection.peer_addr().map_or_else(|_| "tcp".to_owned(), |peer| format!("tcp {peer}"));
        open.retain(|sender| sender.strong_count() > 0);
        if open.len() >= MOST_CONNECTIONS && !give_way(&mut open) {
            tracing::warn!("{name}: refused, {MOST_CONNECTIONS} connections are open and send");
            continue;
        }
        let asked = set_socket_keepalive(&connection, true)
            .and_then(|()| set_tcp_keepidle(&connection, ASKED_AFTER))
            .and_then(|()| set_tcp_keepintvl(&connection, ASKED_EVERY))
            .and_then(|()| set_tcp_keepcnt(&connection, ASKED_TIMES));
        if let Err(error) = asked {
            tracing::warn!("{name}: it is not noticed if its computer is gone ({error})");
        }
        tracing::info!("{name}: connected");
        let sender = Arc::new(Sender { connection, heard: Mutex::new(Instant::now()) });
        open.push(Arc::downgrade(&sender));
        let inlet = inlet.clone();
        spawn(move || {
            lines::read(BufReader::new(&*sender), &name, &inlet);
            tracing::info!("{name}: gone");
        });
    }
}

/// Closes the connection that has been silent longest; false if all of them send.
fn give_way(open: &mut Vec<Weak<Sender>>) -> bool {
    let silent = |sender: &Weak<Sender>| sender.upgrade().map_or(Duration::MAX, |sender| sender.silence());
    let Some(longest) = (0..open.len()).max_by_key(|index| silent(&open[*index])) else { return true };
    if silent(&open[longest]) < MAY_BE_SILENT {
        return false;
    }
    if let Some(sender) = open.swap_remove(longest).upgrade() {
        // Its thread reads the end and goes.
        let _ = sender.connection.shutdown(Shutdown::Both);
    }
    true
}

/// A connection, and when something came by it last.
struct Sender {
    connection: TcpStream,
    heard: Mutex<Instant>,
}

impl Sender {
    fn silence(&self) -> Duration {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner).elapsed()
    }
}

impl Read for &Sender {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let read = (&self.connection).read(into)?;
        *self.heard.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
        Ok(read)
    }
}

/// Puts every sample of a datagram or message into the inlet, lines of JSON or maps of CBOR; false once nobody takes them any more.
fn put_all(message: &[u8], name: &str, inlet: &Inlet) -> bool {
    if cbor::is_cbor(message) {
        cbor::put_all(message, name, inlet)
    } else {
        lines::put_all(message, name, inlet)
    }
}

fn datagrams(socket: &UdpSocket, inlet: &Inlet) {
    let mut datagram = vec![0; LARGEST_DATAGRAM];
    let mut overruns = Overruns::new();
    loop {
        overruns.look(socket, inlet.tally());
        match socket.recv_from(&mut datagram) {
            Ok((length, peer)) => {
                if !put_all(&datagram[..length], &format!("udp {peer}"), inlet) {
                    return;
                }
            }
            Err(error) if overrun::is_pause(&error) => {}
            Err(error) => {
                tracing::warn!(%error, "a datagram cannot be received");
                std::thread::sleep(PAUSE);
            }
        }
    }
}

fn connect(source: &MqttSource) -> Result<Connection, MqttError> {
    let broker = Broker {
        host: &source.host,
        port: source.port,
        client_id: &source.client_id,
        user: source.user.as_deref(),
        password_file: source.password_file.as_deref(),
        tls: source.tls.as_ref().map(|tls| Authorities::of(tls.ca_file.as_deref())),
    };
    // Nobody waits for this thread: it ends with the process.
    let stop = Arc::new(AtomicBool::new(false));
    Connection::open(&broker, KEEP_ALIVE, Instant::now() + LOGIN, &stop)
}

/// Listens to the broker, and connects again for as long as anybody takes the rows.
fn messages(broker: &MqttSource, inlet: &Inlet) {
    let name = format!("mqtt {}:{}", broker.host, broker.port);
    let mut told = false;
    let mut values = match &broker.subjects {
        Subjects::Samples(_) => None,
        Subjects::Values(topics) => Some(Values::new(topics, inlet.clone())),
    };
    let mut take = |message: &Publish| {
        let name = format!("{name} {}", message.topic);
        // Of a message that was kept for whoever comes later nobody knows how old it is.
        if message.retain {
            inlet.tally().add(SourceCount::Arrived, 1);
            inlet.tally().add(SourceCount::Old, 1);
            return true;
        }
        match &mut values {
            None => put_all(&message.payload, &name, inlet),
            Some(values) => values.take(&message.topic, &message.payload, &name),
        }
    };
    let filters = filters(&broker.subjects);
    loop {
        let listened =
            connect(broker).and_then(|connection| listen(&filters, connection, &name, &mut take, &mut told));
        let Err(trouble) = listened else { return };
        if !told {
            tracing::warn!("{name}: {trouble}; tried again and again");
            told = true;
        }
        std::thread::sleep(PAUSE);
    }
}

/// What is asked of a broker, each filter once.
fn filters(subjects: &Subjects) -> Vec<String> {
    match subjects {
        Subjects::Samples(filter) => vec![filter.clone()],
        Subjects::Values(topics) => {
            let filters: BTreeSet<_> = topics.patterns.iter().map(TopicPattern::filter).collect();
            filters.into_iter().collect()
        }
    }
}

/// Until the connection fails, or nobody takes the rows any more.
fn listen(
    filters: &[String],
    mut connection: Connection,
    name: &str,
    take: &mut dyn FnMut(&Publish) -> bool,
    told: &mut bool,
) -> Result<(), MqttError> {
    for filter in filters {
        connection.subscribe(filter)?;
    }
    loop {
        match connection.news(KEEP_ALIVE)? {
            News::Subscribed => {
                tracing::info!("{name}: connected");
                *told = false;
            }
            News::Message(message) => {
                if !take(&message) {
                    return Ok(());
                }
            }
            News::None => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::{Feed, Live};
    use railgrip_filter::PlantKind;

    /// Connections whose computers had lost their power once kept every other sender out for ever.
    #[test]
    fn a_silent_connection_gives_way_and_one_that_sends_does_not() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a socket");
        let sender = |silent: Duration| {
            let ours = TcpStream::connect(listener.local_addr().expect("an address")).expect("connected");
            let connection = listener.accept().expect("accepted").0;
            let heard = Instant::now().checked_sub(silent).expect("the machine runs for longer");
            (ours, Arc::new(Sender { connection, heard: Mutex::new(heard) }))
        };
        let all = [1, 30, 20, 2].map(|seconds| sender(Duration::from_secs(seconds)));
        let mut open: Vec<Weak<Sender>> = all.iter().map(|(_, sender)| Arc::downgrade(sender)).collect();
        let closed = || all.iter().map(|(ours, _)| is_closed(ours)).collect::<Vec<bool>>();
        assert!(give_way(&mut open) && closed() == [false, true, false, false]);
        assert!(give_way(&mut open) && closed() == [false, true, true, false]);
        assert!(!give_way(&mut open) && open.len() == 2, "these send");
    }

    fn is_closed(mut connection: &TcpStream) -> bool {
        connection.set_read_timeout(Some(Duration::from_millis(200))).expect("a time");
        matches!(connection.read(&mut [0; 8]), Ok(0))
    }

    #[test]
    fn what_a_full_queue_loses_is_counted() {
        let vehicle = toml::from_str(include_str!("../../../../config/vehicle.toml")).expect("a vehicle");
        let mut live = Live::of("test", &[vehicle], &[PlantKind::Wagon]);
        let inlet = live.inlet().expect("the first");
        let tally = inlet.tally().clone();
        let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        socket.set_read_timeout(Some(overrun::PERIOD)).expect("a time");
        set_socket_recv_buffer_size(&socket, 16 << 10).expect("little room");
        let (sender, address) = (UdpSocket::bind("127.0.0.1:0").expect("a socket"), socket.local_addr());
        let address = address.expect("an address");
        // Nobody reads yet: most of it finds no room.
        let sent = 5000_u64;
        for k in 0..sent {
            let line = format!("{{\"wagon\":1,\"t_s\":{:.3},\"v_m_s\":20}}\n", k as f64 * 1e-3);
            sender.send_to(line.as_bytes(), address).expect("sent");
        }
        spawn(move || datagrams(&socket, &inlet));
        let began = Instant::now();
        let (mut arrived, mut lost) = (0, 0);
        while arrived + lost < sent && began.elapsed() < Duration::from_secs(20) {
            live.take_due(0.0, &mut |_| ());
            (arrived, lost) = (tally.count(SourceCount::Arrived), tally.count(SourceCount::Overrun));
            std::thread::sleep(Duration::from_millis(20));
        }
        assert!(arrived > 0 && lost > sent / 2, "{arrived} arrived, {lost} were lost");
        assert_eq!(arrived + lost, sent);
    }
}
