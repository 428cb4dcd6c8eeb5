//! Tests RT-Mover's kinematics against motion: drives the paper's example step by step and checks
//! where the wheel is.

use proptest::prelude::*;
use tautrack::math::Scalar;
use tautrack::robots::rt_mover::gait::{Event, Stage, TABLE, next};
use tautrack::robots::rt_mover::lifting::{
    ArmAngles, ProjectedBody, SupportAxle, lift_step, steering_rate, support_axle,
};
use tautrack::robots::rt_mover::parameters::{LENGTHS, Lengths, MASSES, Masses};
use tautrack::robots::rt_mover::posture::{PostureControl, yielding};
use tautrack::robots::rt_mover::projection::{Projection, stand};
use tautrack::robots::rt_mover::support::{margin_without, static_margin};
use tautrack::robots::rt_mover::walk::{Gait, Inputs, Pace};
use tautrack::robots::rt_mover::wheel::{Arm, WHEELS};
use tautrack::robots::rt_mover::wheel_mode::{Frame, wheel_mode};
use tautrack::robots::rt_mover::{
    Axle, Law, Parameters, ParametersError, Shape, Situation, Task, Wheel, command,
};
use tautrack::stability::allowed::Command;

const DT: f64 = 0.01;

fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sine, cosine) = angle.sin_cos();
    [cosine * x - sine * y, sine * x + cosine * y]
}

/// Robot on three wheels on level ground. The lifted wheel's partner is pinned to the ground, and
/// the other axle's middle moves along that axle's heading. Positions come from the shape alone,
/// never from the law's own rates.
struct Pinned {
    parameters: Parameters<f64>,
    lifted: Wheel,
    shape: Shape<f64>,
    heading: f64,
    rates: Shape<f64>,
}

impl Pinned {
    fn new(lifted: Wheel, steering: [f64; 2]) -> Self {
        let parameters = Parameters::nominal();
        let shape = Shape {
            steering,
            ..Shape::ZERO
        };
        Self {
            shape: stand(&parameters, &shape, lifted),
            parameters,
            lifted,
            heading: 0.0,
            rates: Shape::ZERO,
        }
    }

    /// Positions of the lifted wheel (with its height) and of the other axle's middle from the
    /// pinned contact, along the axes of travel.
    fn places(&self, shape: &Shape<f64>, heading: f64) -> ([f64; 3], [f64; 2]) {
        let frame = Projection::new(&self.parameters, shape);
        let [x, y, z] = frame.contacts[self.lifted.partner() as usize];
        let from = |place: [f64; 3]| turned([place[0] - x, place[1] - y], heading);
        let lifted = frame.contacts[self.lifted as usize];
        let [along, ahead] = from(lifted);
        let middle = frame.middles[self.lifted.axle().other() as usize];
        ([along, ahead, lifted[2] - z], from(middle))
    }

    fn wheel(&self) -> [f64; 3] {
        self.places(&self.shape, self.heading).0
    }

    fn step<S: Scalar>(&mut self, law: Law, task: &Task<f64>) {
        let number = S::from_f64;
        let narrow = |shape: &Shape<f64>| Shape {
            pitch: number(shape.pitch),
            steering: shape.steering.map(number),
            roll: shape.roll.map(number),
        };
        let situation = Situation {
            shape: narrow(&self.shape),
            rates: narrow(&self.rates),
            heading: number(self.heading),
            lifted: self.lifted,
        };
        let told = match *task {
            Task::Vertical { roll_rate } => Task::Vertical {
                roll_rate: number(roll_rate),
            },
            Task::Swing { turning } => Task::Swing {
                turning: number(turning),
            },
        };
        let done = command(&Parameters::nominal(), law, &situation, &told, number(DT));
        let leg = self.lifted.axle() as usize;
        let mut next = self.shape;
        next.steering[leg] += done.rates.steering[leg].to_f64() * DT;
        next.roll[leg] += done.rates.roll[leg].to_f64() * DT;
        let next = stand(&self.parameters, &next, self.lifted);
        // Finds the heading at which the middle has not slipped sideways, by the secant method.
        let sup = self.lifted.axle().other() as usize;
        let (_, before) = self.places(&self.shape, self.heading);
        let axle = |shape: &Shape<f64>| Projection::new(&self.parameters, shape).headings[sup];
        let slip = |heading: f64| {
            let (_, after) = self.places(&next, heading);
            let direction = 0.5 * (axle(&self.shape) + self.heading + axle(&next) + heading);
            let (sine, cosine) = direction.sin_cos();
            (after[0] - before[0]) * cosine + (after[1] - before[1]) * sine
        };
        let (mut a, mut b) = (self.heading, self.heading + 1e-3);
        for _ in 0..20 {
            let (fa, fb) = (slip(a), slip(b));
            if (fb - fa).abs() < 1e-18 {
                break;
            }
            (a, b) = (b, b - fb * (b - a) / (fb - fa));
        }
        let rates = |now: [f64; 2], before: [f64; 2]| [0, 1].map(|i| (now[i] - before[i]) / DT);
        self.rates = Shape {
            pitch: (next.pitch - self.shape.pitch) / DT,
            steering: rates(next.steering, self.shape.steering),
            roll: rates(next.roll, self.shape.roll),
        };
        (self.shape, self.heading) = (next, b);
    }
}

