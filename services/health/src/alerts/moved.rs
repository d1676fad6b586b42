//! Alerts that were kept while the train was made up anew: each follows its vehicle to where it runs now, and those of a vehicle
//! that has left the train are over.

use super::model::{Alert, AlertEvent, AlertState, Change};
use crate::time::rfc3339;

/// By place, who a wagon is: its vehicle number, letters and digits alone. A wagon without one is known within one start of the
/// train only, by [`nameless`]; nothing where not even that is known.
pub type Numbers = Vec<Option<String>>;

/// Begins what a wagon without a vehicle number is known by; no number has a blank.
const NAMELESS: &str = "start ";

/// What a wagon without a vehicle number is known by within one start of the train, which has this sign.
#[must_use]
pub fn nameless(session: &str, wagon: u32) -> Option<String> {
    (!session.is_empty()).then(|| format!("{NAMELESS}{session}, place {wagon}"))
}

/// Alerts of the consist `before` as alerts of the consist `now`; says whether any has changed.
#[must_use]
pub fn moved(alerts: Vec<Alert>, before: &Numbers, now: &Numbers, unix_ns: i64) -> (Vec<Alert>, bool) {
    if before == now {
        return (alerts, false);
    }
    let place = |old: u32| -> Option<u32> {
        // The train itself, or this service, is the same whoever runs in it.
        let Some(index) = (old as usize).checked_sub(1) else { return Some(0) };
        let at = match before.get(index)? {
            Some(number) => now.iter().position(|other| other.as_ref() == Some(number))?,
            // Nobody says when the train was started.
            None => now.get(index)?.is_none().then_some(index)?,
        };
        u32::try_from(at + 1).ok()
    };
    let numbered = |wagon: u32| {
        let number = (wagon as usize).checked_sub(1).and_then(|index| before.get(index)?.as_deref());
        number.is_some_and(|number| !number.starts_with(NAMELESS))
    };
    let moved = alerts.into_iter().map(|alert| {
        let left = if numbered(alert.wagon) { LEFT } else { UNKNOWN };
        follow(alert, &place, left, unix_ns)
    });
    (moved.collect(), true)
}

/// Why an alert of a vehicle that is gone is over.
const LEFT: &str = "the vehicle has left the train";
/// The same of a wagon that nobody can tell from another.
const UNKNOWN: &str = "the train has started anew, and without a vehicle number this may be another wagon";

fn follow(mut alert: Alert, place: &impl Fn(u32) -> Option<u32>, left: &str, unix_ns: i64) -> Alert {
    let old = alert.wagon;
    for list in [&mut alert.wagons, &mut alert.affected] {
        *list = list.iter().filter_map(|wagon| place(*wagon)).collect();
        list.sort_unstable();
    }
    alert.places.retain_mut(|shown| {
        let new = place(shown.wagon);
        shown.wagon = new.unwrap_or(shown.wagon);
        new.is_some()
    });
    if let Some(new) = place(old).or_else(|| alert.wagons.first().copied()) {
        let link = |wagon: u32| format!("/api/v1/wagons/{wagon}/");
        alert.evidence.history = alert.evidence.history.replace(&link(old), &link(new));
        alert.wagon = new;
    }
    if alert.active && alert.places.is_empty() {
        let at = rfc3339(unix_ns);
        (alert.active, alert.state, alert.unix_ns) = (false, AlertState::Cleared, unix_ns);
        alert.cleared_at = Some(at.clone());
        alert.changes += 1;
        let note = Some(left.to_owned());
        alert.history.push(AlertEvent {
            at,
            change: Change::Cleared,
            grade: alert.grade_now,
            by: None,
            note,
        });
    }
    alert
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alert(wagon: u32) -> Alert {
        let text = format!(
            r#"{{"id": {wagon}, "cause": "brake_friction", "scope": "wagon", "wagon": {wagon}, "wheelset": null,
            "wagons": [{wagon}], "affected": [{wagon}],
            "places": [{{"wagon": {wagon}, "wheelset": null, "indicator": "brake_friction", "grade": "watch", "reason": "low"}}],
            "grade": "watch", "grade_now": "watch", "reason": "low", "advice": "look",
            "evidence": {{"history": "/api/v1/wagons/{wagon}/history?from=1", "recording": null}}, "active": true,
            "state": "acknowledged", "acknowledged": {{"by": "Ada", "at": "x", "note": null}}, "silenced": null, "times": 1,
            "raised_at": "x", "cleared_at": null, "history": [], "changes": 1, "unix_ns": 1}}"#
        );
        serde_json::from_str(&text).expect("an alert")
    }

    fn numbers(all: &[&str]) -> Numbers {
        all.iter().map(|number| (!number.is_empty()).then(|| (*number).to_owned())).collect()
    }

    #[test]
    fn an_alert_follows_its_vehicle_and_ends_when_it_leaves() {
        let before = numbers(&["A", "B", "", "D"]);
        let now = numbers(&["D", "A", ""]);
        let (alerts, changed) = moved((1..=4).map(alert).collect(), &before, &now, 5_000_000_000);
        assert!(changed);
        let places: Vec<(u32, bool)> = alerts.iter().map(|alert| (alert.wagon, alert.active)).collect();
        assert_eq!(places, [(2, true), (2, false), (3, true), (1, true)]);
        assert_eq!((alerts[0].wagons.as_slice(), alerts[0].places[0].wagon), (&[2][..], 2));
        assert_eq!(alerts[3].evidence.history, "/api/v1/wagons/1/history?from=1");
        assert_eq!(alerts[0].acknowledged, alert(1).acknowledged, "what people did stays");
        let over = &alerts[1];
        assert_eq!((over.state, over.history[0].change), (AlertState::Cleared, Change::Cleared));
        assert!(over.history[0].note.as_deref().is_some_and(|note| note.contains("left the train")));
    }

    #[test]
    fn a_wagon_without_a_number_begins_anew_with_each_start_of_the_train() {
        let of = |session: &str| vec![Some("A".to_owned()), nameless(session, 2)];
        let all = || vec![alert(1), alert(2), of_the_train()];
        let (same, changed) = moved(all(), &of("1 7"), &of("1 7"), 9);
        assert_eq!((same, changed), (all(), false), "a process that was started again");
        let (alerts, changed) = moved(all(), &of("1 7"), &of("2 8"), 9);
        assert!(changed);
        assert_eq!(alerts[0], alert(1));
        assert_eq!((alerts[1].active, alerts[1].wagons.len()), (false, 0));
        let note = alerts[1].history[0].note.as_deref().unwrap_or_default();
        assert!(note.contains("without a vehicle number"), "{note}");
        assert_eq!(alerts[2], of_the_train(), "what is no wagon's stays");
        // A journal of an older version knows no start.
        let (alerts, _) = moved(all(), &numbers(&["A", ""]), &of("2 8"), 9);
        assert!(alerts[0].active && !alerts[1].active);
    }

    /// An alert of the train itself, which names no wagon.
    fn of_the_train() -> Alert {
        let mut alert = alert(1);
        (alert.id, alert.scope, alert.wagon) = (9, crate::alerts::model::Scope::Train, 0);
        (alert.wagons, alert.affected) = (Vec::new(), Vec::new());
        alert.places[0].wagon = 0;
        alert
    }

    #[test]
    fn nothing_changes_while_the_train_stays_as_it_is() {
        let same = numbers(&["A", ""]);
        let (alerts, changed) = moved(vec![alert(1), alert(2)], &same, &same, 9);
        assert_eq!((alerts, changed), (vec![alert(1), alert(2)], false));
    }
}
