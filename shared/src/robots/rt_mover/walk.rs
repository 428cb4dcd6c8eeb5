//! Carries out the step-up gait: computes nine motor rates from nine shaft angles, the torques of
//! wheels and arms, and an inclination.
//!
//! [`super::gait::TABLE`] decides which stage follows. Each stage has one arm of `act`, which
//! drives the motors, and one arm of `event`, which decides when it is over.

use super::command::{Law, command};
use super::gait::{Event, ORDER, Stage, next};
use super::parameters::Parameters;
use super::posture::{PostureControl, yielding};
use super::prediction::{Prediction, Progress, Way, reach};
use super::projection::Projection;
use super::support::margin_without;
use super::task::{MotorCommand, Situation, Task};
use super::wheel::{Arm, Axle, Shape, WHEELS, Wheel};
use super::wheel_mode::{Frame, wheel_mode};
use crate::math::{atan2, clamp, limit, min};
use crate::stability::allowed::Command;

/// Measurements of one tick. Arrays are indexed by [`Wheel`] or [`Axle`].
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Inputs {
    /// Angles of the wheels, forward, rad, from any zero. The gait uses their changes only and does
    /// not unwrap them.
    pub wheels: [f32; 4],
    /// Angles of the steering shafts, rad.
    pub steering: [f32; 2],
    /// Angles of the roll shafts, rad.
    pub roll: [f32; 2],
    /// Angle of the pitch shaft: the seat relative to the body, front up, rad.
    pub pitch_shaft: f32,
    /// Torques of the wheels, forward, N m.
    pub wheel_torques: [f32; 4],
    /// Torques of the roll shafts on their arms, N m.
    pub roll_torques: [f32; 2],
    /// Inclination of the seat: pitch (front up) and roll (left up), rad.
    pub inclination: [f32; 2],
    /// Heading, counter-clockwise, rad.
    pub heading: f32,
    /// Commanded motion; followed while the robot stands or drives ([`Stage::Standing`]).
    pub command: Command<()>,
    /// Speed scale of all motion except posture control, 0 to 1.
    pub speed_scale: f32,
}

impl Inputs {
    /// Shape of the robot.
    pub fn shape(&self) -> Shape<f32> {
        Shape {
            pitch: self.inclination[0] - self.pitch_shaft,
            steering: self.steering,
            roll: self.roll,
        }
    }
}

/// Rates for the nine motors, rad/s.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Outputs {
    /// Wheels, forward.
    pub wheels: [f32; 4],
    /// Steering shafts.
    pub steering: [f32; 2],
    /// Roll shafts.
    pub roll: [f32; 2],
    /// Pitch shaft.
    pub pitch_shaft: f32,
}

/// Parameters of the gait.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Pace {
    /// Law of the lifted wheel's motion.
    pub law: Law,
    /// Driving speed, m/s.
    pub speed: f32,
    /// Rate of steering on the spot, rad/s.
    pub steering_rate: f32,
    /// Rate of lifting a wheel, rad/s.
    pub lifting_rate: f32,
    /// Rate of swinging it, rad/s.
    pub swinging_rate: f32,
    /// Rate of landing it, rad/s.
    pub landing_rate: f32,
    /// Angle of the body askew, rad.
    pub skew: f32,
    /// Distance between wheel and step when the wheel rises, m.
    pub clearance_before: f32,
    /// Distance between wheel and edge when the wheel stands on the step, m.
    pub clearance_behind: f32,
    /// Height of the wheel above the step in between, m.
    pub clearance_above: f32,
    /// Torque of the wheels at which they count as touching the step, N m.
    pub blocked_torque: f32,
    /// Fraction of the airborne torque below which a landing wheel counts as touching.
    pub touched_share: f32,
    /// Smallest margin that a predicted step may have, m.
    pub predicted_margin: f32,
    /// Margin below which a wheel in the air is lowered, m.
    pub lowering_margin: f32,
    /// Posture control.
    pub posture: PostureControl<f32>,
    /// Torque difference of the roll shafts that turns them against each other at 1 rad/s,
    /// N m s/rad.
    pub compliance: f32,
    /// Timeout of a stage, s.
    pub timeout: f32,
    /// Largest rate of a wheel, rad/s. The outputs are limited to it last.
    pub wheel_limit: f32,
    /// The same of a shaft, rad/s.
    pub shaft_limit: f32,
}

