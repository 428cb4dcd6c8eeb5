//! Sets up what building and running the nodes takes: a compiler for their target, and QEMU.
//!
//! [`plan`] decides from facts alone what is to be done; [`machine`] finds the facts and does it;
//! [`checkout`] finds the sources. With
//! `TAUTRACK_NO_SETUP=1` nothing is installed; `TAUTRACK_TOOLCHAIN=distribution` builds the nodes with the Rust of the
//! Linux distribution, which is otherwise the way when rustup is absent or cannot fetch the target.

pub mod checkout;
pub mod machine;
pub mod plan;

pub use plan::{Facts, Missing, Rights, Step, Toolchain};

/// The target of all boards: Cortex-M4 with its floating-point unit.
pub const TARGET: &str = "thumbv7em-none-eabihf";
/// The emulator's program.
pub const QEMU: &str = "qemu-system-arm";

/// Makes sure that nodes can be built and run, installs what is missing where that is allowed, and says which compiler
/// builds them. Every installation is announced on standard error before it begins.
///
/// # Errors
/// [`Missing`], whose text is one line that says what to type.
pub fn ensure() -> Result<Toolchain, Missing> {
    let mut facts = machine::facts();
    loop {
        let (toolchain, steps) = plan::plan(&facts)?;
        let Some(step) = steps.first() else {
            return Ok(toolchain);
        };
        eprintln!("tautrack: {step}");
        let done = machine::perform(*step);
        facts = plan::after(*step, done, &facts, &machine::facts());
    }
}
