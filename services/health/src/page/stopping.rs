//! The train as a whole: stopping distance now against nominal, the wagons that lack force, and where the rail is low.

use super::assets::path;
use super::bar::bar;
use super::kind::Part;
use super::words::{age, chip, number, sentence, vehicle};
use crate::api::adhesion_map::model::{MapCell, MapView};
use crate::api::capability::model::{CapabilityView, StopView};
use crate::api::figure::Figure;
use crate::api::grade::Grade;
use crate::shared::Shared;
use crate::store::Snapshot;
use maud::{Markup, html};
use railgrip_indicators::indicator::STOPPING_RATIO;
use railgrip_words::{say, t};

/// A cell counts as low from this probability on.
const LOW_FROM: f64 = 0.5;
/// Low stretches that are listed; the worst come first when there are more.
const MOST_STRETCHES: usize = 6;
pub(super) fn parts(shared: &Shared, snapshot: &Snapshot) -> Vec<Part> {
    let whole = &snapshot.whole;
    vec![
        Part::new("stops", stops(&whole.capability)),
        Part::new("stretches", stretches(&whole.map, since_s(shared, snapshot))),
    ]
}

/// How far the train runs.
pub(super) fn stop_card(snapshot: &Snapshot) -> Markup {
    html! {
        section .card aria-labelledby="h-stop" {
            div .heading {
                h2 #h-stop { (t("Stopping distance now")) }
                a href="/indicators#stopping-distance" { (t("how it is worked out")) }
            }
            (stops(&snapshot.whole.capability))
        }
    }
}

/// Where the rail is low.
pub(super) fn map_card(shared: &Shared, snapshot: &Snapshot) -> Markup {
    html! {
        section .card aria-labelledby="h-map" {
            div .heading {
                h2 #h-map { (t("Adhesion along the track")) }
                a href="/indicators#map" { (t("where this comes from")) }
            }
            (stretches(&snapshot.whole.map, since_s(shared, snapshot)))
            // What draws it is most of what the page weighs; the script fetches it once there is something to draw.
            div #map .map data-library=(path("uPlot.iife.min.js")) data-charts=(path("charts.js")) {}
        }
    }
}

/// Age of the snapshot, so that ages on the map go on while the service is stuck.
fn since_s(shared: &Shared, snapshot: &Snapshot) -> f64 {
    snapshot.taken.age_s(shared.now().monotonic_ns)
}

fn stops(capability: &CapabilityView) -> Markup {
    html! {
        div #stops {
            p .stops-word { (chip(capability.grade)) " " (sentence(&capability.reason)) }
            table .stops {
                thead { tr {
                    th scope="col" { (t("From speed")) } th scope="col" .num { (t("Now")) } th scope="col" { (t("95 % interval")) }
                    th scope="col" .scale { (t("Against nominal")) } th scope="col" .num { (t("Nominal")) }
                } }
                tbody { @for stop in &capability.stops { (stop_line(stop, capability.grade)) } }
            }
            @if capability.worst_wagons.is_empty() {
                p .aside { (t("No wagon lacks more than 5 % of its brake force.")) }
            } @else {
                p .aside {
                    (t("Weakest:")) " "
                    @for (index, weak) in capability.worst_wagons.iter().enumerate() {
                        @if index > 0 { "; " }
                        a href={ "/wagons/" (weak.wagon) } { (say("wagon {number}", &[("number", &weak.wagon)])) } (vehicle(weak.vehicle_number.as_deref()))
                        " " (say("{share} % of its force", &[("share", &number(100.0 * weak.brake_share, 0))])) ", " (t(weak.lack.words()))
                    }
                    "."
                }
            }
        }
    }
}

fn stop_line(stop: &StopView, grade: Grade) -> Markup {
    let over = |metres: f64| Some(metres / stop.nominal_m.max(1e-9));
    let ratio = Figure {
        value: over(stop.distance_m),
        low: over(stop.low_m),
        high: over(stop.high_m),
        grade,
        reason: String::new(),
    };
    html! {
        tr {
            th scope="row" { (number(stop.speed_km_h, 0)) " km/h" }
            td .num .value { (number(stop.distance_m, 0)) " m" }
            td .interval { (say("{low} to {high}", &[("low", &number(stop.low_m, 0)), ("high", &number(stop.high_m, 0))])) " m" }
            td .scale { (bar(&ratio, &STOPPING_RATIO)) }
            td .num { (number(stop.nominal_m, 0)) " m" }
        }
    }
}

