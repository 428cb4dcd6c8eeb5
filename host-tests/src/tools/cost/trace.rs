//! Records every instruction of the counted calls: QEMU executes one instruction at a time and logs
//! what it translates and executes.

use super::cycles::{Executed, cycles, is_single_memory};
use super::emulator::Count;
use super::{CostError, emulator, image};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader};
use std::path::Path;

/// Results of the traced calls of one entry.
#[derive(Clone, PartialEq, Debug)]
pub struct Trace {
    /// Name of the entry.
    pub name: String,
    /// Minimum and maximum of the modelled cycles of the slowest call, without its return.
    pub cycles: [u32; 2],
    /// Bytes of code that the calls executed.
    pub code_bytes: u32,
}

/// Functions that are left out of the trace: double precision in software, which only constructors
/// use. If a counted call used one of them, its trace would be shorter than its count, and
/// [`trace`] would return an error.
const HIDDEN: [&str; 3] = [
    "compiler_builtins5float",
    "__aeabi_d",
    "5screw8Geometry3new",
];

struct Instruction {
    mnemonic: String,
    operands: String,
    size: u32,
}

/// One counted call: its address and the addresses of the instructions that it executed, the return
/// included.
struct Call {
    address: u32,
    executed: Vec<u32>,
}

/// Traces `calls` calls of every entry of `program`, whose ELF file is `elf`.
///
/// # Errors
/// QEMU fails, or the trace of a call has another number of instructions than the timer counted.
pub fn trace(program: &Path, elf: &[u8], calls: u32) -> Result<Vec<Trace>, CostError> {
    let ranges: Vec<String> = image::functions(elf)?
        .into_iter()
        .filter(|function| !HIDDEN.iter().any(|hidden| function.name.contains(hidden)))
        .map(|function| format!("{:#x}+{:#x}", function.address, function.size.max(2)))
        .collect();
    let filter = ranges.join(",");
    let arguments = [
        "-singlestep",
        "-d",
        "in_asm,exec,nochain",
        "-dfilter",
        &filter,
    ];
    // The addresses of the entries are needed to read the trace from its beginning, so a counting
    // run comes first.
    let addresses: BTreeSet<u32> = emulator::count(program, calls)?
        .iter()
        .map(|count| count.address)
        .collect();
    let mut child = emulator::start(program, calls, &arguments)?;
    let log = child
        .stderr
        .take()
        .ok_or_else(|| CostError::Malformed("no trace".to_owned()))?;
    let mut reader = Reader {
        addresses,
        instructions: BTreeMap::new(),
        before: 0,
        call: None,
        calls: Vec::new(),
    };
    for line in BufReader::with_capacity(1 << 20, log).lines() {
        reader.line(&line?);
    }
    reader.attribute(&emulator::finish(child)?)
}

struct Reader {
    addresses: BTreeSet<u32>,
    instructions: BTreeMap<u32, Instruction>,
    before: u32,
    /// The call that is being executed, and its return address.
    call: Option<(Call, u32)>,
    calls: Vec<Call>,
}

impl Reader {
    fn line(&mut self, line: &str) {
        if let Some(executed) = line.strip_prefix("Trace 0: ") {
            let address = executed
                .split('/')
                .nth(1)
                .and_then(|address| u32::from_str_radix(address, 16).ok());
            if let Some(address) = address {
                self.executed(address);
            }
        } else if line.starts_with("Stopped execution") {
            // QEMU stopped for one of its own timers before it executed the instruction that it had
            // already logged.
            if let Some((call, _)) = &mut self.call {
                call.executed.pop();
            }
        } else if line.starts_with("0x")
            && let Some((address, instruction)) = instruction(line)
        {
            self.instructions.insert(address, instruction);
        }
    }

    fn executed(&mut self, address: u32) {
        let caller = self.instructions.get(&self.before);
        if let Some((mut call, back)) = self.call.take() {
            if address == back {
                self.calls.push(call);
            } else {
                call.executed.push(address);
                self.call = Some((call, back));
            }
        // The program makes its counted calls through a function pointer.
        } else if let Some(caller) = caller
            && caller.mnemonic == "blx"
            && self.addresses.contains(&address)
        {
            let executed = vec![address];
            self.call = Some((Call { address, executed }, self.before + caller.size));
        }
        self.before = address;
    }

    /// Assigns the calls to the entries; both are in the same order.
    fn attribute(&self, counts: &[Count]) -> Result<Vec<Trace>, CostError> {
        let malformed = |what: String| CostError::Malformed(what);
        let nothing = counts.first().map_or(0, |count| count.address);
        // The program also makes an empty call for each counted call.
        let mut calls = self.calls.iter().filter(|call| call.address != nothing);
        let mut traces = Vec::new();
        for count in counts {
            let mut trace = Trace {
                name: count.name.clone(),
                cycles: [0, 0],
                code_bytes: 0,
            };
            let mut touched = BTreeSet::new();
            let mut sum = 0;
            let expected = if count.address == nothing {
                0
            } else {
                count.calls
            };
            for _ in 0..expected {
                let call = calls
                    .next()
                    .filter(|call| call.address == count.address)
                    .ok_or_else(|| {
                        malformed(format!("{}: a call is not in the trace", count.name))
                    })?;
                sum += call.executed.len() as u64 - 1;
                touched.extend(&call.executed);
                let modelled = self.cycles(&call.executed);
                if modelled[1] > trace.cycles[1] {
                    trace.cycles = modelled;
                }
            }
            if sum != count.sum {
                return Err(malformed(format!(
                    "{}: {sum} instructions in the trace, {} by the timer",
                    count.name, count.sum
                )));
            }
            trace.code_bytes = touched
                .iter()
                .filter_map(|address| self.instructions.get(address))
                .map(|instruction| instruction.size)
                .sum();
            traces.push(trace);
        }
        Ok(traces)
    }

    fn cycles(&self, executed: &[u32]) -> [u32; 2] {
        let mut sum = [0, 0];
        let mut after_memory = false;
        // The last address is the one of the return.
        for pair in executed.windows(2) {
            let Some(instruction) = self.instructions.get(&pair[0]) else {
                continue;
            };
            let modelled = cycles(Executed {
                mnemonic: &instruction.mnemonic,
                operands: &instruction.operands,
                branched: pair[1] != pair[0] + instruction.size,
                after_memory,
            });
            after_memory = is_single_memory(&instruction.mnemonic);
            sum = [sum[0] + modelled[0], sum[1] + modelled[1]];
        }
        sum
    }
}

/// Parses a line such as `0x00000400:  f001 f8be  bl       #0x1580`.
fn instruction(line: &str) -> Option<(u32, Instruction)> {
    let (address, rest) = line.strip_prefix("0x")?.split_once(':')?;
    let address = u32::from_str_radix(address, 16).ok()?;
    let mut words = rest.split_whitespace().peekable();
    let mut size = 0;
    while words.peek().is_some_and(|word| {
        size < 4 && word.len() == 4 && word.bytes().all(|byte| byte.is_ascii_hexdigit())
    }) {
        words.next();
        size += 2;
    }
    let mnemonic = words.next()?.to_owned();
    let operands = words.collect::<Vec<_>>().join(" ");
    Some((
        address,
        Instruction {
            mnemonic,
            operands,
            size,
        },
    ))
}
