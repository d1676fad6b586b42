//! Who is at the other end of a connection.

use std::fmt;
use std::net::{IpAddr, SocketAddr};

/// Who is at the other end of a connection.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Peer {
    /// Its address; none at the local socket and where a router is called without a socket.
    pub address: Option<SocketAddr>,
    /// True if TLS is spoken.
    pub tls: bool,
    /// For whom a proxy asks: whom limits go by. The address of the proxy where we do not know it for one.
    pub behind: Option<IpAddr>,
}

impl fmt::Display for Peer {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.address {
            Some(address) => match self.behind.filter(|behind| *behind != address.ip()) {
                Some(behind) => write!(out, "{behind} by {address}"),
                None => address.fmt(out),
            },
            None => out.write_str("local"),
        }
    }
}
