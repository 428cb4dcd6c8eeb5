//! Reads the object dictionary of a role: the build script makes the node of it, and `host-tests/src/reference` its
//! EDS file and its pages.

use std::path::Path;
use zencan_common::device_config::{DefaultValue, DeviceConfig, LoadError, Object};
use zencan_common::objects::AccessType;

/// Role, and its device type (0x1000): the device profile in the low half, its kind of device in the high half.
pub const ROLES: [(&str, u32); 3] = [
    ("axle", 0x0002_0192),  // CiA 402, servo drive
    ("screw", 0x0002_0192), // the same
    ("guard", 0x0002_019A), // CiA 410, two axes of 16 bit
];

/// The dictionary of `role` in `folder`, with all objects that the stack adds.
///
/// # Errors
/// The stack's own, when the file cannot be read or is no dictionary.
pub fn load(folder: &Path, role: &str, device_type: u32) -> Result<DeviceConfig, LoadError> {
    let mut config = DeviceConfig::load(folder.join(role).with_extension("toml"))?;
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
    Ok(config)
}
