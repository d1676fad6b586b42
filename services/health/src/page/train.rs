//! The train: verdict, drawing, what to do, and a table of all wagons.

use super::kind::Part;
use super::words::{NOTHING, Written, capital, chip, condition, data_age, icon, maybe, number};
use super::{alerts, stopping};
use crate::api::grade::{DataState, Grade};
use crate::api::train::model::TrainView;
use crate::api::wagons::model::{WagonRow, WagonView, WheelsetView};
use crate::shared::Shared;
use crate::store::Snapshot;
use maud::{Markup, html};
use railgrip_indicators::IndicatorSpec;
use railgrip_indicators::indicator::{ASYMMETRY, BRAKE_FRICTION, SLIDES};

/// Longer trains are drawn with small wagons.
const ROOMY: usize = 16;

pub(super) fn parts(shared: &Shared, snapshot: &Snapshot) -> Vec<Part> {
    let mut parts = vec![
        Part::new("verdict", verdict(&snapshot.train)),
        Part::new("facts", facts(snapshot)),
        Part::new("todo", alerts::todo(snapshot)),
    ];
    parts.extend(tiles(snapshot, None));
    parts.extend(stopping::parts(shared, snapshot));
    let pairs = snapshot.rows.iter().zip(&snapshot.wagons);
    parts.extend(pairs.map(|(row, wagon)| Part::new(format!("r-{}", row.id), line(row, wagon))));
    parts
}

