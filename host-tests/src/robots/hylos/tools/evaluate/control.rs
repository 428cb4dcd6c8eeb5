//! Functions of the group `hylos_control`: the velocity model and the decoupled control of posture
//! and trajectory.

use super::parameters::{attitude, legs, parameters, posture};
use crate::tools::evaluate::input::{Input, matrix, numbers};
use crate::tools::evaluate::{EvaluateError, Functions};
use serde_json::{Value, json};
use tautrack::math::Scalar;
use tautrack::robots::hylos::velocity::steering_rate;
use tautrack::robots::hylos::{Form, LEGS, Trajectory};

pub fn functions<S: Scalar>() -> Functions {
    vec![("control", control::<S>), ("attitude", matrices::<S>)]
}

/// Inputs: the state, `xt_dot` (x, y, yaw), `grad` and the `sign` with which the legs follow it,
/// `K_gamma`, and whether eq. 17 is computed in its `full` form.
fn control<S: Scalar>(params: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let parameters = parameters::<S>(params)?;
    let posture = posture(&parameters, case)?;
    let [x, y, yaw_rate] = case.scalars("xt_dot")?;
    let trajectory = Trajectory {
        velocity: [x, y],
        yaw_rate,
    };
    let sign = S::from_f64(case.number("sign")?);
    let rates = legs::<S>(case, "grad")?.map(|leg| leg.map(|value| sign * value));
    let form = if case.truth("full")? {
        Form::Full
    } else {
        Form::Printed
    };
    let motion = posture.motion(&trajectory, &rates, form);
    let gain = S::from_f64(case.number("K_gamma")?);
    let measured: [S; LEGS] = case.scalars("gamma")?;
    let wanted: [S; LEGS] =
        std::array::from_fn(|leg| motion.steering[leg].unwrap_or(measured[leg]));
    let turning: [S; LEGS] =
        std::array::from_fn(|leg| steering_rate(gain, wanted[leg], measured[leg]));
    Ok(json!({
        "L": matrix(&posture.locomotion()),
        "J": matrix(&posture.jacobian()),
        "qa_dot": numbers(rates.as_flattened()),
        "xp_dot": numbers(&motion.posture),
        "omega": numbers(&motion.wheels),
        "gamma_des": numbers(&wanted),
        "gamma_dot": numbers(&turning),
    }))
}

/// Inputs `phi`, `psi`, `theta`. The printed `T_phi` gives the angular velocity in world axes.
fn matrices<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let attitude = attitude::<S>(case)?;
    let (rotation, rates) = (attitude.rotation(), attitude.rate_matrix());
    let printed = rotation.map(|row| {
        [0, 1, 2].map(|column| {
            row.iter()
                .zip(&rates)
                .fold(S::ZERO, |sum, (factor, rate)| sum + *factor * rate[column])
        })
    });
    Ok(json!({
        "R0P": matrix(&rotation),
        "T_phi_RP": matrix(&rates),
        "T_phi_printed_R0": matrix(&printed),
    }))
}
