//! Makes the rotor's angle wrong on random drives, and checks that sound drives are not accused.
//! The drives have the gears, loads and gains of RT-Mover and Hylos, random windings, friction and
//! encoders, and settings that are wrong by up to 40 % (resistance), 20 % (inductances), 10 %
//! (torque constant) and 10 degrees (electrical offset).

use super::rig::{PER_RADIAN, Rig, Trouble, model, settings};
use crate::random::Random;
use tautrack::faults::Fault;
use tautrack::motor::model::{MotorModel, WindingModel};
use tautrack::node::axle::BridgeDemand;
use tautrack::settings::{Setting, Settings};

/// A drive: gear ratio, inertia of the load at the output shaft, kg m^2, velocity limit, 1e-3
/// rad/s, acceleration limit, 1e-3 rad/s^2, and gain of the velocity loop, mA s/rad.
const DRIVES: [(f32, f32, i32, i32, i32); 6] = [
    (60.0, 0.07, 4_500, 5_000, 4_400),    // wheel of RT-Mover
    (150.0, 0.4, 3_000, 4_000, 6_200),    // steering and seat of RT-Mover
    (300.0, 1.3, 3_000, 4_000, 11_000),   // roll of RT-Mover
    (150.0, 0.25, 1_600, 10_000, 10_000), // leg of Hylos
    (60.0, 0.035, 9_600, 120_000, 3_000), // wheel of Hylos
    (60.0, 0.01, 3_000, 120_000, 3_000),  // steering of Hylos
];

/// Number of drives whose angle slips.
const CASES: usize = 400;

struct Drive {
    model: MotorModel,
    settings: Settings,
    /// Velocity limit, rad/s.
    velocity: f64,
    /// Torque at the current limit, N m.
    torque: f64,
}

/// Returns a random number between two others.
fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * 0.5 * (random.next() + 1.0)
}

fn pick<T: Copy>(random: &mut Random, of: &[T]) -> T {
    let index = between(random, 0.0, of.len() as f64) as usize;
    of[index.min(of.len() - 1)]
}

impl Drive {
    /// Draws a drive with one of these encoders, counts per turn. `wrong` scales the errors of its
    /// settings.
    fn draw(random: &mut Random, wrong: f64, encoders: &[u32]) -> Self {
        let (gear, inertia, velocity, acceleration, gain) = pick(random, &DRIVES);
        let resistance = between(random, 0.15, 0.6);
        let inductance = between(random, 0.08e-3, 0.25e-3);
        let inductance_q = inductance * between(random, 1.0, 1.6);
        let torque = 0.4 * f64::from(gear);
        let mut model = MotorModel {
            gear_ratio: gear,
            rotor_inertia: 1e-5 + inertia / (gear * gear),
            friction_torque: (torque * between(random, 0.01, 0.04)) as f32,
            encoder_counts: pick(random, encoders),
            ..model(true)
        };
        let WindingModel::ThreePhase(winding) = &mut model.winding else {
            unreachable!("a three-phase motor")
        };
        winding.resistance = resistance as f32;
        winding.inductance = [inductance as f32, inductance_q as f32];
        let mut error = |value: f64, part: f64| {
            let factor = between(random, 1.0 - part * wrong, 1.0 + part * wrong);
            (value * factor).round() as i32
        };
        let changes = [
            (Setting::GearRatio, (gear * 1e3) as i32),
            (Setting::EncoderCounts, model.encoder_counts as i32),
            (Setting::VelocityLimit, velocity),
            (Setting::AccelerationLimit, acceleration),
            (Setting::VelocityGain, gain),
            (Setting::Resistance, error(resistance * 1e3, 0.4)),
            (Setting::Inductance, error(inductance * 1e6, 0.2)),
            (Setting::InductanceQ, error(inductance_q * 1e6, 0.2)),
            (Setting::TorqueConstant, error(40_000.0, 0.1)),
            (Setting::ElectricalOffset, error(40_000.0, 10.0 / 40.0)),
        ];
        Self {
            settings: settings(true, &changes),
            model,
            velocity: f64::from(velocity) * 1e-3,
            torque,
        }
    }

    fn rig(&self) -> Rig {
        Rig::with_model(self.model, &self.settings)
    }

    /// Returns the target for this part of the velocity limit.
    fn target(&self, part: f64) -> i32 {
        (part * self.velocity * PER_RADIAN) as i32
    }

    /// Returns the total inertia at the output shaft, kg m^2.
    fn inertia(&self) -> f64 {
        f64::from(self.model.rotor_inertia) * f64::from(self.model.gear_ratio).powi(2)
    }
}

/// Returns whether the probe is under way. The current in d that burns braking power is never
/// positive.
fn probes(demand: BridgeDemand) -> bool {
    matches!(demand, BridgeDemand::Braking { current, direct } if {
        assert!(current.hypot(direct) <= 10.000_1, "{current} A, {direct} A");
        direct > 0.0
    })
}

