//! Reads the `params` of the groups about Hylos, and the state that is an input of several
//! functions.

use crate::tools::evaluate::EvaluateError;
use crate::tools::evaluate::input::Input;
use tautrack::math::Scalar;
use tautrack::robots::hylos::{Attitude, LEGS, Legs, Measures, Parameters, Posture};

/// Reads `g`, `hip_x`, `hip_y`, `off_y`, `l1`, `l2`, `r`, `m_body`, `com_body`, `m_wheel`.
pub fn parameters<S: Scalar>(params: &Input) -> Result<Parameters<S>, EvaluateError> {
    let measures = Measures {
        hip: [params.number("hip_x")?, params.number("hip_y")?],
        wheel_offset: params.number("off_y")?,
        leg: [params.number("l1")?, params.number("l2")?],
        wheel_radius: params.number("r")?,
        platform_mass: params.number("m_body")?,
        platform_com: params.numbers("com_body")?,
        wheel_mass: params.number("m_wheel")?,
        gravity: params.number("g")?,
    };
    Parameters::new(&measures).map_err(|error| params.refused(error))
}

/// Reads eight numbers: hip and knee of each leg.
pub fn legs<S: Scalar>(case: &Input, name: &str) -> Result<Legs<S>, EvaluateError> {
    let values: [S; 2 * LEGS] = case.scalars(name)?;
    Ok(std::array::from_fn(|leg| {
        [values[2 * leg], values[2 * leg + 1]]
    }))
}

/// Inputs `phi`, `psi`, `theta`.
pub fn attitude<S: Scalar>(case: &Input) -> Result<Attitude<S>, EvaluateError> {
    let [roll, pitch, yaw] = ["phi", "psi", "theta"].map(|name| case.number(name));
    Ok(Attitude::from_angles(
        [roll?, pitch?, yaw?].map(S::from_f64),
    ))
}

/// Inputs `qa`, `gamma`, the angles of the attitude, and `normals0`, the ground's normals in world
/// axes.
pub fn posture<'a, S: Scalar>(
    parameters: &'a Parameters<S>,
    case: &Input,
) -> Result<Posture<'a, S>, EvaluateError> {
    let attitude = attitude(case)?;
    let normals = case.member("normals0")?.array::<LEGS>()?;
    let mut in_platform = [[S::ZERO; 3]; LEGS];
    for (normal, input) in in_platform.iter_mut().zip(&normals) {
        *normal = attitude.into_platform(input.as_numbers()?.map(S::from_f64));
    }
    Ok(Posture::new(
        parameters,
        &legs(case, "qa")?,
        &case.scalars("gamma")?,
        attitude,
        &in_platform,
    ))
}
