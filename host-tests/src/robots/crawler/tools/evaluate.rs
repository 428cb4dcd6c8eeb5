//! Functions of the group `crawler`: tracks that slip. As in the paper, cohesion `c`, pressure
//! `sigma` and stresses are in N/mm^2.

use crate::tools::evaluate::input::{Input, number};
use crate::tools::evaluate::{EvaluateError, Functions};
use serde_json::{Value, json};
use tautrack::math::Scalar;
use tautrack::robots::crawler::kinematics::{slip_from_grousers, track_point_velocity};
use tautrack::robots::crawler::parameters::{Dimensions, Ground};
use tautrack::robots::crawler::{BodyVelocity, Footprint, Kinematics, Soil, parameters};

/// Pa in one N/mm^2.
const MEGA: f64 = 1e6;

pub fn functions<S: Scalar>() -> Functions {
    vec![
        ("slip_from_grousers", grousers::<S>),
        ("track_point_velocity", point::<S>),
        ("forward", forward::<S>),
        ("inverse", inverse::<S>),
        ("shear_stress", shear_stress::<S>),
        ("driving_force", driving_force::<S>),
    ]
}

/// Inputs `n`, `dl`, `L`.
fn grousers<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let [deformation, length] = scalars::<S, 2>(case, ["dl", "L"])?;
    let count = case.number("n")?;
    if !(count >= 1.0 && count <= f64::from(u32::MAX) && count.fract() == 0.0) {
        return case.member("n")?.unexpected("a whole number from 1 on");
    }
    let slip = slip_from_grousers(count as u32, deformation, length);
    Ok(json!({ "s": number(slip) }))
}

/// Inputs `Vu`, `Vt`, `phi`.
fn point<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let [drift, relative, angle] = scalars::<S, 3>(case, ["Vu", "Vt", "phi"])?;
    let velocity = track_point_velocity(drift, relative, angle);
    Ok(json!({
        "Vby": number(velocity.along),
        "Vbz": number(velocity.across),
        "Vb": number(velocity.speed),
    }))
}

/// Inputs `a1`, `a2`, `s1`, `s2`, `beta`, `r`, `H`.
fn forward<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let kinematics = kinematics::<S>(case, parameters::DIMENSIONS.gear_ratio)?;
    let [heading] = scalars(case, ["beta"])?;
    let sprockets = scalars(case, ["a1", "a2"])?;
    let ([x, y], yaw_rate) = kinematics.forward(sprockets, scalars(case, ["s1", "s2"])?, heading);
    Ok(json!({ "x_dot": number(x), "y_dot": number(y), "beta_dot": number(yaw_rate) }))
}

/// Inputs `v`, `bd`, `s1`, `s2`, `r`, `H`, `i`.
fn inverse<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let kinematics = kinematics::<S>(case, case.number("i")?)?;
    let [forward, yaw_rate] = scalars(case, ["v", "bd"])?;
    let drive = kinematics
        .inverse(
            BodyVelocity { forward, yaw_rate },
            scalars(case, ["s1", "s2"])?,
        )
        .map_err(|error| case.refused(error))?;
    let ([a1, a2], [m1, m2]) = (drive.sprockets.map(number), drive.motors.map(number));
    let [skid1, skid2] = drive.skid.map(number);
    Ok(json!({ "a1": a1, "a2": a2, "m1": m1, "m2": m2, "skid1": skid1, "skid2": skid2 }))
}

/// Inputs `dl`, `c`, `sigma`, `rho`, `K1`, `K2`. `ymax` is `null` where eq. 6 is 0 / 0.
fn shear_stress<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let soil = soil::<S>(case)?;
    let [deformation] = scalars(case, ["dl"])?;
    let pressure = S::from_f64(case.number("sigma")? * MEGA);
    let maximum = soil.numerator_maximum();
    Ok(json!({
        "tau": soil.shear_stress(pressure, deformation).to_f64() / MEGA,
        "tau_max": soil.strength(pressure).to_f64() / MEGA,
        "ymax": if maximum > S::ZERO { number(maximum) } else { Value::Null },
    }))
}

/// Inputs `sb`, `b`, `L`, `c`, `sigma`, `rho`, `K1`, `K2`.
fn driving_force<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let soil = soil::<S>(case)?;
    let [slip, width, length] = scalars(case, ["sb", "b", "L"])?;
    let pressure = S::from_f64(case.number("sigma")? * MEGA);
    let force = soil.driving_force(&Footprint { width, length }, pressure, slip);
    Ok(json!({ "Pn": number(force) }))
}

fn kinematics<S: Scalar>(case: &Input, gear_ratio: f64) -> Result<Kinematics<S>, EvaluateError> {
    let dimensions = Dimensions {
        sprocket_radius: case.number("r")?,
        track_spacing: case.number("H")?,
        gear_ratio,
        ..parameters::DIMENSIONS
    };
    Kinematics::new(&dimensions).map_err(|error| case.refused(error))
}

fn soil<S: Scalar>(case: &Input) -> Result<Soil<S>, EvaluateError> {
    let ground = Ground {
        cohesion: case.number("c")? * MEGA,
        friction_angle: case.number("rho")?,
        k1: case.number("K1")?,
        k2: case.number("K2")?,
    };
    Soil::new(&ground).map_err(|error| case.refused(error))
}

fn scalars<S: Scalar, const N: usize>(
    case: &Input,
    names: [&str; N],
) -> Result<[S; N], EvaluateError> {
    let mut values = [S::ZERO; N];
    for (value, name) in values.iter_mut().zip(names) {
        *value = S::from_f64(case.number(name)?);
    }
    Ok(values)
}
