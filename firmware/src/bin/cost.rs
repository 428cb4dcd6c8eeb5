//! Counts the instructions of every kernel and tick: not a node, see [`tautrack_firmware::cost`].
#![no_std]
#![no_main]

#[cortex_m_rt::entry]
fn main() -> ! {
    tautrack_firmware::cost::run()
}
