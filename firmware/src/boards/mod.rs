//! Boards that a node runs on, and the trait [`Board`] that hides them from the rest of the
//! firmware.
//!
//! A new board is a new folder here with one type that implements [`Board`], a cargo feature that
//! selects it, and a link script in `build.rs` (firmware/README.md, "Add a board"). No other part
//! of the firmware depends on the board.

#[cfg(target_os = "none")]
mod board;
#[cfg(any(not(target_os = "none"), feature = "mps2"))]
mod lockstep;
#[cfg(any(test, target_os = "none"))]
mod operator_switches;
#[cfg(any(test, feature = "esc1", feature = "g474"))]
#[allow(dead_code)] // each board uses a part of it
mod portable;

#[cfg(all(target_os = "none", any(feature = "esc1", feature = "g474")))]
mod stm32g4;

#[cfg(all(target_os = "none", feature = "esc1"))]
pub mod esc1;
#[cfg(all(target_os = "none", feature = "esc1"))]
pub use esc1::Esc1 as Selected;

#[cfg(all(target_os = "none", feature = "g474"))]
pub mod g474;
#[cfg(all(target_os = "none", feature = "g474"))]
pub use g474::G474 as Selected;

#[cfg(all(target_os = "none", feature = "mps2"))]
pub(crate) mod mps2;
#[cfg(all(target_os = "none", feature = "mps2"))]
pub use mps2::Mps2 as Selected;

#[cfg(not(target_os = "none"))]
pub mod host;

#[cfg(all(
    target_os = "none",
    not(any(feature = "mps2", feature = "esc1", feature = "g474"))
))]
compile_error!("choose a board, for instance --features mps2");
#[cfg(any(
    all(feature = "mps2", feature = "esc1"),
    all(feature = "mps2", feature = "g474"),
    all(feature = "esc1", feature = "g474"),
))]
compile_error!("choose one board");

#[cfg(any(test, target_os = "none"))]
pub use operator_switches::OperatorSwitches;

use tautrack::motor::board_limits::Limit;
use tautrack::motor::bridge::Ratings;

#[cfg(target_os = "none")]
pub use board::Board;

/// Bounds and defaults of the board's settings.
#[cfg(target_os = "none")]
pub const LIMITS: &[Limit] = <Selected as Board>::LIMITS;
/// Bounds and defaults of the board's settings.
#[cfg(not(target_os = "none"))]
pub const LIMITS: &[Limit] = &[];

/// Power stage of the board.
#[cfg(target_os = "none")]
pub const POWER_STAGE: Ratings = <Selected as Board>::POWER_STAGE;
/// Power stage of the board.
#[cfg(not(target_os = "none"))]
pub const POWER_STAGE: Ratings = lockstep::POWER_STAGE;

/// Makes a program that runs one role of [`roles`](crate::roles) on the selected board. Further
/// roles are for the simulator, where all nodes of a robot run the same program.
#[cfg(target_os = "none")]
#[macro_export]
macro_rules! program {
    ($($role:ident)::+ $(, $other:ident)*) => {
        #[cortex_m_rt::entry]
        fn main() -> ! {
            static OTHERS: &[&$crate::roles::Role] = &[$(&$crate::roles::$other::ROLE),*];
            let role = &$crate::roles::$($role)::+::ROLE;
            <$crate::boards::Selected as $crate::boards::Board>::run(role, OTHERS)
        }
    };
}
/// Makes a program that does nothing: there is no board.
#[cfg(not(target_os = "none"))]
#[macro_export]
macro_rules! program {
    ($($role:tt)*) => {
        fn main() {}
    };
}
