//! Tests of the page on the web in headless Chromium: the page is opened from disk, and driven by
//! keys and the mouse as a visitor does it.

mod browser;
#[path = "../support/unchanged.rs"]
mod unchanged;

use browser::Browser;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::{env, fs};
use tautrack_host_tests::programs::setup::checkout;

/// Maximum size of the page, bytes.
const LARGEST: usize = 5_000_000;
const DESKTOP: [u32; 2] = [1280, 800];
const PHONE: [u32; 2] = [390, 844];

/// Folder for the files of these tests.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("page")
}

fn demo(arguments: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_demo"))
        .args(arguments)
        .output();
    let output = output.expect("the demo starts");
    assert!(output.status.success(), "{arguments:?}: {output:?}");
}

/// Makes the page. Returns its path.
fn page() -> &'static Path {
    static PAGE: OnceLock<PathBuf> = OnceLock::new();
    PAGE.get_or_init(|| {
        let out = folder();
        demo(&["--page", "--out", out.to_str().expect("text")]);
        out.join("page.html")
    })
}

/// Opens the page in a browser of its own.
fn open(name: &str) -> Browser {
    let page = page();
    let profile = folder().join(name);
    let _ = fs::remove_dir_all(&profile);
    let mut browser = Browser::start(&profile);
    browser.dress(DESKTOP, false);
    browser.open(page);
    browser.wait("window.tautrack?.state");
    browser
}

/// Runs a test, unless it has passed with the same page.
fn unless_unchanged(name: &str, test: impl FnOnce()) {
    let page = unchanged::sha256(&fs::read(page()).expect("the page"));
    unchanged::unless_unchanged(name, [page], test);
}

/// Decodes base 64.
fn bytes(text: &str) -> Vec<u8> {
    let value = |letter: u8| match letter {
        b'A'..=b'Z' => u32::from(letter - b'A'),
        b'a'..=b'z' => u32::from(letter - b'a') + 26,
        b'0'..=b'9' => u32::from(letter - b'0') + 52,
        b'+' => 62,
        _ => 63,
    };
    let letters: Vec<u8> = text.bytes().filter(|letter| *letter != b'=').collect();
    let group = |group: &[u8]| {
        let bits = group
            .iter()
            .fold(0, |bits, letter| bits << 6 | value(*letter));
        let bits = bits << (6 * (4 - group.len()));
        bits.to_be_bytes()[1..group.len()].to_vec()
    };
    letters.chunks(4).flat_map(group).collect()
}

/// Keeps a picture of the page. `TAUTRACK_ACCEPT=1` also replaces that of docs/tour.md.
fn keep_picture(browser: &mut Browser, name: &str) {
    let picture = bytes(&browser.picture());
    let file = Path::new(name).with_extension("png");
    fs::write(folder().join(&file), &picture).expect("a file");
    let root = checkout::root().unwrap_or_else(|error| panic!("{error}"));
    let docs = root.join("docs/tour").join(file);
    if docs.exists() && env::var_os("TAUTRACK_ACCEPT").is_some() {
        fs::write(docs, picture).expect("a file");
    }
}

impl Browser {
    /// Arms the robot by the key.
    fn arm(&mut self) {
        self.wait("/ready|armed/.test(tautrack.state.sample.received.guard_state)");
        if self.evaluate("tautrack.state.sample.received.guard_state") == "ready" {
            self.press("Enter");
        }
        self.wait("tautrack.state.sample.received.guard_state === 'armed'");
    }

    /// Chooses a robot and a ground by a part of its name.
    fn choose(&mut self, name: &str) {
        let script = format!(
            "(() => {{ const s = document.getElementById('place'); const o = [...s.options].find(o => o.text.includes({name:?})); \
             s.value = o.value; s.dispatchEvent(new Event('change')); tautrack.state = null; }})()"
        );
        self.evaluate(&script);
        self.wait("tautrack.state");
    }

    /// Saves the run, and repeats it with `cargo demo`.
    fn assert_repeats(&mut self, name: &str) {
        self.evaluate("tautrack.saved = null");
        self.click("[data-tab=save]");
        self.click("#save");
        self.wait("tautrack.saved");
        let saved = self.evaluate("tautrack.saved");
        let text = |key: &str| saved[key].as_str().expect(key).to_owned();
        let scenario = folder().join(name).with_extension("toml");
        fs::write(&scenario, text("scenario")).expect("a file");
        let out = folder().join(name);
        let path = |path: &Path| path.to_str().expect("text").to_owned();
        demo(&[
            "--nodes",
            "host",
            "--scenario",
            &path(&scenario),
            "--out",
            &path(&out),
        ]);
        let summary = fs::read_to_string(out.join("summary.json")).expect("summary.json");
        let summary: Value = serde_json::from_str(&summary).expect("JSON");
        assert_eq!(summary["state_hash"], text("hash"), "{name}");
    }

