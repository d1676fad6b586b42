//! The train: verdict, drawing, what to do, a table of all wagons with what is wrong first, stopping distances and the rail.

use super::kind::Part;
use super::words::{
    Written, age, chip, condition, data_age, icon, maybe, sentence, timed, vehicle, wheelset,
};
use super::{alerts, paper, stopping};
use crate::api::grade::{DataState, Grade};
use crate::api::train::model::TrainView;
use crate::api::wagons::model::{WagonRow, WagonView, WheelsetView};
use crate::shared::Shared;
use crate::store::Snapshot;
use maud::{Markup, html};
use railgrip_indicators::IndicatorSpec;
use railgrip_indicators::indicator::{ASYMMETRY, BRAKE_FRICTION};
use railgrip_words::{say, t};

/// Longer trains are drawn with small wagons.
const ROOMY: usize = 16;

pub(super) fn parts(shared: &Shared, snapshot: &Snapshot) -> Vec<Part> {
    let mut parts = vec![
        Part::new("verdict", verdict(snapshot)),
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
        div .lead { (verdict(snapshot)) (facts(snapshot)) }
        section .card aria-labelledby="h-train" {
            div .heading { h2 #h-train { (t("Wagons")) } (legend()) }
            (drawing(snapshot, None))
        }
        div .columns.first {
            section .card aria-labelledby="h-todo" {
                div .heading { h2 #h-todo { (t("What to do")) } a href="/alerts" { (t("all alerts")) } }
                (alerts::todo(snapshot))
            }
            div .stack {
                section .card.all aria-labelledby="h-all" {
                    div .heading { h2 #h-all { (t("All wagons")) } (filter()) }
                    (table(snapshot))
                }
                div .columns {
                    (stopping::stop_card(snapshot))
                    (stopping::map_card(shared, snapshot))
                }
            }
        }
        (paper::lines())
    }
}

/// One sentence about the train. It is graded as the interface grades it, by figures and active alerts; what somebody has silenced
/// is only named.
fn verdict(snapshot: &Snapshot) -> Markup {
    let train = &snapshot.train;
    let silenced =
        snapshot.alerts.alerts.iter().filter(|alert| alert.silenced.is_some() && alert.active).count();
    html! {
        div #verdict class={ "verdict g-" (train.grade.word()) } {
            (icon(train.grade))
            div {
                h1 { (headline(train)) }
                p {
                    (timed(&sentence(&train.reason)))
                    @if silenced > 0 && train.grade < Grade::Watch { " (" (say("{count} silenced for a time", &[("count", &silenced)])) ")" }
                }
            }
        }
    }
}

fn headline(train: &TrainView) -> String {
    let of = |grade: Grade| train.worst.iter().filter(|row| row.grade == grade).count();
    match train.grade {
        Grade::Act if of(Grade::Act) == 0 => t("The train needs action").to_owned(),
        Grade::Act if of(Grade::Act) == 1 => t("1 wagon needs action").to_owned(),
        Grade::Act => say("{count} wagons need action", &[("count", &of(Grade::Act))]),
        // What is no wagon's own: the rail, stopping distances, a disk.
        Grade::Watch if of(Grade::Watch) == 0 => t("The train needs a look").to_owned(),
        Grade::Watch if of(Grade::Watch) == 1 => t("1 wagon needs a look").to_owned(),
        Grade::Watch => say("{count} wagons need a look", &[("count", &of(Grade::Watch))]),
        Grade::Ok if train.ready => t("All wagons are well").to_owned(),
        Grade::Ok => t("No fault known, but some wagons send no data").to_owned(),
        Grade::Unknown => t("The train cannot be judged now").to_owned(),
    }
}

/// The word behind a number of alerts.
fn alerts_in_words(count: u32) -> &'static str {
    if count == 1 { t("alert") } else { t("alerts") }
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
            div { dt { (t("Speed")) } dd { (maybe(speed, 0)) small { " km/h" } } }
            div { dt { (t("Track position")) } dd { (maybe(position, 2)) small { " km" } } }
            div { dt { (t("Needs action")) } dd { (train.alerts.act) small { " " (alerts_in_words(train.alerts.act)) } } }
            div { dt { (t("Worth a look")) } dd { (train.alerts.watch) small { " " (alerts_in_words(train.alerts.watch)) } } }
            div .loud[quiet > 0] { dt { (t("Without data")) } dd { (quiet) small { " " (say("of {count}", &[("count", &train.wagons)])) } } }
        }
    }
}

