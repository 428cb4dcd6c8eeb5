//! Functions of the group `b2p2_zmp`: the ground's reaction and the zero moment point.

use super::parameters::parameters;
use crate::tools::evaluate::input::{Input, numbers};
use crate::tools::evaluate::{EvaluateError, Functions};
use serde_json::{Value, json};
use tautrack::math::Scalar;
use tautrack::robots::b2p2::Posture;
use tautrack::stability::zmp::{Plane, ZeroMomentPoint, zero_moment_point};

pub fn functions<S: Scalar>() -> Functions {
    vec![("zmp", zmp::<S>)]
}

/// Inputs `q`, `qd`, `qdd`, `plane_point`, `normal`. `zmp` is `null` if there is none.
fn zmp<S: Scalar>(params: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let parameters = parameters::<S>(params)?;
    let posture = Posture::new(&parameters, &case.scalars("q")?);
    let effort = posture.newton_euler(&case.scalars("qd")?, &case.scalars("qdd")?);
    let plane = Plane {
        point: case.scalars("plane_point")?,
        normal: case.scalars("normal")?,
    };
    let point = match zero_moment_point(&effort.reaction, &plane) {
        ZeroMomentPoint::At(point) => numbers(&point),
        ZeroMomentPoint::None => Value::Null,
    };
    Ok(json!({
        "F": numbers(&effort.reaction.force),
        "M_O": numbers(&effort.reaction.moment),
        "zmp": point,
    }))
}