/// Neighbouring cells that are low.
#[derive(Debug, Clone, PartialEq)]
struct Stretch {
    from_m: f64,
    to_m: f64,
    adhesion: f64,
    low: f64,
    high: f64,
    sure: f64,
    wagons: u32,
    slides: u32,
    age_s: f64,
}

impl Stretch {
    fn of(cell: &MapCell) -> Self {
        Self {
            from_m: cell.from_m,
            to_m: cell.to_m,
            adhesion: cell.adhesion,
            low: cell.low,
            high: cell.high,
            sure: cell.low_probability,
            wagons: cell.wagons,
            slides: cell.slides,
            age_s: cell.age_s,
        }
    }

    /// Takes in the next cell; the worst place speaks for all.
    fn take(&mut self, cell: &MapCell) {
        if cell.adhesion < self.adhesion {
            (self.adhesion, self.low, self.high) = (cell.adhesion, cell.low, cell.high);
        }
        self.to_m = cell.to_m;
        self.sure = self.sure.max(cell.low_probability);
        self.wagons = self.wagons.max(cell.wagons);
        self.slides += cell.slides;
        self.age_s = self.age_s.min(cell.age_s);
    }
}

fn low_stretches(map: &MapView) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = Vec::new();
    for cell in map.cells.iter().filter(|cell| cell.low_probability >= LOW_FROM) {
        match found.last_mut().filter(|last| (last.to_m - cell.from_m).abs() < 0.5 * map.cell_m) {
            Some(last) => last.take(cell),
            None => found.push(Stretch::of(cell)),
        }
    }
    found
}

fn stretches(map: &MapView, since_s: f64) -> Markup {
    let mut found = low_stretches(map);
    let all = found.len();
    if all > MOST_STRETCHES {
        found.sort_by(|a, b| a.adhesion.total_cmp(&b.adhesion));
        found.truncate(MOST_STRETCHES);
    }
    html! {
        div #stretches {
            @if map.cells.is_empty() {
                p .calm { (t("No wagon has reported a position and an adhesion yet.")) }
            } @else if found.is_empty() {
                p .calm { (say("No low stretch on the {length} km travelled so far.", &[("length", &kilometres(map))])) }
            }
            ul .stretches {
                @for stretch in &found {
                    li {
                        b { "km " (range(stretch.from_m / 1e3, stretch.to_m / 1e3, 2)) } ": "
                        (t("adhesion")) " " b { (number(stretch.adhesion, 3)) } " (" (range(stretch.low, stretch.high, 3)) ") "
                        (say("at its worst, {share} % probability that it is low", &[("share", &number(100.0 * stretch.sure, 0))])) "; "
                        @if stretch.wagons == 1 { (t("1 wagon passed")) } @else { (say("{count} wagons passed", &[("count", &stretch.wagons)])) }
                        @if stretch.slides > 0 { (t(", wheelsets slid")) } ", "
                        (say("last {age} ago", &[("age", &age((stretch.age_s + since_s).floor()))]))
                    }
                }
            }
            @if all > found.len() { p .aside { (say("{count} more stretches, less low.", &[("count", &(all - found.len()))])) } }
        }
    }
}

fn range(low: f64, high: f64, digits: usize) -> String {
    say("{low} to {high}", &[("low", &number(low, digits)), ("high", &number(high, digits))])
}

fn kilometres(map: &MapView) -> String {
    number(map.cells.len() as f64 * map.cell_m / 1e3, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_low_cells_are_one_stretch() {
        let cell = |index: u32, low_probability: f64, adhesion: f64| MapCell {
            from_m: 50.0 * f64::from(index),
            to_m: 50.0 * f64::from(index + 1),
            adhesion,
            low: adhesion - 0.01,
            high: adhesion + 0.01,
            low_probability,
            wagons: index,
            slides: 1,
            age_s: f64::from(index),
        };
        let cells = vec![
            cell(1, 0.1, 0.3),
            cell(2, 0.9, 0.06),
            cell(3, 0.8, 0.05),
            cell(4, 0.2, 0.2),
            cell(9, 0.7, 0.07),
        ];
        let found = low_stretches(&MapView { cell_m: 50.0, cells });
        assert_eq!(found.len(), 2);
        let first = &found[0];
        assert_eq!((first.from_m, first.to_m, first.adhesion, first.low), (100.0, 200.0, 0.05, 0.04));
        assert_eq!((first.sure, first.wagons, first.slides, first.age_s), (0.9, 3, 2, 2.0));
    }
}
