//! Makes the rotor's angle wrong on random drives, and checks that sound drives are not accused.
//! The drives have the gears, loads and gains of RT-Mover and Hylos, random windings, friction and
//! encoders, and settings that are wrong by up to 40 % (resistance), 20 % (inductances), 10 %
//! (torque constant) and 10 degrees (electrical offset).

use super::rig::{PER_RADIAN, Rig, Trouble, model, settings};
use crate::random::Random;
use std::f64::consts::TAU;
use tautrack::faults::Fault;
use tautrack::motor::halls::COUNTS_PER_ELECTRICAL_TURN;
use tautrack::motor::limits::ActiveLimit;
use tautrack::motor::model::{MotorModel, WindingModel};
use tautrack::node::axle::BridgeDemand;
use tautrack::settings::{Setting, Settings};
use tautrack::units::Angle;

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

pub struct Drive {
    pub model: MotorModel,
    pub settings: Settings,
    /// Velocity limit, rad/s.
    pub velocity: f64,
    /// Torque at the current limit, N m.
    pub torque: f64,
}

/// Returns a random number between two others.
pub fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * 0.5 * (random.next() + 1.0)
}

pub fn pick<T: Copy>(random: &mut Random, of: &[T]) -> T {
    let index = between(random, 0.0, of.len() as f64) as usize;
    of[index.min(of.len() - 1)]
}

