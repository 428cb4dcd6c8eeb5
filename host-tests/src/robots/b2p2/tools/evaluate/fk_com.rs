//! Functions of the group `b2p2_fk_com`: frames, centres of mass, Jacobians and axles.

use super::parameters::parameters;
use crate::tools::evaluate::input::{Input, matrix, number, numbers};
use crate::tools::evaluate::{EvaluateError, Functions};
use serde_json::{Value, json};
use tautrack::math::Scalar;
use tautrack::math::vector::Vector;
use tautrack::robots::b2p2::Posture;

pub fn functions<S: Scalar>() -> Functions {
    vec![("fk_com", fk_com::<S>)]
}

/// Input `q`.
fn fk_com<S: Scalar>(params: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let parameters = parameters::<S>(params)?;
    let posture = Posture::new(&parameters, &case.scalars("q")?);
    let jacobians = posture.jacobians();
    let (axles, cog) = posture.along_heading();
    Ok(json!({
        "T": posture.frames().iter().map(|frame| matrix(&frame.rows())).collect::<Value>(),
        "coms": matrix(&posture.coms()),
        "com": numbers(&posture.cog()),
        "Jv": jacobians.iter().map(|jacobian| rows(&jacobian.linear)).collect::<Value>(),
        "Jw": jacobians.iter().map(|jacobian| rows(&jacobian.angular)).collect::<Value>(),
        "axles": matrix(&posture.axles()),
        "heading_p123": numbers(&axles),
        "heading_cog": number(cog),
    }))
}

/// Transposes a matrix that is given as columns to rows.
fn rows<S: Scalar>(columns: &[Vector<S>; 8]) -> Value {
    matrix(&[0, 1, 2].map(|row| columns.map(|column| column[row])))
}
