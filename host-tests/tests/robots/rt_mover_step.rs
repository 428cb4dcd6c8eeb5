//! Tests of RT-Mover stepping up in the physics: gait and plant, connected by ideal motors.

use crate::stamp;
use core::f64::consts::TAU;
use tautrack::link::Shaft;
use tautrack::robots::rt_mover::gait::Stage;
use tautrack::robots::rt_mover::parameters::{LENGTHS, MASSES, Masses};
use tautrack::robots::rt_mover::support::static_margin;
use tautrack::robots::rt_mover::walk::{Gait, Inputs, Outputs, Pace};
use tautrack::robots::rt_mover::{Law, Parameters, Wheel};
use tautrack::stability::allowed::Command;
use tautrack_host_tests::robots::rt_mover::plant::{MOTORS, RtMover, RtMoverParameters};
use tautrack_host_tests::world::Plant;
use tautrack_host_tests::world::ground::Ground;

const DT: f64 = 1.0e-3;
/// Steps of the physics per step of the gait, which runs at 200 Hz.
const TICK: u32 = 5;
const FRONT_X: f64 = 1.0;
const LIMITS: [f64; 3] = [12.0, 120.0, 60.0];

/// Rotor with its gear, seen from the output shaft. Its velocity servo also corrects the position
/// error, as far as its torque allows.
#[derive(Clone, Copy)]
struct Rotor {
    inertia: f64,
    frequency: f64,
    limit: f64,
    angle: f64,
    rate: f64,
    wanted: f64,
    torque: f64,
}

impl Rotor {
    fn new(motor: usize) -> Self {
        let (inertia, limit) = match motor {
            0..4 => (0.05, LIMITS[0]),
            6..8 => (0.3, LIMITS[1]),
            _ => (0.3, LIMITS[2]),
        };
        Self {
            inertia,
            frequency: 60.0,
            limit,
            angle: 0.0,
            rate: 0.0,
            wanted: 0.0,
            torque: 0.0,
        }
    }

    fn step(&mut self, rate: f64, load: f64) -> Shaft {
        self.torque = 0.0;
        for _ in 0..10 {
            self.wanted += rate * (DT / 10.0);
            let asked = self.inertia
                * self.frequency
                * (self.frequency * (self.wanted - self.angle) + 2.0 * (rate - self.rate));
            let torque = asked.clamp(-self.limit, self.limit);
            if torque != asked {
                // When the torque saturates, the servo drops the position error that it cannot
                // correct.
                self.wanted = self.angle
                    + (torque / (self.inertia * self.frequency) - 2.0 * (rate - self.rate))
                        / self.frequency;
            }
            self.rate += (torque - load) / self.inertia * (DT / 10.0);
            self.angle += self.rate * (DT / 10.0);
            self.torque += 0.1 * torque;
        }
        Shaft {
            position: (self.angle / TAU * 4_294_967_296.0) as i64,
            velocity: self.rate as f32,
        }
    }
}

/// Result of a walk.
#[derive(Debug, Default)]
struct Walk {
    stage: Stage,
    seconds: f64,
    /// Maximum error of the lifted wheel along the direction of travel while it moves up or down,
    /// per wheel, m.
    column: [f64; 4],
    /// Minimum margin while a wheel is in the air, per wheel, m.
    margin: [f64; 4],
    /// Maximum tilt of the seat outside and during touch-downs, rad.
    tilt: [f64; 2],
    heights: [f64; 4],
    toppled: bool,
    /// Number of times that a wheel began to leave the ground.
    lifts: u32,
}

/// Time after a wheel comes down that counts as its touch-down, s.
const TOUCH_DOWN: f64 = 0.5;

/// Runs one gait up a step of `height` (m) with the given model and pace. The measured inclination
/// of the seat has a lag of `lag` (s).
fn walk(height: f64, model: Parameters<f32>, pace: Pace, lag: f64) -> Walk {
    walk_until(height, model, pace, lag, None)
}

