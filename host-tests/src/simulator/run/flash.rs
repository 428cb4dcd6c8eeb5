//! Folder with the flash of a run's nodes: so a node that restarts finds its settings.

use super::Options;
use crate::robots::NodeName;
use std::sync::atomic::{AtomicU32, Ordering};
use tautrack::link::MAX_PATH;

/// Number of temporary folders that were made.
static RUNS: AtomicU32 = AtomicU32::new(0);

/// The folder. One that the run has made is removed when this is dropped.
pub(super) struct Flash {
    folder: String,
    temporary: bool,
}

impl Flash {
    /// The folder of the options, or else a temporary one.
    pub fn of(options: &Options) -> Self {
        if let Some(folder) = options.flash.clone() {
            return Self {
                folder,
                temporary: false,
            };
        }
        Self {
            folder: temporary(),
            temporary: true,
        }
    }

    /// Path of the file with the flash of this node.
    pub fn file(&self, node: NodeName) -> heapless::String<MAX_PATH> {
        let path = format!("{}/{node}.flash", self.folder);
        path.as_str().try_into().unwrap_or_default()
    }
}

impl Drop for Flash {
    fn drop(&mut self) {
        if self.temporary {
            let _ = std::fs::remove_dir_all(&self.folder);
        }
    }
}

/// Makes a temporary folder.
#[cfg(unix)]
fn temporary() -> String {
    use std::io::ErrorKind;
    use std::{env, fs, process};

    // A process that was killed leaves its folders, and another one may get its number.
    let folder = loop {
        let run = RUNS.fetch_add(1, Ordering::Relaxed);
        let name = format!("tautrack-{}-{run}", process::id());
        let folder = env::temp_dir().join(name);
        match fs::create_dir(&folder) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            // After another error the nodes say that they cannot write their flash.
            _ => break folder,
        }
    };
    folder.to_string_lossy().into_owned()
}

/// Returns a new name for the nodes' files, which are in memory.
#[cfg(not(unix))]
fn temporary() -> String {
    RUNS.fetch_add(1, Ordering::Relaxed).to_string()
}
