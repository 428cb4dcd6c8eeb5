//! Makes virtual environments of Python with packages from `PyPI`, below `target/`.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

/// Tests of one program run in parallel; the lock lets only one of them make the environment.
static MAKING: Mutex<()> = Mutex::new(());

/// Returns the interpreter of an environment with these packages (`name==version`), and makes the
/// environment if it is missing.
///
/// If the computer has no `python3`, or the packages cannot be installed, it prints a line that
/// begins with `SKIPPED` and returns `None`.
pub fn python(environment: &str, packages: &[&str]) -> Option<PathBuf> {
    let _making = MAKING.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(environment);
    let interpreter = folder.join("bin/python");
    let ready = folder.join("ready");
    let wanted = packages.join("\n");
    if std::fs::read_to_string(&ready).is_ok_and(|found| found == wanted) {
        return Some(interpreter);
    }
    let done = |command: &mut Command| {
        let output = command.output().map_err(|error| error.to_string())?;
        if output.status.success() {
            Ok(())
        } else {
            Err(String::from_utf8_lossy(&output.stderr).into_owned())
        }
    };
    let made = done(Command::new("python3").args(["-m", "venv"]).arg(&folder)).and_then(|()| {
        done(
            Command::new(&interpreter)
                .args(["-m", "pip", "install", "--quiet"])
                .args(packages),
        )
    });
    match made {
        Ok(()) => {
            std::fs::write(&ready, wanted).expect("the environment's folder can be written");
            Some(interpreter)
        }
        Err(error) => {
            println!("SKIPPED: no python3 with {packages:?}: {error}");
            None
        }
    }
}
