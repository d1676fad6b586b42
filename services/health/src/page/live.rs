//! The parts of a page that changed, as server-sent events.
//!
//! A client first gets every part, then what differs from what it was sent; a slow client delays only itself and is sent
//! the latest when it reads again, so that nothing piles up. Events: `hello` (the version of the page's files, so that a page
//! from before an update loads itself anew), `parts` (object of `id` to HTML), `beat` (nothing changed, but all is well).

use super::kind::Page;
use super::{assets, compose};
use crate::api::problem::Problem;
use crate::shared::Shared;
use axum::Extension;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::sse::{Event, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use railgrip_words::{Language, speak};
use std::collections::{BTreeMap, HashMap};
use std::convert::Infallible;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::Duration;
use tokio::sync::watch;

/// Pages renew themselves this often; people read no faster.
const PERIOD: Duration = Duration::from_secs(1);

#[derive(serde::Deserialize)]
pub(super) struct Wanted {
    page: String,
    /// Language of the page that asks.
    lang: Option<String>,
}

struct Client {
    shared: Shared,
    closing: watch::Receiver<bool>,
    page: Page,
    language: Language,
    told: HashMap<String, u64>,
    sent: u64,
}

pub(super) async fn live(
    State(shared): State<Shared>,
    Extension(language): Extension<Language>,
    Query(wanted): Query<Wanted>,
) -> Result<Response, Problem> {
    let page = Page::parse(&wanted.page).ok_or_else(|| not_a_page(&wanted.page))?;
    let closing = shared.closing();
    let language = wanted.lang.as_deref().and_then(Language::parse).unwrap_or(language);
    let client = Client { shared, closing, page, language, told: HashMap::new(), sent: 0 };
    let events = stream::unfold(client, |mut client| async move {
        let event = client.next().await?;
        Some((Ok::<_, Infallible>(event), client))
    });
    Ok(Sse::new(events).into_response())
}

impl Client {
    /// The next event; `None` once the service stops.
    async fn next(&mut self) -> Option<Event> {
        self.sent += 1;
        if self.sent == 1 {
            let hello = format!("{{\"version\":\"{}\"}}", assets::version());
            return Some(Event::default().event("hello").data(hello));
        }
        if self.sent > 2 {
            tokio::select! {
                () = tokio::time::sleep(PERIOD) => (),
                _ = self.closing.changed() => return None,
            }
        }
        if *self.closing.borrow() {
            return None;
        }
        let changed = self.changed();
        Some(match serde_json::to_string(&changed) {
            Ok(text) if !changed.is_empty() => Event::default().event("parts").data(text),
            _ => Event::default().event("beat").data("{}"),
        })
    }

    /// What differs from what this client was sent.
    fn changed(&mut self) -> BTreeMap<String, String> {
        let snapshot = self.shared.latest();
        let mut changed = BTreeMap::new();
        let parts = speak(self.language, || compose::parts(self.page, &self.shared, &snapshot));
        for part in parts {
            let html = part.html.into_string();
            let mut hasher = DefaultHasher::new();
            html.hash(&mut hasher);
            let hash = hasher.finish();
            if self.told.get(&part.id) != Some(&hash) {
                self.told.insert(part.id.clone(), hash);
                changed.insert(part.id, html);
            }
        }
        changed
    }
}

fn not_a_page(text: &str) -> Problem {
    let detail =
        format!("page is \"{text}\"; allowed is train, alerts, indicators, settings or wagon-NUMBER");
    Problem::new(StatusCode::BAD_REQUEST, detail)
}
