//! Keys and numbers of a table of settings, packed for flash. Most numbers stand in several rows,
//! so each stands once in a list, and a row has their indices there.

use super::units;

/// One row of the table.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Description {
    /// Key on the link and in flash.
    pub key: u16,
    /// Name in files and errors.
    pub name: &'static str,
    /// Unit of the integer.
    pub unit: &'static str,
    /// Smallest value.
    pub minimum: i32,
    /// Largest value.
    pub maximum: i32,
    /// Value that a node uses if the setting was never set.
    pub default: i32,
    /// When a written value takes effect in a drive.
    pub effect: Effect,
}

/// When a value that a client writes takes effect in a drive.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Effect {
    /// After a save and a restart.
    Restart,
    /// At once. The output of the loops does not jump.
    Gain,
    /// At once. While the drive is armed, only a lower value is accepted.
    Limit,
    /// At once, but only while the drive is disarmed: a lower value would keep a drive that moves
    /// from stopping, or would drop its load.
    Disarmed,
}

/// Key and numbers of a row.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Bounds {
    /// Key on the link and in flash.
    pub key: u16,
    /// Smallest value.
    pub minimum: i32,
    /// Largest value.
    pub maximum: i32,
    /// Value that a node uses if the setting was never set.
    pub default: i32,
}

/// The table of so many rows, which has so many different numbers.
pub(super) struct Packed<const ROWS: usize, const NUMBERS: usize> {
    rows: [Row; ROWS],
    numbers: [i32; NUMBERS],
}

#[derive(Clone, Copy)]
struct Row {
    key: u8,
    /// Index of the scale of its unit, and its [`Effect`] from the bit [`EFFECT`] on.
    scale_and_effect: u8,
    /// Indices of minimum, maximum and default.
    numbers: [u8; 3],
}

/// Lowest bit of the effect.
const EFFECT: u32 = 4;

impl<const ROWS: usize, const NUMBERS: usize> Packed<ROWS, NUMBERS> {
    /// Packs the table. `NUMBERS` is [`different_numbers`] of it.
    pub const fn new(table: &[Description]) -> Self {
        let (all, _) = collect(table);
        let row = Row {
            key: 0,
            scale_and_effect: 0,
            numbers: [0; 3],
        };
        let (mut rows, mut numbers) = ([row; ROWS], [0; NUMBERS]);
        let mut index = 0;
        while index < NUMBERS {
            numbers[index] = all[index];
            index += 1;
        }
        let mut index = 0;
        while index < ROWS {
            let [minimum, maximum, default] = numbers_of(&table[index]);
            rows[index] = Row {
                key: table[index].key as u8,
                scale_and_effect: units::scale_index(table[index].unit)
                    | (table[index].effect as u8) << EFFECT,
                numbers: [
                    position(&all, minimum) as u8,
                    position(&all, maximum) as u8,
                    position(&all, default) as u8,
                ],
            };
            index += 1;
        }
        Self { rows, numbers }
    }

    /// Returns the numbers of the row with this index.
    pub fn bounds(&self, row: usize) -> Bounds {
        let Row { key, numbers, .. } = self.rows[row];
        // Each index is that of a number. The compiler does not know it, and no tick may panic.
        let number = |index: u8| self.numbers.get(usize::from(index)).copied();
        let [minimum, maximum, default] = numbers.map(|index| number(index).unwrap_or_default());
        Bounds {
            key: key.into(),
            minimum,
            maximum,
            default,
        }
    }

    /// Returns the row with this key.
    pub fn row_of(&self, key: u16) -> Option<usize> {
        self.rows.iter().position(|row| u16::from(row.key) == key)
    }

    /// Returns the index of the scale of a row's unit.
    pub fn scale(&self, row: usize) -> usize {
        (self.rows[row].scale_and_effect & ((1 << EFFECT) - 1)).into()
    }

    /// Returns the effect of a row.
    pub fn effect(&self, row: usize) -> Effect {
        match self.rows[row].scale_and_effect >> EFFECT {
            0 => Effect::Restart,
            1 => Effect::Gain,
            2 => Effect::Limit,
            _ => Effect::Disarmed,
        }
    }
}

/// Returns how many different numbers the table has. More than 256 do not compile.
pub(super) const fn different_numbers(table: &[Description]) -> usize {
    collect(table).1
}

/// The different numbers of the table, and how many there are.
const fn collect(table: &[Description]) -> ([i32; 257], usize) {
    let (mut numbers, mut count, mut index) = ([0; 257], 0, 0);
    while index < 3 * table.len() {
        numbers[count] = numbers_of(&table[index / 3])[index % 3];
        if position(&numbers, numbers[count]) == count {
            count += 1;
        }
        index += 1;
    }
    (numbers, count)
}

const fn numbers_of(row: &Description) -> [i32; 3] {
    [row.minimum, row.maximum, row.default]
}

/// Returns the first place of `number`, which must be there.
const fn position(numbers: &[i32], number: i32) -> usize {
    let mut index = 0;
    while numbers[index] != number {
        index += 1;
    }
    index
}
