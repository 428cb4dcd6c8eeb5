//! Output to the brake of the simulated motor.

use core::sync::atomic::{AtomicBool, Ordering};

static RELEASED: AtomicBool = AtomicBool::new(false);

/// Releases the brake, or lets it engage.
pub fn set_brake(released: bool) {
    RELEASED.store(released, Ordering::Relaxed);
}

/// Returns whether the brake is released.
pub(super) fn is_released() -> bool {
    RELEASED.load(Ordering::Relaxed)
}
