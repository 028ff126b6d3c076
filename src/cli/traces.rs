//! Options for recordings as files.

use std::path::Path;

use revprio_lab::simulator::recording::{Format, Recording};

use super::error::CliError;
use super::one_of::one_of;

#[derive(Debug, Clone, clap::Args)]
// Without a group, because it is flattened into options of the same name.
#[group(skip)]
pub struct Options {
    /// Formats of the recordings, for example `csv,mcap`
    #[arg(long, value_parser = one_of(&Format::ALL), value_delimiter = ',', default_value = "csv")]
    traces: Vec<Format>,
    /// Also record the real time of each call, which differs from run to run
    #[arg(long)]
    timings: bool,
}

impl Options {
    /// Returns the first of these options that a command was given, and not in vain.
    pub fn given(&self) -> Option<&'static str> {
        if self.traces == [Format::Csv] { self.timings.then_some("--timings") } else { Some("--traces") }
    }

    /// Returns the options of a command that repeats this one, after a space; empty for the defaults.
    pub fn repeated(&self) -> String {
        let formats: Vec<_> = self.traces.iter().map(ToString::to_string).collect();
        let traces =
            if self.traces == [Format::Csv] { String::new() } else { format!(" --traces {}", formats.join(",")) };
        if self.timings { traces + " --timings" } else { traces }
    }

    /// Writes a recording to the directory, in every format.
    pub fn write(&self, out: &Path, recording: &Recording) -> Result<(), CliError> {
        for &format in &self.traces {
            let path = out.join(recording.trace_name(format));
            let written = format.write_file(recording, self.timings, &path);
            written.map_err(|source| CliError::Trace { path, source })?;
        }
        Ok(())
    }

    /// Returns the names of these files.
    pub fn names(&self, recording: &Recording) -> impl Iterator<Item = String> {
        self.traces.iter().map(|&format| recording.trace_name(format))
    }
}
