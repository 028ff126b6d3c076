//! `revprio config` and `revprio completions`

use std::io::{Write as _, stdout};

use clap::CommandFactory;

use super::settings::{InForce, Options};
use super::{Cli, CliError};

/// Prints the settings in force.
pub fn run(options: &Options) -> Result<(), CliError> {
    let in_force = InForce::of(options, |name| std::env::var(name).ok())?;
    Ok(write!(stdout(), "{in_force}")?)
}

/// Prints what a shell needs to complete commands and flags.
pub fn completions(shell: clap_complete::Shell) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "revprio", &mut script);
    Ok(stdout().write_all(&script)?)
}
