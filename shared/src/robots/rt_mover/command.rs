//! Computes the motor rates that lift, swing and land a wheel, by a choice of three laws: the
//! paper's as printed, the paper's corrected, and the exact one that the paper approximates.

use super::exact::exact;
use super::lifting::{
    ArmAngles, ProjectedBody, SupportAxle, lift_step, steering_rate, support_axle,
    support_axle_as_printed, swing,
};
use super::parameters::Parameters;
use super::projection::Projection;
use super::task::{MotorCommand, Situation, Task};
use super::wheel::{Arm, Shape};
use crate::math::Scalar;

/// Law of the lifted wheel's motion.
///
/// Each law states its worst error of the lifted wheel's y in the paper's example, m: in lifting,
/// and in landing (`shared/tests/robots/rt_mover.rs`). The example is that of Fig. 7, for which the
/// paper states 7 mm. Here the supporting wheel is pinned, the rear axle does not slip sideways,
/// and the steps take 10 ms.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Law {
    /// Eq. 3 to 12 with the two errors of eq. 11: 0.014 and 0.031 m. The sum in eq. 6 is corrected
    /// even here, because it would turn the arm by twice its angle in every step.
    Printed,
    /// Eq. 3 to 12 corrected: 0.0005 and 0.0007 m.
    Corrected,
    /// No approximation: 0.00001 and 0.00004 m.
    Exact,
}

/// Command by `law` in `situation` that makes the lifted wheel do `task`; `period` is that of the
/// control, s.
///
/// A shape that no robot can take, such as an arm along the body, gives [`MotorCommand::STOPPED`]
/// or a motion that stays finite.
pub fn command<S: Scalar>(
    parameters: &Parameters<S>,
    law: Law,
    situation: &Situation<S>,
    task: &Task<S>,
    period: S,
) -> MotorCommand<S> {
    if law == Law::Exact {
        return exact(parameters, situation, task).unwrap_or(MotorCommand::STOPPED);
    }
    let lifted = situation.lifted;
    let (leg, sup) = (lifted.axle(), lifted.axle().other());
    let (shape, support_left) = (&situation.shape, lifted.partner().is_left());
    let frame = Projection::new(parameters, shape);
    let half_width = frame.half_widths[leg as usize];
    let phi = frame.headings[leg as usize] + situation.heading;
    let motion = match *task {
        Task::Vertical { roll_rate } => {
            // The paper's approximation: the steering stays as it is.
            let mut next = *shape;
            next.roll[leg as usize] += roll_rate * period;
            next.pitch += situation.rates.pitch * period;
            let after = Arm::new(parameters, &next, leg).half_width(parameters);
            lift_step(half_width, after, phi, period, support_left)
        }
        Task::Swing { turning } => swing(half_width, phi, turning, support_left),
    };

    let mut rates = situation.rates;
    rates.roll[leg as usize] = task.roll_rate();
    let middle_rate = |axle: super::Axle| {
        let arm = Arm::new(parameters, shape, axle);
        let [left, right] = axle
            .wheels()
            .map(|wheel| arm.motion(parameters, &rates, axle, wheel).contact);
        let half = S::from_f64(0.5);
        [half * (left[0] + right[0]), half * (left[1] + right[1])]
    };
    let (own, base) = (middle_rate(leg), middle_rate(sup));
    let [offset, length] = frame.body(leg);
    let body = ProjectedBody {
        length,
        length_rate: own[1] - base[1],
        offset,
        offset_rate: own[0] - base[0],
    };
    let axle = SupportAxle {
        heading: frame.headings[sup as usize],
        heading_rate: rates.steering[sup as usize],
        half_width: frame.half_widths[sup as usize],
    };
    // Eq. 9 holds along the body's axes only.
    let (sine, cosine) = situation.heading.sin_cos();
    let [x, y] = motion.velocity;
    let velocity = [cosine * x + sine * y, cosine * y - sine * x];
    let moved = if law == Law::Printed {
        support_axle_as_printed(velocity, &body, &axle)
    } else {
        support_axle(velocity, &body, &axle)
    };

    let arm = |of: &Shape<S>| ArmAngles {
        pitch: of.pitch,
        steering: of.steering[leg as usize],
        roll: of.roll[leg as usize],
    };
    rates.steering[leg as usize] =
        steering_rate(motion.turning - moved.turning, &arm(shape), &arm(&rates));
    let mut wheels = [S::ZERO; 4];
    for (wheel, speed) in sup.wheels().into_iter().zip(moved.wheels) {
        wheels[wheel as usize] = speed;
    }
    MotorCommand {
        rates,
        wheels,
        turning: moved.turning,
    }
}