/// Largest errors of y in the example of Fig. 7, m: while the wheel is lifted by 0.15 m, and while
/// it is landed after a swing of 0.15 m. For a wheel on either side, in front or behind.
fn figure_7<S: Scalar>(law: Law, lifted: Wheel) -> [f64; 2] {
    let mut robot = Pinned::new(lifted, [0.0; 2]);
    let mirror = if lifted.is_left() { 1.0 } else { -1.0 };
    let leg = lifted.axle() as usize;
    robot.shape.steering[leg] = 20.0_f64.to_radians() * mirror;
    // For a rear wheel, the supporting wheels must lie across in the other direction.
    let across = if lifted.axle() == Axle::Front {
        -30.0_f64
    } else {
        30.0
    };
    robot.shape.steering[1 - leg] = across.to_radians() * mirror;
    robot.shape = stand(&robot.parameters, &robot.shape, lifted);
    let vertical = |rate: f64| Task::Vertical {
        roll_rate: rate * mirror,
    };
    let mut worst = [0.0_f64; 2];
    let start = robot.wheel()[1];
    while robot.wheel()[2] < 0.15 {
        robot.step::<S>(law, &vertical(0.1));
        worst[0] = worst[0].max((robot.wheel()[1] - start).abs());
    }
    let lifted_y = robot.wheel()[1];
    while robot.wheel()[1] - lifted_y < 0.15 {
        robot.step::<S>(
            law,
            &Task::Swing {
                turning: -0.1 * mirror,
            },
        );
    }
    let (landing, height) = (robot.wheel()[1], robot.wheel()[2]);
    assert!(
        lifted.axle() == Axle::Rear || height > 0.16,
        "the body's pitch lifts it further: {height}"
    );
    while robot.wheel()[2] > 0.0 {
        robot.step::<S>(law, &vertical(-0.1));
        worst[1] = worst[1].max((robot.wheel()[1] - landing).abs());
    }
    worst
}

#[test]
fn figure_7_keeps_its_column_with_the_corrected_law_and_not_with_the_printed_one() {
    let all = [Law::Printed, Law::Corrected, Law::Exact];
    for lifted in [
        Wheel::FrontLeft,
        Wheel::FrontRight,
        Wheel::RearLeft,
        Wheel::RearRight,
    ] {
        for law in all {
            for (name, errors) in [
                ("f64", figure_7::<f64>(law, lifted)),
                ("f32", figure_7::<f32>(law, lifted)),
            ] {
                println!("{lifted:?} {law:?} {name}: {errors:.5?} m");
                let worst = errors[0].max(errors[1]);
                match law {
                    Law::Printed => assert!(worst > 0.007, "{errors:?}"),
                    Law::Corrected => assert!(worst <= 0.0015, "{errors:?}"),
                    Law::Exact => assert!(worst <= 0.0001, "{errors:?}"),
                }
            }
        }
    }
}

