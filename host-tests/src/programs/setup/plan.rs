//! Decides from given facts what to install so that nodes can be built and run.

use super::{QEMU, TARGET};
use std::fmt;

/// Debian's packages that build the nodes without rustup: compiler, cargo, library sources, linker.
pub const DISTRIBUTION_PACKAGES: [&str; 4] = ["rustc-web", "cargo-web", "rust-web-src", "lld"];

/// Toolchain that builds the nodes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Toolchain {
    /// The toolchain in use, which has the target's library.
    Current,
    /// The Linux distribution's toolchain, which builds the target's library from its sources.
    Distribution,
}

/// Package manager that provides the needed packages.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Packages {
    /// apt-get of Debian and its derivatives.
    Apt,
    /// dnf of Fedora and its derivatives.
    Dnf,
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
    /// The compiler in use has the target's library.
    pub target_library: bool,
    /// The compiler in use has the sources of the library.
    pub library_sources: bool,
    /// The build compiles the library, as that of every flash image does.
    pub sources_needed: bool,
    /// rustup is installed and has not failed.
    pub rustup: bool,
    /// The distribution's compiler is installed with library sources and linker.
    pub distribution_rust: bool,
    /// The user requests the distribution's compiler.
    pub distribution_wanted: bool,
    /// The emulator is installed.
    pub qemu: bool,
    /// The package manager, unless it has failed.
    pub packages: Option<Packages>,
    /// The right to use the package manager, if there is one.
    pub rights: Option<Rights>,
    /// The user has not forbidden installations.
    pub setup_allowed: bool,
}

/// One installation step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Step {
    /// Adds the target's library with `rustup target add`.
    AddTarget,
    /// Adds the sources of the library with `rustup component add`.
    AddSources,
    /// Installs [`DISTRIBUTION_PACKAGES`].
    InstallDistributionRust(Rights),
    /// Installs the emulator.
    InstallQemu(Packages, Rights),
}

impl Step {
    /// The command lines of this step, to be run in order, each as program and arguments.
    pub fn commands(self) -> Vec<Vec<&'static str>> {
        let apt = |names: &[&'static str]| {
            // If another installation is running, wait for it instead of failing.
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
            Self::AddSources => return vec![vec!["rustup", "component", "add", "rust-src"]],
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
            Self::AddSources => "the sources of Rust's library, which flash images are built from",
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

/// Error: a part that is missing and that cannot, or must not, be installed automatically.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Missing {
    /// A compiler for the target is missing.
    Target,
    /// The sources of the library are missing.
    Sources,
    /// The distribution's compiler is missing, and the user requested it.
    DistributionRust,
    /// The emulator is missing.
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
            Self::Sources => write!(
                f,
                "no sources of Rust's library, which flash images are built from; type: \
                 rustup component add rust-src \
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

/// Decides which toolchain builds the nodes, and which steps install what is missing.
///
/// # Errors
/// [`Missing`] if a needed installation is forbidden or impossible.
pub fn plan(facts: &Facts) -> Result<(Toolchain, Vec<Step>), Missing> {
    let rights = facts.rights.filter(|_| facts.setup_allowed);
    let install_rust = rights
        .filter(|_| facts.packages == Some(Packages::Apt))
        .map(Step::InstallDistributionRust);
    let install_qemu = facts
        .packages
        .zip(rights)
        .map(|(packages, rights)| Step::InstallQemu(packages, rights));

    let add_target = (!facts.target_library).then_some(Step::AddTarget);
    let lacks_sources = facts.sources_needed && !facts.library_sources;
    let add_sources = lacks_sources.then_some(Step::AddSources);
    let rustup_steps: Vec<_> = add_target.into_iter().chain(add_sources).collect();

    let (toolchain, mut steps) = if facts.distribution_wanted {
        let step = needed(
            facts.distribution_rust,
            install_rust,
            Missing::DistributionRust,
        )?;
        (Toolchain::Distribution, Vec::from_iter(step))
    } else if rustup_steps.is_empty() || facts.rustup && facts.setup_allowed {
        (Toolchain::Current, rustup_steps)
    } else {
        let missing = match rustup_steps[0] {
            Step::AddSources => Missing::Sources,
            _ => Missing::Target,
        };
        let step = needed(facts.distribution_rust, install_rust, missing)?;
        (Toolchain::Distribution, Vec::from_iter(step))
    };
    steps.extend(needed(facts.qemu, install_qemu, Missing::Qemu)?);
    Ok((toolchain, steps))
}

/// Returns no step if the part is there, else the step that installs it. The error is `missing` if
/// there is no such step.
fn needed(there: bool, install: Option<Step>, missing: Missing) -> Result<Option<Step>, Missing> {
    if there {
        return Ok(None);
    }
    install.map(Some).ok_or(missing)
}

/// Updates the facts after `step`; `done` says whether its commands succeeded. The result is the
/// facts `found` now, except that a method (rustup or package manager) which did not help, or had
/// failed before, is not tried again.
pub fn after(step: Step, done: bool, before: &Facts, found: &Facts) -> Facts {
    let helped = done
        && match step {
            Step::AddTarget => found.target_library,
            Step::AddSources => found.library_sources,
            Step::InstallDistributionRust(_) => found.distribution_rust,
            Step::InstallQemu(..) => found.qemu,
        };
    let rustup_step = matches!(step, Step::AddTarget | Step::AddSources);
    Facts {
        rustup: before.rustup && (helped || !rustup_step),
        packages: before.packages.filter(|_| helped || rustup_step),
        ..*found
    }
}
