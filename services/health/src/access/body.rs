//! Bodies: those of requests, taken in whole with a limit of size and time; and streams of answers, which end when the
//! one who listens may not listen any more.

use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, header};
use http_body_util::{BodyExt, LengthLimitError, Limited};
use hyper::body::{Body as HttpBody, Frame, SizeHint};
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

/// A stream is asked whether it may go on at least so often.
const RECHECK: Duration = Duration::from_secs(10);

/// Why the body of a request was not taken.
pub(super) enum Unread {
    TooLarge,
    TooSlow,
    Broken,
}

/// Takes in a body whole.
pub(super) async fn read(
    headers: &HeaderMap,
    body: Body,
    max_bytes: usize,
    patience: Duration,
) -> Result<Body, Unread> {
    if HttpBody::is_end_stream(&body) {
        return Ok(body);
    }
    let announced = headers.get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse().ok());
    if announced.is_some_and(|length: u64| length > max_bytes as u64) {
        return Err(Unread::TooLarge);
    }
    match tokio::time::timeout(patience, Limited::new(body, max_bytes).collect()).await {
        Ok(Ok(whole)) => Ok(Body::from(whole.to_bytes())),
        Ok(Err(error)) if error.is::<LengthLimitError>() => Err(Unread::TooLarge),
        Ok(Err(_)) => Err(Unread::Broken),
        Err(_) => Err(Unread::TooSlow),
    }
}

/// A stream that is asked now and then whether it may go on.
pub(super) struct Watched<F> {
    body: Body,
    generation: F,
    may_go_on: Box<dyn Fn() -> bool + Send>,
    seen: u64,
    next: Instant,
}

impl<F: Fn() -> u64> Watched<F> {
    /// `generation` tells cheaply that something changed, `may_go_on` what that means for this stream.
    pub(super) fn new(body: Body, generation: F, may_go_on: Box<dyn Fn() -> bool + Send>) -> Self {
        let seen = generation();
        Self { body, generation, may_go_on, seen, next: Instant::now() + RECHECK }
    }

    fn is_over(&mut self) -> bool {
        let (generation, now) = ((self.generation)(), Instant::now());
        if generation == self.seen && now < self.next {
            return false;
        }
        self.seen = generation;
        self.next = now + RECHECK;
        !(self.may_go_on)()
    }
}

impl<F: Fn() -> u64 + Unpin> HttpBody for Watched<F> {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        if self.is_over() {
            return Poll::Ready(None);
        }
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        HttpBody::size_hint(&self.body)
    }
}
