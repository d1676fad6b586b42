//! A connection to an MQTT broker (3.1.1), plain or by TLS, that no broker can hold.
//!
//! Packets are read and written by `rumqttc`; the connection is our own. That of `rumqttc` goes on for as long as a broker sends,
//! whatever timeout it is given, and its TLS brings crates that nobody maintains. Here every read and write ends at its deadline,
//! and soon after it is asked to stop; a broker that sends what nobody asked for is given up after a number of packets.
//!
//! - `line`: the socket with its deadline
//! - `tls`: whom we believe to be the broker
//! - [`Connection`]: logging in, publishing, listening

mod connection;
mod error;
mod line;
mod tls;

pub use connection::{Connection, News};
pub use error::MqttError;
pub use rumqttc::mqttbytes::v4::Publish;
pub use tls::Authorities;

use std::path::Path;

/// A broker, and who we are there.
#[derive(Debug, Clone, Copy)]
pub struct Broker<'a> {
    /// Its name or address; with TLS its certificate is for this.
    pub host: &'a str,
    /// Its port.
    pub port: u16,
    /// Under which name we are known there.
    pub client_id: &'a str,
    /// User, where it asks for one.
    pub user: Option<&'a str>,
    /// File with the user's password.
    pub password_file: Option<&'a Path>,
    /// How it proves who it is; without, the connection is plain text.
    pub tls: Option<Authorities<'a>>,
}
