//! Chooses the nodes that run the flash image of their board.

use crate::programs::{Board, Program, guard_board, motor_board};
use crate::robots::{NodeName, NodeSpec, Role};
use crate::simulator::run::WITHOUT_IMAGES;
use tautrack::link::WindingModel;

/// Returns the nodes that `names` names; `all` means every node that has a flash image.
///
/// # Errors
/// A text for the user: an unknown name, a node without a flash image, or a program that cannot
/// execute any.
pub(super) fn nodes(names: &[String], specs: &[NodeSpec]) -> Result<Vec<(NodeName, Role)>, String> {
    if !names.is_empty() && cfg!(not(feature = "image")) {
        return Err(WITHOUT_IMAGES.to_owned());
    }
    let mut chosen = Vec::new();
    for name in names {
        if name == "all" {
            chosen.extend(specs.iter().filter(|spec| lacks(spec).is_none()));
            continue;
        }
        let known = || {
            let names: Vec<_> = specs.iter().map(|spec| spec.name.as_str()).collect();
            format!("--image {name}: the robot has {}", names.join(", "))
        };
        let spec = specs.iter().find(|spec| spec.name.as_str() == name);
        let spec = spec.ok_or_else(known)?;
        match lacks(spec) {
            None => chosen.push(spec),
            Some(why) => return Err(format!("--image {name}: {why}")),
        }
    }
    Ok(chosen.iter().map(|spec| (spec.name, spec.role)).collect())
}

/// Why no board can be this node; `None` if one can.
fn lacks(spec: &NodeSpec) -> Option<&'static str> {
    match spec.motor.map(|motor| motor.winding) {
        _ if spec.role == Role::Guard => None,
        Some(WindingModel::Brushed { .. }) => None,
        Some(WindingModel::ThreePhase(_)) => {
            Some("the motor board has no rotor sensor for its three-phase motor")
        }
        None => Some("it has no motor"),
    }
}

/// Builds the flash images of these nodes. `guard` is the guard's program.
///
/// # Errors
/// A text for the user, if the build fails.
pub(super) fn programs(
    nodes: &[(NodeName, Role)],
    guard: &str,
) -> Result<Vec<(NodeName, Board, Program)>, String> {
    let mut images = Vec::new();
    let is_guard = |(_, role): &&(NodeName, Role)| *role == Role::Guard;
    if let Some((name, _)) = nodes.iter().find(is_guard) {
        let programs = guard_board(&[guard]).map_err(|error| error.to_string())?;
        let programs = programs.into_iter();
        images.extend(programs.map(|program| (*name, Board::Image, program)));
    }
    if nodes.len() > images.len() {
        let programs = motor_board().map_err(|error| error.to_string())?;
        images.extend(nodes.iter().filter_map(|(name, role)| {
            let program = match role {
                Role::Screw => &programs.screw,
                Role::Axle => &programs.axle,
                Role::Guard => return None,
            };
            Some((*name, Board::Image, program.clone()))
        }));
    }
    Ok(images)
}
