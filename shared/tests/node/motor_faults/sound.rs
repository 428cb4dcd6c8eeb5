//! Commands at random for sound drives: modes, controlwords, targets and loads, one after the other
//! at any time. No fault may come.

use super::rig::{PER_RADIAN, Rig, model, settings};
use super::wrong_angle::{Drive, between, pick};
use crate::halls::displaced;
use crate::random::Random;
use crate::sweep::cases;
use std::f64::consts::TAU;
use tautrack::bus::cia402::{CONTROL_HALT, CONTROL_START, controlword, mode};
use tautrack::motor::model::{MotorModel, ThreePhaseModel, WindingModel};
use tautrack::node::axle::{AlignmentState, Outputs};
use tautrack::sensors::Switches;
use tautrack::settings::Setting;

const MODES: [i8; 6] = [
    mode::PROFILE_POSITION,
    mode::PROFILE_VELOCITY,
    mode::HOMING,
    mode::CYCLIC_POSITION,
    mode::CYCLIC_VELOCITY,
    mode::CYCLIC_TORQUE,
];
/// Controlwords; `None` enables operation. The second is a quick stop.
const WORDS: [Option<u16>; 10] = [
    None,
    Some(0x0b),
    None,
    Some(controlword::ENABLE_OPERATION | CONTROL_HALT),
    None,
    Some(controlword::ENABLE_OPERATION | CONTROL_START),
    None,
    Some(controlword::SWITCH_ON),
    Some(controlword::SHUTDOWN),
    Some(0),
];

/// Commands a drive. Velocities are in rad/s, torques in N m.
struct Operator {
    rig: Rig,
    outputs: Outputs,
    fastest: f64,
    strongest: f64,
    /// Velocity of the target of cyclic position mode, and the target, bus units.
    ramp: f64,
    position: f64,
}

impl Operator {
    fn new(mut rig: Rig, fastest: f64, strongest: f64) -> Self {
        Self {
            outputs: rig.tick(),
            rig,
            fastest,
            strongest,
            ramp: 0.0,
            position: 0.0,
        }
    }

    /// Sends another command, and stays with it for a random time. Returns the time, ms.
    fn press(&mut self, random: &mut Random) -> usize {
        let part = between(random, -0.6, 0.6);
        let rig = &mut self.rig;
        (rig.mode, rig.word) = (pick(random, &MODES), pick(random, &WORDS));
        let here = self.outputs.motion.position;
        self.position = f64::from(here);
        self.ramp = 0.3 * part * self.fastest / TAU * 65.536;
        rig.target = match rig.mode {
            mode::PROFILE_POSITION => here + (0.5 * part * self.fastest / TAU * 65_536.0) as i32,
            mode::CYCLIC_POSITION => here,
            mode::CYCLIC_TORQUE => (300.0 * part) as i32,
            _ => (part * self.fastest * PER_RADIAN) as i32,
        };
        let load = 0.05 * random.next() * self.strongest;
        let shakes = random.next() > 0.5;
        let milliseconds = between(random, 5.0, 400.0) as usize;
        for _ in 0..milliseconds {
            self.tick(load * if shakes { random.next() } else { 1.0 });
        }
        milliseconds
    }

    fn tick(&mut self, load: f64) {
        let rig = &mut self.rig;
        let velocity = f64::from(rig.axle.velocity());
        if rig.mode == mode::CYCLIC_TORQUE && velocity.abs() > 0.6 * self.fastest {
            rig.target = (-50.0 * velocity.signum()) as i32;
        }
        if rig.mode == mode::CYCLIC_POSITION {
            let follows = rig.is_enabled() && rig.word.is_none();
            self.position = if follows {
                self.position + self.ramp
            } else {
                f64::from(self.outputs.motion.position)
            };
            rig.target = self.position as i32;
        }
        rig.switches = Switches {
            home: rig.angle().sin() > 0.5,
            ..Switches::default()
        };
        // Nothing holds a load while the drive has no power, or only a torque.
        let holds = rig.is_enabled() && rig.mode != mode::CYCLIC_TORQUE;
        rig.load = if holds { load as f32 } else { 0.0 };
        self.outputs = rig.tick();
        let fault = self.outputs.faults.strongest();
        assert_eq!(fault, None, "mode {}, {:x?}", rig.mode, rig.word);
    }
}

/// A random drive that the largest voltage allows to reach its velocity limit.
fn draw(random: &mut Random, case: usize, encoders: &[u32]) -> Drive {
    let mut drive = Drive::draw(random, 1.0, encoders);
    if case % 2 == 1 {
        drive.swap_leads();
    }
    // The largest voltage allows some 8.2 rad/s behind a gear of 60.
    drive.velocity = drive
        .velocity
        .min(490.0 / f64::from(drive.model.gear_ratio));
    for (setting, value) in [
        (Setting::VelocityLimit, (drive.velocity * 1e3) as i32),
        (Setting::HomingDirection, [1, -1][case / 2 % 2]),
        (Setting::HomingSpeed, (drive.velocity * 200.0) as i32),
    ] {
        let key = setting.description().key;
        drive.settings.set(key, value).expect("in range");
    }
    drive
}