impl Pace {
    /// Parameters of a careful gait.
    pub fn nominal() -> Self {
        Self {
            law: Law::Exact,
            speed: 0.06,
            steering_rate: 0.3,
            lifting_rate: 0.1,
            swinging_rate: 0.1,
            landing_rate: 0.06,
            skew: -0.14,
            clearance_before: 0.025,
            clearance_behind: 0.03,
            clearance_above: 0.03,
            blocked_torque: 2.5,
            touched_share: 0.6,
            predicted_margin: 0.010,
            lowering_margin: 0.004,
            posture: PostureControl {
                gain: 400.0,
                damping: 80.0,
            },
            compliance: 800.0,
            timeout: 30.0,
            wheel_limit: 4.0,
            shaft_limit: 0.6,
        }
    }
}

/// Tolerance within which a steering shaft counts as steered, rad.
const STEERED: f32 = 0.01;
/// Gain from the error of a steering angle to its rate, 1/s.
const STEERING_GAIN: f32 = 5.0;
/// Time for which a torque must be measured to count, and time in which the load spreads, s.
const FELT: f32 = 0.03;
const SETTLED: f32 = 0.6;
/// Steering angle with which the body is turned askew, rad.
const TURNING: f32 = 0.35;
/// Longest period that counts, s.
const LONGEST_PERIOD: f32 = 0.1;
/// Fraction of a roll rate that the soft start allows in its first tick; the rest follows within a
/// tenth of a second.
const SOFT: f32 = 0.1;

/// Torque with which an arm presses on the partner of `lifted`, N m: the whole load of the arm
/// while that wheel is in the air.
fn torque_to_partner(inputs: &Inputs, lifted: Wheel) -> f32 {
    -lifted.side::<f32>() * inputs.roll_torques[lifted.axle() as usize]
}

/// State of the gait.
#[derive(Clone, Debug)]
pub struct Gait {
    parameters: Parameters<f32>,
    pace: Pace,
    stage: Stage,
    step: usize,
    step_height: f32,
    straight: f32,
    since: f32,
    felt: f32,
    way: f32,
    aborted: bool,
    /// Height above its partner and distance ahead of it at which the wheel started, m.
    begun: [f32; 2],
    /// Torque of its roll shaft while it was in the air, N m.
    airborne_torque: f32,
    /// Integral of that torque over the present stage, N m s.
    carried: f32,
    /// Prediction of the next step, while it is in progress.
    prediction: Option<Prediction<f32>>,
    /// Angle at which the supporting axle's steering shaft is held during the step, rad.
    held: f32,
    before: Option<(Shape<f32>, [f32; 4])>,
    margin: f32,
}

impl Gait {
    /// Gait of a robot that stands.
    pub fn new(parameters: Parameters<f32>, pace: Pace) -> Self {
        Self {
            parameters,
            pace,
            stage: Stage::Standing,
            step: 0,
            step_height: 0.0,
            straight: 0.0,
            since: 0.0,
            felt: 0.0,
            way: 0.0,
            aborted: false,
            begun: [0.0; 2],
            airborne_torque: 0.0,
            carried: 0.0,
            prediction: None,
            held: 0.0,
            before: None,
            margin: 0.0,
        }
    }

    /// Starts the gait up a step of `height`, m, which the robot faces straight at `heading`, rad.
    /// Ignored unless the robot stands.
    pub fn ask(&mut self, height: f32, heading: f32) {
        let stage = next(self.stage, Event::Commanded);
        if stage != self.stage && height > 0.0 {
            (self.step, self.aborted) = (0, false);
            (self.step_height, self.straight) = (height, heading);
            self.enter(stage);
        }
    }

    /// Acknowledges how a gait ended: the robot stands again and can be driven. A stranded wheel is
    /// lowered first.
    pub fn acknowledge(&mut self) {
        self.follow(Event::Acknowledged);
    }

    /// Aborts the gait where it is. A wheel in the air stays there.
    pub fn hold(&mut self) {
        self.aborted |= self.stage.lifts();
        self.follow(Event::GivenUp);
    }

