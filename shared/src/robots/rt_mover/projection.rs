//! Computes the projection frame: how the robot stands, seen from above (Nakajima, section 4,
//! Fig. 4).

use super::parameters::Parameters;
use super::wheel::{Arm, Axle, Shape, WHEELS, Wheel};
use crate::math::Scalar;
use crate::math::vector::{Vector, add, scale, sub};

/// Steps of Newton's method for the pitch of a standing robot. Each doubles the number of correct
/// digits, and the first gives two.
const STEPS: usize = 6;

/// Contacts of the wheels and quantities derived from them, in body-centred level axes with y along
/// the body.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Projection<S> {
    /// Lowest points of the wheels, m.
    pub contacts: [Vector<S>; 4],
    /// Directions of front and rear arm, `theta_leg` and `theta_sup` when a front wheel is lifted,
    /// rad.
    pub headings: [S; 2],
    /// Half widths of front and rear arm, `A_f` and `A_r`, m.
    pub half_widths: [S; 2],
    /// Middles of the front and the rear contacts, `P_P` and `P_Q` when a front wheel is lifted, m.
    pub middles: [Vector<S>; 2],
}

impl<S: Scalar> Projection<S> {
    /// Projection frame of a robot of this shape.
    pub fn new(parameters: &Parameters<S>, shape: &Shape<S>) -> Self {
        let arms = [Axle::Front, Axle::Rear].map(|axle| Arm::new(parameters, shape, axle));
        let contacts = WHEELS.map(|wheel| arms[wheel.axle() as usize].contact(parameters, wheel));
        let middle = |left: Wheel, right: Wheel| {
            let sum = add(contacts[left as usize], contacts[right as usize]);
            scale(S::from_f64(0.5), sum)
        };
        Self {
            contacts,
            headings: [arms[0].heading(), arms[1].heading()],
            half_widths: [
                arms[0].half_width(parameters),
                arms[1].half_width(parameters),
            ],
            middles: [
                middle(Wheel::FrontLeft, Wheel::FrontRight),
                middle(Wheel::RearLeft, Wheel::RearRight),
            ],
        }
    }

    /// Position of the middle of `axle`'s contacts relative to that of the other axle's, m:
    /// sideways and along the body. The second is `B`, negative for the rear.
    pub fn body(&self, axle: Axle) -> [S; 2] {
        let [x, y, _] = sub(
            self.middles[axle as usize],
            self.middles[axle.other() as usize],
        );
        [x, y]
    }

    /// Length `B` of the projected body, m.
    pub fn length(&self) -> S {
        let [x, y] = self.body(Axle::Front);
        (x * x + y * y).sqrt()
    }

    /// Height of `wheel` above its partner, m.
    pub fn height(&self, wheel: Wheel) -> S {
        self.contacts[wheel as usize][2] - self.contacts[wheel.partner() as usize][2]
    }
}

/// Shape in which the robot stands on level ground on the wheels other than `lifted`, with the body
/// itself not rolled: `shape` with its pitch and the roll of the supporting axle replaced.
///
/// The supporting arm is level if `tan roll = tan pitch sin steering`. Newton's method gives the
/// pitch at which the third wheel is equally low. Cost: about 1000 operations. For tests and
/// planning only, because the robot itself measures its pitch.
pub fn stand<S: Scalar>(parameters: &Parameters<S>, shape: &Shape<S>, lifted: Wheel) -> Shape<S> {
    let (leg, support) = (lifted.axle(), lifted.partner());
    let sup = leg.other();
    let [other, _] = sup.wheels();
    let (steering, _) = shape.steering[sup as usize].sin_cos();
    let mut stood = *shape;
    stood.pitch = S::ZERO;
    for _ in 0..=STEPS {
        let (sine, cosine) = stood.pitch.sin_cos();
        stood.roll[sup as usize] = (sine * steering).atan2(cosine);
        let mut rates = Shape {
            pitch: S::ONE,
            ..Shape::ZERO
        };
        // Derivative of the arc tangent above.
        let square = cosine * cosine + sine * sine * steering * steering;
        rates.roll[sup as usize] = if square > S::ZERO {
            steering / square
        } else {
            S::ZERO
        };
        let height = |axle: Axle, wheel: Wheel| {
            let arm = Arm::new(parameters, &stood, axle);
            let motion = arm.motion(parameters, &rates, axle, wheel);
            [arm.contact(parameters, wheel)[2], motion.contact[2]]
        };
        let (own, base) = (height(leg, support), height(sup, other));
        let slope = own[1] - base[1];
        if slope == S::ZERO {
            break;
        }
        stood.pitch = stood.pitch - (own[0] - base[0]) / slope;
    }
    let (sine, cosine) = stood.pitch.sin_cos();
    stood.roll[sup as usize] = (sine * steering).atan2(cosine);
    stood
}
