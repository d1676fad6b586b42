//! The sockets: accepts connections, speaks TLS where that is asked for, and loses patience with clients that dawdle.
//!
//! HTTP/1.1 only: the page needs one stream and a few requests, and HTTP/2 would add ways to overload a small computer.

use crate::access::control::Access;
use crate::access::local::LocalSocket;
use crate::access::peer::Peer;
use crate::access::seats::{Seat, Seats};
use crate::access::stall::Patient;
use axum::Router;
use axum::extract::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use railgrip_settings::is_loopback;
use rustix::net::sockopt::{set_socket_send_buffer_size, set_tcp_user_timeout};
use std::net::SocketAddr;
use std::pin::pin;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, watch};
use tokio::time::timeout;
use tower::Service;

/// Largest head of a request.
const MAX_HEAD_BYTES: usize = 16 * 1024;
/// What the kernel may keep for a client that does not read; more than any answer but an export needs at once.
const SEND_BUFFER_BYTES: usize = 64 * 1024;
/// How often certificate and tokens are looked at.
const LOOK_PERIOD: Duration = Duration::from_secs(1);
/// What a handshake costs of a client's bucket, in requests: about as much work as two.
const HANDSHAKE_COST: f64 = 2.0;
/// After a failed accept (no descriptors left, for example).
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// What every connection needs.
#[derive(Clone)]
struct House {
    router: Router,
    access: Access,
    seats: Seats,
    /// Of the socket in the folder of the train, which only its user can open: nobody else takes them.
    local_seats: Seats,
    closing: watch::Receiver<bool>,
    /// Dropped with the last connection.
    _alive: mpsc::Sender<()>,
}

/// Serves until `stopping` is done, then until every connection is. `local` is the socket of the user that owns its folder.
pub async fn serve(
    listener: TcpListener,
    local: Option<LocalSocket>,
    router: Router,
    access: Access,
    stopping: impl Future<Output = ()>,
) {
    let (close, closing) = watch::channel(false);
    let (alive, mut all_gone) = mpsc::channel(1);
    let limits = &access.inner.settings.limits;
    let seats = Seats::new(limits.connections, limits.connections_per_client);
    let local_seats = Seats::new(limits.connections, limits.connections);
    let house = House { router, access: access.clone(), seats, local_seats, closing, _alive: alive };
    let watcher = tokio::spawn(async move {
        loop {
            tokio::time::sleep(LOOK_PERIOD).await;
            access.look();
        }
    });
    let mut stopping = pin!(stopping);
    loop {
        tokio::select! {
            () = &mut stopping => break,
            accepted = listener.accept() => match accepted {
                Ok((stream, address)) => house.admit(stream, address),
                Err(error) => pause(&error).await,
            },
            accepted = accept_local(local.as_ref()) => match accepted {
                Ok(stream) => house.admit_local(stream),
                Err(error) => pause(&error).await,
            },
        }
    }
    watcher.abort();
    close.send_replace(true);
    drop((listener, local, house));
    let _ = all_gone.recv().await;
}

async fn accept_local(local: Option<&LocalSocket>) -> std::io::Result<tokio::net::UnixStream> {
    match local {
        Some(local) => local.accept().await,
        None => std::future::pending().await,
    }
}

async fn pause(error: &std::io::Error) {
    // A client that gives up between its call and our answer is no trouble of ours.
    if error.kind() != std::io::ErrorKind::ConnectionAborted {
        tracing::warn!("a connection cannot be accepted: {error}");
        tokio::time::sleep(ACCEPT_PAUSE).await;
    }
}

impl House {
    fn admit(&self, stream: TcpStream, address: SocketAddr) {
        let peer = Peer { address: Some(address), tls: self.access.inner.tls.is_some(), behind: None };
        let client = self.access.limited(&peer);
        let Some(seat) = self.seats.take(is_loopback(address.ip()), client) else {
            tracing::debug!(%address, "no seat is left");
            return;
        };
        if peer.tls && self.access.charge(&peer, HANDSHAKE_COST).is_err() {
            tracing::debug!(%address, "too many handshakes");
            return;
        }
        let limits = self.access.inner.settings.limits;
        prepare(&stream, client.is_some(), limits.stall);
        let stream = Patient::new(stream, limits.stall);
        let house = self.clone();
        tokio::spawn(async move {
            match house.access.inner.tls.as_ref().map(super::tls::Tls::acceptor) {
                None => house.talk(stream, peer, seat).await,
                Some(acceptor) => match timeout(limits.head, acceptor.accept(stream)).await {
                    Ok(Ok(stream)) => house.talk(stream, peer, seat).await,
                    Ok(Err(error)) => tracing::debug!(%peer, %error, "no TLS"),
                    Err(_) => tracing::debug!(%peer, "the handshake took too long"),
                },
            }
        });
    }

    fn admit_local(&self, stream: tokio::net::UnixStream) {
        let Some(seat) = self.local_seats.take(true, None) else { return };
        let stream = Patient::new(stream, self.access.inner.settings.limits.stall);
        let house = self.clone();
        tokio::spawn(async move { house.talk(stream, Peer::default(), seat).await });
    }

    /// Answers the requests of one connection.
    async fn talk<S: AsyncRead + AsyncWrite + Unpin>(mut self, stream: S, peer: Peer, seat: Seat) {
        let router = self.router.clone();
        let service = hyper::service::service_fn({
            let peer = peer.clone();
            move |mut request: Request<Incoming>| {
                request.extensions_mut().insert(peer.clone());
                router.clone().call(request)
            }
        });
        let mut builder = http1::Builder::new();
        builder.timer(TokioTimer::new()).header_read_timeout(self.access.inner.settings.limits.head);
        builder.max_buf_size(MAX_HEAD_BYTES);
        let mut connection = pin!(builder.serve_connection(TokioIo::new(stream), service));
        let closing = async {
            // An error says that the service is gone already.
            let _ = self.closing.wait_for(|closing| *closing).await;
        };
        let early = tokio::select! {
            ended = connection.as_mut() => Some(ended),
            () = closing => None,
        };
        let ended = match early {
            Some(ended) => ended,
            None => {
                connection.as_mut().graceful_shutdown();
                connection.await
            }
        };
        if let Err(error) = ended {
            tracing::debug!(%peer, %error, "a connection broke off");
        }
        drop(seat);
    }
}

/// Has the kernel keep little for a client that we do not trust, and give up on one that is gone.
fn prepare(stream: &TcpStream, limited: bool, stall: Duration) {
    let _ = stream.set_nodelay(true);
    let stall_ms = u32::try_from(stall.as_millis()).unwrap_or(u32::MAX);
    let mut result = set_tcp_user_timeout(stream, stall_ms);
    if limited {
        result = result.and(set_socket_send_buffer_size(stream, SEND_BUFFER_BYTES));
    }
    if let Err(error) = result {
        tracing::debug!(%error, "a socket keeps its settings");
    }
}
