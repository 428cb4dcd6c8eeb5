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
    /// Distance of set-point and position, rad; 0 where the mode has no position.
    pub following_error: f32,
    pub powered: bool,
}

/// Bounds of the watches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub current: f32,
    pub velocity: f32,
    pub following: f32,
}

const UNDER_VOLTAGE: f32 = 12.0;
const OVER_VOLTAGE: f32 = 32.0;

/// What is watched, and for how many ticks it must be bad; the first of several counts.
const WATCHES: [(Fault, u8); 6] = [
    (Fault::InvalidReading, 3),
    (Fault::OverCurrent, 5),
    (Fault::OverVoltage, 5),
    (Fault::UnderVoltage, 5),
    (Fault::Blocked, 60),
    (Fault::FollowingError, 100),
];

/// The watches' dwell counters, in ticks.
#[derive(Clone, Debug, Default)]
pub(super) struct Supervisor {
    ticks: [u8; WATCHES.len()],
}

impl Supervisor {
    /// The fault that has lasted its dwell, if any. Comparisons are written so that a NaN counts as bad.
    pub fn check(&mut self, now: &Readings, bounds: &Bounds) -> Option<Fault> {
        let current = now.current.abs();
        let finite = now.current.is_finite() && now.bus_voltage.is_finite();
        let standing = now.velocity.abs() < 0.01 * bounds.velocity;
        let blocked = now.powered && standing && !(now.demand.abs() <= 0.9 * bounds.current);
        // In the order of `WATCHES`.
        let bad = [
            !finite,
            !(current <= 1.25 * bounds.current),
            !(now.bus_voltage <= OVER_VOLTAGE),
            !(now.bus_voltage >= UNDER_VOLTAGE),
            blocked,
            now.powered && !(now.following_error.abs() <= bounds.following),
        ];
        let mut found = None;
        // Backwards, so that the first of several has the last word.
        for watch in (0..WATCHES.len()).rev() {
            let (fault, dwell) = WATCHES[watch];
            let ticks = if bad[watch] {
                self.ticks[watch].saturating_add(1)
            } else {
                0
            };
            self.ticks[watch] = ticks;
            if ticks >= dwell {
                found = Some(fault);
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = Bounds {
        current: 10.0,
        velocity: 6.0,
        following: 0.35,
    };
    const GOOD: Readings = Readings {
        current: 1.0,
        demand: 1.0,
        bus_voltage: 24.0,
        velocity: 1.0,
        following_error: 0.0,
        powered: true,
    };

    fn ticks_until_fault(readings: Readings) -> Option<(usize, Fault)> {
        let mut supervisor = Supervisor::default();
        (1..500).find_map(|tick| {
            supervisor
                .check(&readings, &BOUNDS)
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
                    following_error: -0.4,
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
        let mut supervisor = Supervisor::default();
        let bad = Readings {
            bus_voltage: 40.0,
            ..GOOD
        };
        for tick in 0..100 {
            let now = if tick % 4 == 3 { GOOD } else { bad };
            assert_eq!(supervisor.check(&now, &BOUNDS), None);
        }
    }
}
