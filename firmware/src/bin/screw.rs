//! Program of the screw's node: runs the role `screw` on the selected board.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_main)]

use tautrack_firmware::roles::screw;

tautrack_firmware::program!(screw::ROLE);