    fn follow(&mut self, event: Event) {
        let stage = next(self.stage, event);
        if stage != self.stage {
            self.enter(stage);
        }
    }

    /// Present stage.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// Wheel whose turn it is.
    pub fn wheel(&self) -> Wheel {
        ORDER[if self.step < 4 { self.step } else { 3 }]
    }

    /// Wheel that the gait may have in the air, if any.
    pub fn lifted(&self) -> Option<Wheel> {
        self.stage.lifts().then(|| self.wheel())
    }

    /// Static margin without the wheel whose turn it is, m.
    pub fn margin(&self) -> f32 {
        self.margin
    }

    fn enter(&mut self, stage: Stage) {
        // However the stage ends, landing needs this torque to detect the ground.
        if matches!(self.stage, Stage::Lifting | Stage::Swinging) {
            self.airborne_torque = self.mean_torque();
        }
        self.stage = stage;
        self.prediction = None;
        (self.since, self.felt, self.way, self.carried) = (0.0, 0.0, 0.0, 0.0);
    }

    /// Runs one tick of `period`, s.
    pub fn tick(&mut self, inputs: &Inputs, period: f32) -> Outputs {
        // Limited, so that a bad period does not stop the timers.
        let period = limit(period, LONGEST_PERIOD);
        let shape = inputs.shape();
        let (last, wheels) = self.before.unwrap_or((shape, inputs.wheels));
        let rate = |now: f32, before: f32| {
            if period > 0.0 {
                (now - before) / period
            } else {
                0.0
            }
        };
        let rates = Shape {
            pitch: rate(shape.pitch, last.pitch),
            steering: [0, 1].map(|i| rate(shape.steering[i], last.steering[i])),
            roll: [0, 1].map(|i| rate(shape.roll[i], last.roll[i])),
        };
        let rolled = (0..4).fold(0.0, |sum, i| sum + (inputs.wheels[i] - wheels[i]));
        self.way += 0.25 * self.parameters.wheel_radius * rolled;
        self.before = Some((shape, inputs.wheels));
        self.since += period;
        let situation = Situation {
            shape,
            rates,
            heading: inputs.heading - self.straight,
            lifted: self.wheel(),
        };
        self.margin = margin_without(&self.parameters, &shape, self.wheel());
        self.carried += period * torque_to_partner(inputs, self.wheel());
        if let Some(event) = self.event(&situation, inputs, period) {
            let stage = next(self.stage, event);
            if stage != self.stage {
                self.leave(event, &situation);
                self.enter(stage);
            }
        }
        self.act(&situation, inputs, period)
    }

    /// Stores what later stages need when a stage ends.
    fn leave(&mut self, event: Event, situation: &Situation<f32>) {
        match (self.stage, event) {
            (Stage::Widening, _) => {
                let sup = situation.lifted.axle().other() as usize;
                self.held = self.steering(situation, Command::default())[sup];
                self.begun = reach(
                    &self.parameters,
                    &situation.shape,
                    situation.heading,
                    situation.lifted,
                );
            }
            (Stage::Lifting | Stage::Swinging, event) => {
                self.aborted |= event != Event::Reached;
            }
            (Stage::Landing, Event::Late) => self.aborted = true,
            (Stage::Settling, Event::Airborne) => {}
            (Stage::Settling, _) => self.step += 1,
            _ => {}
        }
    }

    /// Mean torque of the leg arm's roll shaft over the present stage, N m.
    fn mean_torque(&self) -> f32 {
        if self.since > 0.0 {
            self.carried / self.since
        } else {
            0.0
        }
    }

