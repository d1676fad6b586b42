//! The pages in a real Chromium, served by a real train: loading, renewing, acknowledging, outliving the service, old data,
//! a long train.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]
#![allow(clippy::print_stdout, reason = "tests print the figures they measure")]

use railgrip_tests::{Browser, Look, Tab, TrainUnderTest, program, within};
use rustix::process::Signal;
use std::path::Path;
use std::time::Duration;

railgrip_requirements::tests! {
    the_pages_load_say_everything_in_words_and_renew_themselves: [CHROMIUM],
    old_data_say_so_loudly_and_an_alert_is_acknowledged_with_the_keyboard: [CHROMIUM],
    the_page_outlives_the_service: [CHROMIUM],
    who_is_not_known_is_led_to_the_login_and_back: [CHROMIUM],
    a_train_of_64_wagons_is_shown_whole_and_costs_no_memory_over_time: [CHROMIUM],
}

const SECOND: Duration = Duration::from_secs(1);
const PHONE: Look = Look { width: 390, height: 844, dark: false };
const LAPTOP: Look = Look { width: 1280, height: 800, dark: false };
const WALL: Look = Look { width: 1920, height: 1080, dark: true };

/// Machines on which tests run may be slow; nobody waits longer than it takes.
const PATIENCE: Duration = Duration::from_secs(60);

fn train(name: &str, wagons: u32, more: &str) -> TrainUnderTest {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config").canonicalize().unwrap();
    let text = format!(
        "schema = 1\n[train]\nname = \"{name}\"\nwagons = {wagons}\nvehicle = \"{0}/vehicle.toml\"\n[source]\n\
         kind = \"simulate\"\nscenario = \"{0}/scenarios/demo.toml\"\n[alerts]\nraise_after_s = 1.0\nclear_after_s = 2.0\n\
         [logging]\nlevel = \"info\"\nformat = \"text\"\n{more}",
        config.display()
    );
    TrainUnderTest::new(program!(), &text).at_fixed_port()
}

/// A train that runs, and the address of its page.
fn running(name: &str, wagons: u32) -> (TrainUnderTest, String) {
    started(train(name, wagons, ""))
}

fn started(mut train: TrainUnderTest) -> (TrainUnderTest, String) {
    train.start();
    train.wait_ready(2 * PATIENCE);
    let address = std::fs::read_to_string(train.instance().join("http.address")).unwrap();
    (train, format!("http://{}", address.trim()))
}

fn live(tab: &Tab<'_>) {
    tab.wait(PATIENCE, "document.getElementById('link')?.dataset.state === 'live'");
}

/// Nothing went wrong in the page, and it asked nobody but its own service.
fn sound(tab: &Tab<'_>, base: &str) {
    assert_eq!(tab.faults(), Vec::<String>::new());
    let elsewhere: Vec<String> = tab.requests().into_iter().filter(|url| !url.starts_with(base)).collect();
    assert_eq!(elsewhere, Vec::<String>::new(), "requests to elsewhere");
}

/// What every page owes to people who use no mouse, no eyes, or a small screen.
fn usable(tab: &Tab<'_>) {
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

const CUT_OFF: &str = "[...document.querySelectorAll('main *, .top *')].filter(e => !e.closest('.unseen, .chart, table thead, [hidden]') \
     && e.clientWidth > 0 && e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).overflowX !== 'visible') \
     .map(e => e.tagName + '.' + e.className + ': ' + e.textContent.slice(0, 40))";
const NAMELESS: &str = "[...document.querySelectorAll('a, button, input, select')].filter(e => !e.closest('dialog:not([open])') \
     && !(e.getAttribute('aria-label') || e.textContent.trim() || e.labels?.length)).map(e => e.outerHTML)";
const TWICE: &str = "(() => { const ids = [...document.querySelectorAll('[id]')].map(e => e.id); \
     return ids.filter((id, i) => ids.indexOf(id) !== i); })()";
/// Text whose contrast with the first opaque background behind it is below WCAG's 4.5 (3 for large text).
const TOO_FAINT: &str = r"(() => {
  const canvas = document.createElement('canvas'); canvas.width = canvas.height = 1;
  const pen = canvas.getContext('2d', { willReadFrequently: true });
  const rgba = (text) => { pen.clearRect(0, 0, 1, 1); pen.fillStyle = text; pen.fillRect(0, 0, 1, 1); return pen.getImageData(0, 0, 1, 1).data; };
  const light = (c) => [0.2126, 0.7152, 0.0722].reduce((sum, share, i) => { const v = c[i] / 255; return sum + share * (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); }, 0);
  const behind = (e) => { for (; e; e = e.parentElement) { const c = rgba(getComputedStyle(e).backgroundColor); if (c[3] === 255) return c; } return [255, 255, 255]; };
  const faint = new Set();
  for (const e of document.querySelectorAll('main *, .top *, footer *')) {
    const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.nodeValue.trim());
    if (!own || e.closest('.unseen, .u-axis, svg, [hidden], .s-stale, .s-silent') || !e.getClientRects().length) continue;
    const style = getComputedStyle(e); const [a, b] = [light(rgba(style.color)), light(behind(e))];
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const large = parseFloat(style.fontSize) >= 24 || (parseFloat(style.fontSize) >= 18.6 && style.fontWeight >= 700);
    if (contrast < (large ? 3 : 4.5)) faint.add(`${contrast.toFixed(2)} ${e.tagName}.${e.className} ${e.textContent.trim().slice(0, 30)}`);
  }
  return [...faint];
})()";

