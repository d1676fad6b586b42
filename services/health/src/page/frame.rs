//! What all pages share: head, header with the age of the data, connection, footer, the dialog for alerts.

use super::assets::path;
use super::kind::{Page, Part};
use super::words::{age, chip};
use crate::api::grade::{DataState, Grade};
use crate::api::wagons::model::WagonRow;
use crate::shared::Shared;
use crate::store::Snapshot;
use maud::{DOCTYPE, Markup, html};
use railgrip_words::{Language, say, spoken, t};

/// A picture older than this means that the service itself is stuck, s.
const STUCK_S: f64 = 5.0;

/// The parts of the header.
pub(super) fn parts(shared: &Shared, snapshot: &Snapshot) -> Vec<Part> {
    vec![Part::new("pulse", pulse(shared, snapshot)), Part::new("alert-count", alert_count(snapshot))]
}

pub(super) fn document(
    page: Page,
    title: &str,
    shared: &Shared,
    snapshot: &Snapshot,
    body: &Markup,
) -> Markup {
    html! {
        (DOCTYPE)
        html lang=(spoken().tag()) data-page=(page.key()) data-train=(snapshot.train.name) {
            (head(page, title, snapshot))
            body {
                a .skip href="#main" { (t("Skip to the content")) }
                (header(page, shared, snapshot))
                p #lost .lost role="alert" hidden {}
                noscript { p .lost { (t("Without JavaScript this page does not update by itself. Reload it to see current data.")) } }
                main #main tabindex="-1" { (body) }
                (footer(shared, snapshot))
                p #announcer .unseen role="status" aria-live="polite" {}
                (dialog())
            }
        }
    }
}

/// A page about a wagon that does not exist.
pub(super) fn nowhere(shared: &Shared, snapshot: &Snapshot, id: &str) -> Markup {
    let body = html! {
        section .empty {
            h1 { (say("There is no wagon “{free}”", &[("free", &id)])) }
            p { (say("This train has the wagons 1 to {count}.", &[("count", &snapshot.wagons.len())])) " " a href="/" { (t("Back to the train")) } }
        }
    };
    document(Page::Train, t("No such wagon"), shared, snapshot, &body)
}

/// The tab shows the alarms, too: their number in its title, the worst of them as its icon.
fn head(page: Page, title: &str, snapshot: &Snapshot) -> Markup {
    let counts = snapshot.train.alerts;
    let alarms = counts.act + counts.watch;
    let icon = match alert_grade(snapshot) {
        Grade::Act => "icon-act.svg",
        Grade::Watch => "icon-watch.svg",
        Grade::Ok | Grade::Unknown => "icon.svg",
    };
    html! {
        head {
            meta charset="utf-8";
            meta name="viewport" content="width=device-width, initial-scale=1";
            meta name="color-scheme" content="light dark";
            title { @if alarms > 0 { "(" (alarms) ") " } (title) " – " (snapshot.train.name) " – railgrip" }
            link #icon rel="icon" type="image/svg+xml" href=(path(icon)) data-ok=(path("icon.svg"))
                data-watch=(path("icon-watch.svg")) data-act=(path("icon-act.svg"));
            link rel="stylesheet" href=(path("style.css"));
            script src=(path("theme.js")) {}
            script src=(path(words_of_scripts())) defer {}
            @if matches!(page, Page::Wagon(_)) {
                @for script in ["uPlot.iife.min.js", "charts.js"] { script src=(path(script)) defer {} }
            }
            @if page == Page::Settings { script src=(path("settings.js")) defer {} }
        }
    }
}

/// The script of all pages, in the language that is spoken.
fn words_of_scripts() -> &'static str {
    match spoken() {
        Language::English => "page.js",
        Language::German => "page.de.js",
    }
}

/// The grade of the worst alert.
fn alert_grade(snapshot: &Snapshot) -> Grade {
    match (snapshot.train.alerts.act, snapshot.train.alerts.watch) {
        (1.., _) => Grade::Act,
        (0, 1..) => Grade::Watch,
        (0, 0) => Grade::Ok,
    }
}

fn header(page: Page, shared: &Shared, snapshot: &Snapshot) -> Markup {
    let current = |this: Page| (page == this).then_some("page");
    html! {
        header .top {
            a .brand href="/" aria-label=(say("railgrip, train {free}", &[("free", &snapshot.train.name)])) {
                img src=(path("icon.svg")) alt="" width="28" height="28";
                span { "railgrip" small { (t("Train")) " " (snapshot.train.name) } }
            }
            nav aria-label=(t("Pages")) {
                a href="/" aria-current=[current(Page::Train)] { (t("Train")) }
                a href="/alerts" aria-current=[current(Page::Alerts)] { (t("Alerts")) " " (alert_count(snapshot)) }
                a href="/indicators" aria-current=[current(Page::Meaning)] { (t("Meaning")) }
            }
            div .state {
                (pulse(shared, snapshot))
                span #link .link data-state="connecting" role="status" { (t("connecting")) }
                button #theme type="button" .quiet { (t("Theme")) }
            }
        }
    }
}

