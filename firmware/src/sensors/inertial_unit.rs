//! Inertial unit LSM6DSV16X: accelerometer and gyroscope.

use super::bus::SensorBus;
use super::condition::Chip;
use super::device::{Device, TransferError, axes};
use super::newest::Newest;
use super::service::{self, Driver, Failure};
use core::f32::consts::PI;
use embassy_time::{Delay, Duration};
use embedded_hal_async::i2c::I2c;
use lsm6dsv16x_rs::asynchronous::prelude::{
    GyFullScale, GyMode, Odr, Reg, Reset, XlFullScale, XlMode, from_fs8_to_mg, from_fs1000_to_mdps,
};
use lsm6dsv16x_rs::asynchronous::{Error, I2CAddress, ID, Lsm6dsv16x};

/// Address of the inertial unit, which its pin SA0 selects.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Address {
    /// SA0 is low: address 0x6a.
    Low,
    /// SA0 is high: address 0x6b, as on ST's expansion board X-NUCLEO-IKS4A1.
    High,
}

/// Rates at which the chip measures, Hz, in its mode with accurate rates.
const RATES: [(u32, Odr); 10] = [
    (25, Odr::Ha02_25hz),
    (50, Odr::Ha02_50hz),
    (100, Odr::Ha02_100hz),
    (125, Odr::Ha01_125hz),
    (200, Odr::Ha02_200hz),
    (250, Odr::Ha01_250hz),
    (400, Odr::Ha02_400hz),
    (500, Odr::Ha01_500hz),
    (800, Odr::Ha02_800hz),
    (1_000, Odr::Ha01_1000hz),
];
/// Number of times that the end of the reset is looked for, a millisecond apart. It takes 30 us.
const RESET_LOOKS: u32 = 5;
/// Number of bytes from the status register to the end of the outputs, and the first output.
const BURST: usize = 16;
const OUTPUTS: usize = 4;
/// Bits of the status register: accelerometer or gyroscope have measured.
const READY: u8 = 3;
/// Units of the chip's library in ours: a thousandth of standard gravity, m/s^2, and a thousandth
/// of a degree per second, rad/s.
const MILLI_G: f32 = 9.806_65e-3;
const MILLI_DEGREE: f32 = PI / 180e3;

/// Driver of the inertial unit. Ranges: 8 g with 0.244 mg a digit, and 1000 degrees/s with 35
/// mdegree/s a digit. The chip's noise is larger than a digit, so its readings never repeat for
/// long.
pub(super) struct InertialUnit {
    address: Address,
    rate_hz: u32,
}

impl InertialUnit {
    pub fn new(address: Address, rate_hz: u32) -> Self {
        Self { address, rate_hz }
    }

    /// Lowest rate of the chip at which every call of `read` finds a new reading.
    fn odr(&self) -> Odr {
        RATES
            .iter()
            .find(|(rate, _)| *rate >= self.rate_hz)
            .map_or(Odr::Ha01_1000hz, |(_, odr)| *odr)
    }

    fn address(&self) -> I2CAddress {
        match self.address {
            Address::Low => I2CAddress::I2cAddL,
            Address::High => I2CAddress::I2cAddH,
        }
    }
}

impl From<Error<TransferError>> for Failure {
    fn from(error: Error<TransferError>) -> Self {
        match error {
            Error::Bus(error) => Self::Transfer(error),
            Error::UnexpectedValue | Error::FailedToReadMemBank | Error::FailedToSetMemBank(_) => {
                Self::NoReadings
            }
        }
    }
}

impl Driver for InertialUnit {
    const CHIP: Chip = Chip::InertialUnit;
    const AFTER_TICK: Duration = service::AFTER_TICK;

    fn rate_hz(&self) -> u32 {
        self.rate_hz
    }

    async fn start<B: SensorBus>(&self, device: Device<'_, B>) -> Result<(), Failure> {
        let mut chip = Lsm6dsv16x::new_i2c(device, self.address(), Delay);
        let identity = chip.device_id_get().await?;
        if identity != ID {
            return Err(Failure::WrongIdentity(identity));
        }
        chip.reset_set(Reset::RestoreCtrlRegs).await?;
        let mut looks = 0;
        while chip.reset_get().await? != Reset::Ready {
            looks += 1;
            if looks > RESET_LOOKS {
                return Err(Failure::NoReadings);
            }
            embassy_time::Timer::after_millis(1).await;
        }
        chip.block_data_update_set(1).await?;
        chip.xl_full_scale_set(XlFullScale::_8g).await?;
        chip.gy_full_scale_set(GyFullScale::_1000dps).await?;
        // The chip takes mode and table of rates over only while both sensors are off. The library
        // writes the table after it has switched a sensor on.
        chip.xl_mode_set(XlMode::HighAccuracyOdrMd).await?;
        chip.gy_mode_set(GyMode::HighAccuracyOdrMd).await?;
        let odr = self.odr();
        let mut device = device;
        let table = [Reg::HaodrCfg as u8, odr as u8 >> 4];
        let written = device.write(self.address() as u8, &table).await;
        written.map_err(Failure::Transfer)?;
        chip.xl_data_rate_set(odr).await?;
        chip.gy_data_rate_set(odr).await?;
        Ok(())
    }

    async fn read<B: SensorBus>(
        &self,
        device: Device<'_, B>,
        newest: &Newest,
    ) -> Result<bool, Failure> {
        let mut device = device;
        let mut bytes = [0; BURST];
        // The library reads status and outputs in three transfers. Beside the inclinometer's, they
        // take nearly a millisecond, and readings at 1000 Hz are lost.
        let read = device.write_read(self.address() as u8, &[Reg::StatusReg as u8], &mut bytes);
        read.await.map_err(Failure::Transfer)?;
        // Both sensors measure at the same time. If they do so during the transfer, one flag may be
        // that of the reading before.
        if bytes[0] & READY == 0 {
            return Ok(false);
        }
        let [rate, force] = [OUTPUTS, OUTPUTS + 6].map(|first| axes(&bytes[first..]));
        // Outside of `put`, which masks interrupts.
        let rate = rate.map(|raw| from_fs1000_to_mdps(raw) * MILLI_DEGREE);
        let force = force.map(|raw| from_fs8_to_mg(raw) * MILLI_G);
        newest.put(|readings| {
            readings.angular_rate = rate;
            readings.specific_force = force;
            readings.fresh.gyroscope = true;
            readings.fresh.accelerometer = true;
        });
        Ok(true)
    }
}
