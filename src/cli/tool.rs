//! `revprio bench` and `revprio load`: start the separate program `revprio-bench`.
//!
//! The benchmarks are a separate program, so that users of revprio do not have to compile them.

use std::env;
use std::ffi::OsString;
use std::io;
use std::process::{Command, ExitStatus};

/// The arguments that the benchmark program receives as they are.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Arguments of `revprio-bench`
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

/// Why the benchmark program cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum ToolError {
    /// Neither the program nor its sources were found.
    #[error(
        "the program `revprio-bench` was not found; in a clone of the repository, run \
         `cargo run --release -p revprio-bench -- {command}`"
    )]
    Missing {
        /// `bench` or `load`.
        command: &'static str,
    },
    /// The program cannot be started.
    #[error("cannot start `{program}`: {source}")]
    Start {
        /// The program.
        program: String,
        /// The reason.
        source: io::Error,
    },
    /// The program failed; it has printed the reason.
    #[error("the benchmark ended with {0}")]
    Failed(ExitStatus),
}

/// Runs `revprio-bench` from the directory of this program, or builds it first in a clone of the repository.
pub fn run(command: &'static str, Arguments { arguments }: &Arguments) -> Result<(), ToolError> {
    let mut tool = installed().or_else(in_clone).ok_or(ToolError::Missing { command })?;
    tool.arg(command).args(arguments);
    let status = tool.status().map_err(|source| {
        let program = tool.get_program().to_string_lossy().into_owned();
        ToolError::Start { program, source }
    })?;
    if status.success() { Ok(()) } else { Err(ToolError::Failed(status)) }
}

/// `revprio-bench` next to this program.
fn installed() -> Option<Command> {
    let program = env::current_exe().ok()?.with_file_name(format!("revprio-bench{}", env::consts::EXE_SUFFIX));
    program.exists().then(|| Command::new(program))
}

/// `cargo run` in the clone whose `target` directory holds this program.
fn in_clone() -> Option<Command> {
    let program = env::current_exe().ok()?;
    let mut manifests = program.ancestors().map(|root| root.join("tools/bench/Cargo.toml"));
    let manifest = manifests.find(|path| path.exists())?;
    let mut cargo = Command::new("cargo");
    cargo.args(["run", "--quiet", "--release", "--manifest-path"]).arg(manifest).arg("--");
    Some(cargo)
}