/// Runs the same gait. If `given_up` is set, the gait is aborted a second after this stage begins,
/// and this is acknowledged a second later.
fn walk_until(
    height: f64,
    model: Parameters<f32>,
    pace: Pace,
    lag: f64,
    given_up: Option<Stage>,
) -> Walk {
    let mut since = 0;
    let mut plant = RtMover::new(
        &RtMoverParameters::nominal(),
        &Ground::Curb {
            height,
            front_x: FRONT_X,
            depth: 5.0,
        },
        1,
    );
    let mut gait = Gait::new(model, pace);
    let mut rotors: [Rotor; MOTORS] = core::array::from_fn(Rotor::new);
    let mut rates = [0.0_f64; MOTORS];
    let mut walk = Walk {
        margin: [f64::MAX; 4],
        ..Walk::default()
    };
    let mut column = None;
    let mut inclination = [0.0; 2];
    let mut touched = f64::MIN;
    for step in 0..150_000_u32 {
        let seconds = f64::from(step) * DT;
        if step == 500 {
            gait.ask(height as f32, plant.truth().yaw as f32);
        }
        if given_up == Some(gait.stage()) || since > 0 {
            since += 1;
            match since {
                1_000 => gait.hold(),
                2_000 => gait.acknowledge(),
                _ => {}
            }
        }
        if step.is_multiple_of(TICK) {
            let before = gait.stage();
            let inputs = felt(&plant, &rotors, inclination);
            let out = gait.tick(&inputs, (f64::from(TICK) * DT) as f32);
            rates = motors(&out);
            let t = plant.truth();
            if gait.stage() != before {
                println!(
                    "{seconds:7.3} {:?} {:?} margin {:.4} x {:.3} yaw {:.3} seat {:.4?} loads {:.0?}",
                    gait.stage(),
                    gait.wheel(),
                    gait.margin(),
                    t.points[6][0],
                    t.yaw,
                    [t.pitch, t.roll],
                    plant.loads()
                );
                walk.lifts += u32::from(gait.stage() == Stage::Lifting);
                column = None;
                if before == Stage::Landing {
                    touched = seconds;
                }
            }
            if matches!(gait.stage(), Stage::Arrived | Stage::Stuck) && seconds > touched + 2.0 {
                break;
            }
        }
        let shafts: [_; MOTORS] = core::array::from_fn(|motor| {
            let load = f64::from(plant.sensors(motor).shaft_torque);
            Some(rotors[motor].step(rates[motor], load))
        });
        plant.step(&shafts);
        let t = plant.truth();
        for (felt, angle) in inclination.iter_mut().zip([t.pitch, t.roll]) {
            *felt += (angle - *felt) * (DT / (lag + DT));
        }
        walk.seconds = seconds;
        if let Some(lifted) = gait.lifted() {
            let wheel = lifted as usize;
            if plant.loads()[wheel] == 0.0 {
                if gait.stage() != Stage::Swinging {
                    let x = plant.wheels()[wheel][0];
                    let from = *column.get_or_insert(x);
                    walk.column[wheel] = walk.column[wheel].max((x - from).abs());
                }
                walk.margin[wheel] = walk.margin[wheel].min(margin(&plant, lifted));
            }
        }
        let transient =
            seconds < 0.5 || gait.stage() == Stage::Landing || seconds < touched + TOUCH_DOWN;
        let tilt = t.pitch.abs().max(t.roll.abs());
        let slot = &mut walk.tilt[usize::from(transient)];
        *slot = slot.max(tilt);
    }
    walk.stage = gait.stage();
    walk.heights = plant.wheels().map(|wheel| wheel[2]);
    walk.toppled = plant.truth().toppled;
    walk.margin = walk.margin.map(|margin| margin.min(9.0));
    println!("{height}: {walk:.4?}");
    walk
}

fn margin(plant: &RtMover, lifted: Wheel) -> f64 {
    let around = [
        Wheel::RearRight,
        Wheel::FrontRight,
        Wheel::FrontLeft,
        Wheel::RearLeft,
    ];
    let at = around.iter().position(|wheel| *wheel == lifted).unwrap();
    let supports = [1, 2, 3].map(|next| {
        let [x, y, _] = plant.wheels()[around[(at + next) % 4] as usize];
        [x, y]
    });
    let cog = plant.truth().cog;
    static_margin(&supports, [cog[0], cog[1]])
}

/// Inputs of the gait: angles and torques of the rotors, the inclination, and the true heading.
fn felt(plant: &RtMover, rotors: &[Rotor; MOTORS], inclination: [f64; 2]) -> Inputs {
    let angle = |motor: usize| rotors[motor].angle as f32;
    let torque = |motor: usize| rotors[motor].torque as f32;
    Inputs {
        wheels: [0, 1, 2, 3].map(angle),
        steering: [4, 5].map(angle),
        roll: [6, 7].map(angle),
        pitch_shaft: angle(8),
        wheel_torques: [0, 1, 2, 3].map(torque),
        roll_torques: [6, 7].map(torque),
        inclination: inclination.map(|angle| angle as f32),
        heading: plant.truth().yaw as f32,
        command: Command::default(),
        speed_scale: 1.0,
    }
}