fn shape(values: [f64; 5]) -> Shape<f64> {
    let [pitch, a, b, c, d] = values;
    Shape {
        pitch,
        steering: [a, b],
        roll: [c, d],
    }
}

fn angles() -> impl Strategy<Value = [f64; 5]> {
    [-0.4..0.4, -0.6..0.6, -0.6..0.6, -0.5..0.5, -0.5..0.5]
}

proptest! {
    #[test]
    fn contacts_move_as_the_places_do(at in angles(), rates in angles()) {
        let parameters = Parameters::<f64>::nominal();
        let (at, rates) = (shape(at), shape(rates));
        let moved = |time: f64| Shape {
            pitch: at.pitch + rates.pitch * time,
            steering: [0, 1].map(|i| at.steering[i] + rates.steering[i] * time),
            roll: [0, 1].map(|i| at.roll[i] + rates.roll[i] * time),
        };
        for wheel in WHEELS {
            let axle = wheel.axle();
            let place = |time: f64| {
                Arm::new(&parameters, &moved(time), axle).contact(&parameters, wheel)
            };
            let motion = Arm::new(&parameters, &at, axle).motion(&parameters, &rates, axle, wheel);
            let (before, after) = (place(-1e-5), place(1e-5));
            for i in 0..3 {
                let slope = (after[i] - before[i]) / 2e-5;
                prop_assert!((motion.contact[i] - slope).abs() < 1e-8, "{slope} {motion:?}");
            }
        }
    }

    #[test]
    fn the_rim_rolls_as_its_own_points_move(at in angles(), rates in angles()) {
        // The arm carries the rim point at the ground along with the wheel at rest: eq. 2 with that
        // point's wheel angle.
        let parameters = Parameters::<f64>::nominal();
        let (at, rates) = (shape(at), shape(rates));
        let axle = Axle::Front;
        let arm = Arm::new(&parameters, &at, axle);
        let contact = arm.contact(&parameters, Wheel::FrontLeft);
        let hub = arm.hub(&parameters, Wheel::FrontLeft);
        let down: [f64; 3] = core::array::from_fn(|i| contact[i] - hub[i]);
        let along = |axis: [f64; 3]| (0..3).map(|i| axis[i] * down[i]).sum::<f64>();
        let angle = along(arm.frame.axes[1]).atan2(-along(arm.frame.axes[2]));
        let place = |time: f64| {
            let moved = Shape {
                pitch: at.pitch + rates.pitch * time,
                steering: [0, 1].map(|i| at.steering[i] + rates.steering[i] * time),
                roll: [0, 1].map(|i| at.roll[i] + rates.roll[i] * time),
            };
            Arm::new(&parameters, &moved, axle).rim(&parameters, Wheel::FrontLeft, angle).origin
        };
        let (before, after) = (place(-1e-5), place(1e-5));
        for (rim, lowest) in place(0.0).iter().zip(contact) {
            prop_assert!((rim - lowest).abs() < 1e-12);
        }
        let heading = arm.heading();
        let slope = [0, 1].map(|i| (after[i] - before[i]) / 2e-5);
        let forward = slope[1] * heading.cos() - slope[0] * heading.sin();
        let motion = arm.motion(&parameters, &rates, axle, Wheel::FrontLeft);
        prop_assert!((motion.rolling - forward).abs() < 1e-8, "{forward} {motion:?}");
    }

    #[test]
    fn in_wheel_mode_no_wheel_slips(
        leg in -0.52..0.52_f64, sup in -0.52..0.52_f64, widths in [0.2..0.3, 0.2..0.3], speed in -0.5..0.5
    ) {
        let frame = Frame { headings: [leg, sup], half_widths: widths, length: 0.6 };
        let motion = wheel_mode(&frame, speed);
        // The middle moves at the commanded speed along the mean of the headings' tangents; the
        // other points follow as those of a rigid body.
        let mean = 0.5 * (leg.tan() + sup.tan());
        let scale = speed / (1.0 + mean * mean).sqrt();
        for wheel in WHEELS {
            let (heading, y) = if wheel.axle() == Axle::Front { (leg, 0.3) } else { (sup, -0.3) };
            let arm = wheel.side::<f64>() * widths[wheel.axle() as usize];
            let (x, y) = (arm * heading.cos(), y + arm * heading.sin());
            let velocity = [-mean * scale - motion.turning * y, scale + motion.turning * x];
            let along = velocity[1] * heading.cos() - velocity[0] * heading.sin();
            let across = velocity[0] * heading.cos() + velocity[1] * heading.sin();
            prop_assert!(across.abs() < 1e-12, "{wheel:?} slips {across}");
            prop_assert!((along - motion.wheels[wheel as usize]).abs() < 1e-12);
        }
    }

    #[test]
    fn laws_stay_finite_in_any_shape(
        at in proptest::array::uniform5(-4.0..4.0), rates in proptest::array::uniform5(-4.0..4.0),
        heading in -4.0..4.0, wheel in 0_usize..4, rate in -1.0..1.0, swing in any::<bool>(),
    ) {
        let (at, rates) = (shape(at), shape(rates));
        let lifted = WHEELS[wheel];
        let situation = Situation { shape: at, rates, heading, lifted };
        let task = if swing { Task::Swing { turning: rate } } else { Task::Vertical { roll_rate: rate } };
        for law in [Law::Printed, Law::Corrected, Law::Exact] {
            let told = command(&Parameters::nominal(), law, &situation, &task, DT);
            let numbers = [told.rates.steering, told.rates.roll].concat();
            prop_assert!(numbers.iter().chain(&told.wheels).all(|x| x.is_finite()), "{told:?}");
        }
    }

    #[test]
    fn whatever_comes_in_the_outputs_stay_within_their_bounds(
        ticks in proptest::collection::vec(proptest::array::uniform24(any::<f32>()), 1..40)
    ) {
        let pace = Pace::nominal();
        let mut gait = Gait::new(Parameters::nominal(), pace);
        for (index, x) in ticks.iter().enumerate() {
            let inputs = Inputs {
                wheels: [x[0], x[1], x[2], x[3]], steering: [x[4], x[5]], roll: [x[6], x[7]],
                pitch_shaft: x[8], wheel_torques: [x[9], x[10], x[11], x[12]],
                roll_torques: [x[13], x[14]], inclination: [x[15], x[16]], heading: x[17],
                command: Command::new(x[18], x[19]), speed_scale: x[20],
            };
            if index == 1 { gait.ask(x[21], x[22]); }
            let out = gait.tick(&inputs, if index % 3 == 0 { 0.005 } else { x[23] });
            let shafts = [out.steering, out.roll, [out.pitch_shaft, 0.0]].concat();
            prop_assert!(out.wheels.iter().all(|rate| rate.abs() <= pace.wheel_limit), "{out:?}");
            prop_assert!(shafts.iter().all(|rate| rate.abs() <= pace.shaft_limit), "{out:?}");
        }
    }
}

