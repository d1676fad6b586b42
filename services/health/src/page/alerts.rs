//! Alerts: what happens where since when, what to do about it, and the buttons to acknowledge or silence it.

use super::kind::Part;
use super::words::{capital, chip, instant, plain};
use crate::alerts::model::Alert;
use crate::alerts::model::{AlertEvent, AlertState, Scope};
use crate::alerts::notify::ReceiverView;
use crate::shared::Shared;
use crate::store::Snapshot;
use maud::{Markup, html};

/// Alerts that are over and still shown; the interface has more.
const OVER_SHOWN: usize = 50;

pub(super) fn parts(shared: &Shared, snapshot: &Snapshot) -> Vec<Part> {
    vec![
        Part::new("alert-lists", lists(snapshot)),
        Part::new("receivers", receivers(&shared.receiver_states().view().receivers)),
    ]
}

pub(super) fn body(shared: &Shared, snapshot: &Snapshot) -> Markup {
    html! {
        h1 .page { "Alerts" }
        (lists(snapshot))
        section .card aria-labelledby="h-receivers" {
            h2 #h-receivers { "Receivers" }
            (receivers(&shared.receiver_states().view().receivers))
        }
    }
}

/// Receivers of alerts, and whether they can be reached.
fn receivers(receivers: &[ReceiverView]) -> Markup {
    html! {
        dl #receivers .pairs {
            @if receivers.is_empty() { dt { "Nobody is notified: the config names no [[receiver]]." } dd {} }
            @for receiver in receivers {
                dt { (receiver.name) }
                dd .loud[receiver.trouble.is_some()] {
                    (receiver.delivered) " sent"
                    @if receiver.waiting > 0 { ", " (receiver.waiting) " wait" }
                    @if receiver.refused + receiver.dropped > 0 { ", " (receiver.refused + receiver.dropped) " lost" }
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
                p .calm { @if seen.is_empty() { "No alert is active." } @else { "No new alert." } }
            }
            (list(&open))
            @if !seen.is_empty() {
                h3 .sub { "Acknowledged, still there " span .count { (seen.len()) } }
                (list(&seen))
            }
            @if silenced > 0 {
                p .calm { a href="/alerts#g-silenced" { (silenced) " silenced" } " for a time." }
            }
        }
    }
}

/// The alerts of one wagon.
pub(super) fn of_wagon(snapshot: &Snapshot, wagon: u32) -> Markup {
    let all = snapshot.alerts.alerts.iter();
    let own: Vec<&Alert> = all.filter(|alert| alert.wagons.contains(&wagon)).take(OVER_SHOWN).collect();
    html! {
        div #wagon-alerts {
            @if own.is_empty() { p .calm { "This wagon has no alerts." } }
            (list(&own))
        }
    }
}

fn lists(snapshot: &Snapshot) -> Markup {
    let over = of(snapshot, AlertState::Cleared);
    html! {
        div #alert-lists .stack {
            (group("open", "Needs attention", "No alert is active.", &of(snapshot, AlertState::Active)))
            (group("seen", "Acknowledged, still there", "None.", &of(snapshot, AlertState::Acknowledged)))
            (group("silenced", "Silenced for a time", "None.", &of(snapshot, AlertState::Silenced)))
            (group("over", "Ended", "No alert has ended yet.", &over[..over.len().min(OVER_SHOWN)]))
        }
    }
}

fn group(id: &str, title: &str, empty: &str, alerts: &[&Alert]) -> Markup {
    html! {
        section .card id={ "g-" (id) } aria-labelledby={ "h-" (id) } {
            div .heading { h2 id={ "h-" (id) } { (title) " " span .count { (alerts.len()) } } }
            @if alerts.is_empty() { p .calm { (empty) } }
            (list(alerts))
        }
    }
}

fn list(alerts: &[&Alert]) -> Markup {
    html! { ul .alerts { @for alert in alerts { (entry(alert)) } } }
}

fn entry(alert: &Alert) -> Markup {
    let over = alert.state == AlertState::Cleared;
    let grade = if over { alert.grade } else { alert.grade_now };
    let class = format!("alert g-{} a-{}", grade.word(), alert.state.word());
    html! {
        li id={ "alert-" (alert.id) } class=(class) data-alert=(alert.id) {
            div .line {
                (chip(grade))
                a .where href={ "/wagons/" (alert.wagon) } { (place(alert)) }
                span .cause { (plain(&alert.cause)) }
                span .since { (since(alert)) }
            }
            p .reason { (capital(&alert.reason)) }
            p .advice { b { "Do: " } (alert.advice) }
            (taken(alert))
            div .acts { (buttons(alert)) (more(alert)) }
        }
    }
}

/// Where it is: `Wagon 3, wheelset 2` or `Wagons 1–8`.
fn place(alert: &Alert) -> String {
    match alert.scope {
        Scope::Train if alert.wagons.len() > 1 => format!("Wagons {}", ranges(&alert.wagons)),
        _ => {
            let wheelset = alert.wheelset.map_or_else(String::new, |number| format!(", wheelset {number}"));
            format!("Wagon {}{wheelset}", alert.wagon)
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
            (instant(&alert.raised_at)) " to " (instant(cleared))
        } @else {
            "since " (instant(&alert.raised_at))
        }
        @if alert.times > 1 { ", " (alert.times) " times" }
    }
}

/// Who took care of it.
fn taken(alert: &Alert) -> Markup {
    html! {
        @if let Some(acknowledged) = &alert.acknowledged {
            p .taken {
                "✓ Acknowledged by " b { (acknowledged.by) } ", " (instant(&acknowledged.at))
                @if let Some(note) = &acknowledged.note { ": “" (note) "”" }
            }
        }
        @if let Some(silence) = &alert.silenced {
            p .taken { "Silenced by " b { (silence.by) } " until " (instant(&silence.until)) ": “" (silence.why) "”" }
        }
    }
}

fn buttons(alert: &Alert) -> Markup {
    let acts: &[(&str, &str)] = match alert.state {
        AlertState::Active => &[("acknowledge", "Acknowledge"), ("silence", "Silence")],
        AlertState::Acknowledged => &[("silence", "Silence")],
        AlertState::Silenced => &[("unsilence", "End silence")],
        AlertState::Cleared => &[],
    };
    let about = format!("alert {}: {}, {}", alert.id, place(alert), plain(&alert.cause));
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
            summary { "Evidence and history" }
            ul .course {
                @for place in &alert.places {
                    li {
                        (chip(place.grade)) " "
                        a href={ "/wagons/" (place.wagon) } { "Wagon " (place.wagon) @if let Some(set) = place.wheelset { ", wheelset " (set) } }
                        ": " (plain(&place.indicator)) ": " (place.reason)
                    }
                }
            }
            ul .course { @for event in &alert.history { (line(event)) } }
            p {
                a href={ "/wagons/" (alert.wagon) "#trends" } { "Trends of the wagon" } ", "
                a href=(alert.evidence.history) { "figures of that time" }
                @if let Some(recording) = &alert.evidence.recording { ", recording " code { (recording) } }
            }
        }
    }
}

fn line(event: &AlertEvent) -> Markup {
    html! {
        li {
            (instant(&event.at)) " " (event.change.word()) " (" (event.grade.word()) ")"
            @if let Some(by) = &event.by { " by " (by) }
            @if let Some(note) = &event.note { ": " (note) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_become_ranges() {
        assert_eq!(ranges(&[1, 2, 3, 7, 9, 10]), "1–3, 7, 9–10");
        assert_eq!(ranges(&[]), "");
    }
}
