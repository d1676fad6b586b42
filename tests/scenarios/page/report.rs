//! The gap report in a browser: on paper it begins with one sheet of A4 that says everything, and a phone shows all of it.

use super::common::*;
use super::paper::printed;
use railgrip_requirements::LABELLED_CASES;
use railgrip_tests::{Browser, Look, program};
use std::process::Command;

pub fn a_gap_report_begins_with_one_page_of_a4_and_fits_a_phone() {
    let bench = train("report", 1, "");
    let file = bench.folder().join("report.html");
    let (case, html) = (LABELLED_CASES.path().join("case00"), file.display().to_string());
    let mut command = Command::new(program!());
    let made =
        command.args(["gap", "diagnose", &case.display().to_string(), "--html", &html]).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(Look { width: 390, height: 844, dark: false });
    tab.open(&format!("file://{html}"));
    tab.wait(PATIENCE, "document.readyState === 'complete' && document.querySelector('.sheet h1')");
    let cut = tab.text(
        "[document.documentElement, ...document.querySelectorAll('.scroll')].filter((one) => one.scrollWidth > one.clientWidth + 1)
           .map((one) => `${one.scrollWidth} in ${one.clientWidth}: ${one.textContent.slice(0, 60)}`).join('; ')",
    );
    assert_eq!(cut, "", "cut off on a phone");
    // Paper: the first page alone, as its break makes it.
    let words = tab.text("document.querySelector('.sheet').innerText");
    for needed in ["holdout gap", "How sure", "Where and when", "What to do", "Before and after", "Nominal"] {
        assert!(words.contains(needed), "{needed}: {words}");
    }
    let (all, _) = printed(&tab);
    tab.eval("document.querySelectorAll('main > :not(.sheet), footer').forEach((one) => one.remove())");
    tab.eval("void (document.querySelector('.sheet').style.breakAfter = 'auto')");
    let (pages, sizes) = printed(&tab);
    println!("{all} pages, the first part on {pages}, {sizes:?}");
    assert!(pages == 1 && all > 1);
}
