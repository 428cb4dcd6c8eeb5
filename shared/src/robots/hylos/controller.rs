//! Controls Hylos' body: computes the set-points of all sixteen motors from the sensors and the
//! operator's command.
//!
//! The rates of the legs are the sum of three parts:
//!
//! * The descent of the stability potential, while the margin is below its limit.
//! * The return to the commanded clearance, while the margin is above its limit.
//! * The contact with the ground, always. A platform needs only three wheels to stand. So what
//!   would lift one of the four is removed from the motion (it is the part that `nL_p` cannot
//!   follow). And the loads, measured by the torques of the legs, are spread so that every wheel
//!   carries some, which closes gaps.

use super::least_squares::LeastSquares;
use super::parameters::{HIP_RANGE, KNEE_RANGE, MARGIN_LIMIT, STANCE_REACH, STEERING_RANGE};
use super::velocity::steering_rate;
use super::{Attitude, Form, LEGS, Legs, Parameters, Posture, Potential, Pull, Trajectory};
use crate::math::Scalar;
use crate::math::vector::{Vector, cross, dot, scale, sub, zero};
use crate::stability::tipover::margin;

/// Largest rate of a hip or knee, rad/s. Assumed.
pub const LEG_RATE: f64 = 0.8;
/// Largest rate of the steering, rad/s. Assumed.
pub const STEERING_RATE: f64 = 1.5;
/// Largest rate of a wheel, rad/s. Assumed; it corresponds to 0.6 m/s.
pub const WHEEL_RATE: f64 = 8.0;
/// Gain `K_gamma` of eq. 22, 1/s. Assumed.
const STEERING_GAIN: f64 = 5.0;
/// Speed over ground below which a wheel is not steered, m/s, because it would turn for nothing.
const STEERING_SPEED: f64 = 0.02;
/// Excess of the margin over its limit at which the commanded clearance has its full weight, rad.
const EASE: f64 = 0.1;
/// Gain of the return to the commanded clearance, 1/s, and the largest rate of a joint for this,
/// rad/s.
const RETURN_GAIN: f64 = 0.8;
const RETURN_RATE: f64 = 0.25;
/// Speed with which a wheel follows the ground per newton of missing or excess load, m/(s N), and
/// its maximum, m/s.
const LOAD_GAIN: f64 = 8e-4;
const LOAD_SPEED: f64 = 0.12;
/// Smallest load of a wheel that the controller aims at, N.
const LEAST_LOAD: f64 = 10.0;
/// Time constant of the low-pass of the loads, s; the gears transmit every jolt.
const LOAD_TIME: f64 = 0.03;
/// Largest lead of a set-point over its joint, rad, so that a blocked leg does not wind up.
const LEAD: f64 = 0.15;

/// Measurements of the sensors.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sensed<S> {
    /// Hips and knees, rad.
    pub legs: Legs<S>,
    /// Torques of the hip and knee motors, N m, positive in the positive direction of their joints.
    /// Zero if they are not known; gaps then stay open.
    pub torques: Legs<S>,
    /// Steering angles, rad, counter-clockwise seen from above.
    pub steering: [S; LEGS],
    /// Up direction, a unit vector in the platform's axes ([`Attitude::from_up`]).
    pub up: Vector<S>,
    /// Acceleration of the platform along its axes without gravity, m/s^2; zero if it is not known.
    pub acceleration: Vector<S>,
}

/// Motion that the operator commands.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Desired<S> {
    /// Speed along the heading, m/s, in the horizontal plane: on a slope the wheels turn faster.
    pub forward: S,
    /// Yaw rate, rad/s.
    pub yaw_rate: S,
    /// Height of the hips above the wheels' centres, m, in the posture to which the legs return
    /// when nothing else moves them. `None` leaves the legs where they are.
    pub clearance: Option<S>,
}

/// Set-points of the sixteen motors.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SetPoints<S> {
    /// Hips and knees, rad.
    pub legs: Legs<S>,
    /// Rates of hips and knees, rad/s.
    pub leg_rates: Legs<S>,
    /// Steering angles, rad.
    pub steering: [S; LEGS],
    /// Rates of the steering, rad/s.
    pub steering_rates: [S; LEGS],
    /// Wheel speeds, rad/s, forward positive.
    pub wheel_rates: [S; LEGS],
}

