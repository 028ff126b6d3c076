//! `revprio report`

use std::io::{Write as _, stdout};
use std::path::PathBuf;

use super::CliError;
use crate::report::experiment::store;
use crate::report::{self, Output};

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Directory that `simulate`, `demo` or `compare` left; page and figures are written there
    directory: PathBuf,
}

pub fn run(options: &Options) -> Result<(), CliError> {
    let experiment = store::read(&options.directory)?;
    report::write(&options.directory, &experiment.report(), &[Output::Page, Output::Svg, Output::Png])?;
    writeln!(stdout(), "{}", options.directory.join("index.html").display())?;
    Ok(())
}
