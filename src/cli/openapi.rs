//! `revprio openapi` and `revprio asyncapi`

use std::io::{Write as _, stdout};

use super::CliError;

/// Prints a document.
pub fn run(document: &str) -> Result<(), CliError> {
    Ok(stdout().write_all(document.as_bytes())?)
}