fn the_pages_load_say_everything_in_words_and_renew_themselves() {
    let (mut train, base) = running("pages", 3);
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(LAPTOP);
    tab.open(&format!("{base}/"));
    live(&tab);
    assert_eq!(tab.text("document.title"), "Train – pages – railgrip");
    assert_eq!(tab.eval("document.querySelectorAll('.train > li').length"), 3);
    let words = "[...document.querySelectorAll('.train .word')].every(e => /^(ok|watch|act|unknown)$/.test(e.textContent))";
    assert_eq!(tab.eval(words), true, "a grade that is a colour only");
    tab.wait(
        PATIENCE,
        "/3\u{202f}\\/\u{202f}3 live, data < 1 s old/.test(document.getElementById('pulse').textContent)",
    );

    // Live: figures change while the document stays the same one.
    tab.eval("window.stays = true; window.before = document.getElementById('facts').textContent");
    let took = tab.wait(PATIENCE, "document.getElementById('facts').textContent !== window.before");
    println!("a figure changed after {took:?}");
    assert_eq!(tab.eval("window.stays"), true, "the page was loaded anew");
    usable(&tab);
    sound(&tab, &base);

    // The train as a whole: how far it runs, and where the rail is low.
    tab.wait(PATIENCE, "document.querySelectorAll('#stops tbody tr').length === 4");
    let stops = tab.text("document.getElementById('stops').innerText");
    println!("stopping distances: {stops:?}");
    assert!(stops.contains("80 km/h") && stops.contains("nominal distance"), "{stops}");
    tab.wait(PATIENCE, "document.querySelector('#map canvas')");

    // A wagon has an address of its own, reachable by a link.
    tab.look(LAPTOP);
    tab.click("#w-2 a");
    tab.wait(PATIENCE, "location.pathname === '/wagons/2' && document.querySelector('#indicators tbody tr')");
    live(&tab);
    let rows = tab.text("document.getElementById('indicators').innerText");
    for word in [
        "Pad friction",
        "standardised",
        "Brake builds up in",
        "Drag when released",
        "Without a brake",
        "Adhesion available",
        "95 % interval",
        "Sand",
        "Faulty sensor",
        "Rail",
        "ok",
    ] {
        assert!(rows.contains(word), "{word}: {rows}");
    }
    assert_eq!(tab.eval("document.querySelectorAll('#wheelsets section').length"), 2);
    assert_eq!(
        tab.text("document.querySelector('.strip [aria-current=page]')?.getAttribute('href')"),
        "/wagons/2"
    );
    usable(&tab);
    trends(&tab);
    sound(&tab, &base);

    tab.open(&format!("{base}/alerts"));
    live(&tab);
    usable(&tab);
    sound(&tab, &base);

    // Every indicator leads to what it means.
    tab.open(&format!("{base}/wagons/1"));
    live(&tab);
    tab.click("#indicators a[href='/indicators#dragging']");
    tab.wait(PATIENCE, "location.pathname === '/indicators' && document.querySelector('#dragging:target')");
    let said = tab.text("document.getElementById('dragging').innerText");
    assert!(said.contains("Cannot see") && said.contains("kN"), "{said}");
    // With a target, Tab goes on from there; whoever comes without one starts at the top.
    tab.open(&format!("{base}/indicators"));
    live(&tab);
    usable(&tab);

    // What does not exist says so in words.
    tab.open(&format!("{base}/wagons/99"));
    tab.wait(PATIENCE, "document.querySelector('h1')?.textContent.includes('There is no wagon')");
    assert!(train.stop().success());
}

/// The history is drawn, said in words, and the range can be chosen.
fn trends(tab: &Tab<'_>) {
    tab.wait(2 * PATIENCE, "document.querySelectorAll('.chart canvas').length >= 6");
    tab.click("[data-range='900']");
    tab.wait(2 * PATIENCE, "/Data for [1-9]/.test(document.getElementById('trend-state').textContent)");
    tab.wait(
        PATIENCE,
        "/rising|falling|no trend|eight points/.test(document.getElementById('outlook').textContent)",
    );
    let said = tab.text("document.querySelector('.chart .plot').getAttribute('aria-label')");
    println!("the first chart says: {said}");
    assert!(said.starts_with("Pad friction. wheelset 1: "), "{said}");
    assert_eq!(tab.text("document.querySelector('[data-range][aria-pressed=true]').dataset.range"), "900");
}

