//! Keeps a run and the processes of its nodes on one processor.
//!
//! A run and its native nodes take turns every few microseconds. On one processor a turn costs
//! about a microsecond. With two, the kernel wakes the other one each time, which takes up to 40 us
//! in a virtual machine, and most of the computing time of a run.

use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};
use std::sync::{Mutex, PoisonError};

/// Number of runs of this program on each processor.
static RUNS: Mutex<[usize; CpuSet::MAX_CPU]> = Mutex::new([0; CpuSet::MAX_CPU]);

/// Returns which of the `allowed` processors a run takes: one with the fewest `runs`, and of these
/// the `present` one before the others.
pub fn chosen(
    allowed: impl Iterator<Item = usize>,
    runs: &[usize],
    present: usize,
) -> Option<usize> {
    allowed.min_by_key(|processor| (runs.get(*processor), *processor != present))
}

/// Keeps this thread, and the processes that it starts, on one processor until this is dropped.
pub(super) struct OneProcessor {
    before: CpuSet,
    taken: usize,
}

impl OneProcessor {
    /// Takes the [`chosen`] processor. Returns `None` if the system does not allow it: then a run
    /// only takes longer.
    pub fn take() -> Option<Self> {
        let before = sched_getaffinity(None).ok()?;
        let mut runs = RUNS.lock().unwrap_or_else(PoisonError::into_inner);
        let allowed = (0..CpuSet::MAX_CPU).filter(|processor| before.is_set(*processor));
        let taken = chosen(allowed, &*runs, sched_getcpu())?;
        let mut one = CpuSet::new();
        one.set(taken);
        sched_setaffinity(None, &one).ok()?;
        runs[taken] += 1;
        Some(Self { before, taken })
    }
}

impl Drop for OneProcessor {
    fn drop(&mut self) {
        // A thread that stays on its processor is correct, too.
        let _ = sched_setaffinity(None, &self.before);
        let mut runs = RUNS.lock().unwrap_or_else(PoisonError::into_inner);
        runs[self.taken] = runs[self.taken].saturating_sub(1);
    }
}
