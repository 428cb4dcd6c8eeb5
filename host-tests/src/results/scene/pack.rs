//! Packs the data of a page: compressed, as text, and unpacked by the browser.

use miniz_oxide::deflate::compress_to_vec_zlib;
use serde_json::Value;

/// Level of the compression, 0 to 10.
const LEVEL: u8 = 9;

/// Compresses bytes (RFC 1950) into text.
pub fn packed(bytes: &[u8]) -> String {
    base64(&compress_to_vec_zlib(bytes, LEVEL))
}

/// Rounds all numbers to 0.1 mm or 0.1 mrad, which is enough for a picture.
pub fn round(value: &mut Value) {
    match value {
        Value::Number(number) if number.is_f64() => {
            let rounded = number.as_f64().map(|value| (value * 1e4).round() * 1e-4);
            *value = rounded.map_or(Value::Null, |value| {
                // The shortest decimals of the product.
                format!("{value:.4}")
                    .parse::<f64>()
                    .map_or(Value::Null, Value::from)
            });
        }
        Value::Array(values) => values.iter_mut().for_each(round),
        Value::Object(values) => values.values_mut().for_each(round),
        _ => {}
    }
}

/// Encodes bytes in base 64 (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |group: &[u8]| {
        let bits = (0..3).fold(0, |bits, index| {
            bits << 8 | u32::from(*group.get(index).unwrap_or(&0))
        });
        [18, 12, 6, 0].map(move |shift| LETTERS[(bits >> shift & 63) as usize] as char)
    };
    let mut text: String = bytes.chunks(3).flat_map(group).collect();
    let padding = (3 - bytes.len() % 3) % 3;
    text.truncate(text.len() - padding);
    text.extend(std::iter::repeat_n('=', padding));
    text
}

#[cfg(test)]
mod tests {
    use super::base64;

    #[test]
    fn base_64_has_the_values_of_its_standard() {
        let table = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foobar", "Zm9vYmFy"),
        ];
        for (text, expected) in table {
            assert_eq!(base64(text.as_bytes()), expected);
        }
    }
}
