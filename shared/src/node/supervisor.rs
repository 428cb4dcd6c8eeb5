//! Watches one axle's readings; each watch has a dwell, so that no single sample trips.

use crate::faults::Fault;

/// One tick's readings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Readings {
    pub current: f32,
    /// Current that was asked for. A motor that runs away behind a frozen encoder takes less than it is given.
    pub demand: f32,
    pub bus_voltage: f32,
    pub velocity: f32,
    /// Distance of set-point and position, 2^-32 turn; 0 where the mode has no position.
    pub following_error: i64,
    pub powered: bool,
}

/// Bounds of the watches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    over_current: f32,
    /// Demand above which a motor must turn, and the speed below which it does not.
    pushing: f32,
    standing: f32,
    following: u64,
}

const UNDER_VOLTAGE: f32 = 12.0;
const OVER_VOLTAGE: f32 = 32.0;

/// What is watched, and for how many ticks it must be bad, at most 127; the first of several counts.
const WATCHES: [(Fault, u8); 6] = [
    (Fault::InvalidReading, 3),
    (Fault::OverCurrent, 5),
    (Fault::OverVoltage, 5),
    (Fault::UnderVoltage, 5),
    (Fault::Blocked, 60),
    (Fault::FollowingError, 100),
];

/// The top bit of every byte: a dwell is over.
const OVER: u32 = 0x8080_8080;
const ONE_EACH: u32 = 0x0101_0101;

/// Where the counters start, a byte for each watch: so far below the top bit as the dwell is long.
const START: [u32; 2] = {
    let mut start = [0; 2];
    let mut watch = 0;
    while watch < WATCHES.len() {
        start[watch / 4] |= (0x80 - WATCHES[watch].1 as u32) << (8 * (watch % 4));
        watch += 1;
    }
    start
};

/// The watches' dwell counters: bytes, of which four are counted at once.
#[derive(Clone, Debug)]
pub(super) struct Supervisor {
    counters: [u32; 2],
}

impl Default for Supervisor {
    fn default() -> Self {
        Self { counters: START }
    }
}

impl Bounds {
    /// Bounds by the axle's limits: current, A; velocity, rad/s; distance of set-point and position, 2^-32 turn.
    pub fn new(current: f32, velocity: f32, following: i64) -> Self {
        Self {
            over_current: 1.25 * current,
            pushing: 0.9 * current,
            standing: 0.01 * velocity,
            following: following.unsigned_abs(),
        }
    }
}

impl Supervisor {
    /// The fault that has lasted its dwell, if any. Comparisons are written so that a NaN counts as bad.
    pub fn check(&mut self, now: &Readings, bounds: &Bounds) -> Option<Fault> {
        let current = now.current.abs();
        // No reading is so large that the sum of two has no room.
        let finite = current + now.bus_voltage.abs() < f32::INFINITY;
        let standing = now.velocity.abs() < bounds.standing;
        let blocked = now.powered && standing && !(now.demand.abs() <= bounds.pushing);
        // In the order of `WATCHES`.
        let bad = [
            !finite,
            !(current <= bounds.over_current),
            !(now.bus_voltage <= OVER_VOLTAGE),
            !(now.bus_voltage >= UNDER_VOLTAGE),
            blocked,
            now.powered && now.following_error.unsigned_abs() > bounds.following,
        ];
        let mut counting = [0; 2];
        for (watch, bad) in bad.into_iter().enumerate() {
            if bad {
                counting[watch / 4] |= 0xff << (8 * (watch % 4));
            }
        }
        for word in 0..2 {
            let counter = self.counters[word];
            // One whose dwell is over stays where it is.
            let next = counter + (ONE_EACH & !(counter >> 7));
            self.counters[word] = next & counting[word] | START[word] & !counting[word];
        }
        let [first, second] = self.counters.map(|counters| counters & OVER);
        if first | second == 0 {
            return None;
        }
        let over = u64::from(second) << 32 | u64::from(first);
        let (fault, _) = WATCHES.get(over.trailing_zeros() as usize / 8)?;
        Some(*fault)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: Readings = Readings {
        current: 1.0,
        demand: 1.0,
        bus_voltage: 24.0,
        velocity: 1.0,
        following_error: 0,
        powered: true,
    };

    fn ticks_until_fault(readings: Readings) -> Option<(usize, Fault)> {
        let (mut supervisor, bounds) = (Supervisor::default(), Bounds::new(10.0, 6.0, 400));
        (1..500).find_map(|tick| {
            supervisor
                .check(&readings, &bounds)
                .map(|fault| (tick, fault))
        })
    }

    #[test]
    fn each_bad_reading_raises_its_fault_after_its_dwell() {
        assert_eq!(ticks_until_fault(GOOD), None);
        let cases = [
            (
                Readings {
                    current: f32::NAN,
                    ..GOOD
                },
                3,
                Fault::InvalidReading,
            ),
            (
                Readings {
                    current: -13.0,
                    ..GOOD
                },
                5,
                Fault::OverCurrent,
            ),
            (
                Readings {
                    bus_voltage: 33.0,
                    ..GOOD
                },
                5,
                Fault::OverVoltage,
            ),
            (
                Readings {
                    bus_voltage: 11.0,
                    ..GOOD
                },
                5,
                Fault::UnderVoltage,
            ),
            (
                Readings {
                    demand: -9.5,
                    velocity: 0.0,
                    ..GOOD
                },
                60,
                Fault::Blocked,
            ),
            (
                Readings {
                    following_error: -401,
                    ..GOOD
                },
                100,
                Fault::FollowingError,
            ),
        ];
        for (readings, tick, fault) in cases {
            assert_eq!(ticks_until_fault(readings), Some((tick, fault)));
        }
    }

    #[test]
    fn one_good_sample_starts_the_dwell_anew() {
        let (mut supervisor, bounds) = (Supervisor::default(), Bounds::new(10.0, 6.0, 400));
        let bad = Readings {
            bus_voltage: 40.0,
            ..GOOD
        };
        for tick in 0..100 {
            let now = if tick % 4 == 3 { GOOD } else { bad };
            assert_eq!(supervisor.check(&now, &bounds), None);
        }
    }
}
