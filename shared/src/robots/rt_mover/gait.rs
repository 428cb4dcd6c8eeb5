//! The step-up gait (Nakajima, Fig. 3): one wheel after the other onto the step, front left, front right, rear left, rear right.
//!
//! What follows what is [`TABLE`]; what a stage does is one arm of `Gait::act`; when it is over is one of `Gait::event`.

use super::command::{Command, Law, Situation, Task, command};
use super::parameters::Parameters;
use super::posture::{PostureControl, yielding};
use super::projection::Projection;
use super::rehearsal::{Way, reach, rehearse};
use super::support::margin_without;
use super::wheel::{Arm, Axle, Shape, WHEELS, Wheel};
use super::wheel_mode::{Frame, wheel_mode};
use crate::math::{limit, max, min};

/// What the robot is doing.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Stage {
    /// Standing; posture is held.
    #[default]
    Standing,
    /// Turning the body askew, by which all four steps keep a margin alike.
    Skewing,
    /// Driving straight at the step, the next axle parallel to it, until its wheels feel it.
    Seeking,
    /// Driving back to where a wheel has room to rise.
    Backing,
    /// Steering the other axle to its limit, which widens the support.
    Widening,
    /// Lifting a wheel.
    Lifting,
    /// Swinging it over the step.
    Swinging,
    /// Letting it down until it feels the ground.
    Landing,
    /// Letting the load spread over four wheels.
    Settling,
    /// Steering straight again.
    Straightening,
    /// All four wheels are on the step.
    Arrived,
    /// Something did not go as it should; all four wheels are on the ground, or the robot holds still.
    Stuck,
}

/// What ends a stage.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Event {
    /// The operator asks for the step.
    Asked,
    /// The stage's goal is reached.
    Reached,
    /// As that, and the margin allows the step that follows.
    Allowed,
    /// As that, and the margin does not.
    Refused,
    /// With a wheel in the air, the margin has become too small.
    Unsafe,
    /// The axle's second wheel is next.
    Partner,
    /// The other axle is next.
    OtherAxle,
    /// No wheel is left.
    Last,
    /// The stage takes too long.
    Late,
}

/// From a stage, on an event, to the next stage. No other way leads anywhere; in particular only [`Event::Allowed`] lifts a wheel.
pub const TABLE: [(Stage, Event, Stage); 23] = [
    (Stage::Standing, Event::Asked, Stage::Skewing),
    (Stage::Skewing, Event::Reached, Stage::Seeking),
    (Stage::Skewing, Event::Late, Stage::Stuck),
    (Stage::Seeking, Event::Reached, Stage::Backing),
    (Stage::Seeking, Event::Late, Stage::Stuck),
    (Stage::Backing, Event::Reached, Stage::Widening),
    (Stage::Backing, Event::Late, Stage::Stuck),
    (Stage::Widening, Event::Allowed, Stage::Lifting),
    (Stage::Widening, Event::Refused, Stage::Stuck),
    (Stage::Widening, Event::Late, Stage::Stuck),
    (Stage::Lifting, Event::Reached, Stage::Swinging),
    (Stage::Lifting, Event::Unsafe, Stage::Landing),
    (Stage::Lifting, Event::Late, Stage::Landing),
    (Stage::Swinging, Event::Reached, Stage::Landing),
    (Stage::Swinging, Event::Unsafe, Stage::Landing),
    (Stage::Swinging, Event::Late, Stage::Landing),
    (Stage::Landing, Event::Reached, Stage::Settling),
    (Stage::Landing, Event::Late, Stage::Stuck),
    (Stage::Settling, Event::Partner, Stage::Widening),
    (Stage::Settling, Event::OtherAxle, Stage::Seeking),
    (Stage::Settling, Event::Last, Stage::Straightening),
    (Stage::Settling, Event::Refused, Stage::Stuck),
    (Stage::Straightening, Event::Reached, Stage::Arrived),
];

