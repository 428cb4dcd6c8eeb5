//! Program of Hylos' guard node: runs the role `guard` on the selected board.
#![cfg_attr(target_os = "none", no_std, no_main)]

use tautrack_firmware::boards::{Board, Selected};
use tautrack_firmware::roles::guard;

#[cfg_attr(target_os = "none", cortex_m_rt::entry)]
fn main() -> ! {
    Selected::run(&guard::HYLOS)
}
