//! Models the cycles that an executed instruction takes on a Cortex-M4F without wait states, from
//! the tables of its Technical Reference Manual (3.3.1 and 7.2.3). The model has not been compared
//! with a real core.
//!
//! The model gives a minimum and a maximum. A taken branch refills the pipeline in one to three
//! cycles, and an integer division takes two to twelve, depending on facts that neither trace nor
//! manual contains. A load takes two cycles, or one directly after a load or store. A store takes
//! one.

/// An executed instruction and what its cycles depend on.
#[derive(Clone, Copy, Debug)]
pub struct Executed<'a> {
    /// Mnemonic with its suffixes, as the disassembler prints it.
    pub mnemonic: &'a str,
    /// Operands, as the disassembler prints them.
    pub operands: &'a str,
    /// Whether the next executed instruction is not the one behind it in memory.
    pub branched: bool,
    /// Whether the instruction before it was a load or store of one word.
    pub after_memory: bool,
}

/// Whether `mnemonic` loads or stores one word. The next load or store overlaps with it.
pub fn is_single_memory(mnemonic: &str) -> bool {
    let single = ["ldr", "str", "vldr", "vstr"];
    single.iter().any(|start| mnemonic.starts_with(start))
        && !mnemonic.starts_with("ldrd")
        && !mnemonic.starts_with("strd")
}

/// Minimum and maximum cycles of an instruction.
pub fn cycles(instruction: Executed) -> [u32; 2] {
    let Executed {
        mnemonic,
        operands,
        branched,
        after_memory,
    } = instruction;
    let starts = |names: &[&str]| names.iter().any(|name| mnemonic.starts_with(name));
    let base = if starts(&["vdiv", "vsqrt"]) {
        [14, 14]
    } else if starts(&[
        "vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms", "vfnma", "vfnms",
    ]) {
        [3, 3]
    } else if starts(&["udiv", "sdiv"]) {
        [2, 12]
    } else if starts(&[
        "push", "pop", "ldm", "stm", "ldrd", "strd", "vpush", "vpop", "vldm", "vstm",
    ]) {
        let count = 1 + registers(mnemonic, operands);
        [count, count]
    } else if (starts(&["ldr", "vldr"]) && !after_memory)
        || (mnemonic.starts_with("vmov") && operands.split(',').count() > 2)
    {
        [2, 2]
    } else {
        [1, 1]
    };
    let refill = if branched { [1, 3] } else { [0, 0] };
    [base[0] + refill[0], base[1] + refill[1]]
}

/// Number of words that a multiple load or store transfers.
fn registers(mnemonic: &str, operands: &str) -> u32 {
    if mnemonic.starts_with("ldrd") || mnemonic.starts_with("strd") {
        return 2;
    }
    let list = operands
        .split_once('{')
        .map_or("", |(_, list)| list.trim_end_matches('}'));
    let number = |name: &str| -> Option<u32> { name.trim().get(1..)?.parse().ok() };
    list.split(',')
        .map(|item| {
            let words = if item.trim().starts_with('d') { 2 } else { 1 };
            let registers = item
                .split_once('-')
                .and_then(|(first, last)| Some(number(last)?.checked_sub(number(first)?)? + 1));
            words * registers.unwrap_or(1)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(mnemonic: &str, operands: &str, branched: bool, after_memory: bool) -> [u32; 2] {
        cycles(Executed {
            mnemonic,
            operands,
            branched,
            after_memory,
        })
    }

    #[test]
    fn instructions_take_what_the_manual_says() {
        assert_eq!(of("smmlar", "r0, r1, r2, r3", false, false), [1, 1]);
        assert_eq!(of("ldr.w", "r0, [r1, #4]", false, false), [2, 2]);
        assert_eq!(of("ldr", "r0, [r1, #8]", false, true), [1, 1]);
        assert_eq!(of("push", "{r4, r5, r7, lr}", false, false), [5, 5]);
        assert_eq!(of("pop", "{r4, r7, pc}", true, false), [5, 7]);
        assert_eq!(of("vpush", "{d8, d9}", false, false), [5, 5]);
        assert_eq!(of("vldmia", "r0, {s0-s3}", false, false), [5, 5]);
        assert_eq!(of("ldrd", "r0, r1, [sp]", false, false), [3, 3]);
        assert_eq!(of("bne", "#0x400", false, false), [1, 1]);
        assert_eq!(of("bne", "#0x400", true, false), [2, 4]);
        assert_eq!(of("vsqrt.f32", "s0, s0", false, false), [14, 14]);
        assert_eq!(of("vfma.f32", "s0, s1, s2", false, false), [3, 3]);
        assert_eq!(of("sdiv", "r0, r1, r2", false, false), [2, 12]);
    }
}
