//! Generates one object dictionary per role, and gives the linker the board's script.

use std::{env, error::Error, fs, path::Path};
use zencan_common::device_config::{DefaultValue, DeviceConfig, Object};
use zencan_common::objects::AccessType;

/// Role, and its device type (0x1000): the device profile in the low half, its kind of device in the high half.
const ROLES: [(&str, u32); 3] = [
    ("axle", 0x0002_0192),  // CiA 402, servo drive
    ("screw", 0x0002_0192), // the same
    ("guard", 0x0002_019A), // CiA 410, two axes of 16 bit
];

fn main() -> Result<(), Box<dyn Error>> {
    let out = env::var("OUT_DIR")?;
    println!("cargo:rerun-if-changed=dictionary");
    for (role, device_type) in ROLES {
        let mut config = DeviceConfig::load(format!("dictionary/{role}.toml"))?;
        for object in &mut config.objects {
            if let Object::Var(var) = &mut object.object {
                // The stack fixes both: it would say "no profile", and never let a client set the heartbeat.
                match object.index {
                    0x1000 => var.default_value = Some(DefaultValue::Integer(device_type.into())),
                    0x1017 => var.access_type = AccessType::Rw.into(),
                    _ => {}
                }
            }
        }
        let code = zencan_build::device_config_to_string(&config, false)?;
        fs::write(Path::new(&out).join(format!("{role}.rs")), code)?;
    }

    if env::var_os("CARGO_FEATURE_MPS2").is_some() && env::var("CARGO_CFG_TARGET_OS")? == "none" {
        let script = Path::new(&env::var("CARGO_MANIFEST_DIR")?).join("src/boards/mps2/mps2.x");
        println!("cargo:rerun-if-changed={}", script.display());
        println!("cargo:rustc-link-arg-bins=-T{}", script.display());
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
        println!("cargo:rustc-link-arg-bins=--nmagic");
    }
    Ok(())
}
