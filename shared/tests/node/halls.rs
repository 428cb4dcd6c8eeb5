//! Tests of Hall sensors, on the motor model.

use super::motor_faults::rig::{PER_RADIAN, Rig, model, settings};
use super::motor_faults::wrong_angle::{CHECK, Drive, between};
use crate::random::Random;
use tautrack::settings::Setting;
use tautrack::units::Angle;

fn rig(seed: u64, changes: &[(Setting, i32)]) -> Rig {
    let mut all = vec![
        (Setting::RotorSensor, 4),
        (Setting::EncoderCounts, 384 * 7),
        (Setting::ElectricalOffset, 60_000),
    ];
    all.extend(changes);
    Rig::with_seed(model(true), &settings(true, &all), seed)
}

fn error(rig: &mut Rig) -> f64 {
    let shown = f64::from(rig.inputs.unwrap().electrical.angle.unwrap().0.degrees());
    let truth = f64::from(rig.motor.readings().rotor) / 4096.0 * 7.0 * 360.0 + 40.0;
    (shown - truth + 180.0).rem_euclid(360.0) - 180.0
}

#[test]
fn first() {
    for seed in 1..4 {
        let mut rig = rig(seed, &[]);
        rig.word = None;
        rig.run(300);
        for speed in [0.2, 1.0, 3.0, 6.0, -3.0, 0.0] {
            rig.target = (speed * PER_RADIAN) as i32;
            let (mut worst, mut wv) = (0.0_f64, 0.0_f64);
            for k in 0..1500 {
                let out = rig.tick();
                if !out.faults.is_empty() {
                    println!(
                        "seed {seed} speed {speed} {k} {:?} v {} {} demand {:?}",
                        out.status,
                        rig.motor.shaft().velocity,
                        rig.axle.velocity(),
                        out.bridge
                    );
                    return;
                }
                let e = error(&mut rig);
                if k > 1000 {
                    worst = worst.max(e.abs());
                    wv = wv.max(f64::from(rig.motor.shaft().velocity - rig.axle.velocity()).abs());
                }
            }
            println!(
                "{seed} {speed}: {worst:.1} deg, velocity {} {} {wv}",
                rig.motor.shaft().velocity,
                rig.axle.velocity()
            );
        }
    }
}

#[test]
fn troubles() {
    use super::motor_faults::rig::Trouble as T;
    for trouble in [
        T::ReversedEncoder,
        T::ReversedPhase,
        T::FrozenEncoder,
        T::HallLine(0, false),
        T::HallLine(1, true),
        T::HallLine(2, false),
        T::OpenLead(0),
        T::OpenLead(1),
        T::OpenLead(2),
    ] {
        for speed in [0.0, 0.05, 0.1, 0.5, 2.0, 6.0] {
            let (mut latest, mut never, mut far) = (0, 0, 0.0_f64);
            let mut kinds = std::collections::BTreeMap::new();
            for seed in 1..40 {
                let mut random = Random(seed);
                let mut rig = rig(seed, &[]);
                rig.displaced =
                    core::array::from_fn(|_| Angle::from_degrees(5.0 * random.next() as f32));
                rig.word = None;
                rig.target = (speed * PER_RADIAN) as i32;
                rig.run(800);
                rig.load = 3.0 * random.next() as f32;
                rig.run(300 + seed as usize * 3);
                rig.trouble = trouble;
                if speed == 0.0 {
                    rig.target = 1_000_000;
                }
                match rig.until_fault(1_000) {
                    Some((o, ms, travel)) => {
                        latest = latest.max(ms);
                        far = far.max(travel);
                        *kinds.entry(o.status.error_code).or_insert(0) += 1;
                    }
                    None => never += 1,
                }
            }
            println!("{trouble:?} {speed}: latest {latest} never {never} far {far:.4} {kinds:x?}");
        }
    }
}

#[test]
fn checked() {
    use super::motor_faults::rig::Trouble as T;
    for trouble in [
        T::None,
        T::ReversedEncoder,
        T::ReversedPhase,
        T::FrozenEncoder,
        T::HallLine(0, false),
        T::HallLine(1, true),
        T::OpenLead(0),
    ] {
        for off in [0, 10_000, -10_000, 60_000, 90_000, 180_000] {
            let (mut latest, mut never, mut far) = (0, 0, 0.0_f64);
            let mut kinds = std::collections::BTreeMap::new();
            for seed in 1..80 {
                let mut random = Random(seed);
                let mut rig = rig(
                    seed,
                    &[
                        (Setting::RotorSensor, 5),
                        (
                            Setting::ElectricalOffset,
                            (60_000 + off + 180_000) % 360_000 - 180_000,
                        ),
                    ],
                );
                rig.displaced =
                    core::array::from_fn(|_| Angle::from_degrees(5.0 * random.next() as f32));
                rig.word = None;
                rig.trouble = trouble;
                match rig.until_fault(1_400) {
                    Some((o, ms, travel)) => {
                        latest = latest.max(ms);
                        far = far.max(travel);
                        *kinds.entry(o.status.error_code).or_insert(0) += 1;
                    }
                    None => never += 1,
                }
            }
            println!("{trouble:?} {off}: latest {latest} never {never} far {far:.4} {kinds:x?}");
        }
    }
}