    fn assert_no_errors(&mut self) {
        assert_eq!(self.evaluate("tautrack.errors"), json!([]));
        assert!(self.errors.is_empty(), "{:?}", self.errors);
    }
}

#[test]
fn the_page_is_one_small_file_that_loads_nothing() {
    let text = fs::read_to_string(page()).expect("the page");
    assert!(text.len() <= LARGEST, "{} bytes", text.len());
    for foreign in ["src=\"", "http://", "https://", "import("] {
        assert!(!text.contains(foreign), "{foreign}");
    }
    assert!(!text.contains("{{"), "a part is missing");
}

#[test]
fn a_visitor_is_refused_at_the_stairs_stops_breaks_and_saves() {
    unless_unchanged("visit", || {
        let mut browser = open("visit");
        browser.evaluate("document.getElementById('speed').value = 2; tautrack.speed = 2; 0");
        browser.arm();
        // The front up, and on to the stairs.
        browser.key(true, "KeyE");
        browser.wait("tautrack.command.chassis_deg >= 45");
        browser.key(false, "KeyE");
        browser.key(true, "KeyW");
        browser.wait("tautrack.state.sample.received.odometry > 0.2");
        keep_picture(&mut browser, "drive");
        browser.wait("/refuse/.test(document.getElementById('verdict').innerText)");
        let reason = browser.evaluate("document.getElementById('reason').innerText");
        let reason = reason.as_str().expect("a text");
        assert!(reason.contains("rear edge"), "{reason}");
        keep_picture(&mut browser, "refused");
        browser.wait("tautrack.state.sample.time_s > 25");
        browser.key(false, "KeyW");
        assert_eq!(
            browser.evaluate("tautrack.state.sample.truth.toppled"),
            false
        );
        browser.assert_repeats("refused");

        let verdict = "tautrack.state.sample.received.verdict";
        browser.press("Escape");
        browser.wait(&format!("{verdict} === 'refused: emergency stop'"));
        keep_picture(&mut browser, "stopped");
        browser.press("KeyR");
        browser.press("Enter");
        browser.wait(&format!("{verdict} !== 'refused: emergency stop'"));
        browser.press("Digit0");
        browser.wait("tautrack.state && tautrack.state.sample.time_s < 1");
        browser.arm();
        browser.click("[data-tab=break]");
        browser.click("[data-node=left_track] button");
        browser.wait("tautrack.state.sample.received.guard_state === 'held'");
        let log = browser.evaluate("document.getElementById('log').textContent");
        assert!(
            log.as_str().is_some_and(|log| log.contains("node lost")),
            "{log}"
        );
        keep_picture(&mut browser, "broken");
        browser.assert_repeats("broken");
        browser.assert_no_errors();
    });
}

#[test]
fn the_panel_reads_writes_saves_and_finds_a_setting_after_a_restart() {
    unless_unchanged("panel", || {
        let mut browser = open("panel");
        browser.wait("tautrack.state.sample.received.guard_state === 'ready'");
        browser.click("[data-tab=panel]");
        browser.wait("document.querySelector('#panel-nodes tr[data-id=\"2\"]')");
        browser.click("#panel-nodes tr[data-id=\"2\"] button");
        browser.evaluate(
            "document.querySelectorAll('#tab-panel details').forEach(d => d.open = true)",
        );
        let input = "document.querySelector('[data-name=velocity_limit]')";
        browser.click("#panel-read");
        browser.wait(input);
        let before = browser.evaluate(&format!("Number({input}.value)"));
        let wanted = before.as_i64().expect("a number") - 1_000;
        browser.evaluate(&format!(
            "(() => {{ const i = {input}; i.value = {wanted}; i.dispatchEvent(new Event('change')); }})()"
        ));
        let message = "document.getElementById('panel-message').innerText";
        browser.wait(&format!("{message}.includes('velocity_limit is {wanted}')"));
        browser.click("#panel-save");
        browser.wait(&format!("{message}.includes('flash memory')"));
        browser.click("#panel-restart");
        browser.wait("tautrack.state.sample.time_s > 6");
        browser.click("#panel-read");
        browser.wait(&format!("{message}.includes('settings of node')"));
        assert_eq!(browser.evaluate(&format!("Number({input}.value)")), wanted);
        browser.click("#panel-record");
        browser.wait("tautrack.recorded === 512");
        browser.evaluate("document.getElementById('panel-plot').scrollIntoView()");
        keep_picture(&mut browser, "panel");
        browser.assert_repeats("panel");
        browser.assert_no_errors();
    });
}

