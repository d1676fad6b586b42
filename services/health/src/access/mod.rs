//! Who may use the HTTP service, what they may do, and how much of it one client can take.
//!
//! [`guard`] stands around the router of the service, [`serve`] around its sockets; no handler knows of
//! either. A request passes, in this order: the limit of its client, the name it was sent to, its token or session, the
//! role that its route asks for, the origin of the page that sent it, and the size and pace of its body. Everything that
//! changes something and everything that is turned away is written to the audit log.
//!
//! # Glossary
//! * **token**: 256 random bits that stand for a person or a machine; kept as their SHA-256 only.
//! * **role**: `read`, `acknowledge` or `admin`; each may what the one before may.
//! * **session**: what a browser gets for a token: a signed cookie that names the token and ends with it.
//! * **client**: an IPv4 address, or the 64 leading bits of an IPv6 address.

mod audit;
mod audit_file;
mod body;
mod control;
mod cookie;
mod cors;
mod error;
mod guard;
mod headers;
mod limit;
mod listen;
mod local;
mod login;
mod origin;
mod peer;
pub(crate) mod records;
mod refusal;
mod role;
mod seats;
mod session;
mod stall;
mod tls;
pub mod tokens;
pub(crate) mod whoami;

pub use control::Access;
pub use error::AccessError;
pub use guard::guard;
pub use listen::serve;
pub use local::LocalSocket;
pub use peer::Peer;
pub use role::{Identity, Role};
