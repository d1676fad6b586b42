//! Paper: one page of A4 for a wagon and one for the train, with lines for the fitter and the address of the view.

use super::common::*;
use railgrip_tests::{Browser, Look, Tab};
use serde_json::json;

/// Pages of a PDF of the browser, and the size of each in points.
pub(super) fn printed(tab: &Tab<'_>) -> (usize, Vec<String>) {
    let answer = tab.call("Page.printToPDF", json!({ "preferCSSPageSize": true, "printBackground": false }));
    let text = decoded(answer["data"].as_str().unwrap());
    let pages = text
        .match_indices("/Type /Page")
        .filter(|(at, found)| !text[at + found.len()..].starts_with('s'))
        .count();
    let sizes = text.match_indices("/MediaBox [").map(|(at, found)| {
        let rest = &text[at + found.len()..];
        rest[..rest.find(']').unwrap()].to_owned()
    });
    (pages, sizes.collect())
}

/// Base64, each byte as one character: enough to look at the structure of a PDF.
fn decoded(text: &str) -> String {
    let digit = |byte: u8| match byte {
        b'A'..=b'Z' => byte - b'A',
        b'a'..=b'z' => byte - b'a' + 26,
        b'0'..=b'9' => byte - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let digits: Vec<u32> =
        text.bytes().filter(|byte| *byte != b'=').map(|byte| u32::from(digit(byte))).collect();
    let bytes = digits.chunks(4).flat_map(|four| {
        let bits = four.iter().fold(0, |bits, six| bits << 6 | six) << (6 * (4 - four.len()));
        (0..four.len().saturating_sub(1)).map(move |index| (bits >> (16 - 8 * index)) as u8)
    });
    bytes.map(char::from).collect()
}

pub fn a_wagon_and_the_train_are_one_page_of_a4_each() {
    let (mut train, base) = started_without_all(faulty("paper"));
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(Look { width: 1440, height: 900, dark: true });
    for (path, heading) in [("/wagons/2?range=900", "Wagon 2"), ("/", "need")] {
        tab.open(&format!("{base}{path}"));
        live(&tab);
        tab.wait(4 * PATIENCE, "document.querySelectorAll('.alert .advice').length > 0");
        if path != "/" {
            tab.wait(
                2 * PATIENCE,
                "/Data for [1-9]/.test(document.getElementById('trend-state').textContent)",
            );
        }
        let (pages, sizes) = printed(&tab);
        println!("{path}: {pages} page(s), {sizes:?}");
        assert_eq!(pages, 1, "{path}");
        let size: Vec<f64> = sizes[0].split_whitespace().map(|part| part.parse().unwrap()).collect();
        assert!((size[2] - 595.3).abs() < 1.0 && (size[3] - 841.9).abs() < 1.0, "{path}: no A4: {size:?}");

        // What stands on it: state, evidence, what to do, blank lines, and where it came from.
        assert!(
            tab.text("document.getElementById('printed-from').textContent").contains(&format!("{base}/"))
        );
        tab.call("Emulation.setEmulatedMedia", json!({ "media": "print" }));
        let text = tab.text("document.body.innerText");
        for word in [heading, "Do: ", "since ", "Found", "Done", "Name, date, signature"] {
            assert!(text.contains(word), "{path}: {word} is missing: {text}");
        }
        for button in ["Acknowledge", "zoom in", "Auto"] {
            assert!(!text.contains(button), "{path}: {button} is on paper");
        }
        if path != "/" {
            assert!(
                text.contains("wagon-2") && text.contains("Trends") && text.contains("wheelset 2"),
                "{text}"
            );
            // The link holds the range of the chart that is printed.
            assert!(tab.text("document.getElementById('printed-from').textContent").contains("?from="));
        }
        tab.call("Emulation.setEmulatedMedia", json!({ "media": "" }));
    }
    sound(&tab, &base);
    assert!(train.stop().success());
}