/// Stability of the robot as the controller evaluates it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Assessment<S> {
    /// Tip-over angles about the axes right, front, left and rear, rad.
    pub tip_over: [S; LEGS],
    /// Smallest of them, rad.
    pub margin: S,
    /// Stability potential; zero while the margin is above its limit.
    pub potential: S,
}

/// Body controller of Hylos.
#[derive(Clone, Debug)]
pub struct Controller<S> {
    parameters: Parameters<S>,
    potential: Potential<S>,
    set_points: SetPoints<S>,
    /// Force of the ground on each wheel along the platform's z axis, low-passed, N.
    loads: [S; LEGS],
    /// Angular velocity of the platform that results from the rates of the legs, along its axes,
    /// rad/s.
    turning: Vector<S>,
    /// Rates that the legs would have if they were not held, rad/s.
    proposed: Legs<S>,
    held: bool,
}

impl<S: Scalar> Controller<S> {
    /// Creates the controller of a robot whose joints are where `sensed` says; nothing moves yet.
    pub fn new(parameters: Parameters<S>, potential: Potential<S>, sensed: &Sensed<S>) -> Self {
        Self {
            parameters,
            potential,
            set_points: SetPoints {
                legs: sensed.legs,
                leg_rates: [[S::ZERO; 2]; LEGS],
                steering: sensed.steering,
                steering_rates: [S::ZERO; LEGS],
                wheel_rates: [S::ZERO; LEGS],
            },
            loads: [S::ZERO; LEGS],
            turning: zero(),
            proposed: [[S::ZERO; 2]; LEGS],
            held: false,
        }
    }

    /// Holds the legs from the next step on, or releases them. The controller still computes how
    /// they would move ([`Self::ahead`]).
    pub fn hold_legs(&mut self, held: bool) {
        self.held = held;
    }

    /// Latest set-points.
    pub fn set_points(&self) -> &SetPoints<S> {
        &self.set_points
    }

