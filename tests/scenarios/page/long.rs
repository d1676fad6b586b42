//! A long train: what its page weighs, how soon it can be used, and that it costs no memory over time.

use super::common::*;
use railgrip_tests::Browser;

/// Looks three times a minute at the memory of the service, at the heap of the page's script and at the browser's nodes. After
/// a third of the time, which belongs to buffers that fill once, neither may grow by more than a few percent. The buffers of
/// the service take longer than the page's: it is judged in runs of ten minutes and more.
fn stays_flat(minutes: usize, look: impl Fn() -> (f64, f64, f64)) {
    const MB: f64 = 1e-6;
    let mut seen: Vec<(f64, f64)> = Vec::new();
    for at in 1..=3 * minutes {
        std::thread::sleep(20 * SECOND);
        let (service, heap, nodes) = look();
        if at % 3 == 0 {
            println!(
                "{:3} min: service {:.1} MB, script {:.2} MB, {nodes} nodes",
                at / 3,
                service * MB,
                heap * MB
            );
        }
        seen.push((service, heap));
    }
    if minutes == 0 {
        return;
    }
    let mean = |part: &[(f64, f64)]| {
        let (service, heap) = part.iter().fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
        (service / part.len() as f64 * MB, heap / part.len() as f64 * MB)
    };
    let (middle, end) = (mean(&seen[minutes..2 * minutes]), mean(&seen[2 * minutes..]));
    println!(
        "second and last third, mean: service {:.1}, {:.1} MB; script {:.2}, {:.2} MB",
        middle.0, end.0, middle.1, end.1
    );
    assert!(end.1 < middle.1 + 0.5, "the heap of the page grows");
    assert!(minutes < 10 || end.0 < 1.05 * middle.0, "the service grows");
}

pub fn a_train_of_64_wagons_is_shown_whole_and_costs_no_memory_over_time() {
    let (mut train, base) = running("long", 64);
    let browser = Browser::start();
    let tab = browser.tab();
    tab.look(WALL);
    tab.open(&format!("{base}/"));
    live(&tab);
    tab.wait(PATIENCE, "document.querySelectorAll('.train .s-live').length === 64");
    budget(&browser, &base);
    assert_eq!(tab.eval("document.querySelectorAll('.train > li').length"), 64);
    assert_eq!(tab.eval("document.querySelectorAll('.wagons tbody tr').length"), 64);
    usable(&tab);

    // After a first round of everything, the chart of the rail included, neither the heap nor the document may grow with the
    // updates.
    tab.wait(PATIENCE, "document.querySelector('#map canvas')");
    let elements = || tab.eval("document.getElementsByTagName('*').length").as_f64().unwrap();
    let measure = || (tab.heap_bytes(), elements(), tab.metric("JSEventListeners"));
    tab.eval("window.renewed = 0; document.addEventListener('renewed', () => { window.renewed += 1; })");
    tab.wait(PATIENCE, "window.renewed >= 3");
    let first = measure();
    tab.wait(2 * PATIENCE, "window.renewed >= 15");
    let last = measure();
    // The train may have more to say by then: so much as a page has that is opened only now.
    let fresh = browser.tab();
    fresh.look(WALL);
    fresh.open(&format!("{base}/"));
    live(&fresh);
    fresh.wait(PATIENCE, "document.readyState === 'complete' && document.querySelector('#map canvas')");
    let just_opened = fresh.eval("document.getElementsByTagName('*').length").as_f64().unwrap();
    println!(
        "heap, elements, listeners: {first:?} and after twelve updates {last:?}; opened then: {just_opened} elements"
    );
    assert!(last.0 < first.0 + 1.5e6, "the heap grows");
    assert!(last.1 < 1.1 * just_opened && last.2 < first.2 + 20.0, "the document grows");
    sound(&tab, &base);
    // Afterwards the page need not be without faults: a machine that stands still for long has its stream cut off.
    let minutes = std::env::var("RAILGRIP_MINUTES").ok().and_then(|text| text.parse().ok()).unwrap_or(5);
    stays_flat(minutes, || (train.process("health").memory_bytes(), tab.heap_bytes(), tab.metric("Nodes")));
    assert!(train.stop().success());
}

/// What 64 wagons cost a browser that has never seen the page: bytes over the wire until nothing more is asked for, and
/// elements. The time until it can be used is printed only: half a second is meant for an idle machine, and that of the tests
/// computes 64 wagons meanwhile.
fn budget(browser: &Browser, base: &str) {
    let tab = browser.tab();
    tab.look(WALL);
    tab.call("Network.setCacheDisabled", serde_json::json!({ "cacheDisabled": true }));
    tab.open(&format!("{base}/"));
    live(&tab);
    tab.wait(PATIENCE, "document.readyState === 'complete'");
    // The map's script comes last of all.
    tab.wait(PATIENCE, "document.querySelector('#map canvas')");
    let timing = |name: &str| {
        tab.eval(&format!("performance.getEntriesByType('navigation')[0].{name}")).as_f64().unwrap()
    };
    let page = tab.eval(
        "[...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')] \
         .filter((entry) => !entry.name.includes('/live') && !entry.name.includes('/api/')).reduce((sum, entry) => sum + entry.transferSize, 0)",
    );
    let (bytes, elements) =
        (page.as_f64().unwrap(), tab.eval("document.getElementsByTagName('*').length").as_f64().unwrap());
    let interactive_ms = timing("domContentLoadedEventEnd");
    println!(
        "64 wagons: {:.1} kB over the wire, {elements} elements, answer {:.0} ms, interactive with all scripts {interactive_ms:.0} ms",
        bytes / 1e3,
        timing("responseEnd"),
    );
    assert!(bytes <= 60e3, "{bytes} bytes");
    assert!(elements <= 1500.0, "{elements} elements");
}