#[test]
fn an_angle_that_slips_stops_any_motor_within_60_ms_and_a_frozen_encoder_within_100_ms() {
    let mut random = Random(11);
    let (mut late, mut latest, mut farthest) = (0, 0, 0.0_f64);
    for case in 0..CASES {
        let drive = Drive::draw(&mut random, 0.5, &[2_048, 4_096]);
        let trouble = [
            Trouble::Slipped(90.0),
            Trouble::Slipped(-90.0),
            Trouble::Slipped(180.0),
            Trouble::FrozenEncoder,
        ][case % 4];
        let direction = pick(&mut random, &[-1.0, 1.0]);
        let part = between(&mut random, 0.03, 0.9) * direction;
        let load = between(&mut random, 0.0, 0.3) * drive.torque * direction;
        let mut rig = drive.rig();
        rig.target = drive.target(part);
        rig.run(800);
        rig.load = load as f32;
        rig.run(300 + between(&mut random, 0.0, 100.0) as usize);
        rig.trouble = trouble;
        let (outputs, milliseconds, travel) = rig.until_fault(200).unwrap_or_else(|| {
            panic!("{case}: {trouble:?} at {part:.3}, {load:.1} N m is not found")
        });
        let fault = outputs.faults.strongest().unwrap();
        let context = format!(
            "{case}: {trouble:?} at {part:.3} of the speed, {load:.1} N m: {fault:?} after {milliseconds} ms, {travel:.4} rad"
        );
        if milliseconds > 50 {
            println!("{context}");
            late += 1;
        }
        let within = if trouble == Trouble::FrozenEncoder {
            100
        } else {
            60
        };
        assert!(milliseconds <= within, "{context}");
        // What the shaft travels in 25 ms at its velocity limit.
        assert!(travel < 0.025 * drive.velocity, "{context}");
        latest = latest.max(milliseconds);
        farthest = farthest.max(travel / drive.velocity);
    }
    println!("{late} of {CASES} after 50 ms, the last after {latest} ms; {farthest:.4} s");
    assert!(late <= CASES / 20);
}

#[test]
fn a_sound_drive_is_not_accused_whatever_its_load_does() {
    let mut random = Random(12);
    let mut probing = 0;
    for case in 0..150 {
        let drive = Drive::draw(&mut random, 1.0, &[280, 1_024, 4_096]);
        let mut rig = drive.rig();
        for step in 0..40 {
            rig.target = drive.target(between(&mut random, -0.3, 0.3));
            let load = 0.5 * random.next() * drive.torque;
            for _ in 0..100 {
                let shaken = if step % 3 == 0 { random.next() } else { 1.0 };
                rig.load = (load * shaken) as f32;
                let outputs = rig.tick();
                probing += usize::from(probes(outputs.bridge));
                assert!(
                    outputs.faults.is_empty(),
                    "{case} {step}: {:?}",
                    outputs.faults.strongest()
                );
            }
        }
    }
    println!("{probing} ms");
    assert!(probing > 1_000);
}

#[test]
fn a_shaft_that_is_held_is_blocked_and_its_angle_is_not_accused() {
    let mut random = Random(13);
    let mut probing = 0;
    for case in 0..120 {
        let mut drive = Drive::draw(&mut random, 1.0, &[280, 1_024, 4_096]);
        // A brake or a seized gear holds it, or an elastic end stop.
        let ends = case % 2 == 0;
        if !ends {
            drive.model.friction_torque = 2.0 * drive.torque as f32;
        }
        let stiffness = drive.inertia() * 60.0 * 60.0;
        let mut rig = drive.rig();
        rig.target = drive.target(between(&mut random, 0.05, 0.4));
        let fault = (0..4_000).find_map(|_| {
            if ends {
                rig.load = (stiffness * (rig.angle() - 0.05).max(0.0)) as f32;
            }
            let outputs = rig.tick();
            probing += usize::from(probes(outputs.bridge));
            outputs.faults.strongest()
        });
        assert_eq!(fault, Some(Fault::Blocked), "{case}");
    }
    println!("{probing} ms");
    assert!(probing > 500);
}

#[test]
fn a_load_that_the_motor_carries_does_not_move_while_the_probe_acts() {
    // A shaft that stands under half of the full torque, and whose friction takes a quarter.
    let stuck = MotorModel {
        friction_torque: 6.0,
        ..model(true)
    };
    let mut rig = Rig::with_model(stuck, &settings(true, &[]));
    rig.load = 12.0;
    rig.target = 0;
    rig.run(1_500);
    let start = rig.angle();
    rig.target = (0.1 * PER_RADIAN) as i32;
    let (mut probing, mut back) = (0, 0.0_f64);
    for _ in 0..400 {
        let outputs = rig.tick();
        assert!(
            outputs.faults.is_empty(),
            "{:?}",
            outputs.faults.strongest()
        );
        probing += usize::from(probes(outputs.bridge));
        back = back.min(rig.angle() - start);
    }
    println!("{probing} ms, {back} rad");
    assert!(probing > 0 && back > -1e-3);
}
