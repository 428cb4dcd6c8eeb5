//! Program of the screw's node: runs the role `screw` on the selected board.
#![no_std]
#![no_main]

tautrack_firmware::program!(screw);