fn old_data_say_so_loudly_and_an_alert_is_acknowledged_with_the_keyboard() {
    let (mut train, base) = running("stale", 2);
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(LAPTOP);
    tab.open(&format!("{base}/"));
    live(&tab);
    let (up, ingest) = (train.process("up"), train.process("ingest"));
    // The supervisor would restart what hangs.
    up.signal(Signal::STOP);
    ingest.signal(Signal::STOP);
    tab.wait(PATIENCE, "document.querySelectorAll('.train .s-stale').length === 2");
    let pulse = tab.text(
        "document.getElementById('pulse').className + ' ' + document.getElementById('pulse').textContent",
    );
    println!("stale: {pulse}");
    assert!(pulse.contains("loud") && pulse.contains("0\u{202f}/\u{202f}2 live"), "{pulse}");
    assert!(tab.text("document.getElementById('w-1').innerText").contains("stale"));
    assert!(tab.text("document.querySelector('#r-1').innerText").contains("stale, "));

    // The alert that follows is said aloud; two keys and a name acknowledge it.
    tab.wait(PATIENCE, "document.querySelector('#todo [data-act=acknowledge]')");
    tab.wait(PATIENCE, "document.getElementById('announcer').textContent.startsWith('New alert')");
    let id = tab.text("document.querySelector('#todo [data-act=acknowledge]').dataset.alert");
    tab.eval("document.querySelector('#todo [data-act=acknowledge]').focus()");
    tab.press("Enter");
    tab.wait(
        PATIENCE,
        "document.getElementById('act-dialog').open && document.activeElement.id === 'act-by'",
    );
    tab.write("Early Shift");
    tab.press("Enter");
    tab.wait(PATIENCE, "!document.getElementById('act-dialog').open");
    let shown =
        format!("document.getElementById('alert-{id}')?.innerText.includes('Acknowledged by Early Shift')");
    let took = tab.wait(PATIENCE, &shown);
    println!("acknowledged, shown after {took:?}");
    let alert = train.http().unwrap().json(&format!("/api/v1/alerts/{id}")).unwrap();
    assert_eq!(
        (&alert["state"], &alert["acknowledged"]["by"]),
        (&"acknowledged".into(), &"Early Shift".into())
    );

    // A silence asks for a reason and a time; the other page shows it.
    tab.open(&format!("{base}/alerts"));
    live(&tab);
    tab.click(&format!("#alert-{id} [data-act=silence]"));
    tab.wait(PATIENCE, "document.activeElement.id === 'act-note'");
    tab.write("wagon is in the workshop");
    tab.press("Enter");
    tab.wait(
        PATIENCE,
        &format!("document.querySelector('#g-silenced #alert-{id}')?.innerText.includes('workshop')"),
    );

    ingest.signal(Signal::CONT);
    std::thread::sleep(SECOND);
    up.signal(Signal::CONT);
    tab.open(&format!("{base}/"));
    tab.wait(PATIENCE, "document.querySelectorAll('.train .s-live').length === 2");
    assert!(!tab.text("document.getElementById('pulse').className").contains("loud"));
    sound(&tab, &base);
    assert!(train.stop().success());
}

fn the_page_outlives_the_service() {
    let (mut train, base) = running("outlives", 2);
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(LAPTOP);
    tab.open(&format!("{base}/"));
    live(&tab);
    tab.eval("window.stays = true");
    let health = train.process("health");
    // A service that hangs is as lost as one that is gone: first it only stops to answer.
    health.signal(Signal::STOP);
    tab.wait(PATIENCE, "!document.getElementById('lost').hidden");
    let said = tab.text(
        "document.getElementById('lost').innerText + ' | ' + document.getElementById('link').textContent",
    );
    println!("lost: {said}");
    assert!(said.contains("Connection lost") && said.contains("not connected"), "{said}");
    assert_eq!(tab.eval("document.body.classList.contains('is-lost')"), true);
    tab.wait(PATIENCE, "Number(document.querySelector('#r-1 [data-age]').textContent.match(/\\d+/)[0]) >= 3");
    health.kill();
    let _ = train.successor(&health);
    let took = tab.wait(PATIENCE, "document.getElementById('link').dataset.state === 'live'");
    println!("live again {took:?} after the service was killed");
    tab.wait(PATIENCE, "document.querySelectorAll('.train .s-live').length === 2");
    assert_eq!(
        tab.eval("document.getElementById('lost').hidden && window.stays"),
        true,
        "by itself, without a reload"
    );
    assert!(tab.text("document.getElementById('announcer').textContent").contains("back"));
    assert!(within(SECOND, || train.is_up().then_some(())).is_some());
    assert!(train.stop().success());
}