pub(super) fn body(shared: &Shared, snapshot: &Snapshot) -> Markup {
    html! {
        div .lead { (verdict(&snapshot.train)) (facts(snapshot)) }
        section .card aria-labelledby="h-train" {
            div .heading { h2 #h-train { "Wagons" } (legend()) }
            (drawing(snapshot, None))
        }
        div .columns {
            div .stack {
                section .card aria-labelledby="h-todo" {
                    div .heading { h2 #h-todo { "What to do" } a href="/alerts" { "all alerts" } }
                    (alerts::todo(snapshot))
                }
                (stopping::stop_card(snapshot))
            }
            (stopping::map_card(shared, snapshot))
        }
        section .card aria-labelledby="h-all" {
            div .heading { h2 #h-all { "All wagons" } }
            (table(snapshot))
        }
    }
}

/// One sentence about the train.
fn verdict(train: &TrainView) -> Markup {
    html! {
        div #verdict class={ "verdict g-" (train.grade.word()) } {
            (icon(train.grade))
            div {
                h1 { (headline(train)) }
                p { (capital(&train.reason)) }
            }
        }
    }
}

fn headline(train: &TrainView) -> String {
    let of = |grade: Grade| train.worst.iter().filter(|row| row.grade == grade).count();
    let wagons =
        |count: usize| if count == 1 { "1 wagon needs".to_owned() } else { format!("{count} wagons need") };
    match train.grade {
        Grade::Act => format!("{} action", wagons(of(Grade::Act))),
        Grade::Watch => format!("{} a look", wagons(of(Grade::Watch))),
        Grade::Ok if train.ready => "All wagons are well".to_owned(),
        Grade::Ok => "No fault known, but some wagons send no data".to_owned(),
        Grade::Unknown => "The train cannot be judged now".to_owned(),
    }
}

/// The train in figures.
fn facts(snapshot: &Snapshot) -> Markup {
    let train = &snapshot.train;
    let speed = snapshot.rows.iter().find_map(|row| row.v_m_s).map(|v| 3.6 * v);
    let position = snapshot
        .wagons
        .iter()
        .find_map(|wagon| wagon.now.as_ref()?.position_m)
        .map(|position_m| position_m / 1e3);
    let quiet = train.stale + train.silent;
    html! {
        dl #facts .facts {
            div { dt { "Speed" } dd { (maybe(speed, 0)) small { " km/h" } } }
            div { dt { "Track position" } dd { (maybe(position, 2)) small { " km" } } }
            div { dt { "Needs action" } dd { (train.alerts.act) small { " alerts" } } }
            div { dt { "Worth a look" } dd { (train.alerts.watch) small { " alerts" } } }
            div .loud[quiet > 0] { dt { "Without data" } dd { (quiet) small { " of " (train.wagons) } } }
        }
    }
}

fn legend() -> Markup {
    html! {
        p .legend {
            "Wagon 1 is at the front. "
            @for grade in [Grade::Ok, Grade::Watch, Grade::Act, Grade::Unknown] { (chip(grade)) " " }
        }
    }
}

/// The row of wagons; `current` is the wagon of this page.
pub(super) fn drawing(snapshot: &Snapshot, current: Option<u32>) -> Markup {
    let size = if current.is_some() || snapshot.rows.len() > ROOMY { "small" } else { "roomy" };
    html! {
        ol class={ "train " (size) } {
            @for part in tiles(snapshot, current) { (part.html) }
        }
    }
}

/// The wagons of the drawing.
pub(super) fn tiles(snapshot: &Snapshot, current: Option<u32>) -> Vec<Part> {
    let pairs = snapshot.rows.iter().zip(&snapshot.wagons);
    pairs.map(|(row, wagon)| Part::new(format!("w-{}", row.id), tile(row, wagon, current))).collect()
}

fn tile(row: &WagonRow, wagon: &WagonView, current: Option<u32>) -> Markup {
    let is_current = (current == Some(row.id)).then_some("page");
    let word = match row.state {
        DataState::Live => row.grade.word(),
        state => state.word(),
    };
    let axles = wagon.wheelsets.iter();
    html! {
        li id={ "w-" (row.id) } {
            a href={ "/wagons/" (row.id) } class={ "wagon g-" (row.grade.word()) " s-" (row.state.word()) }
                aria-current=[is_current] {
                span .coach {
                    span .no { span .unseen { "Wagon " } (row.id) }
                    span .word { (icon(row.grade)) (word) }
                    span .more { (about(row)) }
                }
                span .gear {
                    @for axle in axles {
                        @let grade = worst(axle);
                        @let sliding = axle.now.as_ref().is_some_and(|now| now.sliding || now.wsp_active);
                        span class={ "axle g-" (grade.word()) @if sliding { " slides" } } {
                            span .unseen {
                                ", wheelset " (axle.id) " " (grade.word()) @if sliding { ", slides now" }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The worst grade of what shows on one axle: its pads and its slides.
fn worst(axle: &WheelsetView) -> Grade {
    let shown = [&BRAKE_FRICTION, &SLIDES].into_iter().filter_map(|spec| axle.indicators.get(spec));
    shown.map(|figure| figure.grade).max().unwrap_or(Grade::Unknown)
}

/// What a roomy wagon also says.
fn about(row: &WagonRow) -> Markup {
    html! {
        @if row.state == DataState::Live {
            span { "pad " (maybe(row.brake_friction, 3)) }
            span { "rail " (condition(row.condition)) }
        } @else {
            (data_age(row.state, row.age_s))
        }
    }
}

fn table(snapshot: &Snapshot) -> Markup {
    html! {
        table .wagons {
            thead { tr {
                th scope="col" { "Wagon" }
                th scope="col" { "Grade" }
                th scope="col" .num { "Pad friction" }
                th scope="col" .num { "Front − rear" }
                th scope="col" { "Rail" }
                th scope="col" .num { "Adhesion used" }
                th scope="col" .num { "available" }
                th scope="col" { "Wheels" }
                th scope="col" .num { "km/h" }
                th scope="col" .num { "Data age" }
                th scope="col" .why { "Why" }
            } }
            tbody {
                @for (row, wagon) in snapshot.rows.iter().zip(&snapshot.wagons) { (line(row, wagon)) }
            }
        }
    }
}

/// Half of the 95 % interval, behind its figure.
fn half(wagon: &WagonView, spec: &IndicatorSpec) -> Markup {
    let figure = wagon.indicators.get(spec).filter(|figure| figure.value.is_some());
    let ends = figure.and_then(|figure| figure.low.zip(figure.high)).filter(|(low, high)| low < high);
    let half = ends.map(|(low, high)| 0.5 * (high - low));
    html! { @if half.is_some() { small .half { " ±" (spec.form.value(half)) } } }
}

fn line(row: &WagonRow, wagon: &WagonView) -> Markup {
    let wheels = match (row.wsp_active, row.sliding) {
        (Some(true), _) => "WSP acts",
        (_, Some(true)) => "slide",
        (None, _) => NOTHING,
        _ => "roll",
    };
    let bound = match (row.adhesion_available, row.adhesion_available_is_lower_bound) {
        (Some(_), Some(true)) => "≥ ",
        _ => "",
    };
    let speed = row.v_m_s.map_or_else(|| NOTHING.to_owned(), |v| number(3.6 * v, 0));
    html! {
        tr id={ "r-" (row.id) } class={ "s-" (row.state.word()) } {
            th scope="row" { a href={ "/wagons/" (row.id) } { b { (row.id) } " " (row.name) } }
            td data-label="Grade" { (chip(row.grade)) }
            td .num data-label="Pad friction" {
                (maybe(row.brake_friction, 3)) (half(wagon, &BRAKE_FRICTION))
            }
            td .num data-label="Front − rear" {
                (ASYMMETRY.form.value(row.asymmetry)) (half(wagon, &ASYMMETRY))
            }
            td data-label="Rail" { (condition(row.condition)) }
            td .num data-label="Grip used" { (maybe(row.adhesion.map(f64::abs), 3)) }
            td .num data-label="Grip there" { (bound) (maybe(row.adhesion_available, 3)) }
            td data-label="Wheels" { (wheels) }
            td .num data-label="km/h" { (speed) }
            td .num data-label="Data age" { (data_age(row.state, row.age_s)) }
            td .why data-label="Why" { (capital(&row.reason)) }
        }
    }
}