    fn event(&mut self, situation: &Situation<f32>, inputs: &Inputs, period: f32) -> Option<Event> {
        let (p, pace) = (&self.parameters, &self.pace);
        let (leg, lifted) = (situation.lifted.axle(), situation.lifted);
        let reached = |reached: bool| reached.then_some(Event::Reached);
        let steered = |targets: [f32; 2]| situation.shape.is_steered(targets, STEERED);
        if self.since > pace.timeout {
            return Some(Event::Late);
        }
        match self.stage {
            Stage::Standing | Stage::Arrived | Stage::Stuck | Stage::Stranded => None,
            Stage::Skewing => reached((situation.heading - pace.skew) * pace.skew.signum() >= 0.0),
            Stage::Seeking => {
                let torque = leg
                    .wheels()
                    .map(|wheel| inputs.wheel_torques[wheel as usize]);
                let blocked = min(torque[0], torque[1]) > pace.blocked_torque
                    && steered(self.steering(situation, inputs.command));
                self.felt = if blocked { self.felt + period } else { 0.0 };
                reached(self.felt > FELT)
            }
            Stage::Backing => reached(self.way <= -pace.clearance_before),
            Stage::Widening if !steered(self.steering(situation, inputs.command)) => None,
            Stage::Widening => {
                let way = Way {
                    rise: self.step_height + pace.clearance_above,
                    travel: self.travel(),
                    fall: pace.clearance_above,
                };
                let (shape, heading) = (&situation.shape, situation.heading);
                let prediction = self
                    .prediction
                    .get_or_insert_with(|| Prediction::new(p, shape, heading, lifted, &way));
                match prediction.moment(p) {
                    Progress::Unfinished => None,
                    // NaN must not lift a wheel.
                    Progress::Done(end)
                        if end.margin >= pace.predicted_margin
                            && end.steering < p.steering_limit =>
                    {
                        Some(Event::Allowed)
                    }
                    _ => Some(Event::Refused),
                }
            }
            Stage::Lifting | Stage::Swinging if !(self.margin >= pace.lowering_margin) => {
                Some(Event::Unsafe)
            }
            Stage::Lifting => {
                let [height, _] = reach(p, &situation.shape, situation.heading, lifted);
                reached(height - self.begun[0] >= self.step_height + pace.clearance_above)
            }
            Stage::Swinging => {
                let [_, ahead] = reach(p, &situation.shape, situation.heading, lifted);
                reached(ahead - self.begun[1] >= self.travel())
            }
            Stage::Landing => {
                let torque = torque_to_partner(inputs, lifted);
                let touched = torque < pace.touched_share * self.airborne_torque;
                self.felt = if touched { self.felt + period } else { 0.0 };
                reached(self.felt > FELT)
            }
            Stage::Settling => (self.since > SETTLED).then_some(if self.airborne() {
                Event::Airborne
            } else if self.aborted {
                Event::Refused
            } else {
                match self.step {
                    1 => Event::OtherAxle,
                    3 => Event::Last,
                    _ => Event::Partner,
                }
            }),
            Stage::Straightening => reached(steered([0.0; 2])),
        }
    }

    /// Whether the wheel that seemed to touch has carried no load since. A seat that sways relieves
    /// an arm only for a moment; the ground relieves it for good.
    fn airborne(&self) -> bool {
        !(self.mean_torque() < self.pace.touched_share * self.airborne_torque)
    }

    /// Distance by which a wheel moves forward in a step, m.
    fn travel(&self) -> f32 {
        self.parameters.wheel_radius + self.pace.clearance_before + self.pace.clearance_behind
    }

    /// Target angles of the steering shafts in this stage, rad.
    fn steering(&self, situation: &Situation<f32>, command: Command<()>) -> [f32; 2] {
        let (leg, bound) = (situation.lifted.axle(), self.parameters.steering_limit);
        match self.stage {
            Stage::Standing if command.forward != 0.0 => {
                // Equal and opposite angles of both axles give the tightest turn; from eq. 13,
                // tan(theta) = B omega / (2 V).
                let way = command.yaw_rate * command.forward.signum() * self.parameters.body_length;
                let turn = limit(atan2(way, 2.0 * command.forward.abs()), bound);
                [turn, -turn]
            }
            Stage::Skewing => {
                let turn = self.pace.skew.signum() * TURNING;
                [turn, -turn]
            }
            // Both axles lie across the direction of travel: the body moves crabwise, and the axles
            // are parallel to the step.
            Stage::Seeking | Stage::Backing => [limit(-situation.heading, bound); 2],
            Stage::Widening => {
                let mut targets = situation.shape.steering;
                // The supporting wheel on the side of the lifted one moves nearer to it.
                let ahead = match leg {
                    Axle::Front => situation.lifted.side::<f32>(),
                    Axle::Rear => -situation.lifted.side::<f32>(),
                };
                targets[leg.other() as usize] = ahead * bound;
                targets
            }
            Stage::Straightening => [0.0; 2],
            _ => situation.shape.steering,
        }
    }

