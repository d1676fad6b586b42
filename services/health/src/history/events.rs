//! Requests for what happened: alerts, slides, processes that came and went, starts and stops.

use super::query::instant;
use super::routes::{available, read, wagon};
use super::{Consist, History};
use crate::api::problem::Problem;
use crate::shared::Shared;
use crate::time::rfc3339;
use crate::web::pages::{MOST, Page, link};
use crate::web::query::{parameters, refuse, value};
use axum::Json;
use axum::extract::{RawQuery, State};
use axum::response::{IntoResponse, Response};
use railgrip_history::{EventFilter, HistoryError, NumberedEvent, Reader};
use serde::Serialize;
use utoipa::ToSchema;

/// Events of a page unless another number is asked for.
const USUAL: usize = 100;

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct EventView {
    /// Its number; later ones have larger numbers, whatever the clock did.
    pub id: i64,
    /// When, RFC 3339.
    pub at: String,
    /// What kind: `alert_raised` and the like, `slides`, `process_started`, `process_gone`, `service_started`,
    /// `service_stopped`.
    pub kind: String,
    /// The wagon, if it is about one.
    pub wagon: Option<u32>,
    /// The number of its vehicle; `null` where it has none.
    pub vehicle_number: Option<String>,
    /// The wheelset, 1 leading, if it is about one.
    pub wheelset: Option<u32>,
    /// How bad, if that was judged.
    pub grade: Option<String>,
    /// What it is about, for example `brake_friction`.
    pub cause: String,
    /// In words.
    pub text: String,
}

/// A page of events, newest first.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct EventPage {
    /// The events.
    pub events: Vec<EventView>,
    /// Where older ones are; `null` on the last page.
    pub next: Option<String>,
}

/// An event at the place where its wagon runs now.
fn view(consist: &Consist, NumberedEvent { id, event }: NumberedEvent) -> EventView {
    let unix_s = event.unix_ms.div_euclid(1000);
    EventView {
        id,
        at: rfc3339(event.unix_ms.saturating_mul(1_000_000)),
        kind: event.kind,
        wagon: event.wagon.and_then(|wagon| consist.place_then(wagon, unix_s)),
        vehicle_number: event.wagon.and_then(|wagon| consist.vehicle(wagon)).map(str::to_owned),
        wheelset: event.wheelset,
        grade: event.grade,
        cause: event.cause,
        text: event.text,
    }
}

/// What happened, newest first, page by page.
#[utoipa::path(get, path = "/api/v1/events", tag = "history",
    params(
        ("from" = Option<String>, Query, description = "Begin: RFC 3339, Unix seconds, or an age such as `7d`; default: the first",
            pattern = "instant"),
        ("to" = Option<String>, Query, description = "End, exclusive: RFC 3339, Unix seconds, an age such as `7d`, or `now`, the default",
            pattern = "instant"),
        ("wagon" = Option<u32>, Query, minimum = 1, description = "Only of this wagon"),
        ("kind" = Option<String>, Query, max_length = 40, pattern = "^[a-z_]+$",
            description = "Only of this kind, for example `slides`"),
        ("limit" = Option<u32>, Query, minimum = 1, maximum = 1000, description = "At most so many; default 100"),
        ("after" = Option<i64>, Query, minimum = 0, description = "Only behind the event with this number, that is older ones"),
    ),
    responses(
        (status = 200, description = "A page", body = EventPage, headers(("Link" = String, description = "The next page, rel=\"next\""))),
        (status = 400, description = "A query parameter is wrong; the detail names it and what is allowed"),
        (status = 404, description = "There is no such wagon, or no history"),
        (status = 503, description = "The database refuses"),
    ))]
pub(crate) async fn events(
    State(shared): State<Shared>,
    RawQuery(query): RawQuery,
) -> Result<Response, Problem> {
    let pairs = parameters(query.as_deref(), &["from", "to", "wagon", "kind", "limit", "after"])?;
    let page = Page::of(&pairs, USUAL)?;
    let now_s = shared.now().unix_ns.div_euclid(1_000_000_000);
    let at_ms = |name| value(&pairs, name).map(|text| instant(name, text, now_s)).transpose();
    let filter = EventFilter {
        from_ms: at_ms("from")?.map(|s| s * 1000),
        to_ms: at_ms("to")?.map(|s| s * 1000),
        wagon: value(&pairs, "wagon").map(|text| wagon(&shared, text)).transpose()?,
        kind: value(&pairs, "kind").map(kind).transpose()?,
        before_id: page.after.map(|id| i64::try_from(id).unwrap_or(i64::MAX)),
    };
    let history = available(&shared)?;
    let page_of = read(history, move |history| {
        history.read(|reader| found(history, reader, filter, page.limit.min(MOST)))
    });
    let events: Vec<EventView> = page_of.await?;
    let last = events.last().filter(|_| events.len() == page.limit);
    let next = last.map(|last| page.next("/api/v1/events", &pairs, last.id.unsigned_abs()));
    let response = Json(EventPage { events, next: next.clone() }).into_response();
    Ok(link(response, next.as_deref()))
}

/// Events of wagons by the places at which they run now; what happened to a vehicle that is gone names no place, nor what happened
/// to a wagon without a number before the train was started: nobody knows whether it is the same.
fn found(
    history: &History,
    reader: &Reader,
    mut filter: EventFilter,
    limit: usize,
) -> Result<Vec<EventView>, HistoryError> {
    let consist = history.consist(reader)?;
    filter.wagon = filter.wagon.map(|place| consist.id(place));
    if let Some(id) = filter.wagon {
        let known_ms = consist.known_from(id).saturating_mul(1000);
        filter.from_ms = Some(filter.from_ms.map_or(known_ms, |from_ms| from_ms.max(known_ms)));
    }
    let events = reader.events(&filter, limit)?.into_iter().map(|found| view(&consist, found));
    Ok(events.collect())
}

fn kind(text: &str) -> Result<String, Problem> {
    let plain = |byte: u8| byte.is_ascii_lowercase() || byte == b'_';
    if (1..=40).contains(&text.len()) && text.bytes().all(plain) {
        return Ok(text.to_owned());
    }
    Err(refuse("kind", text, "a kind of event, for example slides or alert_raised"))
}
