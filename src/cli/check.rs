//! `revprio check`: runs `tools/check/check.py`, which shares no code with this program.

use std::fs::File;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};

use uuid::Uuid;

use super::output::print_text;

/// The program that checks certificates.
const SCRIPT: &str = include_str!("../../tools/check/check.py");

/// The Python interpreter.
const PYTHON: &str = if cfg!(windows) { "python" } else { "python3" };

#[derive(Debug, clap::Args)]
#[command(
    override_usage = "revprio check REQUEST ANSWER\n       revprio check LINES\n       revprio check --script",
    after_help = NEEDS
)]
pub struct Options {
    /// Request of POST /v1/resolve in JSON, with `"certificate": true`; without ANSWER: a file LINES, which has an object
    /// {"request": …, "answer": …} on each line
    #[arg(required_unless_present = "script", value_name = "REQUEST or LINES")]
    request: Option<PathBuf>,
    /// Answer to the request, in JSON
    answer: Option<PathBuf>,
    /// Print the Python program that checks, to run it without revprio
    #[arg(long, conflicts_with_all = ["request", "answer"])]
    script: bool,
}

const NEEDS: &str = "Python 3.11 or newer must be installed; the command runs it.

Exit status:
  0  the certificates of all answers hold
  1  one does not hold, or Python was not found
  2  an input cannot be read";

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
    /// The program cannot be written for Python.
    #[error("cannot write to the directory for temporary files: {0}")]
    Write(std::io::Error),
    /// The certificate does not hold or cannot be read; the program has printed why.
    #[error("the certificate does not hold or cannot be read")]
    Ended(ExitStatus),
    /// The program cannot be printed.
    #[error("cannot print: {0}")]
    Print(std::io::Error),
}

pub fn run(options: &Options) -> Result<(), CheckError> {
    if options.script {
        return print_text(SCRIPT).map_err(CheckError::Print);
    }
    // A file, because its processes read the program again where Python does not fork.
    let path = std::env::temp_dir().join(format!("revprio-check-{}.py", Uuid::new_v4()));
    let written = File::create_new(&path).and_then(|mut file| file.write_all(SCRIPT.as_bytes()));
    let status = written.map_err(CheckError::Write).and_then(|()| check(&path, options));
    // What is left in the directory for temporary files does no harm.
    std::fs::remove_file(&path).ok();
    let status = status?;
    if status.success() { Ok(()) } else { Err(CheckError::Ended(status)) }
}

fn check(script: &Path, options: &Options) -> Result<ExitStatus, CheckError> {
    let inputs = options.request.iter().chain(&options.answer);
    Command::new(PYTHON).arg("-I").arg(script).args(inputs).status().map_err(|error| match error.kind() {
        ErrorKind::NotFound => CheckError::NoPython,
        _ => CheckError::Run(error),
    })
}
