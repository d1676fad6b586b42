//! A real headless Chromium, driven by its DevTools protocol.
//!
//! Messages go through the browser's debugging pipe (JSON, ended by a NUL byte): that takes no socket, no port and no
//! further crate. Only what the scenarios need is here.

use serde_json::{Value, json};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A browser that has not answered for this long is stuck.
const PATIENCE: Duration = Duration::from_secs(120);
/// A service that is restarted is back within this.
const RESTART: Duration = Duration::from_secs(60);
/// Gives the browser its pipe where it looks for it: file descriptors 3 and 4.
const TO_THE_PIPE: &str = r#"exec "$@" 3<&0 4>&1 </dev/null >/dev/null 2>&1"#;
const FLAGS: [&str; 15] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--disable-dev-shm-usage",
    "--disable-extensions",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-default-apps",
    "--disable-sync",
    "--enable-precise-memory-info",
    "--hide-scrollbars",
    "--no-default-browser-check",
    "--no-first-run",
    "--remote-debugging-pipe",
];

/// A running browser with a profile of its own.
pub struct Browser {
    wire: RefCell<Wire>,
    _profile: TempDir,
}

struct Wire {
    child: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    asked: u64,
    events: VecDeque<Value>,
}

/// One page of the browser.
pub struct Tab<'a> {
    browser: &'a Browser,
    session: String,
}

/// How a page is looked at.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// Width of the window, CSS pixels.
    pub width: u32,
    /// Height of the window, CSS pixels.
    pub height: u32,
    /// Dark instead of light.
    pub dark: bool,
}

impl Browser {
    /// Starts one.
    ///
    /// # Panics
    /// If there is none: the message names the package to install.
    #[must_use]
    pub fn start() -> Self {
        let program = railgrip_requirements::CHROMIUM.path();
        let profile = tempfile::Builder::new().prefix("rgb").tempdir().expect("a folder for the profile");
        let mut command = Command::new("sh");
        command.args(["-c", TO_THE_PIPE, "sh"]).arg(&program).args(FLAGS);
        command.arg(format!("--user-data-dir={}", profile.path().display())).arg("about:blank");
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("{}: {error}", program.display()));
        let (to, from) = (child.stdin.take().expect("stdin"), listen(child.stdout.take().expect("stdout")));
        let wire = Wire { child, to, from, asked: 0, events: VecDeque::new() };
        let browser = Self { wire: RefCell::new(wire), _profile: profile };
        let version = browser.call(None, "Browser.getVersion", json!({}));
        eprintln!("{} of {}", version["product"].as_str().unwrap_or("?"), program.display());
        browser
    }

    /// Opens an empty page that reports what goes wrong in it. It has a window of its own, so that none hides another: a page
    /// that nobody sees lets go of its connection.
    #[must_use]
    pub fn tab(&self) -> Tab<'_> {
        let target =
            self.call(None, "Target.createTarget", json!({ "url": "about:blank", "newWindow": true }));
        let attached = self.call(
            None,
            "Target.attachToTarget",
            json!({ "targetId": target["targetId"], "flatten": true }),
        );
        let session = attached["sessionId"].as_str().expect("a session").to_owned();
        let tab = Tab { browser: self, session };
        for domain in ["Page", "Runtime", "Log", "Network", "Performance"] {
            tab.call(&format!("{domain}.enable"), json!({}));
        }
        tab
    }

    /// Asks and waits for the answer; events that come meanwhile are kept.
    fn call(&self, session: Option<&str>, method: &str, params: Value) -> Value {
        self.ask(session, method, params).unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    /// The same; what the browser refuses is an error.
    fn ask(&self, session: Option<&str>, method: &str, params: Value) -> Result<Value, Value> {
        let mut wire = self.wire.borrow_mut();
        wire.asked += 1;
        let id = wire.asked;
        let mut message = json!({ "id": id, "method": method, "params": params });
        if let Some(session) = session {
            message["sessionId"] = session.into();
        }
        let mut bytes = message.to_string().into_bytes();
        bytes.push(0);
        wire.to.write_all(&bytes).and_then(|()| wire.to.flush()).expect("the browser listens");
        let deadline = Instant::now() + PATIENCE;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let answer = wire.from.recv_timeout(left).unwrap_or_else(|_| panic!("no answer to {method}"));
            if answer["id"] != id {
                wire.events.push_back(answer);
                continue;
            }
            if !answer["error"].is_null() {
                return Err(answer["error"].clone());
            }
            return Ok(answer["result"].clone());
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let wire = self.wire.get_mut();
        let _ =
            wire.to.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0").and_then(|()| wire.to.flush());
        let deadline = Instant::now() + Duration::from_secs(3);
        while Instant::now() < deadline {
            if matches!(wire.child.try_wait(), Ok(Some(_))) {
                return;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        let _ = wire.child.kill();
        let _ = wire.child.wait();
    }
}

/// Reads messages on a thread of its own, which ends with the browser.
fn listen(from: ChildStdout) -> Receiver<Value> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let mut from = BufReader::new(from);
        let mut bytes = Vec::new();
        while from.read_until(0, &mut bytes).is_ok_and(|count| count > 0) {
            let message = serde_json::from_slice(bytes.strip_suffix(&[0]).unwrap_or(&bytes));
            bytes.clear();
            if sender.send(message.unwrap_or(Value::Null)).is_err() {
                break;
            }
        }
    });
    receiver
}

