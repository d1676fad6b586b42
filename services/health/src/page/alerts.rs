//! Alerts: what happens where since when, what to do about it, and the buttons to acknowledge or silence it.

use super::kind::Part;
use super::words::{chip, instant, named, sentence, timed, vehicle, wheelset};
use crate::alerts::model::Alert;
use crate::alerts::model::{AlertEvent, AlertState, Scope};
use crate::alerts::notify::ReceiverView;
use crate::shared::Shared;
use crate::store::Snapshot;
use maud::{Markup, html};
use railgrip_words::{reword, say, t};

/// Alerts that are over and still shown; the interface has more.
const OVER_SHOWN: usize = 50;

/// Alerts of one kind that stand in a list in full; what exceeds them is one line that unfolds, so that forty wagons with one
/// trouble do not push the only one with another off the screen.
const OF_A_KIND: usize = 3;

pub(super) fn parts(shared: &Shared, snapshot: &Snapshot) -> Vec<Part> {
    vec![
        Part::new("alert-lists", lists(snapshot)),
        Part::new("receivers", receivers(&shared.receiver_states().view().receivers)),
    ]
}

pub(super) fn body(shared: &Shared, snapshot: &Snapshot) -> Markup {
    html! {
        h1 .page { (t("Alerts")) }
        (lists(snapshot))
        section .card aria-labelledby="h-receivers" {
            h2 #h-receivers { (t("Receivers")) }
            (receivers(&shared.receiver_states().view().receivers))
        }
    }
}

/// Receivers of alerts, and whether they can be reached.
fn receivers(receivers: &[ReceiverView]) -> Markup {
    html! {
        dl #receivers .pairs {
            @if receivers.is_empty() { dt { (t("Nobody is notified: the config names no [[receiver]].")) } dd {} }
            @for receiver in receivers {
                dt { (receiver.name) }
                dd .loud[receiver.trouble.is_some()] {
                    (say("{count} sent", &[("count", &receiver.delivered)]))
                    @if receiver.waiting > 0 { ", " (say("{count} wait", &[("count", &receiver.waiting)])) }
                    @if receiver.refused + receiver.dropped > 0 { ", " (say("{count} lost", &[("count", &(receiver.refused + receiver.dropped))])) }
                    @if let Some(trouble) = &receiver.trouble { ": " (trouble) }
                }
            }
        }
    }
}

fn of(snapshot: &Snapshot, state: AlertState) -> Vec<&Alert> {
    snapshot.alerts.alerts.iter().filter(|alert| alert.state == state).collect()
}

/// Alerts that nobody has taken care of, and how many somebody has: the morning's list.
pub(super) fn todo(snapshot: &Snapshot) -> Markup {
    let open = of(snapshot, AlertState::Active);
    let seen = of(snapshot, AlertState::Acknowledged);
    let silenced = of(snapshot, AlertState::Silenced).len();
    html! {
        div #todo {
            @if open.is_empty() {
                p .calm { @if seen.is_empty() { (t("No alert is active.")) } @else { (t("No new alert.")) } }
            }
            (list(&open, Rest::Elsewhere))
            @if !seen.is_empty() {
                h3 .sub { (t("Acknowledged, still there")) " " span .count { (seen.len()) } }
                (list(&seen, Rest::Elsewhere))
            }
            @if silenced > 0 {
                p .calm { a href="/alerts#g-silenced" { (say("{count} silenced for a time", &[("count", &silenced)])) } "." }
            }
        }
    }
}

/// The alerts of one wagon; those that have ended are folded.
pub(super) fn of_wagon(snapshot: &Snapshot, wagon: u32) -> Markup {
    let own = snapshot.alerts.alerts.iter().filter(|alert| alert.wagons.contains(&wagon));
    let (open, over): (Vec<&Alert>, Vec<&Alert>) = own.partition(|alert| alert.active);
    html! {
        div #wagon-alerts {
            @if open.is_empty() { p .calm { (t("This wagon has no alerts.")) } }
            (list(&open, Rest::Folded))
            @if !over.is_empty() {
                details .fold #wagon-over {
                    summary { b { @if over.len() == 1 { (t("1 ended alert")) } @else { (say("{count} ended alerts", &[("count", &over.len())])) } } }
                    (list(&over[..over.len().min(OVER_SHOWN)], Rest::Folded))
                }
            }
        }
    }
}

