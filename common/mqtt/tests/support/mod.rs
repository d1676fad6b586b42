//! A broker of a test's own (MQTT 3.1.1), plain or by TLS, that behaves as badly as it is told to. The tests of whoever uses
//! brokers include this file.
#![allow(dead_code, reason = "no test uses all of it")]

use bytes::BytesMut;
use rcgen::{BasicConstraints, CertificateParams, IsCa, Issuer, KeyPair};
use rumqttc::mqttbytes::QoS;
use rumqttc::mqttbytes::v4::{
    ConnAck, ConnectReturnCode, Packet, PingResp, PubAck, Publish, SubAck, SubscribeReasonCode,
};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::{PrivateKeyDer, PrivatePkcs8KeyDer};
use tokio_rustls::rustls::{ServerConfig, ServerConnection, StreamOwned};

/// How a broker behaves once it has let somebody in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Manner {
    /// Confirms everything; hands these messages to whoever subscribes.
    Good(Vec<String>),
    /// Sends without pause what nobody asked for, and confirms nothing.
    Floods,
    /// The same, a packet now and then.
    Trickles,
    /// Takes everything and says nothing more.
    Silent,
    /// Lets nobody in.
    Closed,
    /// Answers the login byte by byte, and never ends.
    Drips,
}

/// What a broker has seen.
pub struct FakeBroker {
    pub port: u16,
    /// Connections so far.
    pub connections: Arc<AtomicUsize>,
    /// Packets that it has read, but for what it read while it flooded.
    pub seen: Arc<Mutex<Vec<Packet>>>,
}

impl FakeBroker {
    pub fn start(tls: Option<Arc<ServerConfig>>, manner: Manner) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let (connections, seen) = (Arc::new(AtomicUsize::new(0)), Arc::new(Mutex::new(Vec::new())));
        let (counted, kept) = (Arc::clone(&connections), Arc::clone(&seen));
        std::thread::spawn(move || {
            for socket in listener.incoming() {
                let socket = socket.unwrap();
                counted.fetch_add(1, Ordering::Relaxed);
                let (tls, manner, seen) = (tls.clone(), manner.clone(), Arc::clone(&kept));
                std::thread::spawn(move || {
                    let stream: Box<dyn Stream> = match tls {
                        Some(config) => {
                            Box::new(StreamOwned::new(ServerConnection::new(config).unwrap(), socket))
                        }
                        None => Box::new(socket),
                    };
                    // Who is refused, or has heard enough, hangs up.
                    let _ = serve(stream, &manner, &seen);
                });
            }
        });
        Self { port, connections, seen }
    }

    /// The messages that were published there, topic and body.
    pub fn published(&self) -> Vec<(String, Vec<u8>)> {
        let of = |packet: &Packet| match packet {
            Packet::Publish(publish) => Some((publish.topic.clone(), publish.payload.to_vec())),
            _ => None,
        };
        self.seen.lock().unwrap().iter().filter_map(of).collect()
    }
}

trait Stream: Read + Write {}
impl Stream for TcpStream {}
impl Stream for StreamOwned<ServerConnection, TcpStream> {}

fn serve(mut stream: Box<dyn Stream>, manner: &Manner, seen: &Mutex<Vec<Packet>>) -> std::io::Result<()> {
    let (mut incoming, mut portion) = (BytesMut::new(), [0; 4096]);
    loop {
        let Ok(packet) = Packet::read(&mut incoming, 1 << 20) else {
            let count = stream.read(&mut portion)?;
            if count == 0 {
                return Ok(());
            }
            incoming.extend_from_slice(&portion[..count]);
            continue;
        };
        seen.lock().unwrap().push(packet.clone());
        let mut answer = BytesMut::new();
        match packet {
            Packet::Connect(_) if *manner == Manner::Drips => {
                // A packet of a million bytes begins.
                stream.write_all(&[0x30, 0xff, 0xff, 0x3f])?;
                loop {
                    stream.write_all(&[0])?;
                    stream.flush()?;
                    std::thread::sleep(Duration::from_millis(20));
                }
            }
            Packet::Connect(_) => {
                let code = match manner {
                    Manner::Closed => ConnectReturnCode::NotAuthorized,
                    _ => ConnectReturnCode::Success,
                };
                ConnAck::new(code, false).write(&mut answer).unwrap();
            }
            Packet::Subscribe(subscribe) => {
                let granted = vec![SubscribeReasonCode::Success(QoS::AtLeastOnce)];
                SubAck::new(subscribe.pkid, granted).write(&mut answer).unwrap();
                if let Manner::Good(messages) = manner {
                    for (number, message) in messages.iter().enumerate() {
                        let topic = &subscribe.filters[0].path;
                        let mut publish = Publish::new(topic, QoS::AtLeastOnce, message.as_bytes());
                        publish.pkid = u16::try_from(number + 1).unwrap();
                        publish.write(&mut answer).unwrap();
                    }
                }
            }
            Packet::Publish(publish) if matches!(manner, Manner::Good(_)) => {
                PubAck::new(publish.pkid).write(&mut answer).unwrap();
            }
            Packet::PingReq if *manner != Manner::Silent => {
                PingResp.write(&mut answer).unwrap();
            }
            _ => {}
        }
        stream.write_all(&answer)?;
        stream.flush()?;
        let unasked = |many: usize| {
            let mut packets = BytesMut::new();
            let publish = Publish::new("railgrip/x", QoS::AtMostOnce, "what nobody asked for");
            (0..many).for_each(|_| drop(publish.write(&mut packets)));
            packets
        };
        match manner {
            Manner::Floods => loop {
                stream.write_all(&unasked(2000))?;
                stream.flush()?;
            },
            Manner::Trickles => loop {
                stream.write_all(&unasked(1))?;
                stream.flush()?;
                std::thread::sleep(Duration::from_millis(20));
            },
            _ => {}
        }
    }
}

/// An authority of a test's own.
pub struct Authority(Issuer<'static, KeyPair>, String);

impl Authority {
    pub fn new() -> Self {
        let mut params = CertificateParams::new(Vec::new()).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        let key = KeyPair::generate().unwrap();
        let pem = params.self_signed(&key).unwrap().pem();
        Self(Issuer::new(params, key), pem)
    }

    /// Its certificate, as a file holds it.
    pub fn pem(&self) -> &str {
        &self.1
    }

    /// A server that it vouches for under these names.
    pub fn server(&self, names: &[&str]) -> Arc<ServerConfig> {
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        let key = KeyPair::generate().unwrap();
        let certificate = CertificateParams::new(names).unwrap().signed_by(&key, &self.0).unwrap();
        let key = PrivateKeyDer::Pkcs8(PrivatePkcs8KeyDer::from(key.serialize_der()));
        let config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()
            .unwrap()
            .with_no_client_auth()
            .with_single_cert(vec![certificate.der().clone()], key)
            .unwrap();
        Arc::new(config)
    }
}
