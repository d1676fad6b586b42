//! The charts of a wagon: range, zoom, crosshair, wagons beside each other, labels, empty ranges, files.

use super::common::*;
use railgrip_tests::{Browser, Look, Tab, within};
use serde_json::json;
use std::path::Path;

const DESK: Look = Look { width: 1440, height: 900, dark: false };
const DRAWN: &str = "document.querySelectorAll('.chart canvas').length === 2 && \
                     /Data for [1-9]/.test(document.getElementById('trend-state').textContent)";

/// The younger end of 900 s holds figures for at least 40 s, in fine steps: a whole minute would also stand for its first second.
const STORED_40_S: &str = "(() => { const found = /in steps of \\d+ s. Data for (\\d+)/.exec(document.getElementById('trend-state').textContent); \
                           return found && Number(found[1]) >= 5; })()";

pub fn charts_are_zoomed_compared_shared_and_saved() {
    let (mut train, base) = started_without_all(faulty("charts"));
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(DESK);
    tab.call("Emulation.setTimezoneOverride", json!({ "timezoneId": "Europe/Berlin" }));
    tab.open(&format!("{base}/wagons/2?range=900&charts=pad,adhesion"));
    live(&tab);
    tab.wait(2 * PATIENCE, DRAWN);
    // The history must reach back into what is zoomed into.
    tab.wait(2 * PATIENCE, STORED_40_S);
    colours_and_scales(&tab);
    times_are_those_of_the_reader(&tab);
    words_do_not_collide(&tab);
    crosshair_and_zoom(&tab);
    other_wagons(&tab);
    empty_ranges(&tab, &base);
    files(&tab, &base, train.folder());
    sound(&tab, &base);
    assert!(train.stop().success());
}

/// Every line has a colour of its own, its band lets the line through, and a wide band does not flatten the lines.
fn colours_and_scales(tab: &Tab<'_>) {
    for dark in [false, true] {
        tab.look(Look { dark, ..DESK });
        let inks = tab.eval("['text', 'accent', 'c2', 'c3', 'c4', 'c5'].map((ink) => plot.colour(ink, 1))");
        let inks = inks.as_array().unwrap();
        let distinct: std::collections::BTreeSet<_> = inks.iter().map(ToString::to_string).collect();
        assert_eq!(distinct.len(), inks.len(), "two inks are alike: {inks:?}");
        let faint =
            "['accent', 'c2', 'c3', 'c4', 'c5'].every((ink) => /0\\.17\\)$/.test(plot.colour(ink, 0.17)))";
        assert_eq!(tab.eval(faint), true, "a band is solid");
    }
    tab.look(DESK);
    let high = tab.eval(
        "plot.span({ floor: 0, lines: [{ band: true }] }, [[1, 2, 3], [0.05, 0.06, 0.07], [0, 0, 0], [0.6, 0.6, 0.6]])[1]",
    );
    assert!(high.as_f64().unwrap() < 0.45, "the band flattens the line: up to {high}");
    assert_eq!(
        tab.eval("Object.values(CHARTS).every((words) => words[2].length > 3)"),
        true,
        "an axis without words"
    );
}

/// 24 hours in the zone of the reader, and the zone is said.
fn times_are_those_of_the_reader(tab: &Tab<'_>) {
    let marks = tab.text("clock.marks([1800000000, 1800003600, 1800050400], 3600).join(' | ')");
    assert_eq!(marks, "09:00\n15 Jan | 10:00 | 23:00");
    assert_eq!(tab.text("clock.zone(new Date('2027-01-15'))"), "Europe/Berlin, UTC+1");
    assert!(tab.text("document.getElementById('zone').textContent").starts_with("Europe/Berlin, UTC+"));
}

