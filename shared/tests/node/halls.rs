//! Tests of Hall sensors, on the motor model: random drives whose sensors are displaced by up to 5
//! electrical degrees each. `motor_faults/sound.rs` has random commands for such drives.

use super::motor_faults::rig::{PER_RADIAN, Rig, Trouble, model, settings};
use super::motor_faults::wrong_angle::{CHECK, Drive, between, pick};
use crate::random::Random;
use std::f64::consts::TAU;
use tautrack::bus::cia402::mode;
use tautrack::faults::Fault;
use tautrack::motor::halls::COUNTS_PER_ELECTRICAL_TURN;
use tautrack::node::axle::BridgeDemand;
use tautrack::settings::Setting;
use tautrack::units::Angle;

/// Angles by which three sensors are displaced.
pub fn displaced(random: &mut Random) -> [Angle; 3] {
    [(); 3].map(|()| Angle::from_degrees(5.0 * random.next() as f32))
}

/// A random drive with Hall sensors, and with cogging. Returns the current that turns its shaft, A,
/// too.
fn draw(random: &mut Random, wrong: f64, case: usize) -> (Drive, f64) {
    let mut drive = Drive::draw(random, wrong, &[4_096]);
    drive.use_halls();
    if case % 2 == 1 {
        drive.swap_leads();
    }
    let turning = drive.add_cogging(random);
    (drive, turning)
}

fn rig(drive: &Drive, random: &mut Random, case: usize) -> Rig {
    let mut rig = Rig::with_seed(drive.model, &drive.settings, case as u64 + 1);
    rig.displaced = displaced(random);
    rig
}

/// The drive of RT-Mover's wheel at constant speeds: up to 6 rad/s, or 400 electrical turns per
/// second. At 0.2 rad/s, 80 edges come in a second.
#[test]
fn angle_and_velocity_are_right_at_constant_speed() {
    let mut random = Random(31);
    for (speed, degrees, slip) in [
        (0.2, 30.0, 0.4),
        (0.6, 15.0, 0.3),
        (1.0, 12.0, 0.2),
        (3.0, 12.0, 0.2),
        (6.0, 20.0, 0.2),
    ] {
        let mut worst = [0.0_f64; 2];
        for seed in 1..=8 {
            let changes = [
                (Setting::RotorSensor, 4),
                (Setting::EncoderCounts, 7 * COUNTS_PER_ELECTRICAL_TURN),
                (Setting::ElectricalOffset, 60_000),
            ];
            let mut rig = Rig::with_seed(model(true), &settings(true, &changes), seed);
            rig.displaced = displaced(&mut random);
            rig.target = (speed * PER_RADIAN) as i32 * [1, -1][seed as usize % 2];
            rig.run(1_500);
            for _ in 0..500 {
                rig.run(1);
                let [angle, velocity] = &mut worst;
                *angle = angle.max(angle_error(&mut rig).abs());
                let apart = rig.motor.shaft().velocity - rig.axle.velocity();
                *velocity = velocity.max(f64::from(apart).abs());
            }
        }
        let [angle, velocity] = worst;
        println!("{speed} rad/s: {angle:.1} degrees, {velocity:.3} rad/s");
        assert!(angle <= degrees, "{speed} rad/s: {angle} degrees");
        assert!(velocity <= slip, "{speed} rad/s: {velocity} rad/s");
    }
}

/// Error of the rotor's angle, electrical degrees.
fn angle_error(rig: &mut Rig) -> f64 {
    let inputs = rig.inputs.expect("a tick");
    let shown = f64::from(inputs.electrical.angle.expect("an angle").0.degrees());
    let truth = f64::from(rig.motor.readings().rotor) * 7.0 * 360.0 / 4_096.0 + 40.0;
    (shown - truth + 180.0).rem_euclid(360.0) - 180.0
}

#[test]
fn a_sound_drive_is_not_accused_whatever_its_load_does() {
    let mut random = Random(32);
    for case in 0..150 {
        let (drive, _) = draw(&mut random, 1.0, case);
        let mut rig = rig(&drive, &mut random, case);
        for step in 0..40 {
            rig.target = drive.target(between(&mut random, -0.3, 0.3));
            let load = 0.4 * random.next() * drive.torque;
            for _ in 0..100 {
                let shaken = if step % 3 == 0 { random.next() } else { 1.0 };
                rig.load = (load * shaken) as f32;
                let fault = rig.tick().faults.strongest();
                assert_eq!(fault, None, "{case} {step}");
            }
        }
    }
}

/// Runs a random drive at a random speed and load, and disturbs it at a random time. Returns the
/// fault, the milliseconds until the bridge opens or shorts, and the electrical turns until then.
fn disturb(random: &mut Random, case: usize, trouble: Trouble) -> (Fault, usize, f64) {
    let (drive, _) = draw(random, 0.5, case);
    let mut rig = rig(&drive, random, case);
    let part = between(random, 0.03, 0.9) * pick(random, &[-1.0, 1.0]);
    rig.target = drive.target(part);
    rig.run(800);
    rig.load = (between(random, 0.0, 0.3) * drive.torque * part.signum()) as f32;
    rig.run(300 + case);
    rig.trouble = trouble;
    let (outputs, milliseconds, travel) = rig.until_fault(3_000).expect("a fault");
    let electrical = travel * f64::from(drive.model.gear_ratio) * 7.0 / TAU;
    let fault = outputs.faults.strongest().expect("a fault");
    (fault, milliseconds, electrical)
}

