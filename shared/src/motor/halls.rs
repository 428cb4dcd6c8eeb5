//! Rotor angle from three Hall sensors, 120 electrical degrees apart.
//!
//! Their code divides an electrical turn into six sectors. Between two edges, the angle goes on at
//! the mean speed of the last sectors: of as many as took 100 readings, and of six at most. So at
//! high speed, neither the places of the sensors nor the rate of the readings count. A motor that
//! stands, or has turned round, counts as in the middle of its sector, which is wrong by at most 30
//! degrees.
//!
//! A code of a sector that is no neighbour does not count before it has stayed for three readings:
//! one wrong code turns no rotor. If it stays, it counts as the shorter way. The sector on the
//! opposite side has no shorter way: then the position is lost, and the sensors count as broken.

#[cfg(feature = "lockstep")]
use crate::units::Angle;

/// Counts of an electrical turn, as [`Halls::update`] returns them.
pub const COUNTS_PER_ELECTRICAL_TURN: i32 = 6 * SECTOR;
/// Counts of a sector.
pub const SECTOR: i32 = 64;
/// Number of the sector of each code. The codes 0 and 7 do not exist.
const SECTORS: [i8; 8] = [NONE, 0, 2, 1, 4, 5, 3, NONE];
const NONE: i8 = -1;
/// Distance of two sectors on opposite sides.
const OPPOSITE: i32 = 3;
/// Score of a reading that no working sensors give, and the score at which they are broken: ten
/// such readings in a row, or one reading of six for 80 readings. So switching lines and single
/// disturbed readings do not count, and a line without signal counts at every speed.
const WRONG: u8 = 20;
const BROKEN: u8 = 200;
/// Readings after which a code that is no neighbour counts.
const STAYS: u8 = 3;
/// Time in a sector that shows no speed any more: the rotor has stood.
const LONGEST: u32 = 4_000;
/// Time that is long enough to show the speed.
const ENOUGH: u32 = 100;

/// Times in the last sectors through which the rotor has turned in one direction.
#[derive(Clone, Debug, Default)]
struct Spent {
    /// The newest first; 0 where it is not known.
    times: [u32; 6],
    /// Number of the newest sectors that show the speed, and the time in them.
    sectors: u32,
    total: u32,
}

impl Spent {
    const fn new() -> Self {
        Self {
            times: [0; 6],
            sectors: 0,
            total: 0,
        }
    }

    /// Adds the time in a sector.
    fn push(&mut self, time: u32) {
        self.times.rotate_right(1);
        self.times[0] = time;
        (self.sectors, self.total) = (0, 0);
        for time in self.times {
            if self.total < ENOUGH && time != 0 {
                self.total += time;
                self.sectors += 1;
            }
        }
    }
}

/// Follows the sensors' code. All times are in calls of [`Self::update`].
#[derive(Clone, Debug, Default)]
pub struct Halls {
    /// The first code was read.
    started: bool,
    /// Count at the lower edge of the sector; wraps.
    base: i32,
    sector: i32,
    /// Direction of the last edge, 1 or -1; 0 if it is not known.
    direction: i32,
    /// Time since the last edge.
    since: u32,
    /// Times in the last sectors.
    spent: Spent,
    score: u8,
    /// Readings since the last one in this sector or a neighbour, without codes that do not exist.
    apart: u8,
}

impl Halls {
    /// Creates the sensors of a motor at power-up.
    pub const fn new() -> Self {
        Self {
            started: false,
            base: 0,
            sector: 0,
            direction: 0,
            since: 0,
            spent: Spent::new(),
            score: 0,
            apart: 0,
        }
    }

    /// Takes the sensors' levels in the lowest three bits of `code`, once in each PWM period.
    /// Returns the rotor's count: [`COUNTS_PER_ELECTRICAL_TURN`] in each electrical turn, wrapping
    /// at 2^32. From the first code that exists on, it is absolute within an electrical turn.
    ///
    /// A code that does not exist leaves the count as it is.
    #[inline]
    pub fn update(&mut self, code: u32) -> u32 {
        self.since = self.since.saturating_add(1);
        let sector = i32::from(SECTORS[(code & 7) as usize]);
        if sector < 0 {
            self.add_wrong();
        } else {
            if !self.started {
                (self.started, self.sector, self.base) = (true, sector, sector * SECTOR);
            }
            // -2 to 3 sectors.
            let moved = (sector - self.sector + 8) % 6 - 2;
            match moved {
                0 => {
                    self.score = self.score.saturating_sub(1);
                    self.apart = 0;
                }
                1 | -1 => {
                    self.enter(sector, moved);
                    self.edge(moved);
                }
                _ => self.doubt(sector, moved),
            }
        }
        self.count() as u32
    }

