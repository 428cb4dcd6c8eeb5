//! Counts the executed instructions of the control code. It is not a node program, see
//! [`tautrack_firmware::cost`].
#![no_std]
#![no_main]

#[cortex_m_rt::entry]
fn main() -> ! {
    tautrack_firmware::cost::run()
}
