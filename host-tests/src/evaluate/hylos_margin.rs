//! Group `hylos_margin`: tip-over angles and the potential made of them. Contacts are clockwise here, as in the papers.

use super::input::{Input, number, numbers};
use super::{EvaluateError, Functions};
use serde_json::{Value, json};
use tautrack::math::Scalar;
use tautrack::stability::tipover::{Potential, angles, margin};

pub fn functions<S: Scalar>() -> Functions {
    vec![("margins", margins::<S>), ("potential", potential::<S>)]
}

/// From `contacts_cw` (3 or 4), `G`, `f`, `moment` at G.
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

/// Backwards, the contacts are counter-clockwise; then the edge from contact `k` to `k + 1` is the one that ends at the old `k`.
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

/// From `nu`, `k_stab`, `v_star`, `v_min`.
fn potential<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let [gain, limit, floor] = ["k_stab", "v_star", "v_min"].map(|name| case.number(name));
    let potential =
        Potential::<S>::new(gain?, limit?, floor?).map_err(|error| case.refused(error))?;
    let nu: Vec<S> = case.list("nu")?.into_iter().map(S::from_f64).collect();
    Ok(json!({ "U": number(potential.total(&nu)) }))
}
