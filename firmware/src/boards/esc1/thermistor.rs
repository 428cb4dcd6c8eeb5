//! Temperature of the thermistor between the transistors.
//!
//! The thermistor (10 kiloohm at 25 degrees Celsius, beta 3425 K) is connected to the converter's
//! reference, and 4.7 kiloohm to ground.

/// Code of a converter with 12 bits, and temperature in degrees Celsius.
const TABLE: [(u16, f32); 13] = [
    (77, -40.0),
    (138, -30.0),
    (235, -20.0),
    (379, -10.0),
    (578, 0.0),
    (1309, 25.0),
    (2184, 50.0),
    (2783, 70.0),
    (3125, 85.0),
    (3380, 100.0),
    (3566, 115.0),
    (3700, 130.0),
    (3822, 150.0),
];

/// Converts a code of 12 bits to degrees Celsius. Worst error from -30 to 140 degrees: 1.3 degrees.
/// NaN for codes outside the table, which mean a broken or shorted thermistor.
pub fn celsius(code: u16) -> f32 {
    TABLE
        .windows(2)
        .find_map(|ends| {
            let [(low_code, low), (high_code, high)] = [ends.first()?, ends.last()?];
            (*low_code..=*high_code).contains(&code).then(|| {
                let part = f32::from(code - low_code) / f32::from(high_code - low_code);
                low + part * (high - low)
            })
        })
        .unwrap_or(f32::NAN)
}
