//! Room in memory for long answers: each holds its share until its reader has taken it or is gone, so that many slow readers of long
//! answers cannot fill the memory. Who finds no room waits a while, and is then asked to come back.

use crate::api::problem::Problem;
use axum::body::{Body, Bytes};
use axum::http::StatusCode;
use axum::response::Response;
use hyper::body::{Body as HttpBody, Frame, SizeHint};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;

/// Shares are of so many bytes.
const SHARE_BYTES: usize = 1024;
/// How long a request waits for room.
const PATIENCE: Duration = Duration::from_secs(10);

/// Room for answers.
#[derive(Debug)]
pub(crate) struct Room {
    shares: Arc<Semaphore>,
    all: usize,
    patience: Duration,
}

/// The room of one answer.
#[derive(Debug, Clone)]
pub(crate) struct Taken {
    _shares: Arc<OwnedSemaphorePermit>,
}

impl Room {
    /// So many bytes for all answers together.
    pub fn new(bytes: usize) -> Self {
        let all = bytes / SHARE_BYTES;
        Self { shares: Arc::new(Semaphore::new(all)), all, patience: PATIENCE }
    }

    /// Takes room for an answer of about so many bytes; one that is longer than all of it gets all of it.
    pub async fn take(&self, bytes: usize) -> Result<Taken, Problem> {
        let shares = bytes.div_ceil(SHARE_BYTES).min(self.all);
        let wanted = Arc::clone(&self.shares).acquire_many_owned(u32::try_from(shares).unwrap_or(u32::MAX));
        match timeout(self.patience, wanted).await {
            Ok(Ok(shares)) => Ok(Taken { _shares: Arc::new(shares) }),
            _ => {
                let detail = "too many long answers wait for their readers; come back later, or ask for fewer steps or fields";
                Err(Problem::new(StatusCode::SERVICE_UNAVAILABLE, detail))
            }
        }
    }
}

/// Has the body of an answer hold the room that was taken for it.
pub(super) fn hold(response: Response) -> Response {
    let (mut parts, body) = response.into_parts();
    match parts.extensions.remove::<Taken>() {
        None => Response::from_parts(parts, body),
        Some(room) => {
            Response::from_parts(parts, Body::new(Holding { body, rest: Bytes::new(), _room: room }))
        }
    }
}

/// Longest piece that the connection gets at once. One that took a whole answer would let go of the body, and of its room, long
/// before the reader has it.
const PIECE_BYTES: usize = 32 * 1024;

/// A body with its room, handed on in pieces.
struct Holding {
    body: Body,
    rest: Bytes,
    _room: Taken,
}

impl HttpBody for Holding {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        if self.rest.is_empty() {
            match ready!(Pin::new(&mut self.body).poll_frame(context)) {
                Some(Ok(frame)) => match frame.into_data() {
                    Ok(data) => self.rest = data,
                    Err(other) => return Poll::Ready(Some(Ok(other))),
                },
                ended => return Poll::Ready(ended),
            }
        }
        let length = self.rest.len().min(PIECE_BYTES);
        Poll::Ready(Some(Ok(Frame::data(self.rest.split_to(length)))))
    }

    fn is_end_stream(&self) -> bool {
        self.rest.is_empty() && self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        let (rest, body) = (self.rest.len() as u64, HttpBody::size_hint(&self.body));
        let mut hint = SizeHint::new();
        hint.set_lower(rest + body.lower());
        if let Some(upper) = body.upper() {
            hint.set_upper(rest + upper);
        }
        hint
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::response::IntoResponse;

    #[tokio::test]
    async fn an_answer_holds_its_room_until_its_body_is_gone() {
        let room = Room { patience: Duration::from_millis(20), ..Room::new(10 * SHARE_BYTES) };
        let answer = async |bytes: usize| {
            let taken = room.take(bytes).await?;
            let mut response = "long".into_response();
            response.extensions_mut().insert(taken);
            Ok::<_, Problem>(hold(response))
        };
        let first = answer(7000).await.expect("room");
        assert_eq!((first.body().size_hint().exact(), room.shares.available_permits()), (Some(4), 3));
        let second = answer(5000).await.expect_err("no room for both");
        assert_eq!(second.status, 503);
        let small = answer(2000).await.expect("room for a short one");
        drop(first);
        let longest = answer(1 << 30);
        drop(small);
        assert!(longest.await.is_ok() && room.shares.available_permits() == 10);
    }

    /// A connection that got the whole answer at once once let go of its room before the reader had taken a byte.
    #[tokio::test]
    async fn a_long_answer_comes_in_pieces_and_is_whole() {
        let room = Room::new(10 * SHARE_BYTES);
        let long: Vec<u8> = (0..200_000_u32).map(|n| n as u8).collect();
        let mut response = long.clone().into_response();
        response.extensions_mut().insert(room.take(5000).await.expect("room"));
        let mut body = hold(response).into_body();
        assert_eq!(body.size_hint().exact(), Some(200_000));
        let (mut whole, mut pieces) = (Vec::new(), 0);
        while let Some(frame) = std::future::poll_fn(|context| Pin::new(&mut body).poll_frame(context)).await
        {
            let piece = frame.expect("frame").into_data().expect("data");
            assert!(piece.len() <= PIECE_BYTES && room.shares.available_permits() == 5);
            whole.extend_from_slice(&piece);
            pieces += 1;
        }
        assert!(whole == long && pieces == 7);
        drop(body);
        assert_eq!(room.shares.available_permits(), 10);
    }
}