#[test]
fn a_sound_three_phase_drive_has_no_fault_whatever_is_commanded() {
    let mut random = Random(8);
    let mut milliseconds = 0;
    for case in 0..cases(200) {
        let drive = draw(&mut random, case, &[1_024, 4_096]);
        let mut rig = drive.rig();
        rig.braked = case % 5 == 0;
        let mut operator = Operator::new(rig, drive.velocity, drive.torque);
        for _ in 0..60 {
            milliseconds += operator.press(&mut random);
        }
    }
    println!("{milliseconds} ms");
}

#[test]
fn a_sound_drive_with_hall_sensors_has_no_fault_whatever_is_commanded() {
    let mut random = Random(18);
    for case in 0..cases(200) {
        let mut drive = draw(&mut random, case, &[4_096]);
        drive.use_halls();
        let mut rig = Rig::with_seed(drive.model, &drive.settings, case as u64 + 1);
        rig.displaced = displaced(&mut random);
        let mut operator = Operator::new(rig, drive.velocity, drive.torque);
        for _ in 0..60 {
            operator.press(&mut random);
        }
    }
}

/// Friction and load turn the aligned angle away from the one that the index corrects.
#[test]
fn a_sound_drive_whose_index_corrects_the_angle_has_no_fault() {
    let mut random = Random(5);
    let mut confirmed = 0;
    for _ in 0..150 {
        let mut drive = Drive::draw(&mut random, 1.0, &[4_096]);
        drive.velocity = drive
            .velocity
            .min(490.0 / f64::from(drive.model.gear_ratio));
        let torque = drive.torque;
        for (setting, value) in [
            (Setting::VelocityLimit, (drive.velocity * 1e3) as i32),
            (Setting::RotorSensor, 3),
            (Setting::ElectricalOffset, 40_000),
            (Setting::AlignmentCurrent, 3_000),
            (Setting::AlignmentTravel, 10_000),
        ] {
            let key = setting.description().key;
            drive.settings.set(key, value).expect("in range");
        }
        let mut rig = drive.rig();
        // An eighth of the torque of the alignment: 8 degrees.
        rig.load = (0.04 * random.next() * torque) as f32;
        for _ in 0..80 {
            rig.target = drive.target(between(&mut random, -0.6, 0.6));
            for _ in 0..60 {
                let outputs = rig.tick();
                confirmed += usize::from(outputs.alignment == AlignmentState::Confirmed);
                assert_eq!(outputs.faults.strongest(), None);
            }
            if rig.is_enabled() {
                rig.load = (0.05 * random.next() * torque) as f32;
            }
        }
    }
    println!("{confirmed} ms");
    assert!(confirmed > 100_000);
}

/// Inductances from 0.05 to 1 mH; the settings are wrong by up to 15 %.
#[test]
fn a_sound_drive_is_not_accused_whatever_its_inductance_is() {
    let base = model(true);
    let WindingModel::ThreePhase(winding) = base.winding else {
        unreachable!("a three-phase motor")
    };
    for inductance in [0.05, 0.15, 0.3, 0.4, 0.6, 1.0] {
        for (resistance, wrong) in [
            (0.3, 1.0),
            (0.3, 0.85),
            (0.3, 1.15),
            (1.0, 0.85),
            (1.0, 1.15),
        ] {
            let model = MotorModel {
                winding: WindingModel::ThreePhase(ThreePhaseModel {
                    resistance,
                    inductance: [1e-3 * inductance, 1.2e-3 * inductance],
                    ..winding
                }),
                ..base
            };
            let changes = [
                (Setting::Resistance, (1e3 * resistance * wrong) as i32),
                (Setting::Inductance, (1e3 * inductance * wrong) as i32),
                (Setting::InductanceQ, (1.2e3 * inductance * wrong) as i32),
            ];
            let mut rig = Rig::with_model(model, &settings(true, &changes));
            let mut random = Random(3);
            for _ in 0..60 {
                rig.target = (4.0 * random.next() * PER_RADIAN) as i32;
                rig.load = (5.0 * random.next()) as f32;
                for _ in 0..200 {
                    let fault = rig.tick().faults.strongest();
                    assert_eq!(
                        fault, None,
                        "{resistance} ohm, {inductance} mH, times {wrong}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_sound_brushed_drive_has_no_fault_whatever_is_commanded() {
    let mut random = Random(2);
    for direction in [1, -1] {
        for _ in 0..25 {
            let changes = [
                (Setting::HomingDirection, direction),
                (Setting::HomingSpeed, 1_000),
            ];
            let mut operator = Operator::new(Rig::new(false, &changes), 6.0, 24.0);
            for _ in 0..60 {
                operator.press(&mut random);
            }
        }
    }
}
