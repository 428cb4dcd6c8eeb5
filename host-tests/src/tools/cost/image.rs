//! Reads sizes and symbols from a program for the target.

use super::CostError;
use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSection, ObjectSymbol, SymbolKind};
use serde::{Deserialize, Serialize};

/// Memory that a program needs.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct Image {
    /// Name of the program.
    pub name: String,
    /// Vectors, code, constants and initial values, bytes.
    pub flash: u64,
    /// Static variables without the stack, bytes.
    pub ram: u64,
    /// Maximum stack during a short run on the bus, bytes; `None` for a program that is never run.
    pub stack: Option<u32>,
}

/// A function of a program, from its symbols.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Function {
    /// Name of its symbol.
    pub name: String,
    /// Address at which it begins.
    pub address: u64,
    /// Size of its code, bytes.
    pub size: u64,
}

impl Image {
    /// Reads the sizes from the ELF file `elf`. `stack` stays `None`.
    ///
    /// # Errors
    /// The bytes are no ELF file.
    pub fn read(name: &str, elf: &[u8]) -> Result<Self, CostError> {
        let file = parse(elf)?;
        let sum = |names: &[&str]| {
            names
                .iter()
                .filter_map(|name| file.section_by_name(name))
                .map(|section| section.size())
                .sum()
        };
        Ok(Self {
            name: name.to_owned(),
            flash: sum(&[".vector_table", ".text", ".rodata", ".data"]),
            ram: sum(&[".data", ".bss", ".uninit"]),
            stack: None,
        })
    }
}

/// The functions of a program.
///
/// # Errors
/// The bytes are no ELF file.
pub fn functions(elf: &[u8]) -> Result<Vec<Function>, CostError> {
    let file = parse(elf)?;
    Ok(file
        .symbols()
        .filter(|symbol| symbol.kind() == SymbolKind::Text)
        .map(|symbol| Function {
            name: symbol.name().unwrap_or_default().to_owned(),
            address: symbol.address() & !1,
            size: symbol.size(),
        })
        .collect())
}

/// The version of the compiler that built a program, from its `.comment` section.
///
/// # Errors
/// The bytes are no ELF file, or do not name the compiler.
pub fn compiler(elf: &[u8]) -> Result<String, CostError> {
    let file = parse(elf)?;
    let comment = file
        .section_by_name(".comment")
        .and_then(|section| section.data().ok());
    let text = String::from_utf8_lossy(comment.unwrap_or_default()).into_owned();
    text.split('\0')
        .find_map(|line| line.strip_prefix("rustc version "))
        .map(str::to_owned)
        .ok_or_else(|| CostError::Malformed("the program does not name its compiler".to_owned()))
}

fn parse(elf: &[u8]) -> Result<ElfFile32<'_, Endianness>, CostError> {
    ElfFile32::parse(elf).map_err(|error| CostError::Malformed(format!("no ELF file: {error}")))
}
