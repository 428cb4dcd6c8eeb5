//! The crawler in the simulator: its section of a scenario file, its nodes, its plant (the
//! simulated physics), and what the tools ask of it.

pub mod nodes;
pub mod plant;
mod results;
pub mod section;
#[cfg(unix)]
mod tools;

use super::section::Facts;
use tautrack::robots::Body;
use tautrack::robots::crawler::Crawler;
use tautrack_firmware::boards::host;

/// Facts about the crawler that do not depend on a scenario.
pub const FACTS: Facts = Facts {
    name: "crawler",
    nodes: &nodes::NODES,
    guard_program: "guard_crawler",
    guard: &host::guard::<Crawler>(),
    scenario_file: "crawler/slope.toml",
    stages: Crawler::STAGES,
    headlines: &["speed_over_ground_mps", "left_slip_1", "right_slip_1"],
    stands_on_wheels: false,
    follow_rates: &["_track"],
    has_hand: false,
    plots_note: "Rates of sprockets and motors as Fig. 7, skid (sprocket's speed times slip) as Fig. 8 of Kurc and Szybicki, from the truth.",
    origin: "Lengths, gear and equations come from Kurc and Szybicki, Kinematics of a Robot with Crawler Drive. The paper gives no masses, no track width and no soil: \
                 5 kg with the centre of gravity 45 mm high, tracks 40 mm wide and the soil of this run are assumed. Other values are another robot.",
};
