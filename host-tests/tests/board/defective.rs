//! Images with one defect each: the program `defective_axle` has them all, and a byte in its flash
//! memory selects one. A named test must find every one of them.

#[allow(unexpected_cfgs)] // a feature of the firmware
#[path = "../../../firmware/src/boards/stm32g4/defect.rs"]
mod defect;

use crate::images::programs;
use crate::stamp;
use crate::{bus_errors, executed, gates, masked};
pub use defect::Defect;
use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSymbol};
use std::fs;
use std::panic::catch_unwind;
use std::sync::OnceLock;
use tautrack_host_tests::programs::{Program, defective_axle};

/// Each defect, and the test that finds it.
const DEFECTS: [(Defect, fn()); 14] = [
    (
        Defect::NoBoost,
        executed::the_core_runs_at_170_mhz_from_the_crystal_with_boost_and_four_wait_states,
    ),
    (
        Defect::SlowWatchdog,
        executed::a_bus_task_that_hangs_is_reset_within_the_period_of_the_watchdog,
    ),
    (
        Defect::FedByOneParty,
        gates::a_current_interrupt_that_stops_is_a_reset,
    ),
    (
        Defect::LiveInFault,
        gates::after_a_panic_the_gates_stay_off_and_the_watchdog_is_named,
    ),
    (
        Defect::LiveAtStart,
        executed::every_gate_is_off_until_the_drive_is_armed,
    ),
    (
        Defect::NoDeadTime,
        executed::the_bridge_is_centre_aligned_at_20_khz_with_dead_time_and_break,
    ),
    (
        Defect::OtherPeriod,
        executed::the_bridge_is_centre_aligned_at_20_khz_with_dead_time_and_break,
    ),
    (
        Defect::InvertedBreak,
        executed::the_bridge_is_centre_aligned_at_20_khz_with_dead_time_and_break,
    ),
    (
        Defect::WrongFunction,
        executed::every_pin_has_the_function_of_the_page,
    ),
    (
        Defect::LowPriority,
        executed::the_current_interrupt_is_the_most_urgent_one,
    ),
    (
        Defect::MaskedLong,
        masked::interrupts_are_masked_for_at_most_5_us,
    ),
    (
        Defect::SlowBus,
        executed::a_bit_on_the_bus_has_170_clocks_and_is_sampled_at_80_percent,
    ),
    (
        Defect::NoRecovery,
        bus_errors::a_node_recovers_from_bus_off_by_itself,
    ),
    (
        Defect::OldFrames,
        bus_errors::frames_that_waited_for_the_bus_for_long_are_not_sent,
    ),
];

/// The program with the defects, built once.
pub fn program() -> &'static Program {
    static PROGRAM: OnceLock<Program> = OnceLock::new();
    PROGRAM.get_or_init(|| defective_axle().unwrap_or_else(|error| panic!("{error}")))
}

/// Runs a test on the program with a defect. Returns whether the test passes.
fn passes(defect: Option<Defect>, test: fn()) -> bool {
    executed::BUILT_IN.set(defect);
    let passed = catch_unwind(test).is_ok();
    executed::BUILT_IN.set(None);
    passed
}

#[test]
fn every_defect_of_a_program_is_found() {
    let Some(_stamp) = stamp("every_defect_of_a_program_is_found") else {
        return;
    };
    let missed: Vec<_> = DEFECTS
        .into_iter()
        .filter(|(defect, test)| passes(Some(*defect), *test))
        .map(|(defect, _)| defect)
        .collect();
    assert!(missed.is_empty(), "not found: {missed:?}");
}

#[test]
fn no_image_that_is_flashed_has_a_defect_to_select() {
    let names = |program: &Program| {
        let elf = fs::read(&program.path).expect("a program");
        let file = ElfFile32::<Endianness>::parse(&*elf).expect("an ELF file");
        let symbols = file.symbols();
        let names = symbols.filter(|symbol| symbol.name().is_ok_and(|it| it.contains("DEFECT")));
        names.count()
    };
    let flashed = programs();
    assert_eq!(names(&flashed.axle) + names(&flashed.screw), 0);
    assert_eq!(names(program()), 1);
}
