//! Writes messages as JSON text with rounded numbers.

use serde::Serialize;
use serde_json::Serializer;
use serde_json::ser::{CompactFormatter, Formatter};
use std::io::{self, Write};

/// Writes numbers with nine significant digits: the relative error is at most 5e-9. The further
/// digits of a double would make the file half as large again.
struct NineDigits;

impl Formatter for NineDigits {
    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        let rounded = format!("{value:.8e}").parse().unwrap_or(value);
        CompactFormatter.write_f64(writer, rounded)
    }
}

/// The JSON text of a message.
///
/// # Errors
/// When the message has no JSON form.
pub(super) fn text(message: &impl Serialize) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    message.serialize(&mut Serializer::with_formatter(&mut text, NineDigits))?;
    Ok(text)
}