    /// Posture that the sensors measure. No sensor measures the ground, so its normal is taken to
    /// be that of the mean plane of the wheels.
    pub fn posture(&self, sensed: &Sensed<S>) -> Posture<'_, S> {
        let normal = ground_normal(&self.parameters, &sensed.legs);
        Posture::new(
            &self.parameters,
            &sensed.legs,
            &sensed.steering,
            Attitude::from_up(sensed.up),
            &[normal; LEGS],
        )
    }

    /// Predicted measurements `horizon` s from now if the legs move as the last step proposed.
    pub fn ahead(&self, sensed: &Sensed<S>, horizon: S) -> Sensed<S> {
        let mut next = *sensed;
        for (leg, rates) in next.legs.iter_mut().zip(&self.proposed) {
            for ((place, rate), [low, high]) in
                leg.iter_mut().zip(rates).zip([HIP_RANGE, KNEE_RANGE])
            {
                let moved = *place + *rate * horizon;
                *place = within(moved, S::from_f64(low), S::from_f64(high));
            }
        }
        // Seen from the platform, the world turns the other way.
        let up = sub(sensed.up, scale(horizon, cross(self.turning, sensed.up)));
        let length = dot(up, up).sqrt();
        if length > S::ZERO {
            next.up = scale(S::ONE / length, up);
        }
        next
    }

    /// Moves the set-points by one `period`, s.
    ///
    /// Accepts any input: set-points are always finite, within their ranges, and not faster than
    /// their limits. A joint whose motion cannot be computed holds. Cost: at most 2600 operations
    /// in addition to sines, 9300 instructions of a Cortex-M4F.
    pub fn step(&mut self, sensed: &Sensed<S>, desired: &Desired<S>, period: S) -> Assessment<S> {
        self.feel(sensed, period);
        let posture = self.posture(sensed);
        let follower = posture.follower();
        let pull = Pull {
            force: sub(
                posture.weight().force,
                scale(self.parameters.mass, sensed.acceleration),
            ),
            moment: zero(),
        };
        let tip_over = posture.tip_over_angles(&pull);
        let slopes = tip_over.map(|angle| self.potential.of_angle(angle).1);
        let assessment = Assessment {
            tip_over,
            margin: margin(&tip_over),
            potential: self.potential.total(&tip_over),
        };

        // Eq. 20 with the total gradient, downhill.
        let mut rates = if assessment.potential > S::ZERO {
            let descent = posture.descent(slopes, &pull, &follower);
            slowed(&descent.total.map(|leg| leg.map(|value| -value)))
        } else {
            [[S::ZERO; 2]; LEGS]
        };
        if let Some(clearance) = desired.clearance {
            let spare = assessment.margin - S::from_f64(MARGIN_LIMIT);
            let say = spare * S::from_f64(1.0 / EASE);
            self.return_to(clearance, within(say, S::ZERO, S::ONE), &mut rates);
        }
        keep_on_ground(&posture, &follower, &self.loads, &mut rates);
        let proposed = self.within_ranges(&rates);
        let led_to = motion(&posture, &follower, desired, &proposed);
        let [_, roll, pitch] = led_to.posture;
        let (rates, motion) = if self.held {
            let still = [[S::ZERO; 2]; LEGS];
            (still, motion(&posture, &follower, desired, &still))
        } else {
            (proposed, led_to)
        };
        let turning = posture.attitude.angular_velocity([roll, pitch, S::ZERO]);
        self.turning = turning.map(|rate| bounded(rate, S::from_f64(LEG_RATE)));
        self.proposed = proposed;
        self.advance(sensed, &rates, &motion, period);
        assessment
    }

    /// Updates the loads from the leg motors' torques. A leg at rest is in balance: `tau = -J^T F`.
    fn feel(&mut self, sensed: &Sensed<S>, period: S) {
        let share = period / (S::from_f64(LOAD_TIME) + period);
        for (leg, load) in self.loads.iter_mut().enumerate() {
            let (_, [[ax, az], [bx, bz]]) =
                super::posture::leg_kinematics(&self.parameters, leg, sensed.legs[leg]);
            let [hip, knee] = sensed.torques[leg];
            let area = ax * bz - az * bx;
            // A leg that is nearly straight gives little information, so the result is damped.
            let felt = (bx * hip - ax * knee) * area / (area * area + S::from_f64(1e-6));
            let change = share * (felt - *load);
            if change.is_finite() {
                *load += change;
            }
        }
    }

    /// Adds the rates of the return to the posture with this clearance, weighted by `say`.
    fn return_to(&self, clearance: S, say: S, rates: &mut Legs<S>) {
        let stance = stance(&self.parameters, clearance);
        for (leg, rates) in self.set_points.legs.iter().zip(rates) {
            for ((now, then), rate) in leg.iter().zip(stance).zip(rates) {
                let way = S::from_f64(RETURN_GAIN) * (then - *now);
                *rate += say * bounded(way, S::from_f64(RETURN_RATE));
            }
        }
    }

    /// Bounds the rates, and removes those that would leave a joint's range.
    fn within_ranges(&self, rates: &Legs<S>) -> Legs<S> {
        let mut rates = slowed(rates);
        for (leg, rates) in self.set_points.legs.iter().zip(&mut rates) {
            for ((place, [low, high]), rate) in leg.iter().zip([HIP_RANGE, KNEE_RANGE]).zip(rates) {
                let (at_low, at_high) =
                    (!(*place > S::from_f64(low)), !(*place < S::from_f64(high)));
                if (at_low && *rate < S::ZERO) || (at_high && *rate > S::ZERO) {
                    *rate = S::ZERO;
                }
            }
        }
        rates
    }

    fn advance(
        &mut self,
        sensed: &Sensed<S>,
        rates: &Legs<S>,
        motion: &super::MotorGoals<S>,
        period: S,
    ) {
        let points = &mut self.set_points;
        points.leg_rates = *rates;
        for (leg, place) in points.legs.iter_mut().enumerate() {
            for (joint, range) in [HIP_RANGE, KNEE_RANGE].into_iter().enumerate() {
                let measured = sensed.legs[leg][joint];
                place[joint] = moved(place[joint], rates[leg][joint], period, measured, range);
            }
        }
        for leg in 0..LEGS {
            let measured = sensed.steering[leg];
            // The wheel's own speed shows whether it rolls. Without rolling, the direction of the
            // remaining velocity is random.
            let rolling = motion.wheels[leg] * self.parameters.wheel_radius;
            let fast = rolling * rolling > S::from_f64(STEERING_SPEED * STEERING_SPEED);
            let wanted = match motion.steering[leg] {
                Some(wanted) if fast => wanted,
                _ => points.steering[leg],
            };
            let rate = bounded(
                steering_rate(S::from_f64(STEERING_GAIN), wanted, measured),
                S::from_f64(STEERING_RATE),
            );
            points.steering_rates[leg] = rate;
            points.steering[leg] =
                moved(points.steering[leg], rate, period, measured, STEERING_RANGE);
            points.wheel_rates[leg] = bounded(motion.wheels[leg], S::from_f64(WHEEL_RATE));
        }
    }
}