fn lists(snapshot: &Snapshot) -> Markup {
    let over = of(snapshot, AlertState::Cleared);
    html! {
        div #alert-lists .stack {
            (group("open", t("Needs attention"), t("No alert is active."), &of(snapshot, AlertState::Active)))
            (group("seen", t("Acknowledged, still there"), t("None."), &of(snapshot, AlertState::Acknowledged)))
            (group("silenced", t("Silenced for a time"), t("None."), &of(snapshot, AlertState::Silenced)))
            (group("over", t("Ended"), t("No alert has ended yet."), &over[..over.len().min(OVER_SHOWN)]))
        }
    }
}

fn group(id: &str, title: &str, empty: &str, alerts: &[&Alert]) -> Markup {
    html! {
        section .card id={ "g-" (id) } aria-labelledby={ "h-" (id) } {
            div .heading { h2 id={ "h-" (id) } { (title) " " span .count { (alerts.len()) } } }
            @if alerts.is_empty() { p .calm { (empty) } }
            (list(alerts, Rest::Folded))
        }
    }
}

/// What becomes of the alerts of a kind that stand in no list in full.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rest {
    /// They unfold in their place.
    Folded,
    /// They stand on the page of alerts: that of the train stays small however long the train.
    Elsewhere,
}

fn list(alerts: &[&Alert], rest: Rest) -> Markup {
    html! {
        ul .alerts {
            @for (place, alert) in alerts.iter().enumerate() {
                @let before = alerts[..place].iter().filter(|other| other.cause == alert.cause).count();
                @if before < OF_A_KIND { (entry(alert)) } @else if before == OF_A_KIND { (others(&alerts[place..], alert, rest)) }
            }
        }
    }
}

/// The alerts from here on that are of this alert's kind: a line with a link to each place.
fn others(alerts: &[&Alert], first: &Alert, rest: Rest) -> Markup {
    let all: Vec<&Alert> = alerts.iter().copied().filter(|alert| alert.cause == first.cause).collect();
    if let [alone] = all[..] {
        return entry(alone);
    }
    let mut by_place = all.clone();
    by_place.sort_by_key(|alert| (alert.wagon, alert.wheelset));
    let worst = all.iter().map(|alert| if alert.active { alert.grade_now } else { alert.grade }).max();
    let words = say("{count} more: {cause}", &[("count", &all.len()), ("cause", &named(&first.cause))]);
    let class = format!("rest g-{} a-{}", worst.unwrap_or(first.grade).word(), first.state.word());
    html! {
        li id={ "rest-" (first.cause) "-" (first.state.word()) } class=(class) {
            @match rest {
                Rest::Folded => {
                    details {
                        summary { b { (words) } }
                        ul .alerts { @for alert in &all { (entry(alert)) } }
                    }
                    p .places { @for alert in by_place { a href=(home(alert)) { (place(alert)) } " " } }
                }
                Rest::Elsewhere => {
                    p { b { (words) } }
                    p .places { @for alert in by_place { a href={ "/alerts#alert-" (alert.id) } data-alert=(alert.id) { (place(alert)) } " " } }
                }
            }
        }
    }
}

fn entry(alert: &Alert) -> Markup {
    let over = alert.state == AlertState::Cleared;
    let grade = if over { alert.grade } else { alert.grade_now };
    let class = format!("alert g-{} a-{}", grade.word(), alert.state.word());
    html! {
        li id={ "alert-" (alert.id) } class=(class) data-alert=(alert.id) {
            div .line {
                (chip(grade))
                a .where href=(home(alert)) { (place(alert)) }
                (vehicle(shown_number(alert)))
                span .cause { (named(&alert.cause)) }
                span .since { (since(alert)) }
            }
            p .reason { (timed(&sentence(&alert.reason))) }
            p .advice { b { (t("Do:")) " " } (reword(&alert.advice)) }
            (found(alert))
            (taken(alert))
            div .acts { (buttons(alert)) }
            (more(alert))
        }
    }
}

/// The vehicle number of an alert about one wagon that runs in the train; of one that has left it the number is its place.
fn shown_number(alert: &Alert) -> Option<&str> {
    alert.vehicle_number.as_deref().filter(|_| alert.wagons.len() == 1)
}

/// Whether the wagon that an alert was about is gone, or can no longer be told from another.
fn is_gone(alert: &Alert) -> bool {
    alert.wagon > 0 && alert.wagons.is_empty()
}