/// Words that the canvas carries lie beside each other, never upon each other.
fn words_do_not_collide(tab: &Tab<'_>) {
    let overlaps = tab.eval(
        r"(async () => {
          const found = [];
          const write = CanvasRenderingContext2D.prototype.fillText;
          const put = (ctx, text, x, y) => {
            const wide = ctx.measureText(text).width;
            const left = { right: x - wide, center: x - wide / 2 }[ctx.textAlign] ?? x;
            return { text, left, right: left + wide, y };
          };
          const host = document.getElementById('charts');
          for (const values of [[0.1, 0.4], [0.25, 0.25], [null, null]]) {
            let words = [];
            let own = null;
            let last = [];
            CanvasRenderingContext2D.prototype.fillText = function (text, x, y) { if (this === own && /above|below|no data/.test(text)) words.push(put(this, text, x, y)); };
            // Called at the end of every drawing: what was written since the one before.
            const done = () => { [last, words] = [words, []]; };
            const spec = { limits: [0.2, 0.24, 0.26, 0.3], lines: [{ name: 'one' }], title: 'test', axis: 'test', draw: [done] };
            const times = Array.from({ length: 50 }, (_, i) => 1800000000 + 60 * i);
            const chart = charts.make(host, spec);
            own = chart.u.ctx;
            chart.update([times, times.map((_, i) => (i > 30 ? values[i % 2] : null))]);
            chart.u.redraw();
            await new Promise((drawn) => setTimeout(drawn, 100));
            chart.remove();
            found.push(last.length >= 2 ? [] : [`${last.length} words`]);
            found.push(last.flatMap((a, i) => last.slice(i + 1).filter((b) => Math.abs(a.y - b.y) < 11 && a.left < b.right && b.left < a.right).map((b) => `${a.text} / ${b.text}`)));
          }
          CanvasRenderingContext2D.prototype.fillText = write;
          return found.flat();
        })()",
    );
    assert_eq!(overlaps, json!([]), "words upon words");
}

fn mouse(tab: &Tab<'_>, kind: &str, x: f64, y: f64, pressed: bool) {
    let button = if kind == "mouseMoved" && !pressed { "none" } else { "left" };
    tab.call(
        "Input.dispatchMouseEvent",
        json!({ "type": kind, "x": x, "y": y, "button": button, "buttons": i32::from(pressed), "clickCount": 1 }),
    );
}

/// The crosshair is that of all charts; dragging zooms; the range stands in the address, and "back" undoes it.
fn crosshair_and_zoom(tab: &Tab<'_>) {
    let place = tab.eval(
        "(() => { const e = document.querySelector('.u-over'); e.scrollIntoView({ block: 'center' }); \
         const r = e.getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; })()",
    );
    let [x, y, width, height] = [0, 1, 2, 3].map(|index| place[index].as_f64().unwrap());
    let middle = y + 0.5 * height;
    mouse(tab, "mouseMoved", x + 0.97 * width, middle, false);
    tab.wait(
        PATIENCE,
        "[...document.querySelectorAll('.lines .at')].every((at) => /\\d\\d:\\d\\d/.test(at.textContent))",
    );
    let said = tab.text("document.querySelectorAll('.lines')[1].innerText");
    println!("the other chart at the crosshair: {said:?}");

    tab.eval("window.stays = true");
    for (kind, share, pressed) in [
        ("mouseMoved", 0.69, false),
        ("mousePressed", 0.69, true),
        ("mouseMoved", 0.8, true),
        ("mouseMoved", 0.99, true),
        ("mouseReleased", 0.99, false),
    ] {
        mouse(tab, kind, x + share * width, middle, pressed);
    }
    tab.wait(PATIENCE, "new URLSearchParams(location.search).has('from')");
    let span = "(() => { const q = new URLSearchParams(location.search); return (Date.parse(q.get('to')) - Date.parse(q.get('from'))) / 1000; })()";
    let zoomed_s = tab.eval(span).as_f64().unwrap();
    println!("zoomed from 900 s to {zoomed_s} s");
    assert!((200.0..340.0).contains(&zoomed_s), "three tenths of 900 s are {zoomed_s} s");
    assert_eq!(tab.eval("document.querySelectorAll('[data-range][aria-pressed=true]').length"), 0);
    // Without a mouse: the buttons do the same.
    tab.click("[data-times='0.5']");
    tab.wait(PATIENCE, &format!("Math.abs({span} - {zoomed_s} / 2) < 2"));
    tab.eval("history.back()");
    tab.wait(PATIENCE, &format!("Math.abs({span} - {zoomed_s}) < 2"));
    let address = tab.text("location.href");
    assert_eq!(tab.eval("window.stays"), true, "the page was loaded anew");
    // A link leads to exactly this view.
    tab.open(&address);
    live(tab);
    tab.wait(PATIENCE, DRAWN);
    assert!((tab.eval(span).as_f64().unwrap() - zoomed_s).abs() < 2.0);
    assert_eq!(tab.eval("document.querySelectorAll('#picks [aria-pressed=true]').length"), 2);
}

