//! Limits the speed of a run to the wall clock.

use std::time::{Duration, Instant};
use tautrack::link::STEP_US;

/// Maximum delay that a run makes up after an interruption, for example by a loaded computer. A
/// longer delay is not made up, so that clients do not see a robot that moves too fast for long.
const MAX_BACKLOG: Duration = Duration::from_millis(100);

/// Pace of a run: a maximum of virtual seconds per second, or as fast as possible.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    step: Option<Duration>,
    due: Instant,
}

impl Pace {
    /// Creates a pace that starts at `now`. `speed` is in virtual seconds per second and above 0;
    /// `None` means unlimited.
    pub fn new(speed: Option<f64>, now: Instant) -> Self {
        let step_s = |speed: f64| STEP_US as f64 * 1e-6 / speed;
        // If a step is longer than `Duration` can hold, the run practically stands still.
        let step = speed.map(|speed| {
            Duration::try_from_secs_f64(step_s(speed)).unwrap_or(Duration::from_hours(24))
        });
        Self { step, due: now }
    }

    /// Returns how long to sleep after a step that ends at `now`. It is never longer than a step at
    /// this pace.
    pub fn pause(&mut self, now: Instant) -> Duration {
        let Some(step) = self.step else {
            return Duration::ZERO;
        };
        let earliest = now.checked_sub(MAX_BACKLOG).unwrap_or(now);
        self.due = (self.due + step).max(earliest);
        self.due.saturating_duration_since(now).min(step)
    }
}
