//! Access of one chip to the shared bus. Every transfer ends in time.

use super::bus::SensorBus;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::{Duration, with_timeout};
use embedded_hal_async::i2c::{Error, ErrorKind, ErrorType, I2c, Operation};

/// Maximum duration of a transfer, and of freeing the bus. The longest transfer has 19 bytes and
/// takes 1.8 ms at 100 kbit/s.
const TIMEOUT: Duration = Duration::from_millis(3);

/// Bus that the chips of a board share.
pub(super) type Shared<B> = Mutex<NoopRawMutex, B>;

/// Access of one chip to the bus.
pub(super) struct Device<'a, B>(pub &'a Shared<B>);

// A derived `Clone` asks for a bus that can be cloned.
impl<B> Clone for Device<'_, B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<B> Copy for Device<'_, B> {}

/// Error of a transfer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum TransferError {
    /// No chip acknowledged its address or a byte.
    NoAcknowledge,
    /// The transfer did not end in time.
    Timeout,
    /// The bus had another error, for instance a misplaced start or stop condition.
    Bus,
}

impl Error for TransferError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NoAcknowledge => {
                ErrorKind::NoAcknowledge(embedded_hal_async::i2c::NoAcknowledgeSource::Unknown)
            }
            Self::Timeout => ErrorKind::Other,
            Self::Bus => ErrorKind::Bus,
        }
    }
}

impl<B> ErrorType for Device<'_, B> {
    type Error = TransferError;
}

impl<B: SensorBus> I2c for Device<'_, B> {
    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), TransferError> {
        let mut bus = self.0.lock().await;
        let error = match with_timeout(TIMEOUT, bus.transaction(address, operations)).await {
            Ok(Ok(())) => return Ok(()),
            Ok(Err(error)) if matches!(error.kind(), ErrorKind::NoAcknowledge(_)) => {
                // The controller ends such a transfer with a stop condition: the bus is free.
                return Err(TransferError::NoAcknowledge);
            }
            Ok(Err(_)) => TransferError::Bus,
            Err(_) => TransferError::Timeout,
        };
        // A bus that cannot be freed shows itself in the next transfer.
        let _ = with_timeout(TIMEOUT, bus.recover()).await;
        Err(error)
    }
}

/// Returns the outputs of three axes in the first six of `bytes`, low bytes first.
pub(super) fn axes(bytes: &[u8]) -> [i16; 3] {
    let mut outputs = bytes.as_chunks::<2>().0.iter();
    core::array::from_fn(|_| outputs.next().map_or(0, |bytes| i16::from_le_bytes(*bytes)))
}
