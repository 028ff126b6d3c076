//! `revprio report`

use std::path::PathBuf;

use revprio_lab::report::experiment::store;
use revprio_lab::report::{self, Output, Report};

use super::compare::{Format, print};
use super::error::CliError;
use super::output::print_remark;

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Output directory of `simulate`, `demo` or `compare`; page and figures are written there
    directory: PathBuf,
    /// Format of the printed result
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

pub fn run(options: &Options) -> Result<(), CliError> {
    let (experiment, traces) = store::read(&options.directory)?;
    let report = Report { traces, ..experiment.report() };
    report::write(&options.directory, &report, &[Output::Page, Output::Svg, Output::Png])?;
    print(options.format, &report)?;
    print_remark(format_args!("\nwritten: {}", options.directory.join("index.html").display()));
    Ok(())
}
