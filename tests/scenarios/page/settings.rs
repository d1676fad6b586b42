//! Thresholds and receivers on their page, by mouse and keyboard: what is typed stands in the config file, and what the check of
//! the file refuses is said in the dialog.

use super::common::*;
use railgrip_tests::Browser;

pub fn a_receiver_is_added_changed_and_removed_on_the_page() {
    let (mut train, base) = running("receivers", 1);
    let file = train.folder().join("train.toml");
    let config = || std::fs::read_to_string(&file).unwrap();
    let browser = Browser::start();
    let tab = browser.tab();
    tab.open(&format!("{base}/settings"));
    live(&tab);
    let fill = |field: &str, text: &str| {
        tab.eval(&format!("void (document.getElementById('receiver-{field}').value = {text:?})"));
    };
    let shown = |word: &str| {
        let rows = "[...document.querySelectorAll('#receiver-settings tbody tr')].map((row) => row.innerText).join(' | ')";
        tab.wait(PATIENCE, &format!("document.readyState === 'complete' && {rows}.includes({word:?})"));
    };

    tab.click("button[data-receiver='']");
    tab.wait(PATIENCE, "document.getElementById('receiver-dialog').open");
    for (field, text) in
        [("name", "depot"), ("url", "https://depot.example/hook"), ("by", "kim"), ("why", "trial")]
    {
        fill(field, text);
    }
    tab.click("#receiver-send");
    shown("https://depot.example");
    assert!(
        config().contains("# receiver depot added by kim at ")
            && config().contains("url = \"https://depot.example/hook\"")
    );

    usable(&tab);
    tab.look(LAPTOP);

    // A change leaves open what is not typed: the address stays.
    tab.click("button[data-receiver=depot]:not([data-remove])");
    tab.wait(PATIENCE, "document.getElementById('receiver-dialog').open");
    fill("grade", "act");
    fill("by", "lee");
    fill("why", "too many");
    tab.click("#receiver-send");
    shown("what needs action");
    let text = config();
    assert!(
        text.contains("grade = \"act\"") && text.contains("url = \"https://depot.example/hook\""),
        "{text}"
    );
    assert!(text.contains("changed by lee") && !text.contains("by kim"), "{text}");

    // What the check of the file refuses is said, and changes nothing.
    tab.click("button[data-receiver='']");
    tab.wait(PATIENCE, "document.getElementById('receiver-dialog').open");
    fill("kind", "mqtt");
    tab.eval("void document.getElementById('receiver-kind').dispatchEvent(new Event('change'))");
    for (field, text) in
        [("name", "yard"), ("host", "broker"), ("topic", "alerts/#"), ("by", "kim"), ("why", "x")]
    {
        fill(field, text);
    }
    tab.click("#receiver-send");
    tab.wait(PATIENCE, "document.getElementById('receiver-error').textContent.includes('topic')");
    assert_eq!(config(), text);

    // By TLS: the port follows, and the file of the authorities must be one.
    fill("topic", "alerts/{id}");
    tab.click("#receiver-tls");
    tab.wait(PATIENCE, "document.getElementById('receiver-port').value === '8883'");
    fill("ca_file", "ca.pem");
    tab.click("#receiver-send");
    tab.wait(PATIENCE, "document.getElementById('receiver-error').textContent.includes('ca_file')");
    std::fs::write(train.folder().join("ca.pem"), "-----BEGIN CERTIFICATE-----\n").expect("write");
    tab.click("#receiver-send");
    shown("TLS, authorities in");
    assert!(
        config().contains("port = 8883\ntopic = \"alerts/{id}\"\ntls = true\nca_file = \"ca.pem\"\n"),
        "{}",
        config()
    );
    usable(&tab);
    tab.click("button[data-receiver=yard]:not([data-remove])");
    tab.wait(
        PATIENCE,
        "document.getElementById('receiver-dialog').open && document.getElementById('receiver-tls').checked",
    );
    tab.click("#receiver-tls");
    tab.wait(PATIENCE, "document.getElementById('receiver-ca_file').closest('label').hidden");
    fill("by", "kim");
    fill("why", "inside the train");
    tab.click("#receiver-send");
    shown("broker:1883");
    assert!(config().contains("tls = false\n") && !config().contains("ca_file"), "{}", config());

    tab.click("button[data-receiver=depot][data-remove]");
    tab.wait(PATIENCE, "document.getElementById('receiver-dialog').open");
    fill("by", "kim");
    fill("why", "moved");
    tab.click("#receiver-send");
    tab.wait(
        PATIENCE,
        "document.readyState === 'complete' && !document.querySelector('button[data-receiver=depot]')",
    );
    assert!(config().contains("# receiver depot removed by kim at ") && !config().contains("depot.example"));
    assert!(train.stop().success());
}
