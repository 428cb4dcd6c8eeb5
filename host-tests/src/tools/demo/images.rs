//! Chooses the nodes that run the flash image of the motor board.

use crate::programs::{Board, Program, motor_board};
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

/// Why the motor board cannot be this node; `None` if it can.
fn lacks(spec: &NodeSpec) -> Option<&'static str> {
    match spec.motor.map(|motor| motor.winding) {
        _ if spec.role == Role::Guard => Some("the guard does not fit the motor board"),
        Some(WindingModel::Brushed { .. }) => None,
        Some(WindingModel::ThreePhase(_)) => {
            Some("the motor board has no rotor sensor for its three-phase motor")
        }
        None => Some("it has no motor"),
    }
}

/// Builds the flash images of these nodes.
///
/// # Errors
/// A text for the user, if the build fails.
pub(super) fn programs(
    nodes: &[(NodeName, Role)],
) -> Result<Vec<(NodeName, Board, Program)>, String> {
    if nodes.is_empty() {
        return Ok(Vec::new());
    }
    let programs = motor_board().map_err(|error| error.to_string())?;
    let program = |role: &Role| match role {
        Role::Screw => programs.screw.clone(),
        Role::Axle | Role::Guard => programs.axle.clone(),
    };
    let images = nodes.iter();
    Ok(images
        .map(|(name, role)| (*name, Board::Image, program(role)))
        .collect())
}
