//! Runs `cargo demo` for tests, and sends signals to it.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdout, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tautrack_host_tests::programs::setup::checkout;

/// Maximum time to wait for anything. It is long, because a computer that builds something else at
/// the same time is slow.
const LIMIT: Duration = Duration::from_mins(5);

/// Returns the demo's command with an empty folder of this name for its results.
pub fn command(name: &str, arguments: &[&str]) -> (Command, PathBuf) {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&out);
    let mut command = Command::new(env!("CARGO_BIN_EXE_demo"));
    command.args(arguments).arg("--out").arg(&out);
    (command, out)
}

/// Path of a shipped scenario.
pub fn scenario(name: &str) -> String {
    let root = checkout::root().unwrap_or_else(|error| panic!("{error}"));
    let path = root.join("host-tests/scenarios").join(name);
    path.with_extension("toml").display().to_string()
}

/// Reads `summary.json` in `folder`.
pub fn summary(folder: &Path) -> serde_json::Value {
    let text = fs::read_to_string(folder.join("summary.json")).expect("summary.json");
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Running demo in its own process group, as if started from a terminal; dropping it ends it.
pub struct Demo {
    child: Child,
    stdout: BufReader<ChildStdout>,
    stderr: ChildStderr,
}

impl Demo {
    /// Starts `command`.
    pub fn start(mut command: Command) -> Self {
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.process_group(0).spawn().expect("the demo starts");
        let stdout = BufReader::new(child.stdout.take().expect("piped"));
        let stderr = child.stderr.take().expect("piped");
        Self {
            child,
            stdout,
            stderr,
        }
    }

    /// Reads until a line of standard output contains `words`; returns this line.
    pub fn line_with(&mut self, words: &str) -> String {
        loop {
            let mut line = String::new();
            let count = self.stdout.read_line(&mut line).expect("text");
            if count == 0 {
                let (status, _, error) = self.end();
                panic!("no line with {words:?}; {status}: {error}");
            }
            if line.contains(words) {
                return line;
            }
        }
    }

    /// Waits until clients can join; returns the address.
    pub fn address(&mut self) -> String {
        let line = self.line_with("CAN clients can join at ");
        let (_, address) = line.split_once(" join at ").expect("an address");
        address.split(';').next().unwrap_or_default().to_owned()
    }

    /// Waits until all nodes run. Their program has this name. Returns the id of the process that
    /// started last.
    #[cfg(target_os = "linux")]
    pub fn last_node(&self, program: &str) -> u32 {
        let began = Instant::now();
        loop {
            let entries = fs::read_dir("/proc").expect("/proc").flatten();
            let nodes = entries
                .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
                .filter(|process| self.is_node(*process, program));
            // After this time all of them have started.
            let settled = began.elapsed() > Duration::from_secs(3);
            if let Some(last) = nodes.max().filter(|_| settled) {
                return last;
            }
            assert!(began.elapsed() < LIMIT, "no node {program}");
            sleep(Duration::from_millis(100));
        }
    }

    #[cfg(target_os = "linux")]
    fn is_node(&self, process: u32, program: &str) -> bool {
        let read = |file| fs::read_to_string(format!("/proc/{process}/{file}")).unwrap_or_default();
        let parent = format!("PPid:\t{}\n", self.child.id());
        read("status").contains(&parent)
            && read("cmdline")
                .trim_end_matches('\0')
                .ends_with(&format!("/{program}"))
    }

    /// Sends a signal to the whole process group, as a terminal does.
    pub fn signal(&self, name: &str) {
        send(name, &format!("-{}", self.child.id()));
    }

    /// Waits for the end; returns the status, the rest of standard output, and standard error.
    pub fn end(&mut self) -> (ExitStatus, String, String) {
        let (mut output, mut error) = (String::new(), String::new());
        self.stdout.read_to_string(&mut output).expect("text");
        self.stderr.read_to_string(&mut error).expect("text");
        (self.child.wait().expect("it ends"), output, error)
    }
}

impl Drop for Demo {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Sends a signal to a process, or to a process group if its number begins with `-`.
pub fn send(signal: &str, process: &str) {
    let status = Command::new("kill")
        .args(["-s", signal, "--", process])
        .status();
    assert!(
        status.expect("kill starts").success(),
        "{signal} to {process}"
    );
}