/// Motion of platform, wheels and steering for the desired motion and these rates of the legs.
fn motion<S: Scalar>(
    posture: &Posture<S>,
    follower: &LeastSquares<S>,
    desired: &Desired<S>,
    rates: &Legs<S>,
) -> super::MotorGoals<S> {
    let trajectory = Trajectory {
        velocity: [desired.forward, sideways(posture, follower, rates)],
        yaw_rate: desired.yaw_rate,
    };
    posture.follow(follower, &trajectory, rates, Form::Full)
}

/// Normal of the mean plane of the wheels' centres, in the platform's axes. The diagonals of the
/// centres are parallel to this plane.
fn ground_normal<S: Scalar>(parameters: &Parameters<S>, legs: &Legs<S>) -> Vector<S> {
    let [a, b, c, d] =
        core::array::from_fn(|leg| super::posture::leg_kinematics(parameters, leg, legs[leg]).0);
    let normal = cross(sub(a, d), sub(c, b));
    let length = dot(normal, normal).sqrt();
    if length > S::from_f64(1e-6) {
        scale(S::ONE / length, normal)
    } else {
        [S::ZERO, S::ZERO, S::ONE]
    }
}

/// Hip and knee angles that put a wheel's centre [`STANCE_REACH`] outside its hip and `clearance`
/// below it, or as near to that as the leg reaches.
pub fn stance<S: Scalar>(parameters: &Parameters<S>, clearance: S) -> [S; 2] {
    let [thigh, shank] = parameters.leg;
    let reach = S::from_f64(STANCE_REACH);
    let square = reach * reach + clearance * clearance;
    let cosine = (square - thigh * thigh - shank * shank) / (thigh * shank + thigh * shank);
    let cosine = within(cosine, -S::ONE, S::ONE);
    let sine = (S::ONE - cosine * cosine).sqrt();
    let hip = clearance.atan2(reach) - (shank * sine).atan2(thigh + shank * cosine);
    [
        within(hip, S::from_f64(HIP_RANGE[0]), S::from_f64(HIP_RANGE[1])),
        within(
            sine.atan2(cosine),
            S::from_f64(KNEE_RANGE[0]),
            S::from_f64(KNEE_RANGE[1]),
        ),
    ]
}

/// Removes from `rates` what would lift a wheel, and adds what spreads the loads as desired.
fn keep_on_ground<S: Scalar>(
    posture: &Posture<S>,
    follower: &LeastSquares<S>,
    loads: &[S; LEGS],
    rates: &mut Legs<S>,
) {
    let lifting = follower.residual(posture.normal_speeds([zero(); 2], rates));
    let surplus = surplus(follower, loads);
    for (leg, wheel) in posture.wheels.iter().enumerate() {
        let follow = bounded(
            S::from_f64(LOAD_GAIN) * surplus[leg],
            S::from_f64(LOAD_SPEED),
        );
        let wanted = follow - lifting[leg];
        let [hip, knee] = wheel.along(wheel.normal);
        // Smallest motion of the leg that gives this speed; damped where the leg cannot give it.
        let factor = wanted / (hip * hip + knee * knee + S::from_f64(1e-3));
        rates[leg][0] += factor * hip;
        rates[leg][1] += factor * knee;
    }
}

