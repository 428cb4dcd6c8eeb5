//! The command line of `cargo evaluate`.

use super::{EvaluateError, Precision, evaluate};
use clap::Parser;
use std::ffi::OsString;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Exit status for bad arguments and bad documents.
const USAGE: u8 = 2;

/// Evaluates model functions with inputs from a JSON file in the format of host-tests/vectors.
#[derive(Parser)]
#[command(name = "cargo evaluate", version)]
struct Arguments {
    /// JSON document; - reads standard input
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Number format of the computation; the nodes use f32. The screw always uses fixed point
    #[arg(long, value_enum, default_value_t = Precision::F32)]
    scalar: Precision,
}

/// Runs the command. Its exit status is 0, or 1 if the result cannot be written, or 2 for bad
/// arguments and bad documents.
pub fn main(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    let name = std::iter::once(OsString::from("cargo evaluate"));
    let arguments =
        Arguments::try_parse_from(name.chain(arguments)).unwrap_or_else(|error| error.exit());
    let result = read(&arguments.file).and_then(|text| evaluate(&text, arguments.scalar));
    let document = match result {
        Ok(document) => document,
        Err(error) => {
            eprintln!("error: {}: {error}", arguments.file.display());
            return ExitCode::from(USAGE);
        }
    };
    match writeln!(io::stdout().lock(), "{document:#}") {
        Ok(()) => ExitCode::SUCCESS,
        // The reader of the pipe has closed it, as `head` does.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: cannot write the result: {error}");
            ExitCode::FAILURE
        }
    }
}

fn read(file: &Path) -> Result<String, EvaluateError> {
    let text = if file == Path::new("-") {
        let mut text = String::new();
        io::stdin().read_to_string(&mut text).map(|_| text)
    } else {
        std::fs::read_to_string(file)
    };
    text.map_err(|error| EvaluateError::Unreadable(error.to_string()))
}
