//! A panic of a guard: the log names the line, and the watchdog resets the chip.

use crate::gates::log_of;
use crate::guard::running_guard;
use crate::guard_images::guards;
use crate::stamp;
use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSymbol};
use std::fs;
use std::path::Path;
use tautrack_host_tests::programs::flash::{self, Segment};

/// A line of the source that can panic, as the image stores it.
struct Place {
    address: u32,
    file: String,
    line: u32,
}

fn bytes(segments: &[Segment], address: u32, length: u32) -> Option<&[u8]> {
    segments.iter().find_map(|segment| {
        let start = address.checked_sub(segment.address)? as usize;
        segment
            .bytes
            .get(start..start.checked_add(length as usize)?)
    })
}

/// The constant at an address, if it is a `core::panic::Location`: text, its length, line, column.
fn place(segments: &[Segment], address: u32) -> Option<Place> {
    let mut words = bytes(segments, address, 16)?.chunks_exact(4);
    let mut word = || Some(u32::from_le_bytes(words.next()?.try_into().ok()?));
    let (text, length, line) = (word()?, word()?, word()?);
    let file = str::from_utf8(bytes(segments, text, length)?).ok()?;
    let file = file.trim_end_matches('\0');
    let is_source = Path::new(file).extension().is_some_and(|it| it == "rs");
    is_source.then(|| Place {
        address,
        file: file.to_owned(),
        line,
    })
}

#[test]
fn the_log_names_the_line_of_a_panic_and_the_watchdog_resets_the_guard() {
    let Some(_stamp) = stamp("the_log_names_the_line_of_a_panic_and_the_watchdog_resets_the_guard")
    else {
        return;
    };
    let program = &guards()[0];
    let elf = fs::read(&program.path).expect("a program");
    let segments = flash::segments(&elf).expect("an image");
    let words = segments.iter().flat_map(|segment| {
        let end = segment.address + segment.bytes.len() as u32;
        (segment.address..end).step_by(4)
    });
    let place = { words }
        .find_map(|address| place(&segments, address))
        .expect("a line that can panic");
    let file = ElfFile32::<Endianness>::parse(&*elf).expect("an ELF file");
    let panics = { file.symbols() }
        .find(|it| {
            it.name()
                .is_ok_and(|it| it.contains("option13unwrap_failed"))
        })
        .expect("a function that panics");
    let mut chip = running_guard();
    // Without the bit that marks Thumb code.
    chip.call(panics.address() as u32 & !1, place.address);
    chip.run(1_000);
    let line = format!("panic in {}, line {}", place.file, place.line);
    assert_eq!(log_of(program, &chip).pop(), Some(line));
    chip.run(60_000);
    assert_eq!(chip.resets(), 1);
}
