//! RT-Mover's kinematics against motion: the paper's example is driven step by step, and the wheel is where it should be.

use tautrack::math::Scalar;
use tautrack::robots::rt_mover::projection::{Projection, stand};
use tautrack::robots::rt_mover::{Axle, Law, Parameters, Shape, Situation, Task, Wheel, command};

const DT: f64 = 0.01;

fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sine, cosine) = angle.sin_cos();
    [cosine * x - sine * y, sine * x + cosine * y]
}

/// The robot on three wheels on level ground: the lifted wheel's partner is pinned to the ground, and the other axle's middle
/// moves along that axle's heading. Positions come from the shape alone, never from the law's own rates.
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

    /// Lifted wheel (with its height) and the other axle's middle from the pinned contact, along the axes of travel.
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
        // The heading at which the middle has not slipped sideways, by secants.
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

/// Largest errors of y while the wheel is lifted by 0.15 m and landed again, after a swing of 0.15 m: Fig. 7's example, m. Mirrored or not,
/// in front or behind.
fn figure_7<S: Scalar>(law: Law, lifted: Wheel) -> [f64; 2] {
    let mut robot = Pinned::new(lifted, [0.0; 2]);
    let mirror = if lifted.is_left() { 1.0 } else { -1.0 };
    let leg = lifted.axle() as usize;
    robot.shape.steering[leg] = 20.0_f64.to_radians() * mirror;
    // Behind, the supporting wheels must lie across the other way.
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
