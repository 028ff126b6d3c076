//! `revprio config`

use super::error::CliError;
use super::output::print_text;
use super::settings::{EffectiveSettings, Options};

/// Prints the effective settings.
pub fn run(options: &Options) -> Result<(), CliError> {
    let settings = EffectiveSettings::of(options, |name| std::env::var(name).ok())?;
    Ok(print_text(settings)?)
}