/// Where `stage` goes on `event`; itself if the table has nothing.
pub fn next(stage: Stage, event: Event) -> Stage {
    TABLE
        .iter()
        .find(|(from, on, _)| (*from, *on) == (stage, event))
        .map_or(stage, |(_, _, to)| *to)
}

/// What the shafts and the seat say, once per tick. Arrays by [`Wheel`] or [`Axle`].
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Inputs {
    /// Angles of the wheels, forward, rad; any zero, and they may wrap at 2^16 rad or never.
    pub wheels: [f32; 4],
    /// Angles of the steering shafts, rad.
    pub steering: [f32; 2],
    /// Angles of the roll shafts, rad.
    pub roll: [f32; 2],
    /// Angle of the pitch shaft: the seat against the body, front up, rad.
    pub pitch_shaft: f32,
    /// Torques of the wheels, forward, N m.
    pub wheel_torques: [f32; 4],
    /// Torques of the roll shafts on their arms, N m.
    pub roll_torques: [f32; 2],
    /// Inclination of the seat: pitch, front up, and roll, left up, rad.
    pub inclination: [f32; 2],
    /// Heading, counter-clockwise, rad; what it is when the gait starts counts as straight at the step.
    pub heading: f32,
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

/// How the gait is walked.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Pace {
    /// Law of the lifted wheel.
    pub law: Law,
    /// Speed of driving, m/s.
    pub speed: f32,
    /// Rates of steering on the spot, of lifting, of swinging and of landing, rad/s.
    pub rates: [f32; 4],
    /// Angle askew, rad.
    pub skew: f32,
    /// Room between wheel and step when it rises, between wheel and edge when it stands on it, and over it in between, m.
    pub clearance: [f32; 3],
    /// Torque of the wheels at which the step is felt, N m.
    pub blocked_torque: f32,
    /// Part of the airborne torque below which a landing wheel has touched.
    pub touched_share: f32,
    /// Least margin that a step may come to in rehearsal, and at which a wheel in the air goes down, m.
    pub margins: [f32; 2],
    /// Posture control.
    pub posture: PostureControl<f32>,
    /// Torque difference of the roll shafts that turns them against each other at 1 rad/s, N m s/rad.
    pub compliance: f32,
    /// Longest time of a stage, s.
    pub patience: f32,
}

impl Pace {
    /// A careful walk.
    pub fn nominal() -> Self {
        Self {
            law: Law::Exact,
            speed: 0.06,
            rates: [0.3, 0.1, 0.1, 0.06],
            skew: -0.14,
            clearance: [0.025, 0.03, 0.03],
            blocked_torque: 2.5,
            touched_share: 0.6,
            margins: [0.010, 0.004],
            posture: PostureControl {
                gain: 400.0,
                damping: 80.0,
            },
            compliance: 800.0,
            patience: 30.0,
        }
    }
}

/// A steered shaft is where it should be within this, rad.
const STEERED: f32 = 0.01;
/// Gain towards a steering angle, 1/s.
const STEERING_GAIN: f32 = 5.0;
/// Time for which a torque must be felt, and for which the load spreads, s.
const FELT: f32 = 0.03;
const SETTLED: f32 = 0.6;
/// Steering with which the body is turned askew, rad.
const TURNING: f32 = 0.35;
/// Share of a roll rate that the soft start leaves in its first tick; the rest comes within a tenth of a second.
const SOFT: f32 = 0.1;

/// The order of the steps.
pub const ORDER: [Wheel; 4] = WHEELS;

/// The gait's state.
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
    /// Height over its partner and distance ahead of it from which the wheel began, and its roll shaft's torque in the air.
    begun: [f32; 2],
    airborne_torque: f32,
    /// Where the supporting steering shaft is held meanwhile, rad.
    held: f32,
    before: Option<(Shape<f32>, [f32; 4])>,
    margin: f32,
}