/// The page of the wagon, or of the train where no wagon is named.
fn home(alert: &Alert) -> String {
    if alert.wagon == 0 || is_gone(alert) { "/".to_owned() } else { format!("/wagons/{}", alert.wagon) }
}

/// Where it is: `Wagon 3, wheelset 2`, `Wagons 1–8`, or `Whole train` where no wagon is named.
fn place(alert: &Alert) -> String {
    if is_gone(alert) {
        return match &alert.vehicle_number {
            Some(number) => say("Vehicle {number}", &[("number", number)]),
            None => t("A wagon of an earlier start").to_owned(),
        };
    }
    match alert.scope {
        Scope::Train if alert.wagons.iter().all(|wagon| *wagon == 0) => t("Whole train").to_owned(),
        Scope::Train if alert.wagons.len() > 1 => say("Wagons {list}", &[("list", &ranges(&alert.wagons))]),
        Scope::Wagon if alert.wagons.len() > 1 => say("Wagons {list}", &[("list", &ranges(&alert.wagons))]),
        _ => {
            let wagon = say("Wagon {number}", &[("number", &alert.wagon)]);
            if alert.wheelsets.len() == 2 {
                return format!(
                    "{wagon}, {}",
                    say("wheelsets {list}", &[("list", &ranges(&alert.wheelsets))])
                );
            }
            alert.wheelset.map_or_else(|| wagon.clone(), |set| format!("{wagon}, {}", wheelset(set)))
        }
    }
}

/// `1, 2, 3, 7` as `1–3, 7`.
fn ranges(numbers: &[u32]) -> String {
    let mut runs: Vec<(u32, u32)> = Vec::new();
    for number in numbers {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == *number => *last = *number,
            _ => runs.push((*number, *number)),
        }
    }
    let text = |(first, last): (u32, u32)| {
        if first == last { format!("{first}") } else { format!("{first}–{last}") }
    };
    runs.into_iter().map(text).collect::<Vec<_>>().join(", ")
}

fn since(alert: &Alert) -> Markup {
    html! {
        @if let Some(cleared) = &alert.cleared_at {
            (instant(&alert.raised_at)) " " (t("to")) " " (instant(cleared))
        } @else {
            (t("since")) " " (instant(&alert.raised_at))
        }
        @if alert.times > 1 { ", " (say("{count} times", &[("count", &alert.times)])) }
    }
}

/// What the diagnosis of its recording found.
fn found(alert: &Alert) -> Markup {
    html! {
        @if let Some(diagnosis) = &alert.evidence.diagnosis {
            p .advice {
                b { (t("Diagnosis of the recording:")) " " } (reword(&diagnosis.words))
                @if diagnosis.has_page { " " a href={ "/api/v1/alerts/" (alert.id) "/report" } { (t("The whole report")) } }
            }
        }
    }
}

/// Who took care of it.
fn taken(alert: &Alert) -> Markup {
    html! {
        @if let Some(acknowledged) = &alert.acknowledged {
            p .taken {
                "✓ " (t("Acknowledged by")) " " b { (acknowledged.by) } ", " (instant(&acknowledged.at))
                @if let Some(note) = &acknowledged.note { ": “" (note) "”" }
            }
        }
        @if let Some(silence) = &alert.silenced {
            p .taken { (t("Silenced by")) " " b { (silence.by) } " " (t("until")) " " (instant(&silence.until)) ": “" (silence.why) "”" }
        }
    }
}

fn buttons(alert: &Alert) -> Markup {
    let acts: &[(&str, &str)] = match alert.state {
        AlertState::Active => &[("acknowledge", t("Acknowledge")), ("silence", t("Silence"))],
        AlertState::Acknowledged => &[("unacknowledge", t("Take back")), ("silence", t("Silence"))],
        AlertState::Silenced => &[("unsilence", t("End silence"))],
        AlertState::Cleared => &[],
    };
    let about = say(
        "alert {free}: {place}, {cause}",
        &[("free", &alert.id), ("place", &place(alert)), ("cause", &named(&alert.cause))],
    );
    html! {
        @for (act, word) in acts {
            button type="button" data-act=(act) data-alert=(alert.id) aria-label={ (word) " " (about) } { (word) }
        }
    }
}