#[test]
fn degenerate_cases_stand_still() {
    let straight = |headings: [f64; 2], length: f64| {
        wheel_mode(
            &Frame {
                headings,
                half_widths: [0.3; 2],
                length,
            },
            0.1,
        )
    };
    // Opposite angles are the tightest turn, not the straight course.
    let tightest = straight([-LENGTHS.steering_limit, LENGTHS.steering_limit], 0.6);
    let [x, y] = tightest.centre.unwrap();
    assert!((x - 0.5196).abs() < 1e-3 && y.abs() < 1e-9, "{tightest:?}");
    assert!(straight([0.3, 0.3], 0.6).centre.is_none());
    assert_eq!(straight([1.571, 0.0], 0.6).wheels, [0.0; 4]);
    assert_eq!(straight([0.1, 0.0], 0.0).wheels, [0.0; 4]);

    let still = lift_step(0.3, 0.29, 0.3, 0.0, true);
    assert_eq!((still.velocity, still.turning), ([0.0; 2], 0.0));
    // The arm has become shorter than the distance by which the wheel is ahead, so the wheel comes
    // as near as it can.
    assert!(lift_step(0.3, 0.1, 1.2, 0.01, true).turning.is_finite());
    let upright = ArmAngles {
        pitch: core::f64::consts::FRAC_PI_2,
        steering: 0.1,
        roll: 0.1,
    };
    assert_eq!(steering_rate(1.0, &upright, &upright), 0.0);
    let axle = SupportAxle {
        heading: 0.1,
        heading_rate: 0.0,
        half_width: 0.3,
    };
    let body = ProjectedBody {
        length: 0.0,
        length_rate: 0.0,
        offset: 0.0,
        offset_rate: 0.0,
    };
    assert_eq!(support_axle([0.1; 2], &body, &axle).wheels, [0.0; 2]);
    let line = static_margin(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]], [0.5, 0.1]);
    assert!(line < 0.0, "{line}");
}

