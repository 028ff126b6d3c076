//! `revprio config` and `revprio completions`

use clap::CommandFactory;

use super::output::print_text;
use super::settings::{EffectiveSettings, Options};
use super::{Cli, CliError};

/// Prints the effective settings.
pub fn run(options: &Options) -> Result<(), CliError> {
    let settings = EffectiveSettings::of(options, |name| std::env::var(name).ok())?;
    Ok(print_text(settings)?)
}

/// Prints a script with which a shell completes commands and options.
pub fn completions(shell: clap_complete::Shell) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "revprio", &mut script);
    Ok(print_text(String::from_utf8_lossy(&script))?)
}
