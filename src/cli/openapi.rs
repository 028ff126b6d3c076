//! `revprio openapi` and `revprio asyncapi`

use super::error::CliError;
use super::output::print_text;

/// Prints a document.
pub fn run(document: &str) -> Result<(), CliError> {
    Ok(print_text(document)?)
}
