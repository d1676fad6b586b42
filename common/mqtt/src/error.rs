//! What can go wrong with a broker.

use rumqttc::mqttbytes;
use rumqttc::mqttbytes::v4::ConnectReturnCode;
use std::io;
use std::path::PathBuf;

/// What can go wrong with a broker.
#[derive(Debug, thiserror::Error)]
pub enum MqttError {
    /// The password cannot be read.
    #[error("{}: {source}", file.display())]
    Password {
        /// Where it should be.
        file: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The authorities cannot be read.
    #[error("{}: {problem}", file.display())]
    Authorities {
        /// Where they should be.
        file: PathBuf,
        /// What is wrong there.
        problem: String,
    },
    /// No certificate can be for such a host.
    #[error("no certificate can be for a host \"{0}\"")]
    Host(String),
    /// Nobody is there, or the connection broke.
    #[error("{0}")]
    Socket(io::Error),
    /// The broker is not who it should be.
    #[error("the broker's certificate is refused: {0}")]
    Certificate(rustls::CertificateError),
    /// There is no TLS with whoever is there.
    #[error("no TLS with the broker: {0}")]
    Tls(String),
    /// Plain text was answered by TLS.
    #[error("the broker speaks TLS on this port: tls = true")]
    SpeaksTls,
    /// The connection has ended.
    #[error("the broker has closed the connection")]
    Closed,
    /// The connection has ended before the broker said anything.
    #[error("the broker has closed the connection without an answer; it may want TLS on this port, or none")]
    Unanswered,
    /// The broker lets too much time pass.
    #[error("the broker did not confirm in time")]
    Late,
    /// The broker has been silent for too long.
    #[error("the broker gives no sign of life")]
    Silent,
    /// The broker sends what nobody asked for in place of an answer.
    #[error("the broker does not confirm, and sends what nobody asked for")]
    Unasked,
    /// The broker does not want us.
    #[error("the broker refuses the login: {0:?}")]
    Login(ConnectReturnCode),
    /// The broker does not hand out the topic.
    #[error("the broker refuses the subscription")]
    Subscription,
    /// What is sent or received is no MQTT.
    #[error("{0}")]
    Packet(#[from] mqttbytes::Error),
    /// We were asked to stop.
    #[error("stopped")]
    Stopped,
}
