//! One wagon: verdict, every indicator with interval, limits, grade and reason, wheelset by wheelset, trends, alerts.

use super::bar::bar;
use super::kind::Part;
use super::words::{NOTHING, Written, capital, chip, data_age, energy, icon, instant, maybe, number};
use super::{alerts, notes, outlook, train};
use crate::api::acoustic::AcousticView;
use crate::api::figure::Figure;
use crate::api::grade::{DataState, Grade};
use crate::api::processes::ProcessView;
use crate::api::wagons::model::{WagonView, WheelsetView};
use crate::limits::Limits;
use crate::store::Snapshot;
use maud::{Markup, html};
use railgrip_indicators::indicator::{ADHESION_AVAILABLE, RAIL};
use railgrip_indicators::{Form, IndicatorSpec, Limit};

pub(super) fn parts(id: u32, limits: &Limits, snapshot: &Snapshot) -> Vec<Part> {
    let Some(wagon) = snapshot.wagons.iter().find(|wagon| wagon.id == id) else { return Vec::new() };
    let mut parts = vec![
        Part::new("verdict", verdict(wagon)),
        Part::new("facts", facts(wagon, snapshot)),
        Part::new("indicators", indicators(wagon, limits)),
        Part::new("wheelsets", wheelsets(wagon, limits)),
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
        section .card aria-labelledby="h-ind" {
            div .heading { h2 #h-ind { "Indicators of the wagon" } (key()) }
            (indicators(wagon, limits))
        }
        section .card aria-labelledby="h-sets" {
            div .heading { h2 #h-sets { "Wheelsets" } p .legend { "wheelset 1 leads" } }
            (wheelsets(wagon, limits))
        }
        section .card aria-labelledby="h-outlook" {
            div .heading { h2 #h-outlook { "Outlook" } a href="/indicators#trend" { "how trends are computed" } }
            (outlook::placeholder())
        }
        (trends(wagon, limits))
        div .columns {
            section .card aria-labelledby="h-own" { h2 #h-own { "Alerts of this wagon" } (alerts::of_wagon(snapshot, id)) }
            section .card aria-labelledby="h-events" {
                h2 #h-events { "Latest events" }
                div #events data-wagon=(id) { p .calm { "Loading events…" } }
            }
            (notes::section(id))
            section .card aria-labelledby="h-behind" { h2 #h-behind { "Behind the figures" } (behind(wagon)) }
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
        dl #facts .facts {
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

fn key() -> Markup {
    let sample =
        Figure { value: Some(5.0), low: Some(4.0), high: Some(6.4), grade: Grade::Ok, reason: String::new() };
    let limit = Limit {
        scale: (0.0, 10.0),
        act_low: Some(1.5),
        watch_low: Some(3.0),
        watch_high: Some(7.5),
        act_high: Some(9.0),
    };
    html! { p .legend { (bar(&sample, &limit)) " stroke: figure, band: 95 % interval, marks: limits of watch and act" } }
}

/// One line of a table of indicators.
struct Row<'a> {
    spec: &'static IndicatorSpec,
    figure: &'a Figure,
    limit: Option<Limit>,
    at_least: bool,
}

impl<'a> Row<'a> {
    /// An indicator of a wagon or of one of its wheelsets; `lower_bound` if the adhesion available is one.
    fn new(
        (spec, figure): (&'static IndicatorSpec, &'a Figure),
        limits: &Limits,
        wagon: u32,
        lower_bound: bool,
    ) -> Self {
        let at_least = lower_bound && spec.id == ADHESION_AVAILABLE.id;
        Self { spec, figure, limit: limits.limit(spec, wagon), at_least }
    }

    fn render(&self) -> Markup {
        let bound = if self.at_least && self.figure.value.is_some() { "≥ " } else { "" };
        html! {
            tr {
                th scope="row" { a .term href={ "/indicators#" (self.spec.anchor()) } { (self.spec.label) } }
                td .num .value { (bound) (self.spec.form.value(self.figure.value)) }
                td .interval { (self.spec.form.interval(self.figure).unwrap_or_else(|| NOTHING.to_owned())) }
                td .scale { @if let Some(limit) = &self.limit { (bar(self.figure, limit)) } }
                td .grade { (chip(self.figure.grade)) }
                td .why { (capital(&self.figure.reason)) }
            }
        }
    }
}

fn indicator_table(rows: &[Row<'_>], last: &Markup) -> Markup {
    html! {
        table .indicators {
            thead { tr {
                th scope="col" { "Indicator" } th scope="col" .num { "Figure" } th scope="col" { "95 % interval" }
                th scope="col" .scale { "On its scale" } th scope="col" { "Grade" } th scope="col" .why { "Why" }
            } }
            tbody { @for row in rows { (row.render()) } (last) }
        }
    }
}

fn indicators(wagon: &WagonView, limits: &Limits) -> Markup {
    // The rail has a line of its own: a bar of probabilities.
    let shown = wagon.indicators.iter().filter(|(spec, _)| spec.id != RAIL.id);
    let rows: Vec<Row<'_>> = shown
        .map(|shown| Row::new(shown, limits, wagon.id, wagon.adhesion_available_is_lower_bound))
        .collect();
    let last = html! {
        (rail(wagon))
        @if let Some(acoustic) = &wagon.acoustic { (sound(acoustic)) }
    };
    html! { div #indicators { (indicator_table(&rows, &last)) } }
}

/// What the microphone hears.
fn sound(acoustic: &AcousticView) -> Markup {
    let probability = acoustic.wet_probability.map(|wet| format!("wet {:.0} %", 100.0 * wet));
    let state = match acoustic.state.as_str() {
        "heard" => "The last second of audio was heard".to_owned(),
        "silent" => "No data from the listener".to_owned(),
        state => format!("Microphone: {}", state.replace('_', " ")),
    };
    let advice = acoustic.decision.as_ref().map(|decision| {
        format!(
            "; advice: adhesion peaks at slip {:.3}, {:.2} there",
            decision.optimum_slip, decision.optimum_adhesion
        )
    });
    html! {
        tr {
            th scope="row" { "Rail, by microphone" }
            td .num .value { (super::words::condition(acoustic.condition)) }
            td .interval { (probability.unwrap_or_else(|| NOTHING.to_owned())) }
            td .scale {}
            td .grade {}
            td .why { (state) (advice.unwrap_or_default()) }
        }
    }
}

/// The rail's condition as shares of one bar.
fn rail(wagon: &WagonView) -> Markup {
    let shares = [
        ("dry", wagon.rail_dry),
        ("wet", wagon.rail_wet),
        ("low", wagon.rail_low),
        ("very low", wagon.rail_very_low),
    ];
    let Some(judged) = wagon.indicators.get(&RAIL) else { return html! {} };
    let mut left = 0.0;
    let shares = shares.into_iter().filter_map(|(name, share)| share.map(|share| (name, share)));
    let shares: Vec<(&str, f64)> = shares.collect();
    let pieces: Vec<(String, f64, f64)> = shares
        .iter()
        .map(|(name, share)| {
            let piece = (name.replace(' ', "-"), 200.0 * left, 200.0 * share);
            left += share;
            piece
        })
        .collect();
    let words = shares.iter().filter(|(_, share)| *share >= 0.005);
    let words: Vec<String> = words.map(|(name, share)| format!("{name} {:.0} %", 100.0 * share)).collect();
    html! {
        tr {
            th scope="row" { a .term href={ "/indicators#" (RAIL.anchor()) } { (RAIL.label) } }
            td .num .value { (super::words::condition(wagon.condition)) }
            td .interval { (if words.is_empty() { NOTHING.to_owned() } else { words.join(", ") }) }
            td .scale {
                svg .bar viewBox="0 0 200 22" preserveAspectRatio="none" aria-hidden="true" {
                    @for (name, from, width) in &pieces {
                        rect class={ "rail-" (name) } x={ (format!("{from:.1}")) } y="5" width={ (format!("{width:.1}")) } height="12" {}
                    }
                }
            }
            td .grade { (chip(judged.grade)) }
            td .why { (capital(&judged.reason)) }
        }
    }
}

fn wheelsets(wagon: &WagonView, limits: &Limits) -> Markup {
    html! {
        div #wheelsets .wheelsets {
            @if wagon.wheelsets.is_empty() { p .calm { "This wagon has not sent data yet." } }
            @for wheelset in &wagon.wheelsets {
                (one(wheelset, limits, wagon.id))
            }
        }
    }
}

fn one(wheelset: &WheelsetView, limits: &Limits, wagon: u32) -> Markup {
    let bound = wheelset.adhesion_available_is_lower_bound;
    let rows: Vec<Row<'_>> =
        wheelset.indicators.iter().map(|shown| Row::new(shown, limits, wagon, bound)).collect();
    let state = wheelset.now.as_ref().map(|now| match (now.wsp_active, now.sliding) {
        (true, _) => "slide protection acts now",
        (_, true) => "slides now",
        _ => "rolls",
    });
    let nominal = wheelset.brake_friction_to_nominal.map(|ratio| Form::PERCENT.value(Some(ratio)));
    html! {
        section aria-labelledby={ "set-" (wheelset.id) } {
            h3 id={ "set-" (wheelset.id) } { "Wheelset " (wheelset.id) small { " " (state.unwrap_or("no current data")) } }
            (indicator_table(&rows, &html! {}))
            p .aside {
                @if let Some(nominal) = nominal { "Pads " (nominal) " of nominal. " }
                "Slide energy " (energy(wheelset.slide_energy_j)) " in " (number(wheelset.slide_s, 1)) " s of sliding."
            }
        }
    }
}

/// Where the script draws the history of this wagon.
fn trends(wagon: &WagonView, limits: &Limits) -> Markup {
    let ends = |limit: &Limit| {
        let all = [limit.act_low, limit.watch_low, limit.watch_high, limit.act_high];
        all.map(|end| end.map_or_else(String::new, |end| format!("{end:.6}"))).join(" ")
    };
    let of_wagon = |spec: &'static IndicatorSpec| {
        limits.limit(spec, wagon.id).map(|limit| (spec.field(), ends(&limit).into()))
    };
    let all: serde_json::Map<String, serde_json::Value> =
        wagon.indicators.iter().filter_map(|(spec, _)| of_wagon(spec)).collect();
    html! {
        section #trends .card aria-labelledby="h-trends" data-wagon=(wagon.id) data-wheelsets=(wagon.wheelsets.len())
            data-limits=(serde_json::Value::from(all).to_string()) {
            div .heading {
                h2 #h-trends { "Trends" }
                div .ranges role="group" aria-label="Range of time" {
                    @for (seconds, name) in [(900, "15 min"), (3600, "1 h"), (21600, "6 h"), (86400, "1 day"), (604_800, "7 days"), (2_592_000, "30 days")] {
                        button type="button" data-range=(seconds) aria-pressed=(if seconds == 3600 { "true" } else { "false" }) { (name) }
                    }
                }
            }
            p #trend-state .calm role="status" { "Loading the history…" }
            div #charts .charts {}
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