#[test]
fn a_broken_line_opens_the_bridge_within_50_ms_or_an_electrical_turn() {
    let mut random = Random(33);
    let (mut latest, mut farthest) = (0, 0.0_f64);
    for case in 0..300 {
        let trouble = Trouble::HallLine(case as u32 % 3, case % 2 == 0);
        let (fault, milliseconds, electrical) = disturb(&mut random, case, trouble);
        let in_time = milliseconds <= 50 || electrical <= 1.0;
        assert!(
            in_time,
            "{case}: {fault:?} after {milliseconds} ms, {electrical:.2} turns"
        );
        (latest, farthest) = (latest.max(milliseconds), farthest.max(electrical));
    }
    println!("after up to {latest} ms and {farthest:.2} electrical turns");
}

#[test]
fn sensors_that_break_without_power_end_the_homing_and_raise_their_fault() {
    let mut random = Random(37);
    let (mut drive, _) = draw(&mut random, 0.0, 0);
    let key = Setting::HomingDirection.description().key;
    drive.settings.set(key, 1).expect("in range");
    let mut rig = rig(&drive, &mut random, 0);
    rig.word = Some(0);
    rig.mode = mode::HOMING;
    rig.run(20);
    // Homing where it stands.
    let mut parameters = rig.axle.parameters();
    parameters.homing_method = 37;
    rig.axle.configure(&parameters);
    rig.word = None;
    rig.run(30);
    rig.word = Some(0x1f);
    rig.run(30);
    assert!(rig.axle.homed());
    rig.word = Some(0);
    rig.run(30);
    rig.trouble = Trouble::HallCable;
    let (outputs, milliseconds) = rig.until_raised(10).expect("a fault");
    assert_eq!(outputs.faults.strongest(), Some(Fault::EncoderNoise));
    assert!(milliseconds <= 2 && !rig.axle.homed(), "{milliseconds} ms");
}

#[test]
fn a_line_that_is_broken_at_power_up_opens_the_bridge_or_lets_the_shaft_stand() {
    let mut random = Random(38);
    for case in 0..60 {
        let (drive, _) = draw(&mut random, 0.5, case);
        let mut rig = rig(&drive, &mut random, case);
        rig.trouble = Trouble::HallLine(case as u32 % 3, case / 3 % 2 == 0);
        rig.target = drive.target(0.3);
        let (start, mut turns) = (rig.angle(), 0.0_f64);
        for _ in 0..3_000 {
            let faulty = !rig.tick().faults.is_empty();
            let turned = (rig.angle() - start).abs() * f64::from(drive.model.gear_ratio);
            turns = turns.max(turned * 7.0 / TAU);
            if faulty {
                break;
            }
        }
        assert!(turns <= 1.5, "{case}: {turns:.2} electrical turns");
    }
}

#[test]
fn an_unplugged_cable_opens_the_bridge_within_5_ms() {
    let mut random = Random(36);
    for case in 0..60 {
        let (fault, milliseconds, _) = disturb(&mut random, case, Trouble::HallCable);
        assert!(
            milliseconds <= 5,
            "{case}: {fault:?} after {milliseconds} ms"
        );
    }
}

#[test]
fn a_check_at_arming_accuses_no_sound_drive() {
    let mut random = Random(34);
    for case in 0..200 {
        let (mut drive, turning) = draw(&mut random, 1.0, case);
        drive.check(turning, CHECK);
        let mut rig = rig(&drive, &mut random, case);
        if case % 4 < 2 {
            rig.load = drive.load(&mut random, turning);
        }
        rig.target = drive.target(0.3);
        while rig.axle.velocity().abs() < 0.25 * drive.velocity as f32 {
            rig.run(1);
            assert!(rig.now_us < 6_000_000, "{case}");
        }
    }
}

#[test]
fn a_check_at_arming_finds_every_wrong_drive_before_it_is_enabled() {
    let troubles = [
        Trouble::ReversedEncoder,
        Trouble::ReversedPhase,
        Trouble::FrozenEncoder,
        Trouble::OpenLead(1),
    ];
    // The offset is wrong by this many degrees, if nothing else is.
    let offsets = [60, 90, 120, 180, -60, -120];
    let mut random = Random(35);
    for case in 0..400 {
        let (mut drive, turning) = draw(&mut random, 0.5, case);
        drive.check(turning, CHECK);
        let trouble = if case % 2 == 0 {
            troubles[case / 2 % troubles.len()]
        } else {
            let (key, offset) = (
                Setting::ElectricalOffset.description().key,
                offsets[case / 2 % 6],
            );
            let wrong = drive.settings.get(Setting::ElectricalOffset) + 1_000 * offset;
            let wrong = (wrong + 180_000).rem_euclid(360_000) - 180_000;
            drive.settings.set(key, wrong).expect("in range");
            Trouble::None
        };
        let mut rig = rig(&drive, &mut random, case);
        rig.trouble = trouble;
        let fault = loop {
            let outputs = rig.tick();
            assert!(rig.now_us < 2_000_000, "{case}: {trouble:?}");
            let bridge = outputs.bridge;
            assert!(
                matches!(bridge, BridgeDemand::Align { .. } | BridgeDemand::Off),
                "{case}: {trouble:?} {bridge:?}"
            );
            if let Some(fault) = outputs.faults.strongest() {
                break fault;
            }
        };
        let expected = [Fault::Misaligned, Fault::EncoderNoise, Fault::OpenPhase];
        assert!(expected.contains(&fault), "{case}: {trouble:?} {fault:?}");
    }
}