fn legend() -> Markup {
    html! {
        p .legend {
            (t("Wagon 1 is at the front.")) " "
            @for grade in [Grade::Act, Grade::Watch, Grade::Unknown, Grade::Ok] { (chip(grade)) " " }
            span .sample { (t("Wheelsets:")) " " }
            @for (grade, words) in [(Grade::Ok, t("well")), (Grade::Watch, t("watch")), (Grade::Act, t("act")), (Grade::Unknown, t("unknown"))] {
                span .sample { i class={ "axle g-" (grade.word()) } {} " " (words) }
            }
            span .sample { i .axle.g-ok.slides {} " " (t("slides now")) }
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
    let small = snapshot.rows.len() > ROOMY;
    pairs.map(|(row, wagon)| Part::new(format!("w-{}", row.id), tile(row, wagon, current, small))).collect()
}

fn tile(row: &WagonRow, wagon: &WagonView, current: Option<u32>, small: bool) -> Markup {
    let is_current = (current == Some(row.id)).then_some("page");
    let word = t(match row.state {
        DataState::Live => row.grade.word(),
        state => state.word(),
    });
    let about_axles: Vec<String> = wagon.wheelsets.iter().filter_map(about_axle).collect();
    let spoken = [format!("{} {word}", row.id), about_axles.join(", ")];
    let spoken = spoken.iter().filter(|part| !part.is_empty()).cloned().collect::<Vec<_>>().join(", ");
    html! {
        li id={ "w-" (row.id) } class={ "g-" (row.grade.word()) " s-" (row.state.word()) } {
            a .coach href={ "/wagons/" (row.id) } aria-current=[is_current] aria-label={ (t("Wagon")) " " (spoken) } {
                (row.id) " " span .word { (word) }
                @if current.is_none() && !small { span .more { (about(row)) } }
            }
            @for axle in &wagon.wheelsets {
                i class={ "axle g-" (axle.grade.word()) @if slides(axle) { " slides" } } {}
            }
        }
    }
}

/// What is worth saying of a wheelset: that it slides, or that it is not well.
fn about_axle(axle: &WheelsetView) -> Option<String> {
    let grade = Some(axle.grade).filter(|grade| *grade >= Grade::Watch).map(|grade| t(grade.word()));
    let said: Vec<&str> = grade.into_iter().chain(slides(axle).then(|| t("slides now"))).collect();
    (!said.is_empty()).then(|| format!("{} {}", wheelset(axle.id), said.join(", ")))
}

fn slides(axle: &WheelsetView) -> bool {
    axle.now.as_ref().is_some_and(|now| now.sliding || now.wsp_active)
}

/// What a roomy wagon also says.
fn about(row: &WagonRow) -> Markup {
    html! {
        @if row.state == DataState::Live {
            span { (t("pad")) " " (maybe(row.brake_friction, 3)) }
            span { (t("rail")) " " (condition(row.condition)) }
        } @else {
            (data_age(row.state, row.age_s))
        }
    }
}

/// Columns of the table, and whether they hold figures.
const COLUMNS: [(&str, bool); 9] = [
    ("Wagon", false),
    ("Grade", false),
    ("Pad friction", true),
    ("Front minus rear", true),
    ("Rail", false),
    ("Adhesion used", true),
    ("Adhesion available", true),
    ("Data age", true),
    ("Why", false),
];

/// Worst first; what is well comes in a body of its own, which the script folds.
fn table(snapshot: &Snapshot) -> Markup {
    let mut all: Vec<(&WagonRow, &WagonView)> = snapshot.rows.iter().zip(&snapshot.wagons).collect();
    // What is unknown comes behind what is wrong, and before what is well.
    let rank = |grade| match grade {
        Grade::Act => 0,
        Grade::Watch => 1,
        Grade::Unknown => 2,
        Grade::Ok => 3,
    };
    all.sort_by_key(|(row, _)| (rank(row.grade), row.id));
    let (well, others): (Vec<_>, Vec<_>) = all.into_iter().partition(|(row, _)| row.grade == Grade::Ok);
    html! {
        table .wagons {
            thead { tr {
                @for (index, (name, figures)) in COLUMNS.into_iter().enumerate() {
                    th scope="col" .num[figures] .why[index == COLUMNS.len() - 1] { button type="button" .sort { (t(name)) } }
                }
            } }
            tbody { @for (row, wagon) in &others { (line(row, wagon)) } }
            tbody .well { @for (row, wagon) in &well { (line(row, wagon)) } }
        }
        p .folding { button #fold type="button" .quiet aria-expanded="false" { (well.len()) " " (t("well")) } }
    }
}

/// Looks for a number, a name or a word in the table.
fn filter() -> Markup {
    html! {
        span .filter {
            label { (t("Filter")) " " input #filter type="search" placeholder=(t("number, name, word")) autocomplete="off"; }
            span #filtered role="status" {}
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
        (Some(true), _) => t(", slide protection acts"),
        (_, Some(true)) => t(", slides"),
        _ => "",
    };
    let bound = match (row.adhesion_available, row.adhesion_available_is_lower_bound) {
        (Some(_), Some(true)) => "≥ ",
        _ => "",
    };
    let live = row.state == DataState::Live;
    let age_s = row.age_s.filter(|_| live);
    html! {
        tr id={ "r-" (row.id) } class={ "s-" (row.state.word()) } data-grade=(row.grade.word()) {
            th scope="row" { a href={ "/wagons/" (row.id) } { (row.id) " " (row.name) } (vehicle(row.vehicle_number.as_deref())) }
            td .c-grade data-label=(t("Grade")) { (chip(row.grade)) }
            td .num data-label=(t("Pad friction")) {
                (maybe(row.brake_friction, 3)) (half(wagon, &BRAKE_FRICTION))
            }
            td .num data-label=(t("Front minus rear")) {
                (ASYMMETRY.form.value(row.asymmetry)) (half(wagon, &ASYMMETRY))
            }
            td .c-rail data-label=(t("Rail")) { (condition(row.condition)) (wheels) }
            td .num data-label=(t("Adhesion used")) { (maybe(row.adhesion.map(f64::abs), 3)) }
            td .num data-label=(t("Adhesion available")) { (bound) (maybe(row.adhesion_available, 3)) }
            @if let Some(age_s) = age_s {
                td .num data-label=(t("Data age")) data-age=(age_s.floor()) { (age(age_s)) }
            } @else {
                td .num data-label=(t("Data age")) { (data_age(row.state, row.age_s)) }
            }
            @let why = sentence(&row.reason);
            @if row.grade == Grade::Ok {
                td .why data-label=(t("Why")) { (timed(&why)) }
            } @else {
                td .why data-label=(t("Why")) { div .clamp title=(why) { (timed(&why)) } }
            }
        }
    }
}
