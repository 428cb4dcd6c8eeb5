//! Functions of the group `b2p2_clearance`: which stairs and curbs the robot clears with taut
//! belts, by statics and the shape of the belts.

use super::parameters::parameters;
use crate::tools::evaluate::input::{Input, number};
use crate::tools::evaluate::{EvaluateError, Functions};
use serde_json::{Value, json};
use tautrack::math::Scalar;
use tautrack::robots::b2p2::Posture;
use tautrack::robots::b2p2::clearance::{Clearing, Straight};
use tautrack::robots::b2p2::model::belt::TautBelt;

pub fn functions<S: Scalar>() -> Functions {
    vec![("stairs", stairs::<S>), ("curb", curb::<S>)]
}

/// Inputs of the robot, besides its parameters: `K` and `pulley_radius`, m.
fn straight<S: Scalar>(params: &Input, case: &Input) -> Result<Straight<S>, EvaluateError> {
    let parameters = parameters::<S>(params)?;
    let [l1, l2, axle_3] = [
        params.number("l1")?,
        params.number("l2")?,
        params.number("c3")?,
    ];
    let belt =
        TautBelt::<S>::new(case.number("K")?, l1, l2).map_err(|error| case.refused(error))?;
    let mut q = [S::ZERO; 8];
    q[7] = belt.extension(S::ZERO).length - S::from_f64(axle_3);
    let posture = Posture::new(&parameters, &q);
    // At `q = 0` the heading is y0.
    let [_, forward, up] = posture.cog();
    Ok(Straight {
        cog: [forward, up],
        length: posture.axles()[2][1],
        pulley_radius: S::from_f64(case.number("pulley_radius")?),
    })
}

/// Inputs `K`, `pulley_radius`, `riser`, `run`, `friction`.
fn stairs<S: Scalar>(params: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let [riser, run, friction] = case_numbers::<S, 3>(case, ["riser", "run", "friction"])?;
    Ok(found(straight(params, case)?.stairs(riser, run, friction)))
}

/// Inputs `K`, `pulley_radius`, `height`, `friction`.
fn curb<S: Scalar>(params: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let [height, friction] = case_numbers::<S, 2>(case, ["height", "friction"])?;
    Ok(found(straight(params, case)?.curb(height, friction)))
}

fn case_numbers<S: Scalar, const N: usize>(
    case: &Input,
    names: [&str; N],
) -> Result<[S; N], EvaluateError> {
    let mut values = [S::ZERO; N];
    for (value, name) in values.iter_mut().zip(names) {
        *value = S::from_f64(case.number(name)?);
    }
    Ok(values)
}

fn found<S: Scalar>(clearing: Clearing<S>) -> Value {
    json!({
        "clears": clearing.margin >= S::ZERO,
        "margin_mm": number(clearing.margin * S::from_f64(1e3)),
        "phase": clearing.phase as u8,
    })
}
