//! Program of an axle's node: runs the role `axle` on the selected board.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_main)]

use tautrack_firmware::roles::axle;

tautrack_firmware::program!(axle::ROLE);
