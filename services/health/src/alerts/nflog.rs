//! The notification log: what is still to be sent to whom (the outbox), and how much was sent.
//!
//! A notification leaves the outbox only when its receiver has confirmed it; it may therefore arrive twice, and carries a key
//! by which the receiver can tell.

use super::model::{Alert, Change};
use crate::api::grade::Grade;
use crate::time::rfc3339;
use rusqlite::{Connection, OptionalExtension, Transaction, params};

/// Something that receivers shall know.
#[derive(Debug, Clone)]
pub struct Notification {
    /// The alert as it was then.
    pub alert: Alert,
    /// What happened to it.
    pub change: Change,
    /// When, Unix ns.
    pub at_unix_ns: i64,
}

/// A receiver, as the outbox addresses it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Receiver {
    /// Its name in the outbox.
    pub name: String,
    /// True if it only wants to hear of what needs action.
    pub act_only: bool,
}

/// A notification in the outbox.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Queued {
    /// Its place.
    pub id: i64,
    /// The alert's number.
    pub alert: u64,
    /// The same for the same notification, however often it is sent.
    pub key: String,
    /// JSON.
    pub body: String,
    /// How often the receiver has refused it for good.
    pub refused: u32,
}

/// What every notification of this train carries.
pub(super) struct Envelope<'a> {
    /// Name of the database, which no other has.
    pub installation: &'a str,
    /// Name of the train.
    pub train: &'a str,
}

/// Puts each notification into the outbox of every receiver that wants it; of a receiver with more than `most` that wait,
/// the oldest are dropped and counted.
pub(super) fn enqueue(
    transaction: &Transaction<'_>,
    envelope: &Envelope<'_>,
    notifications: &[Notification],
    receivers: &[Receiver],
    most: u32,
) -> rusqlite::Result<()> {
    for notification in notifications {
        let alert = &notification.alert;
        let (key, body) = written(envelope, notification);
        let unix_s = notification.at_unix_ns.div_euclid(1_000_000_000);
        for receiver in receivers.iter().filter(|one| !one.act_only || alert.grade == Grade::Act) {
            transaction.execute(
                "INSERT INTO outbox (target, alert, key, body, written_unix_s) VALUES (?1, ?2, ?3, ?4, ?5)",
                params![receiver.name, alert.id as i64, key, body, unix_s],
            )?;
        }
    }
    for Receiver { name, .. } in receivers {
        let dropped = transaction.execute(
            "DELETE FROM outbox WHERE target = ?1 AND id <= (
                 SELECT id FROM outbox WHERE target = ?1 ORDER BY id DESC LIMIT 1 OFFSET ?2)",
            params![name, most],
        )?;
        if dropped > 0 {
            tracing::warn!(receiver = name, dropped, "the outbox is full: its oldest notifications are lost");
            add_to_fact(transaction, &format!("dropped:{name}"), dropped)?;
        }
    }
    Ok(())
}

/// The key of a notification, and its text.
fn written(envelope: &Envelope<'_>, notification: &Notification) -> (String, String) {
    let alert = &notification.alert;
    let key = format!("{}-{}-{}", envelope.installation, alert.id, alert.changes);
    let body = serde_json::json!({
        "key": key,
        "train": envelope.train,
        "change": notification.change,
        "at": rfc3339(notification.at_unix_ns),
        "alert": alert,
    });
    (key, body.to_string())
}

/// The oldest notification for a receiver.
pub(super) fn next(connection: &Connection, receiver: &str) -> rusqlite::Result<Option<Queued>> {
    let oldest = "SELECT id, alert, key, body, refused FROM outbox WHERE target = ?1 ORDER BY id LIMIT 1";
    let queued = |row: &rusqlite::Row<'_>| {
        Ok(Queued {
            id: row.get(0)?,
            alert: row.get::<_, i64>(1)?.unsigned_abs(),
            key: row.get(2)?,
            body: row.get(3)?,
            refused: row.get(4)?,
        })
    };
    connection.prepare_cached(oldest)?.query_row([receiver], queued).optional()
}

/// Takes a notification out of the outbox, confirmed or given up.
pub(super) fn done(
    connection: &Connection,
    receiver: &str,
    id: i64,
    confirmed: bool,
) -> rusqlite::Result<()> {
    let fact = format!("{}:{receiver}", if confirmed { "delivered" } else { "refused" });
    let transaction = connection.unchecked_transaction()?;
    transaction.execute("DELETE FROM outbox WHERE id = ?1", [id])?;
    add_to_fact(&transaction, &fact, 1)?;
    transaction.commit()
}

/// Counts that a receiver will not take a notification.
pub(super) fn refused(connection: &Connection, id: i64) -> rusqlite::Result<()> {
    connection.execute("UPDATE outbox SET refused = refused + 1 WHERE id = ?1", [id]).map(|_| ())
}

/// Notifications that wait for a receiver, and those ever delivered, refused and dropped.
pub(super) fn counts(connection: &Connection, receiver: &str) -> rusqlite::Result<[u64; 4]> {
    let number = |row: &rusqlite::Row<'_>| row.get::<_, i64>(0).map(i64::unsigned_abs);
    let count = "SELECT count(*) FROM outbox WHERE target = ?1";
    let waiting = connection.query_row(count, [receiver], number)?;
    let fact = |name: &str| {
        let of = "SELECT CAST(value AS INTEGER) FROM fact WHERE name = ?1";
        let found = connection.query_row(of, [format!("{name}:{receiver}")], number).optional();
        found.map(Option::unwrap_or_default)
    };
    Ok([waiting, fact("delivered")?, fact("refused")?, fact("dropped")?])
}

fn add_to_fact(connection: &Connection, name: &str, count: usize) -> rusqlite::Result<()> {
    connection.execute(
        "INSERT INTO fact (name, value) VALUES (?1, ?2)
         ON CONFLICT (name) DO UPDATE SET value = CAST(value AS INTEGER) + ?2",
        params![name, count.to_string()],
    )?;
    Ok(())
}
