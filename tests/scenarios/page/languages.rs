//! German: every page in it, without a word of English left, numbers and times as it writes them, and the ways to choose it.

use super::common::*;
use railgrip_tests::{Browser, Tab};
use serde_json::json;
use std::path::Path;

/// Everything that is read or heard on a page, folds and dialog included; keys of the config are no words.
const WORDS: &str = "(() => { document.querySelectorAll('code, [data-setting]').forEach((key) => key.remove()); \
     document.querySelectorAll('details').forEach((fold) => { fold.open = true; }); \
     const named = [...document.querySelectorAll('*')].flatMap((e) => ['aria-label', 'placeholder', 'data-label', 'title'].map((name) => e.getAttribute(name)).filter(Boolean)); \
     return [document.title, document.body.innerText, ...[...document.querySelectorAll('dialog')].map((e) => e.textContent), ...named].join('\\n'); })()";
/// Words that no German text has.
const ENGLISH: &str =
    r"/\b(the|and|of|with|not|since|until|wheelset|friction|braking|unknown|watch|slides|alerts?|wagons)\b/i";

/// Phrases of the table of messages in English that are others in German.
fn phrases() -> Vec<String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../common/words/de.po");
    let text = std::fs::read_to_string(file).unwrap();
    let value = |line: &str, name: &str| {
        line.strip_prefix(name).and_then(|rest| rest.strip_suffix('"')).map(|text| text.replace("\\\"", "\""))
    };
    let mut found = Vec::new();
    let mut english = String::new();
    for line in text.lines() {
        if let Some(message) = value(line, "msgid \"") {
            english = message;
        } else if let Some(german) = value(line, "msgstr \"") {
            let mut rest = english.as_str();
            while !rest.is_empty() {
                let (piece, behind) = rest.split_once('{').unwrap_or((rest, ""));
                let piece = piece.trim();
                if piece.len() >= 9 && piece.contains(' ') && !german.contains(piece) {
                    found.push(piece.to_owned());
                }
                rest = behind.split_once('}').map_or("", |(_, behind)| behind);
            }
        }
    }
    found
}

fn all_german(tab: &Tab<'_>, path: &str, phrases: &[String]) {
    assert_eq!(tab.text("document.documentElement.lang"), "de", "{path}");
    let words = tab.text(WORDS);
    assert!(words.len() > 300, "{path}: {words}");
    let left: Vec<&String> = phrases.iter().filter(|phrase| words.contains(phrase.as_str())).collect();
    assert_eq!(left, Vec::<&String>::new(), "{path}: English is left: {words}");
    let word = tab.eval(&format!("({words:?}.match({ENGLISH}) ?? [''])[0]"));
    assert_eq!(word, "", "{path}: an English word is left: {words}");
}

pub fn every_page_speaks_german_without_a_word_of_english() {
    let (mut train, base) = started_without_all(faulty("zug"));
    let phrases = phrases();
    assert!(phrases.len() > 300, "{} phrases", phrases.len());
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(LAPTOP);
    // As a browser in a German depot asks.
    tab.call(
        "Network.setExtraHTTPHeaders",
        json!({ "headers": { "Accept-Language": "de-DE,de;q=0.9,en;q=0.5" } }),
    );
    for (path, ready) in [
        (
            "/",
            "document.querySelectorAll('#todo .alert').length >= 4 && document.querySelectorAll('.stops tbody tr').length > 0",
        ),
        (
            "/wagons/2",
            "document.querySelectorAll('.alert').length > 0 && /Daten f\u{fc}r [1-9]/.test(document.getElementById('trend-state').textContent) && !/geladen/.test(document.getElementById('events').textContent)",
        ),
        ("/wagons/4", "document.querySelectorAll('.alert').length > 0"),
        ("/wagons/7", "document.querySelectorAll('.alert').length > 0"),
        ("/alerts", "document.querySelectorAll('#g-open .alert').length >= 4"),
        ("/indicators", "document.querySelector('.meaning')"),
        ("/settings", "document.querySelectorAll('#settings tbody tr').length > 20"),
    ] {
        tab.open(&format!("{base}{path}"));
        tab.wait(
            4 * PATIENCE,
            &format!("location.pathname === '{path}' && document.readyState === 'complete' && ({ready})"),
        );
        all_german(&tab, path, &phrases);
        // Names of grades and colours in the scripts are not words of the page.
        assert!(
            tab.text("document.getElementById('icon').getAttribute('href')").contains("icon-act"),
            "{path}"
        );
        assert_eq!(tab.text("document.getElementById('link').dataset.state"), "live", "{path}");
    }
    // A comma in figures, the day before the month.
    tab.open(&format!("{base}/wagons/2"));
    live(&tab);
    let figures = tab.text(
        "[...document.querySelectorAll('.indicators .value')].map((cell) => cell.textContent).join(' ')",
    );
    assert!(figures.contains("0,") && !figures.contains("0."), "{figures}");
    assert_eq!(tab.text("clock.marks([1800000000], 86400)[0]"), "15. Jan.");
    assert!(tab.text("plot.format(-0.25, { digits: 2 })").contains("−0,25"));
    let advice = tab.text(
        "[...document.querySelectorAll('.alert .advice')].map((advice) => advice.textContent).join(' | ')",
    );
    assert!(advice.contains("Tun: Beläge, Scheiben und Gestänge"), "{advice}");

    // The switch at the foot of the page keeps where the reader is, and holds on the next page.
    tab.click("a[data-lang=en]");
    tab.wait(PATIENCE, "document.documentElement.lang === 'en' && location.pathname === '/wagons/2'");
    tab.open(&format!("{base}/alerts"));
    tab.wait(
        PATIENCE,
        "document.documentElement.lang === 'en' && document.querySelector('h1')?.textContent === 'Alerts'",
    );
    // Programs get English unless they ask.
    let http = train.http().unwrap();
    // Which alert is the first depends on how far the train has come; the wagon whose brake is cut off is always among them.
    let reason = |alerts: &serde_json::Value| {
        let all = alerts["alerts"].as_array().cloned().unwrap_or_default();
        let isolated = all.into_iter().find(|alert| alert["cause"] == "isolated").expect("an alert");
        isolated["advice"].as_str().unwrap_or_default().to_owned()
    };
    let english = reason(&http.json("/api/v1/alerts").unwrap());
    let german = tab.eval(
        "fetch('/api/v1/alerts', { headers: { 'accept-language': 'de' } }).then((answer) => answer.json())",
    );
    println!("{english} / {}", reason(&german));
    assert!(english.starts_with("Check") && !reason(&german).starts_with("Check"), "{german}");
    assert!(train.stop().success());
}
