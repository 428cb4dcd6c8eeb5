//! RT-Mover in the simulator: its section of a scenario file, its nodes, its plant (the
//! simulated physics), and what the tools ask of it.

pub mod nodes;
pub mod plant;
mod results;
pub mod section;
#[cfg(unix)]
mod tools;

use super::section::Facts;
use tautrack::robots::Body;
use tautrack::robots::rt_mover::RtMover;
use tautrack_firmware::boards::host;

/// Facts about RT-Mover that do not depend on a scenario.
pub const FACTS: Facts = Facts {
    name: "RT-Mover",
    nodes: &nodes::NODES,
    guard_program: "guard_rt_mover",
    guard: &host::guard::<RtMover>(),
    scenario_file: "rt-mover/step-10.toml",
    stages: RtMover::STAGES,
    headlines: &[
        "front_left_height_m",
        "rear_right_height_m",
        "support_margin_m",
    ],
    stands_on_wheels: true,
    follow_rates: &[""],
    has_hand: false,
    plots_note: "Angles of the arms' shafts and heights of the wheels as Fig. 7 of Nakajima, and the margin over the wheels that carry load, from the truth.",
    origin: "Equations come from Nakajima, Kinematics for a Rough Terrain Mobile Robot to Climb up a Step; lengths from the published overall size. \
                 Masses, the arms' drop, motors and gears are assumed. Other values are another robot.",
};
