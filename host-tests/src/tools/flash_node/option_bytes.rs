//! Where the motor board's chip starts: its boot pin is also an input of the encoder, so the option
//! bytes must say that it starts the flash memory (RM0440, 2.6.1 and 5.4). Boards leave the factory
//! so; a chip whose option bytes were erased does not.

use super::probe::{self, MOTOR_BOARD};

/// Register of the option bytes, and its bits: the boot pin decides; without it, the flash memory.
const OPTIONS: u32 = 0x4002_2020;
const PIN_DECIDES: u32 = 1 << 26;
const STARTS_FLASH: u32 = 1 << 27;
/// Level of the read protection, and its value for none.
const PROTECTION: u32 = 0xff;
const UNPROTECTED: u32 = 0xaa;
/// Key registers of flash memory and option bytes, and the control register.
const KEYS: [(u32, u32); 4] = [
    (0x4002_2008, 0x4567_0123),
    (0x4002_2008, 0xcdef_89ab),
    (0x4002_200c, 0x0819_2a3b),
    (0x4002_200c, 0x4c5d_6e7f),
];
const CONTROL: u32 = 0x4002_2014;
const PROGRAM_OPTIONS: u32 = 1 << 17;
const LOAD_OPTIONS: u32 = 1 << 27;

/// Reads the option bytes of a connected motor board, and sets them if `set`. Otherwise it says
/// what is wrong with them.
///
/// # Errors
/// One line with the command that failed, or why they are not set.
pub(super) fn look(set: bool) -> Result<(), String> {
    let options = probe::read(MOTOR_BOARD, OPTIONS)?;
    if options & (PIN_DECIDES | STARTS_FLASH) == STARTS_FLASH {
        return Ok(());
    }
    if !set {
        println!(
            "option bytes {options:#010x}: the chip starts its ROM while PB8 is high; add \
             --set-option-bytes"
        );
        return Ok(());
    }
    if options & PROTECTION != UNPROTECTED {
        return Err(format!(
            "option bytes {options:#010x}: the chip is protected against reading"
        ));
    }
    let wanted = options & !PIN_DECIDES | STARTS_FLASH;
    let writes = [(OPTIONS, wanted), (CONTROL, PROGRAM_OPTIONS)];
    for (register, word) in KEYS.into_iter().chain(writes) {
        probe::write(MOTOR_BOARD, register, word)?;
    }
    // This resets the chip, so the probe may lose it.
    let _ = probe::write(MOTOR_BOARD, CONTROL, LOAD_OPTIONS);
    match probe::read(MOTOR_BOARD, OPTIONS)? {
        got if got == wanted => Ok(()),
        got => Err(format!("option bytes are {got:#010x}, not {wanted:#010x}")),
    }
}
