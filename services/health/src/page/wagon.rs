//! One wagon: verdict, what to do, every indicator with interval, limits, grade and reason, trends, and a paper for the fitter.

use super::kind::Part;
use super::words::{NOTHING, data_age, icon, instant, maybe, number, sentence, timed, vehicle};
use super::{alerts, indicators, notes, outlook, paper, train, trends};
use crate::api::grade::{DataState, Grade};
use crate::api::processes::ProcessView;
use crate::api::wagons::model::WagonView;
use crate::limits::Limits;
use crate::store::Snapshot;
use maud::{Markup, html};
use railgrip_words::{reword, say, t};

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
        nav .strip aria-label=(t("Wagons")) {
            (step("prev", t("Previous wagon"), "‹", (id > 1).then(|| id - 1)))
            (train::drawing(snapshot, Some(id)))
            (step("next", t("Next wagon"), "›", (id < count).then(|| id + 1)))
        }
        div .lead { (verdict(wagon)) (facts(wagon, snapshot)) }
        section .card aria-labelledby="h-own" {
            div .heading { h2 #h-own { (t("What to do")) } a href="/alerts" { (t("all alerts")) } }
            (alerts::of_wagon(snapshot, id))
        }
        section .card aria-labelledby="h-ind" {
            div .heading { h2 #h-ind { (t("Indicators")) } (indicators::key()) }
            (indicators::indicators(wagon, limits))
        }
        (trends::section(wagon, snapshot.wagons.len(), limits))
        section .card aria-labelledby="h-outlook" {
            div .heading { h2 #h-outlook { (t("Outlook")) } a href="/indicators#trend" { (t("how trends are computed")) } }
            (outlook::placeholder())
        }
        (paper::lines())
        div .columns.behind {
            (notes::section(id, wagon.vehicle_number.is_some()))
            details .card #fold-events { summary { h2 { (t("Latest events")) } } div #events data-wagon=(id) { p .calm { (t("Loading events…")) } } }
            details .card #fold-behind { summary { h2 { (t("Behind the figures")) } } (indicators::wheelsets(wagon)) (behind(wagon)) }
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
    let n: &[(&str, &dyn std::fmt::Display)] = &[("number", &wagon.id)];
    let headline = match (wagon.state, wagon.grade) {
        (DataState::Stale, _) => say("Wagon {number} sends no data", n),
        (DataState::Silent, _) => say("Wagon {number} has not sent data yet", n),
        (_, Grade::Act) => say("Wagon {number} needs action", n),
        (_, Grade::Watch) => say("Wagon {number} is worth a look", n),
        (_, Grade::Ok) => say("Wagon {number} is well", n),
        (_, Grade::Unknown) => say("Wagon {number} cannot be judged yet", n),
    };
    html! {
        div #verdict class={ "verdict g-" (wagon.grade.word()) " s-" (wagon.state.word()) } {
            (icon(wagon.grade))
            div {
                h1 { (headline) " " small { (wagon.name) } (vehicle(wagon.vehicle_number.as_deref())) }
                p { (timed(&sentence(&wagon.reason))) }
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
            div { dt { (t("Speed")) } dd { (maybe(now.and_then(|now| now.v_m_s).map(|v_m_s| 3.6 * v_m_s), 0)) small { " km/h" } } }
            div { dt { (t("Track position")) } dd { (maybe(now.and_then(|now| now.position_m).map(|position_m| position_m / 1e3), 2)) small { " km" } } }
            div { dt { (t("Alert since")) } dd .since { @match since { Some(at) => (instant(at)), None => (NOTHING) } } }
            div { dt { (t("Braking so far")) } dd { (number(wagon.braking_s, 0)) small { " s" } } }
            div .loud[wagon.state != DataState::Live] {
                dt { (t("Age of the data")) }
                dd { (data_age(wagon.state, wagon.age_s)) }
                @if let Some(at) = &wagon.acquired_at { dd .at { (t("from")) " " (instant(at)) } }
            }
        }
    }
}

/// What the figures rest on.
fn behind(wagon: &WagonView) -> Markup {
    html! {
        dl #behind .pairs {
            dt { (t("Vehicle number")) }
            dd {
                @match &wagon.vehicle_number {
                    Some(number) => (number),
                    None => { (t("none: what is remembered of this wagon begins with this start of the train")) }
                }
            }
            dt { (t("Samples processed")) } dd { (wagon.samples) }
            dt { (t("Samples lost")) } dd { (wagon.samples_missed) }
            dt { (t("Faulty sensors")) }
            dd .loud[!wagon.faulty_sensors.is_empty()] {
                @if wagon.faulty_sensors.is_empty() { (t("none")) } @else { (wagon.faulty_sensors.iter().map(|name| reword(name)).collect::<Vec<_>>().join(", ")) }
            }
            dt { (t("Brake applications")) }
            dd { (wagon.brake_applications) @if let Some(at) = &wagon.brake_applied_at { ", " (t("latest")) " " (instant(at)) } }
            dt { (t("Measurements rejected by the filter")) } dd { (wagon.outputs_rejected) }
            @match &wagon.estimator {
                Some(process) => (estimator(process)),
                None => { dt { (t("Estimator")) } dd .loud { (t("no heartbeat")) } }
            }
        }
    }
}

fn estimator(process: &ProcessView) -> Markup {
    let microseconds = |ns: u64| format!("{} µs", number(ns as f64 / 1e3, 1));
    html! {
        dt { (t("Estimator")) } dd { (say("process {free}, up for {age}", &[("free", &process.pid), ("age", &super::words::age(process.uptime_s))])) }
        dt { (t("One step of the filter (median, 99 %)")) }
        dd { (microseconds(process.step_p50_ns)) ", " (microseconds(process.step_p99_ns)) }
        dt { (t("From sample to estimate (median, 99 %)")) }
        dd { (microseconds(process.latency_p50_ns)) ", " (microseconds(process.latency_p99_ns)) }
    }
}
