//! Keeps a test and its node on one processor. They take turns every few microseconds, and to wake
//! another processor for each takes longer than the turn.

#[cfg(target_os = "linux")]
use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};

/// Keeps this thread, and the processes that it starts, on one processor until this is dropped.
#[cfg(target_os = "linux")]
pub struct OneProcessor(CpuSet);

/// Other systems do not allow it. A test only takes longer there.
#[cfg(not(target_os = "linux"))]
pub struct OneProcessor;

impl OneProcessor {
    /// Stays on the present processor, if the system allows it.
    pub fn present() -> Option<Self> {
        #[cfg(target_os = "linux")]
        {
            let before = sched_getaffinity(None).ok()?;
            let mut present = CpuSet::new();
            present.set(sched_getcpu());
            sched_setaffinity(None, &present).ok()?;
            Some(Self(before))
        }
        #[cfg(not(target_os = "linux"))]
        None
    }
}

#[cfg(target_os = "linux")]
impl Drop for OneProcessor {
    fn drop(&mut self) {
        let _ = sched_setaffinity(None, &self.0);
    }
}
