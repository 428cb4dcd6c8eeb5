//! Program of B2P2's guard node: runs the role `guard` on the selected board.
//! In the simulator it also has the roles of the drives.
#![no_std]
#![no_main]

use tautrack_firmware::roles::{axle, guard, screw};

tautrack_firmware::program!(guard::B2P2, axle::ROLE, screw::ROLE);
