//! Solves the motion of a lifted wheel without the approximations of the paper's laws: the
//! supporting wheels roll without slipping, and the lifted wheel does its task.

use super::parameters::Parameters;
use super::task::{MotorCommand, Situation, Task};
use super::wheel::{Arm, Axle, Shape, WHEELS, Wheel, WheelMotion};
use crate::math::Scalar;

/// Smallest determinant of the two linear systems that is accepted, m^2. In its range the robot has
/// at least 0.05.
const LEAST: f64 = 1e-4;

/// Solves `p a + q b = r` for `(p, q)`.
fn solve<S: Scalar>(p: [S; 2], q: [S; 2], r: [S; 2]) -> Option<[S; 2]> {
    let determinant = p[0] * q[1] - p[1] * q[0];
    let least = S::from_f64(LEAST);
    (determinant > least || determinant < -least).then(|| {
        [
            (r[0] * q[1] - r[1] * q[0]) / determinant,
            (p[0] * r[1] - p[1] * r[0]) / determinant,
        ]
    })
}

fn plus<S: Scalar>(base: &Shape<S>, factor: S, other: &Shape<S>) -> Shape<S> {
    let sum = |a: [S; 2], b: [S; 2]| [a[0] + factor * b[0], a[1] + factor * b[1]];
    Shape {
        pitch: base.pitch + factor * other.pitch,
        steering: sum(base.steering, other.steering),
        roll: sum(base.roll, other.roll),
    }
}

fn cross<S: Scalar>(a: [S; 2], b: [S; 2]) -> S {
    a[0] * b[1] - a[1] * b[0]
}

fn minus<S: Scalar>(a: [S; 2], b: [S; 2]) -> [S; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot<S: Scalar>(a: [S; 2], b: [S; 2]) -> S {
    a[0] * b[0] + a[1] * b[1]
}

/// Value of one wheel. The mask tells the compiler that the index is in range.
fn of<T: Copy>(values: &[T; 4], wheel: Wheel) -> T {
    values[wheel as usize & 3]
}

/// Robot of this shape, standing on three wheels.
struct Standing<'a, S> {
    parameters: &'a Parameters<S>,
    arms: [Arm<S>; 2],
}

impl<S: Scalar> Standing<'_, S> {
    fn motions(&self, rates: &Shape<S>) -> [WheelMotion<S>; 4] {
        WHEELS.map(|wheel| {
            let axle = wheel.axle();
            self.arms[axle as usize].motion(self.parameters, rates, axle, wheel)
        })
    }
}

/// Rates of the leg arm's steering shaft and of the wheels, with the resulting rates of pitch and
/// supporting roll. `None` for shapes that no robot takes, such as an arm along the body.
///
/// The unknowns are the rates of pitch, of the supporting roll shaft, of the leg arm's steering
/// shaft, and of the body's rotation. These conditions determine them:
///
/// * The three supporting wheels keep their heights. These two equations give the first two
///   unknowns from the others.
/// * The lifted wheel keeps its y, or turns about its partner at the rate of the task; the partner
///   stands still.
/// * The middle of the supporting axle does not slip sideways.
///
/// Each supporting wheel then rolls as its contact requires, corrected for the arm's own twist.
/// Cost: five times the motion of four wheels, about 2500 operations.
pub fn exact<S: Scalar>(
    parameters: &Parameters<S>,
    situation: &Situation<S>,
    task: &Task<S>,
) -> Option<MotorCommand<S>> {
    let (leg, lifted) = (situation.lifted.axle(), situation.lifted);
    let (sup, support) = (leg.other(), lifted.partner());
    let [left, right] = sup.wheels();
    let standing = Standing {
        parameters,
        arms: [Axle::Front, Axle::Rear].map(|axle| Arm::new(parameters, &situation.shape, axle)),
    };
    let half = S::from_f64(0.5);

    let heights = |rates: &Shape<S>| {
        let z = standing.motions(rates).map(|motion| motion.contact[2]);
        let [support, left, right] = [support, left, right].map(|wheel| of(&z, wheel));
        [support - half * (left + right), left - right]
    };
    let mut pitching = Shape::ZERO;
    pitching.pitch = S::ONE;
    let mut rolling = Shape::ZERO;
    rolling.roll[sup as usize] = S::ONE;
    let (by_pitch, by_roll) = (heights(&pitching), heights(&rolling));
    let on_ground = |rates: Shape<S>| {
        let rest = heights(&rates).map(|height| -height);
        let [pitch, roll] = solve(by_pitch, by_roll, rest)?;
        Some(plus(&plus(&rates, pitch, &pitching), roll, &rolling))
    };
    let mut given = Shape::ZERO;
    given.steering[sup as usize] = situation.rates.steering[sup as usize];
    given.roll[leg as usize] = task.roll_rate();
    let mut steered = Shape::ZERO;
    steered.steering[leg as usize] = S::ONE;
    let (given, steered) = (on_ground(given)?, on_ground(steered)?);

    let contacts = WHEELS.map(|wheel| {
        let [x, y, _] = standing.arms[wheel.axle() as usize].contact(parameters, wheel);
        [x, y]
    });
    let middle = |at: &dyn Fn(Wheel) -> [S; 2]| {
        let (one, other) = (at(left), at(right));
        [half * (one[0] + other[0]), half * (one[1] + other[1])]
    };
    // Positions relative to the leg arm's supporting wheel, which stands still, and velocities,
    // along the body's axes.
    let reach = minus(of(&contacts, lifted), of(&contacts, support));
    let axle = minus(
        middle(&|wheel| of(&contacts, wheel)),
        of(&contacts, support),
    );
    let relative = |rates: &Shape<S>| {
        let xy = standing
            .motions(rates)
            .map(|motion| [motion.contact[0], motion.contact[1]]);
        [
            minus(of(&xy, lifted), of(&xy, support)),
            minus(middle(&|wheel| of(&xy, wheel)), of(&xy, support)),
        ]
    };
    let (wanted, goal) = match *task {
        Task::Vertical { .. } => {
            let (sine, cosine) = situation.heading.sin_cos();
            ([sine, cosine], S::ZERO)
        }
        Task::Swing { turning } => ([-reach[1], reach[0]], turning * dot(reach, reach)),
    };
    let (sine, cosine) = standing.arms[sup as usize].heading().sin_cos();
    let across = [cosine, sine];
    let [fixed, free] = [&given, &steered].map(relative);
    let [steering, turning] = solve(
        [dot(free[0], wanted), dot(free[1], across)],
        [cross(reach, wanted), cross(axle, across)],
        [goal - dot(fixed[0], wanted), -dot(fixed[1], across)],
    )?;

    let rates = plus(&given, steering, &steered);
    let motions = standing.motions(&rates);
    let still = of(&motions, support).contact;
    let mut wheels = [S::ZERO; 4];
    for wheel in [support, left, right] {
        let arm = &standing.arms[wheel.axle() as usize];
        let (sine, cosine) = arm.heading().sin_cos();
        let from = minus(of(&contacts, wheel), of(&contacts, support));
        let body = [
            -(turning * from[1]) - still[0],
            turning * from[0] - still[1],
        ];
        wheels[wheel as usize & 3] = dot(body, [-sine, cosine]) + of(&motions, wheel).rolling;
    }
    Some(MotorCommand {
        rates,
        wheels,
        turning,
    })
}
