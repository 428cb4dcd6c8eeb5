//! What is to be done so that nodes can be built and run, decided from facts alone.

use super::{QEMU, TARGET};
use std::fmt;

/// Debian's packages that build the nodes without rustup: compiler, cargo, library sources, linker.
pub const DISTRIBUTION_PACKAGES: [&str; 4] = ["rustc-web", "cargo-web", "rust-web-src", "lld"];

/// Which compiler builds the nodes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Toolchain {
    /// The one in use, which has the target's library.
    Current,
    /// The Linux distribution's, which builds the target's library from its sources.
    Distribution,
}

/// A package manager that knows what is needed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Packages {
    /// Debian and what descends from it.
    Apt,
    /// Fedora and what descends from it.
    Dnf,
}

/// How packages can be installed without asking anybody.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Rights {
    /// Running as root.
    Root,
    /// `sudo` asks for no password.
    Sudo,
}

/// What a machine has and allows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(clippy::struct_excessive_bools)] // facts, independent of each other
pub struct Facts {
    /// The compiler in use has the target's library.
    pub target_library: bool,
    /// rustup is there and has not failed.
    pub rustup: bool,
    /// The distribution's compiler is there with library sources and linker.
    pub distribution_rust: bool,
    /// The user asks for the distribution's compiler.
    pub distribution_wanted: bool,
    /// The emulator is there.
    pub qemu: bool,
    /// The package manager, unless it has failed.
    pub packages: Option<Packages>,
    /// The right to use it.
    pub rights: Option<Rights>,
    /// The user does not forbid installations.
    pub setup_allowed: bool,
}

/// One installation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Step {
    /// `rustup target add`.
    AddTarget,
    /// [`DISTRIBUTION_PACKAGES`].
    InstallDistributionRust(Rights),
    /// The emulator.
    InstallQemu(Packages, Rights),
}

impl Step {
    /// The command lines of this step, to be run in order, each as program and arguments.
    pub fn commands(self) -> Vec<Vec<&'static str>> {
        let apt = |names: &[&'static str]| {
            // Another installation may be going on: wait for it instead of failing.
            let install = [
                "apt-get",
                "-o",
                "DPkg::Lock::Timeout=300",
                "install",
                "-y",
                "--no-install-recommends",
            ];
            vec![vec!["apt-get", "update"], [&install, names].concat()]
        };
        let (commands, rights) = match self {
            Self::AddTarget => return vec![vec!["rustup", "target", "add", TARGET]],
            Self::InstallDistributionRust(rights) => (apt(&DISTRIBUTION_PACKAGES), rights),
            Self::InstallQemu(Packages::Apt, rights) => (apt(&[QEMU]), rights),
            Self::InstallQemu(Packages::Dnf, rights) => {
                (vec![vec!["dnf", "install", "-y", QEMU]], rights)
            }
        };
        match rights {
            Rights::Root => commands,
            Rights::Sudo => commands
                .iter()
                .map(|command| [&["sudo", "-n"], &command[..]].concat())
                .collect(),
        }
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let what = match self {
            Self::AddTarget => "the library of the nodes' target",
            Self::InstallDistributionRust(_) => "the distribution's Rust with its library sources",
            Self::InstallQemu(..) => "the emulator",
        };
        let commands: Vec<String> = self
            .commands()
            .iter()
            .map(|command| command.join(" "))
            .collect();
        write!(f, "installing {what}: {}", commands.join(" && "))
    }
}

/// What is missing and cannot be, or may not be, installed from here.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Missing {
    /// A compiler for the target.
    Target,
    /// The distribution's compiler, which the user asked for.
    DistributionRust,
    /// The emulator.
    Qemu,
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let packages = DISTRIBUTION_PACKAGES.join(" ");
        match self {
            Self::Target => write!(
                f,
                "no compiler for {TARGET}; type: rustup target add {TARGET} \
                 (without rustup, on Debian: sudo apt-get install {packages})"
            ),
            Self::DistributionRust => write!(
                f,
                "TAUTRACK_TOOLCHAIN=distribution, but the distribution's Rust with its library sources is not there; \
                 type (Debian): sudo apt-get install {packages}"
            ),
            Self::Qemu => write!(
                f,
                "{QEMU} is missing; type: sudo apt-get install {QEMU} (Debian, Ubuntu), \
                 sudo dnf install {QEMU} (Fedora) or brew install qemu (macOS)"
            ),
        }
    }
}

impl std::error::Error for Missing {}

/// Which compiler builds the nodes, and what has to be installed before.
///
/// # Errors
/// [`Missing`] when it takes an installation that is forbidden or impossible.
pub fn plan(facts: &Facts) -> Result<(Toolchain, Vec<Step>), Missing> {
    let rights = facts.rights.filter(|_| facts.setup_allowed);
    let install_rust = rights
        .filter(|_| facts.packages == Some(Packages::Apt))
        .map(Step::InstallDistributionRust);
    let install_qemu = facts
        .packages
        .zip(rights)
        .map(|(packages, rights)| Step::InstallQemu(packages, rights));

    let (toolchain, rust_step) = if facts.distribution_wanted {
        let step = needed(
            facts.distribution_rust,
            install_rust,
            Missing::DistributionRust,
        )?;
        (Toolchain::Distribution, step)
    } else if facts.target_library {
        (Toolchain::Current, None)
    } else if facts.rustup && facts.setup_allowed {
        (Toolchain::Current, Some(Step::AddTarget))
    } else {
        let step = needed(facts.distribution_rust, install_rust, Missing::Target)?;
        (Toolchain::Distribution, step)
    };
    let qemu_step = needed(facts.qemu, install_qemu, Missing::Qemu)?;
    Ok((toolchain, rust_step.into_iter().chain(qemu_step).collect()))
}

/// Nothing for what is there, its installation for what is not.
fn needed(there: bool, install: Option<Step>, missing: Missing) -> Result<Option<Step>, Missing> {
    if there {
        return Ok(None);
    }
    install.map(Some).ok_or(missing)
}

/// The facts to go on with after `step`, of which `done` says whether its commands succeeded: those `found` now, but
/// a means that did not help, or had failed before, is not tried again.
pub fn after(step: Step, done: bool, before: &Facts, found: &Facts) -> Facts {
    let helped = done
        && match step {
            Step::AddTarget => found.target_library,
            Step::InstallDistributionRust(_) => found.distribution_rust,
            Step::InstallQemu(..) => found.qemu,
        };
    let rustup_step = step == Step::AddTarget;
    Facts {
        rustup: before.rustup && (helped || !rustup_step),
        packages: before.packages.filter(|_| helped || rustup_step),
        ..*found
    }
}