/// Excess load of each wheel, N.
///
/// Balance leaves one pattern of loads free: more on one diagonal and less on the other. The
/// desired amount of this pattern is zero, except for what gives every wheel its smallest load.
/// Near the edge of the support, equal shares would require a wheel to pull, and it would be lifted
/// instead.
fn surplus<S: Scalar>(follower: &LeastSquares<S>, loads: &[S; LEGS]) -> [S; LEGS] {
    // Unknown loads are all zero.
    if loads.iter().all(|load| *load == S::ZERO) {
        return [S::ZERO; LEGS];
    }
    let (one, least) = (S::ONE, S::from_f64(LEAST_LOAD));
    let pattern = follower.residual([one, -one, -one, one]);
    let square = product(&pattern, &pattern);
    let free = product(&pattern, loads) / (square + S::from_f64(1e-6));
    // Bounds of the desired amount of the pattern.
    let (mut low, mut high) = (S::from_f64(-1e30), S::from_f64(1e30));
    for (share, load) in pattern.into_iter().zip(loads) {
        // Amount of the pattern that leaves this wheel its smallest load.
        let bound = (least - (*load - free * share)) / share;
        if share > S::ZERO && bound > low {
            low = bound;
        } else if share < S::ZERO && bound < high {
            high = bound;
        }
    }
    let wanted = if low > high {
        S::from_f64(0.5) * (low + high)
    } else {
        within(S::ZERO, low, high)
    };
    pattern.map(|share| share * (free - wanted))
}

fn product<S: Scalar>(a: &[S; LEGS], b: &[S; LEGS]) -> S {
    a.iter().zip(b).fold(S::ZERO, |sum, (a, b)| sum + *a * *b)
}

/// Speed of the platform to its left, m/s, that results from these rates of the legs. The wheels
/// roll forward but cannot slide sideways. So when the legs roll the platform over the wheels, the
/// platform moves sideways. Least squares over the four wheels.
fn sideways<S: Scalar>(posture: &Posture<S>, follower: &LeastSquares<S>, rates: &Legs<S>) -> S {
    let slide = |path: [Vector<S>; 2], legs: &Legs<S>| -> [S; LEGS] {
        let rising = posture.normal_speeds(path, legs);
        let following = follower.solve(rising).map(|value| -value);
        let twist = posture.with_posture(path, following);
        core::array::from_fn(|leg| {
            let wheel = &posture.wheels[leg];
            let velocity = wheel.velocity(twist, legs[leg]);
            dot(wheel.lateral, velocity)
        })
    };
    let left = Trajectory {
        velocity: [S::ZERO, S::ONE],
        yaw_rate: S::ZERO,
    };
    let at_rest = [[S::ZERO; 2]; LEGS];
    let (unit, forced) = (
        slide(posture.path_twist(&left), &at_rest),
        slide([zero(); 2], rates),
    );
    -(product(&unit, &forced) / (product(&unit, &unit) + S::from_f64(1e-3)))
}

/// Scales all rates by one factor so that none is above [`LEG_RATE`]. Their direction stays the
/// same.
fn slowed<S: Scalar>(rates: &Legs<S>) -> Legs<S> {
    let limit = S::from_f64(LEG_RATE);
    let mut largest = limit;
    for rate in rates.as_flattened() {
        let size = if *rate < S::ZERO { -*rate } else { *rate };
        if size > largest {
            largest = size;
        }
    }
    let factor = limit / largest;
    rates.map(|leg| leg.map(|rate| bounded(rate * factor, limit)))
}

/// Moves `place` at `rate`, within [`LEAD`] of the measured joint and within its range.
fn moved<S: Scalar>(place: S, rate: S, period: S, measured: S, [low, high]: [f64; 2]) -> S {
    let lead = S::from_f64(LEAD);
    let next = within(place + rate * period, measured - lead, measured + lead);
    let next = within(next, S::from_f64(low), S::from_f64(high));
    if next.is_finite() { next } else { place }
}

/// Limits `value` to `low..=high`; a NaN bound has no effect.
fn within<S: Scalar>(value: S, low: S, high: S) -> S {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

/// Limits `value` to `-bound..=bound`; 0 for NaN.
fn bounded<S: Scalar>(value: S, bound: S) -> S {
    if value > bound {
        bound
    } else if value < -bound {
        -bound
    } else if value.is_finite() {
        value
    } else {
        S::ZERO
    }
}