#[test]
fn posture_control_is_the_papers_and_a_yielding_drive_rests_at_its_torque() {
    let control = PostureControl {
        gain: 400.0,
        damping: 80.0,
    };
    assert!((control.torque(0.1_f64, -0.5)).abs() < 1e-12);
    assert!((control.rate(0.1_f64) + 0.5).abs() < 1e-12);
    assert_eq!(
        PostureControl {
            gain: 1.0,
            damping: 0.0
        }
        .rate(1.0),
        0.0
    );
    assert_eq!(yielding(5.0, 5.0, 100.0), 0.0);
    assert_eq!(yielding(5.0, 1.0, 0.0), 0.0);
}

#[test]
fn parameters_that_no_robot_can_have_are_refused() {
    let bad = Lengths {
        wheel_radius: f64::NAN,
        ..LENGTHS
    };
    assert!(matches!(
        Parameters::<f32>::new(&bad, &MASSES),
        Err(ParametersError::OutOfRange {
            name: "wheel radius",
            ..
        })
    ));
    let wide = Lengths {
        steering_limit: 1.5,
        ..LENGTHS
    };
    assert!(Parameters::<f32>::new(&wide, &MASSES).is_err());
    let light = Masses {
        wheel: 0.0,
        ..MASSES
    };
    assert!(Parameters::<f32>::new(&LENGTHS, &light).is_err());
    assert!((MASSES.total() - 28.0).abs() < 1e-12);
    assert!(Parameters::<f32>::new(&LENGTHS, &MASSES).is_ok());
}

#[test]
fn widening_the_support_is_what_makes_room_for_a_lifted_wheel() {
    let parameters = Parameters::<f64>::nominal();
    let margin = |rear: f64| {
        let at = shape([0.0, 0.0, rear, 0.0, 0.0]);
        margin_without(&parameters, &at, Wheel::FrontLeft)
    };
    let limit = LENGTHS.steering_limit;
    // With straight steering, three wheels of a square have the middle on an edge, and the load in
    // front of it tips the robot.
    assert!(margin(0.0) < 0.0 && margin(limit) < margin(0.0) && margin(-limit) > 0.03);
}

#[test]
fn only_an_allowed_step_lifts_a_wheel_and_every_moving_stage_ends() {
    for (from, event, to) in TABLE {
        assert_eq!(next(from, event), to);
        assert_eq!(to == Stage::Lifting, event == Event::Allowed);
        assert!(to != Stage::Swinging || from == Stage::Lifting);
        // From a stage with a wheel in the air, every transition leads to another such stage, until
        // the ground carries the wheel. Aborting a gait keeps whether a wheel may be in the air.
        if from.lifts() && from != Stage::Settling {
            assert!(to.lifts(), "{from:?} {event:?} {to:?}");
        }
        if matches!(event, Event::GivenUp | Event::Airborne) {
            assert_eq!(from.lifts(), to.lifts());
        }
    }
    let rows = TABLE
        .iter()
        .map(|(from, event, _)| (*from as u8, *event as u8));
    assert_eq!(
        rows.clone()
            .collect::<std::collections::BTreeSet<_>>()
            .len(),
        rows.count()
    );
    for stage in [
        Stage::Skewing,
        Stage::Seeking,
        Stage::Backing,
        Stage::Widening,
        Stage::Lifting,
        Stage::Swinging,
        Stage::Landing,
        Stage::Straightening,
    ] {
        assert_ne!(next(stage, Event::Late), stage, "{stage:?} waits for ever");
    }
    assert_eq!(next(Stage::Stuck, Event::Commanded), Stage::Stuck);
}
