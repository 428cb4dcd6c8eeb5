//! The processor under the images: properties that the version of rsemu lacks, and that the model
//! of the chip must add.

use crate::chip::Chip;

const FLASH: u32 = 0x0800_0000;
const RAM: u32 = 0x2000_0000;
/// Offset of the clock's interrupt in the vector table.
const TIMER_VECTOR: u32 = 4 * (16 + 28);
/// Address of the program.
const PROGRAM: u32 = FLASH + 0x100;

/// Executes a program for 100 ms that clears two words of RAM and enables the interrupt of TIM2 at
/// its overflow. The handler, at this offset, stores r1 to the first word and counts its calls in
/// the second. Returns r1.
fn interrupted(code: &[u16], handler: u32) -> u32 {
    let mut chip = Chip::new(&[], FLASH);
    for (address, word) in [
        (FLASH, RAM + 0x1000),
        (FLASH + 4, PROGRAM + 1),
        (FLASH + TIMER_VECTOR, PROGRAM + handler + 1),
    ] {
        chip.patch(address, &word.to_le_bytes());
    }
    let code: Vec<u8> = code.iter().flat_map(|half| half.to_le_bytes()).collect();
    chip.patch(PROGRAM, &code);
    chip.run(100_000);
    let word = |address| {
        let bytes = chip.memory(address, 4).try_into().expect("a word");
        u32::from_le_bytes(bytes)
    };
    // The timer overflows every 65536 clocks, each time at another place of the loop.
    assert!(word(RAM + 4) > 200, "{} interrupts", word(RAM + 4));
    word(RAM)
}

/// Loops for ever:
///
/// ```text
/// cmp r0, #0      @ r0 is 1
/// itttt eq
/// addeq r1, #1    @ four times
/// ```
#[test]
fn an_interrupt_within_a_conditional_block_does_not_make_its_rest_unconditional() {
    let code = [
        0xf04f, 0x5300, 0x2100, 0x6019, 0x6059, 0x4a0e, 0x2301, 0x071b, 0x6013, 0xf04f, 0x4280,
        0x2301, 0x60d3, 0x6013, 0x2001, 0x2800, 0xbf01, 0x3101, 0x3101, 0x3101, 0x3101, 0xe7f8,
        0xf04f, 0x4280, 0x2300, 0x6113, 0xf04f, 0x5300, 0x6019, 0x685a, 0x3201, 0x605a, 0x4770,
        0x0000, 0xe100, 0xe000,
    ];
    assert_eq!(interrupted(&code, 0x2c), 0, "conditional additions");
}

/// Loops for ever:
///
/// ```text
/// vcmp.f32 s0, s0           @ s0 is 1.0
/// vmrs APSR_nzcv, FPSCR
/// beq skip
/// adds r1, #1
/// skip:
/// ```
#[test]
fn an_interrupt_after_a_floating_point_comparison_does_not_change_its_result() {
    let code = [
        0xf04f, 0x5300, 0x2100, 0x6019, 0x6059, 0x4a10, 0xf44f, 0x0370, 0x6013, 0x4a0f, 0x2301,
        0x071b, 0x6013, 0xf04f, 0x4280, 0x2301, 0x60d3, 0x6013, 0xeeb7, 0x0a00, 0xeeb4, 0x0a40,
        0xeef1, 0xfa10, 0xd000, 0x3101, 0xe7f8, 0xf04f, 0x4280, 0x2300, 0x6113, 0xf04f, 0x5300,
        0x6019, 0x685a, 0x3201, 0x605a, 0x4770, 0xed88, 0xe000, 0xe100, 0xe000,
    ];
    assert_eq!(
        interrupted(&code, 0x36),
        0,
        "comparisons with a wrong result"
    );
}
