//! What decides who may come in: certificate, tokens, sessions, limits and the audit log of one service.

use crate::access::audit::Audit;
use crate::access::cookie;
use crate::access::error::AccessError;
use crate::access::limit::{Client, Limiter};
use crate::access::peer::Peer;
use crate::access::refusal::Refusal;
use crate::access::role::{Identity, Proof, Role};
use crate::access::session::Sessions;
use crate::access::tls::Tls;
use crate::access::tokens::{self, TokenBook};
use crate::time::unix_s;
use axum::http::{HeaderMap, HeaderValue, header};
use railgrip_settings::{AccessSettings, TrainSettings, is_loopback};
use std::net::IpAddr;
use std::sync::Arc;
use std::time::Instant;

/// What a wrong token costs of a client's bucket, in requests.
const WRONG_TOKEN_COST: f64 = 10.0;

/// Access to one service. Clones share.
#[derive(Clone)]
pub struct Access {
    pub(super) inner: Arc<Inner>,
}

pub(super) struct Inner {
    pub(super) settings: AccessSettings,
    pub(super) cors_origins: Vec<String>,
    pub(super) tls: Option<Tls>,
    pub(super) tokens: Option<TokenBook>,
    pub(super) sessions: Sessions,
    pub(super) limiter: Limiter,
    pub(super) audit: Audit,
}

impl Access {
    /// Opens certificate, tokens and audit log.
    ///
    /// # Errors
    /// A certificate, key or token file that cannot be used.
    pub fn open(settings: &TrainSettings) -> Result<Self, AccessError> {
        let access = settings.access.clone();
        let listen = settings.http.listen;
        let loopback = is_loopback(listen.ip());
        let tls = access.tls.as_ref().map(Tls::load).transpose()?;
        let tokens = access.token_file.as_deref().map(TokenBook::open).transpose()?;
        if !loopback && (tls.is_none() || tokens.is_none()) {
            let tls = if tls.is_none() { "without TLS" } else { "with TLS" };
            let tokens = if tokens.is_none() { "without tokens" } else { "with tokens" };
            tracing::error!(
                "INSECURE: {listen} is open to other machines {tls} and {tokens}, because [http] allow_insecure says so"
            );
        }
        let key_file = settings.instance.dir.join("session.key");
        let sessions = Sessions::open(&key_file, access.session)
            .map_err(|source| AccessError::File { file: key_file, source })?;
        let limiter = Limiter::new(access.limits.requests_per_s, access.limits.burst);
        let audit = Audit::start(&access.audit, &settings.name);
        let cors_origins = settings.http.cors_origins.clone();
        let inner = Inner { settings: access, cors_origins, tls, tokens, sessions, limiter, audit };
        Ok(Self { inner: Arc::new(inner) })
    }

    /// Checks what [`Access::open`] would read, and that somebody could come in; opens nothing.
    ///
    /// # Errors
    /// What is wrong, and how it is put right.
    pub fn check(settings: &TrainSettings) -> Result<(), AccessError> {
        Self::wrong(settings).into_iter().next().map_or(Ok(()), |(_, error)| Err(error))
    }

    /// Everything that is wrong with what [`Access::open`] would read, each with the key that names it.
    #[must_use]
    pub fn wrong(settings: &TrainSettings) -> Vec<(&'static str, AccessError)> {
        let tls = settings.access.tls.as_ref().and_then(|files| Tls::load(files).err());
        let tokens = settings.access.token_file.as_ref().and_then(|file| match tokens::read(file) {
            Ok(tokens) if tokens.iter().any(|token| token.usable(unix_s())) => None,
            Ok(_) => Some(AccessError::NoToken { file: file.clone() }),
            Err(error) => Some(error),
        });
        let tls = tls.map(|error| ("http.tls", error));
        tls.into_iter().chain(tokens.map(|error| ("http.token_file", error))).collect()
    }

    /// `https` or `http`.
    #[must_use]
    pub fn scheme(&self) -> &'static str {
        if self.inner.tls.is_some() { "https" } else { "http" }
    }

    /// True if the plain address does not let everybody on this machine in, so that this user needs a socket of its own.
    #[must_use]
    pub fn needs_local_socket(&self) -> bool {
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

    /// The peer, and for whom it asks if it is a proxy. One that we were not told of is believed nothing, and its clients share
    /// one bucket: it would else be a way around all limits, since it runs on this machine.
    pub(super) fn seen_through(&self, peer: Peer, headers: &HeaderMap) -> Peer {
        let Some(address) = peer.address else { return peer };
        let is_known = self.inner.settings.proxies.contains(&address.ip().to_canonical());
        let forwarded = headers.get_all("x-forwarded-for").iter().next_back();
        // The last is what the proxy itself saw; those before it anybody can invent.
        let last =
            |value: &HeaderValue| value.to_str().ok()?.rsplit(',').next()?.trim().parse::<IpAddr>().ok();
        let behind = match forwarded {
            Some(value) if is_known => last(value).or(Some(address.ip())),
            Some(_) => Some(address.ip()),
            None if headers.contains_key(header::FORWARDED) => Some(address.ip()),
            None => None,
        };
        Peer { behind, ..peer }
    }

    /// Whose limits hold for this one; `None` where none do.
    pub(super) fn limited(&self, peer: &Peer) -> Option<Client> {
        let address = peer.address?.ip();
        let near = is_loopback(address) && !self.inner.settings.limits.on_loopback;
        peer.behind.or((!near).then_some(address)).map(Client::of)
    }

    /// Takes from the bucket of a client.
    pub(super) fn charge(&self, peer: &Peer, cost: f64) -> Result<(), Refusal> {
        let Some(client) = self.limited(peer) else { return Ok(()) };
        self.inner.limiter.take(client, cost, Instant::now()).map_err(Refusal::TooMany)
    }

    /// Lets a client pay for a wrong token, whether or not its bucket holds so much.
    pub(super) fn fine(&self, peer: &Peer) {
        if let Some(client) = self.limited(peer) {
            self.inner.limiter.fine(client, WRONG_TOKEN_COST, Instant::now());
        }
    }

    /// Who asks.
    pub(super) fn identify(&self, peer: &Peer, headers: &HeaderMap) -> Result<Identity, Stranger> {
        if peer.address.is_none() {
            return Ok(Identity { name: "local".into(), role: Role::Admin, by: Proof::Local });
        }
        let Some(tokens) = &self.inner.tokens else {
            return Ok(Identity { name: "anyone".into(), role: Role::Admin, by: Proof::None });
        };
        let now_s = unix_s();
        if let Some(value) = headers.get(header::AUTHORIZATION) {
            let text = value.to_str().map_err(|_| Stranger::Wrong)?;
            let (kind, secret) = text.split_once(' ').ok_or(Stranger::Wrong)?;
            let found =
                tokens.of_secret(secret.trim(), now_s).filter(|_| kind.eq_ignore_ascii_case("bearer"));
            let token = found.ok_or(Stranger::Wrong)?;
            return Ok(Identity { name: token.name.into(), role: token.role, by: Proof::Token });
        }
        let session = cookie::session(headers, self.scheme() == "https").ok_or(Stranger::Silent)?;
        let owner = self.inner.sessions.owner(&session, &tokens.all(), now_s).ok_or(Stranger::Silent)?;
        Ok(Identity { name: owner.name.into(), role: owner.role, by: Proof::Session })
    }
}

/// Somebody whom we do not know.
pub(super) enum Stranger {
    /// Shows nothing, or a session that is over.
    Silent,
    /// Shows a token that is none.
    Wrong,
}
