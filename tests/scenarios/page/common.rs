//! What the scenarios of the pages share: a train, looks, and what every page owes to its readers.

use railgrip_tests::{Look, Tab, TrainUnderTest, program, within};
use std::path::Path;
use std::time::Duration;

pub const SECOND: Duration = Duration::from_secs(1);
pub const PHONE: Look = Look { width: 390, height: 844, dark: false };
pub const LAPTOP: Look = Look { width: 1280, height: 800, dark: false };
pub const WALL: Look = Look { width: 1920, height: 1080, dark: true };

/// Machines on which tests run may be slow; nobody waits longer than it takes.
pub const PATIENCE: Duration = Duration::from_secs(60);

pub fn train(name: &str, wagons: u32, more: &str) -> TrainUnderTest {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config").canonicalize().unwrap();
    let text = format!(
        "schema = 1\n[train]\nname = \"{name}\"\nwagons = {wagons}\nvehicle = \"{0}/vehicle.toml\"\n[source]\n\
         kind = \"simulate\"\nscenario = \"{0}/scenarios/demo.toml\"\n[alerts]\nraise_after_s = 1.0\nclear_after_s = 2.0\n\
         [logging]\nlevel = \"info\"\nformat = \"text\"\n{more}",
        config.display()
    );
    TrainUnderTest::new(program!(), &text).at_fixed_port()
}

/// A train of eight wagons of which six have a fault, by number; time runs faster than outside.
pub fn faulty(name: &str) -> TrainUnderTest {
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config").canonicalize().unwrap();
    let demo = std::fs::read_to_string(scenarios.join("scenarios/demo.toml")).unwrap();
    let vehicle = scenarios.join("vehicle.toml").display().to_string();
    let text = format!(
        "schema = 1\n[train]\nname = \"{name}\"\nwagons = 8\nvehicle = \"{vehicle}\"\n[source]\nkind = \"simulate\"\n\
         scenario = \"faulty.toml\"\nspeed = 4.0\n[history]\nflush_s = 1.0\n[alerts]\nraise_after_s = 1.0\n",
    );
    let train = TrainUnderTest::new(program!(), &text).at_fixed_port();
    let scenario = demo.replace("../vehicle.toml", &vehicle) + FAULTS;
    std::fs::write(train.folder().join("faulty.toml"), scenario).unwrap();
    train
}

const FAULTS: &str = r#"
[[wagon]]
number = 2
pad_friction_factors = [1.0, 0.55]
[[wagon]]
number = 3
dragging_force_n = 25000.0
[[wagon]]
number = 4
isolated_wheelsets = [1]
[[wagon]]
number = 6
pad_friction_factors = [0.5, 0.5]
[[fault]]
wagon = 5
signal = "omega_f_rad_s"
kind = "missing"
from_s = 2.0
until_s = 100000.0
[[fault]]
wagon = 7
kind = "silent"
from_s = 2.0
until_s = 100000.0
"#;

/// A train that runs, and the address of its page.
pub fn running(name: &str, wagons: u32) -> (TrainUnderTest, String) {
    started(train(name, wagons, ""))
}

pub fn started(mut train: TrainUnderTest) -> (TrainUnderTest, String) {
    train.start();
    train.wait_ready(2 * PATIENCE);
    let address = std::fs::read_to_string(train.instance().join("http.address")).unwrap();
    (train, format!("http://{}", address.trim()))
}

/// Started, although one of its wagons never sends anything for long.
pub fn started_without_all(mut train: TrainUnderTest) -> (TrainUnderTest, String) {
    train.start();
    let answers = || {
        train
            .http()
            .and_then(|http| http.json("/api/v1/train"))
            .filter(|view| view["live"].as_u64() >= Some(6))
    };
    assert!(within(2 * PATIENCE, answers).is_some(), "the train does not start: {}", train.log());
    let address = std::fs::read_to_string(train.instance().join("http.address")).unwrap();
    (train, format!("http://{}", address.trim()))
}

pub fn live(tab: &Tab<'_>) {
    tab.wait(PATIENCE, "document.getElementById('link')?.dataset.state === 'live'");
}

/// Nothing went wrong in the page, and it asked nobody but its own service.
pub fn sound(tab: &Tab<'_>, base: &str) {
    assert_eq!(tab.faults(), Vec::<String>::new());
    let elsewhere: Vec<String> = tab.requests().into_iter().filter(|url| !url.starts_with(base)).collect();
    assert_eq!(elsewhere, Vec::<String>::new(), "requests to elsewhere");
}

