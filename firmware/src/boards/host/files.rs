//! Files of the host, as the simulated flash uses them. A page on the web has no files: there they
//! are in memory.

use crate::boards::lockstep::Files;

/// The files.
pub(super) const FILES: Files = Files {
    read: imp::read,
    write: imp::write,
};

#[cfg(not(target_family = "wasm"))]
mod imp {
    use std::fs::{File, OpenOptions};
    use std::io::{ErrorKind, Read, Write};

    pub fn read(path: &str, bytes: &mut [u8]) -> Option<bool> {
        match File::open(path) {
            Ok(mut file) => Some(fill(&mut file, bytes)),
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(_) => Some(false),
        }
    }

    pub fn write(path: &str, bytes: &[u8]) -> bool {
        overwrite(path, bytes).is_ok()
    }

    /// Fills `bytes`; returns whether the file has their length.
    fn fill(file: &mut File, bytes: &mut [u8]) -> bool {
        file.read_exact(bytes).is_ok() && matches!(file.read(&mut [0]), Ok(0))
    }

    /// Writes the file with a single write in place: so it stays whole if the process is killed.
    fn overwrite(path: &str, bytes: &[u8]) -> std::io::Result<()> {
        let mut options = OpenOptions::new();
        let mut file = options
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)?;
        file.write_all(bytes)
    }
}

#[cfg(target_family = "wasm")]
mod imp {
    use std::borrow::ToOwned;
    use std::cell::RefCell;
    use std::collections::BTreeMap;
    use std::string::String;
    use std::thread_local;
    use std::vec::Vec;

    thread_local! {
        static FILES: RefCell<BTreeMap<String, Vec<u8>>> = const { RefCell::new(BTreeMap::new()) };
    }

    pub fn read(path: &str, bytes: &mut [u8]) -> Option<bool> {
        FILES.with_borrow(|files| {
            let file = files.get(path)?;
            let fits = file.len() == bytes.len();
            if fits {
                bytes.copy_from_slice(file);
            }
            Some(fits)
        })
    }

    pub fn write(path: &str, bytes: &[u8]) -> bool {
        FILES.with_borrow_mut(|files| files.insert(path.to_owned(), bytes.to_owned()));
        true
    }
}
