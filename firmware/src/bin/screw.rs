//! Program of the screw's node: runs the role `screw` on the selected board.
#![cfg_attr(target_os = "none", no_std, no_main)]

use tautrack_firmware::boards::{Board, Selected};
use tautrack_firmware::roles::screw;

#[cfg_attr(target_os = "none", cortex_m_rt::entry)]
fn main() -> ! {
    Selected::run(&screw::ROLE)
}
