//! Images with one defect each, which the model of the chip gives them. A test must find every one
//! of them.

use crate::chip::{
    BDTR, CONTROL, Defect, FDCAN, FLASH_CONTROL, GPIO, IWDG, MOE, PWR, RCC, SYSCFG_CFGR2, TIM1,
    TIMINGR,
};
use crate::stamp;
use crate::{breaks, bus_errors, executed as test, gates, guard, masked, sensors};
use std::panic::catch_unwind;

/// What is wrong, the defect, and the test that finds it.
const DEFECTS: [(&str, Defect, fn()); 36] = [
    (
        "no boost",
        register(PWR + 0x80, 1 << 8, 1 << 8),
        test::the_core_runs_at_170_mhz_from_the_crystal_with_boost_and_four_wait_states,
    ),
    (
        "160 MHz",
        register(RCC + 0x0c, 0x7f << 8, 80 << 8),
        test::the_core_runs_at_170_mhz_from_the_crystal_with_boost_and_four_wait_states,
    ),
    (
        "no prefetch",
        register(FLASH_CONTROL, 1 << 8, 0),
        test::the_core_runs_at_170_mhz_from_the_crystal_with_boost_and_four_wait_states,
    ),
    (
        "no caches of the flash memory",
        register(FLASH_CONTROL, 3 << 9, 0),
        test::the_core_runs_at_170_mhz_from_the_crystal_with_boost_and_four_wait_states,
    ),
    (
        "the guard at the end of the stack is off",
        register(0xe000_ed94, 1, 0),
        gates::a_stack_that_overflows_opens_the_bridge_and_overwrites_nothing,
    ),
    (
        "no dead time",
        register(BDTR, 0xff, 0),
        test::the_bridge_is_centre_aligned_at_20_khz_with_dead_time_and_break,
    ),
    (
        "dead time is not locked",
        register(BDTR, 3 << 8, 0),
        test::the_bridge_is_centre_aligned_at_20_khz_with_dead_time_and_break,
    ),
    (
        "20 005 Hz",
        register(TIM1 + 0x2c, 0xffff, 4249),
        test::the_bridge_is_centre_aligned_at_20_khz_with_dead_time_and_break,
    ),
    (
        "the trigger of the samples is low for two clocks",
        register(TIM1 + 0x40, 0xffff, 4249),
        test::the_trigger_of_the_samples_is_low_for_four_clocks_of_the_converters,
    ),
    (
        "the bridge is live at once",
        register(BDTR, MOE, MOE),
        test::every_gate_is_off_until_the_drive_is_armed,
    ),
    (
        "the bridge stays live in a panic",
        register(BDTR, MOE, MOE),
        test::a_panic_opens_the_bridge_and_the_watchdog_resets_the_chip,
    ),
    (
        "the bridge stays live after a panic",
        register(BDTR, MOE, MOE),
        gates::after_a_panic_the_gates_stay_off_and_the_watchdog_is_named,
    ),
    (
        "the bridge stays live after a hard fault",
        register(BDTR, MOE, MOE),
        gates::after_a_hard_fault_the_gates_stay_off_and_the_watchdog_is_named,
    ),
    (
        "break input is disabled",
        register(BDTR, 1 << 12, 0),
        test::safe_torque_off_opens_the_bridge_until_the_drive_is_disabled,
    ),
    (
        "comparators are not connected",
        register(TIM1 + 0x64, 0x1e, 0),
        breaks::each_comparator_opens_the_bridge,
    ),
    (
        "nothing watches the crystal",
        register(RCC, 1 << 19, 0),
        breaks::a_failed_crystal_opens_the_bridge_and_is_named,
    ),
    (
        "safe torque off has a filter",
        register(BDTR, 0xf << 16, 3 << 16),
        breaks::safe_torque_off_needs_no_clock,
    ),
    (
        "a lock-up is not connected",
        register(SYSCFG_CFGR2, 1, 0),
        breaks::a_core_that_locks_up_opens_the_bridge,
    ),
    (
        "the flash memory is not connected",
        register(SYSCFG_CFGR2, 1 << 3, 0),
        breaks::an_error_of_the_flash_memory_opens_the_bridge,
    ),
    (
        "the supply's detector is off",
        register(PWR + 4, 1, 0),
        breaks::a_low_supply_of_the_chip_opens_the_bridge,
    ),
    (
        "a comparator is not blanked",
        register(0x4001_020c, 7 << 19, 1 << 19),
        breaks::the_comparators_have_a_filter_and_blanking_and_safe_torque_off_has_neither,
    ),
    (
        "safe torque off opens the bridge when it is closed",
        register(TIM1 + 0x60, 1 << 9, 0),
        test::the_bridge_is_centre_aligned_at_20_khz_with_dead_time_and_break,
    ),
    (
        "safe torque off has another function of its pin",
        register(GPIO + 0x24, 0xf << 28, 8 << 28),
        test::every_pin_has_the_function_of_the_page,
    ),
    (
        "the current interrupt is the least urgent one",
        register(0xe000_e410, 0xff << 16, 3 << 20),
        test::the_current_interrupt_is_the_most_urgent_one,
    ),
    (
        "the control task masks all interrupts while it runs",
        Defect::MaskedIn(CONTROL),
        masked::interrupts_are_masked_for_at_most_5_us,
    ),
    (
        "the task of the LED alone feeds the watchdog",
        Defect::FedWith(GPIO + 0x818),
        gates::a_current_interrupt_that_stops_is_a_reset,
    ),
    (
        "the watchdog waits 500 ms",
        register(IWDG + 8, 0xfff, 3999),
        test::a_bus_task_that_hangs_is_reset_within_the_period_of_the_watchdog,
    ),
    (
        "500 kbit/s",
        register(FDCAN + 0x1c, 0x1ff << 16, 1 << 16),
        test::a_bit_on_the_bus_has_170_clocks_and_is_sampled_at_80_percent,
    ),
    (
        "the controller stays off after a bus-off",
        register(FDCAN + 0x54, 1 << 19, 0),
        bus_errors::a_node_recovers_from_bus_off_by_itself,
    ),
    (
        "frames wait for the bus as long as it is gone",
        register(FDCAN + 0xd0, 7, 0),
        bus_errors::frames_that_waited_for_the_bus_for_long_are_not_sent,
    ),
    (
        "low side a is not connected",
        register(GPIO + 0x824, 0xf << 20, 0),
        test::every_pin_has_the_function_of_the_page,
    ),
    (
        "no boost in the guard's board",
        register(PWR + 0x80, 1 << 8, 1 << 8),
        guard::the_core_runs_at_170_mhz_from_the_crystal_of_24_mhz_with_boost,
    ),
    (
        "the watchdog of the guard waits 500 ms",
        register(IWDG + 8, 0xfff, 3999),
        guard::a_guard_without_its_bus_task_or_its_control_task_is_reset,
    ),
    (
        "a bit of the guard has other clocks",
        register(FDCAN + 0x1c, 0x7f, 0),
        guard::a_bit_on_the_bus_has_170_clocks_and_is_sampled_at_80_percent,
    ),
    (
        "the I2C bus of the guard has 1 Mbit/s",
        register(TIMINGR, 0xf << 28, 1 << 28),
        sensors::the_bit_timing_is_that_of_the_fast_mode,
    ),
    (
        "the data line of the I2C bus is not connected",
        register(GPIO + 0x824, 0xf << 4, 0),
        sensors::a_wrong_identity_at_the_start_is_named_within_100_ms_of_power_up,
    ),
];

const fn register(address: u32, mask: u32, value: u32) -> Defect {
    Defect::Register {
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
    for (what, defect, test) in DEFECTS {
        test::DEFECT.set(Some(defect));
        if catch_unwind(test).is_ok() {
            missed.push(what);
        }
        test::DEFECT.set(None);
    }
    assert!(missed.is_empty(), "not found: {missed:?}");
}
