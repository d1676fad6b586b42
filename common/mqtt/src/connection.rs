//! Logging in, publishing, listening.

use crate::line::{Stream, meaning};
use crate::{Broker, MqttError, tls};
use bytes::{Bytes, BytesMut};
use rumqttc::mqttbytes::v4::{
    Connect, ConnectReturnCode, Login, Packet, PubAck, Publish, Subscribe, SubscribeReasonCode,
};
use rumqttc::mqttbytes::{Error as PacketError, QoS};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Largest packet, bytes.
const LARGEST: usize = 1 << 20;
/// Bytes read at once.
const PORTION: usize = 16 << 10;
/// Longest time that sending may take, when the broker takes nothing.
const SENDING: Duration = Duration::from_secs(10);
/// Packets that a broker may send in place of the answer that we wait for.
const MOST_UNASKED: usize = 1000;
/// First byte of a record of TLS that tells of a mistake; a broker never sends an MQTT packet that begins so.
const TLS_ALERT: u8 = 0x15;

/// A connection on which the broker has let us in.
pub struct Connection {
    stream: Stream,
    keep_alive: Duration,
    incoming: BytesMut,
    outgoing: BytesMut,
    portion: Box<[u8; PORTION]>,
    /// When something last came, and when something was last sent.
    heard: Instant,
    sent: Instant,
    /// Identifier of the packet before.
    packet_id: u16,
}

/// What a broker tells whoever listens.
#[derive(Debug)]
pub enum News {
    /// It will hand out the topic.
    Subscribed,
    /// A message.
    Message(Publish),
    /// Nothing so far.
    None,
}

impl Connection {
    /// Connects and logs in, until `until` at the latest and until `stop` is set, which whatever is done later looks at, too.
    /// `keep_alive` is the longest time without a sign of life.
    ///
    /// # Errors
    /// A password or authorities that cannot be read, a broker that is not there, is not who it should be, or lets nobody in.
    pub fn open(
        broker: &Broker<'_>,
        keep_alive: Duration,
        until: Instant,
        stop: &Arc<AtomicBool>,
    ) -> Result<Self, MqttError> {
        let login = login(broker)?;
        let tls = broker.tls.map(tls::config).transpose()?;
        let stream = Stream::open(broker.host, broker.port, tls, until, stop)?;
        let now = Instant::now();
        let mut connection = Self {
            stream,
            keep_alive,
            incoming: BytesMut::new(),
            outgoing: BytesMut::new(),
            portion: Box::new([0; PORTION]),
            heard: now,
            sent: now,
            packet_id: 0,
        };
        let mut connect = Connect::new(broker.client_id);
        connect.keep_alive = u16::try_from(keep_alive.as_secs()).unwrap_or(u16::MAX);
        connect.login = login;
        connection.send(&Packet::Connect(connect), until)?;
        connection.let_in(until)?;
        Ok(connection)
    }

    /// Waits for the answer to the login.
    fn let_in(&mut self, until: Instant) -> Result<(), MqttError> {
        let unanswered =
            |error| if matches!(error, MqttError::Closed) { MqttError::Unanswered } else { error };
        self.fill(until).map_err(unanswered)?;
        if self.incoming.first() == Some(&TLS_ALERT) {
            return Err(MqttError::SpeaksTls);
        }
        match self.packet(until).map_err(unanswered)? {
            Packet::ConnAck(answer) if answer.code == ConnectReturnCode::Success => Ok(()),
            Packet::ConnAck(answer) => Err(MqttError::Login(answer.code)),
            _ => Err(MqttError::Unasked),
        }
    }

    /// Publishes with quality of service 1 and waits until `until` for the broker's confirmation.
    ///
    /// # Errors
    /// No confirmation; the connection is of no use then.
    pub fn publish(
        &mut self,
        topic: &str,
        body: &[u8],
        retain: bool,
        until: Instant,
    ) -> Result<(), MqttError> {
        let mut publish = Publish::from_bytes(topic, QoS::AtLeastOnce, Bytes::copy_from_slice(body));
        publish.retain = retain;
        publish.pkid = self.next_id();
        let confirmation = Packet::PubAck(PubAck::new(publish.pkid));
        self.send(&Packet::Publish(publish), until)?;
        for _ in 0..MOST_UNASKED {
            if self.packet(until)? == confirmation {
                return Ok(());
            }
        }
        Err(MqttError::Unasked)
    }

