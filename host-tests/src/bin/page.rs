//! Module of the page on the web, for the target `wasm32-unknown-unknown`: the simulator with the
//! nodes ([`tautrack_host_tests::live`]). It imports nothing.
//!
//! The page asks for a buffer of a length, writes a request into it, calls [`answer`] and reads the
//! answer, whose length it returns, from the same buffer. If the module panics, [`answer`] does not
//! return, and [`panicked`] says where the text is.
#![cfg_attr(target_family = "wasm", no_main)]

#[cfg(not(target_family = "wasm"))]
fn main() {}

#[cfg(target_family = "wasm")]
mod module {
    use std::cell::RefCell;
    use std::panic;
    use tautrack_host_tests::live::Session;

    #[derive(Default)]
    struct Module {
        session: Session,
        bytes: Vec<u8>,
    }

    thread_local! {
        static MODULE: RefCell<Module> = RefCell::default();
        static PANIC: RefCell<String> = const { RefCell::new(String::new()) };
    }

    /// Returns a buffer of `length` bytes.
    #[unsafe(no_mangle)]
    pub extern "C" fn buffer(length: usize) -> *mut u8 {
        MODULE.with_borrow_mut(|module| {
            module.bytes.resize(length.max(1), 0);
            module.bytes.as_mut_ptr()
        })
    }

    /// Answers the request in the buffer. Returns the length of the answer, which is where
    /// [`contents`] says.
    #[unsafe(no_mangle)]
    pub extern "C" fn answer() -> usize {
        panic::set_hook(Box::new(|info| {
            PANIC.with_borrow_mut(|text| *text = info.to_string());
        }));
        MODULE.with_borrow_mut(|module| {
            module.bytes = module.session.answer(&module.bytes);
            module.bytes.len()
        })
    }

    /// Returns where the answer is.
    #[unsafe(no_mangle)]
    pub extern "C" fn contents() -> *const u8 {
        MODULE.with_borrow(|module| module.bytes.as_ptr())
    }

    /// Returns where the text of a panic is.
    #[unsafe(no_mangle)]
    pub extern "C" fn panicked() -> *const u8 {
        PANIC.with_borrow(|text| text.as_ptr())
    }

    /// Returns the length of the text of a panic.
    #[unsafe(no_mangle)]
    pub extern "C" fn panicked_length() -> usize {
        PANIC.with_borrow(String::len)
    }
}
