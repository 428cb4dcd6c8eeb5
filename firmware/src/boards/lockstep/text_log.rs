//! Writes log records as lines of text into the buffer of log bytes that the answers carry.

use super::log_buffer;
use std::format;

/// Sends the records of the logging macros to the buffer from now on.
pub fn install() {
    // Fails only if a logger is set already, and nothing else sets one.
    let _ = log::set_logger(&BufferedLogger);
    log::set_max_level(log::LevelFilter::Info);
}

struct BufferedLogger;

impl log::Log for BufferedLogger {
    fn enabled(&self, _: &log::Metadata) -> bool {
        true
    }

    fn log(&self, record: &log::Record) {
        let line = format!("{}: {}\n", record.level(), record.args());
        log_buffer::with(|buffer| {
            buffer.begin();
            buffer.write(line.as_bytes());
            buffer.end();
        });
    }

    fn flush(&self) {}
}
