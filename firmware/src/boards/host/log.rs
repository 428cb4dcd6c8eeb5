//! Writes log records as lines of text into the buffer of the node that runs.

use crate::boards::lockstep::LogBuffer;
use std::boxed::Box;
use std::cell::RefCell;
use std::{format, mem, thread_local};

thread_local! {
    static RUNNING: RefCell<Box<LogBuffer>> = RefCell::new(Box::new(LogBuffer::new()));
}

/// Exchanges the buffer of the node that runs in this thread for `buffer`.
pub(super) fn exchange(buffer: &mut Box<LogBuffer>) {
    RUNNING.with_borrow_mut(|running| mem::swap(running, buffer));
}

/// Writes how many records did not fit.
pub(super) fn warn_of_lost(buffer: &mut LogBuffer, lost: u32) {
    write(buffer, &format!("WARN: {lost} log records were lost\n"));
}

/// Sends the records of the logging macros to the buffer from now on.
pub(super) fn install() {
    // Fails only if a logger is set already.
    let _ = log::set_logger(&NodeLogger);
    log::set_max_level(log::LevelFilter::Info);
}

struct NodeLogger;

impl log::Log for NodeLogger {
    fn enabled(&self, record: &log::Metadata) -> bool {
        record.target().starts_with("tautrack")
    }

    fn log(&self, record: &log::Record) {
        if self.enabled(record.metadata()) {
            let line = format!("{}: {}\n", record.level(), record.args());
            RUNNING.with_borrow_mut(|buffer| write(buffer, &line));
        }
    }

    fn flush(&self) {}
}

fn write(buffer: &mut LogBuffer, line: &str) {
    buffer.begin();
    buffer.write(line.as_bytes());
    buffer.end();
}
