//! The units of the settings, with what one of each is in the unit in which the nodes compute. That
//! is the SI unit; but angles in degrees stay in degrees, and magnetic fields are in uT.

/// Name and scale of each unit.
const UNITS: &[(&str, f64)] = &[
    ("1", 1.0),
    ("1e-3", 1e-3),
    ("1e-4", 1e-4),
    ("2^-16", 1.0 / 65_536.0),
    ("0.1 K", 0.1),
    ("0.1 degree C", 0.1),
    ("1e-3 degree", 1e-3),
    ("1e-3 degree/s", 1e-3),
    ("1e-3/m", 1e-3),
    ("1e-3/s", 1e-3),
    ("A/s", 1.0),
    ("Hz", 1.0),
    ("Pa", 1.0),
    ("W", 1.0),
    ("g", 1e-3),
    ("N", 1.0),
    ("mA", 1e-3),
    ("mA s/rad", 1e-3),
    ("mOhm", 1e-3),
    ("mV", 1e-3),
    ("mg", 1e-6),
    ("mrad", 1e-3),
    ("mrad/s", 1e-3),
    ("mrad/s^2", 1e-3),
    ("ms", 1e-3),
    ("nT", 1e-3),
    ("ns", 1e-9),
    ("rad/s", 1.0),
    ("uA s^2/rad", 1e-6),
    ("uH", 1e-6),
    ("uN m/A", 1e-6),
    ("ug m^2", 1e-9),
    ("um", 1e-6),
    ("um/s", 1e-6),
    ("um/s^2", 1e-6),
    ("urad", 1e-6),
    ("us", 1e-6),
];

/// Every scale of [`UNITS`], once.
pub(super) const SCALES: [f64; 7] = [1.0, 0.1, 1e-3, 1e-4, 1e-6, 1e-9, 1.0 / 65_536.0];

/// [`SCALES`] in single precision, with zeros behind them up to a power of two.
const SINGLE: [f32; 8] = {
    let mut single = [0.0; 8];
    let mut index = 0;
    while index < SCALES.len() {
        single[index] = SCALES[index] as f32;
        index += 1;
    }
    single
};

/// Returns the scale with this index in single precision. It cannot panic, because ticks use it.
pub(super) fn single(index: usize) -> f32 {
    SINGLE[index % SINGLE.len()]
}

/// Returns the index in [`SCALES`] of the unit with this name. If there is none, the table of
/// settings does not compile.
pub(super) const fn scale_index(name: &str) -> u8 {
    let mut row = 0;
    while !equal(UNITS[row].0.as_bytes(), name.as_bytes()) {
        row += 1;
    }
    let mut index = 0;
    while SCALES[index] != UNITS[row].1 {
        index += 1;
    }
    index as u8
}

const fn equal(a: &[u8], b: &[u8]) -> bool {
    let mut index = 0;
    while index < a.len() && index < b.len() && a[index] == b[index] {
        index += 1;
    }
    index == a.len() && index == b.len()
}