impl Tab<'_> {
    /// Any method of the protocol.
    pub fn call(&self, method: &str, params: Value) -> Value {
        self.browser.call(Some(&self.session), method, params)
    }

    /// Sets the size of the window and the preferred theme.
    pub fn look(&self, look: Look) {
        let Look { width, height, dark } = look;
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", size);
        let theme = if dark { "dark" } else { "light" };
        // Colours that are on their way to others cannot be judged.
        let features = json!({ "features": [
            { "name": "prefers-color-scheme", "value": theme },
            { "name": "prefers-reduced-motion", "value": "reduce" },
        ] });
        self.call("Emulation.setEmulatedMedia", features);
    }

    /// Goes to an address. A service that its supervisor is just starting again refuses connections for a moment.
    ///
    /// # Panics
    /// If nobody answers there.
    pub fn open(&self, url: &str) {
        let started = Instant::now();
        loop {
            let answer = self.call("Page.navigate", json!({ "url": url }));
            if answer["errorText"] == "net::ERR_CONNECTION_REFUSED" && started.elapsed() < RESTART {
                std::thread::sleep(Duration::from_millis(200));
                continue;
            }
            assert!(answer["errorText"].is_null(), "{url}: {}", answer["errorText"]);
            return;
        }
    }

    /// The value of a JavaScript expression; promises are waited for.
    ///
    /// # Panics
    /// If it throws.
    pub fn eval(&self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true, "userGesture": true });
        let answer = self.call("Runtime.evaluate", params);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {}", answer["exceptionDetails"]);
        answer["result"]["value"].clone()
    }

    /// The value of an expression as text.
    #[must_use]
    pub fn text(&self, expression: &str) -> String {
        self.eval(expression).as_str().unwrap_or_default().to_owned()
    }

    /// Waits until an expression is true; says how long that took.
    ///
    /// # Panics
    /// If it never is; shows what the page says.
    pub fn wait(&self, patience: Duration, expression: &str) -> Duration {
        let started = Instant::now();
        while started.elapsed() < patience {
            // A page that is just being left answers nothing.
            let params = json!({ "expression": format!("!!document.body && !!({expression})"), "returnByValue": true });
            if let Ok(answer) = self.browser.ask(Some(&self.session), "Runtime.evaluate", params) {
                let thrown = &answer["exceptionDetails"];
                assert!(thrown.is_null(), "{expression}: {thrown}");
                if answer["result"]["value"] == true {
                    return started.elapsed();
                }
            }
            std::thread::sleep(Duration::from_millis(25));
        }
        let page = self.text("document.body ? document.body.innerText : ''");
        panic!(
            "not within {patience:?}: {expression}\n--- the page says ---\n{page}\n--- faults ---\n{:#?}",
            self.faults()
        )
    }

    /// Clicks in the middle of an element with a real mouse event.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn click(&self, selector: &str) {
        let place = self.eval(&format!(
            "(() => {{ const e = document.querySelector({selector:?}); if (!e) return null; \
             e.scrollIntoView({{ block: 'center' }}); const r = e.getClientRects()[0] ?? e.getBoundingClientRect(); \
             return [r.x + r.width / 2, r.y + r.height / 2]; }})()"
        ));
        assert!(place.is_array(), "nothing to click: {selector}");
        for kind in ["mousePressed", "mouseReleased"] {
            let event =
                json!({ "type": kind, "x": place[0], "y": place[1], "button": "left", "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", event);
        }
    }

    /// Presses and releases a key: `Tab`, `Enter`, `Escape`.
    pub fn press(&self, key: &str) {
        let code = match key {
            "Tab" => 9,
            "Enter" => 13,
            "Escape" => 27,
            _ => 0,
        };
        let text = if key == "Enter" { "\r" } else { "" };
        for kind in ["keyDown", "keyUp"] {
            let mut event = json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code });
            if kind == "keyDown" && !text.is_empty() {
                event["text"] = text.into();
            }
            self.call("Input.dispatchKeyEvent", event);
        }
    }

    /// Types into what has the focus.
    pub fn write(&self, text: &str) {
        self.call("Input.insertText", json!({ "text": text }));
    }

    /// Everything that went wrong in the page so far: exceptions, errors in its log (a refused inline style is one), and
    /// requests to anywhere but `allowed`.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let wire = self.browser.wire.borrow();
        let own = wire.events.iter().filter(|event| event["sessionId"] == self.session.as_str());
        own.filter_map(|event| match event["method"].as_str()? {
            "Runtime.exceptionThrown" => Some(event["params"]["exceptionDetails"].to_string()),
            "Log.entryAdded" if event["params"]["entry"]["level"] == "error" => {
                Some(event["params"]["entry"].to_string())
            }
            _ => None,
        })
        .collect()
    }

    /// Addresses that the page asked for.
    #[must_use]
    pub fn requests(&self) -> Vec<String> {
        self.eval("document.readyState");
        let wire = self.browser.wire.borrow();
        let own = wire.events.iter().filter(|event| event["sessionId"] == self.session.as_str());
        let sent = own.filter(|event| event["method"] == "Network.requestWillBeSent");
        sent.filter_map(|event| event["params"]["request"]["url"].as_str().map(str::to_owned)).collect()
    }

    /// JavaScript heap in use after a collection, bytes.
    #[must_use]
    pub fn heap_bytes(&self) -> f64 {
        self.call("HeapProfiler.collectGarbage", json!({}));
        self.call("Runtime.getHeapUsage", json!({}))["usedSize"].as_f64().unwrap_or(f64::NAN)
    }

    /// A figure of the browser about the page, for example `Nodes` or `JSEventListeners`.
    #[must_use]
    pub fn metric(&self, name: &str) -> f64 {
        let answer = self.call("Performance.getMetrics", json!({}));
        let all = answer["metrics"].as_array().cloned().unwrap_or_default();
        all.iter()
            .find(|metric| metric["name"] == name)
            .and_then(|metric| metric["value"].as_f64())
            .unwrap_or(f64::NAN)
    }
}
