//! Functions of the group `b2p2_dynamics`: the equations of motion.

use super::parameters::parameters;
use crate::tools::evaluate::input::{Input, matrix, numbers};
use crate::tools::evaluate::{EvaluateError, Functions};
use serde_json::{Value, json};
use tautrack::math::Scalar;
use tautrack::robots::b2p2::Posture;

pub fn functions<S: Scalar>() -> Functions {
    vec![("dynamics", dynamics::<S>)]
}

/// Inputs `q`, `qd`, `qdd`. `T` is computed by the recursion, independently of the matrices.
fn dynamics<S: Scalar>(params: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let parameters = parameters::<S>(params)?;
    let posture = Posture::new(&parameters, &case.scalars("q")?);
    let (rates, accelerations) = (case.scalars("qd")?, case.scalars("qdd")?);
    Ok(json!({
        "D": matrix(&posture.inertia_matrix()),
        "C": matrix(&posture.coriolis_matrix(&rates)),
        "Q": numbers(&posture.gravity_forces()),
        "T": numbers(&posture.newton_euler(&rates, &accelerations).forces),
    }))
}
