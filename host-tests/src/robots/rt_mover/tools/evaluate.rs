//! Functions of the group `rt_mover`: the kinematics of the leg-wheel robot RT-Mover. Contacts of a
//! support are counter-clockwise.

use crate::tools::evaluate::input::{Input, matrix, number, numbers};
use crate::tools::evaluate::{EvaluateError, Functions};
use serde_json::{Value, json};
use tautrack::math::Scalar;
use tautrack::robots::rt_mover::lifting::{self, ArmAngles, ProjectedBody, SupportAxle};
use tautrack::robots::rt_mover::parameters::{Lengths, MASSES};
use tautrack::robots::rt_mover::projection::{Projection, stand};
use tautrack::robots::rt_mover::wheel::Arm;
use tautrack::robots::rt_mover::wheel_mode::{self, Frame};
use tautrack::robots::rt_mover::{Axle, Parameters, Shape, Wheel, support};

pub fn functions<S: Scalar>() -> Functions {
    vec![
        ("T_wheel", wheel::<S>),
        ("projection", projection::<S>),
        ("leg_angle", leg_angle::<S>),
        ("steer_rate_eq8", steering_rate::<S>),
        ("lift_step", lift_step::<S>),
        ("swing_velocity", swing::<S>),
        ("rear_wheels", rear_wheels::<S>),
        ("wheel_mode", wheel_mode::<S>),
        ("static_margin", static_margin::<S>),
    ]
}

/// Reads `LB`, `LA`, `Lr`, `R`, `steer_max`. The masses are the ones of the simulated robot.
fn parameters<S: Scalar>(params: &Input) -> Result<Parameters<S>, EvaluateError> {
    let lengths = Lengths {
        body: params.number("LB")?,
        half_arm: params.number("LA")?,
        arm_drop: params.number("Lr")?,
        wheel_radius: params.number("R")?,
        steering_limit: params.number("steer_max")?,
    };
    Parameters::new(&lengths, &MASSES).map_err(|error| params.refused(error))
}

fn scalar<S: Scalar>(case: &Input, name: &str) -> Result<S, EvaluateError> {
    Ok(S::from_f64(case.number(name)?))
}

/// Reads pitch, steering and roll of an arm.
fn arm<S: Scalar>(case: &Input, names: [&str; 3]) -> Result<ArmAngles<S>, EvaluateError> {
    let [pitch, steering, roll] = names;
    Ok(ArmAngles {
        pitch: scalar(case, pitch)?,
        steering: scalar(case, steering)?,
        roll: scalar(case, roll)?,
    })
}

/// Reads one arm's angles and uses them for both arms.
fn shape<S: Scalar>(case: &Input) -> Result<Shape<S>, EvaluateError> {
    let arm = arm(case, ["thp", "ths", "thr"])?;
    Ok(Shape {
        pitch: arm.pitch,
        steering: [arm.steering; 2],
        roll: [arm.roll; 2],
    })
}

/// Inputs `thp`, `ths`, `thr`, `thw`, `front`, `left`. Computes eq. 2 and the lowest point of the
/// wheel.
fn wheel<S: Scalar>(params: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let parameters = parameters::<S>(params)?;
    let axle = if case.flag("front")? {
        Axle::Front
    } else {
        Axle::Rear
    };
    let [left, right] = axle.wheels();
    let wheel = if case.flag("left")? { left } else { right };
    let arm = Arm::new(&parameters, &shape(case)?, axle);
    let rim = arm.rim(&parameters, wheel, scalar(case, "thw")?);
    Ok(json!({
        "T": matrix(&rim.rows()),
        "lowest_point": numbers(&arm.contact(&parameters, wheel)),
    }))
}

/// Inputs `thsf`, `thrf`, `thsr`, `support_left`. One front wheel is lifted; the other three wheels
/// stand on level ground.
fn projection<S: Scalar>(params: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let parameters = parameters::<S>(params)?;
    let lifted = if case.flag("support_left")? {
        Wheel::FrontRight
    } else {
        Wheel::FrontLeft
    };
    let shape = Shape {
        pitch: S::ZERO,
        steering: [scalar(case, "thsf")?, scalar(case, "thsr")?],
        roll: [scalar(case, "thrf")?, S::ZERO],
    };
    let stood = stand(&parameters, &shape, lifted);
    let frame = Projection::new(&parameters, &stood);
    let [offset, length] = frame.body(Axle::Front);
    let [leg, sup] = frame.middles.map(|[x, y, _]| numbers(&[x, y]));
    Ok(json!({
        "thp": number(stood.pitch),
        "thrr": number(stood.roll[1]),
        "contacts": matrix(&frame.contacts),
        "lift": number(frame.height(lifted)),
        "A_f": number(frame.half_widths[0]),
        "A_r": number(frame.half_widths[1]),
        "B": number(frame.length()),
        "Bx": number(offset),
        "By": number(length),
        "th_leg": number(frame.headings[0]),
        "th_sup": number(frame.headings[1]),
        "PP": leg,
        "PQ": sup,
    }))
}

