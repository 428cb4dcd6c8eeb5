//! A browser without a window, driven through its `DevTools` protocol over a pipe: Chromium reads
//! requests from its file descriptor 3 and writes answers and events to 4, with a 0 behind each.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tautrack_host_tests::programs::setup::{BROWSER, Part, ensure};

/// Maximum time to wait for anything; other programs may use the computer at the same time.
const LIMIT: Duration = Duration::from_mins(6);
/// Switches: everything that talks to a network or needs a display is off.
const SWITCHES: &str = "--headless --no-sandbox --no-first-run --disable-quic \
    --disable-background-networking --disable-component-update --disable-sync \
    --disable-extensions --disable-dev-shm-usage --use-angle=swiftshader \
    --enable-unsafe-swiftshader --hide-scrollbars --remote-debugging-pipe";

/// A running browser with one page; it ends when this is dropped.
pub struct Browser {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    session: String,
    next: u64,
    /// Errors that the console of the page showed.
    pub errors: Vec<String>,
}

impl Browser {
    /// Starts the browser with an empty page. Its profile is in `folder`.
    pub fn start(folder: &Path) -> Self {
        ensure(&[Part::Browser]).unwrap_or_else(|missing| panic!("{missing}"));
        let profile = folder.join("profile");
        let line = format!(
            "exec {BROWSER} {SWITCHES} --user-data-dir='{}' about:blank 3<&0 4>&1 >/dev/null 2>&1",
            profile.display()
        );
        let mut child = Command::new("sh")
            .args(["-c", &line])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("a shell");
        let to = child.stdin.take().expect("piped");
        let from = BufReader::new(child.stdout.take().expect("piped"));
        let mut browser = Self {
            child,
            to,
            from,
            session: String::new(),
            next: 1,
            errors: Vec::new(),
        };
        let targets = browser.call("Target.getTargets", &json!({}));
        let pages = targets["targetInfos"].as_array().expect("targets");
        let page = pages.iter().find(|target| target["type"] == "page");
        let target = &page.expect("a page")["targetId"];
        let attached = json!({ "targetId": target, "flatten": true });
        let attached = browser.call("Target.attachToTarget", &attached);
        let session = attached["sessionId"].as_str().expect("an id");
        session.clone_into(&mut browser.session);
        for domain in ["Page", "Runtime", "Log"] {
            browser.call(&format!("{domain}.enable"), &json!({}));
        }
        browser
    }

    /// Calls a method of the protocol. Returns its result.
    pub fn call(&mut self, method: &str, parameters: &Value) -> Value {
        let id = self.next;
        self.next += 1;
        let mut request = json!({ "id": id, "method": method, "params": parameters });
        if !self.session.is_empty() {
            request["sessionId"] = self.session.clone().into();
        }
        let mut bytes = request.to_string().into_bytes();
        bytes.push(0);
        self.to.write_all(&bytes).expect("the browser has ended");
        loop {
            let mut message = Vec::new();
            let count = self.from.read_until(0, &mut message).expect("a message");
            assert!(count > 0, "the browser has ended");
            message.pop();
            let message: Value = serde_json::from_slice(&message).expect("JSON");
            if message["id"] == id {
                assert!(message.get("error").is_none(), "{method}: {message}");
                return message["result"].clone();
            }
            self.note(&message);
        }
    }

    /// Keeps what an event says of an error.
    fn note(&mut self, event: &Value) {
        let parameters = &event["params"];
        let bad = match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => true,
            Some("Runtime.consoleAPICalled") => {
                ["error", "warning", "assert"].contains(&parameters["type"].as_str().unwrap_or(""))
            }
            Some("Log.entryAdded") => parameters["entry"]["level"] == "error",
            _ => false,
        };
        if bad {
            self.errors.push(parameters.to_string());
        }
    }

    /// Opens a file.
    pub fn open(&mut self, file: &Path) {
        let url = format!("file://{}", file.display());
        self.call("Page.navigate", &json!({ "url": url }));
    }

    /// Evaluates a script; a promise is awaited.
    pub fn evaluate(&mut self, script: &str) -> Value {
        let parameters = json!({
            "expression": script, "awaitPromise": true, "returnByValue": true, "userGesture": true,
        });
        let result = self.call("Runtime.evaluate", &parameters);
        assert!(
            result.get("exceptionDetails").is_none(),
            "{script}: {result}"
        );
        result["result"]["value"].clone()
    }

    /// Waits until a script is true.
    pub fn wait(&mut self, script: &str) {
        let began = Instant::now();
        while self.evaluate(&format!("Boolean({script})")) != true {
            if began.elapsed() > LIMIT {
                let texts = "[document.querySelector('aside')?.innerText, tautrack.errors, \
                    document.querySelector('#guard')?.innerText]";
                let texts = self.evaluate(texts);
                panic!("it never holds: {script}\n{texts}\n{:?}", self.errors);
            }
            sleep(Duration::from_millis(50));
        }
    }

    /// Presses a key, by its code, or releases it.
    pub fn key(&mut self, down: bool, code: &str) {
        let kind = if down { "rawKeyDown" } else { "keyUp" };
        let parameters = json!({ "type": kind, "code": code, "key": code });
        self.call("Input.dispatchKeyEvent", &parameters);
    }

    /// Presses and releases a key.
    pub fn press(&mut self, code: &str) {
        self.key(true, code);
        self.key(false, code);
    }

    /// Clicks the first element of a selector.
    pub fn click(&mut self, selector: &str) {
        let script = format!(
            "(() => {{ const e = document.querySelector({selector:?}); e.scrollIntoView({{ block: 'center' }}); \
             const r = e.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]; }})()"
        );
        let place = self.evaluate(&script);
        self.mouse("mousePressed", &place);
        self.mouse("mouseReleased", &place);
    }

    /// Sends an event of the left mouse button at a place.
    pub fn mouse(&mut self, kind: &str, place: &Value) {
        let parameters = json!({
            "type": kind, "x": place[0], "y": place[1], "button": "left", "clickCount": 1,
        });
        self.call("Input.dispatchMouseEvent", &parameters);
    }

    /// Sets the size of the window and the theme.
    pub fn dress(&mut self, [width, height]: [u32; 2], dark: bool) {
        let phone = width < 600;
        let size = json!({
            "width": width, "height": height, "deviceScaleFactor": if phone { 2 } else { 1 },
            "mobile": phone,
        });
        self.call("Emulation.setDeviceMetricsOverride", &size);
        self.call(
            "Emulation.setTouchEmulationEnabled",
            &json!({ "enabled": phone }),
        );
        let theme = if dark { "dark" } else { "light" };
        let features = json!([{ "name": "prefers-color-scheme", "value": theme }]);
        self.call(
            "Emulation.setEmulatedMedia",
            &json!({ "features": features }),
        );
    }

    /// Takes a picture of the window, as a PNG file in base 64.
    pub fn picture(&mut self) -> String {
        let picture = self.call("Page.captureScreenshot", &json!({ "format": "png" }));
        picture["data"].as_str().expect("a picture").to_owned()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self
            .to
            .write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0");
        let began = Instant::now();
        while matches!(self.child.try_wait(), Ok(None)) && began.elapsed() < Duration::from_secs(5)
        {
            sleep(Duration::from_millis(20));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
