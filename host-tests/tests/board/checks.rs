//! Checks of the images of all boards.

use crate::chip::{Chip, FDCAN, FLASH_CONTROL, GPIO, IWDG, PWR, RCC, TIM2};
use crate::pins;
use tautrack::can::Frame;

pub fn field(word: u32, low: u32, bits: u32) -> u32 {
    word >> low & ((1 << bits) - 1)
}

pub fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(id, data).expect("a frame")
}

/// Writes an object by SDO, and waits for the answer.
pub fn write(chip: &mut Chip, node: u16, object: u16, sub: u8, value: &[u8]) {
    let [low, high] = object.to_le_bytes();
    let mut data = [0; 8];
    data[..4].copy_from_slice(&[0x23 | (4 - value.len() as u8) << 2, low, high, sub]);
    data[4..4 + value.len()].copy_from_slice(value);
    chip.take_sent();
    chip.send(frame(0x600 + node, &data));
    chip.run(3_000);
    let sent = chip.take_sent();
    let answered = sent
        .iter()
        .any(|(_, frame)| frame.id() == 0x580 + node && frame.data()[0] == 0x60);
    assert!(answered, "{object:#x}: {sent:x?}");
}

/// Reads an object of up to four bytes by SDO.
pub fn read(chip: &mut Chip, node: u16, object: u16, sub: u8) -> u32 {
    let [low, high] = object.to_le_bytes();
    chip.take_sent();
    chip.send(frame(0x600 + node, &[0x40, low, high, sub, 0, 0, 0, 0]));
    chip.run(3_000);
    let sent = chip.take_sent();
    let answer = sent.iter().find(|(_, frame)| frame.id() == 0x580 + node);
    let (_, answer) = answer.unwrap_or_else(|| panic!("{object:#x}: {sent:x?}"));
    u32::from_le_bytes(answer.data()[4..8].try_into().expect("four bytes"))
}

/// Checks that the core runs at 170 MHz from a crystal, which `divider` divides to 4 MHz, with
/// boost and four wait states.
pub fn clocks(chip: &Chip, divider: u32) {
    let pll = chip.register(RCC + 0x0c);
    // The divided crystal, times 85, divided by 2.
    assert_eq!(field(pll, 0, 2), 3, "source");
    assert_eq!(field(pll, 4, 4) + 1, divider, "M");
    assert_eq!(field(pll, 8, 7), 85, "N");
    assert_eq!(2 * (field(pll, 25, 2) + 1), 2, "R");
    assert_eq!(field(pll, 24, 1), 1, "output R");
    assert_eq!(field(chip.register(RCC + 0x08), 2, 2), 3, "system clock");
    assert_eq!(field(chip.register(FLASH_CONTROL), 0, 4), 4, "wait states");
    assert_eq!(field(chip.register(FLASH_CONTROL), 8, 1), 1, "prefetch");
    assert_eq!(field(chip.register(FLASH_CONTROL), 9, 2), 3, "caches");
    assert_eq!(field(chip.register(PWR + 0x80), 8, 1), 0, "R1MODE");
    // Boost and wait states come before the switch to the fast clock.
    let writes = chip.writes();
    let at = |address: u32, holds: fn(u32) -> bool| {
        writes
            .iter()
            .position(|write| write.address == address && holds(write.value))
            .unwrap_or_else(|| panic!("{address:#x} is never written"))
    };
    // The bus clock is half of the fast clock for at least 1 us, so 85 clocks of the core.
    let switched = at(RCC + 0x08, |value| value & 3 == 3);
    assert_eq!(
        field(writes[switched].value, 4, 4),
        8,
        "AHB/2 at the switch"
    );
    let full = at(RCC + 0x08, |value| value & 0xf3 == 3);
    assert!(writes[full].clock >= writes[switched].clock + 85);
    assert!(at(FLASH_CONTROL, |value| value & 15 == 4) < full);
    assert_eq!(field(chip.register(RCC + 0x08), 4, 4), 0, "AHB/1");
    // The clock of the program counts microseconds.
    assert_eq!(chip.register(TIM2 + 0x28), 169);
    assert!(at(PWR + 0x80, |value| value & 1 << 8 == 0) < switched);
    // Two wait states are enough for 85 MHz.
    assert!(at(FLASH_CONTROL, |value| value & 15 >= 2) < switched);
}

/// Checks that the watchdog is started before the clocks, that it bites after 50 ms, and that it is
/// fed.
pub fn watchdog(chip: &Chip) {
    assert_eq!(chip.register(IWDG + 4), 0, "divided by 4");
    assert_eq!(chip.register(IWDG + 8), 399, "50 ms at 8 kHz");
    let writes = chip.writes();
    let started = writes
        .iter()
        .position(|write| (write.address, write.value) == (IWDG, 0xcccc))
        .expect("the watchdog is started");
    let clocks = writes
        .iter()
        .position(|write| write.address == RCC)
        .expect("the clocks are set");
    assert!(started < clocks);
    let fed = writes
        .iter()
        .filter(|write| (write.address, write.value) == (IWDG, 0xaaaa));
    assert!(fed.count() > 2);
}

/// Checks that a bit on the bus has 170 clocks and is sampled at 80 %.
pub fn bit_timing(chip: &Chip) {
    let timing = chip.register(FDCAN + 0x1c);
    let before = field(timing, 8, 8) + 2;
    let after = field(timing, 0, 7) + 1;
    assert_eq!(field(timing, 16, 9), 0, "prescaler");
    assert_eq!(before + after, 170);
    assert_eq!(before * 10, 170 * 8);
    assert_eq!(
        field(chip.register(FDCAN + 0x18), 0, 1),
        0,
        "takes part in the bus"
    );
}

/// Checks that every pin has the function of the page. Returns the number of pins.
pub fn pins(chip: &Chip, page: &str) -> usize {
    let rows = pins::rows(page);
    let count = rows.len();
    for (pin, function) in rows {
        let port = GPIO + 0x400 * u32::from(pin.as_bytes()[1] - b'A');
        let number: u32 = pin[2..].parse().expect("a number");
        let alternate = pins::alternate(&function);
        let mode = match &*function {
            "input" => 0,
            "output" => 1,
            "analogue" => 3,
            _ => 2,
        };
        let got = field(chip.register(port), 2 * number, 2);
        assert_eq!(got, mode, "{pin}: mode");
        if let Some((_, wanted)) = alternate {
            let register = port + 0x20 + 4 * (number / 8);
            let got = field(chip.register(register), 4 * (number % 8), 4);
            assert_eq!(got, wanted, "{pin}: alternate function");
        }
    }
    count
}
