//! The indicators of a wagon and its wheelsets in one table, by grade: what is wrong first, then what is unknown and what is
//! well, both folded with the names that they hold.

use super::bar::bar;
use super::words::{NOTHING, Written, chip, condition, energy, number, sentence};
use crate::api::acoustic::AcousticView;
use crate::api::figure::Figure;
use crate::api::grade::Grade;
use crate::api::wagons::model::{WagonView, WheelsetView};
use crate::limits::Limits;
use maud::{Markup, html};
use railgrip_indicators::indicator::{ADHESION_AVAILABLE, RAIL};
use railgrip_indicators::{Form, IndicatorSpec, Limit};
use railgrip_words::{say, t};

/// Explains the bars.
pub(super) fn key() -> Markup {
    let sample =
        Figure { value: Some(5.0), low: Some(4.0), high: Some(6.4), grade: Grade::Ok, reason: String::new() };
    let limit = Limit {
        scale: (0.0, 10.0),
        act_low: Some(1.5),
        watch_low: Some(3.0),
        watch_high: Some(7.5),
        act_high: Some(9.0),
    };
    html! { p .legend { (bar(&sample, &limit)) " " (t("stroke: figure, band: 95 % interval, marks: limits of watch and act")) } }
}

/// One line of the table.
struct Row {
    grade: Grade,
    /// Its name, for the line of a fold.
    name: String,
    html: Markup,
}

impl Row {
    /// An indicator of the wagon or of one of its wheelsets; `lower_bound` if the adhesion available is one.
    fn new(
        (spec, figure): (&'static IndicatorSpec, &Figure),
        limit: Option<Limit>,
        wheelset: Option<u32>,
        lower_bound: bool,
    ) -> Self {
        let at_least = lower_bound && spec.id == ADHESION_AVAILABLE.id && figure.value.is_some();
        let place = place(wheelset);
        let html = html! {
            // What raises no alert repeats in other words what one has already said; a phone leaves it to the charts.
            tr .also[spec.alert.is_none()] {
                th scope="row" data-place=(place) { a .term href={ "/indicators#" (spec.anchor()) } { (t(spec.name())) } }
                td .place { (place) }
                td .num .value { @if at_least { "≥ " } (spec.form.value(figure.value)) }
                td .interval { (spec.form.interval(figure).unwrap_or_else(|| NOTHING.to_owned())) }
                td .scale { @if let Some(limit) = &limit { (bar(figure, limit)) } }
                td .grade { (chip(figure.grade)) }
                td .why { (sentence(&figure.reason)) }
            }
        };
        let name = t(spec.name()).to_owned();
        Self { grade: figure.grade, name, html }
    }
}

fn place(wheelset: Option<u32>) -> String {
    wheelset.map_or_else(|| t("wagon").to_owned(), super::words::wheelset)
}

/// The whole table as a part.
pub(super) fn indicators(wagon: &WagonView, limits: &Limits) -> Markup {
    let rows = rows(wagon, limits);
    let of =
        |wanted: fn(Grade) -> bool| -> Vec<&Row> { rows.iter().filter(|row| wanted(row.grade)).collect() };
    let mut wrong = of(|grade| grade >= Grade::Watch);
    wrong.sort_by_key(|row| std::cmp::Reverse(row.grade));
    html! {
        div #indicators .graded {
            @if wrong.is_empty() { p .calm { (t("Nothing that is known is wrong.")) } } @else { (table(&wrong)) }
            (fold("unknown", t("not known yet"), &of(|grade| grade == Grade::Unknown)))
            (fold("well", t("well"), &of(|grade| grade == Grade::Ok)))
        }
    }
}

fn rows(wagon: &WagonView, limits: &Limits) -> Vec<Row> {
    let limit = |spec: &'static IndicatorSpec| limits.limit(spec, wagon.id);
    // The rail has a line of its own: a bar of probabilities.
    let shown = wagon.indicators.iter().filter(|(spec, _)| spec.id != RAIL.id);
    let bound = wagon.adhesion_available_is_lower_bound;
    let mut rows: Vec<Row> = shown.map(|one| Row::new(one, limit(one.0), None, bound)).collect();
    rows.extend(rail(wagon));
    rows.extend(wagon.acoustic.as_ref().map(sound));
    for set in &wagon.wheelsets {
        let bound = set.adhesion_available_is_lower_bound;
        rows.extend(set.indicators.iter().map(|one| Row::new(one, limit(one.0), Some(set.id), bound)));
    }
    rows
}

fn table(rows: &[&Row]) -> Markup {
    html! {
        table .indicators {
            thead { tr {
                th scope="col" { (t("Indicator")) } th scope="col" { (t("Where")) } th scope="col" .num { (t("Figure")) }
                th scope="col" { (t("95 % interval")) } th scope="col" .scale { (t("On its scale")) } th scope="col" { (t("Grade")) }
                th scope="col" .why { (t("Why")) }
            } }
            tbody { @for row in rows { (row.html) } }
        }
    }
}

