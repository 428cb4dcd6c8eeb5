//! Keys and numbers of the table of settings, packed for flash. Most numbers stand in several rows,
//! so each stands once in a list, and a row has their indices there.

use super::{Description, TABLE, units};

/// Numbers of a row of [`TABLE`].
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

/// Returns the numbers of the row of [`TABLE`] with this index.
pub(super) fn bounds(row: usize) -> Bounds {
    let Row { key, numbers, .. } = ROWS[row];
    let [minimum, maximum, default] = numbers.map(|index| NUMBERS[usize::from(index)]);
    Bounds {
        key: key.into(),
        minimum,
        maximum,
        default,
    }
}

/// Returns the index of the scale of a row's unit ([`super::Settings::si`]).
pub(super) fn scale(row: usize) -> usize {
    ROWS[row].scale.into()
}

#[derive(Clone, Copy)]
struct Row {
    key: u8,
    scale: u8,
    /// Indices in [`NUMBERS`] of minimum, maximum and default.
    numbers: [u8; 3],
}

static ROWS: [Row; TABLE.len()] = {
    let row = Row {
        key: 0,
        scale: 0,
        numbers: [0; 3],
    };
    let (mut rows, mut index) = ([row; TABLE.len()], 0);
    while index < TABLE.len() {
        let description = &TABLE[index];
        let [a, b, c] = numbers_of(description);
        rows[index] = Row {
            key: description.key as u8,
            scale: units::scale_index(description.unit),
            numbers: [find(a) as u8, find(b) as u8, find(c) as u8],
        };
        index += 1;
    }
    rows
};

/// The numbers of all rows. More than 256 do not compile.
static NUMBERS: [i32; DIFFERENT.1] = {
    let (mut numbers, mut index) = ([0; DIFFERENT.1], 0);
    while index < DIFFERENT.1 {
        numbers[index] = DIFFERENT.0[index];
        index += 1;
    }
    numbers
};

/// The numbers of all rows, and how many there are.
const DIFFERENT: ([i32; 257], usize) = {
    let (mut numbers, mut count, mut index) = ([0; 257], 0, 0);
    while index < 3 * TABLE.len() {
        numbers[count] = numbers_of(&TABLE[index / 3])[index % 3];
        if position(&numbers, numbers[count]) == count {
            count += 1;
        }
        index += 1;
    }
    (numbers, count)
};

const fn numbers_of(row: &Description) -> [i32; 3] {
    [row.minimum, row.maximum, row.default]
}

const fn find(number: i32) -> usize {
    position(&DIFFERENT.0, number)
}

/// Returns the first place of `number`, which must be there.
const fn position(numbers: &[i32], number: i32) -> usize {
    let mut index = 0;
    while numbers[index] != number {
        index += 1;
    }
    index
}
