//! Hands what is judged to the alerts: silent wagons, indicators, what only the neighbours show, and this service itself.

use crate::alerts::{AlertBook, Symptom};
use crate::api::grade::Grade;
use crate::store::inference::{Inference, Whole};
use crate::store::judgement::Judgement;
use crate::store::received::Received;
use crate::time::rfc3339;
use railgrip_causes::Cause;
use railgrip_indicators::{Judged, Table};
use railgrip_messages::{EventKind, Stamp};

/// Judges every symptom of the train. `started` is when this service began: a wagon of which nothing came is as old.
pub(super) fn judge(
    book: &mut AlertBook,
    table: Table,
    received: &Received,
    inference: &Inference,
    judgement: &Judgement,
    started: Stamp,
    now: Stamp,
) {
    for known in &received.wagons {
        let wagon = known.number;
        let of_wagon = |rule| Symptom { wagon, wheelset: None, rule };
        let last = known.health.as_deref().map_or(started, |health| health.acquired);
        let stale = last.age_s(now.monotonic_ns) > received.stale_after_s;
        let told = |kind| received.told.get(&(kind, wagon)).map_or("", |(text, _)| text.as_str());
        let (units, clock) = (told(EventKind::UnitsImplausible), told(EventKind::ClockDrifts));
        let graded = |text: &str, grade| if text.is_empty() { Grade::Ok } else { grade };
        book.judge(of_wagon("units"), graded(units, Grade::Act), units, now);
        book.judge(of_wagon("source_clock"), graded(clock, Grade::Watch), clock, now);
        // Nothing comes of a wagon whose samples are withheld: that alert says why.
        let missing = stale && units.is_empty() && !received.played_out(last);
        let (grade, reason) = match missing {
            true => (Grade::Act, no_data(received, wagon, last)),
            false => (Grade::Ok, String::new()),
        };
        book.judge(of_wagon("silent"), grade, &reason, now);
        let Some(health) = known.health.as_deref().filter(|_| !stale) else { continue };
        for Judged { spec, wheelset, indicator } in table.judged(health) {
            let symptom = Symptom { wagon, wheelset, rule: spec.id };
            if judgement.grades(spec) {
                book.judge(symptom, indicator.grade().into(), indicator.reason.as_str(), now);
            } else if Cause::from_word(spec.id).is_none() {
                // What a journal still holds of it, of a time when the wagon ran alone, is over.
                book.judge(symptom, Grade::Ok, "", now);
            }
        }
        for (spec, indicator) in inference.among(wagon).0.iter().filter(|(spec, _)| judgement.grades(spec)) {
            book.judge(of_wagon(spec.id), indicator.grade().into(), indicator.reason.as_str(), now);
        }
    }
}

/// Judges what all wagons together make of the train.
pub(super) fn judge_train(book: &mut AlertBook, whole: &Whole, now: Stamp) {
    for (spec, indicator) in &whole.judged {
        let symptom = Symptom { wagon: 0, wheelset: None, rule: spec.id };
        book.judge(symptom, indicator.grade().into(), indicator.reason.as_str(), now);
    }
}

/// Judges what is wrong with a train whose wagons are judged together, and that nobody judges it.
pub(super) fn judge_together(book: &mut AlertBook, judgement: &Judgement, started: Stamp, now: Stamp) {
    if let Some(verdicts) = judgement.fresh(now) {
        book.judge_together(verdicts, now);
    }
    let (grade, reason) = match judgement.silence(started, now) {
        Some(last) => {
            (Grade::Watch, format!("the train as a whole is not judged since {}", rfc3339(last.unix_ns)))
        }
        None => (Grade::Ok, String::new()),
    };
    book.judge(Symptom { wagon: 0, wheelset: None, rule: "judge" }, grade, &reason, now);
}

/// Since when no data of a wagon were taken, and why not if some came.
fn no_data(received: &Received, wagon: u32, last: Stamp) -> String {
    let since = format!("no data since {}", rfc3339(last.unix_ns));
    match received.refused.since_taken(wagon) {
        Some((why, count)) => {
            let why = why.word().replace('_', " ");
            format!("{since}: {count} messages came and were refused, the last because of: {why}")
        }
        None => since,
    }
}

/// Judges what is wrong with this service itself: its journal of alerts, its history.
pub(super) fn judge_service(book: &mut AlertBook, history: Option<&str>, now: Stamp) {
    let of_service = |rule| Symptom { wagon: 0, wheelset: None, rule };
    let (grade, reason) = match book.trouble() {
        Some(trouble) => {
            (Grade::Act, format!("alerts cannot be saved, so a restart would forget them: {trouble}"))
        }
        None => (Grade::Ok, String::new()),
    };
    book.judge(of_service("storage"), grade, &reason, now);
    let (grade, reason) = match history {
        Some(trouble) => {
            (Grade::Act, format!("the history cannot be saved; everything else works: {trouble}"))
        }
        None => (Grade::Ok, String::new()),
    };
    book.judge(of_service("history"), grade, &reason, now);
}