fn motors(out: &Outputs) -> [f64; MOTORS] {
    let mut all = [0.0; MOTORS];
    all[..4].copy_from_slice(&out.wheels.map(f64::from));
    all[4..6].copy_from_slice(&out.steering.map(f64::from));
    all[6..8].copy_from_slice(&out.roll.map(f64::from));
    all[8] = f64::from(out.pitch_shaft);
    all
}

#[test]
fn the_robot_at_rest_weighs_what_it_weighs_and_stands_level() {
    let mut plant = RtMover::new(&RtMoverParameters::nominal(), &Ground::Flat, 1);
    let mut rotors: [Rotor; MOTORS] = core::array::from_fn(Rotor::new);
    for _ in 0..1000 {
        let shafts: [_; MOTORS] = core::array::from_fn(|motor| {
            let load = f64::from(plant.sensors(motor).shaft_torque);
            Some(rotors[motor].step(0.0, load))
        });
        plant.step(&shafts);
    }
    let loads: f64 = plant.loads().iter().sum();
    assert!((loads / plant.weight() - 1.0).abs() < 0.01, "{loads}");
    assert!(plant.truth().pitch.abs() < 0.01 && plant.truth().roll.abs() < 0.01);
}

/// Asserts the goals of the gait: column within 5 mm, positive margin, seat within 2 degrees.
fn steps_up(height: f64, lag: f64) {
    let walk = walk(height, Parameters::nominal(), Pace::nominal(), lag);
    assert_eq!(walk.stage, Stage::Arrived);
    assert!(!walk.toppled);
    for wheel in 0..4 {
        assert!((walk.heights[wheel] - height).abs() < 0.005, "{walk:?}");
        assert!(walk.column[wheel] <= 0.005, "{walk:?}");
        assert!(walk.margin[wheel] > 0.0, "{walk:?}");
    }
    assert!(walk.tilt[0] < 2.0_f64.to_radians(), "{walk:?}");
}

#[test]
fn the_gait_steps_up_ten_centimetres() {
    let Some(_stamp) = stamp("the_gait_steps_up_ten_centimetres") else {
        return;
    };
    steps_up(0.10, 0.0);
}

#[test]
fn the_gait_steps_up_fifteen_centimetres() {
    let Some(_stamp) = stamp("the_gait_steps_up_fifteen_centimetres") else {
        return;
    };
    steps_up(0.15, 0.0);
}

#[test]
fn the_gait_steps_up_twenty_centimetres() {
    let Some(_stamp) = stamp("the_gait_steps_up_twenty_centimetres") else {
        return;
    };
    steps_up(0.20, 0.0);
}

#[test]
fn a_late_inclination_spoils_no_step() {
    let Some(_stamp) = stamp("a_late_inclination_spoils_no_step") else {
        return;
    };
    steps_up(0.15, 0.05);
}

#[test]
fn no_wheel_leaves_the_ground_when_the_margin_does_not_allow_it() {
    // The controller's model has a heavy load above the rear.
    let heavy = Masses {
        seat_forward: 0.0,
        seat: 20.0,
        ..MASSES
    };
    let pace = Pace {
        predicted_margin: 0.060,
        ..Pace::nominal()
    };
    let model = Parameters::new(&LENGTHS, &heavy).unwrap();
    let walk = walk(0.10, model, pace, 0.0);
    assert_eq!(
        (walk.stage, walk.lifts, walk.toppled),
        (Stage::Stuck, 0, false)
    );
    assert!(walk.heights.iter().all(|height| height.abs() < 0.002));
}

#[test]
fn a_wheel_in_the_air_goes_down_again_when_the_margin_shrinks() {
    // The prediction allows the step, but the minimum margin in the air is above the one reached in
    // the swing.
    let pace = Pace {
        lowering_margin: 0.048,
        ..Pace::nominal()
    };
    let walk = walk(0.10, Parameters::nominal(), pace, 0.0);
    assert_eq!(
        (walk.stage, walk.lifts, walk.toppled),
        (Stage::Stuck, 1, false)
    );
    // The wheel was in the air, and the margin was always positive.
    assert!((0.030..0.060).contains(&walk.margin[0]), "{walk:?}");
}

