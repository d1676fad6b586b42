//! The train at one instant, ready to be served.

use crate::alerts::SharedBook;
use crate::alerts::model::{Alert, AlertList};
use crate::api::acoustic::acoustic;
use crate::api::figure::Freshness;
use crate::api::grade::{DataState, Grade};
use crate::api::processes::process;
use crate::api::sources::source;
use crate::api::train::model::{AlertCounts, RefusedView, TrainView};
use crate::api::wagons::model::{WagonList, WagonRow, WagonView, WheelsetView};
use crate::api::wagons::view::{self, Who};
use crate::store::inference::{Among, Inference, Whole};
use crate::store::judgement::Judgement;
use crate::store::received::{Received, Wagon};
use crate::time::rfc3339;
use crate::web::json::json;
use axum::body::Bytes;
use railgrip_causes::Cause;
use railgrip_indicators::{IndicatorSpec, Table};
use railgrip_messages::{ProcessKind, Stamp};
use std::sync::Arc;

/// The train at one instant, ready to be served.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// When its data were taken from the channels.
    pub taken: Stamp,
    /// At which instant ages and states hold.
    pub as_of: Stamp,
    /// The indicators.
    pub table: Table,
    /// The train at a glance.
    pub train: TrainView,
    /// One line a wagon.
    pub rows: Vec<WagonRow>,
    /// All about each wagon.
    pub wagons: Vec<WagonView>,
    /// What is said of the whole train.
    pub whole: Arc<Whole>,
    /// All alerts.
    pub alerts: AlertList,
    /// Why the train is not ready; empty if it is.
    pub not_ready: Vec<String>,
    /// `rows` as JSON.
    pub rows_json: Bytes,
    /// `train` as JSON.
    pub train_json: Bytes,
    /// What happened to alerts since the snapshot before.
    pub news: Vec<Alert>,
    /// The alerts themselves, for those who change them.
    pub book: SharedBook,
    /// Version of the alerts in this snapshot.
    pub alert_version: u64,
    basis: Arc<Basis>,
}

/// What a snapshot is made of, whenever it is looked at.
#[derive(Debug)]
pub(super) struct Basis {
    table: Table,
    train: String,
    received: Received,
    /// Of each wagon, front first.
    among: Vec<Among>,
    judgement: Judgement,
    whole: Arc<Whole>,
}

impl Basis {
    /// Everything that is known now.
    pub fn new(
        table: Table,
        train: &str,
        received: &Received,
        inference: &Inference,
        judgement: &Judgement,
        whole: Arc<Whole>,
    ) -> Self {
        let among = received.wagons.iter().map(|wagon| inference.among(wagon.number)).collect();
        Self {
            table,
            train: train.to_owned(),
            received: received.clone(),
            among,
            judgement: judgement.clone(),
            whole,
        }
    }
}

impl Snapshot {
    /// The train as it is now.
    pub(super) fn take(basis: Basis, book: &SharedBook, news: Vec<Alert>, now: Stamp) -> Self {
        let whole = Arc::clone(&basis.whole);
        Self::at(Arc::new(basis), whole, book, news, now, now)
    }

    /// The same train later, when nothing has come since: ages, states and readiness as they are at `now`.
    #[must_use]
    pub fn aged(&self, now: Stamp) -> Self {
        let whole =
            Arc::new(self.basis.whole.aged(&self.basis.received, &self.basis.judgement, now.monotonic_ns));
        Self::at(Arc::clone(&self.basis), whole, &self.book, Vec::new(), self.taken, now)
    }

    /// The same train with the alerts as they are now, and all that is judged by them.
    #[must_use]
    pub fn with_present_alerts(&self) -> Self {
        let (basis, whole) = (Arc::clone(&self.basis), Arc::clone(&self.whole));
        Self::at(basis, whole, &self.book, self.news.clone(), self.taken, self.as_of)
    }

    fn at(
        basis: Arc<Basis>,
        whole: Arc<Whole>,
        book: &SharedBook,
        news: Vec<Alert>,
        taken: Stamp,
        now: Stamp,
    ) -> Self {
        let locked = book.lock();
        let (alert_version, alerts) = (locked.version(), AlertList { alerts: locked.list(), next: None });
        let counts = locked.counts();
        drop(locked);
        let (mut rows, mut wagons) = wagons(&basis, now.monotonic_ns);
        accuse(basis.table, &alerts.alerts, &mut rows, &mut wagons);
        let not_ready: Vec<String> = rows
            .iter()
            .filter(|row| row.state != DataState::Live)
            .map(|row| format!("wagon {} ({}) is {}", row.id, row.name, row.reason))
            .collect();
        let train = train(&basis, &alerts.alerts, counts, &rows, now);
        let list = WagonList {
            train: train.name.clone(),
            generated_at: train.generated_at.clone(),
            wagons: rows.clone(),
            next: None,
        };
        Self {
            taken,
            as_of: now,
            rows_json: json(&list),
            train_json: json(&train),
            train,
            rows,
            wagons,
            whole,
            alerts,
            not_ready,
            news,
            book: book.clone(),
            alert_version,
            table: basis.table,
            basis,
        }
    }
}

