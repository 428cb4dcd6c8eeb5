//! B2P2 in the simulator: its section of a scenario file, its nodes, its plant (the simulated
//! physics), and what the tools ask of it.

pub mod nodes;
pub mod plant;
pub mod results;
pub mod section;
#[cfg(unix)]
mod tools;

use super::section::Facts;
use tautrack::robots::Body;
use tautrack::robots::b2p2::B2p2;
use tautrack_firmware::boards::host;

/// Facts about B2P2 that do not depend on a scenario.
pub const FACTS: Facts = Facts {
    name: "B2P2",
    nodes: &nodes::NODES,
    guard_program: "guard",
    guard: &host::guard::<B2p2>(),
    scenario_file: "staircase.toml",
    stages: B2p2::STAGES,
    headlines: &[],
    stands_on_wheels: false,
    follow_rates: &["_track"],
    has_hand: true,
    plots_note: "",
    origin: "Masses, inertias, L1 and L2 come from the B2P2 papers of Paillat, Lucidarme and Hardouin.",
};
