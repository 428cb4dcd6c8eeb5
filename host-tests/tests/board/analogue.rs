//! What the motor board derives from its resistors, against what others measured or computed.

use crate::checks::field;
use crate::chip::{ADC_CONTROL, CORE_HZ, Chip, TIM1};
use crate::executed::{NODE, arm, read, running_axle, with_pages, write};
use crate::images::programs;
use crate::index::with_three_phase_motor;
use tautrack::settings::Setting;
use tautrack_host_tests::programs::settings_pages::Pages;

#[allow(dead_code)] // a part of it is tested
#[path = "../../../firmware/src/boards/esc1/analogue.rs"]
mod board;

/// Data of the converter DAC3 for comparator 1, and for the comparators 2 and 4.
pub const THRESHOLDS: [u32; 2] = [0x5000_1008, 0x5000_1014];

#[test]
fn the_network_gives_the_zero_and_the_scale_that_others_computed() {
    // 0.129 V at the inputs, 2.06 V at the output.
    assert!((board::ZERO - 24_687).abs() <= 5, "{}", board::ZERO);
    // Half of 3.3 V, at 3 mOhm times 64/7.
    assert!((board::FULL_SCALE_AMPERES - 60.16).abs() < 0.01);
    // Code 249 trips at 42 A: 150 % of 22.7 A, and 8 A.
    assert!((i32::from(board::threshold(24_687, 22.67)) - 249).abs() <= 1);
}

#[test]
fn the_comparators_follow_the_zero_and_the_current_limit_of_the_settings() {
    // The bias is the op-amp's output, divided by 16. Each ampere adds 4/7 of 3 mV.
    let code = |zero: f64, limit: f64| {
        let bias = 3.3 * (65_535.0 - zero) / 65_536.0 / 16.0;
        (bias + 1.714_286e-3 * (1.5 * limit + 8.0)) / 3.3 * 4_096.0
    };
    for (zeros, limit) in [
        ([24_687, 24_687], 10_000),
        ([32_700, 32_000], 2_000),
        ([24_687, 32_700], 30_000),
    ] {
        let mut pages = Pages::erased();
        let settings = [
            (Setting::NodeId, NODE.into()),
            (Setting::CurrentZeroA, zeros[0]),
            (Setting::CurrentZeroB, zeros[1]),
            (Setting::CurrentLimit, limit),
        ];
        pages.save(&settings).expect("settings");
        let mut chip = with_pages(&programs().axle, &pages.0);
        chip.run(20_000);
        for (register, zero) in THRESHOLDS.into_iter().zip(zeros) {
            let wanted = code(f64::from(zero), f64::from(limit) / 1e3);
            let got = f64::from(chip.register(register) & 0xfff);
            assert!(
                (got - wanted).abs() <= 1.0,
                "{zero} {limit}: {got}, {wanted}"
            );
        }
    }
}

/// Registers of the converters, and what they sample: converter, and channel of an op-amp's output.
const CONVERTERS: [u32; 2] = [0x5000_0000, 0x5000_0100];
const OP_AMPS: [[u32; 2]; 2] = [[3, 12], [3, 3]];

#[test]
fn the_converters_sample_each_op_amp_long_enough_while_its_low_side_conducts() {
    let chip = running_axle();
    let dividers = [1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256];
    let divider = dividers[field(chip.register(ADC_CONTROL), 18, 4) as usize];
    let clock = f64::from(divider) / CORE_HZ as f64;
    let times = [2.5, 6.5, 12.5, 24.5, 47.5, 92.5, 247.5, 640.5];
    // The trigger comes behind the overflow of the counter.
    let behind = chip.register(TIM1 + 0x2c) - chip.register(TIM1 + 0x40);
    for (converter, channels) in CONVERTERS.into_iter().zip(OP_AMPS) {
        let sequence = chip.register(converter + 0x4c);
        let mut end = f64::from(behind) / CORE_HZ as f64;
        for (rank, channel) in (0..).zip(channels) {
            assert_eq!(field(sequence, 9 + 6 * rank, 5), channel);
            let register = converter + 0x14 + 4 * (channel / 10);
            let time = times[field(chip.register(register), 3 * (channel % 10), 3) as usize];
            // Data sheet DS12589: sampling time of an op-amp's output.
            assert!(time * clock >= 200e-9, "{:.0} ns", time * clock * 1e9);
            // A dead time and the settling time of the op-amp pass before the overflow, and as much
            // behind it.
            assert!(end + time * clock <= 1.9e-6, "{end} s");
            end += (time + 12.5) * clock;
        }
    }
}

/// Starts a calibration of a disarmed axle, and lets its client stay for this number of requests of
/// 3 ms.
fn calibrate(chip: &mut Chip, requests: u32) {
    write(chip, 0x6060, 0, &[9]);
    write(chip, 0x6040, 0, &[0, 0]);
    write(chip, 0x2001, 0, &[1]);
    write(chip, 0x2050, 0, &[1]);
    for _ in 0..requests {
        write(chip, 0x6040, 0, &[0, 0]);
    }
    let [progress, reason] = [0x2051, 0x2052].map(|object| read(chip, object) & 0xff);
    assert_eq!((progress, reason), (1, 0), "measures the zero");
}

/// A chip with a three-phase motor whose encoder has an index, and with these settings.
fn with_motor(more: &[(Setting, i32)]) -> Chip {
    let encoder = [(Setting::RotorSensor, 3), (Setting::AlignmentTravel, 1_000)];
    with_three_phase_motor(&[&encoder, more].concat())
}

#[test]
fn a_calibration_gives_the_comparators_the_zero_that_it_finds() {
    let mut chip = with_motor(&[(Setting::CurrentLimit, 13_000)]);
    // Half of the range.
    chip.pins(|pins| pins.zeros[0] = 1.65);
    chip.run(20_000);
    calibrate(&mut chip, 75);
    for (register, zero) in THRESHOLDS.into_iter().zip([32_768, 24_687]) {
        let (code, wanted) = (chip.register(register), board::threshold(zero, 13.0));
        assert!(code.abs_diff(wanted.into()) <= 1, "{code}, {wanted}");
    }
}

/// The pin of a comparator idles at 0.129 V, and a small current is a threshold close to it.
#[test]
fn a_calibration_with_a_small_current_limit_drives_the_bridge_after_the_zero_is_known() {
    let mut chip = with_motor(&[(Setting::CurrentLimit, 2_000)]);
    chip.run(20_000);
    calibrate(&mut chip, 80);
    assert!(chip.is_live());
}

#[test]
fn each_converter_may_have_a_zero_of_its_own() {
    // 6 A, twice the largest sum of the currents, are 0.164 V.
    let mut chip = with_motor(&[]);
    chip.pins(|pins| pins.zeros[2] += 0.164);
    chip.run(100_000);
    arm(&mut chip);
    for _ in 0..30 {
        write(&mut chip, 0x6040, 0, &[15, 0]);
    }
    assert_eq!(read(&mut chip, 0x603f), 0);
    assert!(chip.is_live());
}
