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
/// Window of a test while nobody looks: without a graphics card, drawing takes most of the time.
const SMALL: [u32; 2] = [860, 240];

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

/// Opens a file in a browser of its own, whose profile has this name.
fn browse(name: &str, file: &Path) -> Browser {
    let profile = folder().join("profiles").join(name);
    let _ = fs::remove_dir_all(&profile);
    let mut browser = Browser::start(&profile);
    browser.dress(DESKTOP, false);
    browser.open(file);
    browser
}

/// Opens the page in a browser of its own.
fn open(name: &str) -> Browser {
    let mut browser = browse(name, page());
    browser.wait("window.tautrack?.state && document.getElementById('loading').hidden");
    browser.dress(SMALL, false);
    browser
}

/// A scenario file of the project.
fn scenario(name: &str) -> PathBuf {
    let root = checkout::root().unwrap_or_else(|error| panic!("{error}"));
    root.join("host-tests/scenarios").join(name)
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

/// Keeps a picture of a small window as a desktop shows it.
fn keep_desktop(browser: &mut Browser, name: &str) {
    browser.dress(DESKTOP, false);
    browser.evaluate("new Promise(done => setTimeout(done, 400))");
    keep_picture(browser, name);
    browser.dress(SMALL, false);
}

impl Browser {
    /// Arms the robot by the key.
    fn arm(&mut self) {
        self.wait("/ready|armed/.test(tautrack.state.sample.received.guard_state)");
        // The page itself arms a robot that would fall.
        let ready = "tautrack.state.sample.received.guard_state === 'ready' \
                     && !['rt-mover', 'hylos'].includes(tautrack.still.robot)";
        if self.evaluate(ready) == true {
            self.press("Enter");
        }
        self.wait("tautrack.state.sample.received.guard_state === 'armed'");
    }

    /// Does what starts a run, and waits for its first state.
    fn restart(&mut self, act: impl FnOnce(&mut Self)) {
        self.evaluate("window.earlier = tautrack.still; 0");
        act(self);
        self.wait("tautrack.still !== earlier");
    }

    /// Chooses a robot and a ground by a part of its name.
    fn choose(&mut self, name: &str) {
        let script = format!(
            "(() => {{ const s = document.getElementById('place'); const o = [...s.options].find(o => o.text.includes({name:?})); \
             s.value = o.value; s.dispatchEvent(new Event('change')); }})()"
        );
        self.restart(|browser| drop(browser.evaluate(&script)));
    }

    /// Enters a declared payload of some mass, kg, at a place, m.
    fn enter_load(&mut self, mass: f64, [x, y, z]: [f64; 3]) {
        self.click("[data-tab=setup]");
        self.evaluate(&format!(
            "(() => {{ const form = document.getElementById('changes').elements; form.declared.checked = true; \
             form.mass.value = {mass}; form.x.value = {x}; form.y.value = {y}; form.z.value = {z}; }})()"
        ));
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
        browser.wait("/refuse/.test(document.getElementById('verdict').innerText)");
        let reason = browser.evaluate("document.getElementById('reason').innerText");
        let reason = reason.as_str().expect("a text");
        assert!(reason.contains("rear edge"), "{reason}");
        keep_desktop(&mut browser, "refused");
        browser.wait("tautrack.state.sample.time_s > 25");
        // A stop holds while the key is.
        browser.click("#stop");
        browser.wait("tautrack.state.sample.time_s > 27");
        let now = "[tautrack.command.speed_mps, tautrack.state.requested]";
        assert_eq!(browser.evaluate(now), json!([0, "stop"]));
        browser.key(false, "KeyW");
        assert_eq!(
            browser.evaluate("tautrack.state.sample.truth.toppled"),
            false
        );
        browser.assert_repeats("refused");

        let verdict = "tautrack.state.sample.received.verdict";
        browser.press("Escape");
        browser.wait(&format!("{verdict} === 'refused: emergency stop'"));
        keep_desktop(&mut browser, "stopped");
        browser.press("KeyR");
        browser.wait("tautrack.state.requested === 'reset'");
        browser.wait("document.getElementById('state').textContent.includes('Arm to drive on')");
        let pressed = "document.getElementById('arm').getAttribute('aria-pressed')";
        assert_eq!(browser.evaluate(pressed), "false");
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
        browser.wait("document.getElementById('state').textContent.includes('node lost')");
        keep_desktop(&mut browser, "broken");
        browser.assert_repeats("broken");
        // A new run takes no input that was meant for the one before.
        browser.evaluate(
            "(async () => { const started = tautrack.start(tautrack.text); \
             tautrack.act({ break: { node_dead: 'left_track' } }); await started; })()",
        );
        browser.wait("tautrack.state.sample.time_s > 0.5");
        assert_eq!(browser.evaluate("tautrack.state.faults"), json!([]));
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
        keep_desktop(&mut browser, "panel");
        browser.assert_repeats("panel");
        // A new run ends what was under way, and is listened to.
        browser.click("[data-tab=panel]");
        browser.click("#panel-read");
        browser.press("Digit0");
        browser.wait(&format!("{message}.includes('restarted')"));
        browser.wait("document.querySelector('#panel-nodes tr[data-id=\"2\"]')");
        browser.assert_no_errors();
    });
}

