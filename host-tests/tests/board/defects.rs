//! Images that write another value to one register: the model changes the writes. A test must find
//! every one of them.

use crate::chip::{BDTR, FDCAN, GPIO, IWDG, MOE, PWR, Patch, RCC, TIM1, TIMINGR};
use crate::stamp;
use crate::{executed as test, guard, sensors};
use std::panic::catch_unwind;

/// What is wrong, the patch, and the test that finds it.
const DEFECTS: [(&str, Patch, fn()); 17] = [
    (
        "no boost",
        patch(PWR + 0x80, 1 << 8, 1 << 8),
        test::the_core_runs_at_170_mhz_from_the_crystal_with_boost_and_four_wait_states,
    ),
    (
        "160 MHz",
        patch(RCC + 0x0c, 0x7f << 8, 80 << 8),
        test::the_core_runs_at_170_mhz_from_the_crystal_with_boost_and_four_wait_states,
    ),
    (
        "no dead time",
        patch(BDTR, 0xff, 0),
        test::the_bridge_is_centre_aligned_at_20_khz_with_dead_time_and_break,
    ),
    (
        "dead time is not locked",
        patch(BDTR, 3 << 8, 0),
        test::the_bridge_is_centre_aligned_at_20_khz_with_dead_time_and_break,
    ),
    (
        "20 005 Hz",
        patch(TIM1 + 0x2c, 0xffff, 4249),
        test::the_bridge_is_centre_aligned_at_20_khz_with_dead_time_and_break,
    ),
    (
        "the bridge is live at once",
        patch(BDTR, MOE, MOE),
        test::every_gate_is_off_until_the_drive_is_armed,
    ),
    (
        "the bridge stays live in a panic",
        patch(BDTR, MOE, MOE),
        test::a_panic_opens_the_bridge_and_the_watchdog_resets_the_chip,
    ),
    (
        "break input is disabled",
        patch(BDTR, 1 << 12, 0),
        test::a_break_opens_the_bridge_until_the_drive_is_disabled,
    ),
    (
        "comparators are not connected",
        patch(TIM1 + 0x60, 0x1e, 0),
        test::a_break_opens_the_bridge_until_the_drive_is_disabled,
    ),
    (
        "the watchdog waits 500 ms",
        patch(IWDG + 8, 0xfff, 3999),
        test::a_bus_task_that_hangs_is_reset_within_the_period_of_the_watchdog,
    ),
    (
        "500 kbit/s",
        patch(FDCAN + 0x1c, 0x1ff << 16, 1 << 16),
        test::a_bit_on_the_bus_has_170_clocks_and_is_sampled_at_80_percent,
    ),
    (
        "low side a is not connected",
        patch(GPIO + 0x824, 0xf << 20, 0),
        test::every_pin_has_the_function_of_the_page,
    ),
    (
        "no boost in the guard's board",
        patch(PWR + 0x80, 1 << 8, 1 << 8),
        guard::the_core_runs_at_170_mhz_from_the_crystal_of_24_mhz_with_boost,
    ),
    (
        "the watchdog of the guard waits 500 ms",
        patch(IWDG + 8, 0xfff, 3999),
        guard::a_guard_without_its_bus_task_or_its_control_task_is_reset,
    ),
    (
        "a bit of the guard has other clocks",
        patch(FDCAN + 0x1c, 0x7f, 0),
        guard::a_bit_on_the_bus_has_170_clocks_and_is_sampled_at_80_percent,
    ),
    (
        "the I2C bus of the guard has 1 Mbit/s",
        patch(TIMINGR, 0xf << 28, 1 << 28),
        sensors::the_bit_timing_is_that_of_the_fast_mode,
    ),
    (
        "the data line of the I2C bus is not connected",
        patch(GPIO + 0x824, 0xf << 4, 0),
        sensors::a_wrong_identity_at_the_start_is_named_within_100_ms_of_power_up,
    ),
];

const fn patch(address: u32, mask: u32, value: u32) -> Patch {
    Patch {
        address,
        mask,
        value,
    }
}

#[test]
fn every_defect_is_found() {
    let Some(_stamp) = stamp("every_defect_is_found") else {
        return;
    };
    let mut missed = Vec::new();
    for (what, patch, test) in DEFECTS {
        test::DEFECT.set(Some(patch));
        if catch_unwind(test).is_ok() {
            missed.push(what);
        }
        test::DEFECT.set(None);
    }
    assert!(missed.is_empty(), "not found: {missed:?}");
}
