//! Functions of the group `hylos_margin`: tip-over angles, the potential computed from them, and
//! its gradient. As in the papers, contacts are clockwise.

use super::parameters::{parameters, posture};
use crate::tools::evaluate::input::{Input, matrix, number, numbers};
use crate::tools::evaluate::{EvaluateError, Functions};
use serde_json::{Value, json};
use tautrack::math::Scalar;
use tautrack::math::vector::add;
use tautrack::robots::hylos::{LEGS, Potential, Pull};
use tautrack::stability::tipover::{angles, margin};

pub fn functions<S: Scalar>() -> Functions {
    vec![
        ("margins", margins::<S>),
        ("state", state::<S>),
        ("potential", potential::<S>),
    ]
}

/// Inputs `contacts_cw` (3 or 4), `G`, `f`, `moment` at G.
fn margins<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let contacts = case.rows::<3>("contacts_cw")?;
    let nu = match contacts.len() {
        3 => clockwise::<S, 3>(&contacts, case)?,
        4 => clockwise::<S, 4>(&contacts, case)?,
        count => {
            let expected = format!("an array of 3 or 4 contacts, not of {count}");
            return case.member("contacts_cw")?.unexpected(expected);
        }
    };
    Ok(json!({ "nu": numbers(&nu), "m_s": number(margin(&nu)) }))
}

/// Tip-over angles for clockwise contacts. The contacts are reversed, so that they are
/// counter-clockwise; the angles are then put into the order of the input.
fn clockwise<S: Scalar, const N: usize>(
    contacts: &[[f64; 3]],
    case: &Input,
) -> Result<Vec<S>, EvaluateError> {
    let reversed = std::array::from_fn(|k| contacts[N - 1 - k].map(S::from_f64));
    let nu = angles::<S, N>(
        &reversed,
        case.scalars("G")?,
        case.scalars("f")?,
        case.scalars("moment")?,
    );
    Ok((0..N).map(|k| nu[(2 * N - 2 - k) % N]).collect())
}

/// Inputs: the state, the additional force `f0` and moment `m0` in world axes, and the potential's
/// constants. The tip-over axes of `nu` are front, right, rear, left.
fn state<S: Scalar>(params: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let parameters = parameters::<S>(params)?;
    let posture = posture(&parameters, case)?;
    let weight = posture.weight();
    let into_platform = |direction| posture.attitude().into_platform(direction);
    let pull = Pull {
        force: add(weight.force, into_platform(case.scalars("f0")?)),
        moment: add(weight.moment, into_platform(case.scalars("m0")?)),
    };
    let potential = constants::<S>(case)?;
    let tip_over = posture.tip_over_angles(&pull);
    let gradient = posture.gradient(&potential, &pull, &tip_over);
    let contacts: [[S; 3]; LEGS] = posture.wheels().map(|wheel| wheel.contact);
    Ok(json!({
        "contacts_P": matrix(&contacts),
        "cog_P": numbers(&posture.cog()),
        "nu": numbers(&[1, 0, 3, 2].map(|axis| tip_over[axis])),
        "m_s": number(margin(&tip_over)),
        "U": number(potential.total(&tip_over)),
        "dU_dqa_partial": numbers(gradient.partial.as_flattened()),
        "dU_dzphipsi": numbers(&gradient.attitude),
        "dU_dqa_total": numbers(gradient.total.as_flattened()),
    }))
}

/// Inputs `k_stab`, `v_star`, `v_min`.
fn constants<S: Scalar>(case: &Input) -> Result<Potential<S>, EvaluateError> {
    let [gain, limit, floor] = ["k_stab", "v_star", "v_min"].map(|name| case.number(name));
    Potential::new(gain?, limit?, floor?).map_err(|error| case.refused(error))
}

/// Inputs `nu` and the potential's constants.
fn potential<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let potential = constants::<S>(case)?;
    let nu: Vec<S> = case.list("nu")?.into_iter().map(S::from_f64).collect();
    Ok(json!({ "U": number(potential.total(&nu)) }))
}
