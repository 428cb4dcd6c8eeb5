//! List of the guards, with one for each robot.

/// Calls the macro `$make` with the name and the body of every guard.
macro_rules! every_guard {
    ($make:ident) => {
        $make! {
            /// The tracked robot of Paillat et al.
            B2P2: tautrack::robots::b2p2::B2p2;
            /// The tracked robot of Kurc and Szybicki.
            CRAWLER: tautrack::robots::crawler::Crawler;
            /// The wheel-legged robot of Besseron et al.
            HYLOS: tautrack::robots::hylos::Hylos;
            /// The leg-wheel robot of Nakajima.
            RT_MOVER: tautrack::robots::rt_mover::RtMover;
        }
    };
}

pub(crate) use every_guard;
