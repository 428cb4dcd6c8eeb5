//! The cart in the simulator: its section of a scenario, its nodes, its plant, and what the
//! tools ask of it.

pub mod nodes;
pub mod plant;
mod results;
pub mod section;
#[cfg(test)]
mod tests;
mod tools;

use super::section::Facts;
use tautrack::robots::Body;
use tautrack::robots::cart::Cart;
use tautrack_firmware::boards::host;

/// Facts about the cart that need no scenario.
pub const FACTS: Facts = Facts {
    name: "cart",
    nodes: &nodes::NODES,
    guard_program: "guard_cart",
    guard: &host::guard::<Cart>(),
    scenario_file: "cart/flat.toml",
    stages: Cart::STAGES,
    headlines: &["left_wheel_radps", "right_wheel_radps"],
    stands_on_wheels: false,
    follow_rates: &["_wheel"],
    has_hand: false,
    plots_note: "Rates of the wheels, from the truth.",
    origin: "All measures and masses are assumed: nobody has built this cart.",
};
