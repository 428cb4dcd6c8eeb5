//! Functions of the group `cart`: rates of the wheels.

use crate::tools::evaluate::input::{Input, number};
use crate::tools::evaluate::{EvaluateError, Functions};
use serde_json::{Value, json};
use tautrack::math::Scalar;
use tautrack::robots::cart::model;

pub fn functions<S: Scalar>() -> Functions {
    vec![("wheel_rates", wheel_rates::<S>)]
}

/// Inputs `r`, `b`, `v`, `w`.
fn wheel_rates<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let scalar = |name| case.number(name).map(S::from_f64);
    let [left, right] = model::wheel_rates(scalar("r")?, scalar("b")?, scalar("v")?, scalar("w")?);
    Ok(json!({ "left": number(left), "right": number(right) }))
}
