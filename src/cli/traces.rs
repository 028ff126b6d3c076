//! Recordings as files beside figures and page.

use std::path::Path;

use revprio_lab::simulator::recording::{Format, Recording};

use super::CliError;
use super::one_of::one_of;

#[derive(Debug, clap::Args)]
// Not a group of its own: flattened into options of the same name.
#[group(skip)]
pub struct Options {
    /// Formats of the traces, such as `csv,mcap`
    #[arg(long, value_parser = one_of(&Format::ALL), value_delimiter = ',', default_value = "csv")]
    traces: Vec<Format>,
    /// Also record how long each call took, which differs from run to run
    #[arg(long)]
    timings: bool,
}

impl Options {
    /// Writes a recording in every format into the directory.
    pub fn write(&self, out: &Path, recording: &Recording) -> Result<(), CliError> {
        for &format in &self.traces {
            let path = out.join(recording.trace_name(format));
            let written = format.write_file(recording, self.timings, &path);
            written.map_err(|source| CliError::Trace { path, source })?;
        }
        Ok(())
    }

    /// Names of these files.
    pub fn names(&self, recording: &Recording) -> impl Iterator<Item = String> {
        self.traces.iter().map(|&format| recording.trace_name(format))
    }
}