#[test]
fn random() {
    let mut random = Random(5);
    let mut faults = 0;
    for seed in 1..200 {
        let mut rig = rig(
            seed,
            &[(Setting::VelocityGain, [1000, 3000, 6000][seed as usize % 3])],
        );
        rig.displaced = core::array::from_fn(|_| Angle::from_degrees(5.0 * random.next() as f32));
        rig.word = None;
        rig.load = 2.0 * random.next() as f32;
        let mut worst = 0.0_f64;
        for k in 0..6000 {
            if k % 400 == 0 {
                rig.target = (6.0 * random.next().powi(3) * PER_RADIAN) as i32;
            }
            let out = rig.tick();
            if !out.faults.is_empty() {
                faults += 1;
                let e = error(&mut rig);
                println!(
                    "seed {seed} target {} {k} {:?} v {} {} demand {:?} error {}",
                    rig.target,
                    out.status,
                    rig.motor.shaft().velocity,
                    rig.axle.velocity(),
                    out.bridge,
                    e
                );
                break;
            }
            if k > 300 && error(&mut rig).abs() > 65.0 && worst < 65.0 {
                println!("{seed} {k} {}", error(&mut rig))
            }
            if k > 300 {
                worst = worst.max(error(&mut rig).abs());
            }
        }
        if seed % 20 == 0 {
            println!("{seed} {worst}");
        }
    }
    println!("{faults} of 199");
}

#[test]
fn loads() {
    let mut random = Random(12);
    let mut kinds = std::collections::BTreeMap::new();
    for case in 0..200 {
        let mut drive = Drive::draw(&mut random, 1.0, &[4_096]);
        drive.use_halls();
        if case % 2 == 1 {
            drive.swap_leads();
        }
        let mut rig = drive.rig();
        rig.displaced = core::array::from_fn(|_| Angle::from_degrees(5.0 * random.next() as f32));
        'outer: for step in 0..40 {
            rig.target = drive.target(between(&mut random, -0.3, 0.3));
            let load = 0.5 * random.next() * drive.torque;
            for _ in 0..100 {
                let shaken = if step % 3 == 0 { random.next() } else { 1.0 };
                rig.load = (load * shaken) as f32;
                let outputs = rig.tick();
                if let Some(f) = outputs.faults.strongest() {
                    *kinds
                        .entry(format!("{f:?} {}", drive.model.gear_ratio))
                        .or_insert(0) += 1;
                    break 'outer;
                }
            }
        }
    }
    println!("kinds {kinds:?}");
}
#[test]
fn check_accuses_none() {
    let mut random = Random(82);
    let mut failed = 0;
    for case in 0..200 {
        let mut drive = Drive::draw(&mut random, 1.0, &[500, 2_048, 4_096]);
        drive.use_halls();
        let turning = drive.add_cogging(&mut random);
        drive.check(turning, CHECK);
        let load = drive.load(&mut random, turning);
        let loaded = case % 2 == 1;
        if loaded {
            let key = Setting::ElectricalOffset.description().key;
            drive
                .settings
                .set(key, 60_000 + between(&mut random, -6_000.0, 6_000.0) as i32)
                .expect("in range");
        }
        let mut rig = Rig::with_seed(drive.model, &drive.settings, case as u64 + 1);
        rig.displaced = core::array::from_fn(|_| Angle::from_degrees(5.0 * random.next() as f32));
        rig.load = if loaded { load } else { 0.0 };
        rig.target = drive.target(0.3);
        while rig.axle.velocity().abs() < 0.25 * drive.velocity as f32 {
            let outputs = rig.tick();
            if let Some(f) = outputs.faults.strongest() {
                failed += 1;
                println!("case {case} {f:?} {}", rig.now_us / 1000);
                break;
            }
            if rig.now_us > 6_000_000 {
                println!("case {case} slow");
                break;
            }
        }
    }
    println!("kinds {failed}");
}