    /// Takes the edge to a neighbouring sector.
    fn edge(&mut self, moved: i32) {
        if moved == self.direction && self.since <= LONGEST {
            self.spent.push(self.since);
        } else {
            self.spent = Spent::new();
        }
        (self.direction, self.since) = (moved, 0);
    }

    /// Takes the code of a sector that is no neighbour.
    fn doubt(&mut self, sector: i32, moved: i32) {
        self.add_wrong();
        self.apart += 1;
        if self.apart < STAYS {
            return;
        }
        self.enter(sector, moved);
        (self.spent, self.direction) = (Spent::new(), 0);
        if moved == OPPOSITE {
            self.score = u8::MAX;
        }
    }

    /// Enters a sector, by this many sectors from the one before.
    fn enter(&mut self, sector: i32, moved: i32) {
        self.sector = sector;
        self.base = self.base.wrapping_add(moved * SECTOR);
        self.apart = 0;
    }

    /// Counts a reading that no working sensors give. Sensors that are broken stay so for 55
    /// readings, more than a control period.
    fn add_wrong(&mut self) {
        self.score = match self.score.saturating_add(WRONG) {
            score @ ..BROKEN => score,
            BROKEN.. => u8::MAX,
        };
    }

    /// Returns the count of the newest reading.
    ///
    /// A rotor that has not left its sector after the mean time turns more slowly: its count
    /// returns to the middle.
    #[inline]
    pub fn count(&self) -> i32 {
        let middle = SECTOR as u32 / 2;
        // The edge was half a reading before it was seen, on average.
        let since = 2 * self.since.min(4 * LONGEST) + 1;
        let passed = (since * middle * self.spent.sectors).checked_div(self.spent.total);
        let end = SECTOR as u32 - 1;
        let within = match passed {
            Some(passed) if passed <= end => passed,
            Some(passed) => (end + middle).saturating_sub(passed / 2).max(middle),
            None => middle,
        } as i32;
        self.base.wrapping_add(if self.direction < 0 {
            SECTOR - 1 - within
        } else {
            within
        })
    }

    /// Returns whether a sensor or its line is broken: too many codes do not exist, or are no
    /// neighbours of the last one, or one has lost the position. Before the first code that exists,
    /// the count says nothing, so the sensors count as broken.
    pub fn are_broken(&self) -> bool {
        !self.started || self.score >= BROKEN
    }
}

/// Returns the code of working sensors at an electrical angle, of which each is displaced by an
/// angle. The sensor of bit 0 is on from 0 to 180 degrees.
#[cfg(feature = "lockstep")]
pub fn code(angle: Angle, displaced: [Angle; 3]) -> u32 {
    let (mut axis, mut code) = (Angle::ZERO, 0);
    for (bit, displaced) in displaced.into_iter().enumerate() {
        code |= u32::from((angle - axis - displaced).to_bits() >= 0) << bit;
        axis += Angle::from_degrees(120.0);
    }
    code
}

#[cfg(test)]
#[cfg(feature = "lockstep")]
mod tests {
    extern crate std;
    use super::*;
    use std::format;

    /// Code at a position in counts; count 0 is at 60 degrees.
    fn code_at(count: i32) -> u32 {
        let degrees = 60.0 + 360.0 * f64::from(count) / f64::from(COUNTS_PER_ELECTRICAL_TURN);
        code(
            Angle::from_degrees((degrees + 0.1) as f32),
            [Angle::ZERO; 3],
        )
    }

    #[test]
    fn the_count_is_absolute_within_an_electrical_turn_from_the_first_code_on() {
        for sector in 0..6 {
            let mut halls = Halls::new();
            let middle = sector * SECTOR + SECTOR / 2;
            assert_eq!(halls.update(code_at(middle)) as i32, middle);
            assert!(!halls.are_broken());
        }
    }

    #[test]
    fn sensors_without_a_code_that_exists_are_broken() {
        let mut halls = Halls::new();
        halls.update(7);
        assert!(halls.are_broken());
        halls.update(code_at(100));
        assert!(!halls.are_broken());
    }

