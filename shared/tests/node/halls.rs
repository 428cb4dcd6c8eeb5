//! Tests of Hall sensors, on the motor model.

use super::motor_faults::rig::{Rig, PER_RADIAN, model, settings};
use crate::random::Random;
use tautrack::motor::model::MotorModel;
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
                if !out.faults.is_empty() { println!("seed {seed} speed {speed} {k} {:?} v {} {} demand {:?}", out.status, rig.motor.shaft().velocity, rig.axle.velocity(), out.bridge); return; }
                let e = error(&mut rig);
                if k > 1000 { worst = worst.max(e.abs()); wv = wv.max(f64::from(rig.motor.shaft().velocity - rig.axle.velocity()).abs()); }
            }
            println!("{seed} {speed}: {worst:.1} deg, velocity {} {} {wv}", rig.motor.shaft().velocity, rig.axle.velocity());
        }
    }
}

#[test]
fn random() {
    let mut random = Random(5);
    let mut faults = 0;
    for seed in 1..200 {
        let mut rig = rig(seed, &[(Setting::VelocityGain, [1000, 3000, 6000][seed as usize % 3])]);
        rig.displaced = core::array::from_fn(|_| Angle::from_degrees(5.0 * random.next() as f32));
        rig.word = None;
        rig.load = 2.0 * random.next() as f32;
        let mut worst = 0.0_f64;
        for k in 0..6000 {
            if k % 400 == 0 { rig.target = (6.0 * random.next().powi(3) * PER_RADIAN) as i32; }
            let out = rig.tick();
            if !out.faults.is_empty() { faults += 1; let e = error(&mut rig); println!("seed {seed} target {} {k} {:?} v {} {} demand {:?} error {}", rig.target, out.status, rig.motor.shaft().velocity, rig.axle.velocity(), out.bridge, e); break; }
            if k > 300 && error(&mut rig).abs() > 65.0 && worst < 65.0 { println!("{seed} {k} {}", error(&mut rig)) }
 if k > 300 { worst = worst.max(error(&mut rig).abs()); }
        }
        if seed % 20 == 0 { println!("{seed} {worst}"); }
    }
    println!("{faults} of 199");
}
