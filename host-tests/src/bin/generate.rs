//! `cargo generate`: writes the EDS files, the URDF files and the generated tables in docs/ again.

use std::process::ExitCode;
use tautrack_host_tests::tools::generate;

fn main() -> ExitCode {
    let files = match generate::files() {
        Ok(files) => files,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::FAILURE;
        }
    };
    for (path, text) in files {
        if let Err(error) = std::fs::write(&path, text) {
            eprintln!("error: cannot write {}: {error}", path.display());
            return ExitCode::FAILURE;
        }
        println!("{}", path.display());
    }
    ExitCode::SUCCESS
}
