//! WebAssembly module as a board: the simulator calls the node instead of exchanging messages with
//! it over pipes. Each node is an instance of the module with a memory of its own, and many
//! instances fit into one process, also in a web page.
//!
//! The module imports nothing. A program made with [`program!`](crate::program) exports `buffer`,
//! `answer` and `last_words`.

use crate::boards::Board;
use crate::boards::lockstep::{self, End, Machine, text_log};
use crate::roles::Role;
use crate::sensors::Rates;
use embassy_executor::{SpawnError, Spawner};
use std::boxed::Box;
use std::cell::RefCell;
use std::string::{String, ToString};
use std::sync::Mutex;
use std::thread_local;
use tautrack::link::{MAX_MESSAGE, Stepped};
use tautrack::motor::bridge::Ratings;
use tautrack::sensors::Switches;

/// An instance of a WebAssembly module.
pub struct Wasm;

impl Board for Wasm {
    const NAME: &'static str = "wasm";
    const POWER_STAGE: Ratings = lockstep::POWER_STAGE;
    type Storage = lockstep::Flash;

    fn encoder() -> i32 {
        lockstep::encoder()
    }

    fn encoder_broken() -> bool {
        lockstep::encoder_broken()
    }

    fn index() -> Option<u32> {
        lockstep::index()
    }

    fn supply_voltage() -> f32 {
        lockstep::supply_voltage()
    }

    fn switches() -> Switches {
        lockstep::switches()
    }

    fn set_brake(released: bool) {
        lockstep::set_brake(released);
    }

    fn start_sensors(spawner: Spawner, rates: Rates) -> Result<(), SpawnError> {
        lockstep::start_sensors(spawner, rates)
    }

    fn serial_number() -> u32 {
        lockstep::serial_number()
    }

    fn storage() -> lockstep::Flash {
        lockstep::Flash
    }

    fn feed_watchdog() {
        lockstep::feed_watchdog();
    }
}

struct Node {
    machine: Option<Machine>,
    buffer: Box<[u8; MAX_MESSAGE]>,
    stepped: Stepped,
}

thread_local! {
    static NODE: RefCell<Node> = RefCell::new(Node {
        machine: None,
        buffer: Box::new([0; MAX_MESSAGE]),
        stepped: Stepped::default(),
    });
}

/// Why the node has ended. It is not part of `NODE`, which stays borrowed after a panic.
static LAST_WORDS: Mutex<String> = Mutex::new(String::new());

fn end_with(words: String) {
    if let Ok(mut last) = LAST_WORDS.lock() {
        *last = words;
    }
}

/// Address of the buffer for messages and answers, of [`MAX_MESSAGE`] bytes. It does not change.
pub fn buffer() -> *const u8 {
    NODE.with_borrow(|node| node.buffer.as_ptr())
}

/// Answers the message in the first `length` bytes of the buffer. Writes the answer to the buffer
/// and returns its length; 0 if the node has ended.
pub fn answer(role: &'static Role, others: &'static [&'static Role], length: usize) -> usize {
    NODE.with_borrow_mut(|node| {
        let machine = node.machine.get_or_insert_with(|| {
            text_log::install();
            std::panic::set_hook(Box::new(|panic| end_with(panic.to_string())));
            Machine::new(Wasm::NAME, role, others, None)
        });
        match machine.answer(&mut node.buffer[..], length, &mut node.stepped) {
            Ok(length) => length,
            Err(End::Finished) => 0,
            Err(End::Starved(starved)) => {
                end_with(starved.to_string());
                0
            }
        }
    })
}

/// Why the node has ended: the address of the text in the upper 32 bits, its length in the lower
/// ones. The text is empty if the node has not ended or has nothing to report.
pub fn last_words() -> u64 {
    LAST_WORDS.lock().map_or(0, |words| {
        (words.as_ptr() as u64) << 32 | words.len() as u64
    })
}

/// Makes a program that answers for a node when it is called. The node has the first role, unless
/// the simulator asks for another one.
#[macro_export]
macro_rules! program {
    ($role:expr $(, $other:expr)*) => {
        /// See [`tautrack_firmware::boards::wasm::buffer`].
        // SAFETY: no other function of the program has this name.
        #[unsafe(no_mangle)]
        extern "C" fn buffer() -> *const u8 {
            $crate::boards::wasm::buffer()
        }

        /// See [`tautrack_firmware::boards::wasm::answer`].
        // SAFETY: no other function of the program has this name.
        #[unsafe(no_mangle)]
        extern "C" fn answer(length: usize) -> usize {
            static OTHERS: &[&$crate::roles::Role] = &[$(&$other),*];
            $crate::boards::wasm::answer(&$role, OTHERS, length)
        }

        /// See [`tautrack_firmware::boards::wasm::last_words`].
        // SAFETY: no other function of the program has this name.
        #[unsafe(no_mangle)]
        extern "C" fn last_words() -> u64 {
            $crate::boards::wasm::last_words()
        }
    };
}
