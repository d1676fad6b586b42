//! Tells the listeners of the stream what changed.

use crate::alerts::model::Scope;
use crate::api::wagons::model::WagonRow;
use crate::shared::{Shared, StreamEvent};
use crate::store::Snapshot;
use crate::web::json::json;
use std::time::{Duration, Instant};

/// Listeners of the stream get changes this often.
const STREAM_PERIOD: Duration = Duration::from_millis(500);

/// Tells the listeners of the stream what changed.
#[derive(Default)]
pub(super) struct Streamer {
    told: Vec<WagonRow>,
    at: Option<Instant>,
}

impl Streamer {
    /// Sends what happened to alerts at once, and what changed on the wagons now and then.
    pub fn stream(&mut self, shared: &Shared, snapshot: &Snapshot) {
        for alert in &snapshot.news {
            let change = alert.history.last().map_or("changed", |line| line.change.word());
            tracing::info!(
                id = alert.id,
                grade = alert.grade.word(),
                "alert {change}: {} ({}): {}",
                alert.cause,
                if alert.scope == Scope::Train {
                    "train".to_owned()
                } else {
                    format!("wagon {}", alert.wagon)
                },
                alert.reason
            );
            shared.send(StreamEvent { name: "alert", data: json(alert) });
        }
        if self.at.is_some_and(|at| at.elapsed() < STREAM_PERIOD) || !shared.has_listeners() {
            return;
        }
        self.at = Some(Instant::now());
        let changed: Vec<&WagonRow> = snapshot.rows.iter().filter(|row| !self.told.contains(row)).collect();
        if !changed.is_empty() {
            shared.send(StreamEvent { name: "wagons", data: json(&changed) });
        }
        shared.send(StreamEvent { name: "train", data: snapshot.train_json.clone() });
        self.told.clone_from(&snapshot.rows);
    }
}