/// Inputs `thp`, `ths`, `thr`.
fn leg_angle<S: Scalar>(params: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let parameters = parameters::<S>(params)?;
    let shape = shape(case)?;
    let arm = Arm::new(&parameters, &shape, Axle::Front);
    let linear = lifting::leg_angle(shape.pitch, shape.steering[0], shape.roll[0]);
    Ok(json!({
        "exact": number(arm.heading()),
        "eq7": number(linear),
        "half_arm": number(arm.half_width(&parameters)),
    }))
}

/// Inputs `thleg_dot`, `thrf_dot`, `thp_dot`, `ths`, `thr`, `thp`. Computes eq. 8.
fn steering_rate<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let angles = arm(case, ["thp", "ths", "thr"])?;
    let rates = ArmAngles {
        pitch: scalar(case, "thp_dot")?,
        steering: S::ZERO,
        roll: scalar(case, "thrf_dot")?,
    };
    let rate = lifting::steering_rate::<S>(scalar(case, "thleg_dot")?, &angles, &rates);
    Ok(json!({ "thsf_dot": number(rate) }))
}

/// Inputs `Af0`, `Af1`, `phi`, `dt`, `support_left`. Computes eq. 3 to 6; the rotation of eq. 6 is
/// over `dt`.
fn lift_step<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let period = scalar::<S>(case, "dt")?;
    let motion = lifting::lift_step(
        scalar(case, "Af0")?,
        scalar(case, "Af1")?,
        scalar(case, "phi")?,
        period,
        case.flag("support_left")?,
    );
    Ok(json!({
        "Vx": number(motion.velocity[0]),
        "Vy": number(motion.velocity[1]),
        "dtheta_o": number(motion.turning * period),
    }))
}

/// Inputs `Af`, `thdot_o`, `phi`, `support_left`. Computes eq. 12.
fn swing<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let motion = lifting::swing::<S>(
        scalar(case, "Af")?,
        scalar(case, "phi")?,
        scalar(case, "thdot_o")?,
        case.flag("support_left")?,
    );
    Ok(json!({ "V": numbers(&motion.velocity) }))
}

/// Inputs `Vx`, `Vy`, `B`, `Bdot`, `off`, `off_dot`, `th_sup`, `thsup_dot`, `A_r`. Computes eq. 9
/// to 11.
fn rear_wheels<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let body = ProjectedBody {
        length: scalar(case, "B")?,
        length_rate: scalar(case, "Bdot")?,
        offset: scalar(case, "off")?,
        offset_rate: scalar(case, "off_dot")?,
    };
    let axle = SupportAxle {
        heading: scalar(case, "th_sup")?,
        heading_rate: scalar(case, "thsup_dot")?,
        half_width: scalar(case, "A_r")?,
    };
    let velocity = [scalar::<S>(case, "Vx")?, scalar(case, "Vy")?];
    let motion = lifting::support_axle(velocity, &body, &axle);
    Ok(json!({
        "V3": number(motion.wheels[0]),
        "V4": number(motion.wheels[1]),
        "thB_dot": number(motion.turning),
    }))
}

/// Inputs `V_B`, `th_leg`, `th_sup`, `B`, `A_f`, `A_r`. Computes eq. 13.
fn wheel_mode<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let frame = Frame {
        headings: [scalar(case, "th_leg")?, scalar(case, "th_sup")?],
        half_widths: [scalar(case, "A_f")?, scalar(case, "A_r")?],
        length: scalar(case, "B")?,
    };
    let motion = wheel_mode::wheel_mode::<S>(&frame, scalar(case, "V_B")?);
    Ok(json!({
        "V": numbers(&motion.wheels),
        "omega_B": number(motion.turning),
        "centre": motion.centre.map(|centre| numbers(&centre)),
        "parallel": motion.centre.is_none(),
    }))
}

/// Inputs `contacts_ccw`, `g`.
fn static_margin<S: Scalar>(_: &Input, case: &Input) -> Result<Value, EvaluateError> {
    let rows = case.rows::<2>("contacts_ccw")?;
    let Ok(supports) = <[[f64; 2]; 3]>::try_from(rows) else {
        return case
            .member("contacts_ccw")?
            .unexpected("an array of 3 supports");
    };
    let supports = supports.map(|place| place.map(S::from_f64));
    let margin = support::static_margin(&supports, case.scalars("g")?);
    Ok(json!({ "margin": number(margin) }))
}
