//! Readers who see little, hear the page, or use no mouse: axe-core on every page, and the way from an alert to its
//! acknowledgement and back as a screen reader tells it.

use super::common::*;
use railgrip_requirements::AXE_CORE;
use railgrip_tests::{Browser, Look, Tab};
use serde_json::{Value, json};

/// Rules of WCAG 2.0 to 2.2, A and AA, and the best practices of axe-core.
const AXE: &str = "axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'] }) \
                   .then((found) => found.violations.map((rule) => `${rule.id}: ${rule.nodes.map((node) => node.target).join(' | ')}`))";

pub fn every_page_is_clean_by_axe_in_both_themes_and_on_the_phone() {
    let axe = std::fs::read_to_string(AXE_CORE.path()).unwrap();
    let (mut train, base) = started_without_all(faulty("axe"));
    let browser = Browser::start();
    let mut looked_at = 0;
    for (path, ready) in [
        ("/", "document.querySelector('#map canvas') && document.querySelector('#todo .alert')"),
        ("/wagons/2", "document.querySelectorAll('.alert').length > 0"),
        ("/wagons/2?range=900&with=1,4#trends", "document.querySelector('.chart canvas')"),
        ("/alerts", "document.querySelector('#g-open .alert')"),
        ("/indicators", "document.querySelector('.meaning')"),
        ("/docs", "document.querySelector('.contents-of')"),
        ("/wagons/99", "document.querySelector('.empty')"),
    ] {
        for (width, height) in [(1440, 900), (390, 844)] {
            for dark in [false, true] {
                let look = Look { width, height, dark };
                // A tab of its own: after a change of theme Chromium keeps the colours of links for a while.
                let tab = browser.tab();
                tab.look(look);
                tab.open(&format!("{base}{path}"));
                tab.wait(4 * PATIENCE, &format!("location.href.startsWith({base:?}) && document.readyState === 'complete' && ({ready})"));
                tab.eval(&axe);
                assert_eq!(tab.eval(AXE), json!([]), "{path} {look:?}");
                assert_eq!(tab.eval(TOO_FAINT), json!([]), "{path} {look:?}: contrast below 4.5");
                assert_eq!(tab.eval(TOO_SMALL), json!([]), "{path} {look:?}: targets below 24 px");
                looked_at += 1;
                tab.call("Page.close", json!({}));
            }
        }
    }
    // The dialog, too.
    let tab = browser.tab();
    tab.look(LAPTOP);
    tab.open(&format!("{base}/"));
    live(&tab);
    tab.wait(4 * PATIENCE, "document.querySelector('#todo [data-act=silence]')");
    tab.eval("document.querySelector('#todo [data-act=silence]').click()");
    tab.eval(&axe);
    assert_eq!(tab.eval(AXE), json!([]), "the dialog");
    println!("axe-core {}: {looked_at} views and the dialog without a finding", tab.text("axe.version"));
    assert!(train.stop().success());
}

/// What a screen reader says of that which has the focus: role, name, and whether it must be filled in.
fn focused(tab: &Tab<'_>) -> String {
    let tree = tab.call("Accessibility.getFullAXTree", json!({}));
    let nodes = tree["nodes"].as_array().cloned().unwrap_or_default();
    let is = |node: &Value, name: &str| {
        node["properties"]
            .as_array()
            .is_some_and(|all| all.iter().any(|one| one["name"] == name && one["value"]["value"] == true))
    };
    // The page itself has the focus, too; what is deepest is said.
    let node = nodes.iter().rfind(|node| is(node, "focused") && node["role"]["value"] != "RootWebArea");
    node.map_or_else(String::new, |node| {
        let [role, name] =
            ["role", "name"].map(|part| node[part]["value"].as_str().unwrap_or_default().to_owned());
        let required = if is(node, "required") { ", required" } else { "" };
        format!("{role}: {name}{required}")
    })
}