#[test]
fn a_gait_given_up_with_a_wheel_in_the_air_lets_it_down_when_acknowledged() {
    let Some(_stamp) =
        stamp("a_gait_given_up_with_a_wheel_in_the_air_lets_it_down_when_acknowledged")
    else {
        return;
    };
    for stage in [Stage::Lifting, Stage::Swinging] {
        let (model, pace) = (Parameters::nominal(), Pace::nominal());
        let walk = walk_until(0.10, model, pace, 0.0, Some(stage));
        assert_eq!(
            (walk.stage, walk.lifts, walk.toppled),
            (Stage::Stuck, 1, false)
        );
        assert!(
            walk.heights.iter().all(|height| *height < 0.102),
            "{walk:?}"
        );
        assert!(walk.seconds < 60.0, "{walk:?}");
    }
}

#[test]
fn the_printed_law_leaves_its_column_in_the_physics_too() {
    let Some(_stamp) = stamp("the_printed_law_leaves_its_column_in_the_physics_too") else {
        return;
    };
    let pace = |law| Pace {
        law,
        ..Pace::nominal()
    };
    let [printed, exact] = [Law::Printed, Law::Exact]
        .map(|law| walk(0.10, Parameters::nominal(), pace(law), 0.0).column[0]);
    assert!(printed > 2.0 * exact, "{printed} {exact}");
}

#[test]
fn a_walk_ends_in_the_same_bits_every_time() {
    let run = || {
        let parameters = RtMoverParameters::nominal();
        let mut plant = RtMover::new(&parameters, &Ground::Flat, 1);
        let mut rotors: [Rotor; MOTORS] = core::array::from_fn(Rotor::new);
        for step in 0..500 {
            let rate = if step < 250 { 0.3 } else { -0.2 };
            let shafts: [_; MOTORS] = core::array::from_fn(|motor| {
                let load = f64::from(plant.sensors(motor).shaft_torque);
                Some(rotors[motor].step(rate, load))
            });
            plant.step(&shafts);
        }
        let mut bits = Vec::new();
        plant.truth_bits(&mut |bytes| bits.extend_from_slice(bytes));
        bits
    };
    assert_eq!(run(), run());
}

#[test]
fn dead_motors_hold_the_robot_up() {
    let mut plant = RtMover::new(&RtMoverParameters::nominal(), &Ground::Flat, 1);
    for _ in 0..2000 {
        plant.step(&[None; MOTORS]);
    }
    let truth = plant.truth();
    assert!(
        truth.pitch.abs() < 0.01 && truth.roll.abs() < 0.01,
        "{truth:?}"
    );
    assert!((truth.points[6][2] - 0.15).abs() < 0.003, "{truth:?}");
}

#[test]
fn a_standing_robot_drives_and_turns_as_it_is_asked() {
    let mut plant = RtMover::new(&RtMoverParameters::nominal(), &Ground::Flat, 1);
    let mut gait = Gait::new(Parameters::nominal(), Pace::nominal());
    let mut rotors: [Rotor; MOTORS] = core::array::from_fn(Rotor::new);
    let mut rates = [0.0; MOTORS];
    let mut before = None;
    for step in 0..8000_u32 {
        if step.is_multiple_of(TICK) {
            let mut inputs = felt(&plant, &rotors, [0.0; 2]);
            inputs.command = Command::new(0.15, -0.2);
            rates = motors(&gait.tick(&inputs, (f64::from(TICK) * DT) as f32));
        }
        let shafts: [_; MOTORS] = core::array::from_fn(|motor| {
            let load = f64::from(plant.sensors(motor).shaft_torque);
            Some(rotors[motor].step(rates[motor], load))
        });
        plant.step(&shafts);
        if step == 4000 {
            before = Some((plant.truth().yaw, plant.truth().points[6]));
        }
    }
    let (yaw, place) = before.unwrap();
    let seconds = 3.999;
    let turned = (plant.truth().yaw - yaw) / seconds;
    let now = plant.truth().points[6];
    // Length of the arc, computed from its chord.
    let half = 0.5 * turned * seconds;
    let way = (now[0] - place[0]).hypot(now[1] - place[1]) * half / half.sin();
    println!("{turned} rad/s, {} m/s", way / seconds);
    assert!((turned + 0.2).abs() < 0.01, "{turned}");
    assert!((way / seconds - 0.15).abs() < 0.005, "{}", way / seconds);
}
