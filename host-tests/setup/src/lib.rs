//! Makes sure of what a command of `.cargo/config.toml` needs before anything is compiled, and
//! starts the command.
//!
//! [`commands`] is the table of the commands and of what they need. [`plan`] decides from facts
//! alone what to install; [`machine`] collects the facts and runs the installation; [`checkout`]
//! finds the sources. The simulator uses this crate when it builds nodes, as tests do without a
//! command.
//!
//! With `TAUTRACK_NO_SETUP=1` nothing is installed.

pub mod build;
pub mod checkout;
pub mod commands;
pub mod machine;
pub mod plan;

pub use plan::{Facts, Missing, Part, Rights, Step};

/// Compiler target of all boards: Cortex-M4 with its floating-point unit.
pub const TARGET: &str = "thumbv7em-none-eabihf";
/// Compiler target of the module in the page on the web.
pub const PAGE_TARGET: &str = "wasm32-unknown-unknown";
/// Name of the emulator's program.
pub const QEMU: &str = "qemu-system-arm";
/// Name of the browser, which the tests of the page use.
pub const BROWSER: &str = "chromium";
/// Name of the program that talks to a debug probe.
pub const PROBE_RS: &str = "probe-rs";

/// Makes sure that this computer has all parts in `needs`. Installs what is missing if that is
/// allowed; announces every installation on standard error before it starts.
///
/// # Errors
/// [`Missing`], whose text is one line with the command to type.
pub fn ensure(needs: &[Part]) -> Result<(), Missing> {
    if needs.is_empty() {
        return Ok(());
    }
    let mut facts = machine::facts();
    loop {
        let steps = plan::plan(needs, &facts)?;
        let Some(step) = steps.first() else {
            return Ok(());
        };
        eprintln!("tautrack: {step}");
        let done = machine::perform(*step);
        facts = plan::after(*step, done, &facts, &machine::facts());
    }
}
