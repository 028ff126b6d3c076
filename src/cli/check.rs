//! `revprio check`: runs `tools/check/check.py`, which shares no code with this program.

use std::io::{ErrorKind, Write as _, stdout};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use super::{CliError, FAILURE};

/// The program that checks certificates.
const SCRIPT: &str = include_str!("../../tools/check/check.py");

/// The Python interpreter.
const PYTHON: &str = if cfg!(windows) { "python" } else { "python3" };

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Request and answer of POST /v1/resolve in JSON. A single file has an object with `request` and `answer` on each
    /// line. The request has `"certificate": true`
    #[arg(required_unless_present = "script", value_names = ["REQUEST", "ANSWER"], num_args = 1..=2)]
    files: Vec<PathBuf>,
    /// Print the Python program that checks, to run it without revprio
    #[arg(long)]
    script: bool,
}

/// Why an answer is not checked.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// Python is not installed.
    #[error(
        "`{PYTHON}` was not found. Install Python 3.11 or newer, or check on another machine: `revprio check --script > \
         check.py`, then `python3 check.py REQUEST ANSWER`"
    )]
    NoPython,
    /// Python cannot be run.
    #[error("cannot run `{PYTHON}`: {0}")]
    Run(std::io::Error),
    /// The certificate does not hold or cannot be read; the program has printed why.
    #[error("the certificate does not hold or cannot be read")]
    Ended(u8),
}

pub fn run(options: &Options) -> Result<(), CliError> {
    if options.script {
        write!(stdout(), "{SCRIPT}")?;
        return Ok(());
    }
    check(options).map_err(CliError::from)
}

fn check(options: &Options) -> Result<(), CheckError> {
    // `-` reads the program from standard input: as an argument, it would be too long for Windows.
    let started = Command::new(PYTHON).args(["-I", "-"]).args(&options.files).stdin(Stdio::piped()).spawn();
    let mut python = started.map_err(|error| match error.kind() {
        ErrorKind::NotFound => CheckError::NoPython,
        _ => CheckError::Run(error),
    })?;
    if let Some(mut input) = python.stdin.take() {
        input.write_all(SCRIPT.as_bytes()).map_err(CheckError::Run)?;
    }
    let status = python.wait().map_err(CheckError::Run)?;
    if status.success() {
        return Ok(());
    }
    Err(CheckError::Ended(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(FAILURE)))
}
