//! What the motor board derives from its resistors, against what others measured or computed.

use crate::executed::{NODE, with_pages};
use crate::images::programs;
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
