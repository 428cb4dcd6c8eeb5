//! Program of an axle's node: runs the role `axle` on the selected board.
#![no_std]
#![no_main]

tautrack_firmware::program!(axle);