#[test]
fn b2p2_climbs_the_stairs_by_itself() {
    unless_unchanged("climb", || {
        let mut browser = open("climb");
        browser.choose("B2P2: stairs");
        browser.evaluate("tautrack.speed = 4");
        browser.arm();
        // The visitor holds one key; nobody commands the chassis angle.
        browser.click("#autonomous");
        browser.key(true, "KeyW");
        browser.wait("tautrack.state.sample.truth.pitch > 0.3");
        assert!(
            browser
                .evaluate("document.getElementById('figures').innerText")
                .as_str()
                .is_some_and(|figures| figures.contains("By itself")),
        );
        keep_desktop(&mut browser, "climb");
        browser.wait("tautrack.state.sample.received.clearance === 'approach' && tautrack.state.sample.truth.cog[2] > 0.75");
        browser.key(false, "KeyW");
        let truth = browser.evaluate("tautrack.state.sample.truth");
        assert_eq!(truth["toppled"], false, "{truth}");
        assert_eq!(browser.evaluate("tautrack.command.chassis_deg"), 0);
        browser.assert_repeats("climbed");
        browser.assert_no_errors();
    });
}

#[test]
fn a_gamepad_drives_the_robot() {
    unless_unchanged("gamepad", || {
        let mut browser = open("gamepad");
        browser.evaluate(
            "window.pad = { index: 1, axes: [0, 0, 0, 0], buttons: Array.from({ length: 16 }, () => ({ pressed: false })) }; \
             Object.defineProperty(navigator, 'getGamepads', { value: () => [null, window.pad] }); 0",
        );
        // A button is held until it has its effect.
        let press = |browser: &mut Browser, button: usize, effect: &str| {
            browser.evaluate(&format!("pad.buttons[{button}].pressed = true"));
            browser.wait(effect);
            browser.evaluate(&format!("pad.buttons[{button}].pressed = false"));
        };
        let received = "tautrack.state.sample.received";
        browser.wait(&format!("{received}.guard_state === 'ready'"));
        press(
            &mut browser,
            0,
            &format!("{received}.guard_state === 'armed'"),
        );
        browser.evaluate("pad.axes[3] = -1");
        browser.wait("tautrack.command.chassis_deg > 10");
        browser.evaluate("pad.axes = [0, -1, 0, 0]; 0");
        browser.wait("tautrack.state.sample.truth.ground_speed > 0.1");
        // A stop holds until the stick is in its middle.
        press(&mut browser, 1, "tautrack.state.requested === 'stop'");
        browser.evaluate("window.stopped = tautrack.state.sample.time_s");
        browser.wait("tautrack.state.sample.time_s > stopped + 1");
        assert_eq!(browser.evaluate("tautrack.state.requested"), "stop");
        browser.evaluate("pad.axes[1] = 0");
        browser.wait("!tautrack.waits");
        browser.evaluate("pad.axes[1] = -1");
        browser.wait(
            "tautrack.state.requested === 'arm' && tautrack.state.sample.truth.ground_speed > 0.1",
        );
        // A stick that rests beside its middle commands nothing.
        browser.evaluate("pad.axes = [0.1, 0.1, 0, 0.1]; 0");
        browser.wait("tautrack.command.speed_mps === 0 && tautrack.command.yaw_rate_deg_s === 0");
        browser.evaluate("pad.axes[0] = 1");
        browser.wait("tautrack.state.sample.truth.yaw < -0.05");
        let stopped = format!("{received}.verdict === 'refused: emergency stop'");
        press(&mut browser, 8, &stopped);
        browser.assert_no_errors();
    });
}

