//! Pages that live: they renew themselves, say what is old, and outlive the service.

use super::common::*;
use railgrip_tests::{Browser, Tab, within};
use rustix::process::Signal;

pub fn the_pages_load_say_everything_in_words_and_renew_themselves() {
    let (mut train, base) = running("pages", 3);
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(LAPTOP);
    tab.open(&format!("{base}/"));
    live(&tab);
    assert!(tab.text("document.title").ends_with("Train – pages – railgrip"));
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
    // What is well and what is unknown is folded; each fold names what it holds.
    tab.eval("document.querySelectorAll('#indicators details').forEach((fold) => { fold.open = true; })");
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
    assert_eq!(tab.eval("document.querySelectorAll('#wheelsets li').length"), 2);
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
    tab.eval("document.querySelectorAll('#indicators details').forEach((fold) => { fold.open = true; })");
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
    tab.wait(2 * PATIENCE, "document.querySelectorAll('.chart canvas').length >= 1");
    tab.click("[data-range='900']");
    tab.wait(2 * PATIENCE, "/Data for [1-9]/.test(document.getElementById('trend-state').textContent)");
    tab.wait(
        PATIENCE,
        "/rising|falling|no trend|eight points/.test(document.getElementById('outlook').textContent)",
    );
    // A chart says what it shows, also to those who cannot see it.
    let told = "[...document.querySelectorAll('.chart .plot')].map((plot) => plot.ariaLabel).find((said) => said.includes(': last '))";
    tab.wait(2 * PATIENCE, told);
    let said = tab.text(told);
    println!("a chart says: {said}");
    assert!(said.contains("lowest ") && said.contains("% of the range has no data"), "{said}");
    assert_eq!(tab.text("document.querySelector('[data-range][aria-pressed=true]').dataset.range"), "900");
}

pub fn old_data_say_so_loudly_and_an_alert_is_acknowledged_with_the_keyboard() {
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

pub fn the_page_outlives_the_service() {
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
    // The banner counts; it can be read in both themes.
    for look in [LAPTOP, WALL] {
        tab.look(look);
        tab.wait(
            PATIENCE,
            "document.querySelector('.lost .since-when')?.textContent.startsWith('Last data')",
        );
        assert_eq!(
            tab.eval(TOO_FAINT),
            serde_json::json!([]),
            "{look:?}: contrast while the connection is lost"
        );
    }
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

pub fn who_is_not_known_is_led_to_the_login_and_back() {
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
