//! Thresholds and receivers: what holds, what the next start will bring, and the way to change one.

use super::receivers;
use super::words::number;
use crate::settings::model::{ReceiverSettingList, Setting, SettingList};
use maud::{Markup, html};
use railgrip_words::{reword, say, t};

/// The page's content.
pub(super) fn body(list: &SettingList, told: &ReceiverSettingList) -> Markup {
    html! {
        h1 .page { (t("Thresholds and receivers")) }
        p {
            @match &list.file {
                Some(file) => { code { (file) } ": " (t("Role admin may change them here: the whole file is checked, and a comment says who, when and why.")) }
                None => { (t("The built-in config holds. Start with a config file to change them here.")) }
            }
        }
        @if list.waits_for_start || told.waits_for_start { p .loud { (t("Marked values wait for the next start of the processes.")) } }
        (receivers::card(told))
        section .card aria-labelledby="h-settings" {
            h2 #h-settings { (t("By which indicators are computed and judged")) }
            div .scroll { table #settings .settings {
                thead { tr {
                    th scope="col" { (t("Setting")) } th scope="col" { (t("Says")) } th scope="col" { (t("Now")) } th scope="col" { (t("Allowed")) }
                    @if list.file.is_some() { th scope="col" { (t("Change")) } }
                } }
                tbody { @for setting in &list.settings { (row(setting, list.file.is_some())) } }
            } }
        }
        (receivers::dialog())
        dialog #setting-dialog aria-labelledby="setting-title" {
            form method="dialog" {
                h2 #setting-title { (t("Change a threshold")) }
                p #setting-what {}
                label { (t("New value")) " " input #setting-value name="value" type="number" step="any" required; }
                label { (t("Your name or initials")) " " input #setting-by name="by" autocomplete="name" maxlength="100"; }
                label { (t("Reason")) " " input #setting-why name="why" maxlength="500" required; }
                p #setting-error .error role="alert" {}
                div .buttons {
                    button #setting-cancel type="button" .quiet { (t("Cancel")) }
                    button #setting-send type="submit" .primary { (t("Change")) }
                }
            }
        }
    }
}

fn row(setting: &Setting, may_change: bool) -> Markup {
    let waits = setting.next.filter(|next| *next != setting.value);
    let told = |x: f64| number(x, decimals(x));
    html! {
        tr {
            th scope="row" { code { (setting.key) } }
            td .wide { (reword(&setting.words)) }
            td data-label=(t("Now")) {
                b { (told(setting.value)) }
                @if setting.value != setting.default { " (" (t("default")) " " (told(setting.default)) ")" }
                @if let Some(next) = waits { " " mark { (t("next start:")) " " (told(next)) } }
            }
            td data-label=(t("Allowed")) { (say("{low} to {high}", &[("low", &told(setting.range[0])), ("high", &told(setting.range[1]))])) }
            @if may_change {
                td {
                    button type="button" .quiet data-setting=(setting.key) data-value=(waits.unwrap_or(setting.value))
                        aria-label={ (t("Change")) " " (setting.key) } { (t("Change")) }
                }
            }
        }
    }
}

/// As many decimals as a setting has, three at most.
fn decimals(x: f64) -> usize {
    (0..3).find(|digits| (x * 10f64.powi(*digits)).fract().abs() < 1e-9).unwrap_or(3) as usize
}

#[cfg(test)]
mod tests {
    #[test]
    fn settings_have_the_decimals_that_they_need() {
        for (x, digits) in [(120.0, 0), (0.85, 2), (0.1, 1), (0.008, 3), (1.0 / 3.0, 3)] {
            assert_eq!(super::decimals(x), digits, "{x}");
        }
    }
}