/// Evidence and course, folded.
fn more(alert: &Alert) -> Markup {
    html! {
        details id={ "more-" (alert.id) } {
            summary { (t("Evidence and history")) }
            ul .course {
                @for place in &alert.places {
                    li {
                        (chip(place.grade)) " "
                        @if place.wagon > 0 {
                            a href={ "/wagons/" (place.wagon) } { (say("Wagon {number}", &[("number", &place.wagon)])) @if let Some(set) = place.wheelset { ", " (wheelset(set)) } } (vehicle(place.vehicle_number.as_deref())) ": "
                        }
                        (named(&place.indicator)) ": " (timed(&reword(&place.reason)))
                    }
                }
            }
            ul .course { @for event in &alert.history { (line(event)) } }
            p {
                @if let Some(chart) = chart_of_that_time(alert) { a href=(chart) { (t("Charts of that time")) } }
                @if let Some(recording) = &alert.evidence.recording { ", " (t("recording")) " " code { (recording) } }
            }
            @if let Some(diagnosis) = alert.evidence.diagnosis.as_ref().filter(|diagnosis| !diagnosis.lacks.is_empty()) {
                p { (t("What the recording does not show:")) }
                ul .course { @for lack in &diagnosis.lacks { li { (reword(lack)) } } }
            }
        }
    }
}

/// The charts of its wagon around the time at which it was raised.
fn chart_of_that_time(alert: &Alert) -> Option<String> {
    // The evidence is a request for figures: its wagon and its ends are those of the view.
    let (wagon, ends) = alert.evidence.history.strip_prefix("/api/v1/wagons/")?.split_once("/history?")?;
    Some(format!("/wagons/{wagon}?{ends}#trends"))
}

fn line(event: &AlertEvent) -> Markup {
    html! {
        li {
            (instant(&event.at)) " " (t(event.change.word())) " (" (t(event.grade.word())) ")"
            @if let Some(by) = &event.by { " " (t("by")) " " (by) }
            @if let Some(note) = &event.note { ": " @if event.by.is_some() { (note) } @else { (reword(note)) } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alert(id: u64, wagon: u32, cause: &str) -> Alert {
        let alert = serde_json::json!({
            "id": id, "cause": cause, "scope": "wagon", "wagon": wagon, "wheelset": null, "wagons": [wagon],
            "grade": "watch", "grade_now": "watch", "active": true, "state": "active", "reason": "", "advice": "",
            "raised_at": "2026-11-23T08:00:00Z", "history": [], "places": [], "times": 1, "changes": 1,
            "unix_ns": 0,
            "evidence": { "history": "", "recording": null },
        });
        serde_json::from_value(alert).expect("an alert")
    }

    /// Wagons of the entries in full, then those behind the line that unfolds.
    fn shown(alerts: &[&Alert]) -> (usize, usize) {
        let html = list(alerts, Rest::Folded).into_string();
        let (before, behind) = html.split_once("class=\"rest").unwrap_or((&html, ""));
        let entries = |html: &str| html.matches("class=\"alert ").count();
        (entries(before), entries(behind))
    }

    #[test]
    fn many_of_a_kind_leave_room_for_the_only_one_of_another() {
        let many: Vec<Alert> =
            (1..=12).rev().map(|wagon| alert(u64::from(wagon), wagon, "sensors")).collect();
        let other = alert(99, 20, "rail");
        let all: Vec<&Alert> = many.iter().chain([&other]).collect();
        let html = list(&all, Rest::Folded).into_string();
        assert!(html.contains("9 more: "), "{html}");
        assert_eq!(html.matches("class=\"alert ").count(), 13);
        let links: Vec<usize> =
            (1..=9).map(|wagon| html.rfind(&format!("\"/wagons/{wagon}\"")).unwrap()).collect();
        assert!(links.is_sorted(), "the places stand in the order of the train");
        assert!(html.find("id=\"alert-99\"") > html.find("class=\"rest"), "the other kind follows in full");
        let short = list(&all, Rest::Elsewhere).into_string();
        assert_eq!(short.matches("class=\"alert ").count(), 4);
        assert_eq!(short.matches("data-alert=").count() - short.matches("<button").count(), 4 + 9, "{short}");
        // A fold of one would take the room of the alert itself.
        assert_eq!(shown(&all[..4]), (4, 0));
        assert_eq!(shown(&all[..5]), (3, 2));
    }

    #[test]
    fn neighbours_become_ranges() {
        assert_eq!(ranges(&[1, 2, 3, 7, 9, 10]), "1–3, 7, 9–10");
        assert_eq!(ranges(&[]), "");
    }
}