/// A line about each wagon, and all about each.
fn wagons(basis: &Basis, now_ns: u64) -> (Vec<WagonRow>, Vec<WagonView>) {
    let received = &basis.received;
    let table = basis.table;
    let of_wagon = |(known, among): (&Wagon, &Among)| {
        let health = known.health.as_deref();
        let fresh = Freshness::of(health, now_ns, received.stale_after_s);
        let estimator = received.heartbeats.get(&(ProcessKind::Estimator.code(), known.number));
        let who = Who { id: known.number, name: &known.name, vehicle: known.vehicle.as_deref() };
        let mut row = view::row(table, who, health, fresh);
        let mut wagon = view::wagon(table, who, health, estimator, fresh, now_ns);
        if row.state == DataState::Live {
            among.amend(&mut row, &mut wagon, fresh, &basis.judgement);
            if basis.judgement.speaks(now_ns) {
                wagon
                    .wheelsets
                    .iter_mut()
                    .for_each(|wheelset| wheelset.grade = wheelset.grade.max(Grade::Ok));
            }
        }
        let heard = known.microphone.then_some(known.heard.as_ref());
        wagon.acoustic = heard.map(|heard| acoustic(heard, now_ns, received.stale_after_s));
        (row, wagon)
    };
    received.wagons.iter().zip(&basis.among).map(of_wagon).unzip()
}

/// Grades of wagons and wheelsets are never better than what active alerts say of them, so that page and interface speak with
/// one voice. What somebody has silenced does not count, nor what lies in the line: one alert tells of it, and the wagons that
/// run there stay as they are.
fn accuse(table: Table, alerts: &[Alert], rows: &mut [WagonRow], wagons: &mut [WagonView]) {
    let of_line = |alert: &&Alert| {
        let judged = alert.cause == Cause::LowAdhesion.word();
        judged || table.find(&alert.cause).is_some_and(IndicatorSpec::is_of_train)
    };
    let told = alerts.iter().filter(|alert| alert.active && alert.silenced.is_none());
    for alert in told.filter(|alert| !of_line(alert)) {
        for place in &alert.places {
            let Some(index) = rows.iter().position(|row| row.id == place.wagon) else { continue };
            let (row, wagon) = (&mut rows[index], &mut wagons[index]);
            if row.state != DataState::Live {
                continue;
            }
            if place.grade > row.grade {
                row.grade = place.grade;
                row.reason = alert.reason_at(place.wagon);
                (wagon.grade, wagon.reason) = (row.grade, row.reason.clone());
            }
            let accused = |wheelset: &&mut WheelsetView| Some(wheelset.id) == place.wheelset;
            if let Some(wheelset) = wagon.wheelsets.iter_mut().find(accused) {
                wheelset.grade = wheelset.grade.max(place.grade);
            }
        }
    }
}

/// The train at a glance.
fn train(basis: &Basis, alerts: &[Alert], counts: AlertCounts, rows: &[WagonRow], now: Stamp) -> TrainView {
    let received = &basis.received;
    let count = |state| rows.iter().filter(|row| row.state == state).count() as u32;
    let mut worst: Vec<WagonRow> = rows.iter().filter(|row| row.grade >= Grade::Watch).cloned().collect();
    worst.sort_by_key(|row| std::cmp::Reverse(row.grade));
    let (grade, reason) = match rows.iter().max_by_key(|row| (row.grade, std::cmp::Reverse(row.id))) {
        Some(row) if row.grade >= Grade::Watch => (row.grade, format!("wagon {}: {}", row.id, row.reason)),
        Some(row) if row.grade == Grade::Ok => {
            (Grade::Ok, "everything that is known is as it should be".to_owned())
        }
        _ => (Grade::Unknown, "nothing is known yet".to_owned()),
    };
    // What is no wagon's (the rail, stopping distances, a disk that is full) makes the train no less in need of a look.
    let told = alerts.iter().filter(|alert| alert.active && alert.silenced.is_none());
    let (grade, reason) = match told.max_by_key(|alert| alert.grade_now) {
        Some(alert) if alert.grade_now > grade => (alert.grade_now, alert.reason.clone()),
        _ => (grade, reason),
    };
    let live = count(DataState::Live);
    TrainView {
        name: basis.train.clone(),
        generated_at: rfc3339(now.unix_ns),
        ready: live as usize == rows.len(),
        grade,
        reason,
        wagons: rows.len() as u32,
        live,
        stale: count(DataState::Stale),
        silent: count(DataState::Silent),
        worst,
        alerts: counts,
        judged_together: basis.judgement.is_together(),
        brakings_judged: basis.judgement.brakings(),
        refused: received
            .refused
            .counts()
            .map(|(payload, why, count)| RefusedView {
                payload: payload.to_owned(),
                reason: why.word().to_owned(),
                count,
            })
            .collect(),
        sources: received
            .sources
            .values()
            .map(|state| source(state, received.vehicle(state.wagon)))
            .collect(),
        processes: received
            .heartbeats
            .values()
            .map(|beat| process(beat, received.vehicle(beat.wagon), now.monotonic_ns))
            .collect(),
    }
}
