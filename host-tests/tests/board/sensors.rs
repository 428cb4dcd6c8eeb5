//! How the image of a guard reads its sensor chips over I2C, and what it does when they fail.

use crate::checks::{field, read};
use crate::chip::{CONTROL, CORE_HZ, Chip, GPIO, I2C3, TIMINGR, Write};
use crate::guard::{BOOT_US, NODE, guard_with};
use crate::stamp;
use std::sync::{Arc, Mutex};
use tautrack::link::ChipFault;

/// Condition of the chips, and the numbers of their errors.
const CONDITION: u16 = 0x2112;
const ERRORS: u16 = 0x2113;
/// Conditions: running, no acknowledge, bus stuck, wrong identity.
const RUNNING: u32 = 1;
const NO_ACKNOWLEDGE: u32 = 2;
const BUS_STUCK: u32 = 3;
const WRONG_IDENTITY: u32 = 5;
/// Port C.
const PORT: u32 = GPIO + 0x800;

/// A guard with its sensor chips, of which the inertial unit has this fault, after its start.
fn with_fault(fault: Option<ChipFault>) -> Chip {
    let mut chip = guard_with(&[]);
    chip.connect_modules();
    chip.acts(|acts| acts.faults[0] = fault);
    chip.run(BOOT_US);
    chip
}

/// An object of inertial unit, magnetometer and inclinometer.
fn all(chip: &mut Chip, object: u16) -> [u32; 3] {
    [1, 2, 3].map(|sub| read(chip, NODE, object, sub) & 0xffff)
}

fn conditions(chip: &mut Chip) -> [u32; 3] {
    all(chip, CONDITION).map(|condition| condition & 0xff)
}

/// Register CR2 of the I2C controller, its bits for start, direction and address, and these bits
/// when a transfer from the inertial unit (address 0x6a) begins.
const I2C_REQUEST: u32 = I2C3 + 0x04;
const I2C_BITS: u32 = 1 << 13 | 1 << 10 | 0xff;
const READ_UNIT: u32 = 1 << 13 | 1 << 10 | 0x6a << 1;

/// Ticks, with the longest time between two of them, core clocks.
#[derive(Default)]
struct Periods {
    running: bool,
    last: Option<u64>,
    longest: u64,
    count: u32,
    /// When the ticks began, core clocks.
    begun: Vec<u64>,
}

const MICROSECOND: u64 = CORE_HZ / 1_000_000;
/// Shortest time between two ticks. A frame makes the node's task run in between, so an earlier run
/// is no tick. A tick that comes too early makes the next time twice as long.
const SHORTEST: u64 = 990 * MICROSECOND;

/// Measures the time between two ticks from now on.
fn measure(chip: &mut Chip) -> Arc<Mutex<Periods>> {
    let periods = Arc::new(Mutex::new(Periods::default()));
    let watcher = Arc::clone(&periods);
    chip.watch(move |now| {
        let mut periods = watcher.lock().expect("periods");
        // More urgent interrupts interrupt a run, and do not end it.
        let since = |last: u64| now.clock - last;
        let begins = now.exception == 16 + CONTROL
            && !periods.running
            && periods.last.is_none_or(|last| since(last) >= SHORTEST);
        if now.exception == 16 + CONTROL {
            periods.running = true;
        } else if now.exception == 0 {
            periods.running = false;
        }
        if begins {
            if let Some(last) = periods.last {
                periods.longest = periods.longest.max(since(last));
                periods.count += 1;
            }
            periods.last = Some(now.clock);
            periods.begun.push(now.clock);
        }
    });
    periods
}

/// Checks that the control task ran every millisecond, with a deviation of 10 us.
fn keeps_its_period(periods: &Mutex<Periods>) {
    let periods = periods.lock().expect("periods");
    let longest = periods.longest;
    println!("at most {longest} clocks, {} times", periods.count);
    assert!(periods.count > 100, "{}", periods.count);
    assert!(longest <= 1_010 * MICROSECOND, "{longest} clocks");
}

