//! Recordings as files beside figures and page.

use std::path::Path;

use clap::ValueEnum;
use clap::builder::PossibleValue;

use super::CliError;
use crate::simulator::recording::{Format, Recording};

#[derive(Debug, clap::Args)]
// Not a group of its own: flattened into options of the same name.
#[group(skip)]
pub struct Options {
    /// Formats of the traces, such as `csv,mcap`
    #[arg(long, value_enum, value_delimiter = ',', default_value = "csv")]
    traces: Vec<Format>,
    /// Also record how long each call took, which differs from run to run
    #[arg(long)]
    timings: bool,
}

impl ValueEnum for Format {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.ending()))
    }
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
