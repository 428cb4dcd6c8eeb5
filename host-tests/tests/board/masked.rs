//! How long the images mask all interrupts, from the first interrupt on: before it, the library
//! starts the clocks with masked interrupts.

use crate::chip::{CORE_HZ, Executed};
use crate::executed::{armed_axle_watched, read};
use crate::guard;
use crate::stamp;
use std::sync::{Arc, Mutex};

/// Longest time for which all interrupts may be masked, us.
const LIMIT_US: u64 = 5;

/// Longest masked time, core clocks, with the address behind it, and the number of masked times.
#[derive(Clone, Copy, Default, Debug)]
struct Masked {
    /// There was an interrupt: the chip has started.
    started: bool,
    since: Option<u64>,
    longest: u64,
    end: u32,
    count: u32,
}

impl Masked {
    fn note(&mut self, now: Executed) {
        self.started |= now.exception != 0;
        match (now.masked && self.started, self.since) {
            (true, None) => self.since = Some(now.clock),
            (false, Some(since)) => {
                self.since = None;
                self.count += 1;
                if now.clock - since > self.longest {
                    self.longest = now.clock - since;
                    self.end = now.next;
                }
            }
            _ => {}
        }
    }
}

#[test]
pub fn interrupts_are_masked_for_at_most_5_us() {
    check(5_000, |watcher| {
        let mut chip = armed_axle_watched(watcher);
        for object in [0x1000, 0x6041, 0x6064, 0x603f] {
            read(&mut chip, object);
        }
        chip.run(100_000);
    });
}

#[test]
fn the_guard_masks_interrupts_for_at_most_5_us() {
    let Some(_stamp) = stamp("the_guard_masks_interrupts_for_at_most_5_us") else {
        return;
    };
    check(1_000, |watcher| {
        let mut chip = guard::guard_watched(watcher);
        guard::drive(&mut chip);
    });
}

/// Runs an image that calls this watcher, and masks interrupts at least this often.
fn check(least: u32, run: impl FnOnce(Box<dyn FnMut(Executed) + Send>)) {
    let masked = Arc::new(Mutex::new(Masked::default()));
    let watcher = Arc::clone(&masked);
    run(Box::new(move |now| {
        watcher.lock().expect("a count").note(now);
    }));
    let masked = *masked.lock().expect("a count");
    println!(
        "masked {} times, for at most {} clocks, until {:#x}",
        masked.count, masked.longest, masked.end
    );
    assert!(masked.count > least, "{masked:?}");
    assert!(
        masked.longest * 1_000_000 <= LIMIT_US * CORE_HZ,
        "{masked:x?}"
    );
}
