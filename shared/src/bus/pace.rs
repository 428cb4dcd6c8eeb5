//! Finds frames that come more often than their only sender sends them. CAN does not say who sends
//! a frame, so the rate is all that shows a second sender.

/// Rate of the frames with one identifier.
///
/// A sender that is delayed may send two frames at once, and CAN may deliver a frame twice. So one
/// frame may come too much now and then: in sixteen periods.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Time at which the next frame is due if none came early, us.
    due_us: u64,
}

impl Pace {
    /// The rate before the first frame.
    pub const NEW: Self = Self { due_us: 0 };

    /// Records a frame at `now_us`, of a sender with one frame in `period_us`. Returns whether
    /// another node sends frames, too.
    pub fn is_exceeded(&mut self, now_us: u64, period_us: u32) -> bool {
        // Never more than a few periods, because time does not go back.
        let ahead_us = self.due_us.saturating_sub(now_us) as u32;
        let exceeded = ahead_us > period_us + period_us / 2;
        if !exceeded {
            let more_us = ahead_us + period_us - period_us / 16;
            // Microseconds in 64 bits do not wrap.
            self.due_us = now_us.wrapping_add(u64::from(more_us));
        }
        exceeded
    }
}

#[cfg(test)]
mod tests {
    use super::Pace;

    const PERIOD_US: u32 = 4_000;
    /// Time between two looks at the senders, us.
    const STEP: usize = 20;

    /// Returns when the pace is exceeded first, us, within 2 s. `sent` returns how many frames are
    /// sent at a time.
    fn exceeded(sent: impl Fn(u64) -> u32) -> Option<u64> {
        let mut pace = Pace::NEW;
        (1_000_000..3_000_000).step_by(STEP).find(|now_us| {
            (0..sent(*now_us)).fold(false, |found, _| {
                found | pace.is_exceeded(*now_us, PERIOD_US)
            })
        })
    }

    #[test]
    fn one_sender_never_exceeds_its_pace() {
        let every = |period_us: u64| move |now_us: u64| u32::from(now_us.is_multiple_of(period_us));
        assert_eq!(exceeded(every(4_000)), None);
        // Its clock is 2 % fast.
        assert_eq!(exceeded(every(3_920)), None);
        // Every second frame is late by nearly a period.
        assert_eq!(
            exceeded(|now_us| u32::from(matches!(now_us % 8_000, 0 | 7_980))),
            None
        );
        // A frame comes twice now and then.
        assert_eq!(
            exceeded(|now_us| match (now_us % 4_000, now_us % 80_000) {
                (0, 0) => 2,
                (0, _) => 1,
                _ => 0,
            }),
            None
        );
    }

    #[test]
    fn a_second_sender_is_found_at_every_phase() {
        for (period_us, within_us) in [(1_000, 4_000), (4_000, 8_000), (10_000, 30_000)] {
            for phase_us in (0..4_000).step_by(200) {
                let start_us = 2_000_000 + phase_us;
                let found = exceeded(|now_us| {
                    let second =
                        now_us >= start_us && (now_us - start_us).is_multiple_of(period_us);
                    u32::from(now_us.is_multiple_of(4_000)) + u32::from(second)
                });
                let after_us = found.map(|at| at - start_us);
                let soon = after_us.is_some_and(|after_us| after_us <= within_us);
                assert!(soon, "{period_us} us, phase {phase_us} us: {after_us:?}");
            }
        }
    }
}
