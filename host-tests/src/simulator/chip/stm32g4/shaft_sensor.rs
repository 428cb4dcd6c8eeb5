//! Angle sensor at the output shaft of a motor board, on an I2C bus that the image drives by
//! software: clock on PB3, data on PB4. It sees the lines alone, edge by edge.
//!
//! Registers, addresses and their bits are those of ams' data sheets of AS5600 and AS5048B. Not
//! modelled: other registers, the time of a conversion, and the speed of the bus.

use super::{GPIO, State};

const PORT: u32 = GPIO + 0x400;
const CLOCK: u32 = 3;
const DATA: u32 = 4;

/// Kind of the chip.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ShaftChip {
    /// 12 bits, address 0x36.
    As5600,
    /// 14 bits, address 0x40.
    As5048b,
}

/// A sensor, and what is wrong with it.
#[derive(Clone, Debug)]
#[allow(clippy::struct_excessive_bools)] // independent levels and defects, not states
pub struct ShaftSensor {
    chip: ShaftChip,
    /// Angle as the chip's registers have it.
    pub angle: u16,
    /// The chip has its supply.
    pub powered: bool,
    /// A magnet is above the chip.
    pub magnet: bool,
    /// The chip holds the data line low for this number of clock pulses.
    pub holds_data: u32,
    /// Something holds the clock line low.
    pub holds_clock: bool,
    /// Bytes that the chip has sent.
    pub sent: u32,
    /// Levels of both lines, as the controller drives them.
    lines: [bool; 2],
    phase: Phase,
    /// The chip pulls the data line low.
    pulls: bool,
    pointer: u8,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Phase {
    Idle,
    /// Takes a byte, of which it has this number of bits: the address, or the pointer.
    Take {
        byte: u8,
        bits: u32,
        address: bool,
    },
    /// Acknowledges; afterwards it sends or takes.
    Acknowledge {
        sends: bool,
    },
    /// Sends a byte, of which this number of bits is left.
    Send {
        byte: u8,
        bits: u32,
    },
    /// Waits for the controller's acknowledge.
    Acknowledged(bool),
}

impl ShaftSensor {
    fn new(chip: ShaftChip) -> Self {
        Self {
            chip,
            angle: 0,
            powered: true,
            magnet: true,
            holds_data: 0,
            holds_clock: false,
            sent: 0,
            lines: [true; 2],
            phase: Phase::Idle,
            pulls: false,
            pointer: 0,
        }
    }

    fn register(&self, register: u8) -> u8 {
        let [high, low] = self.angle.to_be_bytes();
        match (self.chip, register) {
            // MD; without a magnet ML, because the gain is at its end.
            (ShaftChip::As5600, 0x0b) if self.magnet => 0x20,
            (ShaftChip::As5600, 0x0b) => 0x10,
            (ShaftChip::As5600, 0x0c) => high & 0x0f,
            (ShaftChip::As5600, 0x0d) => low,
            // OCF; without a magnet the field is too low.
            (ShaftChip::As5048b, 0xfb) if self.magnet => 0x01,
            (ShaftChip::As5048b, 0xfb) => 0x05,
            (ShaftChip::As5048b, 0xfe) => (self.angle >> 6) as u8,
            (ShaftChip::As5048b, 0xff) => low & 0x3f,
            _ => 0,
        }
    }

    /// Takes the levels of clock and data that the controller drives.
    fn drive(&mut self, [clock, data]: [bool; 2]) {
        let [clock_before, data_before] = std::mem::replace(&mut self.lines, [clock, data]);
        if clock && !clock_before {
            self.holds_data = self.holds_data.saturating_sub(1);
        }
        if !self.powered {
            (self.phase, self.pulls) = (Phase::Idle, false);
            return;
        }
        match (clock_before, clock) {
            (true, true) if data_before && !data && !self.pulls => {
                self.phase = Phase::Take {
                    byte: 0,
                    bits: 0,
                    address: true,
                };
            }
            (true, true) if !data_before && data => {
                (self.phase, self.pulls) = (Phase::Idle, false);
            }
            (false, true) => self.rises(data),
            (true, false) => self.falls(),
            _ => {}
        }
    }

    fn rises(&mut self, data: bool) {
        match &mut self.phase {
            Phase::Take { byte, bits, .. } => {
                *byte = *byte << 1 | u8::from(data);
                *bits += 1;
            }
            Phase::Acknowledged(acknowledged) => *acknowledged = !data,
            _ => {}
        }
    }

    fn falls(&mut self) {
        self.phase = match self.phase {
            Phase::Take {
                byte,
                bits: 8,
                address,
            } => {
                let own = match self.chip {
                    ShaftChip::As5600 => 0x36,
                    ShaftChip::As5048b => 0x40,
                };
                self.pulls = !address || byte >> 1 == own;
                if !address {
                    self.pointer = byte;
                }
                if self.pulls {
                    Phase::Acknowledge {
                        sends: address && byte & 1 != 0,
                    }
                } else {
                    Phase::Idle
                }
            }
            Phase::Acknowledge { sends: true } | Phase::Acknowledged(true) => {
                let byte = self.register(self.pointer);
                self.pointer = self.pointer.wrapping_add(1);
                self.sent += 1;
                self.pulls = byte & 0x80 == 0;
                Phase::Send { byte, bits: 8 }
            }
            Phase::Acknowledge { sends: false } => {
                self.pulls = false;
                Phase::Take {
                    byte: 0,
                    bits: 0,
                    address: false,
                }
            }
            Phase::Send { bits: 1, .. } => {
                self.pulls = false;
                Phase::Acknowledged(false)
            }
            Phase::Send { byte, bits } => {
                let byte = byte << 1;
                self.pulls = byte & 0x80 == 0;
                Phase::Send {
                    byte,
                    bits: bits - 1,
                }
            }
            Phase::Acknowledged(false) => Phase::Idle,
            other => other,
        };
    }
}

impl State {
    /// Connects a sensor.
    pub(super) fn connect_shaft_sensor(&mut self, chip: ShaftChip) -> &mut ShaftSensor {
        self.shaft_sensor.insert(ShaftSensor::new(chip))
    }

    /// Whether the port, as an open drain, leaves this line to the pull-up resistor.
    fn releases(&self, pin: u32) -> bool {
        let output = self.get(PORT) >> (2 * pin) & 3 == 1;
        !output || self.get(PORT + 0x14) >> pin & 1 != 0
    }

    /// Shows the sensor the lines after a write to the port.
    pub(super) fn drive_shaft_sensor(&mut self, address: u32) {
        if !(PORT..PORT + 0x400).contains(&address) {
            return;
        }
        let lines = [CLOCK, DATA].map(|pin| self.releases(pin));
        let open_drains = self.get(PORT + 0x04) >> CLOCK & 3 == 3;
        if let Some(sensor) = self.shaft_sensor.as_mut().filter(|_| open_drains)
            && sensor.lines != lines
        {
            sensor.drive(lines);
        }
    }

    /// Levels of the lines in the input register, if a sensor is connected; all others as `levels`.
    pub(super) fn with_shaft_sensor(&self, levels: u32) -> u32 {
        let Some(sensor) = &self.shaft_sensor else {
            return levels;
        };
        let clock = self.releases(CLOCK) && !sensor.holds_clock;
        let data = self.releases(DATA) && !sensor.pulls && sensor.holds_data == 0;
        levels & !(3 << CLOCK) | u32::from(clock) << CLOCK | u32::from(data) << DATA
    }
}