/// The bytes of an adapter: a port that answers as one, with a node behind it.
#[test]
fn the_panel_speaks_the_protocol_of_an_adapter() {
    unless_unchanged("adapter", || {
        let mut browser = open("adapter");
        let script = r#"(async () => {
            const sent = [];
            let toPanel;
            const port = {
                open: async ({ baudRate }) => sent.push(`open ${baudRate}`), close: async () => {},
                readable: new ReadableStream({ start: control => { toPanel = text => control.enqueue(new TextEncoder().encode(text)); } }),
                writable: new WritableStream({ write: bytes => {
                    const text = new TextDecoder().decode(bytes);
                    sent.push(text);
                    // The answer comes in two pieces, with a time and a bell between.
                    if (text.startsWith("t602")) { toPanel("\rz\r\x07t58284B18"); toPanel("100102000000ABCD\r"); }
                } }),
            };
            const bus = await tautrack.panel.openAdapter(port);
            toPanel("t7021"); toPanel("05\rt08280");
            const read = await bus.transfer(2, 0x1018, 1);
            await new Promise(done => setTimeout(done, 50));
            const nodes = bus.nodes().map(({ id, state }) => [id, state]);
            await bus.close();
            return { sent, read, nodes };
        })()"#;
        let found = browser.evaluate(script);
        assert_eq!(
            found["sent"],
            json!([
                "open 115200",
                "C\r",
                "S8\r",
                "O\r",
                "t60284018100100000000\r",
                "C\r"
            ])
        );
        // 0x4B: two bytes of data.
        assert_eq!(found["read"], json!([2, 0]));
        assert_eq!(found["nodes"], json!([[2, 5]]));
        browser.assert_no_errors();
    });
}

#[test]
fn every_robot_is_drawn_on_desktop_and_phone_and_fast_enough() {
    unless_unchanged("robots", || {
        let mut browser = open("robots");
        // Times say something on a computer with nothing else to do. Then 600 frames are measured.
        let timed = std::env::var_os("TAUTRACK_SWEEPS").is_some();
        let each = if timed { 150 } else { 10 };
        let mut all = Vec::new();
        for (place, name, least) in [
            ("B2P2: stairs", "b2p2", 3.0),
            ("RT-Mover: step of 10", "rt-mover", 1.0),
            ("Hylos: hillside", "hylos", 1.0),
            ("Crawler: slope of 20", "crawler", 3.0),
        ] {
            browser.choose(place);
            browser.evaluate("tautrack.speed = 4");
            browser.arm();
            browser.evaluate("tautrack.speed = 1; tautrack.frames.length = 0");
            browser.key(true, "KeyW");
            browser.wait(&format!("tautrack.frames.length >= {each}"));
            browser.key(false, "KeyW");
            let frames = browser.evaluate(&format!("tautrack.frames.slice(0, {each})"));
            let frames: Vec<f64> = serde_json::from_value(frames).expect("numbers");
            all.extend(frames);
            let speed = browser.evaluate("tautrack.measure(4)");
            let speed = speed.as_f64().expect("a number");
            println!("{name}: {speed:.1} times real time");
            assert!(!timed || speed >= least, "{name}: {speed} times real time");
            for (size, screen) in [(DESKTOP, "desktop"), (PHONE, "phone")] {
                for (dark, theme) in [(false, "light"), (true, "dark")] {
                    browser.dress(size, dark);
                    browser.evaluate("new Promise(d => setTimeout(d, 400))");
                    keep_picture(&mut browser, &format!("{name}-{screen}-{theme}"));
                }
            }
            browser.dress(DESKTOP, false);
        }
        all.sort_by(f64::total_cmp);
        let of = |part: f64| all[(part * (all.len() - 1) as f64) as usize];
        let [half, most, last] = [0.5, 0.99, 1.0].map(of);
        println!("half of the frames take {half:.1} ms, 99 % {most:.1} ms, all {last:.1} ms");
        // Other programs may interrupt a script.
        assert!(!timed || most <= 8.0, "{most} ms a frame");
        browser.assert_no_errors();
    });
}

#[test]
fn the_comparison_shows_a_robot_that_topples_without_the_guard() {
    unless_unchanged("compare", || {
        let out = folder();
        let root = checkout::root().unwrap_or_else(|error| panic!("{error}"));
        let scenario = root.join("host-tests/scenarios/staircase-front-kept-up.toml");
        let text = |path: &Path| path.to_str().expect("text").to_owned();
        demo(&[
            "--compare",
            "--scenario",
            &text(&scenario),
            "--out",
            &text(&out),
        ]);
        let profile = out.join("compare");
        let _ = fs::remove_dir_all(&profile);
        let mut browser = Browser::start(&profile);
        browser.dress(DESKTOP, false);
        browser.open(&out.join("compare.html"));
        browser.wait("window.tautrack?.frames.length > 3");
        let outcomes = browser.evaluate("tautrack.runs.map(run => run.outcome)");
        assert_eq!(outcomes, json!(["did not topple", "toppled"]));
        browser.evaluate("seek(tautrack.end * 0.9)");
        browser.evaluate("zoomTo(10, tautrack.end)");
        browser.evaluate("new Promise(done => setTimeout(done, 500))");
        keep_picture(&mut browser, "compared");
        browser.assert_no_errors();
    });
}
