//! Writes defmt records into the buffer of log bytes that the answers carry.

use crate::boards::lockstep::LogBuffer;
use core::cell::RefCell;
use critical_section::Mutex;
use defmt::Encoder;

static ENCODER: Mutex<RefCell<Encoder>> = Mutex::new(RefCell::new(Encoder::new()));

#[defmt::global_logger]
struct Logger;

/// Log records that wait for the next answer.
static LOG: Mutex<RefCell<LogBuffer>> = Mutex::new(RefCell::new(LogBuffer::new()));

/// Calls `use_it` with the log records that wait for the next answer.
pub(super) fn with<R>(use_it: impl FnOnce(&mut LogBuffer) -> R) -> R {
    critical_section::with(|cs| use_it(&mut LOG.borrow(cs).borrow_mut()))
}

/// Runs `body` with the encoder and the buffer.
fn encode(body: impl FnOnce(&mut Encoder, &mut LogBuffer)) {
    critical_section::with(|cs| {
        with(|buffer| body(&mut ENCODER.borrow(cs).borrow_mut(), buffer));
    });
}

// SAFETY: the board has no interrupts and one thread, and nothing logs between `acquire` and
// `release` of a record, so records cannot interleave; each call borrows the state only for its own
// duration.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        encode(|encoder, buffer| {
            buffer.begin();
            encoder.start_frame(|bytes| buffer.write(bytes));
        });
    }

    unsafe fn flush() {}

    unsafe fn release() {
        encode(|encoder, buffer| {
            encoder.end_frame(|bytes| buffer.write(bytes));
            buffer.end();
        });
    }

    unsafe fn write(bytes: &[u8]) {
        encode(|encoder, buffer| encoder.write(bytes, |bytes| buffer.write(bytes)));
    }
}

defmt::timestamp!("{=u64:us}", embassy_time::Instant::now().as_micros());
