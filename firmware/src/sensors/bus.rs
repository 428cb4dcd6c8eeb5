//! What a board provides for its sensors.

use embedded_hal_async::i2c::I2c;

/// I2C bus with the sensor chips of a board.
///
/// Embassy's asynchronous I2C drivers implement [`I2c`]. A transfer may be dropped before it ends;
/// the next call is then [`Self::recover`].
pub trait SensorBus: I2c {
    /// Frees the bus after a transfer that failed or did not end: resets the controller, and gives
    /// up to nine clock pulses and a stop condition while a chip holds the data line low (NXP
    /// UM10204, section 3.1.16). It should take less than a millisecond.
    fn recover(&mut self) -> impl Future<Output = ()>;
}
