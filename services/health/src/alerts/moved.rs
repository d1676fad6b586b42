//! Alerts that were kept while the train was made up anew: each follows its vehicle to where it runs now, and those of a vehicle
//! that has left the train are over.

use super::model::{Alert, AlertEvent, AlertState, Change};
use crate::time::rfc3339;

/// The vehicle numbers of a train by place, letters and digits alone; nothing for a wagon without one.
pub type Numbers = Vec<Option<String>>;

/// Alerts of the consist `before` as alerts of the consist `now`; says whether any has changed.
#[must_use]
pub fn moved(alerts: Vec<Alert>, before: &Numbers, now: &Numbers, unix_ns: i64) -> (Vec<Alert>, bool) {
    if before == now {
        return (alerts, false);
    }
    let place = |old: u32| -> Option<u32> {
        let index = (old as usize).checked_sub(1)?;
        let at = match before.get(index)? {
            Some(number) => now.iter().position(|other| other.as_ref() == Some(number))?,
            // Of a wagon without a number all that is known is its place.
            None => now.get(index)?.is_none().then_some(index)?,
        };
        u32::try_from(at + 1).ok()
    };
    (alerts.into_iter().map(|alert| follow(alert, &place, unix_ns)).collect(), true)
}

fn follow(mut alert: Alert, place: &impl Fn(u32) -> Option<u32>, unix_ns: i64) -> Alert {
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
    if alert.active && alert.wagons.is_empty() {
        let at = rfc3339(unix_ns);
        (alert.active, alert.state, alert.unix_ns) = (false, AlertState::Cleared, unix_ns);
        alert.cleared_at = Some(at.clone());
        alert.changes += 1;
        let note = Some("the vehicle has left the train".to_owned());
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
    fn nothing_changes_while_the_train_stays_as_it_is() {
        let same = numbers(&["A", ""]);
        let (alerts, changed) = moved(vec![alert(1), alert(2)], &same, &same, 9);
        assert_eq!((alerts, changed), (vec![alert(1), alert(2)], false));
    }
}