fn who_is_not_known_is_led_to_the_login_and_back() {
    let more = "[http]\ntoken_file = \"tokens.toml\"\n";
    let train = train("access", 1, more);
    let made = train.run(&["token", "add", "depot", "--role", "acknowledge"]);
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let said = String::from_utf8_lossy(&made.stdout).into_owned();
    let secret = said.split_whitespace().max_by_key(|word| word.len()).unwrap().to_owned();
    let (mut train, base) = started(train);
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(PHONE);
    tab.open(&format!("{base}/wagons/1"));
    tab.wait(PATIENCE, "location.pathname === '/login' && document.activeElement?.id === 'token'");
    tab.write(&secret);
    tab.press("Enter");
    tab.wait(PATIENCE, "location.pathname === '/wagons/1'");
    live(&tab);

    // A token that ends takes the stream with it; the page does not stay behind and grow old.
    assert!(train.run(&["token", "revoke", "depot"]).status.success());
    tab.wait(PATIENCE, "location.pathname === '/login' && location.search.includes('wagons')");
    assert!(train.stop().success());
}

/// Looks once a minute at the memory of the service, at the heap of the page's script and at the browser's nodes. After a
/// third of the time, which belongs to buffers that fill once, neither may grow by more than a few percent.
fn stays_flat(minutes: usize, look: impl Fn() -> (f64, f64, f64)) {
    const MB: f64 = 1e-6;
    let mut seen: Vec<(f64, f64)> = Vec::new();
    for minute in 1..=minutes {
        std::thread::sleep(60 * SECOND);
        let (service, heap, nodes) = look();
        println!("{minute:3} min: service {:.1} MB, script {:.2} MB, {nodes} nodes", service * MB, heap * MB);
        seen.push((service, heap));
    }
    let third = minutes / 3;
    if third < 3 {
        return;
    }
    let mean = |part: &[(f64, f64)]| {
        let (service, heap) = part.iter().fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
        (service / part.len() as f64 * MB, heap / part.len() as f64 * MB)
    };
    let (middle, end) = (mean(&seen[third..2 * third]), mean(&seen[2 * third..]));
    println!(
        "second and last third, mean: service {:.1}, {:.1} MB; script {:.2}, {:.2} MB",
        middle.0, end.0, middle.1, end.1
    );
    assert!(end.0 < 1.05 * middle.0, "the service grows");
    assert!(end.1 < middle.1 + 0.5, "the heap of the page grows");
}

fn a_train_of_64_wagons_is_shown_whole_and_costs_no_memory_over_time() {
    let (mut train, base) = running("long", 64);
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(WALL);
    tab.open(&format!("{base}/"));
    live(&tab);
    let times = tab.text(
        "(() => { const n = performance.getEntriesByType('navigation')[0]; \
         return `answer ${n.responseEnd.toFixed(0)} ms, interactive ${n.domInteractive.toFixed(0)} ms, \
         scripts done ${n.domContentLoadedEventEnd.toFixed(0)} ms, loaded ${n.loadEventEnd.toFixed(0)} ms, \
         page ${(n.decodedBodySize / 1024).toFixed(0)} KiB`; })()",
    );
    println!("64 wagons: {times}");
    assert_eq!(tab.eval("document.querySelectorAll('.train > li').length"), 64);
    assert_eq!(tab.eval("document.querySelectorAll('.wagons tbody tr').length"), 64);
    tab.wait(PATIENCE, "document.querySelectorAll('.train .s-live').length === 64");
    usable(&tab);

    // After a first round of everything neither the heap nor the document may grow with the updates.
    let elements = || tab.eval("document.getElementsByTagName('*').length").as_f64().unwrap();
    let measure = || (tab.heap_bytes(), elements(), tab.metric("JSEventListeners"));
    tab.eval("window.renewed = 0; document.addEventListener('renewed', () => { window.renewed += 1; })");
    tab.wait(PATIENCE, "window.renewed >= 3");
    let first = measure();
    tab.wait(2 * PATIENCE, "window.renewed >= 15");
    let last = measure();
    println!("heap, elements, listeners: {first:?} and after twelve updates {last:?}");
    assert!(last.0 < first.0 + 1.5e6, "the heap grows");
    assert!(last.1 < 1.2 * first.1 && last.2 < first.2 + 20.0, "the document grows");
    sound(&tab, &base);
    // Afterwards the page need not be without faults: a machine that stands still for long has its stream cut off.
    let minutes = std::env::var("RAILGRIP_MINUTES").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    stays_flat(minutes, || (train.process("health").memory_bytes(), tab.heap_bytes(), tab.metric("Nodes")));
    assert!(train.stop().success());
}