/// What every page owes to people who use no mouse, no eyes, or a small screen.
pub fn usable(tab: &Tab<'_>) {
    for look in [PHONE, LAPTOP, WALL] {
        tab.look(look);
        // The page is laid out anew a moment after its width has changed.
        tab.wait(
            PATIENCE,
            &format!("innerWidth === {} && document.documentElement.scrollWidth <= innerWidth", look.width),
        );
        let sticks_out =
            tab.eval("document.documentElement.scrollWidth - document.documentElement.clientWidth");
        assert_eq!(sticks_out, 0, "{look:?}: something sticks out to the right");
        assert_eq!(tab.eval(CUT_OFF), serde_json::json!([]), "{look:?}: text is cut off");
        assert_eq!(tab.eval(TOO_FAINT), serde_json::json!([]), "{look:?}: contrast below 4.5");
    }
    for look in [PHONE, LAPTOP] {
        tab.look(look);
        tab.wait(PATIENCE, &format!("innerWidth === {}", look.width));
        assert_eq!(tab.eval(TOO_SMALL), serde_json::json!([]), "{look:?}: targets below 24 px");
    }
    assert_eq!(tab.eval("document.querySelectorAll('main').length"), 1);
    assert_eq!(tab.eval("document.querySelectorAll('h1').length"), 1);
    assert_eq!(tab.text("document.documentElement.lang"), "en");
    assert_eq!(tab.eval(NAMELESS), serde_json::json!([]), "links, buttons and fields without a name");
    assert_eq!(tab.eval(TWICE), serde_json::json!([]), "ids that occur twice");
    tab.eval("document.activeElement.blur(); scrollTo(0, 0)");
    tab.press("Tab");
    assert_eq!(tab.text("document.activeElement.className"), "skip", "the first stop of the Tab key");
    tab.press("Enter");
    tab.wait(PATIENCE, "location.hash === '#main'");
}

const CUT_OFF: &str = "[...document.querySelectorAll('main *, .top *')].filter(e => !e.closest('.unseen, .chart, .slider, table thead, [hidden]') \
     && e.clientWidth > 0 && e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).overflowX !== 'visible') \
     .map(e => e.tagName + '.' + e.className + ': ' + e.textContent.slice(0, 40))";
const NAMELESS: &str = "[...document.querySelectorAll('a, button, input, select')].filter(e => !e.closest('dialog:not([open])') \
     && !(e.getAttribute('aria-label') || e.textContent.trim() || e.labels?.length)).map(e => e.outerHTML)";
const TWICE: &str = "(() => { const ids = [...document.querySelectorAll('[id]')].map(e => e.id); \
     return ids.filter((id, i) => ids.indexOf(id) !== i); })()";
/// What is to be hit with a finger or a pointer, smaller than WCAG 2.2 (2.5.8) asks: 24 px, unless it stands in a sentence, or
/// so far from others that circles of 24 px around their middles do not meet.
pub const TOO_SMALL: &str = r"(() => {
  const seen = (e) => e.checkVisibility({ visibilityProperty: true }) && e.getClientRects().length && !e.closest('.skip, .unseen, dialog:not([open])');
  const all = [...document.querySelectorAll('a, button, input, select, summary')].filter(seen).map((e) => ({ e, r: e.getBoundingClientRect() }));
  const inSentence = (e) => e.tagName === 'A' && [...e.parentElement.childNodes].some((n) => n.nodeType === 3 && n.nodeValue.trim().length > 2);
  const near = (a, b) => Math.hypot(a.r.x + a.r.width / 2 - b.r.x - b.r.width / 2, a.r.y + a.r.height / 2 - b.r.y - b.r.height / 2) < 24;
  return all.filter((one) => (one.r.width < 24 || one.r.height < 24) && !inSentence(one.e) && all.some((other) => other !== one && near(one, other)))
    .map(({ e, r }) => `${e.tagName} ${e.textContent.trim().slice(0, 30)} ${r.width.toFixed(0)} x ${r.height.toFixed(0)}`);
})()";
/// Text whose contrast with the first opaque background behind it is below WCAG's 4.5 (3 for large text).
pub const TOO_FAINT: &str = r"(() => {
  const canvas = document.createElement('canvas'); canvas.width = canvas.height = 1;
  const pen = canvas.getContext('2d', { willReadFrequently: true });
  const rgba = (text) => { pen.clearRect(0, 0, 1, 1); pen.fillStyle = text; pen.fillRect(0, 0, 1, 1); return pen.getImageData(0, 0, 1, 1).data; };
  const light = (c) => [0.2126, 0.7152, 0.0722].reduce((sum, share, i) => { const v = c[i] / 255; return sum + share * (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); }, 0);
  const behind = (e) => { for (; e; e = e.parentElement) { const c = rgba(getComputedStyle(e).backgroundColor); if (c[3] === 255) return c; } return [255, 255, 255]; };
  const faint = new Set();
  for (const e of document.querySelectorAll('main *, .top *, footer *, .lost, .lost *')) {
    const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.nodeValue.trim());
    if (!own || e.closest('.unseen, .u-axis, svg, [hidden], .s-stale, .s-silent') || !e.getClientRects().length) continue;
    const style = getComputedStyle(e); const [a, b] = [light(rgba(style.color)), light(behind(e))];
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const large = parseFloat(style.fontSize) >= 24 || (parseFloat(style.fontSize) >= 18.6 && style.fontWeight >= 700);
    if (contrast < (large ? 3 : 4.5)) faint.add(`${contrast.toFixed(2)} ${e.tagName}.${e.className} ${e.textContent.trim().slice(0, 30)}`);
  }
  return [...faint];
})()";
