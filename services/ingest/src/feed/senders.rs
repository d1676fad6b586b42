//! Who sends lines: the standard input, TCP connections, UDP datagrams, an MQTT broker. Each is read on a thread of its own.

use super::overrun::{self, Overruns};
use super::{Inlet, InputError};
use super::{cbor, lines};
use railgrip_settings::{MqttSource, Source};
use rumqttc::{Client, Connection, Event, MqttOptions, Packet, QoS};
use rustix::net::sockopt::set_socket_recv_buffer_size;
use std::io::{BufReader, stdin};
use std::net::{SocketAddr, TcpListener, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::spawn;
use std::time::Duration;

/// TCP connections at a time; further ones are closed at once.
const MOST_CONNECTIONS: usize = 64;
/// Largest datagram.
const LARGEST_DATAGRAM: usize = 64 * 1024;
/// Largest message of a broker, bytes.
const LARGEST_MESSAGE: usize = 1 << 20;
/// Time between two signs of life of an idle connection to a broker.
const KEEP_ALIVE: Duration = Duration::from_secs(10);
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
    let open = Arc::new(AtomicUsize::new(0));
    for connection in listener.incoming() {
        let Ok(connection) = connection else {
            std::thread::sleep(PAUSE);
            continue;
        };
        let name = connection.peer_addr().map_or_else(|_| "tcp".to_owned(), |peer| format!("tcp {peer}"));
        if open.fetch_add(1, Ordering::Relaxed) >= MOST_CONNECTIONS {
            open.fetch_sub(1, Ordering::Relaxed);
            tracing::warn!("{name}: refused, {MOST_CONNECTIONS} connections are open");
            continue;
        }
        tracing::info!("{name}: connected");
        let (inlet, open) = (inlet.clone(), Arc::clone(&open));
        spawn(move || {
            lines::read(BufReader::new(connection), &name, &inlet);
            open.fetch_sub(1, Ordering::Relaxed);
            tracing::info!("{name}: gone");
        });
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

fn connect(broker: &MqttSource) -> Result<(Client, Connection), String> {
    let mut options = MqttOptions::new(&broker.client_id, &broker.host, broker.port);
    options.set_keep_alive(KEEP_ALIVE);
    options.set_clean_session(true);
    options.set_max_packet_size(LARGEST_MESSAGE, LARGEST_MESSAGE);
    if let Some(user) = &broker.user {
        let password = match &broker.password_file {
            Some(file) => {
                std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?
            }
            None => String::new(),
        };
        options.set_credentials(user, password.trim());
    }
    Ok(Client::new(options, 10))
}

/// Listens to the broker, and connects again for as long as anybody takes the rows.
fn messages(broker: &MqttSource, inlet: &Inlet) {
    let name = format!("mqtt {}:{}", broker.host, broker.port);
    let mut told = false;
    loop {
        let trouble = match connect(broker) {
            Ok((client, connection)) => match listen(broker, &client, connection, &name, inlet, &mut told) {
                None => return,
                Some(trouble) => trouble,
            },
            Err(trouble) => trouble,
        };
        if !told {
            tracing::warn!("{name}: {trouble}; tried again and again");
            told = true;
        }
        std::thread::sleep(PAUSE);
    }
}

/// Until the connection fails; `None` once nobody takes the rows any more.
fn listen(
    broker: &MqttSource,
    client: &Client,
    mut connection: Connection,
    name: &str,
    inlet: &Inlet,
    told: &mut bool,
) -> Option<String> {
    for event in connection.iter() {
        match event {
            Ok(Event::Incoming(Packet::ConnAck(_))) => {
                if let Err(error) = client.subscribe(&broker.topic, QoS::AtLeastOnce) {
                    return Some(error.to_string());
                }
                tracing::info!("{name}: connected");
                *told = false;
            }
            Ok(Event::Incoming(Packet::Publish(message))) => {
                if !put_all(&message.payload, &format!("{name} {}", message.topic), inlet) {
                    return None;
                }
            }
            Ok(_) => {}
            Err(error) => return Some(error.to_string()),
        }
    }
    Some("the connection has ended".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::{Feed, Live};
    use railgrip_filter::PlantKind;
    use railgrip_messages::SourceCount;
    use std::time::Instant;

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
