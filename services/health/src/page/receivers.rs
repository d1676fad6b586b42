//! Who is notified of alerts, as the config says it, and the way to add, change or remove one.

use crate::settings::model::{LeastGrade, ReceiverKind, ReceiverSetting, ReceiverSettingList};
use maud::{Markup, html};
use railgrip_words::t;

/// The receivers as a table.
pub(super) fn card(list: &ReceiverSettingList) -> Markup {
    let may_change = list.file.is_some();
    html! {
        section .card aria-labelledby="h-receivers" {
            div .heading {
                h2 #h-receivers { (t("Who is notified of alerts")) }
                @if may_change { button type="button" data-receiver="" { (t("Add a receiver")) } }
            }
            @if list.receivers.is_empty() {
                p .calm { (t("Nobody is notified: the config names no [[receiver]].")) }
            } @else {
                div .scroll { table #receiver-settings .settings {
                    thead { tr {
                        th scope="col" { (t("Receiver")) } th scope="col" { (t("Way")) } th scope="col" { (t("Address")) }
                        th scope="col" { (t("Is told of")) } th scope="col" { (t("Holds")) }
                        @if may_change { th scope="col" { (t("Change")) } }
                    } }
                    tbody { @for receiver in &list.receivers { (row(receiver, may_change)) } }
                } }
                p .aside { (t("How many notifications wait and who cannot be reached stands on the page of the alerts.")) " " a href="/alerts#receivers" { (t("Alerts")) } }
            }
        }
    }
}

fn row(receiver: &ReceiverSetting, may_change: bool) -> Markup {
    let name = &receiver.name;
    html! {
        tr {
            th scope="row" { (name) }
            td data-label=(t("Way")) { (way(receiver.kind)) }
            td data-label=(t("Address")) { code { (receiver.address) } @if let Some(topic) = &receiver.topic { br; code { (topic) } } (tls(receiver)) }
            td data-label=(t("Is told of")) { (told_of(receiver.grade)) }
            td data-label=(t("Holds")) {
                @match (receiver.now, receiver.next) {
                    (true, true) => { (t("now")) }
                    (_, true) => { mark { (t("from the next start on")) } }
                    (_, false) => { mark { (t("until the next start")) } }
                }
            }
            @if may_change {
                td .wide {
                    @if receiver.next { div .acts {
                        button type="button" .quiet data-receiver=(name) data-kind=(receiver.kind.word()) data-grade=(receiver.grade.word())
                            data-address=(receiver.address) data-topic=[receiver.topic.as_ref()] data-secret[receiver.secret]
                            data-tls[receiver.tls == Some(true)] data-ca=[receiver.ca_file.as_ref()]
                            aria-label={ (t("Change")) " " (name) } { (t("Change")) }
                        button type="button" .quiet data-receiver=(name) data-remove aria-label={ (t("Remove")) " " (name) } { (t("Remove")) }
                    } }
                }
            }
        }
    }
}

/// How a broker is known for the right one.
fn tls(receiver: &ReceiverSetting) -> Markup {
    html! {
        @if receiver.tls == Some(true) {
            br;
            @match &receiver.ca_file {
                Some(file) => { (t("TLS, authorities in")) " " code { (file) } },
                None => (t("TLS, public authorities")),
            }
        }
    }
}

fn way(kind: ReceiverKind) -> &'static str {
    match kind {
        ReceiverKind::Webhook => t("webhook (HTTP POST)"),
        ReceiverKind::Mqtt => t("MQTT broker"),
    }
}

fn told_of(grade: LeastGrade) -> &'static str {
    match grade {
        LeastGrade::Watch => t("all alerts"),
        LeastGrade::Act => t("what needs action"),
    }
}

/// One dialog for all three; the script fills it and hides what does not belong.
pub(super) fn dialog() -> Markup {
    html! {
        dialog #receiver-dialog aria-labelledby="receiver-title" {
            form method="dialog" {
                h2 #receiver-title data-add=(t("Add a receiver")) data-change=(t("Change a receiver")) data-remove=(t("Remove a receiver")) { (t("Add a receiver")) }
                label { (t("Name")) " " input #receiver-name name="name" maxlength="64" required; }
                label data-for="add" { (t("Way")) " " select #receiver-kind name="kind" {
                    @for kind in [ReceiverKind::Webhook, ReceiverKind::Mqtt] { option value=(kind.word()) { (way(kind)) } }
                } }
                label data-for="webhook" { (t("Address")) " " input #receiver-url name="url" type="url" maxlength="500"; }
                label data-for="mqtt" { (t("Host")) " " input #receiver-host name="host" maxlength="255"; }
                label data-for="mqtt" { (t("Port")) " " input #receiver-port name="port" type="number" min="1" max="65535"; }
                label .tick data-for="mqtt" { input #receiver-tls type="checkbox" name="tls"; " " (t("By TLS: encrypted, and the broker proves who it is")) }
                label data-for="tls" { (t("File with its authorities (PEM); empty for the public ones")) " " input #receiver-ca_file name="ca_file" maxlength="500" placeholder="ca.pem"; }
                label data-for="topic" { (t("Topic")) " " input #receiver-topic name="topic" maxlength="200"; }
                p #receiver-kept data-for="kept" {}
                label data-for="grade" { (t("Is told of")) " " select #receiver-grade name="grade" {
                    @for grade in [LeastGrade::Watch, LeastGrade::Act] { option value=(grade.word()) { (told_of(grade)) } }
                } }
                label { (t("Your name or initials")) " " input #receiver-by name="by" autocomplete="name" maxlength="100"; }
                label { (t("Reason")) " " input #receiver-why name="why" maxlength="500" required; }
                p #receiver-error .error role="alert" {}
                div .buttons {
                    button #receiver-cancel type="button" .quiet { (t("Cancel")) }
                    button #receiver-send type="submit" .primary { (t("Change")) }
                }
            }
        }
    }
}
