//! Program of B2P2's guard node: runs the role `guard` on the selected board.
//! In the simulator it also has the roles of the drives.
#![cfg_attr(target_os = "none", no_std, no_main)]

tautrack_firmware::program!(guard::b2p2, axle, screw);