impl Drive {
    /// Draws a drive with one of these encoders, counts per turn. `wrong` scales the errors of its
    /// settings.
    pub fn draw(random: &mut Random, wrong: f64, encoders: &[u32]) -> Self {
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

    pub fn rig(&self) -> Rig {
        Rig::with_model(self.model, &self.settings)
    }

    /// Returns the target for this part of the velocity limit.
    pub fn target(&self, part: f64) -> i32 {
        (part * self.velocity * PER_RADIAN) as i32
    }

    /// Returns the current that turns the shaft without a load, A.
    pub fn friction(&self) -> f64 {
        f64::from(self.model.friction_torque) / self.torque * 10.0
    }

    /// Swaps the leads a and b, and calibrates the drive again.
    pub fn swap_leads(&mut self) {
        let offset = Setting::ElectricalOffset;
        for (setting, value) in [
            (Setting::PhaseOrder, -1),
            // The angle in the stator is 120 degrees minus the one from before.
            (offset, 120_000 - self.settings.get(offset)),
        ] {
            let key = setting.description().key;
            self.settings.set(key, value).expect("in range");
        }
    }

    /// Has Hall sensors show the rotor instead of the encoder.
    pub fn use_halls(&mut self) {
        // The first sector begins at 60 degrees, and the encoder at 40.
        let later = 20_000 * self.settings.get(Setting::PhaseOrder);
        let offset = self.settings.get(Setting::ElectricalOffset) + later;
        for (setting, value) in [
            (Setting::RotorSensor, 4),
            (Setting::EncoderCounts, 7 * COUNTS_PER_ELECTRICAL_TURN),
            (Setting::ElectricalOffset, offset),
        ] {
            let key = setting.description().key;
            self.settings.set(key, value).expect("in range");
        }
    }

    /// Limits the first current to this one, A.
    fn probe(&mut self, current: f64) {
        let key = Setting::ProbeCurrent.description().key;
        let milliamperes = (current * 1e3) as i32;
        self.settings.set(key, milliamperes).expect("in range");
    }

    /// Has the angle of the rotor checked at arming, with a multiple of the current that turns the
    /// shaft.
    pub fn check(&mut self, turning: f64, multiple: f64) {
        let current = (multiple * turning * 1e3) as i32;
        let sensor = match self.settings.get(Setting::RotorSensor) {
            4 => 5,
            _ => 2,
        };
        for (setting, value) in [
            (Setting::RotorSensor, sensor),
            (Setting::AlignmentCurrent, current),
        ] {
            let key = setting.description().key;
            self.settings.set(key, value).expect("in range");
        }
    }

    /// Returns a load of up to a fifth of the torque of the alignment that checks the angle, N m.
    pub fn load(&self, random: &mut Random, turning: f64) -> f32 {
        (between(random, -0.2, 0.2) * CHECK * turning * 0.1 * self.torque) as f32
    }

    /// Adds cogging at random. Returns the current that overcomes friction and cogging, A.
    pub fn add_cogging(&mut self, random: &mut Random) -> f64 {
        let friction = self.friction();
        let cogging = between(random, 0.0, 0.5) * friction;
        let WindingModel::ThreePhase(winding) = &mut self.model.winding else {
            unreachable!("a three-phase motor")
        };
        winding.cogging_torque = (cogging * 0.04) as f32;
        friction + cogging
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

const SLIPPED_OR_FROZEN: [Trouble; 4] = [
    Trouble::Slipped(90.0),
    Trouble::Slipped(-90.0),
    Trouble::Slipped(180.0),
    Trouble::FrozenEncoder,
];
const REVERSED: [Trouble; 2] = [Trouble::ReversedEncoder, Trouble::ReversedPhase];

/// Times of many runs until the bridge opened or shorted, ms.
#[derive(Default)]
struct Times {
    runs: usize,
    /// Runs that took more than 50 ms.
    late: usize,
    latest: usize,
    /// Largest travel, in travels of a second at the velocity limit.
    farthest: f64,
}

impl Times {
    fn add(&mut self, context: &str, milliseconds: usize, travel: f64) {
        if milliseconds > 50 {
            println!("{context}: {milliseconds} ms, {travel:.4} s");
            self.late += 1;
        }
        self.runs += 1;
        self.latest = self.latest.max(milliseconds);
        self.farthest = self.farthest.max(travel);
    }

    fn print(&self) {
        println!(
            "{} of {} after 50 ms, the last after {} ms; {:.4} s",
            self.late, self.runs, self.latest, self.farthest
        );
    }
}

/// Runs random drives at random speeds and loads, and disturbs them at random times.
fn disturb_running(random: &mut Random, troubles: &[Trouble], cases: usize) -> Times {
    let mut times = Times::default();
    for case in 0..cases {
        let drive = Drive::draw(random, 0.5, &[2_048, 4_096]);
        let trouble = troubles[case % troubles.len()];
        let direction = pick(random, &[-1.0, 1.0]);
        let part = between(random, 0.03, 0.9) * direction;
        let load = between(random, 0.0, 0.3) * drive.torque * direction;
        let mut rig = drive.rig();
        rig.target = drive.target(part);
        rig.run(800);
        rig.load = load as f32;
        rig.run(300 + between(random, 0.0, 100.0) as usize);
        rig.trouble = trouble;
        let context = format!("{case}: {trouble:?} at {part:.3} of the speed, {load:.1} N m");
        let (_, milliseconds, travel) = rig.until_fault(200).expect(&context);
        times.add(&context, milliseconds, travel / drive.velocity);
    }
    times
}

#[test]
fn an_angle_that_slips_and_a_frozen_encoder_stop_any_running_motor_within_50_ms() {
    let times = disturb_running(&mut Random(11), &SLIPPED_OR_FROZEN, CASES);
    times.print();
    assert_eq!(times.late, 0);
    // What the shaft travels in 25 ms at its velocity limit.
    assert!(times.farthest < 0.025);
}

#[test]
fn of_other_running_motors_one_in_100_takes_more_than_50_ms() {
    for (seed, troubles) in [
        (21, &SLIPPED_OR_FROZEN[..]),
        (31, &SLIPPED_OR_FROZEN[..]),
        (41, &REVERSED[..]),
    ] {
        let times = disturb_running(&mut Random(seed), troubles, CASES / 2);
        times.print();
        assert!(times.late <= CASES / 200, "{} of seed {seed}", times.late);
        assert!(times.latest <= 150 && times.farthest < 0.025);
    }
}

/// Makes random drives wrong while they stand, and then lets them move. The time counts from the
/// first torque command that should move the shaft: one above its friction.
///
/// The sign probe limits the current to this multiple of what turns the shaft; 0 without a probe.
fn disturb_standing(random: &mut Random, probe: f64, cases: usize) -> Times {
    let mut times = Times::default();
    for case in 0..cases {
        let mut drive = Drive::draw(random, 0.5, &[2_048, 4_096]);
        let trouble = [&SLIPPED_OR_FROZEN[..], &REVERSED[..]].concat()[case % 6];
        let part = between(random, 0.03, 0.9) * pick(random, &[-1.0, 1.0]);
        let friction = drive.friction();
        drive.probe(probe * friction);
        let mut rig = Rig::with_seed(drive.model, &drive.settings, case as u64 + 1);
        rig.trouble = trouble;
        rig.run(500 + between(random, 0.0, 100.0) as usize);
        rig.target = drive.target(part);
        let (start, mut milliseconds) = (rig.angle(), 0);
        while let BridgeDemand::Current(current) | BridgeDemand::Braking { current, .. } =
            rig.tick().bridge
        {
            let most = if probe > 0.0 { probe * friction } else { 10.0 };
            assert!(
                f64::from(current).abs() < 1.001 * most,
                "{case}: {trouble:?}"
            );
            if milliseconds > 0 || f64::from(current).abs() > friction {
                milliseconds += 1;
            }
            assert!(milliseconds < 500, "{case}: {trouble:?} {part}");
        }
        let context = format!("{case}: {trouble:?} to {part:.3} of the speed");
        let travel = (rig.angle() - start).abs() / drive.velocity;
        times.add(&context, milliseconds, travel);
    }
    times.print();
    times
}

#[test]
fn of_motors_that_stand_one_in_ten_takes_more_than_50_ms_from_the_first_torque_on() {
    let times = disturb_standing(&mut Random(51), 0.0, CASES / 2);
    assert!(times.late <= CASES / 20, "{}", times.late);
    assert!(times.latest <= 250 && times.farthest < 0.04);
}

/// Multiples of the current that turns the shaft to which docs/motor.md has the sign probe set.
const PROBES: [f64; 2] = [2.5, 3.0];

#[test]
fn with_a_sign_probe_no_wrong_motor_that_stands_gets_more_than_its_current() {
    for (probe, seed) in PROBES.into_iter().zip([61, 62]) {
        let times = disturb_standing(&mut Random(seed), probe, CASES);
        assert!(times.late <= CASES / 8, "{}", times.late);
        // What the shaft travels in 2.5 ms at its velocity limit.
        assert!(times.latest <= 150 && times.farthest < 0.0025);
    }
}

/// The drives have cogging, too, and the probe is set to a multiple of what overcomes it.
#[test]
fn a_sound_drive_that_begins_to_turn_is_not_accused_by_the_sign_probe() {
    let mut random = Random(71);
    let mut longest = 0;
    for case in 0..CASES {
        let mut drive = Drive::draw(&mut random, 1.0, &[500, 2_048, 4_096]);
        let turning = drive.add_cogging(&mut random);
        drive.probe(PROBES[case % 2] * turning);
        let part = between(&mut random, 0.03, 0.9) * pick(&mut random, &[-1.0, 1.0]);
        let mut rig = Rig::with_seed(drive.model, &drive.settings, case as u64 + 1);
        rig.run(500 + between(&mut random, 0.0, 100.0) as usize);
        rig.target = drive.target(-part);
        // Some turn back while the probe still limits them.
        let mut limited = 0;
        let turning_back = between(&mut random, 0.0, 40.0) as usize;
        for millisecond in 0..1_000 {
            if millisecond == turning_back {
                rig.target = drive.target(part);
            }
            limited += usize::from(rig.run(1).active_limit == ActiveLimit::SignProbe);
        }
        longest = longest.max(limited);
        assert!(limited < 200, "{case}: {limited} ms");
    }
    println!("limited for up to {longest} ms");
}

/// Multiple of the current that turns the shaft for the alignment that checks the rotor's angle.
pub const CHECK: f64 = 4.0;

#[test]
fn a_check_at_arming_finds_any_wrong_angle_before_the_first_torque() {
    let troubles = [
        &SLIPPED_OR_FROZEN[..],
        &REVERSED[..],
        &[30.0, -30.0, 45.0, -45.0, 60.0, -60.0].map(Trouble::Slipped)[..],
        &[Trouble::NoisyEncoder(1_000)],
    ]
    .concat();
    let mut random = Random(81);
    let (mut latest, mut farthest) = (0, 0.0_f64);
    for case in 0..CASES {
        let mut drive = Drive::draw(&mut random, 0.5, &[2_048, 4_096]);
        let turning = drive.add_cogging(&mut random);
        drive.check(turning, CHECK);
        let mut rig = Rig::with_seed(drive.model, &drive.settings, case as u64 + 1);
        rig.trouble = troubles[case % troubles.len()];
        rig.target = drive.target(0.5);
        // A load shifts the angle that the check finds, by up to 12 degrees.
        if !matches!(rig.trouble, Trouble::Slipped(degrees) if degrees.abs() < 45.0) {
            rig.load = drive.load(&mut random, turning);
        }
        let (mut driven, mut travel) = (0, 0.0_f64);
        let fault = loop {
            let outputs = rig.tick();
            travel = travel.max(rig.angle().abs());
            match outputs.bridge {
                BridgeDemand::Align { .. } => driven += 1,
                BridgeDemand::Off => {}
                other => panic!("{case}: {:?}: {other:?}", rig.trouble),
            }
            if let Some(fault) = outputs.faults.strongest() {
                break fault;
            }
        };
        let noisy = fault == Fault::EncoderNoise && matches!(rig.trouble, Trouble::NoisyEncoder(_));
        assert!(
            noisy || fault == Fault::Misaligned,
            "{case}: {:?}: {fault:?}",
            rig.trouble
        );
        // With two leads swapped, the swing of the rotor adds some current.
        assert!(rig.largest_current < 1.4 * CHECK * turning + 0.2, "{case}");
        let electrical = travel * f64::from(drive.model.gear_ratio) * 7.0 / TAU;
        (latest, farthest) = (latest.max(driven), farthest.max(electrical));
    }
    println!("after up to {latest} ms and {farthest:.2} electrical turns");
    assert!(latest <= 1_155 && farthest < 1.6);
}

#[test]
fn a_check_at_arming_accuses_no_sound_drive() {
    let mut random = Random(82);
    for case in 0..CASES / 2 {
        let mut drive = Drive::draw(&mut random, 1.0, &[500, 2_048, 4_096]);
        let turning = drive.add_cogging(&mut random);
        drive.check(turning, CHECK);
        let load = drive.load(&mut random, turning);
        let offset = 40_000 + between(&mut random, -6_000.0, 6_000.0) as i32;
        let loaded = case % 2 == 1;
        if loaded {
            let key = Setting::ElectricalOffset.description().key;
            drive.settings.set(key, offset).expect("in range");
        }
        let mut rig = Rig::with_seed(drive.model, &drive.settings, case as u64 + 1);
        rig.load = if loaded { load } else { 0.0 };
        rig.target = drive.target(0.3);
        // The stored angle stays in use.
        let mut aligned = false;
        while rig.axle.velocity().abs() < 0.25 * drive.velocity as f32 {
            if let BridgeDemand::Aligned(correction) = rig.run(1).bridge {
                assert_eq!(correction.0, Angle::ZERO);
                aligned = true;
            }
            assert!(rig.now_us < 6_000_000, "{case}");
        }
        assert!(aligned, "{case}");
    }
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

/// Loads that swing: a torque like a sine, cogging, a second inertia on an elastic gear with
/// damping, and an elastic end stop that the shaft leaves again.
#[test]
fn a_sound_drive_is_not_accused_by_a_load_that_swings() {
    let mut random = Random(14);
    for case in 0..160 {
        let mut drive = Drive::draw(&mut random, 1.0, &[280, 1_024, 4_096]);
        if let (1, WindingModel::ThreePhase(winding)) = (case % 4, &mut drive.model.winding) {
            winding.cogging_torque = between(&mut random, 0.008, 0.06) as f32;
            winding.cogging_periods = pick(&mut random, &[42, 84]);
        }
        let mut rig = drive.rig();
        let frequency = between(&mut random, 5.0, 80.0);
        let inertia = 3.0 * drive.inertia();
        let stiffness = drive.inertia() * between(&mut random, 20.0, 120.0).powi(2);
        let damping = 0.1 * (stiffness * inertia).sqrt();
        let (mut position, mut velocity) = (0.0, 0.0);
        for step in 0..40 {
            rig.target = drive.target(between(&mut random, -0.3, 0.3));
            let load = 0.5 * random.next() * drive.torque;
            let stop = rig.angle() + between(&mut random, 0.0, 0.05);
            for _ in 0..100 {
                let time = rig.now_us as f64 * 1e-6;
                rig.load = match case % 4 {
                    0 => 0.5 * drive.torque * (TAU * frequency * time).sin() + 0.3 * load,
                    1 => load * random.next(),
                    2 => {
                        let rotor = f64::from(rig.motor.shaft().velocity);
                        let twist = stiffness * (rig.angle() - position);
                        let torque = twist + damping * (rotor - velocity);
                        let torque = torque.clamp(-0.7 * drive.torque, 0.7 * drive.torque);
                        velocity += (torque - 0.2 * load) / inertia * 1e-3;
                        position += velocity * 1e-3;
                        torque
                    }
                    _ if step % 2 == 0 => {
                        (stiffness * (rig.angle() - stop).max(0.0)).min(2.0 * drive.torque)
                    }
                    _ => load * random.next(),
                } as f32;
                let fault = rig.tick().faults.strongest();
                // A load that throws the shaft may exceed its limits; nothing else counts.
                if let Some(Fault::Overspeed | Fault::OverCurrent | Fault::Blocked) = fault {
                    rig = drive.rig();
                    (position, velocity) = (0.0, 0.0);
                } else {
                    assert_eq!(fault, None, "{case} {step}");
                }
            }
        }
    }
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

/// A current that changes its sign changes the error of the dead time, too.
#[test]
fn a_sound_drive_is_not_accused_while_its_torque_turns_round() {
    let mut random = Random(17);
    for case in 0..150 {
        let mut drive = Drive::draw(&mut random, 1.0, &[280, 1_024, 4_096]);
        if case % 2 == 1 {
            drive.swap_leads();
        }
        let mut rig = drive.rig();
        rig.mode = 10;
        for step in 0..80 {
            let velocity = f64::from(rig.axle.velocity());
            rig.target = if velocity.abs() > 0.5 * drive.velocity {
                -100 * velocity.signum() as i32
            } else {
                between(&mut random, -400.0, 400.0) as i32
            };
            for _ in 0..between(&mut random, 5.0, 60.0) as usize {
                let fault = rig.tick().faults.strongest();
                assert_eq!(fault, None, "{case} {step}: {} per mille", rig.target);
            }
        }
    }
}

/// Half of all motors are connected like this.
#[test]
fn a_drive_with_swapped_leads_is_supervised_like_another_one() {
    let mut random = Random(15);
    let mut probing = 0;
    for case in 0..48 {
        let mut drive = Drive::draw(&mut random, 1.0, &[280, 1_024, 4_096]);
        drive.swap_leads();
        let mut rig = drive.rig();
        for step in 0..20 {
            rig.target = drive.target(between(&mut random, -0.3, 0.3));
            rig.load = (0.3 * random.next() * drive.torque) as f32;
            for _ in 0..200 {
                let outputs = rig.tick();
                probing += usize::from(probes(outputs.bridge));
                let fault = outputs.faults.strongest();
                assert_eq!(fault, None, "{case} {step}");
            }
        }
    }
    println!("{probing} ms");
    assert!(probing > 100);
    let mut times = Times::default();
    for case in 0..96 {
        let mut drive = Drive::draw(&mut random, 0.5, &[2_048, 4_096]);
        drive.swap_leads();
        let trouble = SLIPPED_OR_FROZEN[case % 4];
        let part = between(&mut random, 0.03, 0.9) * pick(&mut random, &[-1.0, 1.0]);
        let mut rig = drive.rig();
        rig.target = drive.target(part);
        rig.run(1_100);
        rig.trouble = trouble;
        let context = format!("{case}: {trouble:?} at {part:.3} of the speed");
        let (_, milliseconds, travel) = rig.until_fault(200).expect(&context);
        times.add(&context, milliseconds, travel / drive.velocity);
    }
    times.print();
    assert!(times.late == 0 && times.farthest < 0.025);
}

/// The probe leaves 6.5 A of 10 A. The shaft is held.
#[test]
fn a_velocity_loop_that_takes_over_from_a_torque_keeps_what_the_probe_left() {
    let held = MotorModel {
        friction_torque: 40.0,
        ..model(true)
    };
    let mut taken_over = 0;
    for delay in 0..40 {
        let slope = [(Setting::CurrentSlope, 2_000)];
        let mut rig = Rig::with_model(held, &settings(true, &slope));
        (rig.mode, rig.target) = (10, 0);
        rig.run(300);
        rig.target = 2_000;
        rig.run(1 + delay);
        (rig.mode, rig.target) = (9, 0);
        let mut last = None;
        for _ in 0..60 {
            let outputs = rig.tick();
            let (BridgeDemand::Current(current) | BridgeDemand::Braking { current, .. }) =
                outputs.bridge
            else {
                panic!("{delay}: {:?}", outputs.bridge);
            };
            if outputs.mode == 10 {
                last = probes(outputs.bridge).then_some(current);
            } else if let Some(last) = last {
                taken_over += 1;
                assert!(
                    (current - last).abs() < 0.1,
                    "{delay}: {last} A, {current} A"
                );
            }
        }
    }
    println!("{taken_over} ms");
    assert!(taken_over > 100);
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

#[test]
fn a_drive_probes_its_rotor_only_if_a_setting_says_so() {
    let held = MotorModel {
        friction_torque: 100.0,
        ..model(true)
    };
    let default = Setting::AngleWatch.description().default;
    for (watch, expected) in [(1, true), (default, false)] {
        let mut rig = Rig::with_model(held, &settings(true, &[(Setting::AngleWatch, watch)]));
        rig.target = (0.3 * PER_RADIAN) as i32;
        let mut probing = false;
        let fault = (0..4_000).find_map(|_| {
            let outputs = rig.tick();
            probing |= probes(outputs.bridge);
            outputs.faults.strongest()
        });
        assert_eq!(fault, Some(Fault::Blocked));
        assert_eq!(probing, expected, "angle_watch = {watch}");
    }
}
