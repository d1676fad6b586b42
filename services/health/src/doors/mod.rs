//! The doors of the HTTP service: who comes in, what they may do, and how much of the service one client can take.
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

mod access;
mod audit;
mod body;
mod cors;
mod error;
mod guard;
mod headers;
mod limit;
mod listen;
mod local;
mod login;
mod origin;
pub(crate) mod records;
mod seats;
mod session;
mod stall;
mod tls;
pub mod tokens;

use crate::doors::audit::Audit;
use crate::doors::limit::Limiter;
use crate::doors::session::Sessions;
use crate::doors::tls::Tls;
use crate::doors::tokens::TokenBook;
use railgrip_settings::{DoorSettings, TrainSettings, is_loopback};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

pub use access::{Identity, Role};
pub use error::DoorError;
pub use guard::guard;
pub use listen::{Peer, serve};
pub use local::LocalDoor;

/// The doors of one service. Clones share.
#[derive(Clone)]
pub struct Doors {
    inner: Arc<Inner>,
}

struct Inner {
    settings: DoorSettings,
    cors_origins: Vec<String>,
    tls: Option<Tls>,
    tokens: Option<TokenBook>,
    sessions: Sessions,
    limiter: Limiter,
    audit: Audit,
}

impl Doors {
    /// Opens certificate, tokens and audit log.
    ///
    /// # Errors
    /// A certificate, key or token file that cannot be used.
    pub fn open(settings: &TrainSettings) -> Result<Self, DoorError> {
        let doors = settings.doors.clone();
        let listen = settings.http.listen;
        let loopback = is_loopback(listen.ip());
        let tls = doors.tls.as_ref().map(Tls::load).transpose()?;
        let tokens = doors.token_file.as_deref().map(TokenBook::open).transpose()?;
        if !loopback && (tls.is_none() || tokens.is_none()) {
            let tls = if tls.is_none() { "without TLS" } else { "with TLS" };
            let tokens = if tokens.is_none() { "without tokens" } else { "with tokens" };
            tracing::error!(
                "INSECURE: {listen} is open to other machines {tls} and {tokens}, because [http] allow_insecure says so"
            );
        }
        let key_file = settings.instance.dir.join("session.key");
        let sessions = Sessions::open(&key_file, doors.session)
            .map_err(|source| DoorError::File { file: key_file, source })?;
        let limiter = Limiter::new(doors.limits.requests_per_s, doors.limits.burst);
        let audit = Audit::start(&doors.audit, &settings.name);
        let cors_origins = settings.http.cors_origins.clone();
        let inner = Inner { settings: doors, cors_origins, tls, tokens, sessions, limiter, audit };
        Ok(Self { inner: Arc::new(inner) })
    }

    /// Checks what [`Doors::open`] would read, and that somebody could come in; opens nothing.
    ///
    /// # Errors
    /// What is wrong, and how it is put right.
    pub fn check(settings: &TrainSettings) -> Result<(), DoorError> {
        if let Some(files) = &settings.doors.tls {
            Tls::load(files)?;
        }
        if let Some(file) = &settings.doors.token_file
            && !tokens::read(file)?.iter().any(|token| token.usable(unix_s()))
        {
            return Err(DoorError::NoToken { file: file.clone() });
        }
        Ok(())
    }

    /// `https` or `http`.
    #[must_use]
    pub fn scheme(&self) -> &'static str {
        if self.inner.tls.is_some() { "https" } else { "http" }
    }

    /// True if the plain address does not let everybody on this machine in, so that a door for this user is needed.
    #[must_use]
    pub fn needs_local_door(&self) -> bool {
        self.inner.tls.is_some() || self.inner.tokens.is_some()
    }

    /// Reads certificate and tokens anew if their files changed.
    pub fn look(&self) {
        if let Some(tls) = &self.inner.tls
            && let Some(result) = tls.look()
        {
            self.inner
                .audit
                .event("tls_reload", result.as_ref().map_or_else(String::clone, |()| "ok".into()));
        }
        if let Some(tokens) = &self.inner.tokens
            && let Some(result) = tokens.look()
        {
            self.inner.audit.event("token_reload", result);
        }
    }

    /// True if the limits of one client hold for this one.
    fn limited(&self, peer: &Peer) -> bool {
        match peer.address {
            None => false,
            Some(address) => self.inner.settings.limits.on_loopback || !is_loopback(address.ip()),
        }
    }
}

/// Seconds since 1970.
pub(crate) fn unix_s() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_secs()).unwrap_or(i64::MAX)
}