impl Gait {
    /// A robot that stands.
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
            held: 0.0,
            before: None,
            margin: 0.0,
        }
    }

    /// Starts the gait up a step of `height`, m; the robot's present heading is straight at it. Ignored unless the robot stands.
    pub fn ask(&mut self, height: f32, heading: f32) {
        if self.stage == Stage::Standing && height > 0.0 {
            (self.step, self.aborted) = (0, false);
            (self.step_height, self.straight) = (height, heading);
            self.enter(next(self.stage, Event::Asked));
        }
    }

    /// What the robot is doing.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// The wheel whose turn it is.
    pub fn wheel(&self) -> Wheel {
        ORDER[if self.step < 4 { self.step } else { 3 }]
    }

    /// The wheel that is in the air by command, if any.
    pub fn lifted(&self) -> Option<Wheel> {
        matches!(
            self.stage,
            Stage::Lifting | Stage::Swinging | Stage::Landing
        )
        .then(|| self.wheel())
    }

    /// Static margin without the wheel whose turn it is, m.
    pub fn margin(&self) -> f32 {
        self.margin
    }

    fn enter(&mut self, stage: Stage) {
        self.stage = stage;
        (self.since, self.felt, self.way) = (0.0, 0.0, 0.0);
    }

    /// One tick of `period`, s.
    pub fn tick(&mut self, inputs: &Inputs, period: f32) -> Outputs {
        let shape = Shape {
            pitch: inputs.inclination[0] - inputs.pitch_shaft,
            steering: inputs.steering,
            roll: inputs.roll,
        };
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
        if let Some(event) = self.event(&situation, inputs, period) {
            let stage = next(self.stage, event);
            if stage != self.stage {
                self.leave(event, &situation);
                self.enter(stage);
            }
        }
        self.act(&situation, inputs, period)
    }

    /// What has to be remembered when a stage ends.
    fn leave(&mut self, event: Event, situation: &Situation<f32>) {
        match (self.stage, event) {
            (Stage::Widening, _) => {
                let sup = situation.lifted.axle().other() as usize;
                self.held = self.steering(situation)[sup];
                self.begun = reach(
                    &self.parameters,
                    &situation.shape,
                    situation.heading,
                    situation.lifted,
                );
            }
            (Stage::Lifting | Stage::Swinging, Event::Unsafe | Event::Late) => self.aborted = true,
            (Stage::Settling, _) => self.step += 1,
            _ => {}
        }
    }

    fn event(&mut self, situation: &Situation<f32>, inputs: &Inputs, period: f32) -> Option<Event> {
        let (p, pace) = (&self.parameters, &self.pace);
        let (leg, lifted) = (situation.lifted.axle(), situation.lifted);
        let reached = |reached: bool| reached.then_some(Event::Reached);
        let steered = |targets: [f32; 2]| {
            (0..2).all(|i| (targets[i] - situation.shape.steering[i]).abs() < STEERED)
        };
        if self.since > pace.patience {
            return Some(Event::Late);
        }
        match self.stage {
            Stage::Standing | Stage::Arrived | Stage::Stuck => None,
            Stage::Skewing => reached((situation.heading - pace.skew) * pace.skew.signum() >= 0.0),
            Stage::Seeking => {
                let torque = leg
                    .wheels()
                    .map(|wheel| inputs.wheel_torques[wheel as usize]);
                let blocked = min(torque[0], torque[1]) > pace.blocked_torque
                    && steered(self.steering(situation));
                self.felt = if blocked { self.felt + period } else { 0.0 };
                reached(self.felt > FELT)
            }
            Stage::Backing => reached(self.way <= -pace.clearance[0]),
            Stage::Widening => steered(self.steering(situation)).then(|| {
                let way = Way {
                    rise: self.step_height + pace.clearance[2],
                    travel: self.travel(),
                    fall: pace.clearance[2],
                };
                let least = rehearse(p, &situation.shape, situation.heading, lifted, &way);
                // NaN must not lift a wheel.
                match least {
                    Some(end)
                        if end.margin >= pace.margins[0] && end.steering < p.steering_limit =>
                    {
                        Event::Allowed
                    }
                    _ => Event::Refused,
                }
            }),
            Stage::Lifting | Stage::Swinging if !(self.margin >= pace.margins[1]) => {
                Some(Event::Unsafe)
            }
            Stage::Lifting => {
                let [height, _] = reach(p, &situation.shape, situation.heading, lifted);
                reached(height - self.begun[0] >= self.step_height + pace.clearance[2])
            }
            Stage::Swinging => {
                let [_, ahead] = reach(p, &situation.shape, situation.heading, lifted);
                self.airborne_torque = inputs.roll_torques[leg as usize].abs();
                reached(ahead - self.begun[1] >= self.travel())
            }
            Stage::Landing => {
                let torque = -lifted.side::<f32>() * inputs.roll_torques[leg as usize];
                let touched = torque < pace.touched_share * self.airborne_torque;
                self.felt = if touched { self.felt + period } else { 0.0 };
                reached(self.felt > FELT)
            }
            Stage::Settling => (self.since > SETTLED).then_some(if self.aborted {
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

    /// How far a wheel goes forward in a step, m.
    fn travel(&self) -> f32 {
        self.parameters.wheel_radius + self.pace.clearance[0] + self.pace.clearance[1]
    }

    /// Where the steering shafts shall be in this stage, rad.
    fn steering(&self, situation: &Situation<f32>) -> [f32; 2] {
        let (leg, bound) = (situation.lifted.axle(), self.parameters.steering_limit);
        match self.stage {
            Stage::Skewing => {
                let turn = self.pace.skew.signum() * TURNING;
                [turn, -turn]
            }
            // Both axles across the direction of travel: the body goes crabwise, the axles are parallel to the step.
            Stage::Seeking | Stage::Backing => [limit(-situation.heading, bound); 2],
            Stage::Widening => {
                let mut targets = situation.shape.steering;
                // The supporting axle's wheel opposite the lifted one comes nearer to it.
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
        let soft = min(1.0, SOFT + self.since / 0.1);
        let up = -situation.lifted.side::<f32>();
        let task = match self.stage {
            Stage::Lifting => Some(Task::Vertical {
                roll_rate: up * pace.rates[1] * soft,
            }),
            Stage::Swinging => Some(Task::Swing {
                turning: -up * pace.rates[2] * soft,
            }),
            Stage::Landing => Some(Task::Vertical {
                roll_rate: -up * pace.rates[3] * soft,
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
        Outputs {
            wheels: moved.wheels.map(|speed| speed / p.wheel_radius),
            steering: moved.rates.steering,
            roll: moved.rates.roll,
            pitch_shaft: pace.posture.rate(inputs.inclination[0]) - moved.rates.pitch,
        }
    }

    /// All four wheels on the ground: drives and steers, the arms equally loaded.
    fn drive(&self, situation: &Situation<f32>, inputs: &Inputs, level: f32) -> Command<f32> {
        let (p, pace, shape) = (&self.parameters, &self.pace, &situation.shape);
        let targets = self.steering(situation);
        let steered = (0..2).all(|i| (targets[i] - shape.steering[i]).abs() < 0.1);
        let speed = match self.stage {
            Stage::Skewing | Stage::Seeking if steered => pace.speed,
            Stage::Backing => -0.5 * pace.speed,
            _ => 0.0,
        };
        let mut rates = Shape::ZERO;
        for i in 0..2 {
            let wanted = STEERING_GAIN * (targets[i] - shape.steering[i]);
            rates.steering[i] = limit(wanted, pace.rates[0]);
        }
        // Both arms together level the body; against each other they share its weight.
        let [front, rear] = inputs.roll_torques;
        let share = yielding(0.0, 0.5 * (front - rear), pace.compliance);
        rates.roll = match self.stage {
            Stage::Stuck => [0.0; 2],
            _ => [level + share, level - share],
        };
        let frame = Projection::new(p, shape);
        let straight = wheel_mode(
            &Frame {
                headings: frame.headings,
                half_widths: frame.half_widths,
                length: max(frame.length(), 0.0),
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
        Command {
            rates,
            wheels,
            turning: straight.turning,
        }
    }
}