/// Lines that nobody needs to read now, under a line that names them.
fn fold(id: &str, words: &str, rows: &[&Row]) -> Markup {
    let mut names: Vec<&str> = Vec::new();
    for row in rows {
        if !names.contains(&row.name.as_str()) {
            names.push(&row.name);
        }
    }
    html! {
        @if !rows.is_empty() {
            details .fold id={ "fold-" (id) } {
                summary { b { (rows.len()) " " (words) } span .names { (names.join(", ")) } }
                (table(rows))
            }
        }
    }
}

/// What the wheelsets do now, as a part.
pub(super) fn wheelsets(wagon: &WagonView) -> Markup {
    html! {
        ul #wheelsets .sets {
            @if wagon.wheelsets.is_empty() { li .calm { (t("This wagon has not sent data yet.")) } }
            @for wheelset in &wagon.wheelsets { (wheelset_line(wheelset)) }
        }
    }
}

fn wheelset_line(wheelset: &WheelsetView) -> Markup {
    let state = wheelset.now.as_ref().map(|now| match (now.wsp_active, now.sliding) {
        (true, _) => t("slide protection acts now"),
        (_, true) => t("slides now"),
        _ => t("rolls"),
    });
    let nominal = wheelset.brake_friction_to_nominal.map(|ratio| Form::PERCENT.value(Some(ratio)));
    html! {
        li {
            b { (super::words::capital(&super::words::wheelset(wheelset.id))) } " " (state.unwrap_or_else(|| t("no current data")))
            @if let Some(nominal) = nominal { ", " (say("pads {share} of nominal", &[("share", &nominal)])) }
            ", " (say("slide energy {energy} in {time} s of sliding", &[("energy", &energy(wheelset.slide_energy_j)), ("time", &number(wheelset.slide_s, 1))]))
        }
    }
}

/// What the microphone hears.
fn sound(acoustic: &AcousticView) -> Row {
    let probability =
        acoustic.wet_probability.map(|wet| say("wet {share} %", &[("share", &number(100.0 * wet, 0))]));
    let state = match acoustic.state.as_str() {
        "heard" => t("The last second of audio was heard").to_owned(),
        "silent" => t("No data from the listener").to_owned(),
        state => say("Microphone: {free}", &[("free", &state.replace('_', " "))]),
    };
    let advice = acoustic.decision.as_ref().map(|decision| {
        say(
            "; advice: adhesion peaks at slip {slip}, {adhesion} there",
            &[
                ("slip", &number(decision.optimum_slip, 3)),
                ("adhesion", &number(decision.optimum_adhesion, 2)),
            ],
        )
    });
    let name = t("Rail, by microphone").to_owned();
    let html = html! {
        tr {
            th scope="row" data-place=(t("wagon")) { (name) }
            td .place { (t("wagon")) }
            td .num .value { (condition(acoustic.condition)) }
            td .interval { (probability.unwrap_or_else(|| NOTHING.to_owned())) }
            td .scale {}
            td .grade {}
            td .why { (state) (advice.unwrap_or_default()) }
        }
    };
    // Advice that nothing judges: it stands with what is well unless nothing is heard.
    let grade = if acoustic.condition.is_some() { Grade::Ok } else { Grade::Unknown };
    Row { grade, name, html }
}

/// The rail's condition as shares of one bar.
fn rail(wagon: &WagonView) -> Option<Row> {
    let shares = [
        ("dry", wagon.rail_dry),
        ("wet", wagon.rail_wet),
        ("low", wagon.rail_low),
        ("very low", wagon.rail_very_low),
    ];
    let judged = wagon.indicators.get(&RAIL)?;
    let mut left = 0.0;
    let shares = shares.into_iter().filter_map(|(name, share)| share.map(|share| (name, share)));
    let shares: Vec<(&'static str, f64)> = shares.collect();
    let pieces: Vec<(String, f64, f64)> = shares
        .iter()
        .map(|(name, share)| {
            let piece = (name.replace(' ', "-"), 200.0 * left, 200.0 * share);
            left += share;
            piece
        })
        .collect();
    let words = shares.iter().filter(|(_, share)| *share >= 0.005);
    let words: Vec<String> = words
        .map(|(name, share)| {
            say("{class} {share} %", &[("class", &t(name)), ("share", &number(100.0 * share, 0))])
        })
        .collect();
    let html = html! {
        tr {
            th scope="row" data-place=(t("wagon")) { a .term href={ "/indicators#" (RAIL.anchor()) } { (t(RAIL.name())) } }
            td .place { (t("wagon")) }
            td .num .value { (condition(wagon.condition)) }
            td .interval { (if words.is_empty() { NOTHING.to_owned() } else { words.join(", ") }) }
            td .scale {
                svg .bar viewBox="0 0 200 22" preserveAspectRatio="none" aria-hidden="true" {
                    @for (name, from, width) in &pieces {
                        rect class={ "rail-" (name) } x={ (format!("{from:.1}")) } y="5" width={ (format!("{width:.1}")) } height="12" {}
                    }
                }
            }
            td .grade { (chip(judged.grade)) }
            td .why { (sentence(&judged.reason)) }
        }
    };
    Some(Row { grade: judged.grade, name: t(RAIL.name()).to_owned(), html })
}
