//! Functions of the group `b2p2_screw`: the extension that keeps the tracks taut.

use crate::tools::evaluate::input::{Input, number};
use crate::tools::evaluate::{EvaluateError, Functions};
use fixed::types::I4F28;
use serde_json::{Value, json};
use tautrack::math::Scalar;
use tautrack::robots::b2p2::model::belt::TautBelt;
use tautrack::screw::Geometry;
use tautrack::units::Angle;

pub fn functions<S: Scalar>() -> Functions {
    vec![("screw", screw::<S>)]
}

/// Inputs `theta`, `K`, `l1`, `l2`. The results come from the fixed-point code that drives the
/// screw, except the second derivative, which only the floating-point code has. Lengths are
/// accurate to 2^-24 m. The angle of the inverse is accurate to about 2e-6 rad, except where the
/// extension is flat.
fn screw<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let theta = case.number("theta")?;
    let [k, l1, l2] = [case.number("K")?, case.number("l1")?, case.number("l2")?];
    let length = I4F28::saturating_from_num::<f64>;
    let geometry =
        Geometry::new(length(l1), length(l2), length(k)).map_err(|error| case.refused(error))?;
    let belt = TautBelt::<S>::new(k, l1, l2).map_err(|error| case.refused(error))?;

    let bits = theta / std::f64::consts::TAU * 4_294_967_296.0;
    let extension = geometry.extension(Angle::from_bits(bits.round() as i64 as i32));
    let l3 = extension.length.to_num::<f64>();
    let reach = geometry.l2().to_num::<f64>() + l3;
    // Near the ends of its range the extension is flat: within its resolution it belongs to a range
    // of angles, so there is no inverse.
    let flat = extension.derivative.abs() < I4F28::lit("0.0001");
    let inverse = geometry
        .inverse(extension.length)
        .map_err(|error| case.refused(error))?;
    let angle = f64::from(inverse.to_bits()) / 4_294_967_296.0 * std::f64::consts::TAU;
    Ok(json!({
        "r": reach,
        "l3": l3,
        "dl3_dtheta": extension.derivative.to_num::<f64>(),
        "d2l3_dtheta2": number(belt.extension(S::from_f64(theta)).second_derivative),
        "inverse_abs_theta": if flat { Value::Null } else { angle.into() },
        "L_axle1_axle3": geometry.k().to_num::<f64>() - reach,
    }))
}
