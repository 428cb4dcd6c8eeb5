//! Program of an axle's node: runs the role `axle` on the selected board.
#![cfg_attr(target_os = "none", no_std, no_main)]

use tautrack_firmware::boards::{Board, Selected};
use tautrack_firmware::roles::axle;

#[cfg_attr(target_os = "none", cortex_m_rt::entry)]
fn main() -> ! {
    Selected::run(&axle::ROLE)
}
