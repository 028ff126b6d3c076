//! The `revprio` program. All code is in the library.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    match revprio::cli::Cli::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