/// Checks that each transfer from the inertial unit begins at the same time after a tick, within
/// 50 us, however long the tick takes. Otherwise up to half of the readings of a chip that measures
/// at about the same rate are lost. The first 100 ms are those in which the chips are started.
fn is_read_at_one_moment(chip: &Chip, periods: &Mutex<Periods>) {
    let begun = &periods.lock().expect("periods").begun;
    let of_unit = |write: &&Write| {
        write.clock > 100_000 * MICROSECOND
            && write.address == I2C_REQUEST
            && write.value & I2C_BITS == READ_UNIT
    };
    let writes = chip.writes();
    let after = |write: &Write| {
        let ticks = begun.partition_point(|begun| *begun <= write.clock);
        write.clock - begun[ticks - 1]
    };
    let after: Vec<u64> = writes.iter().filter(of_unit).map(after).collect();
    let [first, last] = [after.iter().min(), after.iter().max()]
        .map(|clocks| clocks.expect("transfers") / MICROSECOND);
    println!(
        "{} transfers, {first} us to {last} us after a tick",
        after.len()
    );
    assert!(after.len() > 1_000, "{}", after.len());
    assert!(last - first <= 50, "{first} us to {last} us");
}

#[test]
fn all_chips_are_started_and_their_readings_reach_the_guard() {
    let Some(_stamp) = stamp("all_chips_are_started_and_their_readings_reach_the_guard") else {
        return;
    };
    let mut chip = with_fault(None);
    let periods = measure(&mut chip);
    chip.acts(|acts| {
        acts.specific_force = [1.5, -2.0, 9.5];
        acts.tilt_force = [1.0, 0.0, 9.5];
    });
    for turn in 0..40_u8 {
        // The noise of a chip.
        chip.acts(|acts| acts.angular_rate = [0.002 * f32::from(turn % 3); 3]);
        chip.run(30_000);
    }
    assert_eq!(conditions(&mut chip), [RUNNING; 3]);
    assert_eq!(all(&mut chip, ERRORS), [0; 3]);
    keeps_its_period(&periods);
    is_read_at_one_moment(&chip, &periods);
    // Rates of inclinometer, accelerometer and gyroscope, 0.1 Hz.
    let rates = [1, 2, 3].map(|sub| read(&mut chip, NODE, 0x2101, sub) & 0xffff);
    for (rate, wanted) in rates.into_iter().zip([1_000, 10_000, 10_000]) {
        // A reading is lost when a transfer to another chip delays it into the next millisecond.
        assert!((wanted * 95 / 100..=wanted).contains(&rate), "{rates:?}");
    }
    // Age of the magnetometer, ms: it measures 10 times a second.
    let age = read(&mut chip, NODE, 0x2102, 4) & 0xffff;
    assert!(age <= 120, "{age}");
    // The emergency stop trips the guard, which keeps inclination (0.01 degree) and specific force
    // (0.01 m/s^2).
    chip.pins(|pins| pins.port_c |= 1 << 10);
    chip.run(50_000);
    let kept = [11, 12, 13, 14, 15].map(|sub| read(&mut chip, NODE, 0x4007, sub) as i16);
    // atan(1 / 9.5) is 6.01 degrees.
    for (got, wanted) in kept.into_iter().zip([601_i16, 0, 150, -200, 950]) {
        assert!(got.abs_diff(wanted) <= 2, "{kept:?}");
    }
    assert_eq!(chip.resets(), 0);
}

