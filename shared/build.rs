//! Generates the code of the object dictionary of each role.

#[path = "dictionary/code.rs"]
mod code;
#[path = "dictionary/load.rs"]
#[allow(dead_code)] // other generators use the rest
mod dictionary;

use std::error::Error;
use std::path::Path;
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=dictionary");
    let out = env::var("OUT_DIR")?;
    let [axle, screw, guard] =
        dictionary::ROLES.map(|role| dictionary::load(Path::new("dictionary"), role));
    let (axle, screw, guard) = (axle?, screw?, guard?);
    // A screw is an axle with more objects.
    for (dictionary, first) in [(&axle, &axle), (&screw, &axle), (&guard, &guard)] {
        let code = code::generate(dictionary, first)?;
        fs::write(
            Path::new(&out).join(format!("{}.rs", dictionary.role)),
            code,
        )?;
    }
    let payloads = code::payloads(&[&axle, &screw, &guard])?;
    fs::write(Path::new(&out).join("payloads.rs"), payloads)?;
    Ok(())
}
