//! What happened: alerts, slides, processes that came and went.

use rusqlite::{Connection, params};

/// Something that happened at an instant.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Event {
    /// When, Unix ms.
    pub unix_ms: i64,
    /// What kind, for example `alert_raised`.
    pub kind: String,
    /// The wagon, if it is about one.
    pub wagon: Option<u32>,
    /// The wheelset, if it is about one.
    pub wheelset: Option<u32>,
    /// How bad, if that was judged.
    pub grade: Option<String>,
    /// What it is about, for example `brake_friction`.
    pub cause: String,
    /// In words.
    pub text: String,
}

/// An event with its number; later ones have larger numbers, whatever the clock did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NumberedEvent {
    /// Its number.
    pub id: i64,
    /// The event.
    pub event: Event,
}

/// Which events a query asks for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EventFilter {
    /// From this instant on, Unix ms.
    pub from_ms: Option<i64>,
    /// Before this instant, Unix ms.
    pub to_ms: Option<i64>,
    /// Of this wagon.
    pub wagon: Option<u32>,
    /// Of this kind.
    pub kind: Option<String>,
    /// With numbers below this one: where a page before ended.
    pub before_id: Option<i64>,
}

/// Events that may wait in memory while the disk refuses them; beyond, the oldest are dropped and counted.
pub(crate) const WAITING_EVENTS: usize = 10_000;

pub(crate) fn insert(connection: &Connection, events: &[Event]) -> rusqlite::Result<()> {
    let mut insert = connection.prepare_cached(
        "INSERT INTO event (unix_ms, kind, wagon, wheelset, grade, cause, text) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
    )?;
    for event in events {
        insert.execute(params![
            event.unix_ms,
            event.kind,
            event.wagon,
            event.wheelset,
            event.grade,
            event.cause,
            event.text
        ])?;
    }
    Ok(())
}
