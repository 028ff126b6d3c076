//! `revprio config` and `revprio completions`

use std::io::{Write as _, stdout};

use clap::CommandFactory;

use super::settings::{EffectiveSettings, Options};
use super::{Cli, CliError};

/// Prints the effective settings.
pub fn run(options: &Options) -> Result<(), CliError> {
    let settings = EffectiveSettings::of(options, |name| std::env::var(name).ok())?;
    Ok(write!(stdout(), "{settings}")?)
}

/// Prints a script with which a shell completes commands and options.
pub fn completions(shell: clap_complete::Shell) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "revprio", &mut script);
    Ok(stdout().write_all(&script)?)
}