#[test]
fn a_visitor_loads_the_robot_and_drops_a_scenario_file() {
    unless_unchanged("load", || {
        let mut browser = open("load");
        browser.enter_load(1.5, [0.2, -0.05, 0.12]);
        keep_desktop(&mut browser, "load");
        browser.restart(|browser| browser.click("#changes button"));
        let payload = browser.evaluate("tautrack.still.description.robot.b2p2.payload");
        assert_eq!(payload["mass_kg"], 1.5, "{payload}");
        assert_eq!(payload["place_m"], json!([0.2, -0.05, 0.12]), "{payload}");
        assert_eq!(payload["declared"], true, "{payload}");
        browser.wait("tautrack.state.sample.time_s > 0.5 && !tautrack.busy");
        browser.assert_repeats("loaded");

        let drop = |browser: &mut Browser, name: &str, text: &str| {
            browser.evaluate(&format!(
                "(() => {{ const data = new DataTransfer(); data.items.add(new File([{}], {name:?})); \
                 document.body.dispatchEvent(new DragEvent('drop', {{ dataTransfer: data, bubbles: true, cancelable: true }})); }})()",
                Value::from(text)
            ));
        };
        let file = scenario("hylos/hazards/quick-turn-uphill.toml");
        let text = fs::read_to_string(file).expect("a scenario");
        drop(&mut browser, "mine.toml", &text);
        browser.wait("tautrack.still.robot === 'hylos'");
        let chosen = "document.getElementById('place').selectedOptions[0].text";
        browser.wait(&format!("{chosen} === 'mine.toml'"));
        // A file with a mistake is refused with its place, and the run goes on.
        drop(
            &mut browser,
            "wrong.toml",
            &text.replace("friction", "fiction"),
        );
        let refused = "document.getElementById('refused').innerText";
        browser.wait(&format!("{refused}.includes('fiction')"));
        let time = browser.evaluate("tautrack.state.sample.time_s");
        browser.wait(&format!("tautrack.state.sample.time_s > {time}"));
        assert_eq!(browser.evaluate(chosen), "mine.toml");
        browser.assert_no_errors();
    });
}