fn other_wagons(tab: &Tab<'_>) {
    tab.click("[data-range='900']");
    tab.wait(PATIENCE, "!location.search.includes('from=')");
    tab.eval("document.getElementById('beside').focus()");
    tab.write("1, 99");
    tab.press("Enter");
    tab.wait(PATIENCE, "/1 to 8/.test(document.getElementById('beside-wrong').textContent)");
    tab.eval("document.getElementById('beside').value = ''");
    tab.write("1, 4");
    tab.press("Enter");
    tab.wait(PATIENCE, "location.search.includes('with=1,4')");
    tab.wait(PATIENCE, DRAWN);
    let lines = tab.text("document.querySelector('.lines').innerText");
    for line in ["wagon 2, wheelset 1", "wagon 2, wheelset 2", "wagon 1, wheelset 1", "wagon 4, wheelset 2"] {
        assert!(lines.contains(line), "{line}: {lines}");
    }
    // A line that is in the way is hidden by its button in the legend.
    tab.click(".line-of");
    assert_eq!(tab.text("document.querySelector('.line-of').getAttribute('aria-pressed')"), "false");
}

/// What is empty says so, and from when on something is stored.
fn empty_ranges(tab: &Tab<'_>, base: &str) {
    tab.open(&format!("{base}/wagons/2?from=2024-05-01T06:00:00Z&to=2024-05-01T07:00:00Z"));
    live(tab);
    let said = "document.getElementById('trend-state').textContent";
    tab.wait(PATIENCE, &format!("/Nothing is stored for 1 May 08:00 to 09:00/.test({said})"));
    let said = tab.text(said);
    println!("{said}");
    assert!(said.contains("The history goes back to about") && said.contains("20"), "{said}");
}

/// What is shown comes as CSV and as PNG.
fn files(tab: &Tab<'_>, base: &str, folder: &Path) {
    tab.open(&format!("{base}/wagons/2?range=900&charts=pad"));
    live(tab);
    tab.wait(PATIENCE, "/Data for [1-9]/.test(document.getElementById('trend-state').textContent)");
    let path = folder.join("saved");
    std::fs::create_dir_all(&path).unwrap();
    let allow = json!({ "behavior": "allow", "downloadPath": path.display().to_string() });
    tab.call("Page.setDownloadBehavior", allow);
    let saved = |end: &str| {
        within(PATIENCE, || {
            let files = std::fs::read_dir(&path).unwrap().flatten().map(|entry| entry.path());
            files.into_iter().find(|file| file.extension().is_some_and(|own| own == end))
        })
    };
    tab.click(".tools button:nth-child(2)");
    let csv = saved("csv").unwrap();
    let text =
        within(PATIENCE, || std::fs::read_to_string(&csv).ok().filter(|text| text.ends_with('\n'))).unwrap();
    let mut lines = text.lines();
    let head = lines.next().unwrap();
    println!("{}: {head}", csv.display());
    assert!(
        head.starts_with("time_utc,\"Pad friction, wheelset 1\",\"Pad friction, wheelset 1, low\""),
        "{head}"
    );
    assert!(lines.clone().count() > 100 && lines.all(|line| line.split(',').count() == 7), "{text}");
    tab.click(".tools button:nth-child(3)");
    let png = saved("png").unwrap();
    let bytes = within(PATIENCE, || std::fs::read(&png).ok().filter(|bytes| bytes.len() > 5000)).unwrap();
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
}
