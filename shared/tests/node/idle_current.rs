//! The zero of the current converters, which is checked at each arming.

use super::motor_faults::rig::{Rig, STAGE, Trouble};
use super::motor_faults::wrong_angle::between;
use crate::random::Random;
use tautrack::bus::cia402::CONTROL_FAULT_RESET;
use tautrack::faults::{Fault, Faults};
use tautrack::motor::current::ZERO_ERROR;
use tautrack::node::axle::{BridgeDemand, Outputs};

/// Current limit of the drives, A.
const LIMIT: f64 = 10.0;

/// Runs milliseconds in which faults may come. Returns the outputs of the last one.
fn run(rig: &mut Rig, milliseconds: usize) -> Outputs {
    for _ in 1..milliseconds {
        rig.tick();
    }
    rig.tick()
}

/// Makes a drive whose converter of this half bridge shows a current, A, while none flows. Its
/// master leaves it without power for 100 ms, and then arms it.
fn armed(three_phase: bool, phase: usize, amperes: f64) -> Rig {
    let mut rig = Rig::new(three_phase, &[]);
    let codes = amperes / f64::from(STAGE.full_scale) * 32_768.0;
    rig.trouble = Trouble::CurrentOffset(phase, codes as i32);
    rig.word = Some(0);
    assert_eq!(rig.run(100).faults, Faults::NONE, "no fault before arming");
    rig.word = None;
    rig
}

#[test]
fn a_drive_whose_current_reads_more_than_its_bound_without_power_gets_none() {
    let bound = 0.02 * LIMIT + f64::from(ZERO_ERROR * STAGE.full_scale);
    let mut random = Random(91);
    for case in 0..400 {
        let three_phase = case % 2 == 1;
        let phase = if three_phase { case / 2 % 2 } else { 0 };
        let sign = if case % 8 < 4 { 1.0 } else { -1.0 };
        let part = between(&mut random, 0.0, 3.0);
        let mut rig = armed(three_phase, phase, sign * part * bound);
        let context = format!("{case}: {part} of the bound");
        // The converter is noisy.
        if part < 1.05 {
            if part < 0.95 {
                assert_eq!(rig.run(50).faults, Faults::NONE, "{context}");
                assert!(rig.is_enabled(), "{context}");
            }
            continue;
        }
        let accused = Faults::of(Fault::InvalidReading);
        loop {
            let outputs = rig.tick();
            let drives = !matches!(outputs.bridge, BridgeDemand::Off | BridgeDemand::Brake);
            assert!(!drives, "{context}: {:?}", outputs.bridge);
            if outputs.faults == accused {
                break;
            }
            assert!(rig.now_us < 200_000, "{context}");
        }
        // A reset clears it, so that a calibration can find the zero. The next arming accuses
        // again.
        for word in [0, CONTROL_FAULT_RESET, 0] {
            rig.word = Some(word);
            run(&mut rig, 50);
        }
        assert_eq!(rig.tick().faults, Faults::NONE, "{context}");
        rig.word = None;
        assert_eq!(run(&mut rig, 100).faults, accused, "{context}");
    }
}

#[test]
fn the_second_converter_of_a_brushed_motor_does_not_count() {
    let mut rig = armed(false, 1, LIMIT);
    assert_eq!(rig.run(200).faults, Faults::NONE);
    assert!(rig.is_enabled());
}

/// The generated voltage exceeds that of the supply, so that current flows through the diodes.
#[test]
fn a_shaft_that_something_turns_is_not_accused_of_its_current() {
    for three_phase in [false, true] {
        let mut rig = Rig::new(three_phase, &[]);
        rig.supply_voltage = 12.5;
        rig.load = -8.0;
        rig.word = Some(0);
        let mut largest = 0.0_f32;
        for _ in 0..1_000 {
            rig.run(1);
            let idle = rig.inputs.and_then(|inputs| inputs.electrical.idle);
            let [a, b] = idle.expect("the bridge is open");
            largest = largest.max(a).max(b);
        }
        assert!(f64::from(largest) > 0.05 * LIMIT, "{largest} A");
        rig.word = None;
        for _ in 0..300 {
            let faults = rig.tick().faults;
            assert!(!faults.contains(Fault::InvalidReading), "{three_phase}");
        }
    }
}
