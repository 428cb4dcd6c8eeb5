//! Task that starts the chips, reads them at their rates, and starts them again after a failure.

use super::Published;
use super::bus::SensorBus;
use super::condition::{Chip, Condition};
use super::device::{Device, Shared, TransferError};
use super::inclinometer::Inclinometer;
use super::inertial_unit::{Address, InertialUnit};
use super::magnetometer::Magnetometer;
use super::newest::Newest;
use embassy_futures::join::join3;
use embassy_time::{Duration, Instant, Ticker, Timer};
use tautrack::settings::{Setting, Settings};

/// Time from power-up to the first transfer. The magnetometer takes 20 ms to boot, the inertial
/// unit 10 ms.
const BOOT: Duration = Duration::from_millis(25);
/// Time from a failure to the next start of a chip.
const RETRY: Duration = Duration::from_millis(50);
/// Minimum time without a reading after which a chip is started again, and the same in periods of
/// the chip. The longer time counts.
const SILENCE: Duration = Duration::from_millis(20);
const SILENT_PERIODS: u32 = 4;

/// Time from a control tick to the reading of the inertial unit. A control tick takes less, and a
/// transfer of 0.45 ms ends before the next tick.
pub(super) const AFTER_TICK: Duration = Duration::from_micros(400);
/// The same for the other chips. Their transfers wait for that of the inertial unit, and end before
/// its next one.
pub(super) const LATER: Duration = Duration::from_micros(500);

/// Rates at which the chips are read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Rates {
    /// Rate of accelerometer and gyroscope, Hz, from 20 to 1000.
    pub inertial_hz: u32,
    /// Rate of the magnetometer, Hz, from 5 to 1000; the chip measures 100 times a second at most.
    pub magnetometer_hz: u32,
    /// Rate of the inclinometer, Hz, from 10 to 1000; the chip measures 800 times a second at most.
    pub inclinometer_hz: u32,
}

impl Rates {
    /// Reads the settings.
    pub fn new(settings: &Settings) -> Self {
        let rate = |setting| settings.get(setting).unsigned_abs();
        Self {
            inertial_hz: rate(Setting::InertialRate),
            magnetometer_hz: rate(Setting::CompassRate),
            inclinometer_hz: rate(Setting::InclinometerRate),
        }
    }
}

/// Why a chip cannot be started or read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Failure {
    /// A transfer failed.
    Transfer(TransferError),
    /// The chip has this identity instead of the expected one.
    WrongIdentity(u8),
    /// The chip does not end its reset, or does not measure.
    NoReadings,
}

impl Failure {
    fn condition(self) -> Condition {
        match self {
            Self::Transfer(TransferError::NoAcknowledge) => Condition::NoAcknowledge,
            Self::Transfer(TransferError::Timeout) => Condition::BusStuck,
            Self::Transfer(TransferError::Bus) => Condition::BusError,
            Self::WrongIdentity(_) => Condition::WrongIdentity,
            Self::NoReadings => Condition::NoReadings,
        }
    }
}

/// Driver of one kind of chip.
pub(super) trait Driver {
    /// The chip.
    const CHIP: Chip;
    /// Time from a control tick to a reading.
    const AFTER_TICK: Duration;

    /// Rate at which the chip is read, Hz.
    fn rate_hz(&self) -> u32;
    /// Checks the identity of the chip, resets it and configures it.
    async fn start<B: SensorBus>(&self, device: Device<'_, B>) -> Result<(), Failure>;
    /// Puts the chip's readings into `newest` if it has measured since the previous call. Returns
    /// whether it has.
    async fn read<B: SensorBus>(
        &self,
        device: Device<'_, B>,
        newest: &Newest,
    ) -> Result<bool, Failure>;
}

/// Reads the sensor chips on `bus` for ever. `address` is the one of the inertial unit.
///
/// A board spawns a task with this future on the executor below its control task. The chips do not
/// wait for each other, except for a transfer.
pub async fn run<B: SensorBus>(bus: B, address: Address, rates: Rates, published: &Published) -> ! {
    let bus = Shared::new(bus);
    let device = Device(&bus);
    Timer::after(BOOT).await;
    join3(
        serve(
            InertialUnit::new(address, rates.inertial_hz),
            device,
            published,
        ),
        serve(Magnetometer::new(rates.magnetometer_hz), device, published),
        serve(Inclinometer::new(rates.inclinometer_hz), device, published),
    )
    .await
    .0
}

/// Serves one chip for ever.
async fn serve<D: Driver, B: SensorBus>(
    driver: D,
    device: Device<'_, B>,
    published: &Published,
) -> ! {
    let conditions = &published.conditions;
    loop {
        let failure = match driver.start(device).await {
            Ok(()) => {
                conditions.set(D::CHIP, Condition::Running);
                read_until_silent(&driver, device, published).await
            }
            Err(failure) => {
                conditions.count_error(D::CHIP);
                failure
            }
        };
        if let Failure::WrongIdentity(found) = failure
            && !conditions.is(D::CHIP, Condition::WrongIdentity)
        {
            crate::logger::warn!("{}: identity {:#04x}", D::CHIP.name(), found);
        }
        conditions.set(D::CHIP, failure.condition());
        Timer::after(RETRY).await;
    }
}

/// Returns a ticker that fires `after_tick` after control ticks.
///
/// A control tick interrupts this task, for a time that differs from tick to tick. A transfer that
/// waited for the end of the tick would read the chip at moments that differ as much. If the chip
/// measures at about the rate at which it is read, and in between these moments, some transfers
/// find no reading and others skip one: the sensor counts as too slow. If transfers end near a
/// tick, sometimes before and sometimes after it, one tick sees two readings as one, and the next
/// one none. On the emulated boards a transfer takes no time, so that no reading ends near a tick.
fn ticker_after_tick(period: Duration, after_tick: Duration, newest: &Newest) -> Ticker {
    let mut ticker = Ticker::every(period);
    let taken = newest.taken().filter(|taken| taken.elapsed() < period);
    if let (Some(taken), true) = (taken, cfg!(feature = "stm32g4")) {
        ticker.reset_at(taken + after_tick);
    }
    ticker
}

/// Reads a chip at its rate until it has no new readings for some time. Returns the last failure.
async fn read_until_silent<D: Driver, B: SensorBus>(
    driver: &D,
    device: Device<'_, B>,
    published: &Published,
) -> Failure {
    let Published { newest, conditions } = published;
    let period = Duration::from_hz(u64::from(driver.rate_hz()));
    let silence = SILENCE.max(period * SILENT_PERIODS);
    let mut ticker = ticker_after_tick(period, D::AFTER_TICK, newest);
    let mut last = Instant::now();
    loop {
        ticker.next().await;
        let failure = match driver.read(device, newest).await {
            Ok(true) => {
                last = Instant::now();
                continue;
            }
            Ok(false) => Failure::NoReadings,
            Err(failure) => {
                conditions.count_error(D::CHIP);
                failure
            }
        };
        if last.elapsed() >= silence {
            return failure;
        }
    }
}