    #[test]
    fn wrong_codes_of_any_length_never_count_as_an_electrical_turn_without_being_found() {
        for (sector, wrong, length) in
            (0..6).flat_map(|s| (0..8).flat_map(move |w| (1..=12).map(move |n| (s, w, n))))
        {
            let mut halls = Halls::new();
            let right = code_at(sector * SECTOR + SECTOR / 2);
            let start = halls.update(right) as i32;
            let readings = [wrong].repeat(length).into_iter().chain([right; 12]);
            let mut found = false;
            for code in readings {
                halls.update(code);
                found |= halls.are_broken();
            }
            let what = format!("{wrong} instead of {right} for {length} readings");
            // Behind an edge, the middle of a sector is one count off.
            let apart = halls.count() - start;
            assert!(found || apart.abs() <= 1, "{what}: {apart}");
            assert!(!found || length >= usize::from(STAYS), "{what}");
            // One period of control has 20 readings.
            assert!(!found || halls.are_broken(), "{what}");
        }
    }

    #[test]
    fn wrong_codes_between_the_right_ones_of_a_turning_rotor_change_no_position() {
        for (wrong, every) in (0..8).flat_map(|wrong| [7, 13, 50].map(|every| (wrong, every))) {
            let mut halls = Halls::new();
            halls.update(code_at(SECTOR / 2));
            for reading in 0..6_000 {
                let right = code_at(SECTOR / 2 + reading);
                halls.update(if reading % every == 3 { wrong } else { right });
            }
            for _ in 0..3 {
                halls.update(code_at(SECTOR / 2 + 6_000));
            }
            let apart = halls.count() - (SECTOR / 2 + 6_000);
            assert!(apart.abs() <= SECTOR, "{wrong} every {every}: {apart}");
        }
    }

    #[test]
    fn a_code_that_does_not_exist_changes_no_speed() {
        let [mut disturbed, mut sound] = [Halls::new(), Halls::new()];
        for reading in 0..4_000 {
            let code = code_at(reading);
            let expected = sound.update(code);
            // Within a sector, so that no edge is missed.
            let wrong = reading % 640 == 30;
            let count = disturbed.update(if wrong { 7 } else { code });
            assert_eq!(count, expected, "{reading}");
        }
    }

    #[test]
    fn at_constant_speed_the_count_is_right_in_both_directions_and_beyond_the_range_of_32_bits() {
        for direction in [1, -1] {
            // Sectors of 9.1, 37 and 1000 readings.
            for per_reading in [7.0, 1.73, 0.064] {
                let mut halls = Halls::new();
                halls.update(code_at(0));
                // Two sectors before the largest count, or behind the smallest.
                halls.base = if direction > 0 {
                    i32::MAX - 2 * SECTOR + 1
                } else {
                    i32::MIN + SECTOR
                };
                let start = halls.count();
                let mut position = 0.0_f64;
                let readings = (30.0 * f64::from(SECTOR) / per_reading) as u32;
                for reading in 0..readings {
                    position += per_reading * f64::from(direction);
                    let count = halls.update(code_at(position.floor() as i32)) as i32;
                    let apart = count.wrapping_sub(start) + SECTOR / 2;
                    let error = f64::from(apart) - position;
                    let settled = reading > readings / 4;
                    assert!(
                        !settled || error.abs() <= 1.5 * per_reading + 2.0,
                        "{error}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_rotor_that_stops_or_turns_round_counts_as_in_the_middle_of_its_sector() {
        let mut halls = Halls::new();
        for count in 0..10 * SECTOR {
            halls.update(code_at(count / 2));
        }
        let sector = (5 * SECTOR - 1) / SECTOR * SECTOR;
        for _ in 0..10 * SECTOR {
            halls.update(code_at(sector));
        }
        assert_eq!(halls.count(), sector + SECTOR / 2);
        let back = halls.update(code_at(sector - 1)) as i32;
        assert_eq!(back, sector - SECTOR / 2 - 1);
    }

    #[test]
    fn each_stuck_line_is_found_at_every_speed_and_disturbed_readings_are_not() {
        for (line, level) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
            for readings_per_count in [1, 3, 40] {
                let mut halls = Halls::new();
                let found = (0..2 * COUNTS_PER_ELECTRICAL_TURN).find(|count| {
                    for _ in 0..readings_per_count {
                        halls.update(code_at(*count) & !(1 << line) | level << line);
                    }
                    halls.are_broken()
                });
                assert!(found.is_some(), "{line} {level} {readings_per_count}");
            }
        }
        let mut halls = Halls::new();
        for reading in 0..100_000 {
            let wrong = if reading % 50 == 25 {
                1 << (reading / 50 % 3)
            } else {
                0
            };
            halls.update(code_at(reading / 100) ^ wrong);
            assert!(!halls.are_broken(), "{reading}");
        }
    }
}
