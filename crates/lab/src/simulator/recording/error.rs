//! Errors of reading and writing recordings.

use std::error::Error;
use std::io;
use std::path::PathBuf;

use mcap::McapError;

/// Why a recording cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file cannot be written.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The CSV table cannot be written.
    #[error("{0}")]
    Csv(#[from] csv::Error),
    /// A sample or the description of the run cannot be written as JSON.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    /// The Parquet file cannot be written.
    #[error("{0}")]
    Parquet(#[from] parquet::errors::ParquetError),
    /// The MCAP file cannot be written.
    #[error("{}", with_cause(.0))]
    Mcap(#[from] McapError),
    /// A message of the MCAP file cannot be encoded.
    #[error("a message cannot be encoded")]
    Message,
}

/// Returns the text of an error with its cause, such as a full disk: the error itself does not name it.
fn with_cause(error: &McapError) -> String {
    error.source().map_or_else(|| error.to_string(), |cause| format!("{error}: {cause}"))
}

impl From<WriteError> for io::Error {
    fn from(error: WriteError) -> Self {
        match error {
            WriteError::Io(error) => error,
            other => Self::other(other),
        }
    }
}

/// Why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The file name extension is unknown.
    #[error("the extension of a recording must be one of {known}")]
    Format {
        /// The known extensions.
        known: String,
    },
    /// The description of the run next to a table cannot be read.
    #[error(
        "cannot read the description of the run, {}: {source}; keep this file next to the table, or record as Parquet or \
         MCAP, which contain it", path.display()
    )]
    Sidecar {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A Parquet or MCAP file without the description of a run.
    #[error("the file has no description of the run; only files written by revprio can be read")]
    NoDescription,
    /// The description of the run is not valid.
    #[error("the description of the run is not valid: {0}")]
    Description(serde_json::Error),
    /// The table has another number of periods than the description of the run.
    #[error(
        "it has {found} periods, but the description of the run next to it states {stated}; a part of the file is lost, or it is that of \
         another run"
    )]
    Periods {
        /// Number in the description.
        stated: usize,
        /// Number in the table.
        found: usize,
    },
    /// A line is not valid.
    #[error("line {line}: {source}")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// The error.
        source: serde_json::Error,
    },
    /// The CSV table is not valid.
    #[error("{0}")]
    Csv(#[from] csv::Error),
    /// The Parquet file is not valid.
    #[error("{0}")]
    Parquet(#[from] parquet::errors::ParquetError),
    /// The MCAP file is not valid.
    #[error("{}", with_cause(.0))]
    Mcap(#[from] McapError),
    /// A column is missing.
    #[error("there is no column `{column}`")]
    Column {
        /// Name of the column.
        column: String,
    },
    /// A value has the wrong kind.
    #[error("row {row}: column `{column}` has `{text}`, not {expected}")]
    Value {
        /// Row, from 1.
        row: usize,
        /// Name of the column.
        column: String,
        /// What the column has.
        expected: &'static str,
        /// What the file has.
        text: String,
    },
}