    /// Rates of all motors in this stage.
    fn act(&mut self, situation: &Situation<f32>, inputs: &Inputs, period: f32) -> Outputs {
        let (p, pace) = (&self.parameters, &self.pace);
        let soft = clamp(inputs.speed_scale, 0.0, 1.0) * min(1.0, SOFT + self.since / 0.1);
        let up = -situation.lifted.side::<f32>();
        let task = match self.stage {
            Stage::Lifting => Some(Task::Vertical {
                roll_rate: up * pace.lifting_rate * soft,
            }),
            Stage::Swinging => Some(Task::Swing {
                turning: -up * pace.swinging_rate * soft,
            }),
            Stage::Landing => Some(Task::Vertical {
                roll_rate: -up * pace.landing_rate * soft,
            }),
            _ => None,
        };
        let level = -pace.posture.rate(inputs.inclination[1]);
        let moved = match task {
            Some(task) => {
                let mut moved = command(p, pace.law, situation, &task, period);
                let sup = situation.lifted.axle().other() as usize;
                moved.rates.roll[sup] += level;
                moved.rates.steering[sup] =
                    STEERING_GAIN * (self.held - situation.shape.steering[sup]);
                moved
            }
            None => self.drive(situation, inputs, level),
        };
        let (wheel, shaft) = (pace.wheel_limit, pace.shaft_limit);
        let shafts = |rates: [f32; 2]| rates.map(|rate| limit(rate, shaft));
        let pitch = pace.posture.rate(inputs.inclination[0]) - moved.rates.pitch;
        Outputs {
            wheels: moved
                .wheels
                .map(|speed| limit(speed / p.wheel_radius, wheel)),
            steering: shafts(moved.rates.steering),
            roll: shafts(moved.rates.roll),
            pitch_shaft: limit(pitch, shaft),
        }
    }

    /// Drives and steers with all four wheels on the ground and both arms equally loaded.
    fn drive(&self, situation: &Situation<f32>, inputs: &Inputs, level: f32) -> MotorCommand<f32> {
        let (p, pace, shape) = (&self.parameters, &self.pace, &situation.shape);
        let speed_scale = clamp(inputs.speed_scale, 0.0, 1.0);
        let targets = self.steering(situation, inputs.command);
        let steered = shape.is_steered(targets, 0.1);
        let speed = match self.stage {
            Stage::Skewing | Stage::Seeking if steered => speed_scale * pace.speed,
            Stage::Standing if steered => speed_scale * inputs.command.forward,
            Stage::Backing => -0.5 * speed_scale * pace.speed,
            _ => 0.0,
        };
        let mut rates = Shape::ZERO;
        rates.steering = [0, 1].map(|i: usize| {
            let wanted = STEERING_GAIN * (targets[i] - shape.steering[i]);
            limit(wanted, speed_scale * pace.steering_rate)
        });
        // Both arms together level the body; against each other they share its weight equally.
        let [front, rear] = inputs.roll_torques;
        let twist = yielding(0.0, 0.5 * (front - rear), pace.compliance);
        rates.roll = match self.stage {
            Stage::Stuck | Stage::Stranded => [0.0; 2],
            _ => [level + twist, level - twist],
        };
        let frame = Projection::new(p, shape);
        let straight = wheel_mode(
            &Frame {
                headings: frame.headings,
                half_widths: frame.half_widths,
                length: frame.length(),
            },
            speed,
        );
        let mut on_the_spot = Shape::ZERO;
        on_the_spot.steering = rates.steering;
        let mut wheels = straight.wheels;
        for wheel in WHEELS {
            let axle = wheel.axle();
            let arm = Arm::new(p, shape, axle);
            wheels[wheel as usize] += arm.motion(p, &on_the_spot, axle, wheel).rolling;
        }
        MotorCommand {
            rates,
            wheels,
            turning: straight.turning,
        }
    }
}
