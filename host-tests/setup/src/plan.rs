//! Decides from given facts what to install so that a command has all that it needs.

use super::{BROWSER, PAGE_TARGET, PROBE_RS, QEMU, TARGET};
use std::fmt;

/// Command that installs rustup, as its makers publish it.
pub const RUSTUP: &str = "curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh";

/// Part of a computer's set-up that a command can need.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Part {
    /// Library of the boards' target, [`TARGET`].
    Target,
    /// Library of the target of the page on the web, [`PAGE_TARGET`].
    PageTarget,
    /// Sources of Rust's library, which flash images compile with themselves.
    Sources,
    /// The emulator.
    Qemu,
    /// The browser in which tests open the page.
    Browser,
    /// The program that talks to a debug probe. It is never installed automatically, because it
    /// compiles for minutes.
    ProbeRs,
}

impl Part {
    /// Arguments with which rustup adds the part; `None` if rustup does not have it.
    fn of_rustup(self) -> Option<[&'static str; 3]> {
        match self {
            Self::Target => Some(["target", "add", TARGET]),
            Self::PageTarget => Some(["target", "add", PAGE_TARGET]),
            Self::Sources => Some(["component", "add", "rust-src"]),
            Self::Qemu | Self::Browser | Self::ProbeRs => None,
        }
    }

    /// Debian package with the part; `None` if there is none.
    fn package(self) -> Option<&'static str> {
        match self {
            Self::Qemu => Some(QEMU),
            Self::Browser => Some(BROWSER),
            _ => None,
        }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Target => "the library of the nodes' target",
            Self::PageTarget => "the library of the page's target",
            Self::Sources => "the sources of Rust's library, which flash images are built from",
            Self::Qemu => "the emulator",
            Self::Browser => "the browser of the tests",
            Self::ProbeRs => PROBE_RS,
        })
    }
}

/// Right to install packages without a password.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Rights {
    /// The process runs as root.
    Root,
    /// `sudo` asks for no password.
    Sudo,
}

/// Facts about a computer and the user's choices.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(clippy::struct_excessive_bools)] // independent facts
pub struct Facts {
    /// The compiler in use has the library of the boards' target.
    pub target_library: bool,
    /// The compiler in use has the library of the page's target.
    pub page_library: bool,
    /// The compiler in use has the sources of the library.
    pub library_sources: bool,
    /// rustup is installed and has not failed.
    pub rustup: bool,
    /// The emulator is installed.
    pub qemu: bool,
    /// Chromium is installed.
    pub browser: bool,
    /// probe-rs is installed.
    pub probe_rs: bool,
    /// apt-get of Debian and its derivatives is installed and has not failed.
    pub apt: bool,
    /// The right to use apt-get, if there is one.
    pub rights: Option<Rights>,
    /// The user has not forbidden installations.
    pub setup_allowed: bool,
}

impl Facts {
    /// Whether the computer has the part.
    fn has(self, part: Part) -> bool {
        match part {
            Part::Target => self.target_library,
            Part::PageTarget => self.page_library,
            Part::Sources => self.library_sources,
            Part::Qemu => self.qemu,
            Part::Browser => self.browser,
            Part::ProbeRs => self.probe_rs,
        }
    }

    /// The step that installs the part; `None` if that is forbidden or impossible.
    fn step(self, part: Part) -> Option<Step> {
        if !self.setup_allowed {
            return None;
        }
        if self.rustup && part.of_rustup().is_some() {
            return Some(Step::Rustup(part));
        }
        let rights = self
            .rights
            .filter(|_| self.apt && part.package().is_some())?;
        Some(Step::Package(part, rights))
    }
}

/// One installation step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Step {
    /// Adds a part with rustup.
    Rustup(Part),
    /// Installs a part with apt-get.
    Package(Part, Rights),
}

impl Step {
    /// What the step installs.
    fn part(self) -> Part {
        match self {
            Self::Rustup(part) | Self::Package(part, _) => part,
        }
    }

    /// The command lines of this step, to be run in order, each as program and arguments.
    pub fn commands(self) -> Vec<Vec<&'static str>> {
        let sudo: &[_] = match self {
            Self::Rustup(part) => {
                let arguments = part.of_rustup().into_iter().flatten();
                return vec![["rustup"].into_iter().chain(arguments).collect()];
            }
            Self::Package(_, Rights::Sudo) => &["sudo", "-n"],
            Self::Package(_, Rights::Root) => &[],
        };
        let update: &[_] = &["apt-get", "update"];
        // If another installation is running, wait for it instead of failing.
        let install: &[_] = &[
            "apt-get",
            "-o",
            "DPkg::Lock::Timeout=300",
            "install",
            "-y",
            "--no-install-recommends",
        ];
        let package: Vec<_> = self.part().package().into_iter().collect();
        vec![[sudo, update].concat(), [sudo, install, &package].concat()]
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let commands: Vec<String> = self
            .commands()
            .iter()
            .map(|command| command.join(" "))
            .collect();
        write!(f, "installing {}: {}", self.part(), commands.join(" && "))
    }
}

/// Error: a part that is missing and that cannot, or must not, be installed automatically.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Missing(pub Part);

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.0 {
            Part::Target | Part::PageTarget | Part::Sources => {
                let arguments = self.0.of_rustup().into_iter().flatten();
                let arguments: Vec<&str> = arguments.collect();
                write!(
                    f,
                    "{} is missing; type: rustup {} (if there is no rustup, before that: {RUSTUP})",
                    self.0,
                    arguments.join(" ")
                )
            }
            Part::Browser => write!(
                f,
                "{BROWSER} is missing; type: sudo apt-get install {BROWSER} (Debian, Ubuntu)"
            ),
            Part::Qemu => write!(
                f,
                "{QEMU} is missing; type: sudo apt-get install {QEMU} (Debian, Ubuntu), \
                 sudo dnf install {QEMU} (Fedora) or brew install qemu (macOS)"
            ),
            Part::ProbeRs => write!(
                f,
                "{PROBE_RS} is not installed; type: cargo install probe-rs-tools --locked"
            ),
        }
    }
}

impl std::error::Error for Missing {}

/// Decides which steps install what is missing of `needs`.
///
/// # Errors
/// [`Missing`] if a needed installation is forbidden or impossible.
pub fn plan(needs: &[Part], facts: &Facts) -> Result<Vec<Step>, Missing> {
    let missing = needs.iter().copied().filter(|part| !facts.has(*part));
    missing
        .map(|part| facts.step(part).ok_or(Missing(part)))
        .collect()
}

/// Updates the facts after `step`; `done` says whether its commands succeeded. The result is the
/// facts `found` now, except that a method (rustup or apt-get) which did not help, or had
/// failed before, is not tried again.
pub fn after(step: Step, done: bool, before: &Facts, found: &Facts) -> Facts {
    let helped = done && found.has(step.part());
    let rustup_step = matches!(step, Step::Rustup(_));
    Facts {
        rustup: before.rustup && (helped || !rustup_step),
        apt: before.apt && (helped || rustup_step),
        ..*found
    }
}