/// The dialog that is open, as it is announced.
fn dialog(tab: &Tab<'_>) -> String {
    let tree = tab.call("Accessibility.getFullAXTree", json!({}));
    let nodes = tree["nodes"].as_array().cloned().unwrap_or_default();
    let open = nodes.iter().find(|node| node["role"]["value"] == "dialog");
    open.map_or_else(String::new, |node| {
        format!("dialog: {}", node["name"]["value"].as_str().unwrap_or_default())
    })
}

fn spoken(tab: &Tab<'_>) -> String {
    format!("says: {}", tab.text("document.getElementById('announcer').textContent"))
}

pub fn an_alert_is_acknowledged_and_taken_back_by_ear_and_keyboard() {
    let (mut train, base) = running("heard", 2);
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(LAPTOP);
    tab.call("Accessibility.enable", json!({}));
    tab.open(&format!("{base}/"));
    live(&tab);
    let mut transcript: Vec<String> = Vec::new();
    // A train that stops to send raises an alert.
    let (up, ingest) = (train.process("up"), train.process("ingest"));
    up.signal(rustix::process::Signal::STOP);
    ingest.signal(rustix::process::Signal::STOP);
    tab.wait(PATIENCE, "document.getElementById('announcer').textContent.startsWith('New alert')");
    transcript.push(spoken(&tab));
    // From the top of the page by Tab alone to the first button of an alert.
    tab.eval("document.activeElement.blur(); scrollTo(0, 0)");
    for _ in 0..40 {
        tab.press("Tab");
        let said = focused(&tab);
        transcript.push(said.clone());
        if said.starts_with("button: Acknowledge alert") {
            break;
        }
    }
    tab.press("Enter");
    tab.wait(
        PATIENCE,
        "document.getElementById('act-dialog').open && document.activeElement.id === 'act-by'",
    );
    transcript.extend([dialog(&tab), focused(&tab)]);
    tab.write("Early Shift");
    tab.press("Enter");
    tab.wait(PATIENCE, "!document.getElementById('act-dialog').open");
    transcript.push(spoken(&tab));
    tab.wait(PATIENCE, "document.activeElement.dataset.act === 'unacknowledge'");
    transcript.push(focused(&tab));
    // It was the wrong one: the same key takes it back.
    tab.press("Enter");
    tab.wait(
        PATIENCE,
        "document.getElementById('act-dialog').open && document.activeElement.id === 'act-note'",
    );
    transcript.extend([dialog(&tab), focused(&tab)]);
    tab.press("Enter");
    tab.wait(PATIENCE, "!document.getElementById('act-dialog').open");
    transcript.push(spoken(&tab));
    tab.wait(PATIENCE, "document.activeElement.dataset.act === 'acknowledge'");
    transcript.push(focused(&tab));
    println!("{}", transcript.join("\n"));

    let mut lines = transcript.iter();
    for wanted in [
        "says: New alert: act",
        "link: Skip to the content",
        "link: railgrip, train heard",
        "link: Alerts 1 active",
        "button: Theme",
        "link: Wagon 1 stale",
        "button: Acknowledge alert",
        "dialog: Acknowledge this alert",
        "textbox: Your name or initials, required",
        "says: Acknowledged.",
        "button: Take back alert",
        "dialog: Take the acknowledgement back",
        "textbox: Note (optional)",
        "says: Acknowledgement taken back.",
        "button: Acknowledge alert",
    ] {
        assert!(
            lines.any(|line| line.starts_with(wanted)),
            "{wanted:?} is not said, or not in this order: {transcript:#?}"
        );
    }
    assert!(
        transcript.iter().all(|line| line.len() > "button: ".len()),
        "something without a name: {transcript:#?}"
    );
    ingest.signal(rustix::process::Signal::CONT);
    up.signal(rustix::process::Signal::CONT);
    sound(&tab, &base);
    assert!(train.stop().success());
}