/// How many alerts are active, as a badge.
fn alert_count(snapshot: &Snapshot) -> Markup {
    let counts = snapshot.train.alerts;
    html! {
        span #alert-count class={ "badge g-" (alert_grade(snapshot).word()) } data-act=(counts.act) data-watch=(counts.watch) {
            (counts.act + counts.watch)
            span .unseen { " " (say("active: {act} act, {watch} watch", &[("act", &counts.act), ("watch", &counts.watch)])) }
        }
    }
}

/// How old the data are and of how many wagons they arrive: never out of sight.
fn pulse(shared: &Shared, snapshot: &Snapshot) -> Markup {
    let train = &snapshot.train;
    let stuck_s = snapshot.taken.age_s(shared.now().monotonic_ns);
    let oldest = snapshot
        .rows
        .iter()
        .filter_map(|row| row.age_s)
        .fold(None, |worst: Option<f64>, age| Some(worst.map_or(age, |worst| worst.max(age))));
    let quiet: Vec<&WagonRow> = snapshot.rows.iter().filter(|row| row.state != DataState::Live).collect();
    html! {
        span #pulse .pulse .loud[!quiet.is_empty() || stuck_s > STUCK_S] {
            @if stuck_s > STUCK_S {
                b { (t("Service stuck")) } " " (t("for")) " " span data-age=(stuck_s.floor()) { (age(stuck_s)) }
            } @else if let Some(oldest) = oldest {
                b { (train.live) "\u{202f}/\u{202f}" (train.wagons) } " " (t("live, data")) " "
                span data-age=(oldest.floor()) { (age(oldest)) } " " (t("old"))
            } @else {
                b { (t("No data yet")) }
            }
        }
    }
}

fn footer(shared: &Shared, snapshot: &Snapshot) -> Markup {
    html! {
        footer {
            p { (t("railgrip advises people. It drives no brake, no traction and no slide protection.")) }
            p {
                (t("Grades:")) " " @for grade in [Grade::Ok, Grade::Watch, Grade::Act, Grade::Unknown] { (chip(grade)) " " }
                (t("Intervals are 95 %.")) " " (t("Times are")) " " span #zone { "UTC" } ". "
                (t("Page made")) " " (super::words::instant(&snapshot.train.generated_at)) "."
            }
            nav aria-label=(t("Data")) {
                a href="/api/v1/train" { (t("train")) } a href="/api/v1/wagons" { (t("wagons")) } a href="/api/v1/alerts" { (t("alerts")) }
                a href="/metrics" { (t("metrics")) } a href="/docs" { (t("interface")) }
                a href="/settings" { (t("thresholds and receivers")) }
                @for (language, name) in Language::ALL { @if language != spoken() { a href={ "?lang=" (language.tag()) } hreflang=(language.tag()) lang=(language.tag()) data-lang=(language.tag()) { (name) } } }
            }
            @if snapshot.taken.age_s(shared.now().monotonic_ns) > STUCK_S { p { (t("The service has stopped updating its data.")) } }
        }
    }
}

/// One dialog for acknowledging, silencing and taking back; the script fills it.
fn dialog() -> Markup {
    html! {
        dialog #act-dialog aria-labelledby="act-title" {
            form method="dialog" {
                h2 #act-title { (t("Acknowledge")) }
                p #act-what {}
                label { (t("Your name or initials")) " " input #act-by name="by" autocomplete="name" maxlength="100" required; }
                label #act-silence hidden { (t("Silence it for"))
                    select #act-for name="for" {
                        option value="3600" { (t("1 hour")) }
                        option value="28800" selected { (t("8 hours")) }
                        option value="86400" { (t("1 day")) }
                        option value="604800" { (t("7 days")) }
                        option value="2592000" { (t("30 days")) }
                    }
                }
                label { span #act-note-name { (t("Note (optional)")) } input #act-note name="note" maxlength="500"; }
                p #act-error .error role="alert" {}
                div .buttons {
                    button #act-cancel type="button" .quiet { (t("Cancel")) }
                    button #act-send type="submit" .primary { (t("Acknowledge")) }
                }
            }
        }
    }
}
