//! Installs what building and running the nodes needs: a compiler for their target, for flash
//! images the sources of its library, and QEMU.
//!
//! [`plan`] decides from facts alone what to install; [`machine`] collects the facts and runs the
//! installation; [`checkout`] finds the sources. With `TAUTRACK_NO_SETUP=1` nothing is installed.
//! With `TAUTRACK_TOOLCHAIN=distribution` the Rust of the Linux distribution builds the nodes;
//! without it, that Rust is used only if rustup is absent or cannot fetch the target.

pub mod checkout;
pub mod machine;
pub mod plan;

pub use plan::{Facts, Missing, Rights, Step, Toolchain};

/// Compiler target of all boards: Cortex-M4 with its floating-point unit.
pub const TARGET: &str = "thumbv7em-none-eabihf";
/// Name of the emulator's program.
pub const QEMU: &str = "qemu-system-arm";

/// Makes sure that nodes can be built and run, and returns the toolchain that builds them. Flash
/// images are `built_from_sources`: with their library. Installs what is missing if that is
/// allowed; announces every installation on standard error before it starts.
///
/// # Errors
/// [`Missing`], whose text is one line with the command to type.
pub fn ensure(built_from_sources: bool) -> Result<Toolchain, Missing> {
    let mut facts = machine::facts(built_from_sources);
    loop {
        let (toolchain, steps) = plan::plan(&facts)?;
        let Some(step) = steps.first() else {
            return Ok(toolchain);
        };
        eprintln!("tautrack: {step}");
        let done = machine::perform(*step);
        facts = plan::after(*step, done, &facts, &machine::facts(built_from_sources));
    }
}
