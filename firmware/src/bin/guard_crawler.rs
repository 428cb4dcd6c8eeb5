//! Program of the crawler's guard node: runs the role `guard` on the selected board.
//! In the simulator it also has the roles of the drives.
#![no_std]
#![no_main]

use tautrack_firmware::roles::{axle, guard};

tautrack_firmware::program!(guard::CRAWLER, axle::ROLE);
