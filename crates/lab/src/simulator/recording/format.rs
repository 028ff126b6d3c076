//! The formats in which recordings are kept.

use std::fmt;
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::ops::Range;
use std::path::Path;

use super::error::{ReadError, WriteError};
use super::{Recording, csv_table, head, json_lines, mcap_log, parquet_table};

/// A format of recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// A table, units in the names of the columns; the description of the run in a file beside it.
    Csv,
    /// One object per line and period; the description of the run in a file beside it.
    JsonLines,
    /// The table of the CSV file in columns, the description of the run inside.
    Parquet,
    /// Messages for Foxglove, Rerun and PlotJuggler, the description of the run inside.
    Mcap,
}

impl fmt::Display for Format {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.pad(self.ending())
    }
}

/// Writes a recording piece by piece.
pub trait Writer: Send {
    /// Writes some periods of the recording, those after the last ones.
    fn write(&mut self, recording: &Recording, rows: Range<usize>) -> Result<(), WriteError>;

    /// Writes what comes after the last period.
    fn finish(self: Box<Self>) -> Result<(), WriteError>;
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Csv, Self::JsonLines, Self::Parquet, Self::Mcap];

    /// Ending of the file name.
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::JsonLines => "jsonl",
            Self::Parquet => "parquet",
            Self::Mcap => "mcap",
        }
    }

    /// The format of a file, by its name.
    pub fn of(path: &Path) -> Result<Self, ReadError> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let known = || Self::ALL.map(|format| format!(".{}", format.ending())).join(", ");
        Self::ALL.into_iter().find(|f| f.ending() == ending).ok_or_else(|| ReadError::Format { known: known() })
    }

    /// Periods that are best written at once; those of a Parquet file must be.
    pub const fn piece(self) -> usize {
        match self {
            Self::Csv | Self::JsonLines | Self::Mcap => 500,
            Self::Parquet => 5000,
        }
    }

    /// Whether the description of the run stands in a file of its own.
    const fn has_sidecar(self) -> bool {
        matches!(self, Self::Csv | Self::JsonLines)
    }

    /// Begins a file; `timed` adds the clock on the wall, which differs from run to run.
    pub fn writer<W: Write + Send + 'static>(
        self,
        recording: &Recording,
        timed: bool,
        out: W,
    ) -> Result<Box<dyn Writer>, WriteError> {
        Ok(match self {
            Self::Csv => Box::new(csv_table::Table::begin(recording, timed, out)?),
            Self::JsonLines => Box::new(json_lines::Lines::new(timed, out)),
            Self::Parquet => Box::new(parquet_table::Table::begin(recording, timed, out)?),
            Self::Mcap => Box::new(mcap_log::Log::begin(recording, timed, out)?),
        })
    }

    /// Writes all of a recording.
    pub fn write_all<W: Write + Send + 'static>(
        self,
        recording: &Recording,
        timed: bool,
        out: W,
    ) -> Result<(), WriteError> {
        let mut writer = self.writer(recording, timed, out)?;
        let rows = recording.samples.len();
        for start in (0..rows).step_by(self.piece()) {
            writer.write(recording, start..rows.min(start + self.piece()))?;
        }
        writer.finish()
    }

    /// Writes a recording to a file, and the description of the run beside it where the format has no place for it.
    pub fn write_file(self, recording: &Recording, timed: bool, path: &Path) -> Result<(), WriteError> {
        if self.has_sidecar() {
            std::fs::write(sidecar(path), head::to_json(recording, timed)?)?;
        }
        self.write_all(recording, timed, BufWriter::new(File::create(path)?))
    }
}

/// The file beside a table.
fn sidecar(path: &Path) -> std::path::PathBuf {
    path.with_extension("recording.json")
}

/// Reads a recording from a file of any format.
pub fn read(path: &Path) -> Result<Recording, ReadError> {
    let format = Format::of(path)?;
    if !format.has_sidecar() {
        return match format {
            Format::Parquet => parquet_table::read(File::open(path)?),
            _ => mcap_log::read(&std::fs::read(path)?),
        };
    }
    let file = BufReader::new(File::open(path)?);
    let beside = sidecar(path);
    let text = std::fs::read_to_string(&beside).map_err(|source| ReadError::Sidecar { path: beside, source })?;
    let head = head::from_json(&text)?;
    match format {
        Format::Csv => csv_table::read(head, file),
        _ => json_lines::read(head, file),
    }
}
