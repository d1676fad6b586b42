//! Six faults at six in the morning: what is wrong comes first, and the first screen answers what, where, since when, how
//! sure and what to do.

use super::common::*;
use railgrip_tests::{Browser, Look, Tab};

const DESK: Look = Look { width: 1440, height: 900, dark: false };
const HD: Look = Look { width: 1920, height: 1080, dark: false };

/// Where each fault is, and a word of what is to be done about it.
const ANSWERS: [(&str, &str); 6] = [
    ("Wagon 2, wheelset 2", "pads"),
    ("Wagon 3", "does not release"),
    ("Wagon 4, wheelset 1", "isolating cock"),
    ("Wagon 5", "sensor"),
    ("Wagon 6", "pads"),
    ("Wagon 7", "data"),
];

pub fn what_is_wrong_comes_first_and_is_answered_from_the_first_screen() {
    let (mut train, base) = started_without_all(faulty("faults"));
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(DESK);
    tab.open(&format!("{base}/"));
    live(&tab);
    for (place, _) in ANSWERS {
        let shown = format!(
            "[...document.querySelectorAll('#todo .where')].some((where) => where.textContent.startsWith({place:?}))"
        );
        tab.wait(4 * PATIENCE, &shown);
    }
    first_screen(&tab);
    tab_shows_alarms(&tab);
    order_and_filter(&tab);

    // The whole table is there at once on a large screen, and the same answers beside it.
    tab.look(HD);
    tab.wait(PATIENCE, "innerWidth === 1920");
    first_screen(&tab);
    let bottom = tab.eval("document.querySelector('.wagons tbody').getBoundingClientRect().bottom + scrollY");
    println!("1920 x 1080: the table ends at {bottom} px");
    assert!(bottom.as_f64().unwrap() <= 1080.0);

    // A wagon is told on two screens, on the desk and in the hand.
    for look in [DESK, PHONE] {
        tab.look(look);
        tab.open(&format!("{base}/wagons/2"));
        live(&tab);
        tab.wait(PATIENCE, "document.getElementById('outlook').textContent !== 'Loading trends…'");
        std::thread::sleep(SECOND);
        let height = tab.eval("document.documentElement.scrollHeight").as_f64().unwrap();
        println!("{look:?}: a wagon with a fault is {height} px high");
        assert!(height <= 2.0 * f64::from(look.height), "more than two screens");
    }
    // An alert leads to charts of its time, not to figures for programs.
    tab.look(DESK);
    tab.open(&format!("{base}/alerts"));
    live(&tab);
    tab.eval("document.querySelector('#g-open details').open = true");
    let link = tab.text("document.querySelector(\"#g-open a[href*='#trends']\").getAttribute('href')");
    assert!(link.starts_with("/wagons/") && link.contains("from=") && link.contains("to="), "{link}");
    assert_eq!(tab.eval("document.querySelectorAll('main a[href^=\"/api/\"]').length"), 0);
    sound(&tab, &base);
    assert!(train.stop().success());
}

/// Each fault: where, since when, how sure or how much, and what to do, above the fold.
fn first_screen(tab: &Tab<'_>) {
    let seen = tab.eval(
        "[...document.querySelectorAll('#todo .alert')].filter((alert) => alert.getBoundingClientRect().bottom <= innerHeight) \
         .map((alert) => ['.where', '.since', '.reason', '.advice'].map((part) => alert.querySelector(part).textContent))",
    );
    let seen = seen.as_array().unwrap();
    for (place, act) in ANSWERS {
        let alert = seen.iter().find(|alert| alert[0].as_str().unwrap().starts_with(place));
        let alert = alert.unwrap_or_else(|| panic!("{place} is not on the first screen: {seen:?}"));
        println!("{alert}");
        let [since, reason, advice] = [1, 2, 3].map(|index| alert[index].as_str().unwrap());
        assert!(since.contains("since ") && since.contains(':'), "{place}: since when? {since}");
        assert!(
            reason.chars().any(|letter| letter.is_ascii_digit()) || place == "Wagon 7",
            "{place}: how sure? {reason}"
        );
        assert!(advice.to_lowercase().contains(act), "{place}: what to do? {advice}");
    }
}

fn tab_shows_alarms(tab: &Tab<'_>) {
    let title = tab.text("document.title");
    let count = tab.eval("Number(document.getElementById('alert-count').dataset.act) + Number(document.getElementById('alert-count').dataset.watch)");
    assert!(title.starts_with(&format!("({count}) ")), "{title}: {count}");
    assert!(
        tab.text("document.getElementById('icon').getAttribute('href')").starts_with("/assets/icon-act.svg")
    );
    // Markers of wheelsets are explained beside the drawing.
    let legend = tab.text("document.querySelector('#h-train').parentElement.innerText");
    assert!(legend.contains("Wheelsets") && legend.contains("slides now"), "{legend}");
}

/// By grade, what is well folded; by any column on request; by a word.
fn order_and_filter(tab: &Tab<'_>) {
    let ranks = "[...document.querySelectorAll('.wagons tbody:first-of-type tr')].map((row) => ['act', 'watch', 'unknown', 'ok'].indexOf(row.dataset.grade))";
    let sorted = format!(
        "(({ranks}).length > 0 && ({ranks}).every((rank, i, all) => rank < 3 && (i === 0 || all[i - 1] <= rank)))"
    );
    tab.wait(PATIENCE, &sorted);
    assert_eq!(
        tab.eval("[...document.querySelectorAll('.wagons .well tr')].every((row) => !row.checkVisibility())"),
        true
    );
    let numbers = "[...document.querySelectorAll('.wagons tbody tr')].filter((row) => row.checkVisibility()).map((row) => Number(row.id.slice(2)))";
    tab.click(".wagons thead th:first-child button");
    assert_eq!(tab.eval(numbers), serde_json::json!([1, 2, 3, 4, 5, 6, 7, 8]));
    tab.click(".wagons thead th:first-child button");
    assert_eq!(tab.eval(numbers), serde_json::json!([8, 7, 6, 5, 4, 3, 2, 1]));
    assert_eq!(tab.text("document.querySelector('.wagons th').getAttribute('aria-sort')"), "descending");
    // The order stays while figures come in.
    tab.eval("window.renewed = 0; document.addEventListener('renewed', () => { window.renewed += 1; })");
    tab.wait(PATIENCE, "window.renewed >= 3");
    assert_eq!(tab.eval(numbers), serde_json::json!([8, 7, 6, 5, 4, 3, 2, 1]));
    tab.click(".wagons thead th:first-child button");
    tab.eval("document.getElementById('filter').focus()");
    tab.write("wagon-4");
    assert_eq!(tab.eval(numbers), serde_json::json!([4]));
    tab.eval("(() => { const filter = document.getElementById('filter'); filter.value = ''; filter.dispatchEvent(new Event('input')); })()");
    tab.wait(PATIENCE, &sorted);
}
