//! Keeps a run to the wall clock.

use std::time::{Duration, Instant};
use tautrack::link::STEP_US;

/// Time that a run may catch up after it was held up, for example by a loaded computer. What is
/// beyond it is lost: no client sees a robot that moves faster than asked for long.
const MAX_BACKLOG: Duration = Duration::from_millis(100);

/// The pace of a run: so many virtual seconds per second at most, or as fast as possible.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    step: Option<Duration>,
    due: Instant,
}

impl Pace {
    /// A pace that begins `now`; `speed` is in virtual seconds per second and above 0, none is
    /// without limit.
    pub fn new(speed: Option<f64>, now: Instant) -> Self {
        let step_s = |speed: f64| STEP_US as f64 * 1e-6 / speed;
        // A speed that makes a step longer than the clock can count is as good as standing still.
        let step = speed.map(|speed| {
            Duration::try_from_secs_f64(step_s(speed)).unwrap_or(Duration::from_secs(86_400))
        });
        Self { step, due: now }
    }

    /// How long to sleep after a step that ends `now`; never longer than the step itself takes at
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
