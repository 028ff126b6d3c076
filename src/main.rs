//! The `revprio` program. All code is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    revprio::cli::main(std::env::args_os()).into()
}