#[test]
fn a_refusal_to_arm_is_named_and_only_one_off_level_can_be_confirmed() {
    unless_unchanged("refusal", || {
        let mut browser = open("refusal");
        let received = "tautrack.state.sample.received";
        let state = "document.getElementById('state').innerText";
        let ready = format!("{received}.guard_state === 'ready'");
        // A screw that restarts on the stairs is to be homed there.
        browser.evaluate("tautrack.speed = 4");
        browser.arm();
        browser.click("#autonomous");
        browser.key(true, "KeyW");
        browser.wait("tautrack.state.sample.truth.pitch > 0.25");
        browser.key(false, "KeyW");
        browser.click("[data-tab=break]");
        for node in ["screw", "guard"] {
            browser.click(&format!(
                "#nodes [data-node={node}] button[data-fault*=restart]"
            ));
        }
        browser.wait(&ready);
        // Whoever presses twice at once confirms nothing.
        browser.press("Enter");
        browser.press("Enter");
        browser.wait(&format!("{state}.includes('not level. Arm again')"));
        browser.evaluate("new Promise(done => setTimeout(done, 400))");
        assert_eq!(browser.evaluate("tautrack.state.requested"), "arm");
        browser.press("Enter");
        browser.wait("tautrack.state.requested === 'arm_off_level'");

        browser.choose("B2P2: stairs");
        browser.enter_load(3.0, [-0.5, 0.0, 0.2]);
        browser.restart(|browser| browser.click("#changes button"));
        browser.wait(&ready);
        for _ in 0..2 {
            browser.press("Enter");
            let words = "starts no drive: drives would be homed with a margin below";
            browser.wait(&format!("{state}.includes('{words}')"));
            browser.evaluate("new Promise(done => setTimeout(done, 400))");
        }
        assert_eq!(browser.evaluate("tautrack.state.requested"), "arm");
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
            browser.dress(DESKTOP, false);
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
            browser.dress(SMALL, false);
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
        let scenario = scenario("staircase-front-kept-up.toml");
        let text = |path: &Path| path.to_str().expect("text").to_owned();
        demo(&[
            "--compare",
            "--scenario",
            &text(&scenario),
            "--out",
            &text(&out),
        ]);
        let mut browser = browse("compare", &out.join("compare.html"));
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

#[test]
fn a_report_has_the_scene_and_on_paper_the_side_view() {
    unless_unchanged("report", || {
        let out = folder().join("report");
        let text = |path: &Path| path.to_str().expect("text").to_owned();
        let scenario = text(&scenario("staircase.toml"));
        demo(&[
            "--nodes",
            "host",
            "--scenario",
            &scenario,
            "--out",
            &text(&out),
        ]);
        let mut browser = browse("report", &out.join("report.html"));
        browser.wait("document.querySelector('.is-solid')");
        browser.evaluate("seek(14); 0");
        for (size, screen) in [(DESKTOP, "desktop"), (PHONE, "phone")] {
            for (dark, theme) in [(false, "light"), (true, "dark")] {
                browser.dress(size, dark);
                browser.evaluate("new Promise(done => setTimeout(done, 800))");
                keep_picture(&mut browser, &format!("report-{screen}-{theme}"));
            }
        }
        browser.dress(DESKTOP, false);
        // Every plot shows the same part of the run, without a curve that is switched off.
        let plots = "[...document.querySelectorAll('#plots figure')].map(figure => [figure.querySelectorAll('path').length, [...figure.querySelectorAll('text')].at(-1).textContent])";
        let whole = browser.evaluate(plots);
        browser.evaluate("zoom(10, 14); document.querySelector('#plots .key input').click()");
        let part = browser.evaluate(plots);
        let count = |plots: &Value, at: usize| plots[at][0].as_u64().expect("a number");
        assert_eq!(count(&part, 0) + 1, count(&whole, 0));
        assert_eq!(count(&part, 1), count(&whole, 1));
        let ends: Vec<_> = part
            .as_array()
            .expect("plots")
            .iter()
            .map(|plot| &plot[1])
            .collect();
        assert!(
            ends.iter()
                .all(|end| **end == *ends[0] && **end != whole[0][1]),
            "{part}"
        );
        let height = "document.getElementById('view').clientHeight";
        assert_eq!(browser.evaluate(height), 0);
        browser.call("Emulation.setEmulatedMedia", &json!({ "media": "print" }));
        assert!(browser.evaluate(height).as_u64() > Some(100));
        assert_eq!(
            browser.evaluate("document.getElementById('solid').clientHeight"),
            0
        );
        assert!(browser.errors.is_empty(), "{:?}", browser.errors);
    });
}
