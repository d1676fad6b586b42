//! One wagon: verdict, what to do, every indicator with interval, limits, grade and reason, trends, and a paper for the fitter.

use super::kind::Part;
use super::words::{NOTHING, capital, data_age, icon, instant, maybe, number};
use super::{alerts, indicators, notes, outlook, paper, train, trends};
use crate::api::grade::{DataState, Grade};
use crate::api::processes::ProcessView;
use crate::api::wagons::model::WagonView;
use crate::limits::Limits;
use crate::store::Snapshot;
use maud::{Markup, html};

pub(super) fn parts(id: u32, limits: &Limits, snapshot: &Snapshot) -> Vec<Part> {
    let Some(wagon) = snapshot.wagons.iter().find(|wagon| wagon.id == id) else { return Vec::new() };
    let mut parts = vec![
        Part::new("verdict", verdict(wagon)),
        Part::new("facts", facts(wagon, snapshot)),
        Part::new("indicators", indicators::indicators(wagon, limits)),
        Part::new("wheelsets", indicators::wheelsets(wagon)),
        Part::new("wagon-alerts", alerts::of_wagon(snapshot, id)),
        Part::new("behind", behind(wagon)),
    ];
    parts.extend(train::tiles(snapshot, Some(id)));
    parts
}

pub(super) fn body(id: u32, limits: &Limits, snapshot: &Snapshot) -> Markup {
    let Some(wagon) = snapshot.wagons.iter().find(|wagon| wagon.id == id) else { return html! {} };
    let count = snapshot.wagons.len() as u32;
    html! {
        nav .strip aria-label="Wagons" {
            (step("prev", "Previous wagon", "‹", (id > 1).then(|| id - 1)))
            (train::drawing(snapshot, Some(id)))
            (step("next", "Next wagon", "›", (id < count).then(|| id + 1)))
        }
        div .lead { (verdict(wagon)) (facts(wagon, snapshot)) }
        section .card aria-labelledby="h-own" {
            div .heading { h2 #h-own { "What to do" } a href="/alerts" { "all alerts" } }
            (alerts::of_wagon(snapshot, id))
        }
        section .card aria-labelledby="h-ind" {
            div .heading { h2 #h-ind { "Indicators" } (indicators::key()) }
            (indicators::indicators(wagon, limits))
        }
        (trends::section(wagon, snapshot.wagons.len(), limits))
        section .card aria-labelledby="h-outlook" {
            div .heading { h2 #h-outlook { "Outlook" } a href="/indicators#trend" { "how trends are computed" } }
            (outlook::placeholder())
        }
        (paper::lines())
        div .columns.behind {
            (notes::section(id))
            details .card #fold-events { summary { h2 { "Latest events" } } div #events data-wagon=(id) { p .calm { "Loading events…" } } }
            details .card #fold-behind { summary { h2 { "Behind the figures" } } (indicators::wheelsets(wagon)) (behind(wagon)) }
        }
    }
}

fn step(rel: &str, name: &str, arrow: &str, id: Option<u32>) -> Markup {
    html! {
        @if let Some(id) = id {
            a .step rel=(rel) href={ "/wagons/" (id) } aria-label={ (name) ", " (id) } { (arrow) }
        } @else {
            span .step aria-hidden="true" { (arrow) }
        }
    }
}

fn verdict(wagon: &WagonView) -> Markup {
    let headline = match (wagon.state, wagon.grade) {
        (DataState::Stale, _) => "sends no data",
        (DataState::Silent, _) => "has not sent data yet",
        (_, Grade::Act) => "needs action",
        (_, Grade::Watch) => "is worth a look",
        (_, Grade::Ok) => "is well",
        (_, Grade::Unknown) => "cannot be judged yet",
    };
    html! {
        div #verdict class={ "verdict g-" (wagon.grade.word()) " s-" (wagon.state.word()) } {
            (icon(wagon.grade))
            div {
                h1 { "Wagon " (wagon.id) " " (headline) " " small { (wagon.name) } }
                p { (capital(&wagon.reason)) }
            }
        }
    }
}

fn facts(wagon: &WagonView, snapshot: &Snapshot) -> Markup {
    let now = wagon.now.as_ref();
    let alerts =
        snapshot.alerts.alerts.iter().filter(|alert| alert.active && alert.wagons.contains(&wagon.id));
    let since = alerts.map(|alert| alert.raised_at.as_str()).min();
    html! {
        dl #facts .facts.of-wagon {
            div { dt { "Speed" } dd { (maybe(now.and_then(|now| now.v_m_s).map(|v_m_s| 3.6 * v_m_s), 0)) small { " km/h" } } }
            div { dt { "Track position" } dd { (maybe(now.and_then(|now| now.position_m).map(|position_m| position_m / 1e3), 2)) small { " km" } } }
            div { dt { "Alert since" } dd .since { @match since { Some(at) => (instant(at)), None => (NOTHING) } } }
            div { dt { "Braking so far" } dd { (number(wagon.braking_s, 0)) small { " s" } } }
            div .loud[wagon.state != DataState::Live] {
                dt { "Age of the data" }
                dd { (data_age(wagon.state, wagon.age_s)) }
                @if let Some(at) = &wagon.acquired_at { dd .at { "from " (instant(at)) } }
            }
        }
    }
}

/// What the figures rest on.
fn behind(wagon: &WagonView) -> Markup {
    html! {
        dl #behind .pairs {
            dt { "Samples processed" } dd { (wagon.samples) }
            dt { "Samples lost" } dd { (wagon.samples_missed) }
            dt { "Faulty sensors" }
            dd .loud[!wagon.faulty_sensors.is_empty()] {
                @if wagon.faulty_sensors.is_empty() { "none" } @else { (wagon.faulty_sensors.join(", ")) }
            }
            dt { "Brake applications" }
            dd { (wagon.brake_applications) @if let Some(at) = &wagon.brake_applied_at { ", latest " (instant(at)) } }
            dt { "Measurements rejected by the filter" } dd { (wagon.outputs_rejected) }
            @match &wagon.estimator {
                Some(process) => (estimator(process)),
                None => { dt { "Estimator" } dd .loud { "no heartbeat" } }
            }
        }
    }
}

fn estimator(process: &ProcessView) -> Markup {
    let microseconds = |ns: u64| format!("{} µs", number(ns as f64 / 1e3, 1));
    html! {
        dt { "Estimator" } dd { "process " (process.pid) ", up for " (super::words::age(process.uptime_s)) }
        dt { "One step of the filter (median, 99 %)" }
        dd { (microseconds(process.step_p50_ns)) ", " (microseconds(process.step_p99_ns)) }
        dt { "From sample to estimate (median, 99 %)" }
        dd { (microseconds(process.latency_p50_ns)) ", " (microseconds(process.latency_p99_ns)) }
    }
}
