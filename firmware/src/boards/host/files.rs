//! Files of the host, as the simulated flash uses them.

use crate::boards::lockstep::Files;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Write};

/// The files.
pub(super) const FILES: Files = Files {
    read: |path, bytes| match File::open(path) {
        Ok(mut file) => Some(fill(&mut file, bytes)),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(_) => Some(false),
    },
    write: |path, bytes| overwrite(path, bytes).is_ok(),
};

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