/// A fault of the inertial unit begins while all chips run. It is named within 40 ms, the
/// others have `other` within 600 ms, and all run again after its end: the inertial unit within
/// 100 ms, the others within 200 ms.
fn named(fault: ChipFault, condition: u32, other: u32) {
    let mut chip = with_fault(None);
    let periods = measure(&mut chip);
    chip.run(60_000);
    assert_eq!(conditions(&mut chip), [RUNNING; 3]);
    chip.acts(|acts| acts.faults[0] = Some(fault));
    chip.run(37_000);
    assert_eq!(read(&mut chip, NODE, CONDITION, 1) & 0xff, condition);
    chip.run(554_000);
    assert_eq!(conditions(&mut chip), [condition, other, other]);
    let errors = all(&mut chip, ERRORS);
    assert!(errors[0] > 10, "{errors:?}");
    chip.acts(|acts| acts.faults[0] = None);
    chip.run(97_000);
    assert_eq!(read(&mut chip, NODE, CONDITION, 1) & 0xff, RUNNING);
    chip.run(97_000);
    assert_eq!(conditions(&mut chip), [RUNNING; 3]);
    keeps_its_period(&periods);
    assert_eq!(chip.resets(), 0);
}

#[test]
fn a_chip_that_holds_the_bus_is_named_in_40_ms_and_freed_with_clock_pulses_and_no_tick_waits() {
    named(ChipFault::BusStuck, BUS_STUCK, BUS_STUCK);
}

#[test]
fn a_chip_that_does_not_acknowledge_is_named_in_40_ms_and_the_others_are_read() {
    named(ChipFault::NoAcknowledge, NO_ACKNOWLEDGE, RUNNING);
}

#[test]
pub fn a_wrong_identity_at_the_start_is_named_within_100_ms_of_power_up() {
    let mut chip = with_fault(Some(ChipFault::WrongIdentity));
    chip.run(94_000 - BOOT_US);
    assert_eq!(conditions(&mut chip), [WRONG_IDENTITY, RUNNING, RUNNING]);
}

#[test]
fn without_modules_no_chip_acknowledges() {
    let mut chip = guard_with(&[]);
    chip.run(94_000);
    assert_eq!(conditions(&mut chip), [NO_ACKNOWLEDGE; 3]);
}

#[test]
pub fn the_bit_timing_is_that_of_the_fast_mode() {
    let chip = with_fault(None);
    let timing = chip.register(TIMINGR);
    // Nanoseconds of a number of units.
    let unit = 1e9 / CORE_HZ as f64 * f64::from(field(timing, 28, 4) + 1);
    let time = |low, bits| f64::from(field(timing, low, bits) + 1) * unit;
    // NXP UM10204, table of the timing in fast mode: low and high period, and the data's set-up
    // time with a rise time of 300 ns.
    let (low, high) = (time(0, 8), time(8, 8));
    assert!(low >= 1_300.0 && high >= 600.0, "{low} and {high} ns");
    assert!(time(20, 4) >= 100.0 + 300.0, "{} ns", time(20, 4));
    // At most 400 kbit/s, and not much less: each edge is recognized after 50 ns and two clocks at
    // least.
    let period = low + high + 2.0 * (50.0 + 2.0 * 1e3 / 170.0);
    assert!((2_500.0..2_600.0).contains(&period), "{period} ns");
    // The data line changes at least 300 ns after the falling edge, of which the filter takes 50 ns
    // and the controller three clocks; and at most 900 ns after it, of which the rise takes 300 ns,
    // the filter 260 ns and the controller four clocks.
    let hold = f64::from(field(timing, 16, 4)) * unit;
    assert!(hold >= 300.0 - 50.0 - 3.0 * 1e3 / 170.0, "{hold} ns");
    assert!(
        hold <= 900.0 - 300.0 - 260.0 - 4.0 * 1e3 / 170.0,
        "{hold} ns"
    );
}

#[test]
fn both_lines_are_open_drain_with_pull_up_resistors() {
    let chip = with_fault(None);
    for pin in [8, 9] {
        assert_eq!(field(chip.register(PORT + 0x04), pin, 1), 1, "{pin}");
        assert_eq!(field(chip.register(PORT + 0x0c), 2 * pin, 2), 1, "{pin}");
    }
}