    /// Asks for the messages of a topic, with quality of service 1 at most. They come as [`News`].
    ///
    /// # Errors
    /// The connection is broken.
    pub fn subscribe(&mut self, filter: &str) -> Result<(), MqttError> {
        let mut subscribe = Subscribe::new(filter, QoS::AtLeastOnce);
        subscribe.pkid = self.next_id();
        self.send(&Packet::Subscribe(subscribe), Instant::now() + SENDING)
    }

    /// Waits for news, `patience` at the longest, and keeps the connection alive. A message is confirmed when the next news are asked
    /// for: by then it has been taken.
    ///
    /// # Errors
    /// The connection is broken, or the broker refuses the topic.
    pub fn news(&mut self, patience: Duration) -> Result<News, MqttError> {
        let until = Instant::now() + patience;
        loop {
            if self.sent.elapsed() >= self.keep_alive {
                self.send(&Packet::PingReq, Instant::now() + SENDING)?;
            }
            match self.buffered()? {
                Some(Packet::Publish(message)) => {
                    if message.qos != QoS::AtMostOnce {
                        self.queue(&Packet::PubAck(PubAck::new(message.pkid)))?;
                    }
                    return Ok(News::Message(message));
                }
                Some(Packet::SubAck(answer)) => {
                    let refused = answer.return_codes.contains(&SubscribeReasonCode::Failure);
                    return if refused { Err(MqttError::Subscription) } else { Ok(News::Subscribed) };
                }
                Some(_) => {}
                None => {
                    self.flush(Instant::now() + SENDING)?;
                    match self.fill(until) {
                        Err(MqttError::Late) if self.heard.elapsed() > 2 * self.keep_alive => {
                            return Err(MqttError::Silent);
                        }
                        Err(MqttError::Late) => return Ok(News::None),
                        filled => filled?,
                    }
                }
            }
            if Instant::now() >= until {
                return Ok(News::None);
            }
        }
    }

    /// The next packet, until `until` at the latest, however many there are.
    fn packet(&mut self, until: Instant) -> Result<Packet, MqttError> {
        loop {
            if Instant::now() >= until {
                return Err(MqttError::Late);
            }
            match self.buffered()? {
                Some(packet) => return Ok(packet),
                None => self.fill(until)?,
            }
        }
    }

    /// A packet that has come as a whole.
    fn buffered(&mut self) -> Result<Option<Packet>, MqttError> {
        match Packet::read(&mut self.incoming, LARGEST) {
            Ok(packet) => Ok(Some(packet)),
            Err(PacketError::InsufficientBytes(_)) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Takes in more bytes.
    fn fill(&mut self, until: Instant) -> Result<(), MqttError> {
        self.stream.set_deadline(until);
        match self.stream.read(&mut self.portion[..]).map_err(meaning)? {
            0 => Err(MqttError::Closed),
            count => {
                self.incoming.extend_from_slice(&self.portion[..count]);
                self.heard = Instant::now();
                Ok(())
            }
        }
    }

    fn send(&mut self, packet: &Packet, until: Instant) -> Result<(), MqttError> {
        self.queue(packet)?;
        self.flush(until)
    }

    fn queue(&mut self, packet: &Packet) -> Result<(), MqttError> {
        packet.write(&mut self.outgoing, LARGEST)?;
        Ok(())
    }

    fn flush(&mut self, until: Instant) -> Result<(), MqttError> {
        if self.outgoing.is_empty() {
            return Ok(());
        }
        self.stream.set_deadline(until);
        self.stream.write(&self.outgoing).map_err(meaning)?;
        self.outgoing.clear();
        self.sent = Instant::now();
        Ok(())
    }

    /// Identifiers are never 0.
    fn next_id(&mut self) -> u16 {
        self.packet_id = self.packet_id.checked_add(1).unwrap_or(1);
        self.packet_id
    }
}

/// User and password, read now, so that a new one holds from the next connection on.
fn login(broker: &Broker<'_>) -> Result<Option<Login>, MqttError> {
    let Some(user) = broker.user else { return Ok(None) };
    let password = match broker.password_file {
        Some(file) => std::fs::read_to_string(file)
            .map_err(|source| MqttError::Password { file: file.to_owned(), source })?,
        None => String::new(),
    };
    Ok(Some(Login::new(user, password.trim())))
}
