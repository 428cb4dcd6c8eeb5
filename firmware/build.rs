//! Passes the board's linker script to the linker.

use std::env;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    if env::var("CARGO_CFG_TARGET_OS")? != "none" {
        return Ok(());
    }
    let boards = Path::new(&env::var("CARGO_MANIFEST_DIR")?).join("src/boards");
    if env::var_os("CARGO_FEATURE_MPS2").is_some() {
        let script = boards.join("mps2/mps2.x");
        println!("cargo:rerun-if-changed={}", script.display());
        println!("cargo:rustc-link-arg-bins=-T{}", script.display());
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
        println!("cargo:rustc-link-arg-bins=--nmagic");
    }
    if env::var_os("CARGO_FEATURE_ESC1").is_some() {
        let script = boards.join("esc1/loader.x");
        println!("cargo:rerun-if-changed={}", script.display());
        println!("cargo:rerun-if-changed=../memory.x");
        println!("cargo:rustc-link-arg-bin=loader=-T{}", script.display());
        for role in ["axle", "screw"] {
            // The script of the run-time crate includes memory.x of the repository's root.
            println!("cargo:rustc-link-arg-bin={role}=-Tlink.x");
            println!("cargo:rustc-link-arg-bin={role}=-Tdefmt.x");
            // Functions with equal instructions become one.
            println!("cargo:rustc-link-arg-bin={role}=--icf=all");
        }
        println!("cargo:rustc-link-arg-bins=--nmagic");
    }
    if env::var_os("CARGO_FEATURE_G474").is_some() {
        let script = boards.join("g474/g474.x");
        println!("cargo:rerun-if-changed={}", script.display());
        println!("cargo:rustc-link-arg-bins=-T{}", script.display());
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
        println!("cargo:rustc-link-arg-bins=--icf=all");
        println!("cargo:rustc-link-arg-bins=--nmagic");
    }
    Ok(())
}
