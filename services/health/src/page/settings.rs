//! Thresholds and receivers: what holds, what the next start will bring, and the way to change one.

use super::receivers;
use super::words::{named, number};
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
        @if list.waits_for_start || told.waits_for_start { p .loud { (t("Marked values wait until the processes start again or read their config again (SIGHUP).")) } }
        (receivers::card(told))
        section .card aria-labelledby="h-settings" {
            h2 #h-settings { (t("By which indicators are computed and judged")) }
            div .scroll { table #settings .settings {
                thead { tr {
                    th scope="col" { (t("Setting")) } th scope="col" { (t("Says")) } th scope="col" { (t("Now")) } th scope="col" { (t("Allowed")) }
                    @if list.file.is_some() { th scope="col" { (t("Change")) } }
                } }
                @for group in list.settings.chunk_by(|one, next| table(one) == table(next)) {
                    tbody {
                        tr .group { th scope="rowgroup" colspan="5" { (heading(table(&group[0]))) } }
                        @for setting in group { (row(setting, list.file.is_some())) }
                    }
                }
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

/// The table of the config that a setting stands in.
fn table(setting: &Setting) -> &str {
    setting.key.split_once('.').map_or("", |(table, _)| table)
}

/// What a table of the config is about, in the words of the other pages.
fn heading(table: &str) -> String {
    match table {
        "standard" => named("brake_friction_standard"),
        "adhesion" => t("Adhesion").to_owned(),
        "wsp" => named("wsp_share"),
        id => named(id),
    }
}

fn row(setting: &Setting, may_change: bool) -> Markup {
    let waits = setting.next.filter(|next| *next != setting.value);
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

/// A setting with the decimals that tell it from others, and its thousands apart.
fn told(x: f64) -> String {
    let text = number(x, decimals(x));
    let whole = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    if whole < 5 {
        return text;
    }
    let digits = text[..whole].char_indices();
    let apart =
        digits.flat_map(|(i, c)| [(i > 0 && (whole - i).is_multiple_of(3)).then_some('\u{202f}'), Some(c)]);
    apart.flatten().collect::<String>() + &text[whole..]
}

/// As many decimals as it takes to write a number to a thousandth of itself, six at most.
fn decimals(x: f64) -> usize {
    let enough = |digits: &i32| {
        let ten = 10f64.powi(*digits);
        ((x * ten).round() / ten - x).abs() <= 1e-3 * x.abs()
    };
    (0..6).find(enough).unwrap_or(6) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_indicators::{INDICATORS, IndicatorSettings};

    #[test]
    fn settings_have_the_decimals_that_they_need() {
        for (x, text) in [
            (120.0, "120"),
            (0.0, "0"),
            (0.85, "0.85"),
            (0.1, "0.1"),
            (0.008, "0.008"),
            (0.00045, "0.00045"),
            (1.0 / 3.0, "0.333"),
            (1e7, "10\u{202f}000\u{202f}000"),
            (60_000.5, "60\u{202f}000"),
            (2000.0, "2000"),
        ] {
            assert_eq!(told(x), text, "{x}");
        }
    }

    #[test]
    fn every_table_is_called_what_the_other_pages_call_it() {
        let entries = IndicatorSettings::default().entries();
        let names: Vec<&str> = INDICATORS.iter().map(|spec| spec.name()).chain(["Adhesion"]).collect();
        for entry in &entries {
            let table = entry.key.split_once('.').map_or("", |(table, _)| table);
            assert!(names.contains(&heading(table).as_str()), "{}: {}", entry.key, heading(table));
        }
        assert!(entries.len() > 40, "{} settings", entries.len());
    }
}
