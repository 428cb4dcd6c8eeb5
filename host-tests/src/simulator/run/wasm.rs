//! Runs one node program as a WebAssembly module in this process. Each instance has a memory of its
//! own. A node that panics traps: its instance ends, and this program does not.

use super::link::{Link, TIMEOUT, late};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, SystemTime};
use tautrack::link::MAX_MESSAGE;
use wasmtime::{Config, Engine, Memory, Module, Store, Trap, TypedFunc};

/// Period in which the engine counts the time of running nodes.
const TICK: Duration = Duration::from_millis(100);

/// Running instance of a node program.
pub(super) struct Instance {
    store: Store<()>,
    memory: Memory,
    answer: TypedFunc<u32, u32>,
    last_words: TypedFunc<(), u64>,
    /// Address of the buffer for messages and answers in the instance's memory.
    buffer: usize,
    /// Length of the message in the buffer that is not answered yet.
    pending: u32,
    timeout: Duration,
}

impl Instance {
    /// Creates an instance of the program at `path`.
    ///
    /// # Errors
    /// The reason in words, if the program cannot be read or is no node program.
    pub fn start(path: &Path) -> Result<Self, String> {
        let fail = |error: wasmtime::Error| format!("{} does not start: {error}", path.display());
        let engine = engine()?;
        let module = module(engine, path).map_err(fail)?;
        let mut store = Store::new(engine, ());
        store.set_epoch_deadline(ticks(TIMEOUT));
        let instance = wasmtime::Instance::new(&mut store, &module, &[]).map_err(fail)?;
        let memory = instance.get_memory(&mut store, "memory");
        let buffer = instance
            .get_typed_func::<(), u32>(&mut store, "buffer")
            .and_then(|buffer| buffer.call(&mut store, ()))
            .map_err(fail)?;
        Ok(Self {
            memory: memory.ok_or("its program exports no memory")?,
            answer: instance
                .get_typed_func(&mut store, "answer")
                .map_err(fail)?,
            last_words: instance
                .get_typed_func(&mut store, "last_words")
                .map_err(fail)?,
            store,
            buffer: buffer as usize,
            pending: 0,
            timeout: TIMEOUT,
        })
    }

    /// Returns the error of a node that has ended, with its last words.
    fn ended(&mut self, how: &str) -> String {
        self.store.set_epoch_deadline(ticks(TIMEOUT));
        let words = self.last_words.call(&mut self.store, ()).ok();
        let words = words.and_then(|place| {
            let (start, length) = ((place >> 32) as usize, place as u32 as usize);
            let bytes = self.memory.data(&self.store).get(start..start + length)?;
            Some(String::from_utf8_lossy(bytes).into_owned())
        });
        match words {
            Some(words) if !words.is_empty() => format!("its program ended ({how}): {words}"),
            _ => format!("its program ended ({how}); it wrote nothing about it"),
        }
    }
}

impl Link for Instance {
    fn send(&mut self, message: &[u8]) -> Result<(), String> {
        if message.len() > MAX_MESSAGE {
            return Err(format!(
                "a message has {} bytes, at most {MAX_MESSAGE}",
                message.len()
            ));
        }
        self.memory
            .write(&mut self.store, self.buffer, message)
            .map_err(|error| error.to_string())?;
        self.pending = message.len() as u32;
        Ok(())
    }

    fn receive(&mut self, answer: &mut Vec<u8>) -> Result<(), String> {
        self.store.set_epoch_deadline(ticks(self.timeout));
        let length = match self.answer.call(&mut self.store, self.pending) {
            Ok(0) => return Err(self.ended("no answer")),
            Ok(length) => length as usize,
            Err(error) => {
                return Err(match error.downcast_ref::<Trap>() {
                    Some(Trap::Interrupt) => late(self.timeout),
                    Some(trap) => self.ended(&trap.to_string()),
                    None => self.ended(&error.to_string()),
                });
            }
        };
        let memory = self.memory.data(&self.store);
        let bytes = memory
            .get(self.buffer..self.buffer + length)
            .ok_or("its answer is longer than its memory")?;
        answer.clear();
        answer.extend(bytes);
        Ok(())
    }

    fn set_timeout(&mut self, timeout: Duration) {
        self.timeout = timeout;
    }
}

/// Number of ticks after which a node is late; at least one whole tick.
fn ticks(timeout: Duration) -> u64 {
    timeout.div_duration_f64(TICK).ceil() as u64 + 1
}

/// Returns the engine of this process, which all nodes share.
fn engine() -> Result<&'static Engine, String> {
    static ENGINE: OnceLock<Result<Engine, String>> = OnceLock::new();
    let start = || {
        let mut config = Config::new();
        config.epoch_interruption(true);
        let engine = Engine::new(&config).map_err(|error| error.to_string())?;
        let ticking = engine.clone();
        thread::spawn(move || {
            loop {
                thread::sleep(TICK);
                ticking.increment_epoch();
            }
        });
        Ok(engine)
    };
    ENGINE.get_or_init(start).as_ref().map_err(Clone::clone)
}

/// Returns the machine code of the program at `path`. It is compiled once, and again when the file
/// has changed.
fn module(engine: &Engine, path: &Path) -> wasmtime::Result<Module> {
    type Modules = HashMap<PathBuf, (SystemTime, Module)>;
    static MODULES: OnceLock<Mutex<Modules>> = OnceLock::new();
    let changed = std::fs::metadata(path)?.modified()?;
    let modules = MODULES.get_or_init(Mutex::default);
    let mut modules = modules.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((compiled, module)) = modules.get(path)
        && *compiled == changed
    {
        return Ok(module.clone());
    }
    let module = Module::from_file(engine, path)?;
    modules.insert(path.to_owned(), (changed, module.clone()));
    Ok(module)
}
