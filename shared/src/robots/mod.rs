//! The robots: their masses, shapes and controllers.
//!
//! [`body`] is the interface that the guard requires of each; every robot has a folder of its own.
//! [`turn`] and [`odometry`] are shared parts.

pub mod b2p2;
pub mod body;
pub mod crawler;
pub mod hylos;
pub mod odometry;
pub mod rt_mover;
pub mod turn;

pub use body::{
    Ahead, Allowed, Autonomy, Body, Command, DriveState, Goal, MAX_DRIVES, MAX_OFFSETS, MAX_STAGES,
    Offset, Phase, PostureCommand, Stop,
};

/// The list of the robots: calls the macro `$make` with the folder, the type and the description of
/// each. Firmware and simulator have a folder with the same name and ask this list, too.
///
/// The first robot is the default one. A new robot goes to the end, because the random operators of
/// `cargo demo --suite operators` depend on a robot's position.
#[macro_export]
macro_rules! every_robot {
    ($make:ident) => {
        $make! {
            b2p2::B2p2: "Tracked, variable geometry (Paillat et al.)",
            crawler::Crawler: "Two tracks on soft ground (Kurc and Szybicki)",
            hylos::Hylos: "Four legs with steered wheels (Besseron et al.)",
            rt_mover::RtMover: "Four wheels on two arms that step (Nakajima)",
        }
    };
}
