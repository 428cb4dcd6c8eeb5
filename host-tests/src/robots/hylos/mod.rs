//! Hylos in the simulator: its section of a scenario file, its nodes, its plant (the simulated
//! physics), and what the tools ask of it.

pub mod nodes;
pub mod plant;
mod results;
pub mod section;
#[cfg(unix)]
mod tools;

use super::section::Facts;
use tautrack::robots::Body;
use tautrack::robots::hylos::Hylos;
use tautrack_firmware::boards::host;

/// Facts about Hylos that do not depend on a scenario.
pub const FACTS: Facts = Facts {
    name: "Hylos",
    nodes: &nodes::NODES,
    guard_program: "guard_hylos",
    guard: &host::guard::<Hylos>(),
    scenario_file: "hylos/loop.toml",
    stages: Hylos::STAGES,
    headlines: &["tip_over_margin_rad"],
    stands_on_wheels: false,
    follow_rates: &["_wheel"],
    has_hand: false,
    plots_note: "Least tip-over angle as Fig. 7 of Besseron et al., joint angles and loads of the wheels, from the truth.",
    origin: "Equations, mass and the limit of the margin come from Besseron, Grand, Ben Amar and Bidaud, Decoupled control of the high mobility robot Hylos based on a \
                 dynamic stability margin. The paper gives no lengths, no distribution of the mass and no motors: all of these are assumed. Other values are another robot.",
};
