//! Inclinometer LIS2DUXS12: an accelerometer that measures the direction of gravity.

use super::bus::SensorBus;
use super::condition::Chip;
use super::device::{Device, TransferError, axes};
use super::newest::Newest;
use super::service::{self, Driver, Failure};
use embassy_time::{Delay, Duration};
use embedded_hal_async::i2c::I2c;
use lis2duxs12_rs::asynchronous::prelude::{Bw, Fs, Md, Odr, Reg};
use lis2duxs12_rs::asynchronous::{Error, I2CAddress, ID, Lis2duxs12, from_fs8g_to_mg};
use tautrack::estimate::attitude::pitch_and_roll;

/// Address of the chip, whose pin SA0 is high, as on ST's expansion board X-NUCLEO-IKS4A1.
const ADDRESS: I2CAddress = I2CAddress::I2cAddH;
/// Rates at which the chip measures in its mode of high performance, Hz.
const RATES: [(u32, Odr); 7] = [
    (12, Odr::_12_5hzHp),
    (25, Odr::_25hzHp),
    (50, Odr::_50hzHp),
    (100, Odr::_100hzHp),
    (200, Odr::_200hzHp),
    (400, Odr::_400hzHp),
    (800, Odr::_800hzHp),
];
/// Number of bytes from the status register to the end of the outputs, and the first output.
const BURST: usize = 9;
const OUTPUTS: usize = 3;
/// Bit of the status register: the chip has measured.
const READY: u8 = 1;

/// Driver of the inclinometer. Range: 8 g with 0.244 mg a digit, so that impacts do not saturate
/// it. A digit is 0.014 degree.
pub(super) struct Inclinometer {
    rate_hz: u32,
}

impl Inclinometer {
    pub fn new(rate_hz: u32) -> Self {
        Self { rate_hz }
    }

    /// Lowest rate of the chip at which every call of `read` finds a new reading, if it has one.
    fn odr(&self) -> Odr {
        RATES
            .iter()
            .find(|(rate, _)| *rate >= self.rate_hz)
            .map_or(Odr::_800hzHp, |(_, odr)| *odr)
    }
}

impl From<Error<TransferError>> for Failure {
    fn from(error: Error<TransferError>) -> Self {
        match error {
            Error::Bus(error) => Self::Transfer(error),
            Error::FailedToBoot
            | Error::FailedToSwReset
            | Error::InvalidBwForODR
            | Error::InvalidValue
            | Error::BufferTooSmall
            | Error::FailedToReadMemBank
            | Error::FailedToSetMembank(_) => Self::NoReadings,
        }
    }
}

impl Driver for Inclinometer {
    const CHIP: Chip = Chip::Inclinometer;
    const AFTER_TICK: Duration = service::LATER;

    fn rate_hz(&self) -> u32 {
        self.rate_hz
    }

    async fn start<B: SensorBus>(&self, device: Device<'_, B>) -> Result<(), Failure> {
        let mut chip = Lis2duxs12::new_i2c(device, ADDRESS, Delay);
        // The chip sleeps when its supply is switched on.
        chip.exit_deep_power_down().await?;
        let identity = chip.device_id_get().await?;
        if identity != ID {
            return Err(Failure::WrongIdentity(identity));
        }
        chip.sw_reset().await?;
        chip.init_set().await?;
        let mode = Md {
            odr: self.odr(),
            fs: Fs::_8g,
            bw: Bw::OdrDiv2,
        };
        chip.mode_set(&mode).await?;
        Ok(())
    }

    async fn read<B: SensorBus>(
        &self,
        device: Device<'_, B>,
        newest: &Newest,
    ) -> Result<bool, Failure> {
        let mut device = device;
        let mut bytes = [0; BURST];
        // The library reads status and axes in six transfers.
        let read = device.write_read(ADDRESS as u8, &[Reg::Status as u8], &mut bytes);
        read.await.map_err(Failure::Transfer)?;
        if bytes[0] & READY == 0 {
            return Ok(false);
        }
        let force = axes(&bytes[OUTPUTS..]).map(from_fs8g_to_mg);
        if force == [0.0; 3] {
            // No robot is weightless, and zeros would look level.
            return Ok(false);
        }
        // Outside of `put`, which masks interrupts.
        let inclination = pitch_and_roll(force);
        newest.put(|readings| {
            readings.inclination = inclination;
            readings.fresh.inclinometer = true;
        });
        Ok(true)
    }
}
