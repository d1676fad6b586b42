//! Server-sent events: first the whole picture, then what changes.

use crate::shared::{Shared, StreamEvent};
use axum::extract::State;
use axum::response::IntoResponse;
use axum::response::sse::{Event, KeepAlive, Sse};
use futures_util::stream;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::time::Duration;
use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::watch;

/// A comment is sent when nothing else was for this long, so that both ends notice a dead connection.
const KEEP_ALIVE: Duration = Duration::from_secs(10);

struct Client {
    shared: Shared,
    events: Receiver<StreamEvent>,
    closing: watch::Receiver<bool>,
    waiting: VecDeque<StreamEvent>,
}

/// Changes as they happen: `wagons` (all lines first, then those that changed), `train`, `alert`.
#[utoipa::path(get, path = "/api/v1/stream", tag = "stream", responses((
    status = 200, content_type = "text/event-stream", body = String,
    description = "Events `train` (TrainView), `wagons` (list of WagonRow), `alert` (Alert). The first of `train` and `wagons` \
                   are complete; later `wagons` hold the lines that changed."
)))]
pub(crate) async fn stream(State(shared): State<Shared>) -> impl IntoResponse {
    let (events, closing) = (shared.listen(), shared.closing());
    let waiting = whole_picture(&shared);
    let client = Client { shared, events, closing, waiting };
    let events = stream::unfold(client, |mut client| async move {
        let event = client.next().await?;
        let text = String::from_utf8_lossy(&event.data);
        Some((Ok::<_, Infallible>(Event::default().event(event.name).data(text)), client))
    });
    Sse::new(events).keep_alive(KeepAlive::new().interval(KEEP_ALIVE))
}

fn whole_picture(shared: &Shared) -> VecDeque<StreamEvent> {
    let snapshot = shared.latest();
    let wagons = StreamEvent { name: "wagons", data: crate::web::json::json(&snapshot.rows) };
    let train = StreamEvent { name: "train", data: snapshot.train_json.clone() };
    VecDeque::from([train, wagons])
}

impl Client {
    /// The next event; `None` once the service stops.
    async fn next(&mut self) -> Option<StreamEvent> {
        if *self.closing.borrow() {
            return None;
        }
        if let Some(event) = self.waiting.pop_front() {
            return Some(event);
        }
        tokio::select! {
            event = self.events.recv() => match event {
                Ok(event) => Some(event),
                Err(RecvError::Lagged(_)) => {
                    self.waiting = whole_picture(&self.shared);
                    self.waiting.pop_front()
                }
                Err(RecvError::Closed) => None,
            },
            _ = self.closing.changed() => None,
        }
    }
}
