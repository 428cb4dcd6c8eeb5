//! Magnetometer LIS2MDL.

use super::bus::SensorBus;
use super::condition::Chip;
use super::device::{Device, TransferError};
use super::newest::Newest;
use super::service::{self, Driver, Failure};
use embassy_time::{Delay, Duration};
use lis2mdl_rs::asynchronous::prelude::{Md, Odr, SetRst};
use lis2mdl_rs::asynchronous::{Error, I2CAddress, ID, Lis2mdl, from_lsb_to_mgauss};

/// Rates at which the chip measures, Hz.
const RATES: [(u32, Odr); 4] = [
    (10, Odr::_10hz),
    (20, Odr::_20hz),
    (50, Odr::_50hz),
    (100, Odr::_100hz),
];
/// Microtesla in the unit of the chip's library, a thousandth of a gauss.
const MILLI_GAUSS: f32 = 0.1;

/// Driver of the magnetometer. Range: 4915 uT with 0.15 uT a digit.
pub(super) struct Magnetometer {
    rate_hz: u32,
}

impl Magnetometer {
    pub fn new(rate_hz: u32) -> Self {
        Self { rate_hz }
    }

    /// Lowest rate of the chip at which every call of `read` finds a new reading, if it has one.
    fn odr(&self) -> Odr {
        RATES
            .iter()
            .find(|(rate, _)| *rate >= self.rate_hz)
            .map_or(Odr::_100hz, |(_, odr)| *odr)
    }
}

impl From<Error<TransferError>> for Failure {
    fn from(error: Error<TransferError>) -> Self {
        match error {
            Error::Bus(error) => Self::Transfer(error),
            Error::UnexpectedValue | Error::InvalidConfiguration | Error::HwNoResponse => {
                Self::NoReadings
            }
        }
    }
}

impl Driver for Magnetometer {
    const CHIP: Chip = Chip::Magnetometer;
    const AFTER_TICK: Duration = service::LATER;

    fn rate_hz(&self) -> u32 {
        self.rate_hz
    }

    async fn start<B: SensorBus>(&self, device: Device<'_, B>) -> Result<(), Failure> {
        let mut chip = Lis2mdl::new_i2c(device, I2CAddress::I2cAdd, Delay);
        let identity = chip.device_id_get().await?;
        if identity != ID {
            return Err(Failure::WrongIdentity(identity));
        }
        chip.sw_reset().await?;
        chip.block_data_update_set(1).await?;
        chip.offset_temp_comp_set(1).await?;
        // Removes the chip's own offset, which changes after a strong field.
        chip.set_rst_mode_set(SetRst::SensOffCancEveryOdr).await?;
        chip.data_rate_set(self.odr()).await?;
        chip.operating_mode_set(Md::ContinuousMode).await?;
        Ok(())
    }

    async fn read<B: SensorBus>(
        &self,
        device: Device<'_, B>,
        newest: &Newest,
    ) -> Result<bool, Failure> {
        let mut chip = Lis2mdl::new_i2c(device, I2CAddress::I2cAdd, Delay);
        if chip.mag_data_ready_get().await? == 0 {
            return Ok(false);
        }
        let field = chip.magnetic_raw_get().await?;
        // Outside of `put`, which masks interrupts.
        let field = field.map(|raw| from_lsb_to_mgauss(raw) * MILLI_GAUSS);
        newest.put(|readings| {
            readings.magnetic_field = field;
            readings.fresh.magnetometer = true;
        });
        Ok(true)
    }
}
